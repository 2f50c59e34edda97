#pragma once
#include <algorithm>
#include <cctype>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <tilemesh/render/setup_fields.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <utility>
#include <vector>

namespace json_schema {

using Json = nlohmann::ordered_json;

/// Checks a document against a JSON schema (draft 2020-12, the keywords below; another keyword is an error). Collects what is wrong, one
/// line each, and which members of objects it met.
class Validator {
public:
    explicit Validator(Json const& schema) : root_(schema) { note_members(schema, "#"); }

    std::vector<std::string> errors(Json const& document)
    {
        errors_.clear();
        check(root_, "#", document, "$");
        return errors_;
    }
    /// The members that the schema names and no document so far has had, as "#/$defs/frame/image".
    std::vector<std::string> unseen() const
    {
        std::vector<std::string> out;
        std::set_difference(members_.begin(), members_.end(), seen_.begin(), seen_.end(), std::back_inserter(out));
        return out;
    }

private:
    static bool is_of(Json const& value, std::string const& type)
    {
        return type == "object"    ? value.is_object()
               : type == "array"   ? value.is_array()
               : type == "string"  ? value.is_string()
               : type == "integer" ? value.is_number_integer()
               : type == "number"  ? value.is_number()
               : type == "boolean" ? value.is_boolean()
                                   : type == "null" && value.is_null();
    }
    void wrong(std::string const& at, std::string const& why) { errors_.push_back(at + ": " + why); }

    void note_members(Json const& node, std::string const& where)
    {
        if (node.contains("properties"))
            for (auto const& item : node["properties"].items()) {
                members_.insert(where + "/" + item.key());
                note_members(item.value(), where + "/" + item.key());
            }
        if (node.contains("items")) note_members(node["items"], where + "/[]");
        if (node.contains("$defs"))
            for (auto const& item : node["$defs"].items()) note_members(item.value(), "#/$defs/" + item.key());
    }

    void check(Json const& node, std::string const& where, Json const& value, std::string const& at)
    {
        for (auto const& item : node.items()) {
            auto const& key = item.key();
            auto const& rule = item.value();
            if (key == "$schema" || key == "$id" || key == "$defs" || key == "title" || key == "description") continue;
            if (key == "$ref") {
                auto const name = rule.get<std::string>();
                check(root_.at(Json::json_pointer(name.substr(1))), name, value, at);
            } else if (key == "type") {
                auto const types = rule.is_array() ? rule : Json::array({rule});
                if (std::none_of(types.begin(), types.end(), [&](Json const& type) { return is_of(value, type.get<std::string>()); }))
                    wrong(at, "is not of type " + rule.dump());
            } else if (key == "enum") {
                if (std::find(rule.begin(), rule.end(), value) == rule.end()) wrong(at, "is none of " + rule.dump());
            } else if (key == "const") {
                if (value != rule) wrong(at, "is not " + rule.dump());
            } else if (key == "minimum") {
                if (value.is_number() && value.get<double>() < rule.get<double>()) wrong(at, "is below " + rule.dump());
            } else if (key == "minItems" || key == "maxItems") {
                if (value.is_array() && (key == "minItems" ? value.size() < rule.get<std::size_t>() : value.size() > rule.get<std::size_t>()))
                    wrong(at, "has " + std::to_string(value.size()) + " items, not " + rule.dump());
            } else if (key == "items") {
                if (!value.is_array()) continue;
                for (std::size_t i = 0; i < value.size(); ++i) check(rule, where + "/[]", value[i], at + "[" + std::to_string(i) + "]");
            } else if (key == "required") {
                for (auto const& name : rule)
                    if (value.is_object() && !value.contains(name.get<std::string>())) wrong(at, "has no \"" + name.get<std::string>() + "\"");
            } else if (key == "properties") {
                if (!value.is_object()) continue;
                for (auto const& member : value.items()) {
                    if (!rule.contains(member.key())) continue;
                    seen_.insert(where + "/" + member.key());
                    check(rule[member.key()], where + "/" + member.key(), member.value(), at + "." + member.key());
                }
            } else if (key == "additionalProperties" && rule == false) {
                if (!value.is_object()) continue;
                for (auto const& member : value.items())
                    if (!node["properties"].contains(member.key())) wrong(at, "has \"" + member.key() + "\", which the schema does not know");
            } else {
                wrong(at, "the schema has \"" + key + "\", which this program does not know");
            }
        }
    }

