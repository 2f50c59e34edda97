// test: unoptimised test asan tsan
// Which tiles are full, and where the records that found no slot belong, against brute force.
#include "../splat/runner.hpp"
#include <tilemesh/splat/projection.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using support::make_runner;

namespace {

/// Slots that each tile needs in a view: a record each, and a copy where a footprint goes on to other tiles; and what is parked there.
std::vector<std::uint64_t> slots_needed(support::Runner& renderer, std::vector<Gaussian> const& gaussians, Camera const& camera, bool blooms)
{
    auto const grid = renderer.grid();
    std::vector<std::uint64_t> needed(grid.size(), 0);
    std::set<std::uint32_t> visible;
    for (auto const& g : gaussians) {
        auto const s = project(g, make_view(camera, renderer.rules()), renderer.tiling());
        if (!s.visible()) continue;
        visible.insert(static_cast<std::uint32_t>(g.id));
        for (std::uint32_t t = 0; t < grid.size(); ++t)
            needed[t] += blooms ? covers(s, renderer.tiling(), grid.tile(t)) : grid.tile(t) == s.anchor;
    }
    for (std::uint32_t t = 0; t < grid.size(); ++t)
        for (auto const& mark : renderer.marks(grid.tile(t)))
            needed[t] += !mark.is(Mark::copy) && visible.count(static_cast<std::uint32_t>(mark.id)) == 0;
    return needed;
}

/// Renders some views with so many slots a tile and checks each report. Returns the frames with full tiles.
template <class Setup>
std::uint32_t check(std::uint32_t slots, bool blooms)
{
    auto const gaussians = support::cloud(400, 21);
    auto const renderer = make_runner<Setup>(support::map_of(gaussians), {.grid = {7, 6}, .storage_slots = slots});
    std::uint32_t full = 0;
    for (float turn : {0.0f, 0.0f, 0.02f, -0.4f, 3.1f}) {
        CAPTURE(turn);
        auto const camera = support::lens(120, 80, turn);
        auto const r = renderer->render(camera).report;
        auto const needed = slots_needed(*renderer, gaussians, camera, blooms);
        auto const most = std::max_element(needed.begin(), needed.end());
        bool const lacks = r.losses(report::Cause::unplaced) + r.losses(report::Cause::storage_full) != 0;
        std::optional<report::FullTiles> expected;
        if (lacks && *most > slots)
            expected = report::FullTiles{static_cast<std::uint32_t>(std::count_if(needed.begin(), needed.end(), [=](auto n) { return n > slots; })),
                                         static_cast<std::uint32_t>(most - needed.begin()), *most, slots};
        CHECK(r.full_tiles == expected);
        full += r.full_tiles ? 1 : 0;
        for (auto const& loss : r.lost) {
            auto const s = project(*std::find_if(gaussians.begin(), gaussians.end(), [&](auto const& g) { return g.id == loss.id; }),
                                   make_view(camera, renderer->rules()), renderer->tiling());
            bool const anchored = loss.tile == report::Loss::whole && loss.cause == report::Cause::unplaced && s.visible();
            CHECK(loss.full_tile == (anchored ? renderer->grid().index_of(s.anchor) : report::Loss::whole));
        }
    }
    return full;
}

} // namespace

TEST_CASE("a report counts the full tiles, says what the fullest needs, and where each unplaced record belongs")
{
    CHECK(check<support::Whole>(12, true) > 0);
    CHECK(check<support::Dropping>(20, true) > 0);
    CHECK(check<support::NoRouting>(12, true) > 0);
    CHECK(check<support::Minimal>(3, false) > 0);
    CHECK(check<support::Whole>(400, true) == 0);
}

