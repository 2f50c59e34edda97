#pragma once
#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace shared {

/// The length of the UTF-8 character at the beginning of a text that is not empty: 1 to 4 bytes; 0 if these bytes are no UTF-8 (the Unicode
/// standard, table 3-7: no overlong form, no surrogate, nothing above U+10FFFF).
inline std::size_t utf8_length(std::string_view text) noexcept
{
    auto const byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
    unsigned const first = byte(0);
    if (first < 0x80) return 1;
    std::size_t const length = first >= 0xc2 && first < 0xe0 ? 2 : first >= 0xe0 && first < 0xf0 ? 3 : first >= 0xf0 && first < 0xf5 ? 4 : 0;
    for (std::size_t i = 1; i < length; ++i) {
        unsigned const least = i > 1 ? 0x80 : first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;
        unsigned const most = i > 1 ? 0xbf : first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
        if (byte(i) < least || byte(i) > most) return 0;
    }
    return length;
}

/// A text from a file or a command line, with any content, as one line of UTF-8 on a terminal. Each byte of a control character, and each
/// byte that is no UTF-8, becomes '?'. Of a text longer than `most` bytes the middle is left out, so that its beginning and its end can be
/// read.
inline std::string one_line(std::string_view text, std::size_t most = 1000)
{
    std::string shown;
    for (std::size_t at = 0; at < text.size();) {
        auto const first = static_cast<unsigned char>(text[at]);
        auto const length = utf8_length(text.substr(at)), step = std::max<std::size_t>(length, 1);
        // U+0080 to U+009F are control characters too: c2 80 to c2 9f in UTF-8.
        bool const control = first < 0x20 || first == 0x7f || (first == 0xc2 && length == 2 && static_cast<unsigned char>(text[at + 1]) < 0xa0);
        if (length != 0 && !control) shown.append(text.substr(at, length));
        else shown.append(step, '?');
        at += step;
    }
    if (shown.size() <= most) return shown;
    // A cut does not split a UTF-8 character: its later bytes are 10xxxxxx.
    auto const inside = [&](std::size_t at) { return (static_cast<unsigned char>(shown[at]) & 0xc0) == 0x80; };
    std::size_t begin = most / 2, end = shown.size() - most / 2;
    while (begin > 0 && inside(begin)) --begin;
    while (end < shown.size() && inside(end)) ++end;
    return shown.substr(0, begin).append("...").append(shown, end);
}

} // namespace shared
