// test: optimised, without tsan, cost 10
#include "../../examples/c/tilemesh.h"
#include "../scene/real_packing.hpp"
#include "handle.hpp"
#include <nlohmann/json.hpp>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/splat/quality.hpp>
#include <tilemesh/splat/setup_types.hpp>

namespace render = tilemesh::render;
using namespace page_test;

TEST_SUITE_BEGIN("page");

namespace {

std::vector<float> plane(Handle const& handle, char const* what, std::size_t floats)
{
    auto const* const at = static_cast<float const*>(tilemesh_pixels(handle.at, what));
    REQUIRE_MESSAGE(at != nullptr, handle.error());
    return {at, at + floats};
}
int code(Handle const& handle)
{
    return tilemesh_error_code(handle.at);
}
constexpr std::size_t width = 160, height = 96, pixels = width * height;
Json const small = {{"width", width}, {"height", height}};

} // namespace

TEST_CASE("depth and alpha of one Gaussian are those of its place and its opacity")
{
    Handle handle;
    REQUIRE_MESSAGE(handle.load("one.ply", ply({{0, 0, 0}})), handle.error());
    REQUIRE(handle.set(small));
    std::vector<double> const camera = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -2, 100, 100, 80.5, 48.5, 0.1};
    REQUIRE_MESSAGE(handle.render(camera), handle.error());
    CHECK(tilemesh_pixels(handle.at, "depth") == nullptr);
    CHECK(code(handle) == TILEMESH_NO_FRAME);
    CHECK(is_one_line(handle.error()));
    auto const without = plane(handle, "rgb_float", 3 * pixels);
    REQUIRE(handle.set({{"depth", true}, {"alpha", true}}));
    REQUIRE_MESSAGE(handle.render(camera), handle.error());
    auto const depth = plane(handle, "depth", pixels), alpha = plane(handle, "alpha", pixels);
    auto const centre = 48 * width + 80;
    CHECK(depth[centre] == doctest::Approx(2.0)); // two units in front of the camera
    CHECK(alpha[centre] == doctest::Approx(1 / (1 + std::exp(-3.0))).epsilon(1e-4));
    CHECK(depth[0] == 0.0f);
    CHECK(alpha[0] == 0.0f);
    CHECK(plane(handle, "rgb_float", 3 * pixels) == without);
    REQUIRE(handle.set({{"depth", false}}));
    REQUIRE(handle.render(camera));
    CHECK(tilemesh_pixels(handle.at, "depth") == nullptr);
    CHECK(plane(handle, "alpha", pixels) == alpha);
}

TEST_CASE("planes and quality have the bits of the C++ renderer")
{
    auto const map = scene::built_in_map();
    auto const camera = turn(map, 1, {width, height})[0];
    auto const setup = render::with_planes(render::fitted(splat::setup_of<splat::Lossless>(), map.sh_degree, true, true), true, true);
    for (auto const quality : {splat::Quality::evaluation, splat::Quality::viewing, splat::Quality::on_sensor, splat::Quality::training}) {
        CAPTURE(splat::name(quality));
        tilemesh::RendererOptions options;
        options.quality = quality;
        render::HostRenderer renderer(map, render::checked(setup), options, {});
        auto const expected = renderer.render(camera);
        Handle const handle(small);
        REQUIRE(handle.set({{"depth", true}, {"alpha", true}, {"quality", splat::name(quality)}, {"threads", 2}}));
        REQUIRE_MESSAGE(handle.render(numbers(camera)), handle.error());
        auto const run = handle.report("run");
        CHECK(run["quality"] == splat::name(quality));
        if (handle.report("build")["fused"] == true) continue; // the library of these tests is not native
        CHECK(plane(handle, "rgb_float", 3 * pixels) == expected.image.rgb);
        CHECK(plane(handle, "depth", pixels) == expected.depth.values);
        CHECK(plane(handle, "alpha", pixels) == expected.alpha.values);
    }
}

