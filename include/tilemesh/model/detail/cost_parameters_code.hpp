#pragma once
#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/network_lines.hpp>
#include <tilemesh/model/parameter_file.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 {
namespace model_detail {

inline constexpr std::uint32_t first_operation = 2;

/// All parameters of a model, in the order of its file: clock, exchange_cost, the operations that it prices, run, exchange,
/// exchange_byte, sync, vote.
inline std::vector<ParameterRule> parameter_rules(std::vector<OperationPrice> const& prices)
{
    constexpr std::string_view cycles = "cycles", millicycles = "millicycles";
    std::vector<ParameterRule> rules;
    rules.push_back({"clock", "kHz", 1, most_clock_khz});
    rules.push_back({"exchange_cost", "kind", 0, exchange_cost_names.size() - 1});
    for (auto const& p : prices) rules.push_back({p.operation, millicycles, 0, most_millicycles});
    rules.push_back({"run", cycles, 0, most_cycles});
    rules.push_back({"exchange", cycles, 0, most_cycles});
    rules.push_back({"exchange_byte", millicycles, 0, most_millicycles});
    rules.push_back({"sync", cycles, 0, most_cycles});
    rules.push_back({"vote", cycles, 0, most_cycles});
    return rules;
}
/// The place of a parameter in that order, or the number of parameters if none has this name.
inline std::size_t parameter_index(std::vector<ParameterRule> const& rules, std::string_view name)
{
    return static_cast<std::size_t>(std::find_if(rules.begin(), rules.end(), [&](ParameterRule const& r) { return r.name == name; }) - rules.begin());
}

/// The model's number. Not for exchange_cost, which is not an integer.
template <class Model>
auto& parameter_field(Model& m, std::size_t i)
{
    if (i == 0) return m.clock_khz;
    if (i - first_operation < m.prices.size()) return m.prices[i - first_operation].millicycles;
    switch (i - first_operation - m.prices.size()) {
    case 0:
        return m.run_cycles;
    case 1:
        return m.exchange_cycles;
    case 2:
        return m.exchange_millicycles_a_byte;
    case 3:
        return m.sync_cycles;
    default:
        return m.vote_cycles;
    }
}
inline std::uint64_t parameter_value(CostModel const& m, std::size_t i)
{
    return i == 1 ? static_cast<std::uint64_t>(m.exchange_cost) : parameter_field(m, i);
}
inline std::string parameter_text(std::size_t i, std::uint64_t value)
{
    return i == 1 && value < exchange_cost_names.size() ? std::string(exchange_cost_names[static_cast<std::size_t>(value)]) : std::to_string(value);
}

} // namespace model_detail

TILEMESH_HOST void set_parameter(CostModel& model, std::string_view name, std::uint64_t value, std::string source)
{
    namespace d = model_detail;
    auto const rules = d::parameter_rules(model.prices);
    auto const at = d::parameter_index(rules, name);
    if (at == rules.size()) {
        std::string all;
        for (auto const& r : rules) {
            if (!all.empty()) all += ", ";
            all += r.name;
        }
        throw Error("a cost model has no parameter \"" + d::shown(name) + "\" (it has " + all +
                    "); name one of these, or price an operation of your program with set_price");
    }
    auto const& rule = rules[at];
    d::expect_in_range(rule, value);
    d::expect_source(rule.name, source);
    if (at == 1) model.exchange_cost = static_cast<ExchangeCost>(value);
    else d::parameter_field(model, at) = value;
    ModelParameter entry{rule.name, value, std::string(rule.unit), std::move(source)};
    auto const place = std::find_if(model.parameters.begin(), model.parameters.end(),
                                    [&](ModelParameter const& p) { return d::parameter_index(rules, p.name) >= at; });
    if (place != model.parameters.end() && place->name == rule.name) *place = std::move(entry);
    else model.parameters.insert(place, std::move(entry));
}

