#pragma once
#include <array>
#include <charconv>
#include <cmath>
#include <string>

namespace shared {

/// A number as JSON has it: the shortest text that reads back as this number. JSON has no number that is not finite.
inline std::string number(double value)
{
    if (!std::isfinite(value)) return "null";
    std::array<char, 32> text{};
    auto const end = std::to_chars(text.data(), text.data() + text.size(), value);
    return {text.data(), end.ptr};
}

/// A number for readers: three significant digits. No printed measure is known better, and each has a unit behind it.
inline std::string rounded(double value)
{
    if (!std::isfinite(value)) return "unknown";
    std::array<char, 32> text{};
    bool const large = value >= 999.5 && value < 1e15; // whole, not 1.02e+03
    auto const end = large ? std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, 0)
                           : std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 3);
    return {text.data(), end.ptr};
}

/// A text as JSON has it.
inline std::string json_text(std::string const& text)
{
    std::string out = "\"";
    for (char const c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
    return out + '"';
}

} // namespace shared
