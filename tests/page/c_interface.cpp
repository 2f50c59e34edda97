// test: optimised, without tsan, cost 20
#include "../../examples/c/tilemesh.h"
#include "handle.hpp"
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/frame_report.hpp>

namespace scene = tilemesh::scene;
using namespace page_test;

TEST_SUITE_BEGIN("page");

namespace {

double sum(std::vector<float> const& values)
{
    return std::accumulate(values.begin(), values.end(), 0.0);
}
/// As tilemesh.h says.
std::uint64_t picture_digest(tilemesh::report::Image const& image)
{
    std::vector<std::uint32_t> words(image.rgb.size());
    std::memcpy(words.data(), image.rgb.data(), 4 * words.size());
    return tilemesh::engine::mix_words(tilemesh::engine::mix(image.width, image.height), words.data(), words.size());
}
std::uint64_t counter_digest(tilemesh::report::FrameReport const& r)
{
    std::uint64_t digest = 0;
    for (auto const& field : tilemesh::report::report_fields)
        if (field.exact()) digest = tilemesh::engine::mix(digest, field.count(r));
    return digest;
}
std::string hex(std::uint64_t value)
{
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
    return text;
}

} // namespace

TEST_CASE("ten cameras have the picture and the counters of Renderer")
{
    auto const map = scene::built_in_map();
    tilemesh::Renderer renderer{map};
    Handle handle;
    if (handle.report("build")["fused"] == true) return; // the library of these tests is not native
    REQUIRE(handle.set({{"width", 320}, {"height", 180}}));
    for (auto const& camera : turn(map, 10)) {
        auto const expected = renderer.render(camera);
        REQUIRE_MESSAGE(handle.render(numbers(camera)), handle.error());
        auto const frame = handle.report("frame");
        auto const digest = handle.report("digest");
        CHECK(digest["picture"] == hex(picture_digest(expected.image)));
        REQUIRE(expected.report.lost.empty());
        CHECK(digest["counters"] == hex(counter_digest(expected.report)));
        CHECK(frame["moved"] == expected.report.gaussians.moved);
        CHECK(frame["missing"] == "");
        auto const* const rgb = static_cast<float const*>(tilemesh_pixels(handle.at, "rgb_float"));
        REQUIRE(rgb != nullptr);
        CHECK(std::memcmp(rgb, expected.image.rgb.data(), 4 * expected.image.rgb.size()) == 0);
        auto const run = handle.report("run");
        CHECK(run["frames"][0]["messages"] == expected.report.messages);
        CHECK(run["frames"][0]["modelled"]["cycles"] == frame["modelled_cycles"]);
    }
}

TEST_CASE("heat maps add up to the frame's counters")
{
    auto const map = scene::built_in_map();
    Handle const handle(Json{{"width", 320}, {"height", 180}, {"channel_slots", 2}});
    for (auto const& camera : turn(map, 2)) REQUIRE_MESSAGE(handle.render(numbers(camera)), handle.error());
    auto const frame = handle.report("frame");
    auto const run = handle.report("run")["frames"][0];
    CHECK(sum(handle.heat("copies")) == frame["copies"].get<double>());
    CHECK(sum(handle.heat("load")) - sum(handle.heat("copies")) ==
          frame["visible"].get<double>() + run["gaussians"]["parked"].get<double>() - run["gaussians"]["unplaced"].get<double>());
    CHECK(sum(handle.heat("pairs")) == frame["pairs"].get<double>());
    CHECK(frame["refused"].get<double>() > 0);
    CHECK(sum(handle.heat("refused")) == frame["refused"].get<double>());
    auto const channel = handle.heat("channel");
    CHECK(*std::max_element(channel.begin(), channel.end()) == 1.0f);

    // The supersteps add up to the frame, and the last one has its end.
    auto const steps = handle.report("supersteps");
    REQUIRE(steps.size() == frame["supersteps"].get<std::size_t>());
    double refused = 0, busy = 0;
    std::uint64_t cycles = 0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
        refused += sum(handle.heat("refused", static_cast<int>(i)));
        busy += sum(handle.heat("busy", static_cast<int>(i)));
        cycles += steps[i]["cycles"].get<std::uint64_t>();
        auto const fill = handle.heat("channel", static_cast<int>(i));
        CHECK(*std::max_element(fill.begin(), fill.end()) <= 1.0f);
    }
    CHECK(refused == frame["refused"].get<double>());
    CHECK(busy == sum(handle.heat("busy")));
    CHECK(cycles == frame["modelled_cycles"].get<std::uint64_t>());
    CHECK(handle.heat("load", static_cast<int>(steps.size()) - 1) == handle.heat("load"));

    // Every tile says what the maps say.
    auto const load = handle.heat("load"), copies = handle.heat("copies");
    for (std::uint32_t const t : {0u, 700u, 1439u}) {
        auto const tile = handle.tile(t);
        CHECK(tile["records"].get<float>() == load[t]);
        CHECK(tile["copies"].get<float>() == copies[t]);
        CHECK(tile["channels"].size() == 4);
        CHECK(tile["counts"]["busy_cycles"].get<float>() == handle.heat("busy")[t]);
    }
}

