#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace shared {

/// Reads the values of a program's options. A value that cannot be used throws Error, which names the option and the program's --help.
class OptionValues {
public:
    constexpr explicit OptionValues(char const* program) noexcept : program_(program) {}

    [[noreturn]] void refuse(std::string_view option, std::string_view text, std::string const& why) const;
    std::uint32_t whole(std::string_view option, std::string_view text, std::uint32_t least, std::uint32_t most) const;
    /// `range` is a text, as in "from 0 to 1".
    double number(std::string_view option, std::string_view text, double least, double most, std::string const& range) const;
    /// The value of option argv[i]; moves i to it.
    std::string_view next(int argc, char** argv, int& i) const;

private:
    char const* program_;
};

} // namespace shared
