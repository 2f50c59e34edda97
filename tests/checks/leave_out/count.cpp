// What each feature takes of a tile, and of a frame: the built-in map at 1280 x 720 on 40 x 36 tiles of Mk2 (the last row: on one tile), a
// cold start and the same view again. A line a setup: its name in setups.hpp, what it is called, then the cells of leave_out_table.sh.
#include "setups.hpp"
#include <iostream>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/scene/built_in.hpp>

namespace {
using namespace tilemesh;

template <class Renderer>
std::uint64_t projections(Renderer& renderer)
{
    std::uint64_t n = 0;
    auto const grid = renderer.mesh().grid();
    for (std::uint32_t t = 0; t < grid.size(); ++t) n += renderer.mesh().template state<splat::Counts>(grid.tile(t)).projected;
    return n;
}

template <class S>
void row(char const* name, char const* called, scene::Map const& map, RendererOptions const& options = {})
{
    using Layout = Tile<typename S::Machine, splat::Frame<S>, S>;
    constexpr std::uint32_t slot = splat::slot_bytes(splat::setup_of<S>());
    auto const camera = scene::built_in_camera({1280, 720});
    BasicRenderer<S> renderer{map, options};
    auto const cold = renderer.render(camera).report;
    auto const cold_projections = projections(renderer);
    auto const still = renderer.render(camera).report;
    auto const cells = {std::uint64_t{sizeof(typename S::Record)},
                        std::uint64_t{slot},
                        Layout::bytes - S::Machine::code_bytes - std::uint64_t{slot} * S::sizes.storage,
                        std::uint64_t{S::sizes.storage},
                        cold.exchanges.total(),
                        cold.messages,
                        cold_projections,
                        still.exchanges.total(),
                        still.messages,
                        projections(renderer),
                        still.pairs,
                        std::uint64_t{still.lost.size()}};
    std::cout << name << '|' << called;
    for (auto const cell : cells) std::cout << '|' << report::thousands(cell);
    std::cout << std::endl;
}
} // namespace

int main()
{
    auto const map = scene::built_in_map();
    row<leave_out::minimal>("minimal", "the least: one colour, one view", map);
    row<leave_out::with_bloom>("with_bloom", "+ bloom (footprints span tiles)", map);
    row<leave_out::with_routing>("with_routing", "+ routing (the view moves)", map);
    row<leave_out::both>("both", "+ both: the default", map);
    row<leave_out::degree_1>("degree_1", "default + harmonics of degree 1", map);
    row<leave_out::degree_2>("degree_2", "default + harmonics of degree 2", map);
    row<leave_out::degree_3>("degree_3", "default + harmonics of degree 3", map);
    row<leave_out::with_depth>("with_depth", "default + depth", map);
    row<leave_out::with_alpha>("with_alpha", "default + alpha", map);
    row<leave_out::everything>("everything", "everything", map);
    row<leave_out::one_tile>("one_tile", "the least on one tile", map, {.grid = {1, 1}});
}
