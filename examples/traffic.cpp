// Random traffic: every tile sends parcels to random tiles, along the row first. It counts by link, and prices its own operations.
#include <algorithm>
#include <iostream>
#include <random>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/buffer.hpp>
#include <tilemesh/machine/channel.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/machine/superstep.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/cost_table.hpp>
#include <tilemesh/model/trace_page.hpp>
using tilemesh::Direction, tilemesh::TileId, tilemesh::Vote;
struct Parcel { TileId to; };
struct Road : tilemesh::Channel<Parcel, 16> {};
struct Waiting : tilemesh::Buffer<Parcel, 2000> {};
struct Links { std::uint32_t sent[4], full[4], arrived; }; // by side: parcels, refusals
struct Passed { static constexpr bool per_pass = true; std::uint32_t looked, hops; }; // statistics of one pass, 0 when it begins
struct Work { // operations with names of our own, counted below and priced in main
    enum Kind : std::uint32_t { lookup, hop };
    static constexpr char const* names[] = {"lookup", "hop"};
};
struct Forward {
    Vote operator()(tilemesh::Here here, Waiting& waiting, Links& links, Passed& passed, tilemesh::In<Road> in,
                    tilemesh::Out<Road> out) const noexcept
    {
        for (auto side : tilemesh::news)
            for (Parcel const& parcel : in[side]) waiting.push(parcel);
        std::uint32_t kept = 0;
        passed.looked = waiting.size();
        for (Parcel const& parcel : waiting) {
            if (parcel.to == here.tile) {
                ++links.arrived;
                continue;
            }
            auto const dx = parcel.to.x() - here.tile.x(), dy = parcel.to.y() - here.tile.y(); // modulo 2^32: to the west if above 2^31
            auto const side = dx != 0 ? (dx >> 31 ? Direction::west : Direction::east) : (dy >> 31 ? Direction::north : Direction::south);
            bool const sent = out[side].try_push(parcel);
            ++(sent ? links.sent : links.full)[index(side)];
            if (!sent) waiting[kept++] = parcel;
            passed.hops += sent ? 1 : 0;
        }
        waiting.truncate(kept);
        return waiting.empty() ? Vote::quiet : Vote::busy;
    }
    static tilemesh::Operations<Work> operations(Passed const& passed) noexcept { return {{{passed.looked, passed.hops}}}; }
};
int main()
{
    tilemesh::Mesh mesh{tilemesh::Sequence{tilemesh::Superstep<Forward>{}, tilemesh::UntilQuiet<Forward>{}}, tilemesh::Grid{8, 8},
                        tilemesh::Traced<tilemesh::Mk2>{}, {.threads = 2}};
    mesh.limit<Road>(4); // of the 16 slots
    std::mt19937 random{1};
    for (auto [tile, waiting] : mesh.states<Waiting>())
        for (int i = 0; i < 100; ++i) waiting.push({mesh.grid().tile(random() % 64u)});
    auto const run = mesh.run();
    std::uint32_t arrived = 0, busiest = 0, full = 0;
    for (auto [tile, links] : mesh.states<Links>()) {
        arrived += links.arrived, busiest = std::max(busiest, *std::max_element(links.sent, links.sent + 4));
        for (auto refusals : links.full) full += refusals;
    }
    auto model = tilemesh::mk2(); // its exchange and sync, our operations
    set_price(model, "lookup", 12'000, "assumed: 12 cycles");
    set_price(model, "hop", 30'000, "assumed: 30 cycles");
    auto const page = write_trace_page("traffic_page", "traffic", mesh.trace(), model, mesh.grid(), {.title = "Random traffic"});
    std::cout << arrived << " parcels, " << run.messages() << " hops, " << full << " refusals, " << busiest << " on the busiest link, "
              << milliseconds_text(model, model_cost(model, mesh.trace(), mesh.grid()).cycles) << " ms modelled: " << page.string() << '\n';
    return arrived == 6400 ? 0 : 1;
}
