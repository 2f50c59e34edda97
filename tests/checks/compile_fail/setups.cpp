// Mistakes in setups of the frame program.
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/splat/frame_program.hpp>
using namespace tilemesh;

struct EightWorkers : Mk2 {
    static constexpr std::uint32_t workers = 8;
};

// CASE hold_without_fifos
// EXPECT: a setup that holds needs FIFOs
#include <tilemesh/render/setup.hpp>
struct Setup : splat::Paper { // whose FIFOs have no slot
    using Saturation = splat::Hold;
};
auto facts() { return render::setup_for<Setup>(); }

// CASE too_many_workers
// EXPECT: a machine with more workers than Work counts for
#include <tilemesh/render/setup.hpp>
struct Setup : splat::Lossless {
    using Machine = EightWorkers;
};
auto facts() { return render::setup_for<Setup>(); }

// CASE mesh_with_too_many_workers
// EXPECT: a machine with more workers than a kernel of this program has words for
auto sizes() { return mesh_sizes<splat::Frame<splat::Lossless>, EightWorkers, splat::Lossless>(); }

// CASE mesh_without_fifos
// EXPECT: a list with fewer slots than its program needs to make progress
struct Setup : splat::Lossless {
    static constexpr splat::Sizes sizes{.storage = 100, .road = 9, .beam = 9, .waiting = 0, .tile_pixels = 64};
};
auto sizes() { return mesh_sizes<splat::Frame<Setup>, Setup::Machine, Setup>(); }

// CASE sizes_mistyped
// EXPECT: (member named .*storage_slot|storage_slot.* does not refer to any field)
struct Setup : splat::Lossless {
    static constexpr splat::Sizes sizes{.storage_slot = 700};
};

// CASE routing_turns_back
// EXPECT: this routing rule is not dimension-ordered
struct LongestFirst { // along the longer way first: it changes from columns to rows and back
    static constexpr char const* name = "longest_first";
    static constexpr Direction first_leg[2] = {Direction::west, Direction::east};
    static constexpr Direction towards(TileId from, TileId to) noexcept
    {
        auto const columns = to.x() > from.x() ? to.x() - from.x() : from.x() - to.x();
        auto const rows = to.y() > from.y() ? to.y() - from.y() : from.y() - to.y();
        if (columns > rows) return to.x() > from.x() ? Direction::east : Direction::west;
        return to.y() > from.y() ? Direction::south : Direction::north;
    }
};
struct Setup : splat::Lossless {
    using Routing = LongestFirst;
};
struct Source { // what an interpreter offers a kernel; never run
    template <class X>
    machine::Place state();
    template <class C>
    machine::Place in(Direction);
    template <class C>
    machine::Place out(Direction);
    template <class P>
    P const* shared();
    Here here();
    Worker worker();
};
Vote run(Source& source) { return run_kernel<splat::Route<Setup>>(source); }