TEST_CASE("a starved channel loses copies, and the difference shows where")
{
    auto const map = scene::built_in_map();
    Handle const handle(Json{{"width", 320}, {"height", 180}, {"channel_slots", 2}, {"saturation", "drop"}, {"difference", true}});
    REQUIRE_MESSAGE(handle.render(numbers(turn(map, 1)[0])), handle.error());
    auto const frame = handle.report("frame");
    CHECK(frame["lost_copies"].get<int>() > 0);
    CHECK(sum(handle.heat("lost")) == frame["lost_copies"].get<double>() + frame["lost_records"].get<double>());
    CHECK(frame["missing"].get<std::string>().find(" copies (") != std::string::npos);
    CHECK(frame["advice"].get<std::string>().find("hold") != std::string::npos);
    CHECK(frame["difference"]["pixels"].get<int>() > 0);
    auto const painted = static_cast<unsigned char const*>(tilemesh_pixels(handle.at, "difference"));
    REQUIRE(painted != nullptr);
    int red = 0;
    for (std::size_t i = 0; i < std::size_t{4} * 320 * 180; i += 4) red += painted[i] == 255 && painted[i + 2] == 0 ? 1 : 0;
    CHECK(red == frame["difference"]["pixels"].get<int>());

    // The complete picture is that of a machine that lacks nothing.
    std::vector<unsigned char> complete(std::size_t{4} * 320 * 180);
    std::memcpy(complete.data(), tilemesh_pixels(handle.at, "complete"), complete.size());
    REQUIRE(handle.set({{"channel_slots", 0}, {"saturation", "preset"}}));
    REQUIRE(handle.render(numbers(turn(map, 1)[0])));
    auto const whole = handle.report("frame");
    CHECK(whole["missing"] == "");
    CHECK(whole["difference"]["pixels"] == 0);
    CHECK(whole["difference"]["psnr_db"].is_null());
    CHECK(std::memcmp(complete.data(), tilemesh_pixels(handle.at, "rgba"), complete.size()) == 0);
}

TEST_CASE("the path of a Gaussian begins where it was and ends where it is")
{
    auto const map = scene::built_in_map();
    Handle const handle(Json{{"width", 320}, {"height", 180}});
    auto const cameras = turn(map, 2);
    REQUIRE(handle.render(numbers(cameras[0])));
    // A record that a turn moves: the anchored ones of a tile, before and after.
    std::uint32_t moved = 0;
    for (std::uint32_t t = 600; t < 800 && moved == 0; ++t) {
        auto const before = handle.tile(t);
        for (auto const& r : before["list"])
            if (moved == 0 && r["kind"] == "anchored") {
                auto const x = r["x"].get<double>() - before["rect"][0].get<double>();
                if (x < 0.3) moved = r["id"].get<std::uint32_t>();
            }
    }
    REQUIRE(moved != 0);
    auto const before = handle.gaussian(moved);
    CHECK(before["state"] == "on a tile");
    CHECK(before["path"].is_null());
    REQUIRE(handle.set({{"follow", moved}}));
    REQUIRE(handle.render(numbers(cameras[1])));
    auto const after = handle.gaussian(moved);
    REQUIRE(after["path"].is_array());
    REQUIRE(!after["path"].empty());
    Json first, last; // the tiles that store the record, not a copy of it
    for (auto const& s : after["path"]) {
        if (s["what"] != "anchored" && s["what"] != "leaving") continue;
        if (first.is_null()) first = s;
        if (s["what"] == "anchored") last = s;
    }
    REQUIRE(!last.is_null());
    CHECK(first["superstep"] == 0);
    CHECK(first["tile"] == before["anchor"]);
    CHECK(last["tile"] == after["anchor"]);
    CHECK(handle.gaussian(0xffffffffu)["state"] == "not in the map");
}

