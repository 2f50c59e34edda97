#pragma once
#include <algorithm>
#include <array>
#include <tilemesh/error.hpp>
#include <tilemesh/model/network_lines.hpp>
#include <tilemesh/number_text.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace model_detail {

inline constexpr std::string_view network_prefix = "network.";

struct NetworkLine {
    char const* name;
    NetworkNumber Network::*number;
    char const* unit;
    std::uint64_t most;
};
/// The lines of numbers. The limits are those of time_of.
inline constexpr std::array<NetworkLine, 13> network_numbers = {{{"link", &Network::link, "bytes_a_cycle", 4096},
                                                                 {"port_in", &Network::port_in, "bytes_a_cycle", 4096},
                                                                 {"port_out", &Network::port_out, "bytes_a_cycle", 4096},
                                                                 {"memory", &Network::memory, "bytes_a_cycle", 4096},
                                                                 {"border", &Network::border, "bytes_a_cycle", 4096},
                                                                 {"flit", &Network::flit, "bytes", 1'000'000},
                                                                 {"packet", &Network::packet, "bytes", 1'000'000},
                                                                 {"head", &Network::head, "bytes", 1'000'000},
                                                                 {"hop", &Network::hop, "cycles", 1'000'000},
                                                                 {"latency", &Network::latency, "cycles", 1'000'000'000'000},
                                                                 {"issue", &Network::issue, "cycles", 1'000'000},
                                                                 {"crossing", &Network::crossing, "cycles", 1'000'000'000'000},
                                                                 {"outstanding", &Network::outstanding, "transfers", 1'000'000}}};
inline constexpr std::uint64_t most_network_side = 1024;

TILEMESH_HOST bool is_network_name(std::string_view name) noexcept
{
    return name == "network" || name.substr(0, network_prefix.size()) == network_prefix;
}

TILEMESH_HOST std::vector<ParameterRule> network_rules()
{
    std::vector<ParameterRule> rules;
    auto const add = [&](std::string const& name, char const* unit, std::uint64_t most) { rules.push_back({name, unit, 0, most, true}); };
    std::string const prefix(network_prefix);
    add("network", "kind", 1);
    add(prefix + "nodes", "nodes", most_network_side);
    add(prefix + "memory_columns", "columns", most_network_side - 1);
    for (auto const& line : network_numbers) add(prefix + line.name, line.unit, line.most);
    add(prefix + "chip", "nodes", most_network_side);
    return rules;
}

TILEMESH_HOST std::optional<std::uint64_t> number_within(std::string_view text, std::uint64_t least, std::uint64_t most)
{
    auto const value = number_of<std::uint64_t>(text);
    return value && *value >= least && *value <= most ? value : std::nullopt;
}

TILEMESH_HOST std::optional<NetworkNumber> rate_of(std::string_view text, std::uint64_t most)
{
    auto const slash = std::min(text.find('/'), text.size());
    auto const value = number_within(text.substr(0, slash), 0, most);
    auto const per = slash == text.size() ? std::uint64_t{1} : number_within(text.substr(slash + 1), 1, 100'000'000);
    if (!value || !per) return {};
    return NetworkNumber{*value, {}, *per};
}

TILEMESH_HOST std::string rate_text(std::uint64_t value, std::uint64_t per)
{
    return std::to_string(value) + (per == 1 ? "" : "/" + std::to_string(per));
}

TILEMESH_HOST std::string network_lines(Network const& n)
{
    std::string text;
    auto const by = [](std::uint32_t a, std::uint32_t b) { return std::to_string(a) + "x" + std::to_string(b); };
    auto const add = [&](std::string const& name, std::string const& value, char const* unit, std::string const& source) {
        if (!fits_a_line(source))
            throw Error("network \"" + shown(n.name) + "\" cannot be written (" + (name == "network" ? "its name" : "the source of " + name) +
                        " is not one line of 1 to " + std::to_string(most_text_bytes) + " bytes); give it one");
        text += parameter_line(name, value, unit, source);
    };
    std::string const prefix(network_prefix);
    add("network", n.torus ? "torus" : "mesh", "kind", n.name);
    add(prefix + "nodes", by(n.columns, n.rows), "nodes", n.sources.nodes);
    std::string columns;
    for (auto const column : n.memory_columns) columns += (columns.empty() ? "" : ",") + std::to_string(column);
    if (!columns.empty()) add(prefix + "memory_columns", columns, "columns", n.sources.memory_columns);
    for (auto const& line : network_numbers) {
        auto const& number = n.*line.number;
        if (number == NetworkNumber{}) continue; // it is not said
        bool const rate = std::string_view(line.unit) == "bytes_a_cycle";
        if (number.value > line.most || number.per == 0 || (!rate && number.per != 1) || number.per > 100'000'000)
            throw Error("network \"" + shown(n.name) + "\" cannot be written (" + line.name + " is " + rate_text(number.value, number.per) +
                        ", and a file holds at most " + std::to_string(line.most) + " " + line.unit + "); give it a number that time_of takes");
        add(prefix + line.name, rate_text(number.value, number.per), line.unit, number.source);
    }
    if (n.chip_columns != 0 || n.chip_rows != 0) add(prefix + "chip", by(n.chip_columns, n.chip_rows), "nodes", n.sources.chip);
    return text;
}

