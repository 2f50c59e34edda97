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
#include <tilemesh/scene/detail/json_reader.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

TILEMESH_HOST JsonReader::JsonReader(std::istream& stream, std::string const& name, std::string advice)
    : stream_(stream), name_(name), advice_(std::move(advice)), buffer_(65536, '\0')
{
    if (peek() != 0xef) return;
    for (int const byte : {0xef, 0xbb, 0xbf})
        if (!take(byte)) refuse("a byte order mark is cut off");
}

TILEMESH_HOST auto JsonReader::next() -> JsonPart
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

TILEMESH_HOST void JsonReader::skip(JsonPart part)
{
    if (part != JsonPart::begin_object && part != JsonPart::begin_list) return;
    for (std::uint32_t const outside = depth_ - 1; depth_ > outside;) next();
}

TILEMESH_HOST void JsonReader::refuse(std::string const& why)
{
    throw Error(name_ + " is not JSON (parse error at line " + std::to_string(line_) + ", column " +
                std::to_string(passed_ + at_ + 1 - line_begin_) + ": " + (peek() < 0 ? "the text ends, " : "") + why +
                "); " + advice_);
}

TILEMESH_HOST int JsonReader::peek()
{
    if (at_ == size_ && !fetch()) return -1;
    return static_cast<unsigned char>(buffer_[at_]);
}

TILEMESH_HOST int JsonReader::get()
{
    int const byte = peek();
    if (byte >= 0) ++at_;
    return byte;
}

TILEMESH_HOST bool JsonReader::take(int byte)
{
    bool const there = peek() == byte;
    if (there) ++at_;
    return there;
}

TILEMESH_HOST bool JsonReader::fetch()
{
    passed_ += size_;
    at_ = size_ = 0;
    try {
        auto const room = static_cast<std::streamsize>(buffer_.size());
        size_ = static_cast<std::size_t>(stream_.rdbuf()->sgetn(buffer_.data(), room));
    } catch (std::ios_base::failure const&) {
        throw Error(name_ +
                    " cannot be read to its end (the system reports a read error); check the disk or copy the file");
    }
    return size_ != 0;
}

TILEMESH_HOST void JsonReader::skip_blanks()
{
    for (int c; (c = peek()) == ' ' || c == '\t' || c == '\r' || c == '\n'; ++at_)
        if (c == '\n') {
            ++line_;
            line_begin_ = passed_ + at_ + 1;
        }
}

TILEMESH_HOST auto JsonReader::value() -> JsonPart
{
    int const c = peek();
    if (c == '{' || c == '[') {
        if (depth_ == deepest)
            throw Error(name_ + " is not read (it is nested deeper than " + std::to_string(deepest) + " levels); " + advice_);
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

TILEMESH_HOST void JsonReader::read_digits()
{
    if (!is_digit(peek())) refuse("expected a digit");
    while (is_digit(peek())) text_ += static_cast<char>(get());
}

TILEMESH_HOST void JsonReader::read_number_text()
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

TILEMESH_HOST void JsonReader::read_text()
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

TILEMESH_HOST void JsonReader::read_character()
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

TILEMESH_HOST void JsonReader::read_escape()
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

TILEMESH_HOST std::uint32_t JsonReader::read_hex()
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

}}} // namespace tilemesh::scene
