#pragma once
#include <algorithm>
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
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <tilemesh/model/parameter_file.hpp>
#include <utility>
#include <vector>

// The energy of a run: power x time, as the paper measures it, or events with so many femtojoules each. The library has no built-in
// energies. Supply them, each with its source.
namespace tilemesh { inline namespace v0_2 {

/// The joules of a machine that draws `watts` while `cycles` pass on the model's clock. Throws `Error` for a clock of 0 kHz, and for watts
/// that are negative or not a finite number.
inline double joules_of_power(CostModel const& model, std::uint64_t cycles, double watts)
{
    if (model.clock_khz == 0 || !(watts >= 0) || std::isinf(watts))
        throw Error("energy cannot be computed (model \"" + model_detail::shown(model.name) + "\" has a clock of " +
                    std::to_string(model.clock_khz) + " kHz, and the power is " + std::to_string(watts) +
                    " W); give it a clock above 0 kHz and a finite power that is not negative");
    return watts * (milliseconds(model, cycles) / 1000);
}

/// The events that have an energy: the operations of kernels, by name, and the three below. A kernel of several workers counts the slowest
/// worker's share times the number of workers, because this takes its time; so Composite's pairs are more than those evaluated.
///   sent_byte      a byte of a message or its head over one hop, if the exchange is paid as `live`
///   capacity_byte  a byte that compile-time copies move, live or not, if the exchange is paid as `capacity`
///   tile_cycle     a cycle of a tile, busy or idle: leakage and the clock's energy
inline constexpr char const *sent_byte_event = "sent_byte", *capacity_byte_event = "capacity_byte", *tile_cycle_event = "tile_cycle";

/// The largest energy of an event, in femtojoules: 4 microjoules (1,000 femtojoules are a picojoule). Its product with half of a 64-bit
/// count fits into 64 bits.
inline constexpr std::uint64_t most_femtojoules = 4'000'000'000;

/// The energy of each event. No energy is set at first, and there are no defaults; call set_energy.
struct EnergyModel {
    std::string name;
    std::vector<ModelParameter> events; ///< each event once, in the order in which they were first set
    friend bool operator==(EnergyModel const&, EnergyModel const&) = default;
};

namespace model_detail {
inline ParameterRule energy_rule(std::string_view event)
{
    return {std::string(event), "fJ", 0, most_femtojoules};
}
inline ModelParameter const* find_energy(EnergyModel const& model, std::string_view event) noexcept
{
    auto const p = std::find_if(model.events.begin(), model.events.end(), [&](ModelParameter const& known) { return known.name == event; });
    return p == model.events.end() ? nullptr : &*p;
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

/// Sets the energy of one event: an operation, by the name with which kernels count it, or one of the three above. Throws `Error` for a
/// name that is not one word of at most 64 printable ASCII characters, for a value above `most_femtojoules`, and for a source that is not
/// one line of text.
inline void set_energy(EnergyModel& model, std::string_view event, std::uint64_t femtojoules, std::string source)
{
    namespace d = model_detail;
    if (!d::is_operation_name(event))
        throw Error("an energy model has no event \"" + d::shown(event) +
                    "\" (an event is a word of 1 to 64 printable ASCII characters); name an operation of your kernels, " + sent_byte_event +
                    ", " + capacity_byte_event + " or " + tile_cycle_event);
    auto const rule = d::energy_rule(event);
    d::expect_in_range(rule, femtojoules);
    d::expect_source(rule.name, source);
    ModelParameter entry{rule.name, femtojoules, std::string(rule.unit), std::move(source)};
    auto const known = std::find_if(model.events.begin(), model.events.end(), [&](ModelParameter const& p) { return p.name == event; });
    if (known != model.events.end()) *known = std::move(entry);
    else model.events.push_back(std::move(entry));
}

/// The number of occurrences of an event in a run, and the energy of all of them.
struct EnergyEvent {
    std::string name;
    std::uint64_t count = 0; ///< exact
    double joules = 0;
};
/// The energy of a run: joules of each kind of event, of each step of the program, and of each tile.
struct Energy {
    std::vector<EnergyEvent> events; ///< operations, in the order in which the steps name them, then the three others
    std::vector<double> joules_of_step, joules_of_tile;
    double joules = 0;
    /// The event of this name; an event with count 0 if there is none.
    EnergyEvent of(std::string_view event) const
    {
        for (auto const& e : events)
            if (e.name == event) return e;
        return {std::string(event)};
    }
};

/// Applies an energy model to a run. Events are counted exactly and added up in integers; a sum becomes joules once, at the end. Bytes that
/// compile-time copies move are charged to the tile that sends them. Every tile is charged tile_cycle for all modelled cycles of the run.
///
/// Throws `Error` for an event that occurs and has no energy, for an energy above `most_femtojoules` (possible if it was not set by
/// set_energy), for a trace of another grid, for a trace that model_cost refuses, and for counts that exceed 64 bits. Cost: linear in the
/// trace.
inline Energy energy_of(EnergyModel const& energy, CostModel const& model, Trace const& trace, Grid grid)
{
    using model_detail::Femtojoules;
    model_detail::check_trace(trace, grid);
    for (auto const& event : energy.events) // Femtojoules::add takes less than 2^32
        model_detail::expect_in_range(model_detail::energy_rule(event.name), event.value);
    auto const cost = model_cost(model, trace, grid);
    Energy out;
    model_detail::OperationColumns const columns(trace);
    for (auto const& name : columns.names) out.events.push_back({name});
    std::size_t const sent_byte = out.events.size(), capacity_byte = sent_byte + 1, tile_cycle = sent_byte + 2;
    for (auto const* name : {sent_byte_event, capacity_byte_event, tile_cycle_event}) out.events.push_back({name});
    std::vector<ModelParameter const*> set;
    for (auto const& event : out.events) set.push_back(model_detail::find_energy(energy, event.name));
    std::vector<Femtojoules> kinds(out.events.size());
    std::vector<Femtojoules> steps(trace.kernels.size()), tiles(grid.size());
    Femtojoules all, each_tile; // energy of every event, and of events that occur equally on every tile

    auto const occurs = [&](std::size_t event, std::uint64_t count, std::uint64_t times, std::size_t superstep) {
        auto const most = std::numeric_limits<std::uint64_t>::max();
        if (times != 0 && count > (most - out.events[event].count) / times)
            throw Error("energy cannot be computed (more than 2^64 of event " + out.events[event].name + "); model a shorter run");
        out.events[event].count += count * times;
        auto const* const parameter = set[event];
        if (count != 0 && times != 0 && parameter == nullptr)
            throw Error("energy model \"" + model_detail::shown(energy.name) + "\" cannot be applied (event " +
                        out.events[event].name + " occurs, first in superstep " + std::to_string(superstep) +
                        ", and its energy is not set); set it, and say where it is from");
        return parameter != nullptr ? parameter->value : 0;
    };
    for (std::size_t i = 0; i < trace.supersteps.size(); ++i) {
        auto const& s = trace.supersteps[i];
        for (auto const& t : s.tiles) {
            auto const charge = [&](std::size_t event, std::uint64_t count) {
                auto const each = occurs(event, count, 1, i);
                kinds[event].add(count, each);
                steps[s.step].add(count, each);
                tiles[t.tile].add(count, each);
                all.add(count, each);
            };
            for (std::size_t kind = 0; kind < model_detail::operations_of_step(trace, s.step).size(); ++kind)
                charge(columns.of_step[s.step][kind], t.operations.count[kind]);
            if (model.exchange_cost == ExchangeCost::live) charge(sent_byte, model_detail::all_sent(t));
        }
        auto const charge_all = [&](std::size_t event, std::uint64_t count) {
            auto const each = occurs(event, count, grid.size(), i);
            each_tile.add(count, each);
            kinds[event].add(count * grid.size(), each);
            steps[s.step].add(count * grid.size(), each);
            all.add(count * grid.size(), each);
        };
        if (model.exchange_cost == ExchangeCost::capacity)
            charge_all(capacity_byte, std::uint64_t{4} * s.capacity_bytes);
        charge_all(tile_cycle, cost.supersteps[i].total());
    }
    for (std::size_t event = 0; event < kinds.size(); ++event) out.events[event].joules = kinds[event].joules();
    for (auto const& s : steps) out.joules_of_step.push_back(s.joules());
    for (auto& t : tiles) {
        t.add(each_tile.low);
        t.high += each_tile.high;
        out.joules_of_tile.push_back(t.joules());
    }
    out.joules = all.joules();
    return out;
}

/// Writes a model as text: `#` comments, `energy NAME`, then one event a line, `name value unit source`. read_energy_model reads it back as
/// the same model. Throws `Error` if the model's name is not one line of text, and for a parameter that set_energy would not have made.
inline void write_energy_model(std::ostream& out, EnergyModel const& model)
{
    namespace d = model_detail;
    if (!d::fits_a_line(model.name))
        throw Error("an energy model cannot be written (its name is not one line of 1 to " + std::to_string(d::most_text_bytes) +
                    " bytes, without blanks around it); name it");
    EnergyModel same;
    same.name = model.name;
    for (auto const& p : model.events)
        set_energy(same, p.name, p.value, p.source);
    if (!(same == model))
        throw Error("energy model \"" + d::shown(model.name) +
                    "\" cannot be written (an event is there twice or has another unit than fJ); set each with set_energy");
    std::string text = "# name value unit source; 1,000 fJ are 1 pJ; an event that is not here has no energy set\n";
    text += "energy " + model.name + '\n';
    for (auto const& p : model.events)
        text += d::parameter_line(p.name, std::to_string(p.value), p.unit, p.source);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
}

/// Reads the text of write_energy_model: events in any order, each at most once; `#` begins a comment line. Throws `Error`, one line that
/// names `file_name` and the line, for any other text.
inline EnergyModel read_energy_model(std::istream& in, std::string const& file_name)
{
    namespace d = model_detail;
    EnergyModel model;
    std::vector<d::ParameterRule> rules;
    for (auto const* event : {sent_byte_event, capacity_byte_event, tile_cycle_event}) rules.push_back(d::energy_rule(event));
    d::ParameterFile file{in, file_name, {"energy", "energy model", "an energy model", "fJ", most_femtojoules}, std::move(rules)};
    file.read([](std::size_t, std::string_view, auto const&) { return std::optional<std::uint64_t>{}; },
              [&](ModelParameter p) { model.events.push_back(std::move(p)); }); // each name comes once, with a value in range
    model.name = file.name();
    return model;
}

}} // namespace tilemesh
