#pragma once
#include <tilemesh/engine/cost_model.hpp>

namespace engine_test {
/// Numbers with which cycles are easily added up by hand; a cycle is a microsecond.
inline tilemesh::CostModel model()
{
    tilemesh::CostModel m;
    m.name = "by hand";
    m.clock_khz = 1000;
    m.millicycles[index(tilemesh::Operation::slot)] = 500;
    m.millicycles[index(tilemesh::Operation::routed)] = 6000;
    m.run_cycles = 10;
    m.exchange_cycles = 100;
    m.exchange_millicycles_a_byte = 250;
    m.sync_cycles = 7;
    m.vote_cycles = 3;
    return m;
}
} // namespace engine_test
