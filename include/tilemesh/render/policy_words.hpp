#pragma once
#include <cstdint>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/policies.hpp>
#include <type_traits>

/// The policies of a setup as words of the frame's parameters. So setups that differ in saturation, addressing or copies share one set of
/// policies and its code.
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

}}} // namespace tilemesh::splat
