#pragma once
#include <tilemesh/report/json_text.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {
namespace detail {

/// The bytes at the front of `text` that begin a UTF-8 character, and whether they are a whole one. RFC 3629 allows no longer
/// form than needed, no surrogate, and nothing above U+10FFFF.
struct Utf8 {
    std::size_t bytes;
    bool whole;
};
TILEMESH_HOST Utf8 character_at(std::string_view text) noexcept
{
    auto const byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    unsigned const first = byte(0);
    if (first < 0x80) return {1, true};
    if (first < 0xc2 || first > 0xf4) return {1, false};
    std::size_t const length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
    unsigned const least = first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80; // of the second byte
    unsigned const most = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
    for (std::size_t i = 1; i < length; ++i)
        if (i == text.size() || byte(i) < (i == 1 ? least : 0x80) || byte(i) > (i == 1 ? most : 0xbf)) return {i, false};
    return {length, true};
}

} // namespace detail

TILEMESH_HOST std::string json_string(std::string_view text)
{
    constexpr std::string_view escaped = "\"\\\b\f\n\r\t", letters = "\"\\bfnrt", hexadecimal = "0123456789abcdef";
    std::string out = "\"";
    while (!text.empty()) {
        auto const c = static_cast<unsigned char>(text[0]);
        auto const at = detail::character_at(text);
        if (auto const letter = escaped.find(text[0]); letter != escaped.npos) (out += '\\') += letters[letter];
        else if (c < 0x20) ((out += "\\u00") += hexadecimal[c >> 4]) += hexadecimal[c & 15u];
        else out += at.whole ? text.substr(0, at.bytes) : std::string_view("\xef\xbf\xbd");
        text.remove_prefix(at.bytes);
    }
    return out + '"';
}

}}} // namespace tilemesh::report
