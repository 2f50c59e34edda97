#pragma once
#include <array>
#include <charconv>
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/report/table.hpp>

// Numbers as pages and tables show them: plain ASCII, without a locale, the same on every run.
namespace tilemesh { inline namespace v0_2 { namespace report {

/// A number from 0 to below 2^64 with so many digits after the point, at most 40.
inline std::string decimals(double value, int digits)
{
    std::array<char, 64> text{}; // 20 digits before the point
    auto const end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, digits);
    return {text.data(), end.ptr};
}
/// A whole number from 0 to below 2^64 as such, any other with one decimal.
inline std::string plain_number(double value)
{
    return decimals(value, value == static_cast<double>(static_cast<std::uint64_t>(value)) ? 0 : 1);
}
/// A plain number below 1,000; from there on rounded, with a comma before each three digits.
inline std::string short_number(double value)
{
    return value < 1000 ? plain_number(value) : thousands(static_cast<std::uint64_t>(value + 0.5));
}
/// A part of a whole in percent: "12.5 %"; "0.0 %" of nothing.
inline std::string share_text(double part, double whole)
{
    return decimals(whole == 0 ? 0 : 100 * part / whole, 1) + " %";
}
/// Joules with six digits, which are enough to compare.
inline std::string joules_text(double joules)
{
    std::array<char, 32> text{};
    auto const end = std::to_chars(text.data(), text.data() + text.size(), joules, std::chars_format::general, 6);
    return {text.data(), end.ptr};
}

}}} // namespace tilemesh::report
