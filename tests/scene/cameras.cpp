// test: unoptimised test, needs data, cost 20
#include "support.hpp"
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <nlohmann/json.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>

using namespace scene_test;
using namespace tilemesh;
using nlohmann::json;

namespace {

json entry(std::string const& scene, std::string const& name)
{
    // A quarter turn about y: the camera looks along world -x.
    return {{"scene", scene}, {"file", scene + ".ply"}, {"name", name}, {"width", 640}, {"height", 480}, {"fx", 500.0}, {"fy", 510.0}, {"cx", 320.5},
            {"cy", 239.5}, {"near", 0.05}, {"world_to_camera", {{0, 0, 1, 1}, {0, 1, 0, 2}, {-1, 0, 0, 3}, {0, 0, 0, 1}}}};
}

std::string file_of(std::vector<json> const& cameras)
{
    return json{{"cameras", cameras}}.dump();
}
std::vector<scene::NamedCamera> load_text(std::string const& text, Lines* notes = nullptr,
                                          scene::DistortedLens distorted = scene::DistortedLens::refused)
{
    TempFile const file(text, ".json");
    return scene::load_cameras(file.path(), notes, distorted);
}
std::vector<scene::NamedCamera> load(std::vector<json> const& cameras)
{
    return load_text(file_of(cameras));
}

json training(std::string const& name, int id)
{
    return {{"id", id}, {"img_name", name}, {"width", 640}, {"height", 480}, {"position", {3.0, -2.0, -1.0}},
            {"rotation", {{0.0, 0.0, -1.0}, {0.0, 1.0, 0.0}, {1.0, 0.0, 0.0}}}, {"fy", 510.0}, {"fx", 500.0}};
}
std::vector<scene::NamedCamera> load_training(std::vector<json> const& cameras)
{
    return load_text(json(cameras).dump());
}

template <class Change>
std::string refusal(Change change)
{
    json broken = entry("desk", "left");
    change(broken);
    return error_of([&] { load({entry("desk", "front"), broken}); });
}

std::string refused_text(std::string const& text)
{
    return error_of([&] { load_text(text); });
}

} // namespace

TEST_CASE("a camera file is read field by field")
{
    auto const cameras = load({entry("desk", "front")});
    REQUIRE(cameras.size() == 1);
    CHECK(cameras[0].scene == "desk");
    CHECK(cameras[0].file == "desk.ply");
    CHECK(cameras[0].name == "front");
    auto const& c = cameras[0].camera;
    check_lens(c, 640, 480, 500, 510, 320.5f, 239.5f, 0.05f);
    CHECK(c.rotation[0][2] == 1.0f);
    CHECK(c.rotation[2][0] == -1.0f);
    CHECK(c.position[0] == 3.0f);
    CHECK(c.position[1] == -2.0f);
    CHECK(c.position[2] == -1.0f);

    json plain = entry("desk", "front");
    plain.erase("near");
    plain.erase("file");
    CHECK(load({plain})[0].camera.near_depth == 0.2f);
    CHECK(load({plain})[0].file.empty());
    CHECK(load({}).empty());
}

