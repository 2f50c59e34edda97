// Whole frames over ranks: pictures, counters, the digests of every superstep and traces are those of Mesh.
#include "../splat/runner.hpp"
#include "same_frame.hpp"
#include <tilemesh/render/ranks/host.hpp>
#include <tilemesh/render/ranks/value_form.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/ply.hpp>

using namespace mpi_test;
using support::Whole;

namespace {

/// All setups in this form share one renderer over ranks, and one on a Mesh.
template <class S>
using Form = splat::Valued<WithTrace<S>>;

/// Renders the cameras with setup S on a Mesh, and over the ranks on one thread and on two, the second time with late messages. Returns
/// the report of the last frame.
template <class S>
report::FrameReport compare(scene::Map const& map, RendererOptions options, std::vector<splat::Camera> const& cameras)
{
    std::vector<std::pair<RenderedFrame, Trace>> wanted;
    BasicRenderer<Form<S>, Mesh> reference{map, options};
    for (auto const& camera : cameras) {
        auto frame = reference.render(camera);
        wanted.emplace_back(std::move(frame), reference.trace());
    }
    for (std::uint32_t const threads : {1u, 2u}) {
        CAPTURE(threads);
        options.threads = threads;
        delay(threads == 1 ? 0 : 10);
        BasicRenderer<Form<S>, MpiMesh> renderer{map, options};
        for (std::size_t i = 0; i < cameras.size(); ++i) {
            CAPTURE(i);
            auto const& [want, trace] = wanted[i];
            auto const frame = renderer.render(cameras[i]);
            REQUIRE(frame.report.digests.size() == want.report.digests.size());
            CHECK(frame.report.digests.empty() != options.digest);
            check_same_frame(frame, want);
            CHECK((renderer.gather_trace() == (rank() == 0 ? trace : Trace{})));
        }
        delay(0);
    }
    return wanted.back().first.report;
}

/// Still, half a degree, a jump.
std::vector<splat::Camera> path(splat::Camera const& first, scene::Map const& map)
{
    auto const centre = scene::robust_centre(map);
    auto cameras = scene::orbit(first, centre, 0.5, 2);
    cameras.insert(cameras.begin(), cameras.front());
    cameras.push_back(scene::orbit(first, centre, 40, 2).back());
    return cameras;
}
scene::Size size() { return support::fast() ? scene::Size{160, 90} : scene::Size{320, 180}; }

/// With hold and with drop. A digest reads all words in every superstep, so only the first frames have them.
void check_map(scene::Map const& map, splat::Camera const& first)
{
    CAPTURE(map.name);
    auto cameras = path(first, map);
    if (support::fast()) cameras.resize(2);
    compare<splat::Paper>(map, {}, cameras);
    if (support::fast()) return;
    compare<splat::Lossless>(map, {.channel_slots = 40}, cameras);
    cameras.resize(2);
    compare<splat::Lossless>(map, {.digest = true}, cameras);
}

} // namespace

TEST_CASE("channels of 1 to 200 slots, hold and drop, full tiles, records under way: pictures, counters, digests and traces")
{
    auto const map = support::map_of(support::cloud(500, 31));
    std::vector<splat::Camera> cameras;
    for (float turn : {0.0f, 0.0017f, -0.4f, 0.01f}) cameras.push_back(support::lens(120, 80, turn));
    auto const some = support::fast() ? std::vector{1u, 10u, 200u} : std::vector{1u, 2u, 3u, 10u, 50u, 199u, 200u};
    std::uint64_t held = 0, lost = 0;
    for (std::uint32_t const slots : some) {
        CAPTURE(slots);
        held += compare<Whole>(map, {.grid = {7, 6}, .channel_slots = slots, .storage_slots = 60, .digest = true}, cameras).gaussians.held;
        lost += compare<support::Dropping>(map, {.grid = {7, 6}, .channel_slots = slots, .storage_slots = 22, .digest = true}, cameras).lost.size();
    }
    CHECK(held > 0);
    CHECK(lost > 0);
    auto const last = compare<Whole>(map, {.grid = {7, 6}, .hops = 2, .channel_slots = 5, .storage_slots = 60, .digest = true}, cameras);
    CHECK(last.gaussians.under_way > 0);
    CHECK_FALSE(last.lost.empty());
}

TEST_CASE("slow: the built-in map")
{
    check_map(scene::built_in_map(), scene::built_in_camera(size()));
}

TEST_CASE("slow: Sloth and Salad")
{
    for (char const* name : {"sloth", "salad"}) {
        auto const file = support::data() / "maps" / (std::string(name) + ".ply");
        if (support::data().empty() || !std::filesystem::exists(file)) {
            if (rank() == 0) MESSAGE("skipped: there is no map " << name << " (TILEMESH_DATA)");
            continue;
        }
        auto const map = scene::load_ply(file);
        check_map(map, scene::frame_whole(map, size()));
    }
}
