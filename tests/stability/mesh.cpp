#include "../splat/support.hpp"
#include "catalogue.hpp"
#include "machines.hpp"
#include <deque>
#include <tilemesh/splat/footprint.hpp>

// The owners of records on the mesh, and the way of records to them: rows 71 to 90 of the catalogue.
using namespace tilemesh;
using namespace tilemesh::splat;
using stability::Kind;
using stability::make_runner;
using stability::number;

namespace {

/// Looks along +z. At depth 1024 one world unit is one pixel, and every product on the way there is exact.
Camera exact_camera(std::uint32_t width, std::uint32_t height)
{
    auto c = support::flat_camera(width, height);
    c.fx = c.fy = 1024;
    return c;
}
Gaussian at(std::uint32_t id, float x, float y, float sigma = 0.01f, float opacity = 0.9f)
{
    auto g = support::ball(id, x, y, sigma, opacity);
    g.mean_world[2] = 1024;
    return g;
}
float moved_by_ulps(float v, int ulps)
{
    for (; ulps > 0; --ulps) v = std::nextafter(v, INFINITY);
    for (; ulps < 0; ++ulps) v = std::nextafter(v, -INFINITY);
    return v;
}

/// The number of Gaussians that do not have exactly one owner, the tile of the pixel of (x, y).
std::uint32_t wrong_owners(stability::Runner& runner, std::vector<Gaussian> const& gaussians)
{
    auto const owners = runner.owners();
    auto const tiling = runner.tiling();
    std::uint32_t wrong = 0;
    for (auto const& g : gaussians) {
        auto const tile = TileId::at(static_cast<std::uint32_t>(std::floor(g.mean_world[0])) / tiling.tile_width,
                                     static_cast<std::uint32_t>(std::floor(g.mean_world[1])) / tiling.tile_height);
        std::uint32_t found = 0, right = 0;
        for (auto i = std::lower_bound(owners.begin(), owners.end(), std::pair{static_cast<std::uint32_t>(g.id), 0u});
             i != owners.end() && i->first == static_cast<std::uint32_t>(g.id); ++i) {
            ++found;
            right += i->second == runner.grid().index_of(tile) ? 1 : 0;
        }
        wrong += found == 1 && right == 1 ? 0 : 1;
    }
    return wrong;
}

/// wrong_owners after a frame on Mk2 at 1280 x 720, which owns each Gaussian once and has the naive picture.
std::uint32_t wrong_owners_on_mk2(std::vector<Gaussian> const& gaussians)
{
    auto const camera = exact_camera(1280, 720);
    auto runner = make_runner(Kind::mk2, support::map_of(gaussians));
    auto const frame = runner->render(camera);
    CHECK(runner->owned_ids().size() == gaussians.size());
    CHECK(runner->differing_pixels(frame, camera) == 0);
    return wrong_owners(*runner, gaussians);
}

// --- a naive mesh: records without pictures, known by the tile that they go to -----------------------------------------------

struct Naive {
    Grid grid;
    std::vector<std::deque<TileId>> at; ///< the records on each tile

    explicit Naive(Grid g) : grid(g), at(g.size()) {}
    std::uint32_t away() const
    {
        std::uint32_t n = 0;
        for (std::uint32_t t = 0; t < grid.size(); ++t)
            for (TileId to : at[t]) n += to == grid.tile(t) ? 0 : 1;
        return n;
    }
};
/// Channels of `slots` messages without flow control: a message that meets a full channel is lost. Returns the number of lost messages.
std::uint32_t route_and_lose(Naive mesh, std::uint32_t slots)
{
    std::uint32_t lost = 0;
    while (mesh.away() != 0) {
        std::vector<std::deque<TileId>> next(mesh.grid.size());
        for (std::uint32_t t = 0; t < mesh.grid.size(); ++t) {
            std::uint32_t sent[4] = {};
            for (TileId to : mesh.at[t]) {
                if (to == mesh.grid.tile(t)) {
                    next[t].push_back(to);
                    continue;
                }
                auto const d = RowFirst::towards(mesh.grid.tile(t), to);
                if (sent[index(d)]++ < slots) next[mesh.grid.index_of(mesh.grid.neighbour(mesh.grid.tile(t), d))].push_back(to);
                else ++lost;
            }
        }
        mesh.at = std::move(next);
    }
    return lost;
}
/// One pool of `slots` slots per tile for its own records and for records in transit. A record waits for a full neighbour. Returns the
/// number of records that never arrive.
std::uint32_t route_in_shared_pools(Naive mesh, std::size_t slots)
{
    for (bool moved = true; moved;) {
        moved = false;
        for (std::uint32_t t = 0; t < mesh.grid.size(); ++t)
            for (std::size_t i = 0; i < mesh.at[t].size();) {
                TileId const to = mesh.at[t][i];
                if (!(to == mesh.grid.tile(t))) {
                    auto const next = mesh.grid.neighbour(mesh.grid.tile(t), RowFirst::towards(mesh.grid.tile(t), to));
                    auto& pool = mesh.at[mesh.grid.index_of(next)];
                    if (pool.size() < slots) {
                        pool.push_back(to);
                        mesh.at[t].erase(mesh.at[t].begin() + static_cast<std::ptrdiff_t>(i));
                        moved = true;
                        continue;
                    }
                }
                ++i;
            }
    }
    return mesh.away();
}
/// `per_tile` records on each tile (on average), each bound for another tile; every tile receives equally many.
struct Shuffled {
    Grid grid{20, 18};
    std::vector<Gaussian> gaussians; ///< the tiles are 8 x 8 pixels
    Naive naive{grid};