TEST_CASE("homes and auto have the picture of anchored tiles, and no trace")
{
    auto const map = scene::built_in_map();
    auto const cameras = turn(map, 2, {width, height});
    Json planes = small;
    planes["depth"] = planes["alpha"] = true;
    Handle const anchored(planes);
    for (auto const& run_of : {std::pair("homes", 0), std::pair("auto", 0), std::pair("auto", 40)}) {
        char const* const program = run_of.first;
        int const storage = run_of.second;
        CAPTURE(program);
        CAPTURE(storage);
        Handle const handle(planes);
        REQUIRE_MESSAGE(handle.set({{"program", program}, {"storage_slots", storage}}), handle.error());
        for (auto const& camera : cameras) {
            REQUIRE(anchored.render(numbers(camera)));
            REQUIRE_MESSAGE(handle.render(numbers(camera)), handle.error());
            CHECK(plane(handle, "rgb_float", 3 * pixels) == plane(anchored, "rgb_float", 3 * pixels));
            CHECK(plane(handle, "depth", pixels) == plane(anchored, "depth", pixels));
            CHECK(plane(handle, "alpha", pixels) == plane(anchored, "alpha", pixels));
        }
        auto const frame = handle.report("frame"), run = handle.report("run");
        // Tiles of 40 slots would lack records, so `auto` changes to homes.
        CHECK(frame["program"] == (std::string(program) == "homes" || storage == 40 ? "homes" : "anchored"));
        CHECK(frame["missing"] == "");
        CHECK(frame["modelled_ms"].is_null());
        CHECK(run["program"] == program);
        CHECK(run["frames"][0]["program"] == frame["program"]);
        CHECK(tilemesh_report(handle.at, "supersteps") == nullptr);
        CHECK(code(handle) == TILEMESH_NO_FRAME);
        CHECK(handle.error().find("anchored") != std::string::npos);
        CHECK(tilemesh_heat(handle.at, "load", -1) == nullptr);
        CHECK(tilemesh_tile(handle.at, 0) == nullptr);
        CHECK(tilemesh_gaussian(handle.at, 1) == nullptr);
        // Back to the trace, in the same handle.
        REQUIRE(handle.set({{"program", "anchored"}, {"storage_slots", 0}}));
        REQUIRE(handle.render(numbers(cameras[1])));
        CHECK(tilemesh_report(handle.at, "supersteps") != nullptr);
        CHECK(plane(handle, "rgb_float", 3 * pixels) == plane(anchored, "rgb_float", 3 * pixels));
    }
    Handle handle;
    for (Json const& wrong :
         {Json{{"program", "homes"}, {"hops", 3}}, Json{{"program", "homes"}, {"tile_width", 16}, {"tile_height", 16}},
          Json{{"program", "homes"}, {"saturation", "drop"}}, Json{{"program", "auto"}, {"difference", true}},
          Json{{"program", "homes"}, {"follow", 3}}, Json{{"program", "other"}}, Json{{"quality", "best"}}, Json{{"threads", 0}},
          Json{{"threads", 257}}, Json{{"depth", 1}}, Json{{"rounds", 2}}, Json{{"fold", "off"}}, Json{{"held", 9}, {"program", "anchored"}}}) {
        CAPTURE(wrong.dump());
        refused(handle, handle.set(wrong));
        CHECK(code(handle) == TILEMESH_BAD_INPUT);
    }
    CHECK(handle.report("settings")["program"] == "anchored");
}

