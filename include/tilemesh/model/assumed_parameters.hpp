#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/model/cost_parameters.hpp>

namespace tilemesh { inline namespace v0_2 {

namespace model_detail {
TILEMESH_HOST CostModel assumed_model(MachineSize const& machine, double bytes, std::uint64_t barrier_cycles);
} // namespace model_detail

/// The numbers of mk2() adapted to another machine of which no better numbers are known. The source of an assumed number begins with
/// "assumed", and so such a number counts as guessed; that of a number of mk2() begins with "kept from mk2". The model's name ends with ",
/// assumed", so that every output says it. Clock and number of workers are those of `Machine`. A kernel of one worker has mk2's instructions;
/// with W workers, a worker issues one instruction in W cycles. A kernel that runs on all workers keeps mk2's price. The host link keeps its
/// bytes a second. A tile receives `bytes_a_cycle` bytes per cycle; the price of a byte is rounded to whole thousandths of a cycle. A barrier
/// takes `barrier_cycles`, and a vote takes two barriers. Throws `Error` as set_parameter does, and if the price of a byte would be 0 or out
/// of range.
template <class Machine>
CostModel assumed_model(double bytes_a_cycle, std::uint64_t barrier_cycles)
{
    return model_detail::assumed_model(size_of_machine<Machine>(), bytes_a_cycle, barrier_cycles);
}

/// The assumptions of a model in one line: each parameter whose source begins with "assumed", with its source.
TILEMESH_HOST std::string assumed_text(CostModel const& model);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/assumed_parameters_code.hpp>
#endif
