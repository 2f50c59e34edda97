#pragma once
#include <cstdint>
#include <tilemesh/report/number_text.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST std::string plain_number(double value)
{
    return decimals(value, value == static_cast<double>(static_cast<std::uint64_t>(value)) ? 0 : 1);
}

TILEMESH_HOST std::string short_number(double value)
{
    return value < 1000 ? plain_number(value) : thousands(static_cast<std::uint64_t>(value + 0.5));
}

TILEMESH_HOST std::string share_text(double part, double whole)
{
    return decimals(whole == 0 ? 0 : 100 * part / whole, 1) + " %";
}

}}} // namespace tilemesh::report