TEST_CASE("a tracker finds the camera of a rendered picture, and says when it is lost")
{
    Handle handle;
    std::vector<double> found(17, -1.0);
    std::vector<float> const none(3 * 320 * 180, 0.0f);
    REQUIRE(handle.set({{"width", 320}, {"height", 180}, {"depth", true}, {"alpha", true}}));
    CHECK(tilemesh_track(handle.at, none.data(), nullptr, 320 * 180, 0.0, found.data()) == 0); // none began
    CHECK(code(handle) == TILEMESH_NO_FRAME);
    auto const start = handle.report("map")["start"].get<std::vector<double>>();
    REQUIRE(handle.render(start));
    auto const rgb = plane(handle, "rgb_float", 3 * 320 * 180), depth = plane(handle, "depth", 320 * 180);
    auto guess = start;
    guess[9] += 0.01;
    for (bool const with_depth : {false, true}) {
        CAPTURE(with_depth);
        REQUIRE_MESSAGE(tilemesh_track_begin(handle.at, guess.data(), with_depth) == 1, handle.error());
        CHECK(tilemesh_report(handle.at, "track") == nullptr);
        CHECK(code(handle) == TILEMESH_NO_FRAME);
        auto const* const deep = with_depth ? depth.data() : nullptr;
        REQUIRE_MESSAGE(tilemesh_track(handle.at, rgb.data(), deep, 320 * 180, 0.0, found.data()) == 1, handle.error());
        for (std::size_t i = 0; i < 17; ++i) CHECK(found[i] == doctest::Approx(start[i]).epsilon(1e-5).scale(1));
        auto const track = handle.report("track");
        CHECK(track["verdict"] == "converged");
        CHECK(track["camera"].get<std::vector<double>>() == found);
        CHECK(track["median_depth"].get<double>() > 1.0);
        // What was rendered is still there.
        CHECK(plane(handle, "rgb_float", 3 * 320 * 180) == rgb);
    }
    // A black picture is lost, and the pose is the prediction. It is no error.
    REQUIRE(tilemesh_track(handle.at, none.data(), depth.data(), 320 * 180, 1.0, nullptr) == 1);
    CHECK(handle.report("track")["verdict"] == "lost");
    CHECK(!handle.report("track")["why"].get<std::string>().empty());
    // Half as bright: with `exposure` the gain is found.
    auto dark = rgb;
    for (auto& v : dark) v *= 0.5f;
    REQUIRE(handle.set({{"exposure", true}}));
    REQUIRE(tilemesh_track_begin(handle.at, guess.data(), 0) == 1);
    REQUIRE(tilemesh_track(handle.at, dark.data(), nullptr, 320 * 180, 0.0, found.data()) == 1);
    CHECK(handle.report("track")["exposure"]["log_gain"].get<double>() == doctest::Approx(std::log(0.5)).epsilon(0.01));
    CHECK(found[9] == doctest::Approx(start[9]).epsilon(1e-3).scale(1));

    REQUIRE(tilemesh_track_begin(handle.at, guess.data(), 1) == 1);
    auto const nan = std::numeric_limits<double>::quiet_NaN();
    refused(handle, tilemesh_track(handle.at, nullptr, depth.data(), 320 * 180, 0.0, nullptr));
    refused(handle, tilemesh_track(handle.at, rgb.data(), nullptr, 320 * 180, 0.0, nullptr));
    for (std::size_t const n : {std::size_t{0}, std::size_t{320 * 180 - 1}, std::size_t{320 * 180 + 1}, ~std::size_t{0}}) {
        refused(handle, tilemesh_track(handle.at, rgb.data(), depth.data(), n, 0.0, nullptr));
        CHECK(code(handle) == TILEMESH_BAD_INPUT);
    }
    refused(handle, tilemesh_track(handle.at, rgb.data(), depth.data(), 320 * 180, nan, nullptr));
    for (auto const& [by, plus] : {std::pair(255.0f, 0.0f), std::pair(2.0f, -1.0f)}) { // levels; -1 to 1
        auto levels = rgb;
        for (auto& v : levels) v = by * v + plus;
        CHECK(tilemesh_track(handle.at, levels.data(), depth.data(), 320 * 180, 0.0, nullptr) == 0);
        CHECK_MESSAGE(handle.error().find(plus == 0.0f ? "divide levels of 0 to 255 by 255" : "0 to 1") != std::string::npos, handle.error());
    }
    auto bad = guess;
    bad[3] = nan;
    CHECK(tilemesh_track_begin(handle.at, bad.data(), 0) == 0);
    CHECK(tilemesh_track_begin(handle.at, nullptr, 0) == 0);
    CHECK(code(handle) == TILEMESH_BAD_INPUT);
    // The tracker from before the errors goes on: NaN is a pixel, or a depth, that is not known.
    auto holes = rgb;
    auto deep = depth;
    for (std::size_t i = 0; i < 3000; ++i) holes[30000 + i] = deep[i] = std::numeric_limits<float>::quiet_NaN();
    REQUIRE_MESSAGE(tilemesh_track(handle.at, holes.data(), deep.data(), 320 * 180, 0.0, found.data()) == 1, handle.error());
    CHECK(handle.report("track")["verdict"] == "converged");
    CHECK(found[9] == doctest::Approx(start[9]).epsilon(1e-4).scale(1));
    REQUIRE(tilemesh_load(handle.at, nullptr, nullptr, 0) == 1); // another map
    CHECK(tilemesh_track(handle.at, rgb.data(), depth.data(), 320 * 180, 0.0, nullptr) == 0);
    CHECK(code(handle) == TILEMESH_NO_FRAME);
}

