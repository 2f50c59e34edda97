#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/table.hpp>

// Numbers for pages and tables: plain ASCII, independent of the locale, the same on every run.
namespace tilemesh { inline namespace v0_2 { namespace report {

using tilemesh::decimals;
using tilemesh::significant;
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

}}} // namespace tilemesh::report
