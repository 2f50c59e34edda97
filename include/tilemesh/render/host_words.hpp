#pragma once
#include <cstdint>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/policies.hpp>
#include <type_traits>

/// The words of the host's form (host_form.hpp): references to rows of its table, and the policies of a setup as words of the frame's
/// parameters. So setups that differ in saturation, addressing or copies share one set of policies and its code.
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The policies of a setup as values, and the bytes of its messages on the machine.
struct PolicyWords {
    std::uint32_t holds, carried, reusable; ///< 0 or 1
    std::uint32_t road_bytes, beam_bytes;
    std::uint32_t ranks = 0; ///< 1: LargestFirst
};
template <class S>
constexpr PolicyWords policies_of() noexcept
{
    constexpr auto words = frame_words<S>();
    return {S::Saturation::holds ? 1u : 0u, S::Addressing::carried ? 1u : 0u, S::Copies::reusable ? 1u : 0u, words.road_message,
            words.beam_message, may_rank<typename S::Saturation> ? 1u : 0u};
}

/// Do the frame's parameters have the setup's rules, as TableParameters and PolicyParameters do?
template <class Parameters, class = void>
inline constexpr bool has_policies = false;
template <class Parameters>
inline constexpr bool has_policies<Parameters, std::void_t<decltype(Parameters::policies)>> = true;

/// Policies whose rule is a word in the frame's parameters.
struct RunTimeSaturation {
    static constexpr char const* name = "at run time";
    static constexpr bool may_hold = true, may_rank = true;
    template <class Parameters>
    TILEMESH_KERNEL static bool holds_in(Parameters const& frame) noexcept { return frame.policies.holds != 0; }
    template <class Parameters>
    TILEMESH_KERNEL static bool ranks_in(Parameters const& frame) noexcept { return frame.policies.ranks != 0; }
};
struct RunTimeAddressing : Carried {
    static constexpr char const* name = "at run time";
    template <class Parameters>
    TILEMESH_KERNEL static bool carried_in(Parameters const& frame) noexcept { return frame.policies.carried != 0; }
};

/// A record's place in the host's table, with its id.
struct Reference {
    GaussianId id;
    std::uint32_t row;
};

/// An entry of `Splats`: a row of the host's table.
struct SplatRow {
    std::uint32_t row;
};

/// An address in the host's memory, as words of a broadcast.
template <class T>
class HostPointer {
public:
    HostPointer() noexcept = default;
    explicit HostPointer(T* p) noexcept { __builtin_memcpy(words_, &p, sizeof p); }
    TILEMESH_KERNEL T* get() const noexcept
    {
        T* p;
        __builtin_memcpy(&p, words_, sizeof words_);
        return p;
    }

private:
    std::uint32_t words_[sizeof(T*) / 4] = {};
};

/// The changes to a record in a new view, as far as tiles need them. It is one byte, so that the table of a whole map stays in the caches
/// nearest to the processor.
struct RowState {
    static constexpr std::uint8_t visible = 1;
    static constexpr std::uint8_t moved = 2;    ///< touches other tiles, has another anchor, or was put on the mesh by the host
    static constexpr std::uint8_t appeared = 4; ///< appeared or disappeared
};

/// The tiles that a record touches in a view, as the first and the last one, and its anchor tile.
struct TouchedTiles {
    TileId first, last, anchor;
    std::uint32_t visible; ///< 0 or 1
};

/// The tiles on which a record, or a copy of it, may have been when a view began: from the first to the last.
struct TileSpan {
    TileId first, last;
    static constexpr TileSpan all() noexcept { return {TileId::at(0, 0), TileId::at(0xffff, 0xffff)}; }
    constexpr bool has(TileId t) const noexcept
    {
        return t.x() >= first.x() && t.x() <= last.x() && t.y() >= first.y() && t.y() <= last.y();
    }
};
}}} // namespace tilemesh::splat
