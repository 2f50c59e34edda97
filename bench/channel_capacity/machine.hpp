#pragma once
#include <cstdint>
#include <memory>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/model.hpp>
#include <vector>

namespace channel_capacity {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;

enum class Saturation { hold, drop };
inline char const* to_string(Saturation s)
{
    return s == Saturation::hold ? "hold" : "drop";
}

/// The grid of every machine here: the paper's, 40 x 36 tiles.
inline constexpr std::uint32_t grid_columns = 40, grid_rows = 36, tiles = grid_columns * grid_rows;

struct Frame {
    report::Image image;
    report::FrameReport report;
};

/// A record on a tile.
struct Stored {
    splat::GaussianId id;
    std::uint32_t tile; ///< index
    bool home;          ///< it is the record itself, on its anchor tile; else a copy, or a record that must leave
};

/// A mesh that renders, with limits that may change between frames; hides which policy it was compiled for.
class Machine {
public:
    struct Options {
        std::uint32_t storage_slots = 0; ///< 0: as many as one slot a channel leaves
        std::uint32_t hops = 0;          ///< a frame; 0: until quiet
    };
    virtual ~Machine() = default;
    virtual Frame render(splat::Camera const&) = 0;
    /// Slots of every channel end and, under `hold`, of each FIFO; 0: more than any frame here needs. Not while records are under way.
    virtual void limit_channels(std::uint32_t slots) = 0;
    /// Another bound on the hops a frame, after the first frame; 0: until quiet. Only for machines that were made with a bound.
    virtual void limit_hops(std::uint32_t hops) = 0;
    virtual std::vector<Stored> stored() = 0;
    virtual splat::Model model() const = 0;
    /// Of the last frame.
    virtual tilemesh::Trace const& trace() const = 0;
};

std::unique_ptr<Machine> make_hold(scene::Map const&, Machine::Options);
std::unique_ptr<Machine> make_drop(scene::Map const&, Machine::Options);
inline std::unique_ptr<Machine> make_machine(Saturation s, scene::Map const& map, Machine::Options options)
{
    return s == Saturation::hold ? make_hold(map, options) : make_drop(map, options);
}

} // namespace channel_capacity