TEST_CASE("what is wrong with a camera is said in one line that names it")
{
    auto const says = [](std::string const& text, std::string const& word) { return has(text, "camera desk/left") && has(text, word); };
    for (char const* key : {"width", "height", "fx", "fy", "cx", "cy", "world_to_camera"}) {
        CHECK(says(refusal([&](json& c) { c.erase(key); }), key));
        CHECK(says(refusal([&](json& c) { c[key] = "wide"; }), key));
    }
    for (double const side : {0.0, -1.0, 65536.0, 12.5}) {
        CHECK(says(refusal([&](json& c) { c["width"] = side; }), "1 to 65535"));
        CHECK(says(refusal([&](json& c) { c["height"] = side; }), "1 to 65535"));
    }
    for (char const* key : {"fx", "fy", "near"})
        for (double const value : {0.0, -1.0}) CHECK(says(refusal([&](json& c) { c[key] = value; }), std::string(key) + " is not positive"));
    CHECK(says(refusal([](json& c) { c["near"] = 1e-60; }), "near is not positive"));
    CHECK(says(refusal([](json& c) { c["fx"] = 0.9, c["fy"] = 1.2, c["cx"] = c["cy"] = 0.5; }),
               "they are shares of the picture's sides, and not pixels"));
    for (double const value : {1e-60, 1e-30, 0.47})
        CHECK(says(refusal([&](json& c) { c["fy"] = value; }), "fy is below a thousandth of the picture's side"));
    CHECK(refusal([](json& c) { c["fy"] = 0.48; }).empty());
    for (double const value : {1e30, 16777217.0}) CHECK(says(refusal([&](json& c) { c["fx"] = value; }), "fx is above 2^24 pixels"));
    CHECK(refusal([](json& c) { c["fx"] = 16777216.0; }).empty());
    CHECK(says(refusal([](json& c) { c["cy"] = -1e30; }), "cy is more than 2^24 pixels away"));
    CHECK(says(refusal([](json& c) { c["cx"] = nullptr; }), "\"cx\" is not a number"));
    CHECK(says(refusal([](json& c) { c["cx"] = "320"; }), "\"cx\" is not a number"));
    CHECK(says(refusal([](json& c) { c["cx"] = true; }), "\"cx\" is not a number"));
    CHECK(says(refusal([](json& c) { c["cx"] = 1e300; }), "not a number within 1e37"));
    CHECK(says(refusal([](json& c) { c["world_to_camera"][1][3] = -1e38; }), "not a number within 1e37"));
    CHECK(says(refusal([](json& c) { c["world_to_camera"].erase(3); }), "4x4"));
    CHECK(says(refusal([](json& c) { c["world_to_camera"][1].push_back(0); }), "4x4"));
    CHECK(says(refusal([](json& c) { c["world_to_camera"][3][0] = 1; }), "last row"));
    CHECK(says(refusal([](json& c) { c["world_to_camera"][0][2] = 1.002; }), "orthonormal"));
    CHECK(says(refusal([](json& c) { c["world_to_camera"][0][2] = -1; }), "mirrored"));
    CHECK(refusal([](json& c) { c["world_to_camera"][0][2] = 1.0004; }).empty());

    CHECK(has(refusal([](json& c) { c.erase("name"); }), "camera 2"));
    CHECK(has(refusal([](json& c) { c["name"] = ""; }), "\"name\" is empty"));
    CHECK(has(refusal([](json& c) { c["name"] = "two\nlines"; }), "\"name\" is not one line of text"));
    CHECK(has(refusal([](json& c) { c["scene"] = "a\u2028b"; }), "\"scene\" is not one line of text"));
    CHECK(has(refusal([](json& c) { c["scene"] = 7; }), "\"scene\" is not a string"));
    CHECK(has(refusal([](json& c) { c["name"] = "front"; }), "same scene and name"));
    CHECK(has(refusal([](json& c) { c = 5; }), "camera 2"));
    CHECK(load({entry("desk", "a"), entry("desk", "b")}).size() == 2);
}

TEST_CASE("a lens with distortion is refused with what to run; coefficients of 0 are a pinhole's")
{
    CHECK(refusal([](json& c) { c["k1"] = 0.2; }).ends_with(
        " camera desk/left has a lens with distortion (its \"k1\" is not 0; a pinhole camera has none); undistort the pictures, for example "
        "with colmap image_undistorter, and name the cameras that it writes"));
    auto const is_refused = [](char const* key, json const& value) {
        return has(refusal([&](json& c) { c[key] = value; }), (std::string("distortion (its \"") + key + "\" is ").c_str());
    };
    for (char const* key : {"k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "distortion", "distortion_coefficients", "distortion_params",
                            "dist_coeffs", "camera_model"}) {
        CAPTURE(key);
        for (json const& value : {json(-1e-9), json(true), json("OPENCV"), json{0, 0, 0.1}, json{{"radial", {0, {0, 1}}}}})
            CHECK(is_refused(key, value));
        for (json const& value : {json(0), json(-0.0), json(nullptr), json(false), json::array(), json{0, 0, 0, 0}, json{{"radial", {0, 0.0}}},
                                  json("PINHOLE"), json("simple_pinhole")})
            CHECK(refusal([&](json& c) { c[key] = value; }).empty());
    }
    CHECK(has(refusal([](json& c) { c["camera_model"] = "OPENCV_FISHEYE"; }), "its \"camera_model\" is no pinhole;"));

    // Beside the list: of all cameras. In the form of a training, too.
    CHECK(has(refused_text(R"({"cameras": [], "k2": 0.1})"), "distortion (its \"k2\" is not 0;"));
    CHECK(refused_text(R"({"k2": 0.1, "cameras": [], "k2": 0})").empty()); // the last counts
    CHECK(has(refused_text(R"([{"img_name": "a", "p1": 1}])"), "camera a has a lens with distortion"));
}

