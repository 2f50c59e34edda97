#include "modelled.hpp"
#include "setups.hpp"
#include <string>

namespace channel_capacity {

namespace {

constexpr tilemesh::Grid grid{grid_columns, grid_rows};

std::uint32_t road_bytes(std::uint32_t slots)
{
    return splat::Road<Held>::end_bytes(slots);
}
std::uint32_t beam_bytes(std::uint32_t slots)
{
    return splat::Beam<Held>::end_bytes(slots);
}
static_assert(splat::Road<Held>::end_bytes(1) == splat::Road<Dropped>::end_bytes(1) &&
                  splat::Beam<Held>::end_bytes(1) == splat::Beam<Dropped>::end_bytes(1) &&
                  splat::Road<Held>::end_bytes(1) != splat::Beam<Held>::end_bytes(1),
              "both policies send the same records, and the bytes of an exchange tell which channel it is");

/// The cycles of an exchange that moves `bytes_a_side` bytes from each tile to each neighbour.
std::uint64_t exchange_cycles(std::uint32_t bytes_a_side)
{
    tilemesh::Trace one;
    one.kernels.emplace_back();
    one.supersteps.emplace_back();
    one.supersteps.back().capacity_bytes = bytes_a_side;
    return tilemesh::model_cost(cost_model(), one, grid).supersteps.front().exchange;
}

} // namespace

tilemesh::CostModel const& cost_model()
{
    static tilemesh::CostModel const model = tilemesh::mk2();
    return model;
}

std::uint64_t Modelled::exchange(std::uint32_t slots) const
{
    return road * exchange_cycles(road_bytes(slots)) + beam * exchange_cycles(beam_bytes(slots)) + homes;
}

Modelled modelled(tilemesh::Trace const& trace, std::uint32_t slots, std::uint64_t exchanges, std::string& broken)
{
    auto const cost = tilemesh::model_cost(cost_model(), trace, grid);
    Modelled m;
    std::uint64_t sent = 0;
    bool known = true;
    for (std::size_t i = 0; i < cost.supersteps.size(); ++i) {
        auto const& c = cost.supersteps[i];
        auto const bytes = trace.supersteps[i].capacity_bytes;
        m.rest += c.compute + c.sync + c.vote;
        m.road += bytes == road_bytes(slots) ? 1 : 0;
        m.beam += bytes == beam_bytes(slots) ? 1 : 0;
        known = known && (bytes == 0 || bytes == road_bytes(slots) || bytes == beam_bytes(slots));
        sent += trace.supersteps[i].sent ? 1 : 0;
    }
    if (!known) broken = "an exchange moves other bytes than those of channels with these slots";
    else if (m.cycles(slots) != cost.cycles) broken = "the modelled cycles are not the sum of their parts";
    else if (sent != exchanges)
        broken = "the trace has " + std::to_string(sent) + " exchanges that sent something, the report " + std::to_string(exchanges);
    return m;
}

Modelled modelled_homes(tilemesh::Trace const& trace)
{
    Modelled m;
    for (auto const& c : tilemesh::model_cost(cost_model(), trace, grid).supersteps) {
        m.rest += c.compute + c.sync + c.vote;
        m.homes += c.exchange;
    }
    return m;
}

} // namespace channel_capacity
