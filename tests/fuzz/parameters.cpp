#include "plain_parameters.hpp"
#include "require.hpp"
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/energy.hpp>
#include <tilemesh/model/machine_file.hpp>
#include <tilemesh/model/network.hpp>

// Any text is a cost model, an energy model and a machine, as the plain reader reads it, or gives an Error of one line.
namespace {

using namespace tilemesh;

constexpr std::uint64_t any_word = 0xffffffffu, most_cycles = 1'000'000'000'000, most_prices = 100'000'000, most_energy = 4'000'000'000;
plain::ParameterKind const costs{"model",
                                 {{"clock", {"kHz", 1, 1'000'000'000}},
                                  {"exchange_cost", {"kind", 0, 1}},
                                  {"run", {"cycles", 0, most_cycles}},
                                  {"exchange", {"cycles", 0, most_cycles}},
                                  {"exchange_byte", {"millicycles", 0, most_prices}},
                                  {"sync", {"cycles", 0, most_cycles}},
                                  {"vote", {"cycles", 0, most_cycles}}},
                                 true, "millicycles", most_prices, true};
plain::ParameterKind const machines{"machine",
                                    {{"tiles", {"tiles", 1, any_word}},
                                     {"columns", {"tiles", 1, 65535}},
                                     {"rows", {"tiles", 1, 65535}},
                                     {"sram", {"bytes", 1, any_word}},
                                     {"code", {"bytes", 0, any_word}},
                                     {"workers", {"workers", 1, 1024}},
                                     {"clock", {"kHz", 1, 1'000'000'000}},
                                     {"instruction", {"millicycles", 1, 1'000'000}},
                                     {"run", {"cycles", 0, most_cycles}},
                                     {"barrier", {"cycles", 0, most_cycles}},
                                     {"vote", {"cycles", 0, most_cycles}},
                                     {"exchange_cost", {"kind", 0, 1}},
                                     {"exchange_start", {"cycles", 0, most_cycles}},
                                     {"exchange", {"bytes_a_cycle", 1, 4096}},
                                     {"host_link", {"bytes_a_us", 1, 1'000'000'000}}},
                                    true, "", 0, true};
plain::ParameterKind::Known const energy{"fJ", 0, most_energy};
plain::ParameterKind const energies{"energy", {{"sent_byte", energy}, {"capacity_byte", energy}, {"tile_cycle", energy}}, false, "fJ", most_energy};

void require_same(std::vector<ModelParameter> const& read, std::vector<plain::Parameter> const& expected)
{
    require(read.size() == expected.size(), "as many parameters as the plain reader finds");
    for (auto const& e : expected) {
        auto const p = std::find_if(read.begin(), read.end(), [&](ModelParameter const& r) { return r.name == e.name; });
        require(p != read.end() && p->value == e.value && p->unit == e.unit && p->source == e.source, "a parameter is as the plain reader reads it");
    }
}

void require_network(std::optional<Network> const& network, std::map<std::string, plain::Line> const& lines)
{
    require(network.has_value() == !lines.empty(), "there is a network if it has lines");
    for (auto const& [name, line] : lines) {
        auto const number = [&, &name = name, &line = line](char const* what, NetworkNumber const& n) {
            if (name != std::string("network.") + what) return;
            auto const rate = plain::rate(line.value, 0, 1'000'000'000'000);
            require(rate && n.value == rate->value && n.per == rate->per && n.source == line.source, "a number of a network is as the plain reader reads it");
        };
        auto const& n = *network;
        number("link", n.link), number("port_in", n.port_in), number("port_out", n.port_out), number("memory", n.memory), number("border", n.border);
        number("flit", n.flit), number("packet", n.packet), number("head", n.head), number("hop", n.hop), number("latency", n.latency);
        number("issue", n.issue), number("crossing", n.crossing), number("outstanding", n.outstanding);
        if (name == "network") require(n.torus == (line.value == "torus") && n.name == line.source, "a network has its kind and its name");
        if (name == "network.nodes")
            require(n.columns == (*plain::sides(line.value))[0] && n.rows == (*plain::sides(line.value))[1] && n.sources.nodes == line.source, "its nodes");
        if (name == "network.chip")
            require(n.chip_columns == (*plain::sides(line.value))[0] && n.chip_rows == (*plain::sides(line.value))[1] && n.sources.chip == line.source, "its chips");
        if (name == "network.memory_columns") {
            auto const all = *plain::columns(line.value);
            require(std::equal(all.begin(), all.end(), n.memory_columns.begin(), n.memory_columns.end()), "its memory columns");
        }
    }
}

/// A machine, and the prices that follow from it.
void check_machine(std::string const& text)
{
    auto expected = plain::parameters(text, machines);
    auto const of = [&](char const* name) -> std::uint64_t {
        if (std::find(expected->unknown.begin(), expected->unknown.end(), name) != expected->unknown.end()) return 0;
        return std::find_if(expected->parameters.begin(), expected->parameters.end(), [&](auto const& p) { return p.name == name; })->value;
    };
    if (expected && of("tiles") != 0 && of("columns") * of("rows") > of("tiles")) expected.reset();
    try {
        std::istringstream in(text);
        auto const machine = read_machine_file(in, "file");
        require(expected.has_value(), "what the plain reader refuses is refused");
        require(machine.name == expected->name && machine.numbers.size() == expected->parameters.size(), "name and numbers");
        for (auto const& e : expected->parameters) {
            auto const& n = machine.number(e.name);
            bool const unknown = std::find(expected->unknown.begin(), expected->unknown.end(), e.name) != expected->unknown.end();
            auto const rate = expected->rates.find(e.name);
            require(n.value.has_value() != unknown && (unknown || *n.value == e.value) && n.per == (rate == expected->rates.end() ? 1 : rate->second.per) &&
                        n.unit == e.unit && n.source == e.source,
                    "a number of a machine is as the plain reader reads it");
        }
        require_network(machine.network, expected->network);
        std::istringstream again(machine_file_text(machine));
        require(read_machine_file(again, "again") == machine, "a machine that is written is read back");
        if (machine.number("clock").value) (void)cost_model_of(machine);
    } catch (Error const& error) {
        require(!expected.has_value(), "what the plain reader reads is read");
        require_error(error.what());
    }
}

template <class Read, class Write>
void check(std::string const& text, plain::ParameterKind const& kind, Read const& read, Write const& write)
{
    auto const expected = plain::parameters(text, kind);
    try {
        std::istringstream in(text);
        auto const model = read(in, "file");
        require(expected.has_value(), "what the plain reader refuses is refused");
        require(model.name == expected->name, "the name is as the plain reader reads it");
        if constexpr (requires { model.parameters; }) {
            require_same(model.parameters, expected->parameters);
            require_network(model.network, expected->network);
            require(model.prices.size() + kind.known.size() == expected->parameters.size(), "operations have prices");
            for (auto const& price : model.prices)
                require(std::any_of(expected->parameters.begin(), expected->parameters.end(),
                                    [&](auto const& p) { return p.name == price.operation && p.value == price.millicycles; }),
                        "prices are those of the file");
        } else {
            require_same(model.events, expected->parameters);
        }
        if constexpr (!std::is_null_pointer_v<Write>) {
            std::ostringstream out;
            write(out, model);
            std::istringstream again(out.str());
            require(read(again, "again") == model, "a model that is written is read back");
        }
    } catch (Error const& error) {
        require(!expected.has_value(), "what the plain reader reads is read");
        require_error(error.what());
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    std::string const text(reinterpret_cast<char const*>(data), size);
    check(text, costs, read_cost_model, write_cost_model);
    check(text, energies, read_energy_model, nullptr);
    check_machine(text);
    return 0;
}
