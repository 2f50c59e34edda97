#pragma once
#include <tilemesh/machine/superstep.hpp>
#include <tilemesh/splat/bloom.hpp>
#include <tilemesh/splat/compositing.hpp>
#include <tilemesh/splat/depth_sort.hpp>
#include <tilemesh/splat/frame_start.hpp>
#include <tilemesh/splat/routing.hpp>
#include <tilemesh/splat/setup.hpp>

namespace tilemesh::splat {

namespace detail {
template <class S, bool Routes, bool Blooms>
struct FrameOf;
template <class S>
struct FrameOf<S, true, true> {
    using type = Sequence<Superstep<Project<S>>, UntilQuiet<Route<S>>, Superstep<Bloom<S>>, UntilQuiet<Bloom<S>>,
                          Superstep<DepthSort<S>>, Superstep<Composite<S>>>;
};
template <class S>
struct FrameOf<S, true, false> {
    using type = Sequence<Superstep<Project<S>>, UntilQuiet<Route<S>>, Superstep<DepthSort<S>>, Superstep<Composite<S>>>;
};
template <class S>
struct FrameOf<S, false, true> {
    using type = Sequence<Superstep<Project<S>>, Superstep<Bloom<S>>, UntilQuiet<Bloom<S>>, Superstep<DepthSort<S>>,
                          Superstep<Composite<S>>>;
};
template <class S>
struct FrameOf<S, false, false> {
    using type = Sequence<Superstep<Project<S>>, Superstep<DepthSort<S>>, Superstep<Composite<S>>>;
};
} // namespace detail

/// One frame: project, route, bloom, sort, composite. Gaussians and copies stay where they are between runs. Steps that a
/// setup does without are not there, and neither are the channels and lists that only they use.
///
/// Bloom's first superstep runs on every tile, because after routing all are quiet: those that Project or routing left owing copies
/// begin to send them there. It sends nothing, and so costs no exchange, where nobody owes.
template <class S>
using Frame = typename detail::FrameOf<PoliciesOf<S>, S::routes, S::blooms>::type;

/// Where the steps of `Frame<S>` are in its sequence; `none` for one that is not there.
template <class S>
struct FrameSteps {
    static constexpr std::uint32_t none = 0xffffffffu;
    static constexpr std::uint32_t project = 0;
    static constexpr std::uint32_t route = S::routes ? 1 : none;
    static constexpr std::uint32_t bloom_first = S::blooms ? (S::routes ? 2 : 1) : none;
    static constexpr std::uint32_t bloom = S::blooms ? bloom_first + 1 : none;
    static constexpr std::uint32_t depth_sort = 1 + (S::routes ? 1 : 0) + (S::blooms ? 2 : 0);
    static constexpr std::uint32_t composite = depth_sort + 1;
};

/// At most `hops` supersteps of routing and of bloom a frame; 0: until quiet. What is under way goes on in the next frame.
template <class S>
Frame<S> frame_program(std::uint32_t hops)
{
    Frame<S> frame;
    if constexpr (S::routes) std::get<FrameSteps<S>::route>(frame.steps).at_most = hops == 0 ? 0xffffffffu : hops;
    if constexpr (S::blooms) std::get<FrameSteps<S>::bloom>(frame.steps).at_most = hops == 0 ? 0xffffffffu : hops - 1;
    return frame;
}

} // namespace tilemesh::splat
