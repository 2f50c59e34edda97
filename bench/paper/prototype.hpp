#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>

// The authors' prototype as a program on the mesh. It is written from descriptions of the public code of 2024 and 2026; no code is copied.
// It moves one hop a frame and looks at every slot of every buffer. All steps except blending run on one worker. Copies are sent again, and
// back, in every frame. A record or copy that finds no slot is lost. Its counts are of the work that the paper's stage table timed;
// `mk2_prototype()` prices its operations.
//
// It differs from the authors' code in two points. A mean is on one tile (there, tiles overlap by a pixel, and some means are on two or
// four). A copy that leaves the row goes down before up, even if it also goes on along the row.
namespace paper {

using namespace tilemesh;
using splat::Gaussian;
using splat::GaussianId;

/// The operations that take the prototype's time. Its slots have two prices: each slot is looked at once a frame, whatever is in it; and
/// each insertion looks at the records that wait in the list.
struct Operation {
    enum Kind : std::uint32_t { slot, projection, routed, waiting, comparison, pair, pixel };
    static constexpr char const* names[] = {"slot", "projection", "routed", "waiting", "comparison", "pair", "pixel"};
};
using Operations = tilemesh::Operations<Operation>;

/// The slots in the code: 24,000 bytes of a channel and 192,000 bytes of storage, at a stride of 240 bytes per Gaussian (60 floats, of
/// which 15 are used). The paper divides the same bytes by 60: 400 and 3,200 slots.
inline constexpr std::uint32_t coded_channel_slots = 100, coded_storage_slots = 800;
inline constexpr std::uint32_t most_channel_slots = 400, most_storage_slots = 3'400;
/// Means nearer than this are not drawn. They are stored and routed anyway, in front of the camera or behind it.
inline constexpr float prototype_near = 0.2f;
/// A Gaussian is drawn and bloomed only if its box's diagonal is shorter than this many tile diagonals. The paper does not mention this.
inline constexpr float guard_diagonals = 12.0f;

struct Wire : Channel<Gaussian, most_channel_slots> {};
/// Slots; a slot whose id is none is free. The size is always the capacity.
struct Stored : Buffer<Gaussian, most_storage_slots> {};
/// The ids of Stored once more. With them the mesh looks at every slot faster; the price is that of the looks in the prototype.
struct StoredIds : Buffer<GaussianId, most_storage_slots> {};
/// The records that the first half of the prototype's vertex has put into an outgoing channel. The second half adds records, then all
/// leave.
template <std::uint32_t Side>
struct Staged : Buffer<Gaussian, most_channel_slots> {};
/// A Gaussian to draw.
struct Drawn {
    float x, y, conic[3], depth, opacity, colour[3];
};
struct ToDraw : Buffer<Drawn, most_storage_slots> {};
struct Pixels : Buffer<std::uint32_t, 32 * 20> {};
/// The events on a tile in the frame.
struct Happened {
    std::uint32_t arrivals, records, lost, refused, comparisons, pairs_of_worker[6];
    std::uint32_t waiting_received, waiting_sent; ///< records at which insertions looked: while receiving, and while sending
};
struct PrototypeFrame {
    splat::Camera camera;
    std::uint32_t tile_width, tile_height, columns, rows;
    std::uint32_t draws; ///< does this frame sort and blend? A run that only counts moves need not
};

/// The position and shape of a Gaussian on the screen.
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
inline std::int32_t to_pixel(float v) noexcept // NaN and far values must convert to some integer
{
    float const limit = 1e8f;
    return v > -limit && v < limit ? static_cast<std::int32_t>(std::nearbyint(v)) : v > 0 ? 100'000'000 : -100'000'000;
}
inline std::int32_t floor_divide(std::int32_t a, std::int32_t b) noexcept
{
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}
} // namespace detail

