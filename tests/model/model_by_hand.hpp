#pragma once
#include "../standard.hpp"
#include <tilemesh/model/cost_model.hpp>

namespace engine_test {
/// Numbers with which cycles are easily added up by hand; a cycle is a microsecond.
inline tilemesh::CostModel model()
{
    tilemesh::CostModel m;
    m.name = "by hand";
    m.clock_khz = 1000;
    m.prices = {{"slot", 500}, {"projection", 0}, {"routed", 6000}, {"copied", 0}, {"comparison", 0}, {"pair", 0}, {"pixel", 0}};
    m.run_cycles = 10;
    m.exchange_cycles = 100;
    m.exchange_millicycles_a_byte = 250;
    m.sync_cycles = 7;
    m.vote_cycles = 3;
    return m;
}

/// The names of splat::Operation.
inline std::vector<std::string> seven_kinds()
{
    return {"slot", "projection", "routed", "copied", "comparison", "pair", "pixel"};
}

namespace two_supersteps {
/// Three tiles in a row. Superstep 0: all send eastwards, 2 slots and 1 routed for 1 message, 6 and 3 for 3: 17, 31 and 10
/// cycles; 24 bytes of capacity a side: 124 cycles. Superstep 1, which votes: tiles 1 and 2, 1 and 3 slots: 11 and 12 cycles.
inline tilemesh::Trace by_hand()
{
    tilemesh::Trace trace;
    trace.kernels = {"Send", "Take"};
    trace.operations.assign(2, seven_kinds());
    trace.supersteps = {{0, false, 24, true, {{0, {{2, 0, 1}}, {0, 12, 0, 0}}, {1, {{6, 0, 3}}, {0, 20, 0, 0}}, {2, {}, {}}}},
                        {1, true, 0, false, {{1, {{1}, 4}, {}}, {2, {{3}, 12}, {}}}}};
    return trace;
}
inline constexpr tilemesh::Grid row{3, 1};
} // namespace two_supersteps
} // namespace engine_test
