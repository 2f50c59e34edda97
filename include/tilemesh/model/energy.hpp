#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <istream>
#include <limits>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <tilemesh/model/parameter_file.hpp>
#include <utility>
#include <vector>

// What a run takes of energy: power x time, as the paper measures, or events at so many femtojoules each. No energy of an event is
// known here: whoever has one says it, with where it is from.
namespace tilemesh {

/// Joules of a machine that draws `watts` for as long as `cycles` take on the model's clock. Throws `Error` for a clock of
/// 0 kHz and for watts that are no number from 0.
inline double joules_of_power(CostModel const& model, std::uint64_t cycles, double watts)
{
    if (model.clock_khz == 0 || !(watts >= 0) || std::isinf(watts))
        throw Error("energy cannot be computed (model \"" + model_detail::shown(model.name) + "\" has a clock of " +
                    std::to_string(model.clock_khz) + " kHz, and the power is " + std::to_string(watts) +
                    " W); give it a clock above 0 kHz and a finite power that is not negative");
    return watts * (milliseconds(model, cycles) / 1000);
}

/// What energy is counted for: the operations of kernels, in their order (a kernel of several workers counts what takes its time, the
/// slowest worker's share times the workers: Composite's pairs are above those evaluated), and
///   sent_byte      a byte of a message or its head over one hop; where the exchange is paid for as `live`
///   capacity_byte  a byte that compile-time copies move, live or not; where it is paid for as `capacity`
///   tile_cycle     a cycle of a tile, whatever it does: leakage, and what its clock takes
inline constexpr std::uint32_t energy_events = operation_kinds + 3, sent_byte_event = operation_kinds,
                               capacity_byte_event = operation_kinds + 1, tile_cycle_event = operation_kinds + 2;
constexpr char const* energy_event_name(std::uint32_t event) noexcept
{
    constexpr char const* others[] = {"sent_byte", "capacity_byte", "tile_cycle"};
    return event < operation_kinds ? name_of(static_cast<Operation>(event)) : others[event - operation_kinds];
}

/// Femtojoules that one event may have: 1,000 are a picojoule, and this is 4 microjoules. A product with half of a 64-bit
/// count fits into 64 bits.
inline constexpr std::uint64_t most_femtojoules = 4'000'000'000;

/// What each event takes. Nothing is set at first, and there are no defaults: set_energy.
struct EnergyModel {
    std::string name;
    std::array<std::optional<Parameter>, energy_events> events{};
    friend bool operator==(EnergyModel const&, EnergyModel const&) = default;
};

namespace model_detail {
inline std::vector<ParameterRule> energy_rules()
{
    std::vector<ParameterRule> rules;
    for (std::uint32_t i = 0; i < energy_events; ++i) rules.push_back({energy_event_name(i), "fJ", 0, most_femtojoules});
    return rules;
}

/// An exact sum of femtojoules, in 128 bits.
struct Femtojoules {
    std::uint64_t high = 0, low = 0;
    void add(std::uint64_t n) noexcept
    {
        low += n;
        high += low < n ? 1 : 0;
    }
    void add(std::uint64_t count, std::uint64_t each) noexcept // each < 2^32
    {
        add((count & 0xffffffffu) * each);
        std::uint64_t const upper = (count >> 32) * each;
        add(upper << 32);
        high += upper >> 32;
    }
    double joules() const noexcept
    {
        constexpr double two_to_64 = 18446744073709551616.0; // a product with it is exact
        return (static_cast<double>(high) * two_to_64 + static_cast<double>(low)) / 1e15;
    }
};
} // namespace model_detail

/// Says what one event takes. Throws `Error` for a name that is none, a value above `most_femtojoules`, and a source that is
/// not one line of text.
inline void set_energy(EnergyModel& model, std::string_view event, std::uint64_t femtojoules, std::string source)
{
    namespace d = model_detail;
    auto const rules = d::energy_rules();
    auto const rule = std::find_if(rules.begin(), rules.end(), [&](d::ParameterRule const& r) { return r.name == event; });
    if (rule == rules.end()) {
        std::string all;
        for (auto const& r : rules) all += (all.empty() ? "" : ", ") + std::string(r.name);
        throw Error("an energy model has no event \"" + d::shown(event) + "\" (it has " + all + "); name one of these");
    }
    d::expect_in_range(*rule, femtojoules);
    d::expect_source(rule->name, source);
    model.events[static_cast<std::size_t>(rule - rules.begin())] =
        Parameter{std::string(rule->name), femtojoules, std::string(rule->unit), std::move(source)};
}

/// What a run takes: joules of each kind of event, of each step of the program, and of each tile.
struct Energy {
    std::array<std::uint64_t, energy_events> events{}; ///< exact counts
    std::array<double, energy_events> joules_of_kind{};
    std::vector<double> joules_of_step, joules_of_tile;
    double joules = 0;
};

/// Applies an energy model to a run. Events are counted exactly and added up in integers; a number becomes joules once, at the
/// end. What compile-time copies move is charged to the tile that sends; tile_cycle, to every tile for all of the run's
/// modelled cycles.
///
/// Throws `Error` for an event that occurs and has no energy, for an energy above `most_femtojoules` (set by hand, past
/// set_energy), for a trace of another grid, for what model_cost refuses, and for counts that pass 64 bits. Cost: linear in the trace.
inline Energy energy_of(EnergyModel const& energy, CostModel const& model, Trace const& trace, Grid grid)
{
    using model_detail::Femtojoules;
    model_detail::check_trace(trace, grid);
    auto const rules = model_detail::energy_rules();
    for (std::uint32_t event = 0; event < energy_events; ++event) // Femtojoules::add takes less than 2^32
        if (energy.events[event]) model_detail::expect_in_range(rules[event], energy.events[event]->value);
    auto const cost = model_cost(model, trace, grid);
    Energy out;
    std::array<Femtojoules, energy_events> kinds;
    std::vector<Femtojoules> steps(trace.kernels.size()), tiles(grid.size());
    Femtojoules all, each_tile; // of all that occurs on every tile alike

    auto const occurs = [&](std::uint32_t event, std::uint64_t count, std::uint64_t times, std::size_t superstep) {
        auto const most = std::numeric_limits<std::uint64_t>::max();
        if (times != 0 && count > (most - out.events[event]) / times)
            throw Error("energy cannot be computed (more than 2^64 of event " + std::string(energy_event_name(event)) +
                        "); model a shorter run");
        out.events[event] += count * times;
        auto const& parameter = energy.events[event];
        if (count != 0 && times != 0 && !parameter)
            throw Error("energy model \"" + model_detail::shown(energy.name) + "\" cannot be applied (event " +
                        energy_event_name(event) + " occurs, first in superstep " + std::to_string(superstep) +
                        ", and its energy is not set); set it, and say where it is from");
        return parameter ? parameter->value : 0;
    };
    for (std::size_t i = 0; i < trace.supersteps.size(); ++i) {
        auto const& s = trace.supersteps[i];
        for (auto const& t : s.tiles) {
            auto const charge = [&](std::uint32_t event, std::uint64_t count) {
                auto const each = occurs(event, count, 1, i);
                kinds[event].add(count, each);
                steps[s.step].add(count, each);
                tiles[t.tile].add(count, each);
                all.add(count, each);
            };
            for (std::uint32_t o = 0; o < operation_kinds; ++o) charge(o, t.operations.count[o]);
            if (model.exchange_cost == ExchangeCost::live) charge(sent_byte_event, model_detail::all_sent(t));
        }
        auto const charge_all = [&](std::uint32_t event, std::uint64_t count) {
            auto const each = occurs(event, count, grid.size(), i);
            each_tile.add(count, each);
            kinds[event].add(count * grid.size(), each);
            steps[s.step].add(count * grid.size(), each);
            all.add(count * grid.size(), each);
        };
        if (model.exchange_cost == ExchangeCost::capacity)
            charge_all(capacity_byte_event, std::uint64_t{4} * s.capacity_bytes);
        charge_all(tile_cycle_event, cost.supersteps[i].total());
    }
    for (std::uint32_t event = 0; event < energy_events; ++event) out.joules_of_kind[event] = kinds[event].joules();
    for (auto const& s : steps) out.joules_of_step.push_back(s.joules());
    for (auto& t : tiles) {
        t.add(each_tile.low);
        t.high += each_tile.high;
        out.joules_of_tile.push_back(t.joules());
    }
    out.joules = all.joules();
    return out;
}

/// Writes what is set as text: `#` comments, `energy NAME`, then one event a line, `name value unit source`, to be read by
/// read_energy_model, which gives back the same model. Throws `Error` for a model whose name is not one line of text, and for a
/// parameter that set_energy would not have made.
inline void write_energy_model(std::ostream& out, EnergyModel const& model)
{
    namespace d = model_detail;
    if (!d::fits_a_line(model.name))
        throw Error("an energy model cannot be written (its name is not one line of 1 to " + std::to_string(d::most_text_bytes) +
                    " bytes, without blanks around it); name it");
    EnergyModel same;
    same.name = model.name;
    for (auto const& p : model.events)
        if (p) set_energy(same, p->name, p->value, p->source);
    if (!(same == model))
        throw Error("energy model \"" + d::shown(model.name) +
                    "\" cannot be written (an event has another name or unit than its place); set each with set_energy");
    std::string text = "# name value unit source; 1,000 fJ are 1 pJ; an event that is not here has no energy set\n";
    text += "energy " + model.name + '\n';
    for (auto const& p : model.events)
        if (p) text += d::parameter_line(p->name, std::to_string(p->value), p->unit, p->source);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
}

/// Reads what write_energy_model writes: events in any order, each at most once; `#` begins a comment line. Throws `Error`, one
/// line that names `file_name` and the line, for anything else.
inline EnergyModel read_energy_model(std::istream& in, std::string const& file_name)
{
    namespace d = model_detail;
    EnergyModel model;
    d::ParameterFile file{in, file_name, {"energy", "energy model", "an energy model"}, d::energy_rules()};
    file.read([](std::uint32_t, std::string_view, auto const&) { return std::optional<std::uint64_t>{}; },
              [&](Parameter p) { set_energy(model, p.name, p.value, std::move(p.source)); });
    model.name = file.name();
    return model;
}

} // namespace tilemesh
