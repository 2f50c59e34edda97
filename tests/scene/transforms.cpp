// test: unoptimised test asan
#include "support.hpp"
#include <nlohmann/json.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/detail/picture_size.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>

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
std::vector<scene::NamedCamera> read(std::string const& text, Lines* notes = nullptr, scene::DistortedLens distorted = scene::DistortedLens::refused)
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
    check_lens(c, 640, 480, 500, 510, 320.5f, 239.5f);
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
        check_lens(cameras[1].camera, 320, 480, 250, 510, 11, 239.5f);
    }
}

TEST_CASE("what a lens leaves out follows from the rest")
{
    auto const camera = [](json const& beside) { return read(file_of({frame("a")}, beside).dump()).at(0).camera; };
    check_lens(camera({{"w", 640}, {"h", 480}, {"fl_x", 500}}), 640, 480, 500, 500, 320, 240);
    double const right_angle = std::acos(0.0);
    auto c = camera({{"w", 640}, {"h", 480}, {"camera_angle_x", right_angle}}); // half a side is as long as the focal length
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
                             json{{"camera_model", "FISHEYE624"}}, json{{"camera_model", "OPENCV"}, {"k4", 0.5}}}) {
        CAPTURE(more.dump());
        CHECK(has(refusal(of_frame(more)), "t.json frame bent has a lens with distortion ("));
        CHECK(has(refusal(of_frame(more)), "colmap image_undistorter"));
        auto all = lens;
        all.update(more);
        CHECK(has(refusal(file_of({frame("a")}, all)), "t.json frame a has a lens with distortion ("));
        Lines notes;
        CHECK(read(file_of({frame("a"), frame("b")}, all).dump(), &notes, scene::DistortedLens::ignored).size() == 2);
        CHECK(notes == Lines{"2 cameras have a lens with distortion, which is ignored: the picture is a pinhole's"});
    }
    // A frame's coefficient replaces the file's.
    auto all = lens;
    all["k1"] = 0.1;
    auto straight = frame("a");
    straight["k1"] = 0;
    CHECK(refusal(file_of({straight}, all)).empty());
    CHECK_FALSE(refusal(file_of({straight, frame("b")}, all)).empty());
}

TEST_CASE("the lens of a frame is that of the file but for the frame's own keys")
{
    auto all = lens;
    all["camera_model"] = "OPENCV", all["k1"] = 0.125, all["p1"] = 0.0625;
    auto own = frame("b"), round = frame("c");
    own["k1"] = -0.0625;
    round["camera_model"] = "OPENCV_FISHEYE", round["p1"] = 0;
    auto const cameras = read(file_of({frame("a"), own, round}, all).dump(), nullptr, scene::DistortedLens::kept);
    REQUIRE(cameras.size() == 3);
    CHECK(cameras[0].camera.lens.kind == splat::LensKind::opencv);
    CHECK(cameras[0].camera.lens.k[0] == 0.125f);
    CHECK(cameras[1].camera.lens.k[0] == -0.0625f);
    CHECK(cameras[1].camera.lens.p[0] == 0.0625f);
    CHECK(cameras[2].camera.lens.kind == splat::LensKind::fisheye);
    auto ngp = lens;
    ngp["is_fisheye"] = true;
    CHECK(read(file_of({frame("a")}, ngp).dump(), nullptr, scene::DistortedLens::kept).at(0).camera.lens.kind == splat::LensKind::fisheye);
}

TEST_CASE("the other forms ignore distortion on demand, too")
{
    std::string const pose = R"("width":9,"height":9,"fx":9,"fy":9,"cx":4,"cy":4,"world_to_camera":[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]])";
    Lines notes;
    CHECK(read(R"({"cameras":[{"name":"a",)" + pose + R"(,"k1":0.1},{"name":"b",)" + pose + "}]}", &notes, scene::DistortedLens::ignored).size() == 2);
    CHECK(notes == Lines{"1 camera has a lens with distortion, which is ignored: the picture is a pinhole's"});
    notes.clear();
    CHECK(read(R"({"k1":1,"cameras":[{"name":"a",)" + pose + R"(},{"name":"b",)" + pose + "}]}", &notes, scene::DistortedLens::ignored).size() == 2);
    CHECK(notes == Lines{"2 cameras have a lens with distortion, which is ignored: the picture is a pinhole's"});
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
    Lines notes;
    auto file = file_of({f, frame("b")});
    file["aabb_scale"] = 16;
    file["ply_file_path"] = "points.ply";
    read(file.dump(), &notes);
    CHECK(notes == Lines{"1 camera has \"depth_file_path\", which is not read", "1 camera has \"exposure\", which is not read"});
}

