// test: cost 2
// What a host does at once for all workers of a tile of the program of homes: sorted runs and their order, and a fold as a table.
#include "support.hpp"
#include <tilemesh/splat/homes/blend.hpp>
#include <tilemesh/splat/homes/fold.hpp>
#include <tilemesh/splat/projection.hpp>

using namespace tilemesh;
namespace homes = splat::homes;
using homes::detail::run_begin, splat::SortKey;

namespace {
/// Distinct keys of few depths, so that ids decide.
std::vector<SortKey> keys_of(std::uint32_t n, std::uint32_t depths, support::Random& random)
{
    std::vector<SortKey> keys;
    for (std::uint32_t i = 0; i < n; ++i) {
        auto const depth = __builtin_bit_cast(std::uint32_t, 1.0f + 0.01f * static_cast<float>(random.below(depths)));
        keys.push_back({depth, splat::GaussianId{(i * 7919u) % 1'000'003u}, i});
    }
    return keys;
}
bool same(SortKey const& a, SortKey const& b) { return a.depth_key == b.depth_key && a.id == b.id && a.slot == b.slot; }
} // namespace

TEST_CASE("homes on a host: runs that are sorted at once are the runs that workers sort, and the order is that of all keys")
{
    support::Random random(5);
    for (std::uint32_t const n : {0u, 1u, 5u, 95u, 96u, 97u, 700u, 2048u})
        for (std::uint32_t const depths : {1u, 40u, 1'000'000u})
            for (std::uint32_t runs = 1; runs <= homes::Work::max_workers; ++runs) {
                CAPTURE(n);
                CAPTURE(depths);
                CAPTURE(runs);
                auto const before = keys_of(n, depths, random);
                auto expected = before, keys = before, spare = before;
                for (std::uint32_t r = 0; r < runs; ++r) std::sort(expected.begin() + run_begin(n, runs, r), expected.begin() + run_begin(n, runs, r + 1));
                std::vector<std::uint32_t> order(n);
                homes::detail::sort_runs_at_once(keys.data(), n, runs, spare.data(), order.data());
                CHECK(std::equal(keys.begin(), keys.end(), expected.begin(), same));
                auto all = before;
                std::sort(all.begin(), all.end());
                bool ordered = true;
                for (std::uint32_t i = 0; i < n; ++i) ordered = ordered && order[i] < n && same(keys[order[i]], all[i]);
                CHECK(ordered);
                std::vector<std::uint32_t> taken(n);
                CHECK(homes::detail::take_order(keys.data(), n, order.data(), taken.data()));
                CHECK(taken == order);
            }
}

TEST_CASE("homes on a host: an order that is none is not taken")
{
    support::Random random(6);
    constexpr std::uint32_t n = 9;
    auto keys = keys_of(n, 1000, random);
    std::sort(keys.begin(), keys.end());
    std::vector<std::uint32_t> order(n), taken(n);
    for (std::uint32_t i = 0; i < n; ++i) order[i] = i;
    auto const takes = [&](std::vector<std::uint32_t> const& left) { return homes::detail::take_order(keys.data(), n, left.data(), taken.data()); };
    CHECK(takes(order));
    for (std::uint32_t i = 0; i < n; ++i) {
        auto repeated = order, beyond = order, swapped = order;
        repeated[i] = i == 0 ? 1 : i - 1;
        beyond[i] = n + i;
        std::swap(swapped[i], swapped[(i + 1) % n]);
        CHECK(!takes(repeated));
        CHECK(!takes(beyond));
        CHECK(!takes(swapped));
    }
    CHECK(!takes(std::vector<std::uint32_t>(n, 0)));
}

TEST_CASE("homes on a host: the table of a fold is the fold")
{
    for (std::uint32_t const blocks : {1u, 2u, 7u, 40u, 80u, 143u, homes::AxisTable::most})
        for (std::uint32_t const tiles : {1u, 2u, 3u, 7u, 36u, 40u, 600u})
            for (bool const folded : {false, true}) {
                CAPTURE(blocks);
                CAPTURE(tiles);
                CAPTURE(folded);
                auto const axis = homes::make_axis(blocks, tiles, folded);
                homes::AxisTable const table(axis);
                bool equal = true;
                auto c = axis.cursor(0);
                for (std::uint32_t i = 0; i < blocks; ++i, c = axis.next(c)) {
                    auto const at = table.cursor(i);
                    equal = equal && table.tile(at) == axis.tile(c) && table.number(at) == axis.number(c) && axis.block(table.tile(at), table.number(at)) == i;
                    for (std::uint32_t j = i; j < blocks; j += 1 + j / 9) {
                        auto const a = axis.tiles_of(i, j), b = table.tiles_of(i, j);
                        equal = equal && a.first == b.first && a.last == b.last;
                    }
                }
                CHECK(equal);
            }
    CHECK(homes::FoldTable::has_room(homes::make_fold(16 * 512, 5 * 512, {40, 36}, true)));
    CHECK(!homes::FoldTable::has_room(homes::make_fold(16 * 512 + 1, 5, {40, 36}, true)));
    CHECK(!homes::FoldTable::has_room(homes::make_fold(16, 5 * 512 + 1, {40, 36}, true)));
    auto const fold = homes::make_fold(640, 480, {3, 2}, true); // many blocks share a bit
    REQUIRE(fold.blocks_a_bit > 1);
    homes::FoldTable const table(fold);
    for (std::uint32_t b = 0; b < fold.tile_blocks(); ++b) CHECK(table.bit_of(b) == fold.bit_of(b));
}