TILEMESH_HOST std::vector<std::vector<std::string>> network_rows(Network const& n)
{
    std::vector<std::vector<std::string>> rows;
    auto const by = [](std::uint32_t a, std::uint32_t b) { return std::to_string(a) + "x" + std::to_string(b); };
    std::string const prefix(network_prefix);
    rows.push_back({prefix + "nodes", by(n.columns, n.rows) + (n.torus ? ", a torus" : ", a mesh"), "nodes", n.sources.nodes});
    for (auto const& line : network_numbers)
        if (auto const& number = n.*line.number; !(number == NetworkNumber{}))
            rows.push_back({prefix + line.name, rate_text(number.value, number.per), line.unit, number.source});
    if (n.chip_columns != 0) rows.push_back({prefix + "chip", by(n.chip_columns, n.chip_rows), "nodes", n.sources.chip});
    return rows;
}

TILEMESH_HOST std::optional<std::uint64_t> NetworkReader::word(std::string_view name, std::string_view text, Refuse const& refuse)
{
    any_ = true;
    if (name == "network") {
        if (text != "mesh" && text != "torus") refuse("has no kind of network", "network is \"" + shown(text) + "\"", "write mesh or torus");
        return text == "torus" ? 1 : 0;
    }
    auto const what = name.substr(network_prefix.size());
    auto const bad = [&](char const* todo) { refuse("has no value of " + std::string(name), "it is \"" + shown(text) + "\"", todo); };
    if (what == "nodes" || what == "chip") {
        auto const x = std::min(text.find('x'), text.size());
        auto const width = number_within(text.substr(0, x), 1, most_network_side);
        auto const height = x == text.size() ? std::nullopt : number_within(text.substr(x + 1), 1, most_network_side);
        if (!width || !height) bad("write COLUMNSxROWS, each from 1 to 1024, as 10x12");
        auto& columns = what == "nodes" ? network_.columns : network_.chip_columns;
        auto& rows = what == "nodes" ? network_.rows : network_.chip_rows;
        columns = static_cast<std::uint32_t>(width.value_or(1));
        rows = static_cast<std::uint32_t>(height.value_or(1));
        return columns;
    }
    if (what == "memory_columns") {
        network_.memory_columns.clear();
        for (auto rest = text;;) {
            auto const comma = std::min(rest.find(','), rest.size());
            auto const column = number_within(rest.substr(0, comma), 0, most_network_side - 1);
            if (!column) bad("write columns from 0 to 1023 with commas between them, as 0,5");
            network_.memory_columns.push_back(static_cast<std::uint32_t>(column.value_or(0)));
            if (comma == rest.size()) break;
            rest.remove_prefix(comma + 1);
        }
        return network_.memory_columns.front();
    }
    auto const line = std::find_if(network_numbers.begin(), network_numbers.end(), [&](NetworkLine const& l) { return what == l.name; });
    if (line == network_numbers.end() || std::string_view(line->unit) != "bytes_a_cycle") return {};
    auto const rate = rate_of(text, line->most);
    if (!rate) bad("write bytes a cycle, from 0 to 4096, or BYTES/CYCLES, as 32 or 147/10");
    per_ = rate ? rate->per : 1;
    return rate ? rate->value : 0;
}

TILEMESH_HOST void NetworkReader::set(ModelParameter const& p)
{
    auto const per = std::exchange(per_, 1);
    if (p.name == "network") {
        network_.torus = p.value != 0;
        network_.name = p.source;
        named_ = true;
        return;
    }
    auto const what = std::string_view(p.name).substr(network_prefix.size());
    any_ = true;
    if (what == "nodes") {
        network_.sources.nodes = p.source;
        sized_ = true;
    } else if (what == "chip") {
        network_.sources.chip = p.source;
    } else if (what == "memory_columns") {
        network_.sources.memory_columns = p.source;
    } else {
        for (auto const& line : network_numbers)
            if (what == line.name) network_.*line.number = {p.value, p.source, per};
    }
}

TILEMESH_HOST std::optional<Network> NetworkReader::take(std::string const& file_name) const
{
    if (!any_) return {};
    auto const missing = [&](char const* name, char const* line) {
        throw Error(shown(file_name) + " has lines of a network without " + name + " (it is not known what they belong to); add \"" + line + "\"");
    };
    if (!named_) missing("\"network\"", "network mesh kind NAME");
    if (!sized_) missing("its nodes", "network.nodes COLUMNSxROWS nodes SOURCE");
    if (network_.flit.value == 0 || network_.packet.value == 0)
        missing(network_.flit.value == 0 ? "its flits" : "its packets",
                network_.flit.value == 0 ? "network.flit BYTES bytes SOURCE" : "network.packet BYTES bytes SOURCE");
    for (auto const column : network_.memory_columns)
        if (column >= network_.columns)
            throw Error(shown(file_name) + " has a memory column " + std::to_string(column) + " (the network has " +
                        std::to_string(network_.columns) + " columns, from 0); correct network.memory_columns");
    return network_;
}

}}} // namespace tilemesh::model_detail