TEST_CASE("a field of view that contradicts the focal length is noted; one that agrees is not")
{
    auto const notes_of = [](json const& more) {
        auto file = file_of({frame("a"), frame("b")});
        file["frames"][1].update(more);
        Lines notes;
        read(file.dump(), &notes);
        return notes;
    };
    auto const file = file_of({frame("a")});
    double const side = file["w"], focal = file["fl_x"], angle = 2 * std::atan(0.5 * side / focal);
    CHECK(notes_of({{"camera_angle_x", angle}}) == Lines{});
    CHECK(notes_of({{"camera_angle_x", std::round(angle * 1e5) / 1e5}}) == Lines{});
    CHECK(notes_of({{"camera_angle_x", "wide"}}) == Lines{});
    Lines const noted{"1 camera has a focal length and a camera_angle that are more than 1 % apart: the focal length counts"};
    CHECK(notes_of({{"camera_angle_x", 0.5 * angle}}) == noted);
    CHECK(notes_of({{"fl_y", focal}, {"camera_angle_y", 3.0}}) == noted);
}

TEST_CASE("masks and the lists of views are read; a frame of no list is left out, and a name of no frame is noted")
{
    using scene::Split;
    auto const splits = [](json const& lists, Lines* notes = nullptr) {
        auto file = file_of({frame("a"), frame("./b"), frame("c\\d"), frame("e")});
        file.update(lists);
        std::vector<Split> out;
        for (auto const& camera : read(file.dump(), notes)) out.push_back(camera.split);
        return out;
    };
    auto const u = Split::unsaid, t = Split::training, h = Split::held_out, n = Split::unused;
    Lines notes;
    CHECK(splits(json::object()) == std::vector{u, u, u, u});
    CHECK(splits({{"train_filenames", {"a", "b"}}, {"test_filenames", {"c/d"}}}) == std::vector{t, t, h, n});
    CHECK(splits({{"train_filenames", {"a", "b"}}, {"val_filenames", {".\\b", "e"}}}) == std::vector{t, h, n, h});
    CHECK(splits({{"train_filenames", {"a", "b"}}}) == std::vector{t, t, h, h});
    CHECK(splits({{"val_filenames", {"e"}}, {"test_filenames", {"e", "c/d"}}}, &notes) == std::vector{t, t, h, h});
    CHECK(splits({{"train_filenames", {"a", "b", "c/d", "e"}}, {"test_filenames", json::array()}}) == std::vector{u, u, u, u});
    CHECK(notes.empty());
    CHECK(splits({{"test_filenames", {"e", "f"}}}, &notes) == std::vector{t, t, t, h});
    CHECK(notes == Lines{"1 of 2 names in train_filenames, test_filenames and val_filenames are of no frame"});
    notes.clear();
    CHECK(splits({{"test_filenames", 3}, {"train_filenames", {"a", 4}}}, &notes) == std::vector{t, h, h, h});
    CHECK(notes == Lines{"the file has \"test_filenames\", which is not read", "the file has \"train_filenames\", which is not read"});

    auto masked = frame("b");
    masked["mask_path"] = ".\\masks\\b.png";
    auto const cameras = read(file_of({frame("a"), masked}).dump());
    CHECK(cameras[0].mask.empty());
    CHECK(cameras[1].mask == "masks/b.png");
    masked["mask_path"] = nullptr;
    CHECK(read(file_of({masked}).dump())[0].mask.empty());
    CHECK(has(refusal_of_second([](json& f) { f["mask_path"] = json{{"a", nullptr}}; }), "\"mask_path\" is not a string"));
    CHECK(has(refusal_of_second([](json& f) { f["mask_path"] = 3; }), "\"mask_path\" is not a string"));
}

