#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <istream>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/number_text.hpp>
#include <utility>

// Shared by the readers of cameras and trajectories. Their files may have any content. So the memory of a line is bounded, and a text from
// a file is made printable before an error shows it in its one line.
namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// The largest number that a field may hold: a tenth of the largest float, so that sums and rotated vectors of a few such numbers
/// stay finite when they are rounded.
inline constexpr double largest_number = 1e37;

/// The number of bytes in the first UTF-8 character of `text`. 0: the bytes are not a character, or are a control character or a line
/// separator.
TILEMESH_HOST std::size_t character_bytes(std::string_view text);

/// A file's text for an error message: each byte that is not part of a character becomes "?", and after `most` bytes comes "...".
TILEMESH_HOST std::string shown(std::string_view text, std::size_t most = 200);

/// A path for an error message, not shortened.
TILEMESH_HOST std::string shown_path(std::filesystem::path const& path);

/// Does `text` have printable characters only, so that it can stand in a report and in one line?
TILEMESH_HOST bool is_plain(std::string_view text);

/// The name of a file in a list or a camera file, with "/" for each backslash: it may have been written on Windows.
TILEMESH_HOST std::string with_slashes(std::string_view name);

inline constexpr std::string_view blanks = " \t\r\v\f";

/// Takes the next word off `text`; empty if there is none.
TILEMESH_HOST std::string_view take_word(std::string_view& text);

/// Reads all of `word` as a number; false if it is not one. `read_number` accepts no plus sign, but some writers put one.
template <class T>
bool parse_number(std::string_view word, T& value)
{
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    auto const read = number_of<T>(word);
    if (read) value = *read;
    return read.has_value();
}

/// For a number outside the range of a double: is it too small, not too large? It is too small if its first digit other than 0 is after the
/// decimal point once the exponent has moved the point.
TILEMESH_HOST bool is_tiny(std::string_view number);

/// How a file begins that stands for another one: a pointer of git LFS, or a web page.
inline constexpr std::array<std::string_view, 5> stand_ins{"version https://git-lfs", "<!DOCTYPE html", "<!doctype html", "<html", "<HTML"};

/// Throws `Error` if a file that begins so is one of `stand_ins`.
TILEMESH_HOST void refuse_stand_in(std::string_view begin, std::string const& file);

/// Opens a regular file. It does not open files that may block or never end (a pipe, a device). Throws `Error` if the file cannot be
/// opened, or if it is longer than `most_bytes`; `wanted` says what the user should name instead.
TILEMESH_HOST std::ifstream open_file(std::filesystem::path const& path, std::uint64_t most_bytes, std::string const& wanted);

/// Reads lines that end in LF or CR LF; the last line may have no end. It skips a byte order mark. It keeps one line of at most 64 KiB in
/// memory; real lines have about a hundred bytes.
class LineReader {
public:
    static constexpr std::size_t most_bytes = 65536;

    /// Errors call the file `name`.
    LineReader(std::istream& stream, std::string name) : stream_(stream), name_(std::move(name)), buffer_(most_bytes + 1, '\0') {}

    /// Goes to the next line; false if there is none. Throws `Error` for a line that is too long.
    TILEMESH_HOST bool next();

    /// Goes to the next part of a line of any length, 64 KiB at a time. The line ends with the part for which `whole` is true.
    TILEMESH_HOST bool next_part();

    std::string_view text() const { return text_; }
    bool whole() const { return whole_; }
    /// "FILE line 7"
    std::string place() const { return name_ + " line " + std::to_string(number_); }

private:
    std::istream& stream_;
    std::string name_;
    std::string buffer_;
    std::string_view text_;
    std::uint64_t number_ = 0;
    bool whole_ = true;
};

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/text_input_code.hpp>
#endif
