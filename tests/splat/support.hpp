#pragma once
#include "../standard.hpp"
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/naive.hpp>

namespace support {
using namespace tilemesh;

using tests::fast;

/// The folder with real maps, from the environment variable TILEMESH_DATA or the build's option of that name; empty if neither is set.
inline std::filesystem::path data()
{
    char const* folder = std::getenv("TILEMESH_DATA");
#ifdef TILEMESH_TEST_DATA
    if (folder == nullptr) folder = TILEMESH_TEST_DATA;
#endif
    if (folder == nullptr || *folder == '\0') return {};
    std::filesystem::path const path = folder;
    return std::filesystem::is_directory(path / "maps") ? path : std::filesystem::path{};
}

using tests::Random;

/// Looks along +z from the origin through a long lens: a mean at (x, y, 1000) falls on pixel coordinate (x, y), and one world unit at that
/// depth is one pixel.
inline splat::Camera flat_camera(std::uint32_t width, std::uint32_t height)
{
    splat::Camera c{};
    for (int i = 0; i < 3; ++i) c.rotation[i][i] = 1;
    c.fx = c.fy = 1000;
    c.near_depth = 0.2f;
    c.width = width;
    c.height = height;
    return c;
}

/// An opaque-ish ball of standard deviation `sigma` pixels at pixel coordinate (x, y) of `flat_camera`, at depth 1000.
inline splat::Gaussian ball(std::uint32_t id, float x, float y, float sigma = 0.01f, float opacity = 0.9f)
{
    return {{x, y, 1000}, {0.2f, 0.5f, 0.8f}, opacity, {1, 0, 0, 0}, {std::log(sigma), std::log(sigma), std::log(sigma)},
            splat::GaussianId{id}};
}

/// A cloud in front of `lens`: balls, needles and discs, many of them larger than a tile, ties in depth.
inline std::vector<splat::Gaussian> cloud(std::uint32_t n, std::uint64_t seed)
{
    Random random(seed);
    std::vector<splat::Gaussian> out;
    for (std::uint32_t i = 0; i < n; ++i) {
        splat::Gaussian g{};
        float const z = 1.0f + 0.25f * static_cast<float>(random.below(12)); // ties
        g.mean_world[0] = random.uniform(-0.9f, 0.9f) * z;
        g.mean_world[1] = random.uniform(-0.6f, 0.6f) * z;
        g.mean_world[2] = z;
        for (float& c : g.colour) c = random.uniform(0, 1.5f);
        g.opacity = random.below(20) == 0 ? 1.0f : random.uniform(0.002f, 1.0f);
        for (float& q : g.rotation) q = random.uniform(-1, 1);
        for (float& s : g.log_scale) s = random.uniform(-7.0f, random.below(8) == 0 ? -0.7f : -3.0f);
        g.id = splat::GaussianId{i + 1};
        out.push_back(g);
    }
    return out;
}
/// A camera for `cloud`, turned by `turn` radians about y.
inline splat::Camera lens(std::uint32_t width, std::uint32_t height, float turn = 0)
{
    splat::Camera c = flat_camera(width, height);
    c.rotation[0][0] = c.rotation[2][2] = std::cos(turn);
    c.rotation[0][2] = std::sin(turn);
    c.rotation[2][0] = -std::sin(turn);
    c.fx = c.fy = 0.6f * static_cast<float>(width);
    c.cx = 0.5f * static_cast<float>(width);
    c.cy = 0.5f * static_cast<float>(height) + 0.25f;
    return c;
}

/// Writes over a value of the record's mean, rotation, scales and opacity with probability 1 / `one_in`: with signed zeros, numbers at the ends
/// of float, infinities and NaN.
inline void spoil(splat::Gaussian& g, Random& random, std::uint32_t one_in)
{
    constexpr float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    constexpr float odd[] = {0,    -0.0f, 1,      -1,    1e-38f, 1e-20f, -1e-3f,   0.2f,      0.21f, 3,
                             1e5f, 1e18f, -1e19f, 1e25f, -1e30f, 3e38f,  infinity, -infinity, nan};
    auto const over = [&](float& v) {
        if (random.below(one_in) == 0) v = odd[random.below(std::size(odd))];
    };
    for (float& v : g.mean_world) over(v);
    for (float& v : g.rotation) over(v);
    for (float& v : g.log_scale) over(v);
    over(g.opacity);
}

inline scene::Map map_of(std::vector<splat::Gaussian> gaussians)
{
    scene::Map map;
    map.name = "test";
    map.gaussians = std::move(gaussians);
    return map;
}

/// Have two lists the same bits?
template <class List>
bool same_bits(List const& a, List const& b)
{
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
}
/// The number of pixels of two pictures that differ in any bit.
inline std::uint64_t differing_pixels(report::Image const& a, report::Image const& b)
{
    if (a.width != b.width || a.height != b.height) return ~std::uint64_t{0};
    std::uint64_t n = 0;
    for (std::uint32_t y = 0; y < a.height; ++y)
        for (std::uint32_t x = 0; x < a.width; ++x) n += std::memcmp(a.pixel(x, y), b.pixel(x, y), 12) != 0 ? 1 : 0;
    return n;
}

/// The visible splats of a view, front to back.
template <class Record>
std::vector<splat::Splat> sorted_splats(std::vector<Record> const& records, splat::View const& view)
{
    std::vector<splat::Splat> all, sorted;
    std::vector<splat::SortKey> keys;
    for (auto const& g : records) {
        auto const s = splat::project(g, view, splat::TileSize{view.camera.width, view.camera.height});
        if (s.visible()) keys.push_back({s.depth_key, g.id, static_cast<std::uint32_t>(all.size())}), all.push_back(s);
    }
    std::sort(keys.begin(), keys.end());
    for (auto const& key : keys) sorted.push_back(all[key.slot]);
    return sorted;
}

/// The records that a frame's report lists as missing, for the naive picture.
class Missing {
public:
    Missing(report::FrameReport const& r, splat::Tiling const& tiling, Grid grid) : tiling_(tiling), grid_(grid)
    {
        for (auto const& l : r.lost)
            if (l.tile == report::Loss::whole)
                whole_.insert(l.id);
            else
                copies_.insert({l.id, l.tile});
    }
    bool operator()(splat::GaussianId id, std::uint32_t x, std::uint32_t y) const
    {
        return whole_.count(id) != 0 ||
               (!copies_.empty() &&
                copies_.count({id, grid_.index_of(TileId::at(x / tiling_.tile_width, y / tiling_.tile_height))}) != 0);
    }

private:
    splat::Tiling tiling_;
    Grid grid_;
    std::set<splat::GaussianId> whole_;
    std::set<std::pair<splat::GaussianId, std::uint32_t>> copies_;
};

/// A setup's sizes with `slots` a channel end, `records` of storage and `fifo` in each FIFO.
template <class S>
constexpr splat::Sizes sized(std::uint32_t slots, std::uint32_t records, std::uint32_t fifo)
{
    auto sizes = S::sizes;
    sizes.storage = records;
    sizes.road = sizes.beam = slots;
    sizes.waiting = fifo;
    return sizes;
}
template <class S>
constexpr splat::Sizes sized(std::uint32_t slots, std::uint32_t records)
{
    return sized<S>(slots, records, slots);
}

/// `Base` on any number of tiles of up to 128 x 128 pixels, with room for the records of the tests. A test that needs other sizes sets them
/// in the options, so that all tests share the code of one setup.
template <class Base = splat::Lossless>
struct Room : Base {
    using Machine = TestMachine<64u << 20>;
    static constexpr splat::Sizes sizes{/*storage*/ 1000,        /*road*/ 400,       /*beam*/ 400, /*waiting*/ 400,
                                        /*tile_pixels*/ 128 * 128, /*lists_fit*/ true, Base::sizes.one_channel_memory};
    static constexpr splat::Arithmetic arithmetic = splat::Arithmetic::precise; // because it is compared with the naive loop
};

/// `Room` with other sizes, as a setup of its own: for code that needs a type.
template <std::uint32_t Slots, std::uint32_t Records, class Base = splat::Lossless, std::uint32_t Fifo = Slots>
struct Small : Room<Base> {
    static constexpr splat::Sizes sizes = sized<Room<Base>>(Slots, Records, Fifo);
};

/// Puts a record onto a tile, as a host would.
template <class S, class M>
bool put(M& mesh, TileId t, splat::Gaussian const& g)
{
    auto storage = mesh.template state<splat::Storage<S>>(t);
    auto marks = mesh.template state<splat::Marks<S>>(t);
    auto splats = mesh.template state<splat::Splats<S>>(t);
    if (!storage.try_push(g)) return false;
    marks.unchecked_push({g.id, 0});
    splats.unchecked_push({});
    return true;
}

/// Every id that the mesh owns (stored as anchored, under way or waiting), sorted. An id that is owned twice occurs twice.
template <class S, class M>
std::vector<std::uint32_t> owned_ids(M& mesh)
{
    std::vector<std::uint32_t> ids;
    auto const grid = mesh.grid();
    auto const add = [&](splat::GaussianId id) { ids.push_back(static_cast<std::uint32_t>(id)); };
    for (std::uint32_t i = 0; i < grid.size(); ++i) {
        auto const t = grid.tile(i);
        for (auto const& m : mesh.template state<splat::Marks<S>>(t))
            if (!m.is(splat::Mark::copy)) add(m.id);
        if constexpr (S::routes)
            for (Direction d : news)
                for (auto const& m : mesh.template incoming<splat::Road<S>>(t, d)) add(S::Addressing::record(m).id);
        if constexpr (S::routes && S::Saturation::may_hold) {
            for (auto const& m : mesh.template state<splat::Waiting<S, 0>>(t)) add(S::Addressing::record(m).id);
            for (auto const& m : mesh.template state<splat::Waiting<S, 1>>(t)) add(S::Addressing::record(m).id);
        }
    }
    std::sort(ids.begin(), ids.end());
    return ids;
}

/// The tiles whose records differ from brute force. A record must be anchored exactly on its anchor tile (a parked one anywhere, once), and
/// a copy must be on exactly the other tiles that its footprint touches. `marks_of(tile)`: the marks of the tile's records.
template <class MarksOf>
std::uint32_t wrong_tiles_of(Grid grid, MarksOf const& marks_of, std::vector<splat::Gaussian> const& gaussians, splat::View const& view,
                             splat::Tiling const& tiling)
{
    std::vector<std::set<std::uint32_t>> want(grid.size()), have(grid.size());
    std::vector<bool> twice(grid.size(), false);
    std::set<std::uint32_t> parked;
    for (auto const& g : gaussians) {
        auto const s = splat::project(g, view, tiling);
        auto const id = static_cast<std::uint32_t>(g.id);
        if (!s.visible()) {
            parked.insert(id);
            continue;
        }
        for (std::uint32_t i = 0; i < grid.size(); ++i)
            if (splat::covers(s, tiling, grid.tile(i))) want[i].insert(id << 1 | (s.anchor == grid.tile(i) ? 1u : 0u));
    }
    std::uint32_t parked_seen = 0;
    for (std::uint32_t i = 0; i < grid.size(); ++i)
        for (auto const& m : marks_of(grid.tile(i))) {
            auto const id = static_cast<std::uint32_t>(m.id);
            bool const copy = m.is(splat::Mark::copy);
            if (!copy && parked.count(id) != 0) {
                ++parked_seen;
                continue;
            }
            if (!have[i].insert(id << 1 | (copy ? 0u : 1u)).second || m.is(splat::Mark::leaving)) twice[i] = true;
        }
    std::uint32_t wrong = parked_seen == parked.size() ? 0 : 1;
    for (std::uint32_t i = 0; i < grid.size(); ++i) wrong += want[i] != have[i] || twice[i] ? 1 : 0;
    return wrong;
}
template <class S, class M>
std::uint32_t wrong_tiles(M& mesh, std::vector<splat::Gaussian> const& gaussians, splat::View const& view, splat::Tiling const& tiling)
{
    return wrong_tiles_of(
        mesh.grid(), [&](TileId tile) { return mesh.template state<splat::Marks<S>>(tile); }, gaussians, view, tiling);
}

} // namespace support