    Shuffled(std::uint32_t n, std::uint64_t seed)
    {
        support::Random random(seed);
        std::vector<std::uint32_t> to(n);
        for (std::uint32_t i = 0; i < n; ++i) to[i] = i % grid.size();
        for (std::uint32_t i = n; i > 1; --i) std::swap(to[i - 1], to[random.below(i)]);
        std::uint32_t const share = (n + grid.size() - 1) / grid.size(); // as a renderer loads its map
        for (std::uint32_t i = 0; i < n; ++i) {
            auto const t = grid.tile(to[i]);
            gaussians.push_back(splat_at(i + 1, t));
            naive.at[i / share].push_back(t);
        }
    }
    static Gaussian splat_at(std::uint32_t id, TileId t) { return at(id, static_cast<float>(8 * t.x()) + 4, static_cast<float>(8 * t.y()) + 4); }
    Camera camera() const { return exact_camera(8 * grid.width, 8 * grid.height); }
};
bool all_once(std::vector<std::uint32_t> const& ids)
{
    return std::adjacent_find(ids.begin(), ids.end()) == ids.end();
}
} // namespace

TEST_CASE("row 71: a mean on a border has one owner")
{
    std::vector<Gaussian> gaussians;
    std::uint32_t id = 0, closed_twice = 0, open_never = 0;
    for (std::uint32_t k = 1; k < 40; ++k) {
        float const x = static_cast<float>(32 * k);
        gaussians.push_back(at(++id, x, 10.5f));
        std::uint32_t closed = 0, open = 0;
        for (std::uint32_t t = 0; t < 40; ++t) {
            float const low = static_cast<float>(32 * t), high = static_cast<float>(32 * t + 32);
            closed += x >= low && x <= high ? 1 : 0;
            open += x > low && x < high ? 1 : 0;
        }
        closed_twice += closed == 2 ? 1 : 0;
        open_never += open == 0 ? 1 : 0;
    }
    for (std::uint32_t k = 1; k < 36; ++k) gaussians.push_back(at(++id, 16.5f, static_cast<float>(20 * k)));
    for (std::uint32_t k = 1; k < 36; ++k) gaussians.push_back(at(++id, static_cast<float>(32 * k), static_cast<float>(20 * k)));
    auto const wrong = wrong_owners_on_mk2(gaussians);
    CHECK(closed_twice == 39);
    CHECK(open_never == 39);
    CHECK(wrong == 0);
    stability::report({71, "means on all borders of 40 x 36 tiles", "closed: twice on 39 of 39, open: never on 39 of 39",
                       std::to_string(wrong) + " of " + std::to_string(gaussians.size()) + " without exactly one owner", "one owner", true});
}

TEST_CASE("row 72: of any means, each has the tile of its pixel as its one owner")
{
    std::uint32_t const n = support::fast() ? 2'000 : 10'000;
    support::Random random(72);
    std::vector<Gaussian> gaussians;
    std::uint32_t twice = 0, elsewhere = 0;
    auto const accepts = [](float v, std::uint32_t size) { // the number of tiles with ceil(v) >= min && floor(v) < max
        std::uint32_t tiles = 0;
        for (std::uint32_t t = 0; t * size < 1280; ++t)
            tiles += std::ceil(v) >= static_cast<float>(t * size) && std::floor(v) < static_cast<float>((t + 1) * size) ? 1 : 0;
        return tiles;
    };
    for (std::uint32_t i = 0; i < n; ++i) {
        float const x = random.uniform(0, 1280), y = random.uniform(0, 720);
        gaussians.push_back(at(i + 1, x, y));
        twice += accepts(x, 32) * accepts(y, 20) > 1 ? 1 : 0;
        elsewhere += static_cast<int>(std::nearbyint(x)) / 32 != static_cast<int>(x) / 32 ||
                             static_cast<int>(std::nearbyint(y)) / 20 != static_cast<int>(y) / 20
                         ? 1
                         : 0;
    }
    auto const wrong = wrong_owners_on_mk2(gaussians);
    CHECK(twice > n / 20);
    CHECK(elsewhere > n / 40);
    CHECK(wrong == 0);
    stability::report({72, std::to_string(n) + " means anywhere; the prototype's ceil and nearbyint",
                       number(100.0 * twice / n) + " % have two owners, " + number(100.0 * elsewhere / n) + " % go elsewhere",
                       std::to_string(wrong) + " without exactly one owner", "one owner", true});
}

