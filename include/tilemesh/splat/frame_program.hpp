#pragma once
#include <tilemesh/machine/superstep.hpp>
#include <tilemesh/splat/bloom.hpp>
#include <tilemesh/splat/compositing.hpp>
#include <tilemesh/splat/depth_sort.hpp>
#include <tilemesh/splat/frame_start.hpp>
#include <tilemesh/splat/routing.hpp>
#include <tilemesh/splat/setup.hpp>

namespace tilemesh::splat {

/// One frame: project, route, bloom, sort, composite. Gaussians and copies stay where they are between runs. Steps that a
/// setup does without are not there, and neither are the channels and lists that only they use.
///
/// Bloom's first superstep runs on every tile, because after routing all are quiet: those that Project or routing left owing copies
/// begin to send them there. It sends nothing, and so costs no exchange, where nobody owes.
template <class S>
using Frame = Sequence<Superstep<Project<S>>, StepIf<S::routes, UntilQuiet<Route<S>>>, StepIf<S::blooms, Superstep<Bloom<S>>>,
                       StepIf<S::blooms, UntilQuiet<Bloom<S>>>, Superstep<DepthSort<S>>, Superstep<Composite<S>>>;

/// Where the steps of `Frame<S>` are in its sequence; `none` for one that is not there.
template <class S>
struct FrameSteps {
    static constexpr std::uint32_t none = no_step;
    static constexpr std::uint32_t project = step_of<Frame<S>, Project<S>>();
    static constexpr std::uint32_t route = step_of<Frame<S>, Route<S>>();
    static constexpr std::uint32_t bloom_first = step_of<Frame<S>, Bloom<S>>();
    static constexpr std::uint32_t bloom = step_of<Frame<S>, Bloom<S>, 1>();
    static constexpr std::uint32_t depth_sort = step_of<Frame<S>, DepthSort<S>>();
    static constexpr std::uint32_t composite = step_of<Frame<S>, Composite<S>>();
};

/// At most `hops` supersteps of routing and of bloom a frame; 0: until quiet. What is under way goes on in the next frame.
template <class S>
Frame<S> frame_program(std::uint32_t hops)
{
    Frame<S> frame;
    if constexpr (S::routes) get_step<Route<S>>(frame).at_most = hops == 0 ? 0xffffffffu : hops;
    if constexpr (S::blooms) get_step<Bloom<S>, 1>(frame).at_most = hops == 0 ? 0xffffffffu : hops - 1;
    return frame;
}

} // namespace tilemesh::splat
