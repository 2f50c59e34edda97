#pragma once
#include <tilemesh/machine/superstep.hpp>
#include <tilemesh/splat/bloom.hpp>
#include <tilemesh/splat/compositing.hpp>
#include <tilemesh/splat/depth_sort.hpp>
#include <tilemesh/splat/frame_start.hpp>
#include <tilemesh/splat/routing.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace detail {
/// The optional steps are in the program by the setup's type, or under a condition if the parameters have words for them.
template <class S, bool ByWords = has_parts_words<typename S::Parameters>>
struct FrameOf {
    using type = Sequence<Superstep<Project<S>>, StepIf<S::routes, UntilQuiet<Route<S>>>, StepIf<S::blooms, Superstep<Bloom<S>>>,
                          StepIf<S::blooms, UntilQuiet<Bloom<S>>>, Superstep<DepthSort<S>>, Superstep<Composite<S>>>;
};
template <class S>
struct FrameOf<S, true> {
    using type = Sequence<Superstep<Project<S>>, If<&S::Parameters::routes, UntilQuiet<Route<S>>>,
                          If<&S::Parameters::blooms, Superstep<Bloom<S>>, UntilQuiet<Bloom<S>>>,
                          If<&S::Parameters::draws, Superstep<DepthSort<S>>, Superstep<Composite<S>>>>;
};
} // namespace detail

/// One frame: project, route, bloom, sort, composite. Gaussians and copies stay on their tiles between runs. If a setup leaves out a step,
/// the program has neither the step nor the channels and lists that only this step uses. A host's program may have all steps under a
/// condition (`has_parts_words`): then a frame without a step does not run it, and a run may end before the picture.
///
/// Bloom's first pass runs on every tile, because all tiles are quiet after routing. In this pass, the tiles that owe copies begin to send
/// them. If no tile owes a copy, the pass sends nothing and costs no exchange.
template <class S>
using Frame = typename detail::FrameOf<S>::type;

/// The places of the steps of `Frame<S>` in its sequence; `none` for a step that the setup leaves out.
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

/// Returns the frame program with at most `hops` supersteps of routing and of bloom per frame; 0 means until quiet. Records that are still
/// under way go on in the next frame.
template <class S>
Frame<S> frame_program(std::uint32_t hops)
{
    Frame<S> frame;
    if constexpr (S::routes) get_step<Route<S>>(frame).at_most = hops == 0 ? 0xffffffffu : hops;
    if constexpr (S::blooms) get_step<Bloom<S>, 1>(frame).at_most = hops == 0 ? 0xffffffffu : hops - 1;
    return frame;
}

}}} // namespace tilemesh::splat