TEST_CASE("row 73: the tile index is a division of integers")
{
    std::uint32_t naive_sizes = 0, ours = 0;
    bool naive_20 = false, naive_32 = false;
    for (std::uint32_t w = 1; w <= 64; ++w) {
        bool wrong = false;
        float const inverse = 1.0f / static_cast<float>(w);
        for (std::uint32_t border = w; border < 1280; border += w)
            for (int ulps = -2; ulps <= 2; ++ulps) {
                float const x = moved_by_ulps(static_cast<float>(border), ulps);
                auto const truth = static_cast<std::uint32_t>(std::floor(double{x} / w));
                wrong = wrong || static_cast<std::uint32_t>(x * inverse) != truth;
                ours += splat::detail::pixel_within(x, 0u | 1280u << 16) / w != truth ? 1 : 0;
            }
        naive_sizes += wrong ? 1 : 0;
        naive_20 = naive_20 || (w == 20 && wrong);
        naive_32 = naive_32 || (w == 32 && wrong);
    }
    CHECK(naive_sizes > 0);
    CHECK_FALSE(naive_20);
    CHECK_FALSE(naive_32);
    CHECK(ours == 0);
    stability::report({73, "x (1/w) on all borders +-2 ulp, w = 1..64", "wrong for " + std::to_string(naive_sizes) + " widths",
                       std::to_string(ours) + " wrong", "exact", true});
}

TEST_CASE("row 74: tiles 24 high: what arrives stays")
{
    std::vector<Gaussian> gaussians;
    std::uint32_t bounce = 0;
    for (std::uint32_t border = 24; border < 720; border += 24)
        for (int ulps = -6; ulps <= 6; ++ulps) {
            float const y = moved_by_ulps(static_cast<float>(border), ulps);
            gaussians.push_back(at(static_cast<std::uint32_t>(gaussians.size()) + 1, 16.5f, y));
            // Accepted by its index, evicted by its bounds.
            auto const accepted = static_cast<std::uint32_t>(y * (1.0f / 24));
            bounce += y < static_cast<float>(24 * accepted) || y >= static_cast<float>(24 * accepted + 24) ? 1 : 0;
        }
    auto runner = make_runner(Kind::roomy, support::map_of(gaussians), {.tile = {32, 24}});
    auto const camera = exact_camera(32, 720);
    auto const first = runner->render(camera).report;
    auto const second = runner->render(camera).report;
    auto const wrong = wrong_owners(*runner, gaussians);
    CHECK(bounce > 0);
    CHECK(first.hops > 0);
    CHECK(second.messages == 0);
    CHECK(second.exchanges.total() == 0);
    CHECK(wrong == 0);
    stability::report({74, std::to_string(gaussians.size()) + " border values, y = 119.999992 among them",
                       std::to_string(bounce) + " go to and fro for ever",
                       "settled; " + std::to_string(second.messages) + " messages in the next frame", "settles", true});
}

TILEMESH_EXACT_BEGIN
namespace {
float separate(float const* r, float const* d)
{
    return r[0] * d[0] + (r[1] * d[1] + r[2] * d[2]);
}
float fused(float const* r, float const* d)
{
    return std::fma(r[0], d[0], std::fma(r[1], d[1], r[2] * d[2]));
}
/// The column of a point in pixels: once with every product rounded, and once with every product fused.
std::pair<float, float> column_both_ways(Camera const& c, float const* p)
{
    float const d[3] = {p[0] - c.position[0], p[1] - c.position[1], p[2] - c.position[2]};
    return {c.fx * (separate(c.rotation[0], d) / separate(c.rotation[2], d)) + c.cx,
            std::fma(c.fx, fused(c.rotation[0], d) / fused(c.rotation[2], d), c.cx)};
}
} // namespace
TILEMESH_EXACT_END

TEST_CASE("row 75: the anchor is computed once and carried")
{
    std::uint32_t const n = 2'000'000; // half of them anywhere, half at a border
    auto const camera = support::lens(1280, 720, 0.3f);
    support::Random random(75);
    std::vector<Gaussian> gaussians;
    std::uint32_t anchors[2] = {}, bits = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        float const z = random.uniform(1, 8), y = random.uniform(-0.4f, 0.4f);
        float const border = (static_cast<float>(32 * random.below(40)) - camera.cx) / camera.fx, x = random.uniform(-0.8f, 0.8f);
        float const view[3] = {(i % 2 == 0 ? x : border) * z, y * z, z};
        float p[3] = {};
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) p[a] += camera.rotation[b][a] * view[b];
        auto const [one, two] = column_both_ways(camera, p);
        bits += std::memcmp(&one, &two, sizeof one) != 0 ? 1 : 0;
        bool const differ = std::floor(one / 32) != std::floor(two / 32);
        anchors[i % 2] += differ ? 1 : 0;
        if (!differ || gaussians.size() == 2000) continue;
        auto g = support::ball(static_cast<std::uint32_t>(gaussians.size()) + 1, 0, 0, 0.01f);
        std::copy(p, p + 3, g.mean_world);
        gaussians.push_back(g);
    }
    CHECK(bits > n / 10);
    CHECK(anchors[1] > 1000);
    // The same points on the mesh: stored as anchored on the carried tile, once, and nowhere else.
    auto runner = make_runner(Kind::mk2, support::map_of(gaussians));
    auto const frame = runner->render(camera);
    CHECK(runner->owned_ids().size() == gaussians.size());
    CHECK(all_once(runner->owned_ids()));
    CHECK(runner->wrong_tiles(camera) == 0);
    auto const differing = runner->differing_pixels(frame, camera);
    CHECK(differing == 0);
    stability::report({75, std::to_string(n) + " points, half at borders, products fused and not",
                       number(100.0 * bits / n) + " % of means differ, " + number(2e6 * anchors[0] / n) + " ppm of anchors, at borders " +
                           number(200.0 * anchors[1] / n) + " %",
                       std::to_string(runner->wrong_tiles(camera)) + " tiles wrong, " + std::to_string(differing) + " pixels differ", "bit-equal",
                       true});
}