TEST_CASE("a lens is read: coefficients, lists in OpenCV's order, fisheyes, and what there is not")
{
    using splat::LensKind;
    auto const kept = [](json const& change) {
        auto camera = entry("desk", "left");
        camera.update(change);
        return load_text(file_of({camera}), nullptr, scene::DistortedLens::kept).at(0).camera.lens;
    };
    auto const numbers = [](splat::Lens const& lens) {
        std::vector<float> all(std::begin(lens.k), std::end(lens.k));
        all.insert(all.end(), std::begin(lens.p), std::end(lens.p));
        return all;
    };
    auto const fault = [&](json const& change) { return error_of([&] { kept(change); }); };
    CHECK(kept(json::object()).kind == LensKind::pinhole);
    CHECK(kept({{"k1", 0}, {"distortion", {0, 0, 0}}, {"camera_model", "OPENCV"}}).kind == LensKind::pinhole);
    auto const plain = kept({{"k1", 0.25}, {"k2", -0.125}, {"k3", 0.5}, {"p1", 0.0625}, {"p2", -0.03125}});
    CHECK(plain.kind == LensKind::opencv);
    CHECK(numbers(plain) == std::vector{0.25f, -0.125f, 0.5f, 0.0f, 0.0f, 0.0f, 0.0625f, -0.03125f});
    auto const listed = kept({{"distortion_coefficients", {0.25, -0.125, 0.0625, -0.03125, 0.5, 0.1, 0.01, 0.001}}});
    CHECK(numbers(listed) == std::vector{0.25f, -0.125f, 0.5f, 0.1f, 0.01f, 0.001f, 0.0625f, -0.03125f});
    auto const fisheye = kept({{"camera_model", "OPENCV_FISHEYE"}, {"distortion", {0.01, 0.02, 0.03, 0.04}}});
    CHECK(fisheye.kind == LensKind::fisheye);
    CHECK(fisheye.k[3] == 0.04f);
    CHECK(kept({{"camera_model", "fisheye"}}).kind == LensKind::fisheye);
    CHECK(kept({{"camera_model", "FOV"}, {"k1", 0.9}}).k[0] == 0.9f);
    CHECK(kept({{"camera_model", "FULL_OPENCV"}, {"k4", 0.1}}).k[3] == 0.1f);
    CHECK(has(fault({{"k4", 0.1}}), "is not usable (the k4 of a perspective means two things;"));
    CHECK(has(fault({{"k1", true}}), "in a form that is not read"));
    CHECK(has(fault({{"k1", {0.1}}}), "in a form that is not read"));
    CHECK(has(fault({{"distortion", {{"radial", {0, 1}}}}}), "in a form that is not read"));
    CHECK(has(fault({{"camera_model", "THIN_PRISM_FISHEYE"}}), "no lens here is its camera model thin_prism_fisheye"));
    CHECK(has(fault({{"k1", 0.1}, {"distortion", {0.1}}}), "told twice"));
    CHECK(has(fault({{"camera_model", "fisheye"}, {"p1", 0.1}}), "coefficients that a fisheye has not"));
    CHECK(has(fault({{"distortion", {1, 2, 3, 4, 5, 6, 7, 8, 9}}}), "has more numbers than are read"));
    CHECK(kept({{"distortion", {0.1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}}}).k[0] == 0.1f);
    auto const studio = kept({{"camera_model", "OPENCV"}, {"distortion_params", {0.25, -0.125, 0.5, 0, 0.0625, -0.03125}}});
    CHECK(numbers(studio) == std::vector{0.25f, -0.125f, 0.5f, 0.0f, 0.0f, 0.0f, 0.0625f, -0.03125f});
    CHECK(has(fault({{"distortion_params", {0.1, 0, 0, 0.1, 0, 0}}}), "the k4 of a perspective means two things;"));
    CHECK(has(fault({{"distortion", {0.1}}, {"dist_coeffs", {0.1}}}), "told twice"));
    CHECK(kept({{"distortion", {0.1}}, {"dist_coeffs", {0, 0}}}).k[0] == 0.1f);
    CHECK(has(fault({{"camera_model", "FOV"}, {"k1", 0.9}, {"k2", 0.1}}), "has more than omega"));
    CHECK(has(fault({{"camera_model", "PINHOLE"}, {"k1", 0.1}}), "a pinhole's, and its coefficients are not 0"));
    CHECK(kept({{"k1", 0.1}, {"is_fisheye", true}}).kind == LensKind::fisheye);
    CHECK(has(fault({{"k1", -3}}), "its lens folds within the picture, at a slope of 0.333333"));
    CHECK(has(fault({{"p1", 0.5}}), "its lens folds within the picture, at a slope of 0."));
    CHECK(has(fault({{"camera_model", "FOV"}, {"k1", 2.8}, {"fx", 400}, {"fy", 400}}), "its lens does not see all of the picture: its nearest side is beyond a slope of 64"));
    CHECK(has(fault({{"k1", 1e9}}), "a coefficient of its lens is not a number within 1e6"));
    for (auto const& [key, value] : {std::pair{"is_fisheye", json(true)}, {"k2", json(0.1)}}) {
        json const file{{key, value}, {"cameras", json::array()}};
        CHECK(has(error_of([&] { load_text(file.dump(), nullptr, scene::DistortedLens::kept); }),
                  std::string("beside its list of cameras (its \"") + key + "\")"));
    }
}

