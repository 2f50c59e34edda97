#pragma once
#include <cstdint>
#include <string>

/// The contract handler of this executable. It remembers broken contracts; the handler of the engines reports them.
namespace machine_test {

/// Number of contracts broken since the program began.
std::uint32_t broken_contracts() noexcept;
/// The text of the last broken contract; empty if there is none.
std::string last_broken_contract();

} // namespace machine_test