namespace {
/// What a tile's kept blocks and counters become when they blend a list of splats.
struct Kept {
    std::vector<homes::NarrowBlock> blocks;
    homes::Work work{};
    Kept(homes::Fold const& fold, TileId tile, splat::Camera const& camera) : blocks(fold.tile_blocks())
    {
        for (std::uint32_t b = 0; b < blocks.size(); ++b) homes::detail::begin_block(blocks[b], homes::block_at(fold, tile, b), camera);
    }
    bool operator==(Kept const& other) const
    {
        return std::memcmp(blocks.data(), other.blocks.data(), blocks.size() * sizeof blocks[0]) == 0 && std::memcmp(&work, &other.work, sizeof work) == 0;
    }
};
/// Splats of a view: small ones, some that cover the frame, needles, and some whose middle is far away.
std::vector<splat::Splat> splats_of(std::uint32_t n, float largest, splat::View const& view, std::uint64_t seed)
{
    support::Random random(seed);
    std::vector<splat::Splat> out;
    auto const tiling = splat::make_tiling(view.camera.width, view.camera.height, splat::block_width, splat::block_height);
    while (out.size() < n) {
        auto g = support::cloud(1, random.below(1'000'000))[0];
        bool const large = random.below(8) == 0;
        for (float& s : g.log_scale) s = large ? std::log(largest) - 0.5f * static_cast<float>(random.below(8)) : s;
        if (large)
            for (int c = 0; c < 2; ++c) g.mean_world[c] *= 1.0f + largest * static_cast<float>(random.below(3));
        g.opacity = 0.01f * static_cast<float>(1 + random.below(99));
        if (auto const s = splat::project(g, view, tiling); s.visible()) out.push_back(s);
    }
    return out;
}
} // namespace

TEST_CASE("homes on a host: blocks that blend the splats that may reach them have the pixels and the counters of the workers")
{
    struct Frame {
        std::uint32_t width, height;
        Grid grid;
        bool folded;
    };
    std::uint32_t tiles = 0, far = 0;
    for (Frame const& frame : {Frame{64, 40, {1, 1}, true}, Frame{200, 130, {1, 1}, true}, Frame{700, 33, {1, 2}, false}, Frame{300, 200, {4, 5}, true}})
        for (std::uint32_t const n : {0u, 1u, 130u, 1024u, 1700u})
            for (float const largest : {0.05f, 30.0f}) {
                auto view = splat::make_view(support::lens(frame.width, frame.height), splat::Rules{});
                view.rules.arithmetic = splat::Arithmetic::fast;
                auto const splats = splats_of(n, largest, view, n + frame.width);
                for (auto const& s : splats) far += std::fabs(s.mean_px[0]) > 2 * static_cast<float>(frame.width + frame.height) ? 1u : 0u;
                auto const at = [&](std::uint32_t i) -> splat::Splat const& { return splats[i]; };
                auto const fold = homes::make_fold(frame.width, frame.height, frame.grid, frame.folded);
                for (TileId const tile : frame.grid.tiles()) {
                    if (tile.y() > 1 || tile.x() > 1) continue;
                    CAPTURE(n);
                    CAPTURE(largest);
                    CAPTURE(frame.width);
                    std::uint32_t const finished = frame.folded ? 0u : 2u;
                    Kept workers(fold, tile, view.camera), at_once = workers;
                    for (std::uint32_t w = 0; w < 6; ++w)
                        homes::blend_window(workers.blocks.data(), fold, tile, view, finished, n, at, Worker{w, 6}, workers.work);
                    homes::blend_whole_window(at_once.blocks.data(), fold, tile, view, finished, n, at, 6, at_once.work);
                    CHECK(at_once == workers);
                    tiles += workers.work.contributing[0] != 0 ? 1u : 0u;
                }
            }
    CHECK(tiles > 30);
    CHECK(far > 10);
}
