#pragma once
#include <cstdint>
#include <string>

/// This executable's contract handler: it remembers, where the engines' would report.
namespace machine_test {

/// Contracts broken since the program began.
std::uint32_t broken_contracts() noexcept;
/// The text of the last one.
std::string last_broken_contract();

} // namespace machine_test