TEST_CASE("the difference of a crowded tile is taken from a machine that has room")
{
    auto const map = scene::built_in_map();
    Handle const handle(Json{{"width", 320}, {"height", 180}, {"storage_slots", 40}, {"difference", true}});
    REQUIRE_MESSAGE(handle.render(numbers(turn(map, 1)[0])), handle.error());
    auto const frame = handle.report("frame");
    CHECK(frame["missing"].get<std::string>().find("of the map's") != std::string::npos);
    CHECK(frame["difference"]["pixels"].get<int>() > 0);
    CHECK(sum(handle.heat("lost")) == frame["lost_copies"].get<double>() + frame["lost_records"].get<double>());
}

TEST_CASE("presets, machines and sizes are settings, and every setting has its limits")
{
    auto const map = scene::built_in_map();
    Handle handle;
    for (char const* preset : {"lossless", "paper", "prototype"})
        for (char const* machine : {"mk2", "test"}) {
            CAPTURE(preset);
            CAPTURE(machine);
            REQUIRE_MESSAGE(handle.set({{"width", 160}, {"height", 96}, {"preset", preset}, {"machine", machine}}), handle.error());
            REQUIRE_MESSAGE(handle.render(numbers(turn(map, 1, {160, 96})[0])), handle.error());
            CHECK(handle.report("run")["preset"] == preset);
            CHECK(handle.report("frame")["columns"].get<int>() > 0);
        }
    auto const settings = handle.report("settings");
    CHECK(settings["preset"] == "prototype");
    CHECK(settings["limits"]["channel_slots"]["most"] == 100);
    CHECK(settings["limits"]["channel_slots"]["used"] == 100);
    REQUIRE(handle.set({{"tile_width", 16}, {"tile_height", 16}}));
    REQUIRE_MESSAGE(handle.render(numbers(turn(map, 1, {160, 96})[0])), handle.error());
    CHECK(handle.report("frame")["tile_width"] == 16);
}

