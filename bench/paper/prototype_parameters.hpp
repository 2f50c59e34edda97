#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/model/cost_parameters.hpp>

namespace paper {

using tilemesh::CostModel, tilemesh::ExchangeCost;

/// The authors' prototype on Mk2. Apply it to a trace of a program that counts the prototype's work: it looks at every slot of every
/// buffer, routes records on one worker, and moves them one hop a frame (prototype.hpp has this program). The prices of a slot, an arrival, a
/// projection, a waiting record, a comparison and a Gaussian-pixel pair are fitted: with them the program takes the times of the paper's stage table
/// ("Per-stage execution time by scene") on the map Salad. No other map took part in the fit. The times are milliseconds of that table at
/// the paper's clock. The prototype's code seems to convert cycles at 1.85 GHz. If so, the true times of all stages except blending are
/// 1.40 times as long.
///
/// Do not use it for the kernels of this library, which look at live slots only: use `mk2()` for them.
inline CostModel mk2_prototype()
{
    CostModel m;
    m.name = "mk2_prototype";
    auto const fitted = [&](char const* operation, std::uint64_t millicycles, std::string const& what) {
        set_price(m, operation, millicycles, "fitted to Salad's line of the paper's stage table: " + what);
    };
    set_parameter(m, "clock", 1'325'000, "document: GC200 at 1.325 GHz (the paper); the code that printed its cycles divides by 1.85 GHz");
    set_parameter(m, "exchange_cost", static_cast<std::uint64_t>(ExchangeCost::capacity),
                  "document: copies are compiled, so that whole channels move (the authors' code, edge_builder.cpp)");
    fitted("slot", 4'910'584, "Route and Projection, least, over 400 and 827 slots");
    fitted("projection", 8'516'130, "Projection, mean and most, of a stored record: projected, sent, listed");
    fitted("routed", 20'950'037, "Route, mean and most, of an arrival: projected, stored, sent on");
    fitted("waiting", 50'467, "Route and Projection, mean and most, of a record at which an insertion looks");
    fitted("comparison", 359'437, "Sort, mean and most, of quicksort's comparison with its share of swaps");
    fitted("pair", 36'270, "Blend, of the slowest tile by the host's clock");
    set_price(m, "pixel", 0, "arithmetic: in the price of a pair");
    set_parameter(m, "run", 0, "arithmetic: in the price of a slot");
    set_parameter(m, "exchange", 300, "document: about 300 fixed with two syncs (jit-dynamic-lookup)");
    set_parameter(m, "exchange_byte", 1000,
                  "arithmetic: 4 bytes a cycle a tile (jit-dynamic-lookup), and a record of 60 bytes moves at a stride of 240");
    set_parameter(m, "sync", 0, "arithmetic: in the 300 cycles of an exchange");
    set_parameter(m, "vote", 0, "document: its frame is one superstep, nobody votes");
    return m;
}

} // namespace paper
