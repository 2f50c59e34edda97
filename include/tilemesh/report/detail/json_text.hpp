#pragma once
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report::detail {

/// Writes JSON text as nlohmann-json prints it with an indent of one blank. It builds no nlohmann-json document, because the destructor
/// of a document allocates: without memory, that would end the process.
class JsonText {
public:
    template <class T>
    void value(T const& scalar)
    {
        text_ += nlohmann::ordered_json(scalar).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    }
    /// A number, or null where JSON has none: the PSNR of equal pictures is infinite.
    void finite(double number)
    {
        if (std::isfinite(number)) value(number);
        else value(nullptr);
    }
    /// Starts the next item of an array; write its value next.
    void item()
    {
        text_ += first_ ? "\n" : ",\n";
        text_.append(depth_, ' ');
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
    template <class Scalars>
    void list(std::string_view name, Scalars const& scalars)
    {
        key(name);
        array([&] {
            for (auto const& scalar : scalars) {
                item();
                value(scalar);
            }
        });
    }
    std::string const& text() const noexcept { return text_; }

private:
    template <class Write>
    void nest(char open, char close, Write const& write)
    {
        text_ += open;
        ++depth_;
        first_ = true;
        write();
        --depth_;
        if (!first_) {
            text_ += '\n';
            text_.append(depth_, ' ');
        }
        first_ = false; // the item around it
        text_ += close;
    }
    std::string text_;
    std::size_t depth_ = 0;
    bool first_ = true; ///< the innermost array or object is still empty
};

}}} // namespace tilemesh::report::detail
