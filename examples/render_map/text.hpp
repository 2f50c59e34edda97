#pragma once
#include <algorithm>
#include <cstddef>
#include <string>

namespace render_map {

/// The bytes of the UTF-8 character at `at`; 0: none begins there (RFC 3629: no overlong form, no surrogate, none above U+10FFFF).
inline std::size_t utf8_length(std::string const& text, std::size_t at)
{
    auto const byte = [&](std::size_t i) { return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0u; };
    unsigned const first = byte(0), second = byte(1);
    if (first < 0x80) return 1;
    std::size_t const length = first >= 0xc2 && first <= 0xdf ? 2 : (first & 0xf0u) == 0xe0 ? 3 : first >= 0xf0 && first <= 0xf4 ? 4 : 0;
    for (std::size_t i = 1; i < length; ++i)
        if ((byte(i) & 0xc0u) != 0x80) return 0;
    if ((first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f) || (first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f)) return 0;
    return length;
}

/// A text from a file or a command line, with any content, as one line of a terminal. Control characters and bytes that are no UTF-8 become
/// '?'. Of a text longer than `most` bytes the middle is left out, so that its beginning and its end can be read.
inline std::string one_line(std::string text, std::size_t most = 1000)
{
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    for (std::size_t i = 0; i < text.size();) {
        auto const length = utf8_length(text, i);
        if (length == 0) text[i] = '?';
        i += length == 0 ? 1 : length;
    }
    // U+0080 to U+009F are control characters too: c2 80 to c2 9f in UTF-8.
    for (std::size_t i = 0; i + 1 < text.size(); ++i)
        if (text[i] == '\xc2' && (static_cast<unsigned char>(text[i + 1]) & 0xe0) == 0x80) text[i] = text[i + 1] = '?';
    if (text.size() <= most) return text;
    // A cut does not split a UTF-8 character: its later bytes are 10xxxxxx.
    auto const inside = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xc0) == 0x80; };
    std::size_t begin = most / 2, end = text.size() - most / 2;
    while (begin > 0 && inside(begin)) --begin;
    while (end < text.size() && inside(end)) ++end;
    return text.substr(0, begin).append("...").append(text, end);
}

} // namespace render_map