TEST_CASE("cameras that no pinhole replaces are named, with distortion ignored too")
{
    for (auto const distorted : {scene::DistortedLens::refused, scene::DistortedLens::ignored})
        for (auto const& [key, value, is] : {std::tuple{"camera_model", json("EQUIRECTANGULAR"), "an equirectangular"},
                                             {"camera_model", json("ORTHOPHOTO"), "an orthographic"},
                                             {"equirectangular", json(true), "an equirectangular"},
                                             {"orthographic", json(true), "an orthographic"}}) {
            auto beside = lens;
            beside[key] = value;
            auto one = frame("b");
            one[key] = value;
            auto const of = [&, d = distorted](json const& file) { return error_of([&] { read(file.dump(), nullptr, d); }); };
            CHECK(has(of(file_of({frame("a")}, beside)), std::string("t.json frame a has ") + is + " camera (its camera model is "));
            CHECK(has(of(file_of({frame("a"), one})), std::string("t.json frame b has ") + is));
        }
    auto beside = lens;
    beside["orthographic"] = false;
    CHECK(refusal(file_of({frame("a")}, beside)).empty());
}

TEST_CASE("keys beside the frames that are not read are named, except those that say nothing about the cameras")
{
    Lines notes;
    read(R"({"fl_x": 240, "fl_Y": 120, "cx": 160, "cY": 20, "w": 320, "h": 180, "frames": [)" + frame("r.png").dump() + "]}", &notes);
    CHECK(notes == Lines{"the file has \"fl_Y\", which is not read", "the file has \"cY\", which is not read"});
    // Any key that is not one of a lens is named, wherever it stands; of many, eight.
    for (std::size_t count : {1u, 3u, 8u, 9u, 20u})
        for (std::size_t before_frames : {std::size_t{0}, count / 2, count}) {
            std::string text = "{";
            for (std::size_t i = 0; i < count; ++i) {
                if (i == before_frames) text += "\"frames\":[" + frame("a").dump() + "],";
                text += "\"K" + std::to_string(i) + "\":" + (i % 2 == 0 ? "[1,{\"w\":2}]," : "null,");
            }
            if (before_frames == count) text += "\"frames\":[" + frame("a").dump() + "],";
            notes.clear();
            read(text + lens.dump().substr(1), &notes);
            REQUIRE(notes.size() == std::min<std::size_t>(count, 9));
            for (std::size_t i = 0; i < std::min<std::size_t>(count, 8); ++i)
                CHECK(notes[i] == "the file has \"K" + std::to_string(i) + "\", which is not read");
            if (count > 8) CHECK(notes[8] == "the file has more keys that are not read");
        }
}

namespace {

std::string big_endian(std::uint32_t value, std::size_t bytes)
{
    std::string out;
    for (std::size_t i = bytes; i-- > 0;) out += static_cast<char>(value >> 8 * i & 255u);
    return out;
}
std::string png_header(std::uint32_t width, std::uint32_t height)
{
    return "\x89PNG\r\n\x1a\n" + big_endian(13, 4) + "IHDR" + big_endian(width, 4) + big_endian(height, 4) + std::string("\x08\x02\0\0\0", 5);
}
/// `before`: segments in front of the frame.
std::string jpeg_header(std::uint32_t width, std::uint32_t height, char frame_marker, Lines const& before)
{
    std::string out = "\xff\xd8";
    for (auto const& segment : before) out += "\xff\xe1" + big_endian(static_cast<std::uint32_t>(segment.size() + 2), 2) + segment;
    return out + "\xff\xff" + frame_marker + big_endian(17, 2) + "\x08" + big_endian(height, 2) + big_endian(width, 2) + "\x03";
}
std::optional<scene::Size> size_in(std::string const& bytes)
{
    std::istringstream stream(bytes);
    return scene::detail::picture_size(stream);
}

} // namespace

