#include "handler.hpp"
#include <tilemesh/config.hpp>

namespace {
std::uint32_t count = 0;
char const* last = "";
} // namespace

extern "C" void tilemesh_contract_broken(char const* text) noexcept
{
    ++count;
    last = text;
}

namespace machine_test {
std::uint32_t broken_contracts() noexcept
{
    return count;
}
std::string last_broken_contract()
{
    return last;
}
} // namespace machine_test
