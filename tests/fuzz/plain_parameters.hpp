#pragma once
#include "plain_text.hpp"
#include <algorithm>
#include <map>

namespace plain {

struct Parameter {
    std::string name;
    std::uint64_t value;
    std::string unit, source;
};
struct Model {
    std::string name;
    std::vector<Parameter> parameters; ///< in the order of the file
};

/// A file of parameters: the needed parameters with their units and their least and largest values; whether all of them must be there; the
/// unit and the largest value of the other parameters.
struct ParameterKind {
    struct Known {
        std::string unit;
        std::uint64_t least, most;
    };
    std::string keyword;
    std::map<std::string, Known> known;
    bool all_needed;
    std::string unit;
    std::uint64_t most;
};

inline std::string trimmed(std::string text)
{
    std::string const blank = " \t\r\v\f";
    while (!text.empty() && is_in(text.front(), blank)) text.erase(0, 1);
    while (!text.empty() && is_in(text.back(), blank)) text.pop_back();
    return text;
}
/// Takes the first word off a text, without blanks around it.
inline std::string first_word(std::string& text)
{
    auto const all = words(text);
    if (all.empty()) return "";
    text = trimmed(text.substr(all[0].size()));
    return all[0];
}

inline std::optional<Model> parameters(std::string const& text, ParameterKind const& kind)
{
    Model model;
    std::map<std::string, int> seen;
    for (auto const& line : lines(text)) {
        if (line.size() > 4096) return {};
        std::string rest = trimmed(line);
        if (rest.empty() || rest[0] == '#') continue;
        for (char const c : rest)
            if (c != '\t' && ((c >= 0 && c < ' ') || c == 0x7f)) return {};
        std::string const name = first_word(rest);
        if (model.name.empty()) {
            bool const fits = !rest.empty() && rest.size() <= 2048 && rest.find('\t') == rest.npos;
            if (name != kind.keyword || !fits) return {};
            model.name = rest;
            continue;
        }
        if (name == kind.keyword || seen[name]++ != 0) return {};
        auto const known = kind.known.find(name);
        ParameterKind::Known rule{kind.unit, 0, kind.most};
        if (known != kind.known.end()) {
            rule = known->second;
        } else {
            auto const all = words(rest);
            if (all.size() < 2 || all[1] != kind.unit || name.size() > 64) return {};
            for (char const c : name)
                if (c <= ' ' || c >= 0x7f) return {};
        }
        std::string const value = first_word(rest), unit = first_word(rest);
        auto found = whole(value, 64);
        if (name == "exchange_cost" && kind.keyword == "model")
            found = value == "capacity" ? std::optional<std::uint64_t>(0) : value == "live" ? std::optional<std::uint64_t>(1) : std::nullopt;
        if (!found || *found < rule.least || *found > rule.most || unit != rule.unit || rest.empty() || rest.size() > 2048) return {};
        std::replace(rest.begin(), rest.end(), '\t', ' ');
        model.parameters.push_back({name, *found, unit, rest});
    }
    if (model.name.empty()) return {};
    if (kind.all_needed)
        for (auto const& [name, rule] : kind.known)
            if (seen[name] == 0) return {};
    return model;
}

} // namespace plain