TEST_CASE("keys that are not read are named, each with the number of cameras that have it")
{
    auto const notes_of = [](std::string const& text) {
        Lines notes;
        load_text(text, &notes, scene::DistortedLens::kept);
        return notes;
    };
    json a = entry("desk", "a"), b = entry("desk", "b");
    CHECK(notes_of(file_of({a, b})).empty());
    a["id"] = 7;
    a["k1"] = 0;
    CHECK(notes_of(file_of({a, b})).empty());
    a["exposure"] = {1, {{"fx", 2}}};
    a["rotation"] = 3;
    b["exposure"] = 2;
    CHECK(notes_of(file_of({a, b})) == Lines{"2 cameras have \"exposure\", which is not read", "1 camera has \"rotation\", which is not read"});
    CHECK(notes_of(replaced(file_of({b}), "\"exposure\"", "\"exposure\":1,\"exposure\"")) == Lines{"1 camera has \"exposure\", which is not read"});

    // A list of a training has other keys. The list that counts is the last.
    std::string const training = R"({"id":1,"img_name":"a","width":9,"height":9,"fx":9,"fy":9,"position":[0,0,0],"rotation":[[1,0,0],[0,1,0],[0,0,1]])";
    CHECK(notes_of("[" + training + "}]").empty());
    CHECK(notes_of("[" + training + R"(,"cx":3}])") == Lines{"1 camera has \"cx\", which is not read"});
    CHECK(notes_of("{\"cameras\":" + json::array({a}).dump() + ",\"cameras\":[]}").empty());

    // Eight keys, of 40 bytes at most; control characters are not printed.
    json many = entry("desk", "a");
    for (int i = 0; i < 8; ++i) many["key" + std::to_string(i)] = i;
    CHECK(notes_of(file_of({many})).size() == 8);
    many["one more"] = 0;
    CHECK(notes_of(file_of({many})).size() == 9);
    CHECK(notes_of(file_of({many})).back() == "cameras have more keys that are not read");
    json odd = entry("desk", "a");
    odd[std::string(100, 'x') + "1"] = odd["\x1b[2J"] = 0;
    CHECK(notes_of(file_of({odd})) == Lines{"1 camera has \"?[2J\", which is not read",
                                                              "1 camera has \"" + std::string(40, 'x') + "...\", which is not read"});
}

TEST_CASE("what is no camera file is refused")
{
    check_that_only_files_are_opened([](auto const& path) { scene::load_cameras(path); });
    CHECK(has(refused_text(""), "not JSON"));
    CHECK(has(refused_text("{\"cameras\": [\n1,"), "not JSON"));
    CHECK(has(refused_text("7"), "cameras[]"));
    CHECK(has(refused_text("{\"cameras\": 3}"), "cameras[]"));
    CHECK(has(refused_text("{\"camera_angle_x\": 0.7}"), "it has no list \"cameras\" or \"frames\""));
    CHECK(has(refused_text("[3]"), "camera 1 is not usable (it is not an object)"));
    CHECK(has(refused_text("{\"cameras\": [{\"fx\": 1e999}]}"), "number overflow"));
}

TEST_CASE("no byte of a camera file breaks the one line of its error")
{
    std::string every = "\"";
    for (int byte = 255; byte >= 0; --byte) every += static_cast<char>(byte);
    for (std::string const& text : {every, "[\"" + std::string(100000, 'x'), std::string("[\"\xe2\x80\xa8 \xff\n\x7f")}) {
        std::string const error = refused_text(text);
        CHECK(has(error, "not JSON"));
        CHECK(error.size() < 1000);
        for (char const c : error) CHECK((c >= ' ' && c <= '~'));
    }
    auto camera = entry("desk", "Z\u00fcrich \u6771\u4eac");
    camera["fx"] = 0;
    CHECK(has(error_of([&] { load({camera}); }), "desk/Z\u00fcrich \u6771\u4eac is not usable"));
}