TEST_CASE("row 76: two ulps on either side of a border")
{
    std::vector<Gaussian> gaussians;
    std::uint32_t fixed_point = 0;
    for (std::uint32_t k = 1; k < 40; ++k)
        for (int ulps = -2; ulps <= 2; ++ulps) {
            float const x = moved_by_ulps(static_cast<float>(32 * k), ulps);
            gaussians.push_back(at(static_cast<std::uint32_t>(gaussians.size()) + 1, x, 10.5f));
            fixed_point += std::lround(x * 256) / (256 * 32) != static_cast<long>(x) / 32 ? 1 : 0; // Q.8
        }
    auto const wrong = wrong_owners_on_mk2(gaussians);
    CHECK(fixed_point > 0);
    CHECK(wrong == 0);
    stability::report({76, std::to_string(gaussians.size()) + " border values +-2 ulp",
                       std::to_string(fixed_point) + " on another tile than their pixel (Q.8)", std::to_string(wrong) + " wrong", "one owner", true});
}

TEST_CASE("row 77: a mean far off the screen is parked and costs no message")
{
    std::uint32_t naive = 0;
    for (std::uint32_t column = 20, superstep = 0; superstep < 1000; ++superstep) {
        if (column == 5000 / 32) break;
        column = std::min(column + 1, 39u); // the edge wraps to itself
        ++naive;
    }
    auto runner = make_runner(Kind::mk2, support::map_of({at(1, 5000, 100), at(2, -5000, 100), at(3, 100, 1e30f), at(4, 656.5f, 370.5f)}));
    auto camera = exact_camera(1280, 720);
    auto const first = runner->render(camera).report;
    auto const second = runner->render(camera).report;
    camera.position[1] = 0.25f;
    auto const third = runner->render(camera).report;
    CHECK(naive == 1000);
    CHECK(first.gaussians.parked == 3);
    CHECK(first.lost.empty());
    CHECK(second.messages == 0);
    CHECK(third.messages == 0);
    CHECK(runner->owned_ids().size() == 4);
    stability::report({77, "x = 5000 on a frame of 1280", "under way after " + std::to_string(naive) + " supersteps",
                       "parked; " + std::to_string(second.messages) + " messages when static", "0 messages", true});
}

TEST_CASE("row 78: off the screen to the right is the right edge")
{
    support::Random random(78);
    std::vector<Gaussian> gaussians;
    std::uint32_t left = 0, hops = 0, wrong = 0;
    std::uint32_t const n = 60;
    auto const camera = exact_camera(1280, 720);
    auto const tiling = make_tiling(1280, 720, 32, 20);
    for (std::uint32_t i = 0; i < n; ++i) {
        float const x = 1280 + random.uniform(0, 150), y = random.uniform(0, 720);
        gaussians.push_back(at(i + 1, x, y, 50));
        auto const flat = static_cast<std::uint32_t>(y) / 20 * 40 + static_cast<std::uint32_t>(x) / 32;
        left += flat % 40 < 20 ? 1 : 0;
        hops += 39 - flat % 40;
        auto const anchor = project(gaussians.back(), make_view(camera, Rules{}), tiling).anchor;
        wrong += anchor.x() == 39 && anchor.y() == static_cast<std::uint32_t>(y) / 20 ? 0 : 1;
    }
    auto const negative = static_cast<int>(std::floor(-5.0f / 20)) * 40 + static_cast<int>(std::floor(-5.0f / 32));
    gaussians.push_back(at(n + 1, -5, -5, 50));
    auto runner = make_runner(Kind::mk2, support::map_of(gaussians));
    auto const frame = runner->render(camera);
    auto const owners = runner->owners();
    REQUIRE(owners.size() == n + 1);
    for (std::uint32_t i = 0; i < n; ++i) wrong += runner->grid().tile(owners[i].second).x() == 39 ? 0 : 1;
    wrong += owners[n].second == 0 ? 0 : 1;
    CHECK(left > n / 2);
    CHECK(negative < 0);
    CHECK(wrong == 0);
    CHECK(runner->differing_pixels(frame, camera) == 0);
    stability::report(
        {78, "means up to 150 px right of the frame; (-5, -5)",
         number(100.0 * left / n) + " % in the left half, " + number(double(hops) / n) + " hops wasted; index " + std::to_string(negative),
         std::to_string(wrong) + " not on the edge tile", "exact", true});
}