TEST_CASE("cameras are in the coordinates of the file, also far from 0")
{
    // Multiples of 1/64, which a float has no bits for beside a million.
    std::vector<std::array<double, 3>> means;
    for (int i = 0; i < 40; ++i) means.push_back({i % 7 / 8.0 - 0.375, i % 5 / 8.0 - 0.25, i % 3 / 64.0});
    auto far = means;
    std::array<double, 3> const by = {4'000'000, -2'000'000, 1'000'000};
    for (auto& m : far)
        for (std::size_t k = 0; k < 3; ++k) m[k] += by[k];
    std::vector<double> camera = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -2, 100, 100, 80, 48, 0.1};
    Handle const handle(small);
    REQUIRE_MESSAGE(handle.load("near.ply", ply(means)), handle.error());
    REQUIRE(handle.render(camera));
    auto const expected = plane(handle, "rgb_float", 3 * pixels);
    auto const near_map = handle.report("map");
    REQUIRE_MESSAGE(handle.load("far.ply", ply(far)), handle.error());
    for (std::size_t k = 0; k < 3; ++k) camera[9 + k] += by[k];
    REQUIRE_MESSAGE(handle.render(camera), handle.error());
    auto const shown = plane(handle, "rgb_float", 3 * pixels);
    float most = 0;
    for (std::size_t i = 0; i < shown.size(); ++i) most = std::max(most, std::fabs(shown[i] - expected[i]));
    CHECK(most < 1e-4f); // the origin that the reader subtracts is no multiple of 1/64
    CHECK(*std::max_element(shown.begin(), shown.end()) > 0.3f);
    auto const far_map = handle.report("map");
    for (std::size_t k = 0; k < 3; ++k) {
        CHECK(far_map["start"][9 + k].get<double>() - by[k] == doctest::Approx(near_map["start"][9 + k].get<double>()).epsilon(1e-3).scale(1));
        CHECK(far_map["target"][k].get<double>() - by[k] == doctest::Approx(near_map["target"][k].get<double>()).epsilon(1e-3).scale(1));
        CHECK(handle.gaussian(1)["mean"][k].get<double>() == doctest::Approx(far[0][k]).epsilon(1e-12));
    }
}

TEST_CASE("the cameras of a file have the numbers of the file, and render")
{
    std::ofstream("page_cameras.json") << R"({"cameras": [{"name": "a", "scene": "s", "width": 160, "height": 96, "fx": 100, "fy": 101, "cx": 80.5,
        "cy": 48.25, "near": 0.5, "world_to_camera": [[1, 0, 0, -4000000.25], [0, 0, 1, 2], [0, -1, 0, 3], [0, 0, 0, 1]]}]})";
    Handle const handle(small);
    auto const read = handle.parsed(tilemesh_cameras(handle.at, "page_cameras.json"));
    REQUIRE(read["cameras"].size() == 1);
    auto const& camera = read["cameras"][0];
    CHECK(camera["name"] == "s/a");
    CHECK(camera["width"] == 160);
    CHECK(camera["height"] == 96);
    auto const numbers = camera["camera"].get<std::vector<double>>();
    CHECK(numbers == std::vector<double>{1, 0, 0, 0, 0, 1, 0, -1, 0, 4000000.25, 3, -2, 100, 101, 80.5, 48.25, 0.5});
    CHECK_MESSAGE(handle.render(numbers), handle.error());
    std::ofstream("page_cameras.json") << R"({"cameras": [{"name": "a"}]})";
    refused(handle, tilemesh_cameras(handle.at, "page_cameras.json"));
}

