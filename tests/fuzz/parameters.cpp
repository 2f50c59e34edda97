#include "plain_parameters.hpp"
#include "require.hpp"
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/energy.hpp>

// Any text is a cost model and an energy model, as the plain reader reads it, or gives an Error of one line.
namespace {

using namespace tilemesh;

plain::ParameterKind const costs{"model",
                                 {{"clock", {"kHz", 1, 1'000'000'000}},
                                  {"exchange_cost", {"kind", 0, 1}},
                                  {"run", {"cycles", 0, 1'000'000'000'000}},
                                  {"exchange", {"cycles", 0, 1'000'000'000'000}},
                                  {"exchange_byte", {"millicycles", 0, 100'000'000}},
                                  {"sync", {"cycles", 0, 1'000'000'000'000}},
                                  {"vote", {"cycles", 0, 1'000'000'000'000}}},
                                 true,
                                 "millicycles",
                                 100'000'000};
plain::ParameterKind const energies{"energy",
                                    {{"sent_byte", {"fJ", 0, 4'000'000'000}},
                                     {"capacity_byte", {"fJ", 0, 4'000'000'000}},
                                     {"tile_cycle", {"fJ", 0, 4'000'000'000}}},
                                    false,
                                    "fJ",
                                    4'000'000'000};

void require_same(std::vector<ModelParameter> const& read, std::vector<plain::Parameter> const& expected)
{
    require(read.size() == expected.size(), "as many parameters as the plain reader finds");
    for (auto const& e : expected) {
        auto const p = std::find_if(read.begin(), read.end(), [&](ModelParameter const& r) { return r.name == e.name; });
        require(p != read.end() && p->value == e.value && p->unit == e.unit && p->source == e.source,
                "a parameter is as the plain reader reads it");
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
            require(model.prices.size() + kind.known.size() == expected->parameters.size(), "operations have prices");
            for (auto const& price : model.prices)
                require(std::any_of(expected->parameters.begin(), expected->parameters.end(),
                                    [&](auto const& p) { return p.name == price.operation && p.value == price.millicycles; }),
                        "prices are those of the file");
        } else {
            require_same(model.events, expected->parameters);
        }
        std::ostringstream out;
        write(out, model);
        std::istringstream again(out.str());
        require(read(again, "again") == model, "a model that is written is read back");
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
    check(text, energies, read_energy_model, write_energy_model);
    return 0;
}
