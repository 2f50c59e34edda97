#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <ios>
#include <istream>
#include <string>
#include <string_view>
#include <system_error>
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
    JsonReader(std::istream& stream, std::string const& name, std::string advice = "name a JSON camera file or a COLMAP text model")
        : stream_(stream), name_(name), advice_(std::move(advice)), buffer_(65536, '\0')
    {
        if (peek() != 0xef) return;
        for (int const byte : {0xef, 0xbb, 0xbf})
            if (!take(byte)) refuse("a byte order mark is cut off");
    }

    /// Goes to the next part.
    JsonPart next()
    {
        skip_blanks();
        if (depth_ == 0 && after_value_) {
            if (peek() >= 0) refuse("more text after the value");
            return JsonPart::end;
        }
        if ((after_value_ || just_opened_) && take(in_object() ? '}' : ']')) {
            just_opened_ = false;
            after_value_ = true;
            return (objects_ >> --depth_ & 1) != 0 ? JsonPart::end_object : JsonPart::end_list;
        }
        if (after_value_) {
            if (!take(',')) refuse(in_object() ? "expected , or } after a value" : "expected , or ] after a value");
            skip_blanks();
        }
        just_opened_ = after_value_ = false;
        if (in_object() && !after_key_) {
            if (!take('"')) refuse("expected a key in quotes");
            read_text();
            skip_blanks();
            if (!take(':')) refuse("expected : after a key");
            after_key_ = true;
            return JsonPart::key;
        }
        after_key_ = false;
        return value();
    }

    /// Skips the rest of a value whose first part, `part`, `next` has returned.
    void skip(JsonPart part)
    {
        if (part != JsonPart::begin_object && part != JsonPart::begin_list) return;
        for (std::uint32_t const outside = depth_ - 1; depth_ > outside;) next();
    }

    /// The last key or text, decoded to UTF-8; or the last number, true, false or null, as written.
    std::string const& text() const { return text_; }
    /// The value of a number, which is finite.
    double number() const { return number_; }

