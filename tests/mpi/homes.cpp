// The program of homes over ranks: pictures, planes, reports and digests are those of one process, also in chapters and in parts.
#include "same_frame.hpp"
#include "short_of_memory.hpp"
#include <cstdint>
#include <cstring>
#include <doctest/doctest.h>
#include <memory>
#include <tilemesh/render/ranks/host.hpp>
#include <tilemesh/render/ranks/row_shares.hpp>
#include <tilemesh/render/homes_renderer.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <vector>

using namespace mpi_test;
namespace homes = splat::homes;

namespace {
using Planes = render::HomesPlanes;
using OnMesh = render::HomesRenderer<homes::ValuePolicies<1, Planes>>;
using OnRanks = render::HomesRenderer<homes::ValuePolicies<1, Planes>, MpiMesh>;

scene::Map shaded_cloud(std::uint32_t n)
{
    auto map = support::map_of(support::cloud(n, 17));
    map.sh_degree = 1;
    Random random{5};
    map.harmonics.resize(std::size_t{9} * n);
    for (float& v : map.harmonics) v = static_cast<float>(random.below(601)) * 0.001f - 0.3f;
    return map;
}
/// A test's machine, with degree 1 and both planes.
render::Setup choice_of(std::uint32_t homes)
{
    auto choice = splat::homes_setup;
    choice.machine = size_of_machine<TestMachine<64u << 20>>();
    choice.sizes.homes = homes;
    choice.sh_degree = 1;
    choice.depth = choice.alpha = true;
    return choice;
}
} // namespace

TEST_CASE("homes over ranks: a whole map, chapters, one slot, a bound on rounds")
{
    auto const map = shaded_cloud(200);
    std::vector<splat::Camera> path;
    for (float turn : {0.0f, 0.0f, 0.3f}) path.push_back(support::lens(90, 53, turn));
    struct Case {
        std::uint32_t homes, storage_slots, channel_slots, rounds;
        bool fold;
    };
    // 12 tiles: 17 homes hold the map; with 5, it comes in chapters.
    for (auto const& some : {Case{17, 20, 0, 0, true}, Case{5, 20, 3, 0, true}, Case{17, 9, 1, 0, false}, Case{5, 10, 0, 3, true}}) {
        CAPTURE(some.homes);
        CAPTURE(some.rounds);
        auto const choice = choice_of(some.homes);
        RendererOptions options{.grid = {4, 3}, .channel_slots = some.channel_slots, .storage_slots = some.storage_slots, .digest = true};
        options.rounds = some.rounds;
        options.fold = some.fold;
        OnMesh one{map, choice, options};
        OnRanks whole{map, choice, options};
        auto part = map;
        auto const first = render::RowShares::part_of(200, rank(), ranks()), last = render::RowShares::part_of(200, rank() + 1, ranks());
        part.gaussians.assign(map.gaussians.begin() + static_cast<std::ptrdiff_t>(first), map.gaussians.begin() + static_cast<std::ptrdiff_t>(last));
        part.harmonics.assign(map.harmonics.begin() + static_cast<std::ptrdiff_t>(9 * first),
                              map.harmonics.begin() + static_cast<std::ptrdiff_t>(9 * last));
        options.rows_of_all_parts = 200;
        options.threads = 2;
        OnRanks parts{part, choice, options};
        for (auto const& camera : path) {
            auto const wanted = one.render(camera);
            for (auto* renderer : {&whole, &parts}) {
                auto const frame = renderer->render(camera);
                check_same_frame(frame, wanted);
                CHECK((frame.report.homes.chapters > 1) == (wanted.report.homes.chapters > 1));
            }
            CHECK((some.rounds == 3) == !wanted.report.unfinished.empty());
        }
    }
}

TEST_CASE("homes over ranks: ranks with different views, sizes or limits, and a camera that one rank refuses; the next frame is whole")
{
    if (ranks() == 1) return;
    auto const map = shaded_cloud(60);
    auto const choice = choice_of(20);
    RendererOptions const options{.grid = {4, 3}};
    bool const other = rank() + 1 == ranks();
    auto const view = support::lens(90, 53);
    auto broken = view;
    broken.fx = 0;
    auto const refused = [](OnRanks& renderer, splat::Camera const& camera) { return error_of([&] { renderer.render(camera); }); };
    for (bool views_first : {false, true}) {
        OnRanks renderer{map, choice, options};
        auto const wanted = OnMesh{map, choice, options}.render(view);
        for (int again = 0; again < 2; ++again) { // without a mesh, and with one
            if (views_first) CHECK(has(refused(renderer, support::lens(90, 53, other ? 0.1f : 0)), "ranks with different frames ("));
            else {
                CHECK(has(refused(renderer, support::lens(other ? 80 : 90, 53)), "ranks with different frames ("));
                CHECK(has(refused(renderer, other ? broken : view), of_rank(ranks() - 1)));
            }
            auto const frame = renderer.render(view);
            if (again == 0) check_same_frame(frame, wanted);
            else if (rank() == 0) CHECK(support::differing_pixels(frame.image, wanted.image) == 0);
        }
    }
    auto different = options;
    different.channel_slots = other ? 3 : 0; // a limit is collective, so all ranks must know before that one has none
    OnRanks limited{map, choice, different};
    CHECK(has(refused(limited, view), "ranks with different frames ("));
}

TEST_CASE("homes over ranks: one rank out of memory, at each allocation of a frame in turn")
{
    auto const map = shaded_cloud(60);
    for (std::uint32_t const homes : {20u, 3u}) { // 12 tiles: all of the map, and chapters
        CAPTURE(homes);
        auto const choice = choice_of(homes);
        RendererOptions const options{.grid = {4, 3}, .storage_slots = 20, .digest = true};
        OnMesh one{map, choice, options};
        auto const wanted = one.render(support::lens(60, 40));
        each_allocation_fails([&] { return std::make_unique<OnRanks>(map, choice, options); },
                              [&](OnRanks& renderer) { renderer.render(support::lens(60, 40)); },
                              [&](OnRanks& renderer, bool failed) {
                                  if (!failed) return;
                                  check_same_frame(renderer.render(support::lens(60, 40)), wanted);
                              });
    }
}
