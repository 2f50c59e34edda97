#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/arena.hpp>
#include <tilemesh/engine/contract.hpp>
#include <tilemesh/engine/quiet_change.hpp>
#include <tilemesh/engine/rectangle.hpp>
#include <tilemesh/engine/run.hpp>
#include <tilemesh/engine/store_view.hpp>
#include <tilemesh/engine/trace.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// The rules that CheckedMesh checks, and its supersteps, for any program: the tables of the program stand for its types, and a function
/// runs a kernel on a tile.
class Checker {
public:
    /// One side of a channel on all tiles: {size, note, unused, guard}, and guarded items for each slot.
    struct Ends {
        std::vector<std::array<std::uint32_t, 4>> heads;
        Arena items;
        std::size_t stride = 0;
        std::uint32_t capacity = 0;
        machine::Place at(std::uint32_t slot) noexcept
        {
            return {heads[slot].data(), items.data() + slot * stride + guard_words_around, capacity};
        }
    };
    /// The steps of a mesh of known type. `run` and `sample`: by steps.
    struct Steps {
        ProgramFacts const* program;
        Vote (*const* run)(void* mesh, std::uint32_t tile, Worker share);
        /// Appends what the kernel did on a tile to the trace; null on a machine that is not Traced.
        void (*const* sample)(void* mesh, std::uint32_t tile, SuperstepSample& to);
        void* mesh;
        bool check_quiet_tiles;
        Rectangle const* rectangle; ///< Superstep and Repeat run all of its tiles; an observer may change it
    };

    explicit Checker(StoreView const& store);

    std::vector<Ends> in, out; ///< by channels

    /// Gives a channel ends of its present capacity.
    void make_end(StoreView const& store, std::uint32_t link);
    void limit_link(StoreView const& store, std::uint32_t link, std::uint32_t items);
    /// Runs the program once. Call `RunState::begin` first. Throws Error if no tile ran, but a kernel would have changed a word of a tile.
    RunCounters run(StoreView const& store, RunState& run, Steps const& steps, RunState::Limits const& limits);

private:
    struct Step; // a superstep in progress

    void begin();
    bool any_busy() const noexcept;
    std::uint64_t digest(StoreView const& store);
    Passed superstep(StoreView const& store, RunState& run, Steps const& steps);
    bool unread(std::uint32_t link, std::uint32_t tile);

    std::vector<std::uint8_t> busy_[2];
    std::uint32_t parity_ = 0;
    std::vector<std::uint32_t> state_peak_, link_peak_;
    std::vector<std::vector<std::uint32_t>> most_; ///< by states, then tiles: the items of a list that are not poisoned
    KernelFacts const* last_kernel_ = nullptr;     ///< of the superstep before; null at the start of a run
    std::string would_run_;             ///< the first kernel that no tile ran, as nobody had voted, but that would have changed a word; the tile
    std::vector<std::uint32_t> before_; ///< the states of a tile that need not run, saved before the kernel is tried on it
    detail::BrokenContracts broken_;
};

}}} // namespace tilemesh::engine

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/engine/detail/checker_code.hpp>
#endif