TEST_CASE("maps in every format that the build has, from bytes and from files")
{
    Handle handle;
    auto const build = handle.report("build");
    auto const has = [&](char const* format) { return std::count(build["formats"].begin(), build["formats"].end(), Json(format)) != 0; };
    auto const packing = scene_test::real_packing();
    scene_test::Numbers numbers{7};
    std::vector<std::pair<std::string, std::string>> files; // name, bytes
    auto const one = ply({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    files.emplace_back("map.ply", one);
    if (has("spz")) files.emplace_back("map.spz", scene_test::PackedSpz::random(3, 3, 1, numbers).bytes(packing));
    if (has("spz 4")) files.emplace_back("map4.spz", scene_test::PackedSpz::random(3, 4, 0, numbers).bytes(packing));
    if (has("sog")) {
        auto const sog = scene_test::PackedSog::random(3, 2, 0, numbers);
        files.emplace_back("map.sog", scene_test::write_zip(sog.files(packing), packing, true));
    }
#if defined(TILEMESH_HAS_ZLIB) && defined(TILEMESH_HAS_ZSTD) && defined(TILEMESH_HAS_WEBP)
    CHECK(files.size() == 4);
#endif
    for (auto const& file : files) {
        CAPTURE(file.first);
        REQUIRE_MESSAGE(handle.load(file.first, file.second), handle.error());
        auto const from_bytes = handle.report("map");
        CHECK(from_bytes["gaussians"].get<int>() + from_bytes["rejected"].get<int>() == 3);
        auto const path = "page_" + file.first;
        std::ofstream(path, std::ios::binary) << file.second;
        REQUIRE_MESSAGE(tilemesh_load_file(handle.at, path.c_str()) == 1, handle.error());
        CHECK(handle.report("map")["gaussians"] == from_bytes["gaussians"]);
        CHECK(handle.report("map")["start"] == from_bytes["start"]);
        REQUIRE_MESSAGE(handle.render(from_bytes["start"].get<std::vector<double>>()), handle.error());
        // Half of the file is an error, and the map stays.
        refused(handle, handle.load(file.first, file.second.substr(0, file.second.size() / 2)));
        CHECK(code(handle) == TILEMESH_BAD_INPUT);
        CHECK(handle.report("map")["gaussians"] == from_bytes["gaussians"]);
    }
    for (char const* path : {"", "page_no_such_file", "/dev/null", "."}) {
        CAPTURE(path);
        refused(handle, tilemesh_load_file(handle.at, path));
        CHECK(code(handle) == TILEMESH_BAD_INPUT);
    }
    CHECK(tilemesh_load_file(handle.at, nullptr) == 0);
}

TEST_CASE("versions, and codes of errors")
{
    CHECK(tilemesh_version() == TILEMESH_C_VERSION);
    CHECK(tilemesh_error_code(nullptr) == TILEMESH_BAD_INPUT);
    CHECK(tilemesh_load_file(nullptr, "map.ply") == 0);
    CHECK(tilemesh_track_begin(nullptr, nullptr, 0) == 0);
    CHECK(tilemesh_track(nullptr, nullptr, nullptr, 0, 0.0, nullptr) == 0);
    Handle handle;
    CHECK(code(handle) == TILEMESH_OK);
    CHECK(handle.report("build")["interface"] == TILEMESH_C_VERSION);
    CHECK(tilemesh_pixels(handle.at, "rgba") == nullptr);
    CHECK(code(handle) == TILEMESH_NO_FRAME);
    CHECK(tilemesh_set(handle.at, "{\"width\": 1}") == 0);
    CHECK(code(handle) == TILEMESH_BAD_INPUT);
    CHECK(tilemesh_load(handle.at, "huge", "x", ~std::size_t{0}) == 0);
    CHECK(code(handle) == TILEMESH_BAD_INPUT);
    CHECK(handle.set({{"width", 16}}));
    CHECK(code(handle) == TILEMESH_OK);
}

TEST_SUITE_END();
