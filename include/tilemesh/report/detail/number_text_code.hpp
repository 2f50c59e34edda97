#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST std::string decimals(double value, int digits)
{
    std::array<char, 64> text{}; // 20 digits before the point
    auto const end = write_fixed(text.data(), text.data() + text.size(), value, digits);
    return {text.data(), end.ptr};
}

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

TILEMESH_HOST std::string joules_text(double joules)
{
    std::array<char, 32> text{};
    auto const end = write_general(text.data(), text.data() + text.size(), joules, 6);
    return {text.data(), end.ptr};
}

}}} // namespace tilemesh::report
