#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/report/table.hpp>

namespace tilemesh { inline namespace v0_2 {

/// The numbers of mk2() adapted to another machine of which no better numbers are known. The source of an assumed number begins with
/// "assumed", and so such a number counts as guessed; the model's name ends with ", assumed", so that every output says it. Clock and number
/// of workers are those of `Machine`. A kernel of one worker has mk2's instructions; with W workers, a worker issues one instruction in W
/// cycles. A kernel that runs on all workers keeps mk2's price. A tile receives `bytes_a_cycle` bytes per
/// cycle. A barrier takes `barrier_cycles`, and a vote takes two barriers. Throws `Error` as set_parameter does; `bytes_a_cycle` must not
/// be 0.
template <class Machine>
CostModel assumed_model(std::uint64_t bytes_a_cycle, std::uint64_t barrier_cycles)
{
    auto model = mk2();
    model.name = std::string(Machine::name) + ", assumed";
    set_parameter(model, "clock", Machine::clock_khz, "assumed");
    for (auto const* operation : {"slot", "projection", "routed", "copied", "comparison", "left", "passed", "settled", "mean", "gradient"})
        set_price(model, operation, price_of(model, operation) * Machine::workers / Mk2::workers,
                  "assumed: mk2's instructions, of which a worker issues one in " + std::to_string(Machine::workers) + " cycles");
    set_parameter(model, "exchange_byte", (1000 + bytes_a_cycle / 2) / bytes_a_cycle,
                  "assumed: a tile receives " + std::to_string(bytes_a_cycle) + " bytes in a cycle; rounded to whole millicycles");
    set_parameter(model, "sync", barrier_cycles, "assumed");
    set_parameter(model, "vote", 2 * barrier_cycles, "assumed: there and back");
    return model;
}

/// The assumptions of a model in one line: each parameter whose source begins with "assumed", with its source.
TILEMESH_HOST std::string assumed_text(CostModel const& model);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/assumed_parameters_code.hpp>
#endif
