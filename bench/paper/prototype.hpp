#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>

// The authors' prototype as a program on the mesh, from what is known of it (its public code of 2024 and 2026, read and described, not
// copied): one hop a frame, every slot of every buffer looked at, one worker but for blending, copies sent anew and back in every frame,
// what finds no slot lost. Its numbers are what the paper's stage table timed; its operations are what `mk2_prototype()` prices.
//
// Where it differs from that code: a mean is on one tile (there, tiles overlap by a pixel, and some means are on two or four); a copy that
// leaves the row goes down before up whether or not it goes on along the row.
namespace paper {

using namespace tilemesh;
using splat::Gaussian;
using splat::GaussianId;

/// Slots as coded: 24,000 bytes a channel and 192,000 of storage at a stride of 240 bytes a Gaussian (60 floats, 15 of them used).
/// The paper counts the same bytes at 60: 400 and 3,200.
inline constexpr std::uint32_t coded_channel_slots = 100, coded_storage_slots = 800;
inline constexpr std::uint32_t most_channel_slots = 400, most_storage_slots = 3'400;
/// Means nearer than this are not drawn; in front of the camera or behind it they are stored and routed all the same.
inline constexpr float prototype_near = 0.2f;
/// Drawn and bloomed only where the box's diagonal is shorter than so many tile diagonals; the paper does not say so.
inline constexpr float guard_diagonals = 12.0f;

struct Wire : Channel<Gaussian, most_channel_slots> {};
/// Slots, of which those whose id is none are free; always as long as its capacity.
struct Stored : Buffer<Gaussian, most_storage_slots> {
    using Buffer::Buffer;
};
/// The ids of Stored again: the mesh's shortcut for looking at every slot, priced as the looks they stand for.
struct StoredIds : Buffer<GaussianId, most_storage_slots> {
    using Buffer::Buffer;
};
/// What the first half of the prototype's vertex has put into an outgoing channel; the second half adds to it, and then it leaves.
template <std::uint32_t Side>
struct Staged : Buffer<Gaussian, most_channel_slots> {
    using Buffer<Gaussian, most_channel_slots>::Buffer;
};
/// A Gaussian to draw.
struct Drawn {
    float x, y, conic[3], depth, opacity, colour[3];
};
struct ToDraw : Buffer<Drawn, most_storage_slots> {
    using Buffer::Buffer;
};
struct Pixels : Buffer<std::uint32_t, 32 * 20> {
    using Buffer::Buffer;
};
/// What happened on a tile in the frame.
struct Happened {
    std::uint32_t arrivals, records, lost, refused, comparisons, pairs_of_worker[6];
};
struct PrototypeFrame {
    splat::Camera camera;
    std::uint32_t tile_width, tile_height, columns, rows;
    std::uint32_t draws; ///< whether this frame sorts and blends: a mesh that only wants to know who goes where need not
};

/// Where a Gaussian is on the screen.
struct OnScreen {
    float x, y, depth, conic[3], radius;
};

namespace detail {
inline float row(float const (&r)[3], float const (&d)[3]) noexcept
{
    return r[0] * d[0] + r[1] * d[1] + r[2] * d[2];
}
inline void view_of(Gaussian const& g, splat::Camera const& c, float (&v)[3]) noexcept
{
    float const d[3] = {g.mean_world[0] - c.position[0], g.mean_world[1] - c.position[1], g.mean_world[2] - c.position[2]};
    for (int i = 0; i < 3; ++i) v[i] = row(c.rotation[i], d);
}
inline std::int32_t to_pixel(float v) noexcept // what is not a number, or far away, must convert to some integer
{
    float const limit = 1e8f;
    return v > -limit && v < limit ? static_cast<std::int32_t>(std::nearbyint(v)) : v > 0 ? 100'000'000 : -100'000'000;
}
inline std::int32_t floor_divide(std::int32_t a, std::int32_t b) noexcept
{
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}
} // namespace detail

/// The tile that the prototype sends a mean to: the pixel rounded to nearest, then divided; one beside the screen lands on the tile of
/// the row-major number that comes out, on the other side one row further; one above or below at the first or last tile.
inline TileId destination(float x, float y, PrototypeFrame const& f) noexcept
{
    auto const column = detail::floor_divide(detail::to_pixel(x), static_cast<std::int32_t>(f.tile_width));
    auto const row = detail::floor_divide(detail::to_pixel(y), static_cast<std::int32_t>(f.tile_height));
    auto const columns = static_cast<std::int64_t>(f.columns), rows = static_cast<std::int64_t>(f.rows);
    auto number = row * columns + column;
    number = number < 0 ? 0 : number >= columns * rows ? columns * rows - 1 : number;
    return TileId::at(static_cast<std::uint32_t>(number % columns), static_cast<std::uint32_t>(number / columns));
}
inline void project_mean(Gaussian const& g, splat::Camera const& c, float& x, float& y, float& depth) noexcept
{
    float v[3];
    detail::view_of(g, c, v);
    depth = v[2];
    x = c.fx * v[0] / v[2] + c.cx - 0.5f;
    y = c.fy * v[1] / v[2] + c.cy - 0.5f;
}
/// 3D Gaussian Splatting's projection as the prototype has it: dilation 0.3, slopes clamped at 1.3 of the half field of view, three
/// deviations of the larger axis as radius; the quaternion is taken as it is in the file, of whatever length.
inline OnScreen on_screen(Gaussian const& g, splat::Camera const& c) noexcept
{
    OnScreen s{};
    project_mean(g, c, s.x, s.y, s.depth);
    float v[3];
    detail::view_of(g, c, v);
    float const limit_x = 1.3f * 0.5f * static_cast<float>(c.width) / c.fx, limit_y = 1.3f * 0.5f * static_cast<float>(c.height) / c.fy;
    float const tx = std::fmin(limit_x, std::fmax(-limit_x, v[0] / v[2])), ty = std::fmin(limit_y, std::fmax(-limit_y, v[1] / v[2]));
    float const w = g.rotation[0], x = g.rotation[1], y = g.rotation[2], z = g.rotation[3];
    float const r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    float a = 0.3f, b = 0, d = 0.3f;
    for (int k = 0; k < 3; ++k) {
        float const axis[3] = {r[0][k], r[1][k], r[2][k]};
        float const scale = std::exp(g.log_scale[k]);
        float const depth = detail::row(c.rotation[2], axis);
        float const jx = c.fx / v[2] * scale * (detail::row(c.rotation[0], axis) - tx * depth);
        float const jy = c.fy / v[2] * scale * (detail::row(c.rotation[1], axis) - ty * depth);
        a += jx * jx, b += jx * jy, d += jy * jy;
    }
    float const determinant = a * d - b * b, mid = 0.5f * (a + d);
    s.conic[0] = d / determinant, s.conic[1] = -b / determinant, s.conic[2] = a / determinant;
    s.radius = std::ceil(3.0f * std::sqrt(mid + std::sqrt(std::fmax(0.1f, mid * mid - determinant))));
    return s;
}
inline bool within_guard(OnScreen const& s, PrototypeFrame const& f) noexcept
{
    auto const w = static_cast<float>(f.tile_width), h = static_cast<float>(f.tile_height);
    return 2 * s.radius * std::sqrt(2.0f) < guard_diagonals * std::sqrt(w * w + h * h); // false for what is no number
}
/// The sides of a tile across which the box of a Gaussian goes.
inline std::array<bool, 4> sides_crossed(OnScreen const& s, PrototypeFrame const& f, TileId t) noexcept
{
    auto const x0 = static_cast<float>(t.x() * f.tile_width), y0 = static_cast<float>(t.y() * f.tile_height);
    std::array<bool, 4> out{};
    out[index(Direction::west)] = s.x - s.radius < x0;
    out[index(Direction::east)] = std::ceil(s.x + s.radius) >= x0 + static_cast<float>(f.tile_width);
    out[index(Direction::north)] = s.y - s.radius < y0;
    out[index(Direction::south)] = std::ceil(s.y + s.radius) >= y0 + static_cast<float>(f.tile_height);
    return out;
}
constexpr std::uint32_t distance(TileId a, TileId b) noexcept
{
    auto const apart = [](std::uint32_t p, std::uint32_t q) { return p < q ? q - p : p - q; };
    return apart(a.x(), b.x()) + apart(a.y(), b.y());
}
/// Vertical first.
constexpr Direction best_direction(TileId from, TileId to) noexcept
{
    if (from.y() != to.y()) return to.y() > from.y() ? Direction::south : Direction::north;
    return to.x() > from.x() ? Direction::east : Direction::west;
}

/// Into a list without holes, unless its id is there. False where it is full.
template <class List>
bool insert_once(List& list, Gaussian const& g) noexcept
{
    for (auto const& there : list)
        if (there.id == g.id) return true;
    return list.try_push(g);
}
/// Into the first free slot, unless its id is there. False where there is none.
inline bool store_once(Stored& stored, StoredIds& ids, Gaussian const& g) noexcept
{
    std::uint32_t free = ids.size();
    for (std::uint32_t i = ids.size(); i-- > 0;) {
        if (ids[i] == g.id) return true;
        if (ids[i] == GaussianId::none) free = i;
    }
    if (free == ids.size()) return false;
    stored[free] = g;
    ids[free] = g.id;
    return true;
}

/// Reads the channels, right, left, up, down. A record that came nearer to its destination goes on, one that comes from there blooms on
/// along the tree, and all are stored, those at home for good.
struct Receive {
    void operator()(Here at, In<Wire> in, Stored& stored, StoredIds& ids, Staged<0>& s0, Staged<1>& s1, Staged<2>& s2, Staged<3>& s3,
                    Happened& happened, Broadcast<PrototypeFrame> f) const noexcept
    {
        TileId const here = at.tile;
        happened = {};
        s0.truncate(0), s1.truncate(0), s2.truncate(0), s3.truncate(0);
        auto const stage = [&](Direction d, Gaussian const& g) {
            bool const there = d == Direction::north  ? insert_once(s0, g)
                               : d == Direction::east ? insert_once(s1, g)
                               : d == Direction::west ? insert_once(s2, g)
                                                      : insert_once(s3, g);
            happened.refused += there ? 0 : 1;
            return there;
        };
        for (Direction const from : {Direction::east, Direction::west, Direction::north, Direction::south})
            for (Gaussian const& g : in[from]) {
                ++happened.arrivals;
                float x, y, depth;
                project_mean(g, f->camera, x, y, depth);
                TileId const to = destination(x, y, *f);
                TileId const sender = at.grid.neighbour(here, from);
                if (to == here) {
                    // at home
                } else if (distance(here, to) < distance(sender, to)) {
                    stage(best_direction(here, to), g); // on its way; it is stored as well, and sent once more, which its id makes one
                } else {
                    bloom(here, from, g, *f, stage);
                }
                if (!store_once(stored, ids, g)) ++happened.lost;
            }
    }
    static Operations operations(In<Wire> in, Happened const& happened) noexcept
    {
        Operations done;
        done[Operation::slot] = 4 * in[Direction::north].capacity();
        done[Operation::routed] = happened.arrivals;
        return done;
    }

private:
    /// On along the row, then down, then up; along a column only on. One full channel ends it.
    template <class Stage>
    static void bloom(TileId here, Direction from, Gaussian const& g, PrototypeFrame const& f, Stage const& stage) noexcept
    {
        auto const s = on_screen(g, f.camera);
        if (!within_guard(s, f)) return;
        auto const crossed = sides_crossed(s, f, here);
        auto const wants = [&](Direction d) { return crossed[index(d)]; };
        bool ok = true;
        if (wants(opposite(from))) ok = stage(opposite(from), g);
        if (from == Direction::north || from == Direction::south) return;
        for (Direction const d : {Direction::south, Direction::north})
            if (ok && wants(d)) ok = stage(d, g);
    }
};

/// Projects what is stored. What is anchored here blooms to all sides, again in every frame; what is not leaves towards its anchor, or
/// stays where the channel is full. Both are drawn in this frame.
struct ProjectAndRoute {
    void operator()(Here at, Stored& stored, StoredIds& ids, Staged<0> const& s0, Staged<1> const& s1, Staged<2> const& s2,
                    Staged<3> const& s3, ToDraw& drawn, Happened& happened, Broadcast<PrototypeFrame> f, Out<Wire> out) const noexcept
    {
        TileId const here = at.tile;
        for (auto const& g : s0) out[Direction::north].unchecked_push(g);
        for (auto const& g : s1) out[Direction::east].unchecked_push(g);
        for (auto const& g : s2) out[Direction::west].unchecked_push(g);
        for (auto const& g : s3) out[Direction::south].unchecked_push(g);
        auto const send = [&](Direction d, Gaussian const& g) {
            bool const there = insert_once(out[d], g);
            happened.refused += there ? 0 : 1;
            return there;
        };
        drawn.truncate(0);
        for (std::uint32_t i = 0; i < ids.size(); ++i) {
            if (ids[i] == GaussianId::none) continue;
            ++happened.records;
            Gaussian const g = stored[i];
            auto const s = on_screen(g, f->camera);
            bool const visible = within_guard(s, *f) && s.depth > prototype_near;
            if (TileId const to = destination(s.x, s.y, *f); to == here) {
                auto const crossed = sides_crossed(s, *f, here);
                bool ok = within_guard(s, *f);
                for (Direction const d : {Direction::east, Direction::west, Direction::north, Direction::south})
                    if (ok && crossed[index(d)]) ok = send(d, g);
            } else if (send(best_direction(here, to), g)) {
                ids[i] = GaussianId::none;
            }
            if (visible)
                drawn.unchecked_push({s.x, s.y, {s.conic[0], s.conic[1], s.conic[2]}, s.depth, g.opacity,
                                      {g.colour[0], g.colour[1], g.colour[2]}});
        }
    }
    static Operations operations(StoredIds const& ids, Happened const& happened) noexcept
    {
        Operations done;
        done[Operation::slot] = ids.size();
        done[Operation::projection] = happened.records;
        return done;
    }
};

/// Quicksort by depth with the last item as pivot, iterative; the shorter part first, so that a stack of 32 parts is enough.
struct Sort {
    void operator()(ToDraw& drawn, Happened& happened, Broadcast<PrototypeFrame> f) const noexcept
    {
        if (f->draws == 0 || drawn.size() < 2) return;
        struct Part {
            std::uint32_t low, high;
        } stack[32] = {{0, drawn.size() - 1}};
        for (std::uint32_t depth = 1; depth > 0;) {
            auto part = stack[--depth];
            while (part.low < part.high) {
                float const pivot = drawn[part.high].depth;
                std::uint32_t at = part.low;
                for (std::uint32_t i = part.low; i < part.high; ++i) {
                    ++happened.comparisons;
                    if (drawn[i].depth <= pivot) swap(drawn, i, at++);
                }
                swap(drawn, at, part.high);
                Part left{part.low, at > part.low ? at - 1 : part.low}, right{at + 1, part.high};
                bool const left_is_longer = at - part.low > part.high - at;
                Part const longer = left_is_longer ? left : right;
                part = left_is_longer ? right : left;
                if (longer.low < longer.high) stack[depth++] = longer;
            }
        }
    }
    static Operations operations(Happened const& happened) noexcept
    {
        Operations done;
        done[Operation::comparison] = happened.comparisons;
        return done;
    }

private:
    static void swap(ToDraw& drawn, std::uint32_t i, std::uint32_t j) noexcept
    {
        Drawn const held = drawn[i];
        drawn[i] = drawn[j];
        drawn[j] = held;
    }
};

/// Blends every item of the list at every pixel of the tile, rows dealt to six workers; a pixel ends where it is opaque.
struct Blend {
    void operator()(Here at, ToDraw const& drawn, Pixels& pixels, Happened& happened, Broadcast<PrototypeFrame> f) const noexcept
    {
        TileId const here = at.tile;
        if (f->draws == 0) return;
        pixels.truncate(0);
        for (std::uint32_t y = 0; y < f->tile_height; ++y)
            for (std::uint32_t x = 0; x < f->tile_width; ++x) {
                auto const px = static_cast<float>(here.x() * f->tile_width + x), py = static_cast<float>(here.y() * f->tile_height + y);
                float left = 1, rgb[3] = {0, 0, 0};
                for (auto const& d : drawn) {
                    ++happened.pairs_of_worker[y % 6];
                    float const dx = d.x - px, dy = d.y - py;
                    float const power = -0.5f * (d.conic[0] * dx * dx + d.conic[2] * dy * dy) - d.conic[1] * dx * dy;
                    if (power > 0) continue;
                    float const alpha = std::fmin(0.99f, d.opacity * std::exp(power));
                    if (alpha < 1.0f / 255.0f) continue;
                    if (left * (1 - alpha) < 1e-4f) break;
                    for (int i = 0; i < 3; ++i) rgb[i] += d.colour[i] * alpha * left;
                    left *= 1 - alpha;
                }
                std::uint32_t word = 0;
                for (int i = 0; i < 3; ++i) word |= static_cast<std::uint32_t>(255.0f * std::fmin(1.0f, std::fmax(0.0f, rgb[i]))) << (8 * i);
                pixels.unchecked_push(word);
            }
    }
    /// Six times the busiest worker's pairs: the tile is done when the last of its six workers is.
    static Operations operations(Happened const& happened, Pixels const& pixels) noexcept
    {
        Operations done;
        std::uint32_t most = 0;
        for (auto const n : happened.pairs_of_worker) most = n > most ? n : most;
        done[Operation::pair] = 6 * most;
        done[Operation::pixel] = pixels.size();
        return done;
    }
};

/// One frame: one hop.
using Prototype = Sequence<Superstep<Receive>, Superstep<ProjectAndRoute>, Superstep<Sort>, Superstep<Blend>>;

} // namespace paper