TEST_CASE("a mistake is one line, and the handle lives")
{
    Handle handle;
    CHECK(handle.error().empty());
    refused(handle, tilemesh_pixels(handle.at, "rgba")); // there is no frame
    CHECK(tilemesh_report(handle.at, "frame") == nullptr);
    REQUIRE(handle.set({{"width", 64}, {"height", 48}}));
    auto const start = handle.report("map")["start"].get<std::vector<double>>();
    REQUIRE(start.size() == 17);
    REQUIRE(handle.render(start));
    auto const digest = handle.report("digest")["picture"];

    for (char const* json : {"", "{", "7", "[]", "\"x\"", "{\"width\": 8}", "{\"width\": 1e9}", "{\"width\": 64.5}", "{\"width\": \"a\"}", "{\"wide\": 3}",
                             "{\"preset\": \"mk3\"}", "{\"channel_slots\": 201}", "{\"channel_slots\": -1}", "{\"tile_width\": 8}",
                             "{\"preset\": \"paper\", \"hops\": 3}", "{\"background\": [0, 0]}", "{\"background\": [0, 0, 2]}", "{\"difference\": 1}",
                             "{\"follow\": -2}", "{\"tile_width\": 1, \"tile_height\": 1}", "{\"tile_width\": 200, \"tile_height\": 200, \"width\": 400}", "{\"width\": null}",
                             "{\"width\": 99999999999999999999999}", "\xff\xfe"}) {
        CAPTURE(json);
        refused(handle, tilemesh_set(handle.at, json));
    }
    CHECK(tilemesh_set(handle.at, "{\"chanel_slots\": 3}") == 0); // the nearest name is named
    CHECK_MESSAGE(handle.error().find("but there is channel_slots") != std::string::npos, handle.error());
    CHECK(tilemesh_set(handle.at, "{\"sh_degree\": 0}") == 0); // an option of render_map that is no setting says why
    CHECK_MESSAGE(handle.error().find("it is none: ") != std::string::npos, handle.error());
    REQUIRE(handle.set({{"antialias", true}}));
    REQUIRE(handle.render(start));
    CHECK(handle.report("digest")["picture"] != digest);
    REQUIRE(handle.set({{"antialias", false}}));
    REQUIRE(handle.render(start));
    for (std::size_t i = 0; i < 17; ++i)
        for (double const v : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
            auto camera = start;
            camera[i] = v;
            refused(handle, handle.render(camera));
        }
    for (std::size_t const i : {12u, 13u, 16u})
        for (double const v : {0.0, -1.0}) {
            auto camera = start;
            camera[i] = v;
            CHECK(!handle.render(camera));
        }
    for (char const* const fault : {"zero", "mirrored", "sheared"}) { // as camera files refuse them; a tracker, too
        CAPTURE(fault);
        auto camera = start;
        for (std::size_t i = 0; i < 3; ++i) {
            if (*fault == 'z') camera[i] = camera[3 + i] = camera[6 + i] = 0;
            if (*fault == 'm') camera[i] = -camera[i];
            if (*fault == 's') camera[i] += 0.01 * camera[3 + i];
        }
        CHECK(!handle.render(camera));
        CHECK(handle.error().find(*fault == 'm' ? "its rotation is mirrored" : "its rotation is not orthonormal") != std::string::npos);
        refused(handle, tilemesh_track_begin(handle.at, camera.data(), 0));
    }
    CHECK(tilemesh_render(handle.at, nullptr) == 0);
    CHECK(tilemesh_pixels(handle.at, "rgb") == nullptr);
    CHECK(tilemesh_pixels(handle.at, nullptr) == nullptr);
    CHECK(tilemesh_pixels(handle.at, "difference") == nullptr);
    CHECK(tilemesh_heat(handle.at, "heat", -1) == nullptr);
    CHECK(tilemesh_heat(handle.at, "load", -2) == nullptr);
    CHECK(tilemesh_heat(handle.at, "load", 1'000'000) == nullptr);
    refused(handle, tilemesh_tile(handle.at, 1440));
    refused(handle, handle.load("a.ply", "ply\nformat nonsense 1.0\n"));
    CHECK(!handle.load("a.png", "\x89PNG"));
    CHECK(tilemesh_load(handle.at, nullptr, "", 0) == 0);
    refused(handle, tilemesh_trajectory(handle.at, "t", "1 2 3", 5));
    CHECK(tilemesh_trajectory(handle.at, "t", nullptr, 0) == nullptr);
    refused(handle, tilemesh_cameras(handle.at, nullptr));
    refused(handle, tilemesh_cameras(handle.at, "no such file"));

    // The frame is still there, and the next one is as it would have been.
    CHECK(handle.report("digest")["picture"] == digest);
    REQUIRE(handle.render(start));
    CHECK(handle.error().empty());
    CHECK(handle.report("digest")["picture"] == digest);

    CHECK(tilemesh_load(nullptr, nullptr, nullptr, 0) == 0);
    CHECK(tilemesh_report(nullptr, "map") == nullptr);
    CHECK(std::string(tilemesh_error(nullptr)).find("no handle") == 0);
    tilemesh_destroy(nullptr);
}

