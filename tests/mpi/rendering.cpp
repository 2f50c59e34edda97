// The renderer over ranks: pictures, reports, losses and traces are those of one process.
#include "../splat/runner.hpp"
#include "same_frame.hpp"
#include <tilemesh/render/ranks/host.hpp>
#include <tilemesh/render/ranks/value_form.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/splat/bounded.hpp>

using namespace mpi_test;
using support::Whole;

namespace {

/// The frames of one process.
template <class S>
std::vector<RenderedFrame> frames_of_mesh(scene::Map const& map, RendererOptions const& options, std::vector<splat::Camera> const& cameras)
{
    BasicRenderer<S, Mesh> renderer{map, options};
    std::vector<RenderedFrame> frames;
    for (auto const& camera : cameras) frames.push_back(renderer.render(camera));
    return frames;
}

/// Renders the cameras over the ranks with setup S, in several forms, and compares every frame with those of one process.
template <class S>
void check_frames(std::vector<RenderedFrame> const& wanted, scene::Map const& map, RendererOptions options,
                  std::vector<splat::Camera> const& cameras)
{
    for (std::uint32_t form = 0; form < 2; ++form) {
        CAPTURE(form);
        delay(form == 0 ? 0 : 30);
        options.threads = form + 1;
        MpiMeshOptions engine;
        if (form == 1 && options.grid.height != 0) { // otherwise the renderer chooses; here the first rank has one row, the last may have none
            engine.row_weights.resize(options.grid.height, 1);
            engine.row_weights.front() = options.grid.height;
        }
        BasicRenderer<S, MpiMesh> renderer{map, options, engine};
        RenderedFrame frame;
        for (std::size_t i = 0; i < cameras.size(); ++i) {
            CAPTURE(i);
            renderer.render_into(cameras[i], frame);
            check_same_frame(frame, wanted[i]);
        }
        delay(0);
    }
}

/// Setup S, by its own policies or by those of Valued<S>, against one process. Returns the last frame's report.
template <class S, class OverRanks = S>
report::FrameReport compare(scene::Map const& map, RendererOptions const& options, std::vector<splat::Camera> const& cameras)
{
    auto const wanted = frames_of_mesh<splat::Referenced<S>>(map, options, cameras);
    check_frames<OverRanks>(wanted, map, options, cameras);
    return wanted.back().report;
}

scene::Map cloud(std::uint32_t n = 400, std::uint64_t seed = 21) { return support::map_of(support::cloud(n, seed)); }
scene::Map shaded_cloud(std::uint32_t n, std::uint64_t seed, std::uint32_t degree)
{
    auto map = cloud(n, seed);
    map.sh_degree = degree;
    Random random{seed};
    map.harmonics.resize(std::size_t{3} * splat::harmonics_per_channel(degree) * n);
    for (float& v : map.harmonics) v = static_cast<float>(random.below(601)) * 0.001f - 0.3f;
    return map;
}
/// A still camera, a small step, a jump, a look away and back.
std::vector<splat::Camera> path(std::uint32_t width = 120, std::uint32_t height = 80)
{
    std::vector<splat::Camera> out;
    for (float turn : {0.0f, 0.0f, 0.0017f, -0.4f, 3.1f, 0.01f}) out.push_back(support::lens(width, height, turn));
    return out;
}

} // namespace

TEST_CASE("a moving sequence: from room for all records to channels of one slot")
{
    compare<Whole>(cloud(), {.grid = {7, 6}}, path());
    auto const tight = compare<Whole>(cloud(200), {.grid = {5, 9}, .channel_slots = 1, .waiting_slots = 1}, path());
    CHECK(tight.gaussians.held > 0);
    compare<Whole>(cloud(), {.grid = {30, 20}, .tile = {20, 16}}, path()); // most tiles are beyond the picture
    // The picture's 30 tiles hold 360 of 400 records; the others start beyond the picture.
    compare<Whole>(cloud(), {.grid = {12, 9}, .tile = {20, 16}, .storage_slots = 12}, path());
    compare<Whole>(cloud(100), {.grid = {1, 1}}, path());                  // all ranks but one have no tile
}

