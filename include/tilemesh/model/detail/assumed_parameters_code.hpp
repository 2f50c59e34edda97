#pragma once
#include <cmath>
#include <tilemesh/error.hpp>
#include <tilemesh/model/assumed_parameters.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/table.hpp>

namespace tilemesh { inline namespace v0_2 {
namespace model_detail {

/// The price of a byte, in thousandths of a cycle.
TILEMESH_HOST std::uint64_t millicycles_a_byte(double bytes, std::string const& rate)
{
    double const price = bytes > 0 ? std::floor(1000 / bytes + 0.5) : 0;
    if (!(price >= 1 && price <= static_cast<double>(most_millicycles)))
        throw Error("a tile cannot receive " + rate + " bytes in a cycle (a byte takes 1 to " + report::thousands(most_millicycles) +
                    " thousandths of a cycle: a rate from 0.00001 to 2,000); give it a rate in this range");
    return static_cast<std::uint64_t>(price);
}

TILEMESH_HOST CostModel assumed_model(MachineSize const& machine, double bytes, std::uint64_t barrier_cycles)
{
    auto const rate = number_text(bytes);
    auto model = mk2();
    model.name = std::string(machine.name) + ", assumed";
    for (auto& p : model.parameters) { // what the lines below do not set is mk2's, and says so
        std::string kept = "kept from mk2";
        for (auto const* operation : {"pair", "pixel", "moving_pair", "moving_depth", "splat_motions", "row"})
            if (p.name == operation)
                kept += ", because all workers of a tile, here " + std::to_string(machine.workers) + ", issue one instruction a cycle together";
        p.source = kept + "; " + p.source;
        p.kind = kind_of_source(p.source);
    }
    set_parameter(model, "clock", machine.clock_khz, "assumed");
    for (auto const* operation : {"slot", "projection", "routed", "copied", "comparison", "left", "passed", "settled", "mean", "gradient"})
        set_price(model, operation, price_of(model, operation) * machine.workers / Mk2::workers,
                  "assumed: mk2's instructions, of which a worker issues one in " + std::to_string(machine.workers) + " cycles");
    set_price(model, host_byte, (machine.clock_khz + host_link_bytes_a_us - 1) / host_link_bytes_a_us,
              "arithmetic: mk2's host link, 32 GB/s, in cycles of this clock; no kernel counts it");
    set_parameter(model, "exchange_byte", millicycles_a_byte(bytes, rate),
                  "assumed: a tile receives " + rate + " bytes in a cycle; rounded to whole millicycles");
    set_parameter(model, "sync", barrier_cycles, "assumed");
    set_parameter(model, "vote", 2 * barrier_cycles, "assumed: there and back");
    return model;
}

} // namespace model_detail

TILEMESH_HOST std::string assumed_text(CostModel const& model)
{
    std::string const word = "assumed";
    std::string text;
    for (auto const& p : model.parameters) {
        if (p.source.rfind(word, 0) != 0) continue;
        text += (text.empty() ? "assumed: " : ", ") + p.name + ' ' + report::thousands(p.value) + ' ' + p.unit;
        if (p.name == "exchange_byte" && p.source.size() > word.size() + 2) text += " (" + p.source.substr(word.size() + 2) + ")";
    }
    return text;
}

}} // namespace tilemesh