TEST_CASE("row 79: corner to corner takes W + H - 2 exchanges")
{
    auto runner = make_runner(Kind::mk2, support::map_of({at(1, 1275, 715)})); // loaded onto tile (0, 0)
    auto const r = runner->render(exact_camera(1280, 720)).report;
    std::uint64_t const claimed = 40;
    CHECK(r.exchanges.route == 74);
    CHECK(r.hops == 74);
    CHECK(r.exchanges.route > claimed);
    stability::report({79, "corner to corner on 40 x 36", "max(W, H) = " + std::to_string(claimed) + ": not there yet",
                       std::to_string(r.exchanges.route) + " exchanges", "W + H - 2 = 74", true});
}

TEST_CASE("row 80: zooming out onto 6 x 6 tiles loses nothing that is not named")
{
    std::uint32_t const n = support::fast() ? 5'000 : 25'000;
    Extent2 const tile{4, 4};
    Grid const grid{40, 36};
    support::Random random(80);
    std::vector<Gaussian> gaussians;
    for (std::uint32_t i = 0; i < n; ++i) gaussians.push_back(at(i + 1, random.uniform(0, 160), random.uniform(0, 144), 0.01f, 0.1f));
    auto const near = exact_camera(160, 144);
    auto far = near; // 0.15 times as large, in the middle
    far.position[2] = -5802;
    far.cx = 68, far.cy = 61;
    auto const view = make_view(far, Rules{});
    Naive naive(grid);
    for (auto const& g : gaussians)
        naive.at[grid.index_of(TileId::at(static_cast<std::uint32_t>(g.mean_world[0]) / 4, static_cast<std::uint32_t>(g.mean_world[1]) / 4))]
            .push_back(project(g, view, make_tiling(160, 144, 4, 4)).anchor);

    std::string naive_text, our_text;
    std::uint64_t lost = 0, naive_lost = 0;
    for (std::uint32_t slots : {400u, 100u, 40u, 10u}) {
        naive_lost = route_and_lose(naive, slots);
        auto runner = make_runner(Kind::roomy, support::map_of(gaussians), {.grid = {40, 36}, .tile = tile, .channel_slots = slots});
        (void)runner->render(near);
        auto const frame = runner->render(far);
        lost += frame.report.lost.size();
        CHECK(frame.report.lost.empty());
        CHECK(runner->owned_ids().size() == n);
        CHECK(runner->differing_pixels(frame, far) == 0);
        naive_text += (naive_text.empty() ? "" : "/") + std::to_string(naive_lost);
        our_text += (our_text.empty() ? "" : "/") + std::to_string(frame.report.exchanges.route);
    }
    CHECK(naive_lost > 0);
    // Drop: the report lists the missing records, and the picture lacks exactly these.
    auto dropper =
        make_runner(Kind::drop, support::map_of(gaussians), {.grid = {40, 36}, .tile = tile, .channel_slots = 10, .storage_slots = n / 40});
    (void)dropper->render(near);
    auto const dropped = dropper->render(far);
    CHECK(dropped.report.gaussians.dropped > 0);
    CHECK(dropper->owned_ids().size() + dropped.report.gaussians.dropped == n);
    CHECK(dropper->differing_pixels(dropped, far) == 0);
    stability::report(
        {80, std::to_string(n) + " zoom out to 6 x 6 tiles, channels of 400/100/40/10", naive_text + " lost",
         std::to_string(lost) + " lost, " + our_text + " supersteps; drop names its " + std::to_string(dropped.report.gaussians.dropped),
         "0 lost, or named", true});
}

TEST_CASE("row 81: storage and transit do not share a pool: nothing dead-locks")
{
    std::string naive, ours;
    for (std::uint32_t n : {2880u, 4608u}) { // half full, and 0.8
        Shuffled const job(n, 81);
        auto const stuck = route_in_shared_pools(job.naive, 16);
        CHECK(stuck > 0);
        naive += (naive.empty() ? "" : ", ") + std::to_string(stuck);
        for (std::uint32_t slots : {1u, 4u, 16u}) {
            auto runner = make_runner(Kind::roomy, support::map_of(job.gaussians),
                                      {.grid = {20, 18}, .channel_slots = slots, .waiting_slots = slots, .storage_slots = 16});
            auto camera = job.camera();
            auto r = runner->render(camera).report;
            CHECK(r.gaussians.under_way == 0);
            CHECK(all_once(runner->owned_ids()));
            CHECK(runner->owned_ids().size() + r.gaussians.unplaced == n);
            if (n == 2880) CHECK(r.gaussians.unplaced == 0);
            if (n == 2880) ours += (ours.empty() ? "" : "/") + std::to_string(r.exchanges.route);
            // Records that found no room, because others had not left yet, are back in the next view.
            auto const first = r.gaussians.unplaced;
            camera.position[0] = 0.125f;
            r = runner->render(camera).report;
            CHECK(r.gaussians.unplaced <= first);
            CHECK(runner->owned_ids().size() + r.gaussians.unplaced == n);
            if (r.gaussians.unplaced == 0) CHECK(runner->wrong_tiles(camera) == 0);
        }
    }
    stability::report({81, "2880 and 4608 records, 360 tiles of 16 slots", naive + " never arrive",
                       "0 stuck; half full: all there after " + ours + " supersteps (channels of 1/4/16)", "no stall", true});
}

