// test: unoptimised test asan
#include "support.hpp"
#include <cmath>
#include <cstdint>
#include <doctest/doctest.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <vector>

using namespace scene_test;
using namespace tilemesh;
using nlohmann::json;

namespace {

/// A frame whose camera stands at (1, 2, 3).
json frame(std::string const& path, json rotation = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
{
    json matrix = json::array();
    for (unsigned row = 0; row < 3; ++row) {
        matrix.push_back(rotation[row]);
        matrix.back().push_back(row + 1);
    }
    matrix.push_back({0, 0, 0, 1});
    return {{"file_path", path}, {"transform_matrix", matrix}};
}
json const lens = {{"w", 640}, {"h", 480}, {"fl_x", 500}, {"fl_y", 510}, {"cx", 320.5}, {"cy", 239.5}};

json file_of(std::vector<json> const& frames, json const& beside = lens)
{
    json file = beside;
    file["frames"] = frames;
    return file;
}
std::vector<scene::NamedCamera> read(std::string const& text, std::vector<std::string>* notes = nullptr,
                                     scene::DistortedLens distorted = scene::DistortedLens::refused)
{
    std::istringstream stream(text);
    return scene::read_cameras_json(stream, "t.json", notes, distorted);
}
std::string refusal(json const& file)
{
    return error_of([&] { read(file.dump()); });
}
template <class Change>
std::string refusal_of_second(Change const& change)
{
    auto second = frame("b");
    change(second);
    return refusal(file_of({frame("a"), second}));
}

} // namespace

TEST_CASE("a transforms.json is read field by field; its cameras look along -z with y up")
{
    auto const cameras = read(file_of({frame("./images/a.png"), frame("b", {{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}})}).dump());
    REQUIRE(cameras.size() == 2);
    CHECK(cameras[0].scene.empty());
    CHECK(cameras[0].file.empty());
    CHECK(cameras[0].name == "images/a.png");
    CHECK(cameras[1].name == "b");
    auto const& c = cameras[0].camera;
    CHECK(c.width == 640);
    CHECK(c.height == 480);
    CHECK(c.fx == 500.0f);
    CHECK(c.fy == 510.0f);
    CHECK(c.cx == 320.5f);
    CHECK(c.cy == 239.5f);
    CHECK(c.near_depth == 0.2f);
    // x stays; y points down, so against the world's y; z points forward, against the world's z.
    float const upright[3][3] = {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
    // Turned by a quarter about y: the camera's right is the world's -z, it looks along the world's -x.
    float const turned[3][3] = {{0, 0, -1}, {0, -1, 0}, {-1, 0, 0}};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) {
            CHECK(c.rotation[row][column] == upright[row][column]);
            CHECK(cameras[1].camera.rotation[row][column] == turned[row][column]);
            CHECK(c.position[row] == static_cast<float>(row + 1));
        }
}

TEST_CASE("a frame's lens replaces the file's, field by field, wherever the file's stands")
{
    auto own = frame("own");
    own.update({{"w", 320}, {"fl_x", 250}, {"cx", 11}});
    json const frames = {frame("a"), own};
    for (bool const before : {false, true}) {
        auto const beside = lens.dump();
        std::string const text = before ? beside.substr(0, beside.size() - 1) + ",\"frames\":" + frames.dump() + "}"
                                        : "{\"frames\":" + frames.dump() + "," + beside.substr(1);
        auto const cameras = read(text);
        REQUIRE(cameras.size() == 2);
        CHECK(cameras[0].camera.width == 640);
        CHECK(cameras[1].camera.width == 320);
        CHECK(cameras[1].camera.height == 480);
        CHECK(cameras[1].camera.fx == 250.0f);
        CHECK(cameras[1].camera.fy == 510.0f);
        CHECK(cameras[1].camera.cx == 11.0f);
        CHECK(cameras[1].camera.cy == 239.5f);
    }
}

TEST_CASE("what a lens leaves out follows from the rest")
{
    auto const camera = [](json const& beside) { return read(file_of({frame("a")}, beside).dump()).at(0).camera; };
    auto c = camera({{"w", 640}, {"h", 480}, {"fl_x", 500}});
    CHECK(c.fy == 500.0f);
    CHECK(c.cx == 320.0f);
    CHECK(c.cy == 240.0f);
    double const right_angle = std::acos(0.0);
    c = camera({{"w", 640}, {"h", 480}, {"camera_angle_x", right_angle}}); // half a side is as long as the focal length
    CHECK(c.fx == doctest::Approx(320.0));
    CHECK(c.fy == c.fx);
    c = camera({{"w", 640}, {"h", 480}, {"camera_angle_x", right_angle}, {"camera_angle_y", right_angle}});
    CHECK(c.fy == doctest::Approx(240.0));
    c = camera({{"w", 640}, {"h", 480}, {"camera_angle_x", right_angle}, {"camera_angle_y", right_angle}, {"fl_x", 100}});
    CHECK(c.fx == 100.0f);
    CHECK(c.fy == 100.0f);
    CHECK(read(file_of({}, json::object()).dump()).empty());
}

TEST_CASE("coefficients of 0 are a pinhole; others, and fisheyes, are refused or ignored")
{
    auto const of_frame = [](json const& more) {
        auto bent = frame("bent");
        bent.update(more);
        return file_of({frame("a"), bent});
    };
    for (char const* model : {"OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "FULL_OPENCV", "RADIAL", "SIMPLE_RADIAL", "perspective"})
        CHECK(refusal(of_frame({{"camera_model", model}, {"k1", 0}, {"k2", 0.0}, {"p1", -0.0}, {"is_fisheye", false}})).empty());
    for (json const& more : {json{{"k1", 1e-9}}, json{{"p2", -0.1}}, json{{"camera_model", "OPENCV_FISHEYE"}}, json{{"is_fisheye", true}},
                             json{{"camera_model", "EQUIRECTANGULAR"}}, json{{"camera_model", "OPENCV"}, {"k4", 0.5}}}) {
        CAPTURE(more.dump());
        CHECK(has(refusal(of_frame(more)), "t.json frame bent has a lens with distortion ("));
        CHECK(has(refusal(of_frame(more)), "colmap image_undistorter"));
        auto all = lens;
        all.update(more);
        CHECK(has(refusal(file_of({frame("a")}, all)), "t.json frame a has a lens with distortion ("));
        std::vector<std::string> notes;
        CHECK(read(file_of({frame("a"), frame("b")}, all).dump(), &notes, scene::DistortedLens::ignored).size() == 2);
        CHECK(notes == std::vector<std::string>{"2 cameras have a lens with distortion, which is ignored: the picture is a pinhole's"});
    }
    // A frame's coefficient replaces the file's.
    auto all = lens;
    all["k1"] = 0.1;
    auto straight = frame("a");
    straight["k1"] = 0;
    CHECK(refusal(file_of({straight}, all)).empty());
    CHECK_FALSE(refusal(file_of({straight, frame("b")}, all)).empty());
}

TEST_CASE("the other forms ignore distortion on demand, too")
{
    std::string const pose = R"("width":9,"height":9,"fx":9,"fy":9,"cx":4,"cy":4,"world_to_camera":[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]])";
    std::vector<std::string> notes;
    CHECK(read(R"({"cameras":[{"name":"a",)" + pose + R"(,"k1":0.1},{"name":"b",)" + pose + "}]}", &notes, scene::DistortedLens::ignored).size() == 2);
    CHECK(notes == std::vector<std::string>{"1 camera has a lens with distortion, which is ignored: the picture is a pinhole's"});
    notes.clear();
    CHECK(read(R"({"k1":1,"cameras":[{"name":"a",)" + pose + R"(},{"name":"b",)" + pose + "}]}", &notes, scene::DistortedLens::ignored).size() == 2);
    CHECK(notes == std::vector<std::string>{"2 cameras have a lens with distortion, which is ignored: the picture is a pinhole's"});
}

TEST_CASE("the fault of a frame is named")
{
    CHECK(refusal_of_second([](json&) {}).empty());
    CHECK(has(refusal_of_second([](json& f) { f.erase("file_path"); }), "t.json frame 2 is not usable (it has no \"file_path\"); correct"));
    CHECK(has(refusal_of_second([](json& f) { f["file_path"] = 7; }), "\"file_path\" is not a string"));
    CHECK(has(refusal_of_second([](json& f) { f["file_path"] = "a\nb"; }), "\"file_path\" is not one line of text"));
    CHECK(has(refusal_of_second([](json& f) { f["file_path"] = ""; }), "\"file_path\" is empty"));
    CHECK(has(refusal_of_second([](json& f) { f["file_path"] = "./a"; }), "frame a is not usable (another frame has the same file_path)"));
    CHECK(has(refusal_of_second([](json& f) { f.erase("transform_matrix"); }), "it has no \"transform_matrix\""));
    CHECK(has(refusal_of_second([](json& f) { f["transform_matrix"].erase(3); }), "\"transform_matrix\" is not a 4x4 matrix"));
    CHECK(has(refusal_of_second([](json& f) { f["transform_matrix"][0][0] = "x"; }), "\"transform_matrix\" is not a number"));
    CHECK(has(refusal_of_second([](json& f) { f["transform_matrix"][3][0] = 1; }), "frame b is not usable (the last row of"));
    CHECK(has(refusal_of_second([](json& f) { f["transform_matrix"][0][0] = 2; }), "not orthonormal"));
    CHECK(has(refusal_of_second([](json& f) { f["transform_matrix"][0][0] = -1; }), "mirrored"));
    CHECK(has(refusal_of_second([](json& f) { f["w"] = 640.5; }), "\"w\" is not a whole number from 1 to 65535"));
    CHECK(has(refusal_of_second([](json& f) { f["h"] = "x"; }), "\"h\" is not a number"));
    CHECK(has(refusal_of_second([](json& f) { f["fl_x"] = 0; }), "fx is not positive"));
    CHECK(has(refusal_of_second([](json& f) { f["fl_y"] = -1; }), "fy is not positive"));
    CHECK(has(refusal_of_second([](json& f) { f["cx"] = 1e30; }), "cx is more than 2^24 pixels away"));
    CHECK(has(refusal_of_second([](json& f) { f = 5; }), "t.json frame 2 is not usable (it is not an object)"));
    CHECK(has(refusal(file_of({frame("a"), 5, frame("c")})), "frame 2 is not usable"));

    auto const without = [](char const* key) {
        auto less = lens;
        less.erase(key);
        return refusal(file_of({frame("a")}, less));
    };
    CHECK(has(without("w"), "frame a is not usable (neither it nor the file has \"w\", the size of its picture in pixels)"));
    CHECK(has(without("h"), "has \"h\""));
    CHECK(has(without("fl_x"), "neither it nor the file has \"fl_x\" or \"camera_angle_x\""));
    for (double const angle : {0.0, -1.0, 3.1415926535897932, 7.0})
        CHECK(has(refusal(file_of({frame("a")}, {{"w", 9}, {"h", 9}, {"camera_angle_x", angle}})), "\"camera_angle_x\" is not between 0 and pi"));
    CHECK(has(refusal({{"frames", 3}}), "frame 1 is not usable (it is not an object)"));
    CHECK(has(refusal({{"camera_angle_x", 0.7}}), "it has no list \"cameras\" or \"frames\""));
    // A fault of the text itself goes first, and cameras[] beside frames[] is read.
    CHECK(has(error_of([] { read(R"({"frames": [5], )"); }), "is not JSON"));
    CHECK(read(R"({"frames": [5], "cameras": []})").empty());
}

TEST_CASE("keys of frames that are not read are named, except those that say nothing about the camera")
{
    auto f = frame("a");
    f.update({{"exposure", 1}, {"sharpness", 2}, {"depth_file_path", "d"}, {"mask_path", "m"}, {"colmap_im_id", 4}});
    std::vector<std::string> notes;
    auto file = file_of({f, frame("b")});
    file["aabb_scale"] = 16;
    read(file.dump(), &notes);
    CHECK(notes == std::vector<std::string>{"1 camera has \"exposure\", which is not read"});
}