TEST_CASE("hold with full storage: unplaced records, recalled copies, records that the host puts back")
{
    for (std::uint32_t const slots : {22u, 60u}) {
        CAPTURE(slots);
        auto const last = compare<Whole>(cloud(500, 31), {.grid = {7, 6}, .storage_slots = slots}, path());
        CHECK((slots == 22) == !last.lost.empty());
    }
    for (std::uint32_t const hops : {2u, 5u}) // records under way and late copies between frames
        compare<Whole>(cloud(400, 47), {.grid = {6, 5}, .hops = hops, .channel_slots = 5, .storage_slots = 30}, path());
}

TEST_CASE("one renderer of rules at run time: drop, recomputed anchors, copies of one view, bytes, planes, harmonics")
{
    using namespace support;
    using splat::Valued;
    using Plain = Valued<Whole>;
    using Shared = render::FrameRenderer<splat::PoliciesOf<Plain>, MpiMesh, AnyMachine>;
    static_assert(std::is_same_v<BasicRenderer<Valued<Dropping>, MpiMesh>::Core, Shared> &&
                      std::is_same_v<BasicRenderer<Valued<Screens>, MpiMesh>::Core, Shared>,
                  "the setups share their code");
    std::uint64_t lost = 0;
    RendererOptions const tight[] = {{.grid = {7, 6}, .channel_slots = 2}, {.grid = {7, 6}, .storage_slots = 22}};
    for (auto const& options : tight) {
        lost += compare<Dropping, Valued<Dropping>>(::cloud(500, 31), options, path()).lost.size();
        compare<Screens, Valued<Screens>>(::cloud(500, 31), options, path());
        lost += compare<DropScreens, Valued<DropScreens>>(shaded_cloud(300, 78, 3), options, path()).lost.size();
        compare<Shaded, Valued<Shaded>>(shaded_cloud(300, 77, 2), options, path()); // coefficients that the map does not have are zero
    }
    CHECK(lost > 0);
}

TEST_CASE("without routing, without bloom")
{
    using namespace support;
    compare<NoRouting>(cloud(), {.grid = {7, 6}}, path());
    compare<NoRouting>(cloud(), {.grid = {7, 6}, .storage_slots = 20}, path());
    compare<NoBloom>(cloud(), {.grid = {7, 6}}, path());
}

TEST_CASE("digests of every superstep are those of a Mesh that moves values")
{
    RendererOptions const options{.grid = {7, 6}, .storage_slots = 22, .digest = true};
    auto const wanted = frames_of_mesh<Whole>(cloud(500, 31), options, path());
    CHECK_FALSE(wanted.back().report.digests.empty());
    check_frames<Whole>(wanted, cloud(500, 31), options, path());
}

TEST_CASE("the trace of a frame, also of one that ran twice, is gathered on rank 0")
{
    using S = WithTrace<Whole>;
    RendererOptions const options{.grid = {7, 6}, .storage_slots = 22};
    BasicRenderer<S, Mesh> reference{cloud(500, 31), options};
    BasicRenderer<S, MpiMesh> renderer{cloud(500, 31), options};
    std::uint32_t ran_twice = 0;
    for (auto const& camera : path()) {
        reference.render(camera);
        renderer.render(camera);
        CHECK((renderer.gather_trace() == (rank() == 0 ? reference.trace() : Trace{})));
        auto const& all = reference.trace().supersteps;
        ran_twice += std::count_if(all.begin(), all.end(), [](auto const& s) { return s.step == 0; }) == 2 ? 1 : 0;
        for (auto const& s : renderer.trace().supersteps)
            for (auto const& t : s.tiles) CHECK(renderer.mesh().owns(renderer.mesh().grid().tile(t.tile)));
    }
    CHECK(ran_twice > 0);
}

