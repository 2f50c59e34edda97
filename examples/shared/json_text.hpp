#pragma once
#include "text.hpp"
#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <vector>

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

} // namespace shared