TILEMESH_HOST void set_price(CostModel& model, std::string_view operation, std::uint64_t millicycles, std::string source)
{
    namespace d = model_detail;
    auto const fixed = d::parameter_rules({});
    if (!d::is_operation_name(operation) || d::is_network_name(operation) || d::parameter_index(fixed, operation) != fixed.size())
        throw Error("operation \"" + d::shown(operation) +
                    "\" cannot be priced (a file cannot tell it from another parameter: a name is a word of 1 to 64 printable ASCII "
                    "characters and no parameter's); call it something else");
    if (d::find_price(model, operation) != nullptr) return set_parameter(model, operation, millicycles, std::move(source));
    auto priced = model; // a refused number changes nothing
    priced.prices.push_back({std::string(operation), 0});
    set_parameter(priced, operation, millicycles, std::move(source));
    model = std::move(priced);
}

TILEMESH_HOST CostModel mk2()
{
    namespace d = model_detail;
    using Work = KernelWork;
    CostModel m;
    m.name = "mk2";
    auto const text = [](std::uint64_t n) { return std::to_string(n); };
    auto const counted = [&](char const* operation, std::uint32_t instructions, std::string const& what) {
        set_price(m, operation, instructions * d::one_worker,
                      "arithmetic: " + text(instructions) +
                          " instructions of our code (compiled for RV32IMF) on one worker, which "
                          "issues every 6th cycle (asm_vertices guide): " +
                          what);
    };
    std::string const scalar = "0.68 a cycle (measured for naive scalar C++ on 6 workers, poplar_explorer)";

    set_parameter(m, "clock", 1'325'000, "document: GC200 at 1.325 GHz (the paper; eenewseurope on Hot Chips 33); a C600 may run at 1.49 GHz");
    set_parameter(m, "exchange_cost", static_cast<std::uint64_t>(ExchangeCost::capacity),
                  "document: copies are compiled, so that whole channels move (the authors' code, edge_builder.cpp)");
    counted("slot", Work::slot, "find, the most frequent look; project and depth sort do more, once a record");
    set_price(m, "projection", d::projection_slots() * d::one_worker,
              "arithmetic: " + text(Work::projection_flops) + " flops at " + scalar + ", " + text(Work::projection_roots) +
                  " divisions and roots of 5 slots (poplibs), " + text(Work::projection_others) + " other operations, " + text(Work::reach) +
                  " instructions for the tiles it touches: " + text(d::projection_slots()) + " slots of one worker, 6 cycles each");
    counted("routed", Work::routed,
            "a 64-byte record leaves (" + text(Work::leaves) + "), passes 3 tiles (" + text(Work::passes) +
                " each) and settles (" + text(Work::settles) + "), two operations a hop; that it is 4 hops is a guess");
    counted("copied", Work::copied,
            "mean of a 60-byte copy's arrival (" + text(Work::copy_arrives) + ") and departure (" + text(Work::copy_leaves) + ")");
    counted("comparison", Work::comparison, "a level of heap sort, two compares and three words moved");
    set_price(m, "pair", d::pair_millicycles(), "arithmetic: 21 flops (fast blending in cells) at " + scalar);
    set_price(m, "pixel", Work::pixel * d::six_workers,
                  "arithmetic: " + text(Work::pixel) +
                      " instructions of our code (compiled for RV32IMF) for an RGBX8 pixel on 6 workers, "
                      "one a cycle (graphcore.ai on tile-level parallelism); a float pixel takes about 20");
    counted("left", Work::leaves, "a 64-byte message leaves its tile, as a record in `route`");
    counted("passed", Work::passes, "a 64-byte message passes a tile, as a record in `route`");
    counted("settled", Work::settles, "a 64-byte message settles, as a record in `route`");
    auto const work = [&](std::uint64_t flops, std::uint64_t roots, std::uint64_t others) {
        return text(flops) + " flops at " + scalar + ", " + text(roots) + " divisions of 5 slots (poplibs), " + text(others) + " other operations";
    };
    set_price(m, "moving_pair", d::millicycles_of(Work::tenth_flops_a_tracked_pair + 10 * Work::moving_flops) + Work::moving_others * d::six_workers,
              "arithmetic: a pair, and " + work(Work::moving_flops, 0, Work::moving_others) + " for its derivatives, on 6 workers");
    set_price(m, "moving_depth", d::millicycles_of(10 * Work::moving_depth_flops),
              "arithmetic: " + text(Work::moving_depth_flops) + " flops at " + scalar);
    set_price(m, "splat_motions", d::slots_of(Work::motion_flops, Work::motion_roots, Work::motion_others) * d::six_workers,
              "arithmetic: " + work(Work::motion_flops, Work::motion_roots, Work::motion_others) + ", on 6 workers");
    constexpr std::uint64_t adding_flops = Work::adding_flops + Work::rounding_flops, adding_others = Work::adding_others + Work::rounding_others;
    set_price(m, "row", d::slots_of(adding_flops + Work::row_flops, Work::adding_roots, adding_others + Work::row_others) * d::six_workers,
              "arithmetic: " + work(adding_flops + Work::row_flops, Work::adding_roots, adding_others + Work::row_others) + ", on 6 workers");
    set_price(m, "mean", d::slots_of(Work::mean_flops, 0, Work::mean_others) * d::one_worker,
              "arithmetic: " + work(Work::mean_flops, 0, Work::mean_others) + ", on one worker");
    set_price(m, "gradient",
              d::slots_of(adding_flops + Work::gradient_flops, Work::adding_roots + Work::gradient_roots, adding_others + Work::gradient_others) *
              d::one_worker,
              "arithmetic: " + work(adding_flops + Work::gradient_flops, Work::adding_roots + Work::gradient_roots,
                                    adding_others + Work::gradient_others) + ", on one worker");
    set_price(m, host_byte, (m.clock_khz + d::host_link_bytes_a_us - 1) / d::host_link_bytes_a_us,
              "document: PCIe Gen4 x16 has 64 GB/s both ways (C600 product brief), so 32 GB/s to the chip; no kernel counts it");
    set_parameter(m, "run", d::vertex_cycles, "document: 11 cycles of the supervisor and about 9 (poplibs popopsCycleEstimators)");
    set_parameter(m, "exchange", d::exchange_with_two_syncs - d::most_a_sync,
                  "arithmetic: about 300 fixed with two syncs (jit-dynamic-lookup), less one sync; how they share is a guess");
    set_parameter(m, "exchange_byte", 1000 / d::bytes_a_cycle,
                  "document: 4 bytes a cycle a tile (jit-dynamic-lookup; 8 TB/s over 1,472 tiles at 1.325 GHz is 4.1)");
    set_parameter(m, "sync", d::most_a_sync, "guess: no number found; at most half of 300 cycles with two syncs (jit-dynamic-lookup)");
    set_parameter(m, "vote", d::vote_cycles(40, 36),
                  "guess: two supersteps that gather 40 words, then 36 (our graph), at the numbers above and 4 instructions a word; "
                  "no number found for the loop's own test, which is not in it");
    return m;
}