private:
    [[noreturn]] void refuse(std::string const& why)
    {
        throw Error(name_ + " is not JSON (parse error at line " + std::to_string(line_) + ", column " +
                    std::to_string(passed_ + at_ + 1 - line_begin_) + ": " + (peek() < 0 ? "the text ends, " : "") + why + "); " + advice_);
    }

    /// The next byte, or -1 at the end; `get` takes it.
    int peek()
    {
        if (at_ == size_ && !fetch()) return -1;
        return static_cast<unsigned char>(buffer_[at_]);
    }
    int get()
    {
        int const byte = peek();
        if (byte >= 0) ++at_;
        return byte;
    }
    bool take(int byte)
    {
        bool const there = peek() == byte;
        if (there) ++at_;
        return there;
    }
    bool fetch()
    {
        passed_ += size_;
        at_ = size_ = 0;
        try {
            auto const room = static_cast<std::streamsize>(buffer_.size());
            size_ = static_cast<std::size_t>(stream_.rdbuf()->sgetn(buffer_.data(), room));
        } catch (std::ios_base::failure const&) {
            throw Error(name_ + " cannot be read to its end (the system reports a read error); check the disk or copy the file");
        }
        return size_ != 0;
    }
    void skip_blanks()
    {
        for (int c; (c = peek()) == ' ' || c == '\t' || c == '\r' || c == '\n'; ++at_)
            if (c == '\n') {
                ++line_;
                line_begin_ = passed_ + at_ + 1;
            }
    }

    bool in_object() const { return depth_ != 0 && (objects_ >> (depth_ - 1) & 1) != 0; }

    JsonPart value()
    {
        int const c = peek();
        if (c == '{' || c == '[') {
            if (depth_ == deepest) throw Error(name_ + " is not read (it is nested deeper than " + std::to_string(deepest) + " levels); " + advice_);
            ++at_;
            std::uint64_t const bit = std::uint64_t{1} << depth_++;
            objects_ = c == '{' ? objects_ | bit : objects_ & ~bit;
            just_opened_ = true;
            return c == '{' ? JsonPart::begin_object : JsonPart::begin_list;
        }
        after_value_ = true;
        if (take('"')) {
            read_text();
            return JsonPart::text;
        }
        if (c == '-' || is_digit(c)) {
            read_number_text();
            return JsonPart::number;
        }
        for (std::string_view const word : {"true", "false", "null"}) {
            if (c != word.front()) continue;
            for (char const letter : word)
                if (!take(letter)) refuse("expected " + std::string(word));
            text_ = word;
            return JsonPart::other;
        }
        refuse("expected a value");
    }

    static bool is_digit(int c) { return c >= '0' && c <= '9'; }

    void read_digits()
    {
        if (!is_digit(peek())) refuse("expected a digit");
        while (is_digit(peek())) text_ += static_cast<char>(get());
    }
    void read_number_text()
    {
        text_.clear();
        if (take('-')) text_ += '-';
        if (take('0')) text_ += '0';
        else read_digits();
        if (take('.')) {
            text_ += '.';
            read_digits();
        }
        if (take('e') || take('E')) {
            text_ += 'e';
            if (take('-')) text_ += '-';
            else take('+');
            read_digits();
        }
        number_ = 0.0;
        auto const [end, error] = read_number(text_.data(), text_.data() + text_.size(), number_);
        if (error == std::errc::result_out_of_range && is_tiny(text_)) number_ = text_.front() == '-' ? -0.0 : 0.0;
        else if (error != std::errc{} || std::isinf(number_)) refuse("number overflow in " + shown(text_, 40));
    }

    /// Reads a text after its opening quote.
    void read_text()
    {
        text_.clear();
        for (;;) {
            int const c = peek();
            if (c < 0x20) refuse(c < 0 ? "expected \"" : "a control character in a text");
            if (c == '"' || c == '\\') {
                ++at_;
                if (c == '"') return;
                read_escape();
            } else if (c < 0x80) {
                ++at_;
                text_ += static_cast<char>(c);
            } else {
                read_character();
            }
        }
    }
    /// Reads a character of two to four bytes. The limits of the second byte refuse surrogates, overlong forms and codes above
    /// U+10FFFF.
    void read_character()
    {
        int const lead = peek();
        int const more = lead < 0xe0 ? 1 : lead < 0xf0 ? 2 : 3;
        int least = lead == 0xe0 ? 0xa0 : lead == 0xf0 ? 0x90 : 0x80;
        int most = lead == 0xed ? 0x9f : lead == 0xf4 ? 0x8f : 0xbf;
        if (lead < 0xc2 || lead > 0xf4) refuse("a byte that is no UTF-8");
        text_ += static_cast<char>(get());
        for (int i = 0; i < more; ++i, least = 0x80, most = 0xbf) {
            if (peek() < least || peek() > most) refuse("a byte that is no UTF-8");
            text_ += static_cast<char>(get());
        }
    }
    void read_escape()
    {
        static constexpr std::string_view letters = "\"\\/bfnrt", meant = "\"\\/\b\f\n\r\t";
        int const c = peek();
        if (std::size_t const i = c < 0 ? letters.npos : letters.find(static_cast<char>(c)); i != letters.npos) {
            ++at_;
            text_ += meant[i];
            return;
        }
        if (!take('u')) refuse("an escape that JSON does not have");
        std::uint32_t code = read_hex();
        if (code >= 0xd800 && code <= 0xdfff) {
            constexpr char const* lone = "half of a surrogate pair";
            if (code >= 0xdc00 || !take('\\') || !take('u')) refuse(lone);
            std::uint32_t const low = read_hex();
            if (low < 0xdc00 || low > 0xdfff) refuse(lone);
            code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
        }
        int const more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
        constexpr std::uint32_t leads[] = {0x00, 0xc0, 0xe0, 0xf0};
        text_ += static_cast<char>(leads[more] | code >> (6 * more));
        for (int i = more - 1; i >= 0; --i) text_ += static_cast<char>(0x80 | (code >> (6 * i) & 0x3f));
    }
    std::uint32_t read_hex()
    {
        std::uint32_t code = 0;
        for (int i = 0; i < 4; ++i) {
            int const c = peek(), letter = c | 0x20;
            bool const digit = is_digit(c);
            if (!digit && (c < 0 || letter < 'a' || letter > 'f')) refuse("\\u takes four hexadecimal digits");
            ++at_;
            code = code << 4 | static_cast<std::uint32_t>(digit ? c - '0' : letter - 'a' + 10);
        }
        return code;
    }

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

}}} // namespace tilemesh::v0_2::scene::detail