TEST_CASE("row 82: a sink that is full does not stop the traffic")
{
    std::uint32_t const n = 4608;
    Shuffled const job(n, 82);
    std::uint32_t naive = 0;
    for (std::size_t slots : {16u, 18u, 20u}) naive = std::max(naive, route_in_shared_pools(job.naive, slots));
    CHECK(naive > 0);
    auto runner =
        make_runner(Kind::roomy, support::map_of(job.gaussians), {.grid = {20, 18}, .channel_slots = 1, .waiting_slots = 1, .storage_slots = 16});
    auto const camera = job.camera();
    auto const frame = runner->render(camera);
    auto const& r = frame.report;
    std::uint64_t flagged = 0;
    for (auto const& l : r.lost) flagged += l.cause == report::Cause::unplaced && l.tile == report::Loss::whole ? 1 : 0;
    CHECK(r.gaussians.under_way == 0);
    CHECK(r.gaussians.unplaced == flagged);
    CHECK(runner->owned_ids().size() + flagged == n);
    CHECK(runner->differing_pixels(frame, camera) == 0);
    stability::report({82, "4608 records, channels of 1, 16 to 20 slots a tile", std::to_string(naive) + " stuck",
                       "0 stuck, " + std::to_string(flagged) + " unplaced, by id", "flag", true});
}

TEST_CASE("row 83: jitter on a border does not show")
{
    std::uint32_t const frames = support::fast() ? 100 : 1000;
    std::vector<Gaussian> const gaussians{at(1, 32, 10.5f, 3), at(2, 32, 10.5f, 0.3f, 0.5f)};
    auto runner = make_runner(Kind::roomy, support::map_of(gaussians), {.tile = {32, 20}});
    auto camera = exact_camera(64, 20);
    support::Random random(83);
    std::uint64_t naive = 0, moved = 0, differing = 0, twice = 0;
    std::uint32_t before = 1;
    for (std::uint32_t i = 0; i < frames; ++i) {
        camera.position[0] = random.uniform(-1e-3f, 1e-3f);
        std::uint32_t const tile = 32 - camera.position[0] >= 32 ? 1 : 0;
        naive += i > 0 && tile != before ? 1 : 0;
        before = tile;
        auto const frame = runner->render(camera);
        moved += i > 0 ? frame.report.gaussians.moved : 0;
        differing += runner->differing_pixels(frame, camera);
        twice += runner->owned_ids().size() == 2 ? 0 : 1;
    }
    CHECK(naive > frames / 4);
    CHECK(differing == 0);
    CHECK(twice == 0);
    stability::report({83, "+-1e-3 px about a border, " + std::to_string(frames) + " frames", std::to_string(naive) + " moves of a record",
                       number(double(moved) / 2) + " moves of a record, " + std::to_string(differing) + " pixels differ", "image bit-exact", false});
}

TEST_CASE("row 84: with one hop a frame a pan is late by what the report says")
{
    // 420 tiles of 4 px in a row; 33/32 and 2 tiles a frame.
    std::uint32_t const frames = support::fast() ? 60 : 200;
    std::string naive, ours;
    for (float px_a_frame : {4.0f, 4.125f, 8.0f}) {
        std::vector<Gaussian> const one{at(1, 1670.5f, 2)};
        auto runner = make_runner(Kind::roomy, support::map_of(one), {.grid = {420, 1}, .tile = {4, 4}, .hops = 1});
        auto free_runner = make_runner(Kind::roomy, support::map_of(one), {.grid = {420, 1}, .tile = {4, 4}});
        auto camera = exact_camera(1680, 4);
        auto const settled = [&](RenderedFrame const& f) { return f.report.lost.empty() && f.report.gaussians.under_way == 0; };
        std::uint32_t cold = 0, differing = 0, late = 0, silent = 0, not_free = 0;
        while (cold < 1000 && !settled(runner->render(camera))) ++cold;
        REQUIRE(cold < 1000);
        std::int32_t naive_at = 1670 / 4, naive_lag = 0;
        for (std::uint32_t i = 0; i < frames; ++i) {
            camera.position[0] += px_a_frame;
            auto const frame = runner->render(camera);
            differing += runner->differing_pixels(frame, camera) != 0 ? 1 : 0;
            late += frame.report.lost.empty() ? 0 : 1;
            for (auto const& l : frame.report.lost) silent += l.cause == report::Cause::late ? 0 : 1;
            not_free += free_runner->render(camera).report.lost.empty() ? 0 : 1;
            auto const goal = static_cast<std::int32_t>(std::floor((1670.5f - camera.position[0]) / 4));
            naive_at -= naive_at > goal ? 1 : 0;
            naive_lag = std::abs(naive_at - goal);
        }
        std::uint32_t behind = 0; // frames until the picture is whole again
        while (behind < 1000 && !settled(runner->render(camera))) ++behind;
        CHECK(differing == 0); // the picture lacks exactly the listed records
        CHECK(silent == 0);
        CHECK(not_free == 0);
        CHECK(behind <= static_cast<std::uint32_t>(naive_lag) + 2);
        if (px_a_frame > 4) CHECK(late > frames / 2);
        if (px_a_frame == 8) CHECK(naive_lag == static_cast<std::int32_t>(frames));
        naive += (naive.empty() ? "" : "/") + std::to_string(naive_lag);
        ours += (ours.empty() ? "" : "/") + std::to_string(behind);
    }
    stability::report({84, "pan of 1, 33/32 and 2 tiles a frame, " + std::to_string(frames) + " frames, one hop a frame",
                       naive + " tiles behind, unsaid", ours + " frames behind, each listed as late; 0 until quiet", "stated", false});
}