TEST_CASE("the built-in map: still, half a degree, a jump")
{
    auto const map = scene::built_in_map();
    scene::Size const size{support::fast() ? 160u : 640u, support::fast() ? 90u : 360u};
    auto const first = scene::built_in_camera(size);
    auto const centre = scene::robust_centre(map);
    auto cameras = scene::orbit(first, centre, 0.5, 2);
    cameras.insert(cameras.begin(), cameras.front());
    cameras.push_back(scene::orbit(first, centre, 40, 2).back());
    compare<splat::Lossless>(map, {}, cameras);
}

TEST_CASE("errors are those of one process, on all ranks; ranks with different frames are refused")
{
    auto const want = error_of([] { BasicRenderer<splat::Referenced<Whole>>{cloud(), {.grid = {2, 2}, .storage_slots = 5}}.render(support::lens(120, 80)); });
    CHECK(has(want, "a map of 400 Gaussians"));
    BasicRenderer<Whole, MpiMesh> small{cloud(), {.grid = {2, 2}, .storage_slots = 5}};
    CHECK(error_of([&] { small.render(support::lens(120, 80)); }) == want);
    if (ranks() == 1) return;
    bool const other = rank() == ranks() - 1;
    {
        auto broken = support::lens(120, 80);
        broken.fx = 0;
        BasicRenderer<Whole, MpiMesh> refusing{cloud(), {.grid = {7, 6}}};
        for (int again = 0; again < 2; ++again) { // without a mesh, and with one
            CHECK(has(error_of([&] { refusing.render(other ? broken : support::lens(120, 80)); }), of_rank(ranks() - 1)));
            CHECK(error_of([&] { refusing.render(support::lens(120, 80)); }).empty());
        }
        BasicRenderer<Whole, MpiMesh> limited{cloud(), {.grid = {7, 6}, .channel_slots = other ? 7u : 0u}};
        CHECK(has(error_of([&] { limited.render(support::lens(120, 80)); }), "ranks with different frames ("));
    }
    auto const differ = "ranks with different frames (";
    BasicRenderer<Whole, MpiMesh> renderer{cloud(), {.grid = {7, 6}}};
    CHECK(has(error_of([&] { renderer.render(support::lens(120, 80, other ? 0.1f : 0)); }), differ));
    CHECK(error_of([&] { renderer.render(support::lens(120, 80)); }).empty());
    CHECK(has(error_of([&] { renderer.render(support::lens(other ? 110 : 120, 80)); }), differ));
    CHECK(error_of([&] { renderer.render(support::lens(120, 80)); }).empty()); // the next frame is whole
    renderer.rules().alpha_min = other ? 0.1f : 0.01f;
    CHECK(has(error_of([&] { renderer.render(support::lens(120, 80)); }), differ));
    BasicRenderer<Whole, MpiMesh> maps{cloud(400, other ? 21 : 22), {.grid = {7, 6}}};
    CHECK(has(error_of([&] { maps.render(support::lens(120, 80)); }), differ));
}

TEST_CASE("the exception of an observer on one rank ends the frame on all ranks; the next frame is whole")
{
    auto const wanted = frames_of_mesh<splat::Referenced<Whole>>(cloud(), {.grid = {7, 6}}, path());
    BasicRenderer<Whole, MpiMesh> renderer{cloud(), {.grid = {7, 6}}};
    renderer.observe([](SuperstepEvent const& e) {
        if (e.pass == 2 && rank() == ranks() - 1) throw 7;
    });
    CHECK(has(error_of([&] { renderer.render(path()[0]); }), "an exception that is no std::exception"));
    renderer.observe(nullptr);
    check_same_frame(renderer.render(path()[0]), wanted[0]);
}

TEST_CASE("a frame that bounds its picture has the picture and the bounds of one process")
{
    RendererOptions const options{.grid = {7, 6}};
    check_frames<splat::Bounded>(frames_of_mesh<splat::Bounded>(cloud(), options, path()), cloud(), options, path());
}