TEST_CASE("neither depth nor length of JSON exhausts the stack or the memory")
{
    for (std::string const open : {"[", "{\"a\":"}) {
        std::string deep;
        for (int i = 0; i < 1000000; ++i) deep += open;
        CHECK(has(refused_text(deep), "nested deeper than 64 levels"));
    }
    // 24 MB of {} (6 MB in the short form): without a name, and more than a file may have.
    std::string many = "[{}";
    for (int i = 0; i < (fast() ? 1 << 21 : 1 << 23) - 1; ++i) many += ",{}";
    CHECK(has(refused_text(many + "]"), "has too many cameras (more than 1048576); split it"));
    std::string full = "[{}";
    for (int i = 1; i < (1 << 20); ++i) full += ",{}";
    CHECK(has(refused_text(full + "]"), "camera 1 is not usable (it has no \"img_name\")"));
    CHECK(has(refused_text(full + ",{}]"), "too many cameras"));
    CHECK(has(refused_text("{\"cameras\": " + full + ",{}]}"), "too many cameras"));
    // 64 levels are read; nested values that no camera needs are skipped.
    std::string const levels(62, '['), ends(62, ']');
    CHECK(refused_text("{\"cameras\":[],\"x\":[" + levels + ends + "]}").empty());
    CHECK(has(refused_text("{\"cameras\":[],\"x\":[[" + levels + ends + "]]}"), "nested deeper than 64 levels"));
    CHECK(has(refused_text("[" + std::string(std::size_t{1} << 24, ' ')), "column 16777218: the text ends, expected a value"));

    TempFile const file("{}", ".json");
    std::filesystem::resize_file(file.path(), (std::uintmax_t{256} << 20) + 1);
    CHECK(has(error_of([&] { scene::load_cameras(file.path()); }), "268435457 bytes, 268435456 are read"));
}