TEST_CASE("row 85: bloom costs a message for each tile but the first")
{
    // Flooding: every message goes on to all neighbours within the rectangle, until the farthest tile has it.
    std::vector<std::uint64_t> now(81, 0);
    std::uint64_t flood = 0;
    now[4 * 9 + 4] = 1;
    for (int superstep = 0; superstep < 8; ++superstep) {
        std::vector<std::uint64_t> next(81, 0);
        Grid const grid{9, 9};
        for (std::uint32_t t = 0; t < 81; ++t)
            for (Direction d : news)
                if (grid.has_neighbour(grid.tile(t), d)) {
                    next[grid.index_of(grid.neighbour(grid.tile(t), d))] += now[t];
                    flood += now[t];
                }
        now = next;
    }
    auto const r = stability::render(Kind::roomy, support::map_of({at(1, 36, 36, 16)}), exact_camera(72, 72), {.tile = {8, 8}}).report;
    CHECK(flood > 80);
    CHECK(r.copies == 80);
    CHECK(r.messages - r.hops == 80);
    stability::report({85, "a footprint of 9 x 9 tiles", std::to_string(flood) + " messages (flooding)",
                       std::to_string(r.messages - r.hops) + " messages", "k^2 - 1 = 80", true});
}

TEST_CASE("row 86: the footprint holds every pixel that sees a needle")
{
    auto camera = exact_camera(1280, 720);
    camera.cx = 640, camera.cy = 360;
    auto const tiling = make_tiling(1280, 720, 32, 20);
    auto g = at(1, 0, 0, 1, 1);
    g.log_scale[0] = std::log(100.0f);
    g.rotation[0] = std::cos(0.39269908f), g.rotation[3] = std::sin(0.39269908f); // 45 degrees about z
    Rules paper;
    paper.footprint = Footprint::three_sigma_square;
    auto const tiles = [&](Rules const& m) {
        auto const s = project(g, make_view(camera, m), tiling);
        std::uint32_t n = 0;
        for (std::uint32_t i = 0; i < 40 * 36; ++i) n += covers(s, tiling, Grid{40, 36}.tile(i)) ? 1 : 0;
        return n;
    };
    // The exact set, in double: v along the needle, w across it.
    double const root = std::sqrt(0.5), var_v = 1e4 + 0.3, var_w = 1.3;
    std::set<std::uint32_t> exact;
    std::uint32_t outside = 0;
    auto const s = project(g, make_view(camera, Rules{}), tiling);
    for (std::uint32_t y = 0; y < 720; ++y)
        for (std::uint32_t x = 0; x < 1280; ++x) {
            double const dx = x + 0.5 - 640, dy = y + 0.5 - 360, v = root * (dx + dy), w = root * (dy - dx);
            if (std::exp(-0.5 * (v * v / var_v + w * w / var_w)) < 1.0 / 255) continue;
            exact.insert(y / 20 * 40 + x / 32);
            auto const r = s.rect();
            outside += x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1 && covers(s, tiling, TileId::at(x / 32, y / 20)) ? 0 : 1;
        }
    CHECK(outside == 0);
    CHECK(exact.size() > 30);
    CHECK(tiles(Rules{}) < tiles(paper));
    stability::report({86, "sigma 100 x 1 px at 45 degrees", std::to_string(tiles(paper)) + " tiles (square of 3 sigma)",
                       std::to_string(tiles(Rules{})) + " tiles (box of 3.33 sigma; exact: " + std::to_string(exact.size()) + "), " +
                           std::to_string(outside) + " pixels outside",
                       "superset", false});
}

TEST_CASE("row 87: large splats are drawn")
{
    // The prototype leaves out splats that are wider than 15 tile diagonals.
    auto const naive_draws = [](double sigma) { return 2 * 3 * sigma * std::sqrt(2.0) <= 15 * std::hypot(32.0, 20.0); };
    auto camera = exact_camera(1280, 720); // the splats on the axis
    camera.cx = 640, camera.cy = 360;
    double worst = 0;
    for (float sigma : {60.0f, 67.0f, 100.0f, 300.0f, 5000.0f}) {
        auto g = at(1, 0, 0, sigma, 1);
        for (float& c : g.colour) c = 1;
        auto const image = stability::render(Kind::mk2, support::map_of({g}), camera).image;
        CHECK(naive_draws(double{sigma}) == (sigma < 66.7f));
        for (std::uint32_t y = 0; y < 720; y += 7)
            for (std::uint32_t x = 0; x < 1280; x += 7) {
                double const dx = x + 0.5 - 640, dy = y + 0.5 - 360;
                double const alpha = std::exp(-0.5 * (dx * dx + dy * dy) / (double{sigma} * double{sigma} + 0.3));
                worst = std::max(worst, 255 * std::fabs(alpha - double{image.pixel(x, y)[0]}));
            }
    }
    CHECK(worst <= 1.001); // pixels under alpha_min are cut
    stability::report(
        {87, "sigma 60 to 5000 px, opacity 1", "nothing drawn from 66.7 px on: 255 levels", number(worst) + " levels off", "1 level", true});
}

