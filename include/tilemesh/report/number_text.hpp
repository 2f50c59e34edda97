#pragma once
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/table.hpp>

// Numbers for pages and tables: plain ASCII, independent of the locale, the same on every run.
namespace tilemesh { inline namespace v0_2 { namespace report {

using tilemesh::decimals;
using tilemesh::significant;
/// An integer from 0 to below 2^64 without decimals; any other number with one decimal.
TILEMESH_HOST std::string plain_number(double value);
/// A plain number if it is below 1,000; otherwise rounded, with a comma before each three digits.
TILEMESH_HOST std::string short_number(double value);
/// A part of a whole in percent: "12.5 %". If the whole is 0: "0.0 %".
TILEMESH_HOST std::string share_text(double part, double whole);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/number_text_code.hpp>
#endif
