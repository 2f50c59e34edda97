#pragma once
#include <cstdint>
#include <memory>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>

namespace bench {

/// The settings of a machine with the program of homes.
struct HomesSetting {
    std::uint32_t held = 0;  ///< 0: the setup's
    std::uint32_t homes = 0; ///< records that live on a tile; 0: the setup's. A map with more records comes in chapters
    std::uint32_t slots = 0; ///< of a channel end, and of each FIFO; 0: the setup's
    bool folded = true;
    tilemesh::splat::Rules rules = precise();
    bool one_cut = false;    ///< the frame in slices of depth: all tiles have one window (see OneCut in homes_machine.cpp)
    std::uint32_t threads = 1;
    tilemesh::Grid grid{40, 36};

    /// The arithmetic of the naive loop, with which pictures are compared.
    static tilemesh::splat::Rules precise()
    {
        tilemesh::splat::Rules rules;
        rules.arithmetic = tilemesh::splat::Arithmetic::precise;
        return rules;
    }
};

/// A mesh with the program of homes, and a trace.
class HomesMachine {
public:
    virtual ~HomesMachine() = default;
    virtual void render(tilemesh::splat::Camera const&) = 0;
    virtual tilemesh::report::Image const& image() const = 0;
    virtual tilemesh::report::FrameReport const& report() const = 0;
    /// The trace of the last frame.
    virtual tilemesh::Trace const& trace() const = 0;
    virtual HomesSetting const& setting() const = 0; ///< without zeros
    /// The bytes of a tile, after a frame. They may be more than Mk2 has: a sweep also shows settings that no tile of Mk2 could hold.
    virtual std::uint64_t sram_bytes() const = 0;
};
std::unique_ptr<HomesMachine> make_homes_machine(tilemesh::scene::Map const&, HomesSetting const&);

/// The splats that a tile of Mk2 can hold beside homes for `records` records and channels and FIFOs of `slots` slots, for frames of
/// width x height pixels; 0: the others leave no room.
std::uint32_t most_held(std::uint64_t records, std::uint32_t slots, tilemesh::Grid grid, std::uint32_t width, std::uint32_t height);

} // namespace bench
