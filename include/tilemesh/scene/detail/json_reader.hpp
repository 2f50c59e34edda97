#pragma once
#include <cstddef>
#include <cstdint>
#include <ios>
#include <istream>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// The parts of a JSON text. `other` is true, false or null; `end` is the end of the text.
enum class JsonPart : std::uint8_t { begin_object, end_object, begin_list, end_list, key, text, number, other, end };

/// Reads a JSON text (RFC 8259) part by part and builds no document. It skips a byte order mark. Throws `Error` at the first byte
/// that breaks the grammar, for text that is not UTF-8, for a number too large for a double, and for more than 64 levels of lists
/// and objects.
///
/// Every byte is read once. Memory: 64 KiB, and at most three times the longest text or number.
class JsonReader {
public:
    /// A camera file needs five levels.
    static constexpr std::uint32_t deepest = 64;

    /// Errors call the file `name` and end with `advice`.
    TILEMESH_HOST JsonReader(std::istream& stream, std::string const& name,
                             std::string advice = "name a JSON camera file or a COLMAP text model");

    /// Goes to the next part.
    TILEMESH_HOST JsonPart next();

    /// Skips the rest of a value whose first part, `part`, `next` has returned.
    TILEMESH_HOST void skip(JsonPart part);

    /// The last key or text, decoded to UTF-8; or the last number, true, false or null, as written.
    std::string const& text() const { return text_; }
    /// The value of a number, which is finite.
    double number() const { return number_; }

private:
    [[noreturn]] TILEMESH_HOST void refuse(std::string const& why);

    /// The next byte, or -1 at the end; `get` takes it.
    TILEMESH_HOST int peek();
    TILEMESH_HOST int get();
    TILEMESH_HOST bool take(int byte);
    TILEMESH_HOST bool fetch();
    TILEMESH_HOST void skip_blanks();

    bool in_object() const { return depth_ != 0 && (objects_ >> (depth_ - 1) & 1) != 0; }

    TILEMESH_HOST JsonPart value();

    static bool is_digit(int c) { return c >= '0' && c <= '9'; }

    TILEMESH_HOST void read_digits();
    TILEMESH_HOST void read_number_text();

    /// Reads a text after its opening quote.
    TILEMESH_HOST void read_text();
    /// Reads a character of two to four bytes. The limits of the second byte refuse surrogates, overlong forms and codes above
    /// U+10FFFF.
    TILEMESH_HOST void read_character();
    TILEMESH_HOST void read_escape();
    TILEMESH_HOST std::uint32_t read_hex();

    std::istream& stream_;
    std::string const& name_;
    std::string advice_;
    std::string buffer_;
    std::size_t at_ = 0, size_ = 0;
    std::uint64_t passed_ = 0, line_ = 1, line_begin_ = 0; ///< bytes before the buffer; the line, and where it begins
    std::uint64_t objects_ = 0;                            ///< bit d: level d is an object, not a list
    std::uint32_t depth_ = 0;
    bool just_opened_ = false, after_key_ = false, after_value_ = false;
    std::string text_;
    double number_ = 0.0;
};

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/json_reader_code.hpp>
#endif