TILEMESH_HOST double host_link_milliseconds(CostModel const& model, std::uint64_t bytes)
{
    auto const* const price = model_detail::find_price(model, host_byte);
    return price == nullptr ? 0.0 : static_cast<double>(bytes) * static_cast<double>(price->millicycles) / 1e3 / static_cast<double>(model.clock_khz);
}

TILEMESH_HOST void write_cost_model(std::ostream& out, CostModel const& model)
{
    namespace d = model_detail;
    if (!d::fits_a_line(model.name))
        throw Error("a cost model cannot be written (its name is not one line of 1 to " +
                    std::to_string(d::most_text_bytes) + " bytes, without blanks around it); name it");
    if (model.chips != Chips{})
        throw Error("cost model \"" + d::shown(model.name) + "\" cannot be written (a file has no line for its chips); write it without chips, "
                    "and set CostModel::chips after reading");
    std::string text = "# name value unit source; exchange_cost is capacity or live\nmodel " + model.name + '\n';
    auto const rules = d::parameter_rules(model.prices);
    for (std::size_t i = 0; i < rules.size(); ++i) {
        auto const& rule = rules[i];
        auto const& name = rule.name;
        auto const is_it = [&](ModelParameter const& p) { return p.name == name; };
        auto const p = std::find_if(model.parameters.begin(), model.parameters.end(), is_it);
        if (p == model.parameters.end() || !d::fits_a_line(p->source))
            throw Error("cost model \"" + d::shown(model.name) + "\" cannot be written (parameter " + name +
                        " has no source); give it one with set_parameter");
        auto const value = d::parameter_value(model, i);
        if (p->value != value || p->unit != rule.unit || value < rule.least || value > rule.most ||
            std::count_if(model.parameters.begin(), model.parameters.end(), is_it) != 1)
            throw Error("cost model \"" + d::shown(model.name) + "\" cannot be written (parameter " + name + " is " + std::to_string(value) +
                        ", and its source is of " + std::to_string(p->value) + " " + d::shown(p->unit) + "); set both with set_parameter");
        text += d::parameter_line(name, d::parameter_text(i, value), rule.unit, p->source);
    }
    if (model.parameters.size() != rules.size())
        throw Error("cost model \"" + d::shown(model.name) + "\" cannot be written (it lists " + std::to_string(model.parameters.size()) +
                    " parameters of " + std::to_string(rules.size()) + "); keep those that it has");
    if (model.network) text += d::network_lines(*model.network);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
}

