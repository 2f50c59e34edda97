#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

// Slow and simple readers of the library's files, for comparison. They hold the whole file in memory, split it with strings and
// strtod, and use no code of the library. A reader returns nothing for a file that must be refused. This header includes what all of them
// use of the standard library.
namespace plain {

inline bool is_in(char c, std::string const& set) { return set.find(c) != std::string::npos; }
inline bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The parts of `text` between characters of `separators`, without empty ones.
inline std::vector<std::string> words(std::string const& text, std::string const& separators = " \t\r\v\f")
{
    std::vector<std::string> all;
    std::string word;
    for (char const c : text + separators[0]) {
        if (!is_in(c, separators)) {
            word += c;
        } else if (!word.empty()) {
            all.push_back(word);
            word.clear();
        }
    }
    return all;
}

/// The lines of a text. A line end at the end of the text begins no further line.
inline std::vector<std::string> lines(std::string const& text)
{
    std::vector<std::string> all;
    std::string line;
    for (char const c : text) {
        if (c == '\n') {
            all.push_back(line);
            line.clear();
        } else {
            line += c;
        }
    }
    if (!line.empty()) all.push_back(line);
    return all;
}
inline std::string without_mark(std::string const& text)
{
    return text.substr(0, 3) == "\xef\xbb\xbf" ? text.substr(3) : text;
}

/// The number that a word is: digits with a point and an exponent, or inf and nan as C writes them, after one sign. `lost`: no double holds
/// the number; the value is then 0 or infinite.
struct Number {
    double value = 0.0;
    bool lost = false;
};
inline std::optional<Number> number(std::string word)
{
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word = word.substr(1);
    std::string const body = !word.empty() && word[0] == '-' ? word.substr(1) : word;
    if (body.empty() || body.find('\0') != body.npos || !(is_digit(body[0]) || is_in(body[0], ".iInN"))) return {};
    if (is_digit(body[0]) && body.find_first_of("xXpP") != body.npos) return {};
    char* end = nullptr;
    Number found{std::strtod(word.c_str(), &end)};
    if (end != word.c_str() + word.size()) return {};
    if (is_in(body[0], "iInN")) return found;
    bool const zero = body.substr(0, body.find_first_of("eE")).find_first_of("123456789") == body.npos;
    found.lost = found.value - found.value != 0.0 || (found.value == 0.0 && !zero);
    return found;
}
/// A word as a number from -1e37 to 1e37.
inline std::optional<double> moderate(std::string const& word)
{
    auto const found = number(word);
    if (!found || found->lost || !(found->value >= -1e37 && found->value <= 1e37)) return {};
    return found->value;
}

/// An integer below 2^bits, of digits only.
inline std::optional<std::uint64_t> whole(std::string const& word, unsigned bits)
{
    if (word.empty()) return {};
    unsigned __int128 value = 0;
    for (char const c : word) {
        if (!is_digit(c)) return {};
        value = value * 10 + static_cast<unsigned>(c - '0');
        if (value >> bits != 0) return {};
    }
    return static_cast<std::uint64_t>(value);
}
inline std::optional<std::uint64_t> whole_with_plus(std::string const& word, unsigned bits)
{
    return whole(word.size() > 1 && word[0] == '+' ? word.substr(1) : word, bits);
}

/// Is a text UTF-8 without control characters and line separators?
inline bool printable(std::string const& text)
{
    for (std::size_t i = 0; i < text.size();) {
        auto const at = [&](std::size_t k) { return i + k < text.size() ? static_cast<unsigned char>(text[i + k]) : 0u; };
        std::size_t const bytes = at(0) < 0x80 ? 1 : at(0) >> 5 == 6 ? 2 : at(0) >> 4 == 14 ? 3 : at(0) >> 3 == 30 ? 4 : 0;
        if (bytes == 0) return false;
        unsigned long code = bytes == 1 ? at(0) : at(0) & (0x7fu >> bytes);
        for (std::size_t k = 1; k < bytes; ++k) {
            if (at(k) >> 6 != 2) return false;
            code = code * 64 + (at(k) & 63);
        }
        unsigned long const least[] = {0, 0, 0x80, 0x800, 0x10000};
        if (code < least[bytes] || code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff)) return false;
        if (code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x2028 || code == 0x2029) return false;
        i += bytes;
    }
    return true;
}

} // namespace plain