TEST_CASE("row 88: ids are integers")
{
    std::uint32_t const first = 16'777'216;
    std::set<float> naive{static_cast<float>(first), static_cast<float>(first + 1)};
    auto runner =
        make_runner(Kind::roomy, support::map_of({at(first, 12, 12, 3, 0.5f), at(first + 1, 20, 12, 3, 0.5f), at(0xffffffffu, 24, 4, 3, 0.5f)}),
                    {.tile = {8, 8}});
    auto const camera = exact_camera(32, 24);
    auto const frame = runner->render(camera);
    auto const ids = runner->owned_ids();
    CHECK(naive.size() == 1);
    CHECK(ids == std::vector<std::uint32_t>{first, first + 1, 0xffffffffu});
    CHECK(runner->differing_pixels(frame, camera) == 0);
    CHECK(runner->wrong_tiles(camera) == 0);
    CHECK_THROWS_AS(make_runner(Kind::roomy, support::map_of({at(0, 12, 12)})), Error); // 0 marks a free slot
    stability::report({88, "ids 16777216 and 16777217", "equal as floats: one is lost", std::to_string(ids.size()) + " of 3 kept", "exact", true});
}

TEST_CASE("row 89: no copy of an earlier view survives a jump")
{
    auto const gaussians = support::cloud(400, 89);
    auto runner = make_runner(Kind::roomy, support::map_of(gaussians), {.grid = {7, 6}});
    std::vector<std::set<std::uint32_t>> naive(42); // an id filter keeps the old copy and refuses the new one
    std::uint32_t naive_wrong = 0, wrong = 0;
    std::uint64_t differing = 0;
    for (float turn : {0.0f, 0.9f, -0.7f, 3.0f, 0.05f, 0.0f, 1.4f}) {
        auto const camera = support::lens(120, 80, turn);
        auto const frame = runner->render(camera);
        wrong += runner->wrong_tiles(camera);
        differing += runner->differing_pixels(frame, camera);
        auto const tiling = runner->tiling();
        std::vector<std::set<std::uint32_t>> truth(42);
        for (auto const& g : gaussians) {
            auto const s = project(g, make_view(camera, Rules{}), tiling);
            for (std::uint32_t t = 0; t < 42; ++t)
                if (covers(s, tiling, runner->grid().tile(t))) truth[t].insert(static_cast<std::uint32_t>(g.id));
        }
        for (std::uint32_t t = 0; t < 42; ++t) {
            naive[t].insert(truth[t].begin(), truth[t].end());
            naive_wrong += naive[t] != truth[t] ? 1 : 0;
        }
    }
    CHECK(naive_wrong > 0);
    CHECK(wrong == 0);
    CHECK(differing == 0);
    stability::report({89, "7 camera jumps, 42 tiles", std::to_string(naive_wrong) + " tiles with stale copies",
                       std::to_string(wrong) + " tiles wrong, " + std::to_string(differing) + " pixels differ", "equals brute force", true});
}

TEST_CASE("row 90: odd frames, empty maps and tiles without pixels")
{
    std::uint64_t differing = 0, unwritten = 0;
    auto const picture = [&](std::vector<Gaussian> const& gaussians, Camera const& camera, RendererOptions const& options) {
        auto runner = make_runner(Kind::roomy, support::map_of(gaussians), options);
        runner->render(camera);
        auto const frame = runner->render(camera);
        differing += runner->differing_pixels(frame, camera);
        CHECK(frame.image.rgb.size() == std::size_t{3} * camera.width * camera.height);
        CHECK(frame.report.lost.empty());
        return frame;
    };
    auto const cloud = support::cloud(200, 90);
    auto const odd = support::lens(1283, 721);
    // If the number of tiles is rounded down, no tile owns the last column and row.
    for (std::uint32_t y = 0; y < 721; ++y)
        for (std::uint32_t x = 0; x < 1283; ++x) unwritten += x >= 1283 / 32 * 32 || y >= 721 / 20 * 20 ? 1 : 0;
    (void)picture(cloud, odd, {.tile = {32, 20}}); // the last tile is 3 x 1
    for (float v : picture({}, odd, {.tile = {32, 20}}).image.rgb)
        if (v != 0) FAIL("an empty map is black");
    (void)picture({cloud[0]}, support::lens(120, 80), {.tile = {32, 20}});
    (void)picture({}, support::lens(1, 1), {.grid = {1, 1}});
    (void)picture(cloud, support::lens(120, 80), {.grid = {1, 1}});
    (void)picture(cloud, support::lens(1, 80), {.tile = {32, 20}});
    (void)picture(cloud, support::lens(100, 60), {.grid = {9, 8}, .tile = {32, 20}}); // 60 tiles own no pixel
    CHECK(unwritten > 0);
    CHECK(differing == 0);
    stability::report({90, "1283 x 721, N = 0 and 1, one tile, tiles without pixels", std::to_string(unwritten) + " pixels never written",
                       std::to_string(differing) + " pixels differ", "exact", true});
}