TEST_CASE("JSON is read as RFC 8259 has it, and its first fault is placed by line and column")
{
    auto const fault = [](std::string const& text) {
        std::istringstream stream(text);
        std::string const error = error_of([&] { scene::read_cameras_json(stream, "f"); });
        auto const begin = error.find("parse error at "), end = error.rfind("); ");
        return begin == error.npos ? error : error.substr(begin + 15, end - begin - 15);
    };
    CHECK(fault("") == "line 1, column 1: the text ends, expected a value");
    CHECK(fault("[\n  {\"a\" 1}]") == "line 2, column 8: expected : after a key");
    CHECK(fault("[1,]") == "line 1, column 4: expected a value");
    CHECK(fault("[1 2]") == "line 1, column 4: expected , or ] after a value");
    CHECK(fault("{\"a\":1,}") == "line 1, column 8: expected a key in quotes");
    CHECK(fault("{\"a\":1;") == "line 1, column 7: expected , or } after a value");
    CHECK(fault("[1]]") == "line 1, column 4: more text after the value");
    CHECK(fault(std::string("[]\0", 3)) == "line 1, column 3: more text after the value");
    CHECK(fault("[tru]") == "line 1, column 5: expected true");
    CHECK(fault("[01]") == "line 1, column 3: expected , or ] after a value");
    CHECK(fault("[1.]") == "line 1, column 4: expected a digit");
    CHECK(fault("[-]") == "line 1, column 3: expected a digit");
    CHECK(fault("[1e+]") == "line 1, column 5: expected a digit");
    CHECK(fault("[1e400]") == "line 1, column 7: number overflow in 1e400");
    CHECK(fault("[1" + std::string(400, '0') + "e-80]").starts_with("line 1, column 407: number overflow in 1000"));
    CHECK(fault("[\"a\nb\"]") == "line 1, column 4: a control character in a text");
    CHECK(fault("[\"\\x\"]") == "line 1, column 4: an escape that JSON does not have");
    CHECK(fault("[\"\\u12g4\"]") == "line 1, column 7: \\u takes four hexadecimal digits");
    for (char const* half : {"\\ud800", "\\udc00", "\\ud800\\u0041", "\\ud800x"})
        CHECK(has(fault("[\"" + std::string(half) + "\"]"), "half of a surrogate pair"));
    for (char const* bytes : {"\x80", "\xc1\xbf", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80", "\xf5", "\xc3"})
        CHECK(has(fault("[\"" + std::string(bytes) + "\"]"), "a byte that is no UTF-8"));
    CHECK(fault("\xef\xbb[]") == "line 1, column 3: a byte order mark is cut off");

    json camera = entry("desk", "left");
    std::string const before = file_of({camera});
    auto const with = [&](std::string const& from, std::string const& to) {
        std::istringstream stream(replaced(before, from, to));
        return scene::read_cameras_json(stream, "f").at(0);
    };
    CHECK(with("\"left\"", R"("\ud83d\ude00\u00e9\/")").name == "\xf0\x9f\x98\x80\u00e9/");
    CHECK(with("500.0", "0.5E+3").camera.fx == 500.0f);
    CHECK(with("500.0", "1,\"fx\":2,\"fx\":500").camera.fx == 500.0f); // the last one counts
    CHECK(with("320.5", "1e-400").camera.cx == 0.0f);
    std::istringstream twice(R"({"cameras":[{}],"cameras":[{}, 7],)" + before.substr(1));
    CHECK(scene::read_cameras_json(twice, "f").size() == 1); // and the last list
    std::istringstream none(before.substr(0, before.size() - 1) + R"(,"cameras":7})");
    CHECK(has(error_of([&] { scene::read_cameras_json(none, "f"); }), "it has no list \"cameras\""));
    CHECK(with("320.5", "0." + std::string(400, '0') + "1e20").camera.cx == 0.0f);
    CHECK(with("\"cx\"", "\"x\":[{\"cameras\":[{}]},[],null,true,false,\"\",-0],\"cx\"").camera.cx == 320.5f);
}

TEST_CASE("a byte order mark is skipped, and a stream serves as a file does")
{
    std::string const text = file_of({entry("desk", "front")});
    CHECK(load_text("\xef\xbb\xbf" + text).size() == 1);
    std::istringstream stream(text), broken("{");
    CHECK(scene::read_cameras_json(stream, "here").size() == 1);
    CHECK(error_of([&] { scene::read_cameras_json(broken, "here"); }).starts_with("here is not JSON"));
}

TEST_CASE("the cameras of a 3DGS training are read field by field")
{
    // A quarter turn about y: the camera looks along world -x.
    auto const cameras = load_training({training("img_1", 0)});
    REQUIRE(cameras.size() == 1);
    CHECK(cameras[0].scene.empty());
    CHECK(cameras[0].file.empty());
    CHECK(cameras[0].name == "img_1");
    CHECK(scene::label(cameras[0]) == "img_1");
    // The same camera in our own form has the same bits.
    json own = entry("", "img_1");
    own["cx"] = 320.0;
    own["cy"] = 240.0;
    own.erase("near");
    CHECK(splat::same_view(cameras[0].camera, load({own})[0].camera));

    CHECK(load_training({}).empty());
    // x right of the camera is world +z: `rotation` holds the camera's axes in its columns.
    auto const view = to_view(cameras[0].camera, {3, -2, 0});
    CHECK(view.x == 1.0);
    CHECK(view.z == 0.0);
}

TEST_CASE("pictures of a training that share a name are told apart by id")
{
    auto const cameras = load_training({training("a", 0), training("b", 1), training("a", 2)});
    REQUIRE(cameras.size() == 3);
    CHECK(cameras[0].name == "a#0");
    CHECK(cameras[1].name == "b");
    CHECK(cameras[2].name == "a#2");
    CHECK(has(error_of([] { load_training({training("a", 2), training("a", 2)}); }), "camera a#2 is not usable (another"));
    CHECK(has(error_of([] { load_training({training("a#0", 5), training("a", 0), training("a", 1)}); }), "camera a#0"));
    json without = training("a", 1);
    without.erase("id");
    CHECK(load_training({training("b", 0), without}).size() == 2);
    CHECK(has(error_of([&] { load_training({training("a", 0), without}); }), "it has no \"id\""));
    without["id"] = 1.5;
    CHECK(has(error_of([&] { load_training({training("a", 0), without}); }), "\"id\" is not a whole number"));
}

TEST_CASE("what is wrong with a camera of a training is said")
{
    auto const refusal_of = [](auto change) {
        json broken = training("left", 1);
        change(broken);
        return error_of([&] { load_training({training("front", 0), broken}); });
    };
    for (char const* key : {"width", "height", "fx", "fy", "position", "rotation"}) {
        CHECK(has(refusal_of([&](json& c) { c.erase(key); }), key));
        CHECK(has(refusal_of([&](json& c) { c[key] = "wide"; }), "camera left is not usable"));
    }
    CHECK(has(refusal_of([](json& c) { c.erase("img_name"); }), "camera 2 is not usable (it has no \"img_name\")"));
    CHECK(has(refusal_of([](json& c) { c["width"] = 1280.5; }), "1 to 65535"));
    CHECK(has(refusal_of([](json& c) { c["position"].push_back(1); }), "\"position\" is not 3 numbers"));
    CHECK(has(refusal_of([](json& c) { c["position"][0] = 1e38; }), "not a number within 1e37"));
    CHECK(has(refusal_of([](json& c) { c["rotation"][2].erase(1); }), "\"rotation\" is not a 3x3 matrix"));
    CHECK(has(refusal_of([](json& c) { c["rotation"][0][2] = -1.01; }), "orthonormal"));
    CHECK(has(refusal_of([](json& c) { c["rotation"][0][2] = 1; }), "mirrored"));
    CHECK(has(refusal_of([](json& c) { c["fx"] = 1e-30; }), "below a thousandth"));
}

TEST_CASE("a camera without a scene belongs to every map")
{
    auto cameras = load_training({training("a", 0), training("b", 1)});
    CHECK(scene::select_cameras(cameras, "", "sloth").size() == 2);
    CHECK(scene::select_cameras(cameras, "b", "sloth")[0].name == "b");
    CHECK(has(error_of([&] { scene::select_cameras(cameras, "c", "sloth"); }), "there are a, b"));

    json loose = entry("", "front");
    loose.erase("scene");
    auto const mixed = load({entry("desk", "front"), loose, entry("hall", "front")});
    CHECK(scene::label(mixed[0]) == "desk/front");
    CHECK(scene::label(mixed[1]) == "front");
    CHECK(scene::select_cameras(mixed, "", "desk").size() == 2);
    CHECK(scene::select_cameras(mixed, "", "attic").size() == 1);
    CHECK(scene::select_cameras(mixed, "front", "desk")[0].scene.empty()); // its label, in full

    for (int i = 0; i < 100; ++i) cameras.push_back({"", "", std::string("c").append(std::to_string(i)), {}});
    CHECK(has(error_of([&] { scene::select_cameras(cameras, "none", ""); }), "c16, c17 and 82 more"));
}

TEST_CASE("a selector finds its cameras or lists the choices")
{
    auto const all = load({entry("desk", "front"), entry("desk", "left"), entry("hall", "front")});
    auto const names = [&](std::string const& selector, std::string const& map) {
        std::string text;
        for (auto const& c : scene::select_cameras(all, selector, map)) text += c.scene + "/" + c.name + " ";
        return text;
    };
    CHECK(names("hall/front", "desk") == "hall/front ");
    CHECK(names("left", "hall") == "desk/left ");
    CHECK(names("", "desk") == "desk/front desk/left ");
    CHECK(names("", "hall.ply") == "hall/front ");

    CHECK(names("front", "desk") == "desk/front "); // of several, the one of the map's own scene
    std::string const ambiguous = error_of([&] { names("front", "sloth"); });
    CHECK(has(ambiguous, "ambiguous"));
    CHECK(has(ambiguous, "desk/front, hall/front"));
    CHECK(has(error_of([&] { names("desk/right", "desk"); }), "desk/front, desk/left, hall/front"));
    CHECK(has(error_of([&] { names("", "sloth"); }), "no camera belongs to map \"sloth\""));
    for (char const* const selector : {"", "front"}) // nothing could be chosen
        CHECK(error_of([&] { scene::select_cameras({}, selector, "desk"); }) ==
              "there is no camera to choose (the camera file has none); name a camera file with at least one");
}

TEST_CASE("a map's cameras are found by file where the scene has another name")
{
    json camera = entry("desk", "front");
    camera["file"] = "scan_7.ply";
    auto const all = load({camera});
    CHECK(scene::select_cameras(all, "", "scan_7").size() == 1);
    CHECK(scene::select_cameras(all, "", "scan_7.ply").size() == 1);
    CHECK(has(error_of([&] { scene::select_cameras(all, "", "scan"); }), "no camera"));
}

TEST_CASE("the cameras of the paper's maps are read, and belong to their maps")
{
    auto const path = data_file("cameras.json");
    if (path.empty()) return;
    auto const cameras = scene::load_cameras(path);
    CHECK(cameras.size() == 8);
    CHECK(scene::select_cameras(cameras, "", "sloth").size() == 4);
    CHECK(scene::select_cameras(cameras, "salad/benchmark", "sloth").size() == 1);
}

TEST_CASE("a camera that looks at a point has it on its axis")
{
    glm::dvec3 const eye{1.0, -2.0, 0.5}, target{-3.0, 1.0, 4.0};
    auto const lens = scene::lens_from_field_of_view(60.0, {1280, 720});
    auto const camera = scene::make_camera(scene::look_at(eye, target), lens);
    auto const view = to_view(camera, target);
    CHECK(std::fabs(view.x) < 1e-6);
    CHECK(std::fabs(view.y) < 1e-6);
    CHECK(view.z == doctest::Approx(glm::length(target - eye)));
    // A point further down in the world is lower in the picture; right is right.
    CHECK(to_pixel(camera, target + glm::dvec3{0, 0.1, 0}).y > 361.0);
    auto const pose = scene::look_at({0, 0, 0}, {0, 0, 1});
    CHECK(pose.rotation == glm::dmat3{1.0});
    CHECK(has(error_of([&] { scene::look_at(eye, eye); }), "own position"));
}

TEST_CASE("looking straight down is still a rotation")
{
    for (double const way : {1.0, -1.0}) {
        auto const r = scene::look_at({0, 0, 0}, {0, way, 0}).rotation;
        CHECK(glm::determinant(r) == doctest::Approx(1.0));
        CHECK((r * glm::dvec3{0, way, 0}).z == doctest::Approx(1.0));
    }
}

TEST_CASE("a field of view spans the picture from border to border")
{
    auto const lens = scene::lens_from_field_of_view(90.0, {1000, 400});
    CHECK(lens.fx == doctest::Approx(500.0));
    CHECK(lens.fy == lens.fx);
    CHECK(lens.cx == 500.0);
    CHECK(lens.cy == 200.0);
    CHECK(lens.near_depth == 0.2f);
    for (double const bad : {0.0, -1.0, 180.0, std::nan("")})
        CHECK(has(error_of([&] { scene::lens_from_field_of_view(bad, {10, 10}); }), "field of view"));
    CHECK(has(error_of([&] { scene::lens_from_field_of_view(60, {0, 10}); }), "0 x 10"));
    CHECK(has(error_of([&] { scene::lens_from_field_of_view(60, {10, 65536}); }), "65536"));
}

TEST_CASE("resizing keeps the horizontal field of view")
{
    auto camera = load({entry("desk", "front")})[0].camera;
    CHECK(splat::same_view(scene::resized(camera, 640, 480), camera));
    check_lens(scene::resized(camera, 320, 480), 320, 480, 250, 255, 160.25f, 239.5f, 0.05f);
    auto const tall = scene::resized(camera, 640, 960);
    CHECK(tall.fy == 510.0f);
    CHECK(tall.cy == 479.0f);
    CHECK(has(error_of([&] { scene::resized(camera, 640, 0); }), "640 x 0"));
}

TEST_CASE("a camera survives the way to a pose and back in every bit")
{
    splat::Camera const camera{
        {{0.1f, 0.2f, 0.3f}, {0.4f, 0.5f, 0.6f}, {0.7f, 0.8f, 0.9f}}, {1e-30f, -7.3f, 1e6f}, 501.1f, 502.2f, 3.3f, 4.4f, 0.01f, 11, 12};
    CHECK(splat::same_view(scene::make_camera(scene::pose_of(camera), scene::lens_of(camera)), camera));
}

TEST_CASE("quaternions turn as they should at any length")
{
    double const h = std::sqrt(0.5);
    for (double const length : {1.0, 1e-300, 1e300}) {
        // A quarter turn about z carries x to y.
        auto const turned = scene::rotation_matrix(h * length, 0, 0, h * length) * glm::dvec3{1, 0, 0};
        CHECK(std::fabs(turned.x) < 1e-15);
        CHECK(turned.y == doctest::Approx(1.0));
        // About x: y to z. About y: z to x.
        CHECK((scene::rotation_matrix(h * length, h * length, 0, 0) * glm::dvec3{0, 1, 0}).z == doctest::Approx(1.0));
        CHECK((scene::rotation_matrix(h * length, 0, h * length, 0) * glm::dvec3{0, 0, 1}).x == doctest::Approx(1.0));
    }
    CHECK(scene::rotation_matrix(0, 0, 0, 0) == glm::dmat3{1.0});
}
