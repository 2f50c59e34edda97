#pragma once
#include <algorithm>
#include <cstddef>
#include <string>

namespace render_map {

/// A text from a file or a command line, with any content, as one line of a terminal. Control characters become '?'. Of a text longer than
/// `most` bytes the middle is left out, so that its beginning and its end can be read.
inline std::string one_line(std::string text, std::size_t most = 1000)
{
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
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
