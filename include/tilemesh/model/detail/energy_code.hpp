#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <tilemesh/model/energy.hpp>
#include <tilemesh/model/parameter_file.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST double joules_of_power(CostModel const& model, std::uint64_t cycles, double watts)
{
    if (model.clock_khz == 0 || !(watts >= 0) || std::isinf(watts))
        throw Error("energy cannot be computed (model \"" + model_detail::shown(model.name) + "\" has a clock of " + std::to_string(model.clock_khz) +
                    " kHz, and the power is " + std::to_string(watts) + " W); give it a clock above 0 kHz and a finite power that is not negative");
    return watts * (milliseconds(model, cycles) / 1000);
}

namespace model_detail {

inline ParameterRule energy_rule(std::string_view event)
{
    return {std::string(event), "fJ", 0, most_femtojoules};
}

TILEMESH_HOST ModelParameter const* find_energy(EnergyModel const& model, std::string_view event) noexcept
{
    auto const p = std::find_if(model.events.begin(), model.events.end(), [&](ModelParameter const& known) { return known.name == event; });
    return p == model.events.end() ? nullptr : &*p;
}

TILEMESH_HOST void Femtojoules::add(std::uint64_t n) noexcept
{
    low += n;
    high += low < n ? 1 : 0;
}

TILEMESH_HOST void Femtojoules::add(std::uint64_t count, std::uint64_t each) noexcept
{
    add((count & 0xffffffffu) * each);
    std::uint64_t const upper = (count >> 32) * each;
    add(upper << 32);
    high += upper >> 32;
}

TILEMESH_HOST double Femtojoules::joules() const noexcept
{
    constexpr double two_to_64 = 18446744073709551616.0; // a product with it is exact
    return (static_cast<double>(high) * two_to_64 + static_cast<double>(low)) / 1e15;
}

} // namespace model_detail

TILEMESH_HOST void set_energy(EnergyModel& model, std::string_view event, std::uint64_t femtojoules, std::string source)
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

TILEMESH_HOST auto Energy::of(std::string_view event) const -> EnergyEvent
{
    for (auto const& e : events)
        if (e.name == event) return e;
    return {std::string(event)};
}

TILEMESH_HOST Energy energy_of(EnergyModel const& energy, CostModel const& model, Trace const& trace, Grid grid)
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
        if (model.exchange_cost == ExchangeCost::capacity) charge_all(capacity_byte, s.capacity_of_tile());
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

TILEMESH_HOST EnergyModel read_energy_model(std::istream& in, std::string const& file_name)
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