TILEMESH_HOST CostModel read_cost_model(std::istream& in, std::string const& file_name)
{
    namespace d = model_detail;
    CostModel model;
    std::map<std::string, ModelParameter> read; // because set_parameter and set_price search all of the model for a name
    auto const fixed = d::parameter_rules({}), of_network = d::network_rules();
    auto rules_of_file = fixed;
    rules_of_file.insert(rules_of_file.end(), of_network.begin(), of_network.end());
    d::NetworkReader network;
    d::ParameterFile file{in, file_name, {"model", "cost model", "a cost model", "millicycles", most_millicycles, true}, rules_of_file};
    file.read(
        [&](std::size_t at, std::string_view word, auto const& refuse) -> std::optional<std::uint64_t> {
            if (at >= fixed.size() && at < rules_of_file.size()) return network.word(rules_of_file[at].name, word, refuse);
            if (at != 1) return {};
            auto const kind = std::find(d::exchange_cost_names.begin(), d::exchange_cost_names.end(), word);
            if (kind == d::exchange_cost_names.end())
                refuse("has no kind of exchange", "exchange_cost is \"" + d::shown(word) + "\"", "write capacity or live");
            return static_cast<std::uint64_t>(kind - d::exchange_cost_names.begin());
        },
        [&](ModelParameter p) {
            if (d::is_network_name(p.name)) return network.set(p);
            if (d::parameter_index(fixed, p.name) == fixed.size()) model.prices.push_back({p.name, 0});
            read.emplace(p.name, std::move(p));
        });
    model.name = file.name();
    file.expect_all();
    model.network = network.take(file_name);
    auto const rules = d::parameter_rules(model.prices);
    for (std::size_t i = 0; i < rules.size(); ++i) {
        auto& p = read.at(rules[i].name);
        if (i == 1) model.exchange_cost = static_cast<ExchangeCost>(p.value);
        else d::parameter_field(model, i) = p.value;
        model.parameters.push_back(std::move(p));
    }
    return model;
}

}} // namespace tilemesh
