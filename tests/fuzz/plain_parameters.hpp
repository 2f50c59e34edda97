#pragma once
#include "plain_text.hpp"

namespace plain {

struct Parameter {
    std::string name;
    std::uint64_t value;
    std::string unit, source;
};
struct Rate {
    std::uint64_t value, per;
};
/// A line of a network: the words of its value, and its source.
struct Line {
    std::string value, source;
};
struct Model {
    std::string name;
    std::vector<Parameter> parameters; ///< in the order of the file
    std::map<std::string, Line> network; ///< lines of a network, by name
    std::map<std::string, Rate> rates; ///< of a machine: numbers that are rates
    std::vector<std::string> unknown;  ///< of a machine: numbers that are unknown
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
    bool network = false; ///< may there be the lines of a network?
};

/// "32" or "32/3"
inline std::optional<Rate> rate(std::string const& word, std::uint64_t least, std::uint64_t most)
{
    auto const slash = word.find('/');
    auto const value = whole(word.substr(0, slash), 64), per = slash == word.npos ? std::optional<std::uint64_t>(1) : whole(word.substr(slash + 1), 64);
    if (!value || !per || *value < least || *value > most || *per < 1 || *per > 100'000'000) return {};
    return Rate{*value, *per};
}
/// "10x12"
inline std::optional<std::array<std::uint64_t, 2>> sides(std::string const& word)
{
    auto const x = word.find('x');
    if (x == word.npos) return {};
    auto const a = whole(word.substr(0, x), 64), b = whole(word.substr(x + 1), 64);
    if (!a || !b || *a < 1 || *b < 1 || *a > 1024 || *b > 1024) return {};
    return std::array{*a, *b};
}
inline std::optional<std::vector<std::uint64_t>> columns(std::string const& word)
{
    std::vector<std::uint64_t> all;
    std::string part;
    for (char const c : word + ',') {
        if (c != ',') {
            part += c;
            continue;
        }
        auto const n = whole(part, 64);
        if (!n || *n > 1023) return {};
        all.push_back(*n);
        part.clear();
    }
    return all;
}

inline bool is_of_network(std::string const& name) { return name == "network" || name.rfind("network.", 0) == 0; }
/// Is it a line of a network?
inline bool good_line(std::string const& name, std::string const& value, std::string const& unit)
{
    auto const most = [&](char const* asked, std::uint64_t largest) {
        auto const n = whole(value, 64);
        return unit == asked && n && *n <= largest;
    };
    if (name == "network") return unit == "kind" && (value == "mesh" || value == "torus");
    auto const what = name.substr(8);
    if (what == "nodes" || what == "chip") return unit == "nodes" && sides(value);
    if (what == "memory_columns") return unit == "columns" && columns(value);
    if (what == "link" || what == "port_in" || what == "port_out" || what == "memory" || what == "border") return unit == "bytes_a_cycle" && rate(value, 0, 4096);
    if (what == "flit" || what == "packet" || what == "head") return most("bytes", 1'000'000);
    if (what == "hop" || what == "issue") return most("cycles", 1'000'000);
    if (what == "latency" || what == "crossing") return most("cycles", 1'000'000'000'000);
    return what == "outstanding" && most("transfers", 1'000'000);
}
/// Do the lines make a network? None do, too.
inline bool good_network(std::map<std::string, Line> const& lines)
{
    if (lines.empty()) return true;
    for (auto const* needed : {"network", "network.nodes", "network.flit", "network.packet"})
        if (lines.count(needed) == 0) return false;
    if (*whole(lines.at("network.flit").value, 64) == 0 || *whole(lines.at("network.packet").value, 64) == 0) return false;
    if (lines.count("network.memory_columns") != 0) {
        auto const all = columns(lines.at("network.memory_columns").value).value();
        for (auto const column : all)
            if (column >= (*sides(lines.at("network.nodes").value))[0]) return false;
    }
    return true;
}

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
        if (kind.network && is_of_network(name)) {
            std::string const value = first_word(rest), unit = first_word(rest);
            if (!good_line(name, value, unit) || rest.empty() || rest.size() > 2048) return {};
            std::replace(rest.begin(), rest.end(), '\t', ' ');
            model.network[name] = {value, rest};
            continue;
        }
        auto const known = kind.known.find(name);
        ParameterKind::Known rule{kind.unit, 0, kind.most};
        if (known != kind.known.end()) {
            rule = known->second;
        } else if (kind.unit.empty()) {
            return {};
        } else {
            auto const all = words(rest);
            if (all.size() < 2 || all[1] != kind.unit || name.size() > 64) return {};
            for (char const c : name)
                if (c <= ' ' || c >= 0x7f) return {};
        }
        std::string const value = first_word(rest), unit = first_word(rest);
        auto found = whole(value, 64);
        if (kind.keyword == "machine" && value == "unknown") {
            found = rule.least;
            model.unknown.push_back(name);
        } else if (kind.keyword == "machine" && name == "exchange") {
            auto const r = rate(value, rule.least, rule.most);
            if (!r) return {};
            found = r->value;
            model.rates[name] = *r;
        } else if (name == "exchange_cost" && kind.keyword != "energy")
            found = value == "capacity" ? std::optional<std::uint64_t>(0) : value == "live" ? std::optional<std::uint64_t>(1) : std::nullopt;
        if (!found || *found < rule.least || *found > rule.most || unit != rule.unit || rest.empty() || rest.size() > 2048) return {};
        std::replace(rest.begin(), rest.end(), '\t', ' ');
        model.parameters.push_back({name, *found, unit, rest});
    }
    if (model.name.empty()) return {};
    if (kind.all_needed)
        for (auto const& [name, rule] : kind.known)
            if (seen[name] == 0) return {};
    if (!good_network(model.network)) return {};
    return model;
}

} // namespace plain
