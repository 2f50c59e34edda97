#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/setup.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <vector>

/// What a host asks of a setup: its ledger, whether it fits, and the setup for another machine, map or tile.
namespace tilemesh { inline namespace v0_2 { namespace render {

using splat::ColourFormat, splat::Setup;
using splat::fitted, splat::with_planes, splat::record_bytes;

/// The SRAM ledger of a tile under a setup, and the sum of its lines that count. It is derived from the program's kernels (`SramLedger`),
/// whose regions say their bytes as functions of the setup.
TILEMESH_HOST std::vector<machine::Region> ledger_of(Setup const& setup);
TILEMESH_HOST std::uint64_t sram_bytes_of(Setup const& setup);

/// Throws Error if a setup does not fit into its machine's SRAM, if it holds without FIFOs, or if a kernel has no counters for the machine's
/// number of workers (`splat::Work::max_workers`).
TILEMESH_HOST void check_setup(Setup const& setup);
/// Returns the setup; throws as `check_setup`.
inline Setup checked(Setup setup)
{
    check_setup(setup);
    return setup;
}

/// The value of a setup type. A setup that does not fit into its machine's SRAM does not compile.
template <class S>
Setup setup_for()
{
    static_assert(Tile<typename S::Machine, splat::Frame<S>, S>::bytes <= S::Machine::sram_bytes);
    static_assert(!S::routes || !S::Saturation::holds || S::sizes.waiting >= 1,
                  "a setup that holds needs FIFOs (without one no credit is ever given and nothing moves); give Sizes::waiting "
                  "room for at least one message");
    static_assert(S::Machine::workers >= 1 && S::Machine::workers <= splat::Work::max_workers,
                  "a machine with more workers than Work counts for; raise Work::max_workers");
    return splat::setup_of<S>();
}
/// The value of a setup type with other sizes. Throws Error if they do not fit.
template <class S>
Setup setup_for(splat::Sizes const& sizes)
{
    auto setup = splat::setup_of<S>();
    setup.sizes = sizes;
    check_setup(setup);
    return setup;
}
/// The value of a setup type. If the options name sizes, it has these sizes.
template <class S>
Setup setup_for(RendererOptions const& options)
{
    return options.sizes ? setup_for<S>(*options.sizes) : setup_for<S>();
}

/// Returns the setup for a grid of tiles of `tile` pixels, with as many slots of storage (homes: as many homes) as the rest of its machine's
/// SRAM has room for: one more does not fit. All other sizes stay, and `fit` is off. Throws Error if the machine has fewer tiles than the
/// grid, or has room for no slot; homes also as `layout_homes`.
TILEMESH_HOST Setup fill_storage(Setup setup, Grid grid, Extent2 tile);

/// Returns the setup on another machine, for tiles of `tile_pixels` pixels. Anchored: if its sizes fit there and have the pixels, they stay.
/// Otherwise the framebuffer has the pixels, channels and FIFOs shrink as the SRAM without the code does (`channel_slots`: they have so many
/// slots, at most the setup's), and storage takes the rest, at least one slot. `check_setup` refuses what does not fit even so. Homes: channels
/// and FIFOs shrink; with `fit`, the layout divides the rest among homes and held splats.
TILEMESH_HOST Setup on_machine(Setup setup, MachineSize const& machine, std::uint32_t tile_pixels, std::uint32_t channel_slots = 0);

}}} // namespace tilemesh::render

namespace tilemesh { inline namespace v0_2 { namespace render::detail {
/// `fill_storage` for homes (detail/homes_layout_code.hpp).
TILEMESH_HOST Setup fill_homes(Setup setup, Grid grid, Extent2 tile);
/// Gives a list, which has one slot, as many as the rest of the SRAM has room for: one more does not fit.
TILEMESH_HOST void fill(Setup& setup, std::uint32_t splat::Sizes::*list, std::uint64_t bytes_with_one);
}}} // namespace tilemesh::render::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/render/detail/setup_code.hpp>
#endif
