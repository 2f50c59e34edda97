#pragma once
#include "option_table.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

/// Rows of options as JSON: settings of C and Python, keys of studies.
namespace shared {

/// Sets an option from JSON: a whole number or a number, true or false, a word, [640, 360], [0, 0.5, 1]. Throws `Misfit` for another value.
template <class Of, class Json>
void set_from_json(Of& of, Option<Of> const& row, Json const& json)
{
    auto const text_of = [&](Json const& one) {
        bool const is_whole = one.is_number() && one.template get<double>() == std::floor(one.template get<double>()) && std::fabs(one.template get<double>()) < 1e15;
        return is_whole ? std::to_string(one.template get<std::int64_t>()) : one.is_number() ? one.dump() : std::string();
    };
    std::string text;
    if (row.form == Form::flag) {
        if (!json.is_boolean()) throw Misfit{"it is true or false"};
        row.set(of, {.text = text, .whole = json.template get<bool>() ? 1u : 0u});
        return;
    }
    bool const wants_text = row.form == Form::word || row.form >= Form::text;
    bool good = json.is_array() ? row.form == Form::size || row.form == Form::three : json.is_string() == wants_text && !json.is_structured();
    if (json.is_string()) {
        text = json.template get<std::string>();
        good = good || std::any_of(row.words.begin(), row.words.end(), [&](Word const& one) { return one.word == text; });
    } else if (!json.is_array()) text = text_of(json);
    else
        for (auto const& one : json) {
            text.append(text.empty() ? "" : row.form == Form::size ? "x" : ",").append(text_of(one));
            good = good && one.is_number();
        }
    if (!good) throw Misfit{row.takes()};
    row.set(of, row.read(text));
}

/// An option as JSON, as `set_from_json` reads it.
template <class Json, class Of>
Json to_json(Of const& of, Option<Of> const& row)
{
    auto const v = row.get(of);
    switch (row.form) {
    case Form::flag:
        return v.whole != 0;
    case Form::whole:
        for (auto const& one : row.words)
            if (v.text == one.word) return std::string(v.text);
        return static_cast<std::int64_t>(v.text.empty() ? v.whole : row.read(v.text).whole);
    case Form::number:
        return v.number;
    case Form::three:
        return v.three;
    case Form::size:
        return {static_cast<std::uint32_t>(v.three[0]), static_cast<std::uint32_t>(v.three[1])};
    case Form::word:
        for (auto const& [word, number] : row.words)
            if (v.text.empty() && number == v.whole) return std::string(word);
        return std::string(v.text);
    default:
        return std::string(v.text);
    }
}

/// The row of this name; null if there is none.
template <class Rows>
auto find_row(Rows const& rows, std::string_view name)
{
    auto const at = std::find_if(std::begin(rows), std::end(rows), [name](auto const& row) { return row.name == name; });
    return at == std::end(rows) ? nullptr : &*at;
}

} // namespace shared