TEST_CASE("no text is too deep, and every error is UTF-8")
{
    Handle handle;
    auto const deep = "{\"width\": " + std::string(100'000, '[') + std::string(100'000, ']') + "}";
    refused(handle, tilemesh_set(handle.at, deep.c_str()));
    auto const in_utf8 = [&](auto result) {
        refused(handle, result);
        CHECK_NOTHROW((void)Json(handle.error()).dump()); // it throws if the text is not UTF-8
    };
    std::string const odd = "\xff\xfe\xc3";
    in_utf8(tilemesh_report(handle.at, odd.c_str()));
    in_utf8(handle.load(odd, "garbage"));
    in_utf8(tilemesh_set(handle.at, ("{\"" + std::string(59, 'a') + "\xc3\xa9\": 1}").c_str())); // the cut falls into a letter
}

TEST_CASE("another number of the mesh begins anew, as the first frame did")
{
    auto const map = scene::built_in_map();
    Handle const handle(Json{{"width", 160}, {"height", 96}});
    auto const cameras = turn(map, 3, {160, 96});
    REQUIRE(handle.render(numbers(cameras[0])));
    auto const first = handle.report("digest");
    REQUIRE(handle.render(numbers(cameras[2])));
    REQUIRE(handle.render(numbers(cameras[0])));
    CHECK(handle.report("digest")["picture"] == first["picture"]);
    CHECK(handle.report("digest")["counters"] != first["counters"]); // records started where they were
    REQUIRE(handle.set({{"mesh", 1}}));
    REQUIRE(handle.render(numbers(cameras[0])));
    CHECK(handle.report("digest") == first);
}

TEST_CASE("the complete picture of each preset is that of a machine that lacks nothing")
{
    auto const map = scene::built_in_map();
    auto const camera = numbers(turn(map, 1, {160, 96})[0]);
    constexpr std::size_t bytes = std::size_t{4} * 160 * 96;
    for (char const* preset : {"lossless", "paper", "prototype"}) {
        CAPTURE(preset);
        Handle const handle(Json{{"width", 160}, {"height", 96}, {"preset", preset}, {"machine", "test"}, {"saturation", "hold"}});
        REQUIRE_MESSAGE(handle.render(camera), handle.error());
        REQUIRE(handle.report("frame")["missing"] == "");
        std::vector<unsigned char> expected(bytes);
        std::memcpy(expected.data(), tilemesh_pixels(handle.at, "rgba"), bytes);
        REQUIRE(handle.set({{"storage_slots", 60}, {"difference", true}}));
        REQUIRE_MESSAGE(handle.render(camera), handle.error());
        CHECK(handle.report("frame")["missing"] != "");
        CHECK(std::memcmp(expected.data(), tilemesh_pixels(handle.at, "complete"), bytes) == 0);
    }
}

TEST_CASE("a camera that sees nothing gives a picture and numbers")
{
    auto const map = scene::built_in_map();
    Handle const handle(Json{{"width", 64}, {"height", 48}, {"difference", true}});
    auto camera = handle.report("map")["start"].get<std::vector<double>>();
    for (std::size_t i : {0u, 1u, 2u, 6u, 7u, 8u}) camera[i] = -camera[i]; // everything is behind it
    REQUIRE_MESSAGE(handle.render(camera), handle.error());
    CHECK(handle.report("frame")["visible"] == 0);
    for (char const* what : {"load", "copies", "channel", "refused", "lost", "pairs", "busy"})
        for (float const v : handle.heat(what)) CHECK(v >= 0.0f);
    CHECK(handle.tile(0)["list"].empty());
    auto const g = handle.gaussian(0xfffffff0u);
    CHECK(g["state"] == "not in the map");
    CHECK(g["mean"].is_null());
    CHECK(g["missing"].empty());
}

TEST_CASE("a map and a trajectory from bytes")
{
    Handle handle;
    REQUIRE_MESSAGE(handle.load("one.ply", ply({{0, 0, 0}})), handle.error());
    auto const map = handle.report("map");
    CHECK(map["gaussians"] == 1);
    REQUIRE_MESSAGE(handle.render(map["start"].get<std::vector<double>>()), handle.error());
    CHECK(handle.report("frame")["visible"] == 1);
    auto const g = handle.gaussian(1);
    CHECK(g["state"] == "on a tile");
    REQUIRE(tilemesh_load(handle.at, nullptr, nullptr, 0) == 1);
    CHECK(handle.report("map")["name"] == "built_in");
    CHECK(tilemesh_pixels(handle.at, "rgba") == nullptr); // the frame was of another map

    std::string const tum = "# stamps\n1.5 0 0 1 0 0 0 1\n2.5 0 0 2 0 0 0 1\n";
    auto const poses = handle.parsed(tilemesh_trajectory(handle.at, "t.txt", tum.data(), tum.size()));
    CHECK(poses["format"] == "tum");
    REQUIRE(poses["poses"].size() == 2);
    CHECK(poses["poses"][1]["seconds"] == 2.5);
    CHECK(poses["poses"][1]["position"] == Json({0.0, 0.0, 2.0}));
    CHECK(poses["poses"][1]["rotation"] == Json({1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}));
}

TEST_SUITE_END();
