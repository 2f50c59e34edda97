#pragma once
#include <tilemesh/machine/superstep.hpp>
#include <tilemesh/splat/bloom.hpp>
#include <tilemesh/splat/compositing.hpp>
#include <tilemesh/splat/depth_sort.hpp>
#include <tilemesh/splat/frame_start.hpp>
#include <tilemesh/splat/routing.hpp>
#include <tilemesh/splat/setup.hpp>

namespace tilemesh::splat {

/// One frame: project, route, bloom, sort, composite. Gaussians and copies stay where they are between runs.
///
/// Bloom's first superstep runs on every tile, because after routing all are quiet: who owes copies finds out there. It sends
/// nothing, and so costs no exchange, where nobody does.
template <class S>
using Frame = Sequence<Superstep<Project<S>>, UntilQuiet<Route<S>>, Superstep<Bloom<S>>, UntilQuiet<Bloom<S>>,
                       Superstep<DepthSort<S>>, Superstep<Composite<S>>>;

/// At most `hops` supersteps of routing and of bloom a frame; 0: until quiet. What is under way goes on in the next frame.
template <class S>
Frame<S> frame_program(std::uint32_t hops)
{
    Frame<S> frame;
    std::get<1>(frame.steps).at_most = hops == 0 ? 0xffffffffu : hops;
    std::get<3>(frame.steps).at_most = hops == 0 ? 0xffffffffu : hops - 1;
    return frame;
}

} // namespace tilemesh::splat
