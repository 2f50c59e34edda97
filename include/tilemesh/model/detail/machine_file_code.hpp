#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/machine_file.hpp>
#include <tilemesh/model/network_lines.hpp>
#include <tilemesh/model/parameter_file.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {
namespace model_detail {

inline constexpr std::string_view unknown_word = "unknown";

TILEMESH_HOST std::vector<ParameterRule> machine_rules()
{
    constexpr std::uint64_t word = 0xffffffffu;
    return {{"tiles", "tiles", 1, word},
            {"columns", "tiles", 1, 65535},
            {"rows", "tiles", 1, 65535},
            {"sram", "bytes", 1, word},
            {"code", "bytes", 0, word},
            {"workers", "workers", 1, 1024},
            {"clock", "kHz", 1, most_clock_khz},
            {"instruction", "millicycles", 1, 1'000'000},
            {"run", "cycles", 0, most_cycles},
            {"barrier", "cycles", 0, most_cycles},
            {"vote", "cycles", 0, most_cycles},
            {"exchange_cost", "kind", 0, exchange_cost_names.size() - 1},
            {"exchange_start", "cycles", 0, most_cycles},
            {"exchange", "bytes_a_cycle", 1, 4096},
            {"host_link", "bytes_a_us", 1, 1'000'000'000}};
}
TILEMESH_HOST bool is_rate(ParameterRule const& rule)
{
    return rule.unit == "bytes_a_cycle";
}
/// The words for the value of a number, as in a file.
TILEMESH_HOST std::string value_text(MachineNumber const& n)
{
    if (!n.value) return std::string(unknown_word);
    if (n.unit == "kind") return *n.value < exchange_cost_names.size() ? std::string(exchange_cost_names[static_cast<std::size_t>(*n.value)]) : "?";
    return rate_text(*n.value, n.per);
}

/// The value of a word that is not a whole number: `unknown`, a rate, a kind. `unknown` is what such a number gets; `set` must look at the
/// word again, because the reader of files knows numbers alone.
struct MachineWord {
    bool unknown = false;
    std::uint64_t value = 0, per = 1;
};
TILEMESH_HOST std::optional<MachineWord> machine_word(ParameterRule const& rule, std::string_view text, NetworkReader::Refuse const& refuse)
{
    if (text == unknown_word) return MachineWord{true, rule.least, 1};
    if (rule.unit == "kind") {
        auto const kind = std::find(exchange_cost_names.begin(), exchange_cost_names.end(), text);
        if (kind == exchange_cost_names.end())
            refuse("has no kind of exchange", rule.name + " is \"" + shown(text) + "\"", "write capacity, live or unknown");
        return MachineWord{false, static_cast<std::uint64_t>(kind - exchange_cost_names.begin()), 1};
    }
    if (!is_rate(rule)) return {};
    auto const rate = rate_of(text, rule.most);
    if (!rate || rate->value < rule.least)
        refuse("has no value of " + rule.name, "it is \"" + shown(text) + "\"",
               "write unknown, bytes a cycle from 1 to 4096, or BYTES/CYCLES, as 4 or 147/10");
    return rate ? MachineWord{false, rate->value, rate->per} : MachineWord{};
}

/// Throws `Error` if the grid has more tiles than the machine.
TILEMESH_HOST void check_grid(MachineFile const& machine, std::string const& where)
{
    auto const grid = grid_of(machine);
    auto const& tiles = machine.number("tiles").value;
    if (grid && tiles && std::uint64_t{grid->width} * grid->height > *tiles)
        throw Error(where + " has a grid of " + std::to_string(grid->width) + " x " + std::to_string(grid->height) + " tiles (machine " +
                    shown(machine.name) + " has " + std::to_string(*tiles) + "); correct columns, rows or tiles");
}

/// How a price that is computed from numbers is known: as its weakest one. "arithmetic", "fitted" or "guess" begins its source.
TILEMESH_HOST char const* weakest_word(PriceKind a, PriceKind b, PriceKind c)
{
    auto const weakest = std::max({a, b, c});
    return weakest == PriceKind::guessed ? "guess" : weakest == PriceKind::fitted ? "fitted" : "arithmetic";
}

} // namespace model_detail

TILEMESH_HOST MachineNumber const& MachineFile::number(std::string_view of) const
{
    auto const at = std::find_if(numbers.begin(), numbers.end(), [&](MachineNumber const& n) { return n.name == of; });
    if (at != numbers.end()) return *at;
    std::string all;
    for (auto const& n : numbers) all += (all.empty() ? "" : ", ") + n.name;
    throw Error("a machine has no number \"" + model_detail::shown(of) + "\" (machine " + model_detail::shown(name) + " has " +
                (all.empty() ? "none" : all) + "); name one of these");
}

TILEMESH_HOST std::uint64_t MachineFile::need(std::string_view of) const
{
    auto const& n = number(of);
    if (!n.value)
        throw Error("machine " + model_detail::shown(name) + " cannot be used (its " + n.name + " is unknown: " + model_detail::shown(n.source) +
                    "); write a number of your own into the machine's file, with its source");
    return *n.value;
}

TILEMESH_HOST std::vector<std::string> MachineFile::unknown() const
{
    std::vector<std::string> out;
    for (auto const& n : numbers)
        if (!n.value) out.push_back(n.name);
    return out;
}

TILEMESH_HOST void set_number(MachineFile& machine, std::string_view name, std::string_view value, std::string source)
{
    namespace d = model_detail;
    auto const& known = machine.number(name); // throws
    auto const rules = d::machine_rules();
    auto const& rule = rules.at(d::parameter_index(rules, known.name));
    auto const word = d::machine_word(rule, value, [&](std::string const& problem, std::string const& why, std::string const& todo) {
        throw Error("machine " + d::shown(machine.name) + " " + problem + " (" + why + "); " + todo);
    });
    auto const number = word ? std::optional<std::uint64_t>(word->value) : d::number_within(value, rule.least, rule.most);
    if (!number)
        throw Error("machine " + d::shown(machine.name) + " has no " + rule.name + " \"" + d::shown(value) + "\" (it goes " + d::range_text(rule) +
                    " " + std::string(rule.unit) + "); give it a whole number in this range, or unknown");
    d::expect_source(rule.name, source);
    auto changed = machine;
    auto& n = changed.numbers[static_cast<std::size_t>(&known - machine.numbers.data())];
    n.value = word && word->unknown ? std::nullopt : number;
    n.per = word ? word->per : 1;
    n.source = std::move(source);
    d::check_grid(changed, "a machine that");
    machine = std::move(changed);
}

TILEMESH_HOST MachineFile read_machine_file(std::istream& in, std::string const& file_name)
{
    namespace d = model_detail;
    auto const fixed = d::machine_rules(), of_network = d::network_rules();
    auto rules = fixed;
    rules.insert(rules.end(), of_network.begin(), of_network.end());
    d::NetworkReader network;
    std::map<std::string, MachineNumber> read;
    d::MachineWord last; // of the line that is being read
    d::ParameterFile file{in, file_name, {"machine", "machine", "a machine", "", 0}, rules};
    file.read(
        [&](std::size_t at, std::string_view text, auto const& refuse) -> std::optional<std::uint64_t> {
            last = {};
            if (at >= fixed.size()) return network.word(rules[at].name, text, refuse);
            auto const word = d::machine_word(rules[at], text, refuse);
            if (!word) return {};
            last = *word;
            return word->value;
        },
        [&](ModelParameter const& p) {
            if (d::is_network_name(p.name)) return network.set(p);
            read.emplace(p.name,
                         MachineNumber{p.name, last.unknown ? std::nullopt : std::optional<std::uint64_t>(p.value), last.per, p.unit, p.source});
        });
    file.expect_all();
    MachineFile machine{file.name(), {}, network.take(file_name)};
    for (auto const& rule : fixed) machine.numbers.push_back(std::move(read.at(rule.name)));
    d::check_grid(machine, d::shown(file_name));
    return machine;
}

TILEMESH_HOST std::string machine_file_text(MachineFile const& machine)
{
    namespace d = model_detail;
    if (!d::fits_a_line(machine.name))
        throw Error("a machine cannot be written (its name is not one line of 1 to " + std::to_string(d::most_text_bytes) + " bytes); name it");
    std::string text = "# name value unit source; a value may be unknown\nmachine " + machine.name + '\n';
    for (auto const& rule : d::machine_rules()) {
        auto const& n = machine.number(rule.name);
        d::expect_source(n.name, n.source);
        if (n.value) d::expect_in_range(rule, *n.value);
        text += d::parameter_line(n.name, d::value_text(n), rule.unit, n.source);
    }
    if (machine.network) text += d::network_lines(*machine.network);
    return text;
}

TILEMESH_HOST MachineSize size_of(MachineFile const& machine)
{
    auto const word = [&](std::string_view name) { return static_cast<std::uint32_t>(machine.need(name)); }; // the rules bound it
    return {machine.name.c_str(), word("tiles"), word("sram"), static_cast<std::uint32_t>(machine.number("code").value.value_or(0)), word("workers"),
            word("clock")};
}

TILEMESH_HOST std::optional<Grid> grid_of(MachineFile const& machine)
{
    auto const &columns = machine.number("columns").value, &rows = machine.number("rows").value;
    if (!columns || !rows) return {};
    return Grid{static_cast<std::uint32_t>(*columns), static_cast<std::uint32_t>(*rows)};
}

TILEMESH_HOST CostModel cost_model_of(MachineFile const& machine)
{
    namespace d = model_detail;
    auto model = mk2();
    std::string left_out;
    struct Known {
        std::uint64_t value;
        std::string source;
    };
    auto const known = [&](std::string_view name, std::uint64_t otherwise) -> Known {
        auto const& n = machine.number(name);
        if (n.value) return {*n.value, n.source};
        left_out += (left_out.empty() ? "" : ", ") + n.name;
        return {otherwise, "guess: unknown, and left out of every time (" + n.source.substr(0, 1000) + ")"};
    };
    auto const set = [&](char const* parameter, std::string_view name) {
        auto const n = known(name, 0);
        set_parameter(model, parameter, n.value, n.source);
    };
    set_parameter(model, "clock", machine.need("clock"), machine.number("clock").source);
    set("run", "run");
    set("sync", "barrier");
    set("vote", "vote");
    set("exchange", "exchange_start");
    auto const cost = known("exchange_cost", static_cast<std::uint64_t>(ExchangeCost::live));
    set_parameter(model, "exchange_cost", cost.value, cost.source);
    model.network = machine.network;
    if (auto const& rate = machine.number("exchange"); machine.network) { // the network prices its bytes
        set_parameter(model, "exchange_byte", 0, rate.source);
    } else {
        auto const bytes = known("exchange", 0);
        auto const millicycles = bytes.value == 0 ? 0 : (1000 * rate.per + bytes.value / 2) / bytes.value;
        set_parameter(model, "exchange_byte", millicycles,
                      bytes.source + (bytes.value != 0 && millicycles * bytes.value != 1000 * rate.per ? "; rounded" : ""));
    }

    auto const instruction = known("instruction", 0);
    auto const workers = known("workers", 0);
    constexpr std::array<std::string_view, 6> of_all_workers = {"pair", "pixel", "moving_pair", "moving_depth", "splat_motions", "row"};
    for (auto const& price : mk2().prices) {
        auto const mine =
            std::find_if(model.parameters.begin(), model.parameters.end(), [&](ModelParameter const& p) { return p.name == price.operation; });
        if (price.operation == host_byte) {
            auto const link = known("host_link", 0);
            set_price(model, host_byte, link.value == 0 ? 0 : (model.clock_khz + link.value - 1) / link.value, link.source);
            continue;
        }
        bool const all = std::find(of_all_workers.begin(), of_all_workers.end(), price.operation) != of_all_workers.end();
        auto const times = all ? instruction.value * Mk2::workers : instruction.value * workers.value; // of mk2's, over 1,000 and its workers
        constexpr std::uint64_t of_mk2 = std::uint64_t{1000} * Mk2::workers;
        auto const kind = kind_of_source(mine->source),
            weakest = std::max({kind, kind_of_source(instruction.source), kind_of_source(workers.source)});
        std::string source = mine->source;
        if (times != of_mk2 || weakest != kind)
            source =
                std::string(d::weakest_word(kind, kind_of_source(instruction.source), kind_of_source(workers.source))) + ": mk2's instructions, " +
                     std::to_string(instruction.value) + " millicycles each" + (all ? "" : " times " + std::to_string(workers.value) + " workers");
        set_price(model, price.operation, (price.millicycles * times + of_mk2 / 2) / of_mk2, source);
    }
    model.name = machine.name + (left_out.empty() ? "" : ", at least: without " + left_out);
    return model;
}

TILEMESH_HOST std::string machine_text(MachineFile const& machine)
{
    std::array<std::size_t, price_kind_names.size()> of_kind{};
    std::string guesses, unknown;
    for (auto const& n : machine.numbers) {
        auto& list = n.value ? guesses : unknown;
        if (n.value) ++of_kind[static_cast<std::size_t>(n.kind())];
        if (!n.value || n.kind() == PriceKind::guessed) list += (list.empty() ? "" : ", ") + n.name;
    }
    std::string text = "machine " + machine.name + ": ";
    for (std::size_t k = 0; k + 1 < of_kind.size(); ++k)
        if (of_kind[k] != 0) text += std::to_string(of_kind[k]) + " numbers " + std::string(price_kind_names[k]) + "; ";
    return text + "guessed: " + (guesses.empty() ? "none" : guesses) + "; unknown: " + (unknown.empty() ? "none" : unknown);
}

}} // namespace tilemesh
