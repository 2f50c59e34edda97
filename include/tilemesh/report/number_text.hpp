#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/table.hpp>

// Numbers for pages and tables: plain ASCII, independent of the locale, the same on every run.
namespace tilemesh { inline namespace v0_2 { namespace report {

/// A number from 0 to below 2^64 with `digits` digits after the point, at most 40.
inline std::string decimals(double value, int digits)
{
    std::array<char, 64> text{}; // 20 digits before the point
    auto const end = write_fixed(text.data(), text.data() + text.size(), value, digits);
    return {text.data(), end.ptr};
}
/// An integer from 0 to below 2^64 without decimals; any other number with one decimal.
inline std::string plain_number(double value)
{
    return decimals(value, value == static_cast<double>(static_cast<std::uint64_t>(value)) ? 0 : 1);
}
/// A plain number if it is below 1,000; otherwise rounded, with a comma before each three digits.
inline std::string short_number(double value)
{
    return value < 1000 ? plain_number(value) : thousands(static_cast<std::uint64_t>(value + 0.5));
}
/// A part of a whole in percent: "12.5 %". If the whole is 0: "0.0 %".
inline std::string share_text(double part, double whole)
{
    return decimals(whole == 0 ? 0 : 100 * part / whole, 1) + " %";
}
/// Joules with six significant digits.
inline std::string joules_text(double joules)
{
    std::array<char, 32> text{};
    auto const end = write_general(text.data(), text.data() + text.size(), joules, 6);
    return {text.data(), end.ptr};
}

}}} // namespace tilemesh::report
