#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/number_text.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// A JSON string with its quotes. Of bytes that are no UTF-8 (RFC 3629), each longest beginning of a character becomes U+FFFD,
/// because JSON cannot express them. The bytes are those that nlohmann-json prints.
TILEMESH_HOST std::string json_string(std::string_view text);

/// Writes JSON text and builds no document: a document allocates in its destructor, and without memory that would end the
/// process.
class JsonText {
public:
    /// `indent`: blanks for each level, and a line for each member and item; 0: all in one line. `number`: the text of a finite
    /// number.
    explicit JsonText(std::size_t indent = 1, std::string (*number)(double) = number_text) : indent_(indent), number_(number) {}

    /// Writes a number, a truth value, nullptr or a text. JSON has no number that is not finite: it becomes null.
    template <class T>
    void value(T const& scalar)
    {
        if constexpr (std::is_same_v<T, bool>) text_ += scalar ? "true" : "false";
        else if constexpr (std::is_null_pointer_v<T>) text_ += "null";
        else if constexpr (std::is_integral_v<T>) text_ += std::to_string(scalar);
        else if constexpr (std::is_floating_point_v<T>) text_ += std::isfinite(scalar) ? number_(scalar) : "null";
        else text_ += json_string(scalar);
    }
    /// Starts the next item of an array; write its value next.
    void item()
    {
        if (!first_) text_ += indent_ == 0 ? ", " : ",";
        new_line();
        first_ = false;
    }
    /// Starts the next member of an object; write its value next.
    void key(std::string_view name)
    {
        item();
        value(name);
        text_ += ": ";
    }
    template <class T>
    void member(std::string_view name, T const& scalar)
    {
        key(name);
        value(scalar);
    }
    /// Writes a member whose value is JSON text.
    void member_as_is(std::string_view name, std::string_view json)
    {
        key(name);
        text_ += json;
    }
    /// Writes an object; `write()` writes its members.
    template <class Write>
    void object(Write const& write)
    {
        nest('{', '}', write);
    }
    template <class Write>
    void array(Write const& write)
    {
        nest('[', ']', write);
    }
    /// Writes a member that is an object.
    template <class Write>
    void object(std::string_view name, Write const& write)
    {
        key(name);
        object(write);
    }
    /// Writes a member that is an array; `write(x)` writes the value of the item for each x of `items`.
    template <class Items, class Write>
    void array(std::string_view name, Items const& items, Write const& write)
    {
        key(name);
        array([&] {
            for (auto const& each : items) {
                item();
                write(each);
            }
        });
    }
    /// Writes a member that is an array of objects; `write(x)` writes the members of one.
    template <class Items, class Write>
    void objects(std::string_view name, Items const& items, Write const& write)
    {
        array(name, items, [&](auto const& each) { object([&] { write(each); }); });
    }
    template <class Scalars>
    void list(std::string_view name, Scalars const& scalars)
    {
        array(name, scalars, [&](auto const& scalar) { value(scalar); });
    }
    std::string const& text() const noexcept { return text_; }

private:
    void new_line()
    {
        if (indent_ == 0) return;
        text_ += '\n';
        text_.append(indent_ * depth_, ' ');
    }
    template <class Write>
    void nest(char open, char close, Write const& write)
    {
        text_ += open;
        ++depth_;
        first_ = true;
        write();
        --depth_;
        if (!first_) new_line();
        first_ = false; // the item around it
        text_ += close;
    }
    std::string text_;
    std::size_t indent_, depth_ = 0;
    std::string (*number_)(double);
    bool first_ = true; ///< the innermost array or object is still empty
};

/// A 4 x 4 matrix, row by row, as a list of lists in one line (`JsonText::member_as_is`).
inline std::string matrix_text(std::array<double, 16> const& m, std::string (*number)(double) = number_text)
{
    std::string rows;
    for (std::size_t i = 0; i < 16; ++i) rows += (i == 0 ? "[[" : i % 4 == 0 ? "], [" : ", ") + number(m[i]);
    return rows + "]]";
}

/// An object in one line: `write(json)` writes its members.
template <class Write>
std::string json_line(Write const& write)
{
    JsonText json(0);
    json.object([&] { write(json); });
    return json.text();
}

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/json_text_code.hpp>
#endif