    Json const& root_;
    std::vector<std::string> errors_;
    std::set<std::string> members_, seen_;
};

/// Every change of one place that a schema should notice: each member of each object left out, a member that nobody knows in each object,
/// each value replaced by one of another type. Of an array, only the first item and the last are changed.
inline std::vector<std::pair<std::string, Json>> spoiled(Json const& document)
{
    std::vector<std::pair<std::string, Json>> out;
    auto const walk = [&](auto const& self, Json::json_pointer const& at) -> void {
        auto const& value = document.at(at);
        auto const change = [&](std::string const& how, auto const& f) {
            auto copy = document;
            f(copy.at(at));
            out.emplace_back(how + at.to_string(), std::move(copy));
        };
        change("another type: ", [](Json& v) { v = v.is_boolean() ? Json(Json::array({1})) : Json(true); });
        if (value.is_object()) {
            change("an unknown member: ", [](Json& v) { v["nobody_knows"] = 1; });
            for (auto const& item : value.items()) {
                change("without " + item.key() + ": ", [&](Json& v) { v.erase(item.key()); });
                self(self, at / item.key());
            }
        }
        if (value.is_array())
            for (std::size_t i = 0; i < value.size(); i += std::max<std::size_t>(1, value.size() - 1)) self(self, at / i);
    };
    walk(walk, Json::json_pointer());
    return out;
}

/// The schema of report.json with all numbers of `report_fields` among the members of a frame, and all of `setup_fields` in `setup`.
inline Json with_fields(Json schema)
{
    auto& frame = schema["$defs"]["frame"];
    auto const add = [](Json& object, tilemesh::report::ReportField const& field) {
        std::string const leaf(field.leaf());
        object["properties"][leaf] = {{"description", field.meaning}, {"type", field.exact() ? "integer" : "number"}, {"minimum", 0}};
        auto& required = object["required"];
        if (std::find(required.begin(), required.end(), leaf) == required.end()) required.push_back(leaf);
    };
    std::string last;
    for (auto const& field : tilemesh::report::report_fields) {
        std::string const group(field.group());
        if (group == "size_px" || field.name == "lost") continue; // arrays
        if (group.empty()) {
            add(frame, field);
            continue;
        }
        auto& object = frame["properties"][group];
        if (object.is_null()) object = {{"description", group + "."}, {"type", "object"}, {"additionalProperties", false}};
        if (group != last) object["required"] = Json::array(), object["properties"] = Json::object();
        last = group;
        add(object, field);
    }
    Json setup = {{"description", "The fields of the setup that ran."}, {"type", "object"}, {"additionalProperties", false}};
    setup["required"] = Json::array(), setup["properties"] = Json::object();
    namespace render = tilemesh::render;
    for (auto const& field : render::setup_fields) {
        if (field.use == render::SetupField::several) continue;
        std::string name(field.name), meaning(field.meaning);
        std::replace(name.begin(), name.end(), '-', '_');
        if (auto const at = meaning.find(": {}"); at != meaning.npos) meaning.erase(at);
        if (!field.values.unit.empty() && field.values.unit != "tiles") meaning += ", in " + std::string(field.values.unit);
        meaning[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(meaning[0])));
        setup["required"].push_back(name);
        auto& of = setup["properties"][name] = {{"description", meaning + "."}};
        if (field.values.kind == render::Values::word)
            for (auto const& word : field.values.words) of["enum"].push_back(word.word);
        else of["type"] = field.values.kind == render::Values::whole ? "integer" : "number", of["minimum"] = 0;
    }
    schema["properties"]["setup"] = setup;
    auto& required = schema["required"];
    if (std::find(required.begin(), required.end(), "setup") == required.end()) required.push_back("setup");
    return schema;
}

/// The text of a schema. What holds no object is one line.
inline std::string text_of(Json const& value, std::string const& indent = "\n")
{
    if (!value.is_structured()) return value.dump();
    bool const nested = std::any_of(value.begin(), value.end(), [](Json const& v) { return v.is_object(); });
    std::string text;
    for (auto const& item : value.items())
        text += (text.empty() ? "" : nested ? "," : ", ") + (nested ? indent + " " : "") +
                (value.is_object() ? Json(item.key()).dump() + ": " : "") + text_of(item.value(), indent + " ");
    return (value.is_object() ? "{" : "[") + text + (nested ? indent : "") + (value.is_object() ? "}" : "]");
}

} // namespace json_schema
