#pragma once
#include "rows.hpp"
#include <cstdint>
#include <memory>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>

namespace error_vs_time {

/// The paper's tile. A smaller frame has fewer tiles.
inline constexpr std::uint32_t tile_width = 32, tile_height = 20;

/// A mesh that renders with one setting.
class Machine {
public:
    virtual ~Machine() = default;
    /// Renders two views alternately, beginning and ending with the first, with no limit except for storage. Records that were loaded in
    /// file order move to their tiles, and copies are sent.
    virtual void settle(tilemesh::splat::Camera const& first, tilemesh::splat::Camera const& second) = 0;
    /// Renders the next view, with the setting's limits.
    virtual void render(tilemesh::splat::Camera const&) = 0;
    /// The picture and the counters of the last frame.
    virtual report::Image const& image() const = 0;
    virtual report::FrameReport const& counters() const = 0;
    virtual double modelled_ms() = 0;
    virtual double host_ms() const = 0;
};

std::unique_ptr<Machine> make_machine(scene::Map const&, Setting const&, std::uint32_t threads);

} // namespace error_vs_time
