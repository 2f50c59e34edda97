#pragma once
#include <cstdint>
#include <cstring>
#include <optional>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/splat/frame_program.hpp>
#include <tilemesh/splat/view.hpp>
#include <type_traits>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// May tiles keep their pixels? With parameters of the user's own, the host cannot know what compositing reads.
template <class P>
inline constexpr bool may_keep_pixels =
    std::is_same_v<typename P::Parameters, splat::TableParameters> || std::is_same_v<typename P::Parameters, splat::HostParameters>;

/// Knows which tiles show their splats already, so that the host need not composite them again.
///
/// A tile's pixels and its counters of pairs follow from the tile's list of splats and from the frame's parameters. A tile keeps both if
/// - every byte of the parameters (view with camera and rules of the picture, tiling, rules of the setup, addresses of the table) is that of
///   the last run. The parameters are compared byte by byte, except the three flags and the address that only projection, routing and bloom read; and
/// - the tile's list did not change since: `Counts::changes` was 0 when DepthSort looked. Whoever changes the slots of a tile counts that, so
///   DepthSort already relies on it.
/// Nothing is hashed. In an unchanged view, a tile composites if a record came or left, also if the record that left did not touch the tile.
///
/// The modelled machine composites every tile: passes, pairs, digests and traces are those of a run in which nothing is kept. A renderer
/// that moves records by value has the machine's parameters, so its tiles always composite; so do those of a parameter type of the user's,
/// whose pointers may lead to words that change.
///
/// Call `begin_run` before each run, with complete parameters, and `forget` when the pixels of the tiles are lost: on a new mesh, and when
/// the framebuffers are sized. Cost: a byte per tile, and a pass over these bytes in each run.
class KeptPixels {
public:
    /// `keeps`: false lets every tile composite in every run.
    explicit KeptPixels(bool keeps) : keeps_(keeps) {}

    /// The next run composites every tile.
    void forget() noexcept { shown_.reset(); }

    /// Decides for the next run which tiles keep their pixels, and writes that into the parameters.
    void begin_run(splat::TableParameters& frame, Grid grid)
    {
        if (!keeps_) return;
        stale_.resize(grid.size());
        frame.stale = splat::HostPointer<std::uint8_t>(stale_.data());
        auto now = frame;
        now.view_changed = now.resend_copies = now.readdress = 0;
        now.before = {};
        bool const same = shown_ && std::memcmp(&*shown_, &now, sizeof now) == 0;
        for (auto& tile : stale_) tile = same ? 0 : 1; // DepthSort sets it for tiles whose list changes
        shown_ = now;
    }

    /// The number of tiles of the picture that composited in the last run.
    std::uint32_t composited(splat::Tiling const& tiling, Grid grid) const noexcept
    {
        if (!keeps_) return tiling.columns * tiling.rows;
        std::uint32_t n = 0;
        for (std::uint32_t y = 0; y < tiling.rows; ++y)
            for (std::uint32_t x = 0; x < tiling.columns; ++x) n += stale_[grid.index_of(TileId::at(x, y))];
        return n;
    }

private:
    static_assert(std::is_trivially_copyable_v<splat::TableParameters> && alignof(splat::TableParameters) == 4,
                  "the parameters are whole words, so they have no padding to compare");

    bool keeps_;
    std::vector<std::uint8_t> stale_;              ///< by tiles: 1 if the tile composites in this run
    std::optional<splat::TableParameters> shown_;  ///< the parameters of the last run, without the flags that do not matter
};

}}} // namespace tilemesh::render
