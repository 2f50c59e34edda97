#pragma once
#include "option_table.hpp"
#include "text.hpp"
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <vector>

/// JSON that a user wrote, and rows of options as JSON: settings of C and Python, keys of studies.
namespace shared {

/// Reads JSON that a user wrote. Throws `tilemesh::Error` for a text that is no JSON, and for what JSON allows and no program here can mean: a
/// number that no double holds, a key that comes twice in an object, more than 64 lists and objects inside each other. `name` begins the error.
inline nlohmann::ordered_json json_of(std::string_view text, std::string const& name)
{
    using Json = nlohmann::ordered_json;
    auto const refuse = [&](std::string const& problem, std::string const& todo) {
        throw tilemesh::Error(one_line(name) + " " + problem + "; " + todo);
    };
    std::vector<std::set<std::string>> keys;
    auto const look = [&](int depth, Json::parse_event_t event, Json& value) {
        if (depth > 64) refuse("cannot be read (lists and objects are more than 64 deep)", "write fewer inside each other");
        if (event == Json::parse_event_t::object_start) keys.emplace_back();
        else if (event == Json::parse_event_t::object_end) keys.pop_back();
        else if (event == Json::parse_event_t::key && !keys.back().insert(value.get<std::string>()).second)
            refuse("repeats a key (\"" + one_line(value.get<std::string>(), 60) + "\" is there twice in one object)", "remove one of them");
        return true;
    };
    try {
        return Json::parse(text, look);
    } catch (Json::parse_error const& error) {
        auto const line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(std::min(error.byte, text.size())), '\n');
        refuse("is no JSON (line " + std::to_string(line) + " ends what can be read)", "correct it there");
    } catch (Json::exception const& error) { // "[json.exception.out_of_range.406] number overflow parsing '1e400'"
        std::string const why = error.what();
        refuse("cannot be read (" + why.substr(std::min(why.find("] ") + 2, why.size())) + ")", "write a number that a double can hold");
    }
    return {};
}

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