/// The tile to which the prototype sends a mean: the pixel, rounded to nearest, divided by the tile size. A mean beside the screen lands on
/// the tile with the resulting row-major number: on the other side, one row away. A mean above or below lands on the first or last tile.
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
/// The projection of 3D Gaussian Splatting, as in the prototype: dilation 0.3, slopes clamped at 1.3 half fields of view, a radius of three
/// standard deviations of the larger axis. The quaternion is taken from the file, with any length.
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
    return 2 * s.radius * std::sqrt(2.0f) < guard_diagonals * std::sqrt(w * w + h * h); // false for NaN
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
/// The side on the way to `to`: along the column first.
constexpr Direction best_direction(TileId from, TileId to) noexcept
{
    if (from.y() != to.y()) return to.y() > from.y() ? Direction::south : Direction::north;
    return to.x() > from.x() ? Direction::east : Direction::west;
}

/// Inserts a Gaussian into a list without holes, unless its id is there. Returns false if the list is full. Adds the records at which it looks.
template <class List>
bool insert_once(List& list, Gaussian const& g, std::uint32_t& looked) noexcept
{
    for (auto const& there : list) {
        ++looked;
        if (there.id == g.id) return true;
    }
    return list.try_push(g);
}
/// The records before the first free slot, or before the id if it is nearer.
inline std::uint32_t waiting_before(StoredIds const& ids, GaussianId id) noexcept
{
    std::uint32_t i = 0;
    while (i < ids.size() && ids[i] != GaussianId::none && ids[i] != id) ++i;
    return i;
}
/// Puts a Gaussian into the first free slot, unless its id is there. Returns false if there is no free slot.
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

/// Reads the channels: right, left, up, down. A record that came nearer to its destination goes on. A record that comes from its
/// destination is a copy and blooms on along the tree. All are stored; those on their own tile stay.
struct Receive {
    void operator()(Here at, In<Wire> in, Stored& stored, StoredIds& ids, Staged<0>& s0, Staged<1>& s1, Staged<2>& s2, Staged<3>& s3,
                    Happened& happened, Broadcast<PrototypeFrame> f) const noexcept
    {
        TileId const here = at.tile;
        happened = {};
        s0.truncate(0), s1.truncate(0), s2.truncate(0), s3.truncate(0);
        auto const stage = [&](Direction d, Gaussian const& g) {
            auto& looked = happened.waiting_received;
            bool const there = d == Direction::north  ? insert_once(s0, g, looked)
                               : d == Direction::east ? insert_once(s1, g, looked)
                               : d == Direction::west ? insert_once(s2, g, looked)
                                                      : insert_once(s3, g, looked);
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
                    // on its own tile
                } else if (distance(here, to) < distance(sender, to)) {
                    stage(best_direction(here, to), g); // on its way; it is also stored, and so sent once more; its id makes both one
                } else {
                    bloom(here, from, g, *f, stage);
                }
                happened.waiting_received += waiting_before(ids, g.id);
                if (!store_once(stored, ids, g)) ++happened.lost;
            }
    }
    static Operations operations(In<Wire> in, Happened const& happened) noexcept
    {
        Operations done;
        done[Operation::slot] = 4 * in[Direction::north].capacity();
        done[Operation::routed] = happened.arrivals;
        done[Operation::waiting] = happened.waiting_received;
        return done;
    }

private:
    /// Blooms on along the row, then down, then up. Along a column it only goes on. A full channel ends it.
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

/// Projects the stored records. A record anchored here blooms to all sides, again in every frame. Any other record leaves towards its
/// anchor, or stays if the channel is full. Both are drawn in this frame.
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
            bool const there = insert_once(out[d], g, happened.waiting_sent);
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
        done[Operation::waiting] = happened.waiting_sent;
        return done;
    }
};

/// Quicksort by depth with the last item as pivot. It is iterative and takes the shorter part first, so that a stack of 32 parts is enough.
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

/// Blends every item of the list at every pixel of the tile. Six workers share the rows. A pixel ends when it is opaque.
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
    /// Six times the busiest worker's pairs, because the tile is done when its last worker is done.
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

/// One frame, which moves records by one hop.
using Prototype = Sequence<Superstep<Receive>, Superstep<ProjectAndRoute>, Superstep<Sort>, Superstep<Blend>>;

} // namespace paper