TEST_CASE("the header of a PNG or JPEG says the picture's size; anything else says none")
{
    std::mt19937 random(8);
    for (int round = 0; round < 200; ++round) {
        auto const side = [&] { return static_cast<std::uint32_t>(1 + random() % 65535); };
        std::uint32_t const width = side(), height = side();
        Lines before(random() % 4);
        for (auto& segment : before) segment.assign(random() % 60000, static_cast<char>(random()));
        std::string const png = png_header(width, height);
        std::string const jpeg = jpeg_header(width, height, "\xc0\xc1\xc2\xc9"[random() % 4], before);
        for (auto const& bytes : {png, jpeg}) {
            auto const size = size_in(bytes);
            REQUIRE(size);
            CHECK(size->width == width);
            CHECK(size->height == height);
        }
        CHECK_FALSE(size_in(png.substr(0, random() % 24)));
        CHECK_FALSE(size_in(jpeg.substr(0, jpeg.size() - 3 - random() % 6)));
    }
    CHECK_FALSE(size_in(png_header(0, 5)));
    CHECK_FALSE(size_in(png_header(65536, 5)));
    CHECK_FALSE(size_in(""));
    CHECK_FALSE(size_in("GIF89a" + std::string(30, '\0')));
    CHECK_FALSE(size_in("\xff\xd8" + std::string(100, '\xff')));
    CHECK_FALSE(size_in("\xff\xd8\xff\xe1" + std::string(30, '\0')));
}

TEST_CASE("a frame without w and h has the size of its picture, or the size that was given")
{
    namespace fs = std::filesystem;
    TempFolder const folder;
    auto const load = [&](json const& file, Lines* notes = nullptr, std::optional<scene::Size> size = {}) {
        return scene::load_cameras(folder.write("transforms.json", file.dump()), notes, scene::DistortedLens::refused, size);
    };
    double const angle = 2 * std::atan(0.5); // the focal length is the width
    auto const has_size = [](scene::NamedCamera const& each, std::uint32_t width, std::uint32_t height) {
        return each.camera.width == width && each.camera.height == height && each.camera.fx == doctest::Approx(width);
    };
    json const blender = file_of({frame("./train/r_0"), frame("./train/r_1"), frame(".\\train\\r_2.jpg")}, {{"camera_angle_x", angle}});
    CHECK(has(error_of([&] { load(blender); }), "frame train/r_0 is not usable (neither it nor the file has \"w\" and \"h\", and no PNG or JPEG picture"));
    Lines notes;
    auto given = load(blender, &notes, scene::Size{320, 180});
    REQUIRE(given.size() == 3);
    for (auto const& each : given) {
        CHECK(has_size(each, 320, 180));
        CHECK(each.camera.cy == 90.0f);
    }
    CHECK(given[2].name == "train/r_2.jpg");
    REQUIRE(notes.size() == 1);
    CHECK(has(notes[0], "3 cameras have no \"w\" or \"h\": the size is that of the picture"));
    folder.write("train/r_0.png", png_header(800, 600));
    folder.write("train/r_1.JPG", jpeg_header(640, 400, '\xc2', {"Exif"}));
    folder.write("train/r_2.jpg", "not a picture");
    auto const mixed = load(blender, nullptr, scene::Size{320, 180});
    std::vector<fs::path> pictures;
    scene::load_cameras(folder.path() / "transforms.json", nullptr, scene::DistortedLens::refused, scene::Size{320, 180}, &pictures);
    CHECK(pictures == std::vector<fs::path>{folder.path() / "train/r_0.png", folder.path() / "train/r_1.JPG"});
    CHECK(has_size(mixed[0], 800, 600));
    CHECK(has_size(mixed[1], 640, 400));
    CHECK(has_size(mixed[2], 320, 180));
    // What the file says goes first; a missing side alone is the picture's.
    json half = blender;
    half["w"] = 400;
    half["frames"].erase(2);
    auto const sides = load(half);
    CHECK(has_size(sides[0], 400, 600));
}
