// test: unoptimised test asan
#include "support.hpp"
#include <glm/mat3x3.hpp>
#include <nlohmann/json.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>

using namespace scene_test;
using namespace tilemesh;
using nlohmann::json;

namespace {

std::string const lenses = "# Camera list\n"
                           "1 PINHOLE 640 480 500 510 320.5 239.5\n"
                           "\n"
                           "7 SIMPLE_PINHOLE 1280 720 900 640 360\n";

std::vector<scene::NamedCamera> read(std::string const& cameras, std::string const& images)
{
    std::istringstream cameras_txt(cameras), images_txt(images);
    return scene::read_colmap(cameras_txt, images_txt, "c.txt", "i.txt", scene::DistortedLens::refused);
}
std::string refusal(std::string const& cameras, std::string const& images)
{
    return error_of([&] { read(cameras, images); });
}

} // namespace

TEST_CASE("a COLMAP model is read field by field")
{
    // A quarter turn about y, of length sqrt 2: the camera looks along world -x.
    auto const cameras = read(lenses, "# Image list with two lines of data per image:\n"
                                      "3 1 0 1 0 1 2 3 1 folder/a picture.png\r\n"
                                      "10.5 20.25 -1 30 4e1 77\n"
                                      "\n"
                                      "  4 +2 0 0 0 0 0 0 7 b.png  \n"
                                      "\n"
                                      "5 -1 0 0 0 0 0 0 7 c.png");
    REQUIRE(cameras.size() == 3);
    CHECK(cameras[0].scene.empty());
    CHECK(cameras[0].file.empty());
    CHECK(cameras[0].name == "folder/a picture.png");
    auto const& c = cameras[0].camera;
    check_lens(c, 640, 480, 500, 510, 320.5f, 239.5f);
    CHECK(c.rotation[0][2] == 1.0f);
    CHECK(c.rotation[2][0] == -1.0f);
    CHECK(c.position[0] == 3.0f);
    CHECK(c.position[1] == -2.0f);
    CHECK(c.position[2] == -1.0f);
    CHECK(cameras[1].name == "b.png");
    check_lens(cameras[1].camera, 1280, 720, 900, 900, 640, 360);
    CHECK(cameras[2].name == "c.png");
    CHECK(scene::label(cameras[2]) == "c.png");
    CHECK(scene::select_cameras(cameras, "", "any map").size() == 3);

    CHECK(read(lenses, "").empty());
    std::string const mark = "\xef\xbb\xbf";
    CHECK(read(mark + lenses, mark + "3 1 0 1 0 1 2 3 1 a").size() == 1);
}

TEST_CASE("one camera in the three forms is one camera")
{
    struct Example {
        double q[4], t[3];
        bool equal;
    };
    // Quarter and third turns have a rotation of integers: equal bits. For other turns, the files hold the centre or t, each rounded to
    // double, so the cameras differ at most in the last bit of a float.
    for (auto const& [q, t, equal] : {Example{{1, 0, 1, 0}, {1, 2, 3}, true}, Example{{1, 1, 1, 1}, {-0.25, 8, 1e5}, true},
                                      Example{{0.6, -0.3, 0.2, 0.71}, {0.1, -2.3, 3.7}, false},
                                      Example{{-0.01, 0.9, 0.4, -0.1}, {11.3, 0.7, -5.1}, false}}) {
        scene::Pose pose{scene::rotation_matrix(q[0], q[1], q[2], q[3]), {}};
        std::ostringstream image;
        image.precision(17);
        image << "1 " << q[0] << ' ' << q[1] << ' ' << q[2] << ' ' << q[3];
        json rotation = json::array(), matrix = json::array();
        glm::dvec3 centre{0.0};
        for (int row = 0; row < 3; ++row) {
            image << ' ' << t[row];
            matrix.push_back({pose.rotation[0][row], pose.rotation[1][row], pose.rotation[2][row], t[row]});
            rotation.push_back({pose.rotation[row][0], pose.rotation[row][1], pose.rotation[row][2]});
            for (int column = 0; column < 3; ++column) centre[column] -= pose.rotation[column][row] * t[row];
        }
        matrix.push_back({0, 0, 0, 1});
        json const size = {{"width", 640}, {"height", 480}, {"fx", 500.1}, {"fy", 510.2}};
        json own = size, training = size;
        own.update({{"name", "a"}, {"cx", 320}, {"cy", 240}, {"world_to_camera", matrix}});
        training.update({{"id", 0}, {"img_name", "a"}, {"position", {centre.x, centre.y, centre.z}}, {"rotation", rotation}});
        auto const colmap = read("1 PINHOLE 640 480 500.1 510.2 320 240\n", image.str() + " 1 a\n\n").at(0);
        for (auto const& form : {json{{"cameras", json::array({own})}}, json::array({training})}) {
            std::istringstream stream(form.dump());
            auto const other = scene::read_cameras_json(stream, "form").at(0);
            CHECK(scene::label(other) == scene::label(colmap));
            scene::NamedCamera same = other;
            auto const take = [may_differ = !equal](float& mine, float theirs) {
                CHECK((mine == theirs || (may_differ && std::nextafter(mine, theirs) == theirs)));
                mine = theirs;
            };
            for (int row = 0; row < 3; ++row) {
                for (int column = 0; column < 3; ++column) take(same.camera.rotation[row][column], colmap.camera.rotation[row][column]);
                take(same.camera.position[row], colmap.camera.position[row]);
            }
            CHECK(splat::same_view(same.camera, colmap.camera)); // all else: every bit
        }
    }
}

namespace {

/// A camera model of COLMAP as its documentation lists it: number of focal lengths, number of coefficients.
struct Model {
    std::string name;
    std::uint32_t id, focals, coefficients;
    bool fisheye;
};
std::vector<Model> const models{{"SIMPLE_PINHOLE", 0, 1, 0, false},      {"PINHOLE", 1, 2, 0, false},
                                {"SIMPLE_RADIAL", 2, 1, 1, false},       {"RADIAL", 3, 1, 2, false},
                                {"OPENCV", 4, 2, 4, false},              {"OPENCV_FISHEYE", 5, 2, 4, true},
                                {"FULL_OPENCV", 6, 2, 8, false},         {"FOV", 7, 2, 1, false},
                                {"SIMPLE_RADIAL_FISHEYE", 8, 1, 1, true}, {"RADIAL_FISHEYE", 9, 1, 2, true},
                                {"THIN_PRISM_FISHEYE", 10, 2, 8, true},  {"RAD_TAN_THIN_PRISM_FISHEYE", 11, 2, 12, true}};

/// The numbers of a line of cameras.txt after the size. `bent`: which coefficient is not 0; none if it is too large.
std::string parameters(Model const& model, std::uint32_t bent)
{
    std::string text = model.focals == 1 ? " 500 320 240" : " 500 510 320 240";
    for (std::uint32_t i = 0; i < model.coefficients; ++i) text += i == bent ? " -1e-9" : i % 2 == 0 ? " 0" : " -0.0";
    return text;
}

} // namespace

TEST_CASE("every model of COLMAP but the thin prisms is a lens")
{
    using splat::LensKind;
    auto const kept = [](std::string const& text) {
        std::istringstream cameras_txt("1 " + text + "\n"), images_txt("1 1 0 0 0 0 0 0 1 a\n");
        return scene::read_colmap(cameras_txt, images_txt).at(0).camera.lens;
    };
    auto const is = [&](std::string const& text, LensKind kind, std::array<float, 8> const& expected) {
        auto const lens = kept(text);
        bool same = lens.kind == kind;
        for (std::size_t i = 0; i < 8; ++i) same = same && (i < 6 ? lens.k[i] : lens.p[i - 6]) == expected[i];
        return same;
    };
    CHECK(is("PINHOLE 640 480 500 510 320 240", LensKind::pinhole, {}));
    CHECK(is("SIMPLE_RADIAL 640 480 500 320 240 0.25", LensKind::opencv, {0.25f}));
    CHECK(is("RADIAL 640 480 500 320 240 0.25 -0.125", LensKind::opencv, {0.25f, -0.125f}));
    CHECK(is("OPENCV 640 480 500 510 320 240 0.25 -0.125 0.03125 0.015625", LensKind::opencv, {0.25f, -0.125f, 0, 0, 0, 0, 0.03125f, 0.015625f}));
    CHECK(is("FULL_OPENCV 640 480 500 510 320 240 0.25 -0.125 0.0625 0.03125 0.5 0.125 0.25 0.375", LensKind::opencv,
             {0.25f, -0.125f, 0.5f, 0.125f, 0.25f, 0.375f, 0.0625f, 0.03125f}));
    CHECK(is("OPENCV_FISHEYE 640 480 500 510 320 240 0.25 0.125 0.0625 0.5", LensKind::fisheye, {0.25f, 0.125f, 0.0625f, 0.5f}));
    CHECK(is("SIMPLE_RADIAL_FISHEYE 640 480 500 320 240 0.25", LensKind::fisheye, {0.25f}));
    CHECK(is("RADIAL_FISHEYE 640 480 500 320 240 0 0", LensKind::fisheye, {}));
    CHECK(is("FOV 640 480 500 510 320 240 0.875", LensKind::fov, {0.875f}));
    CHECK(is("FOV 640 480 500 510 320 240 0", LensKind::pinhole, {}));
    CHECK(has(error_of([&] { kept("THIN_PRISM_FISHEYE 640 480 500 510 320 240 0 0 0 0 0 0 0 0.1"); }), "THIN_PRISM_FISHEYE"));
    CHECK(has(error_of([&] { kept("RAD_TAN_THIN_PRISM_FISHEYE 640 480 500 510 320 240 0 0 0 0 0 0 0 0 0 0 0 1"); }), "RAD_TAN_THIN_PRISM_FISHEYE"));
}

TEST_CASE("a lens whose coefficients are all 0 is a pinhole; another is refused by name, or ignored and counted")
{
    std::string const image = "1 1 0 0 0 0 0 0 9 a\n\n2 1 0 0 0 0 0 0 1 b\n\n3 1 0 0 0 0 0 0 9 c\n";
    for (auto const& model : models) {
        CAPTURE(model.name);
        auto const line = [&](std::uint32_t bent) { return lenses + "9 " + model.name + " 640 480" + parameters(model, bent) + "\n"; };
        auto const pinhole = lenses + (model.focals == 1 ? "9 SIMPLE_PINHOLE 640 480 500 320 240\n" : "9 PINHOLE 640 480 500 510 320 240\n");
        for (std::uint32_t bent = model.fisheye ? 0 : model.coefficients; bent <= model.coefficients; ++bent) {
            auto const text = refusal(line(bent), image);
            if (!model.fisheye && bent == model.coefficients) CHECK(text.empty());
            else {
                CHECK(has(text, "c.txt line 5 has a lens with distortion (" + model.name));
                CHECK(has(text, "run colmap image_undistorter"));
            }
        }
        for (std::uint32_t bent = 0; bent < model.coefficients; ++bent) {
            CHECK(has(refusal(line(bent), image), model.fisheye ? ", a fisheye projection;" : ", with a coefficient that is not 0;"));
            std::istringstream cameras_txt(line(bent)), images_txt(image);
            Lines notes;
            auto const cameras = scene::read_colmap(cameras_txt, images_txt, "c", "i", scene::DistortedLens::ignored, &notes);
            REQUIRE(cameras.size() == 3);
            CHECK(splat::same_view(cameras[0].camera, read(pinhole, image)[0].camera));
            CHECK(notes == Lines{"2 cameras have a lens with distortion, which is ignored: the picture is a pinhole's"});
        }
        if (!model.fisheye) CHECK(splat::same_view(read(line(99), image)[0].camera, read(pinhole, image)[0].camera));
        // One number less, and one more.
        auto const whole = line(99);
        CHECK(has(refusal(whole.substr(0, whole.find_last_of(' ')) + "\n", ""), model.name + " takes f"));
        CHECK(has(refusal(whole.substr(0, whole.size() - 1) + " 0\n", ""), ", finite numbers"));
    }
    CHECK(has(refusal("9 RADIAL 640 480 500 320 240 0\n", ""), "RADIAL takes f cx cy and 2 coefficients, finite numbers"));
    CHECK(has(refusal("9 FOV 640 480 500 500 320 240\n", ""), "FOV takes fx fy cx cy and a coefficient, finite numbers"));
    CHECK(has(refusal("9 EQUI\x01\xff 640 480 500\n", ""), "not known (\"EQUI??\""));
    CHECK(has(refusal("9\n", ""), "not known (\"\""));
}

TEST_CASE("the fault of a line of cameras.txt is named")
{
    auto const refused = [](std::string const& line) { return refusal("# c\n" + line + "\n", ""); };
    CHECK(has(refused("x PINHOLE 640 480 500 510 320 240"), "c.txt line 2 is no camera (CAMERA_ID is not a whole number)"));
    CHECK(has(refused("-1 PINHOLE 640 480 500 510 320 240"), "CAMERA_ID"));
    CHECK(has(refused("1.5 PINHOLE 640 480 500 510 320 240"), "CAMERA_ID"));
    for (char const* side : {"0", "65536", "1280.5", "-3", "4294967297", "x", "1e2"}) {
        CHECK(has(refused(std::string("1 PINHOLE ") + side + " 480 500 510 320 240"), "WIDTH is not a whole number from 1 to 65535"));
        CHECK(has(refused(std::string("1 PINHOLE 640 ") + side + " 500 510 320 240"), "HEIGHT is not a whole number"));
    }
    for (char const* tail : {"500 510 320", "500 510 320 240 1", "500 510 320 nan", "inf 510 320 240", "500 510 1e999 240", "500 x 320 240", ""})
        CHECK(has(refused(std::string("1 PINHOLE 640 480 ") + tail), "PINHOLE takes fx fy cx cy, finite numbers"));
    CHECK(has(refused("1 SIMPLE_PINHOLE 640 480 500 510 320 240"), "SIMPLE_PINHOLE takes f cx cy"));
    CHECK(has(refused("1 PINHOLE 640 480 0 510 320 240"), "fx is not positive"));
    CHECK(has(refused("1 PINHOLE 640 480 500 1e-30 320 240"), "fy is below a thousandth"));
    CHECK(has(refused("1 PINHOLE 640 480 1e30 510 320 240"), "fx is above 2^24 pixels"));
    CHECK(has(refused("1 PINHOLE 640 480 500 510 1e30 240"), "cx is more than 2^24 pixels away"));
    CHECK(has(refusal(lenses + "7 PINHOLE 640 480 500 510 320 240", ""), "another camera has CAMERA_ID 7"));
    CHECK(has(refusal(std::string(70000, ' '), ""), "c.txt line 1 is too long"));
}

TEST_CASE("the fault of a line of images.txt is named")
{
    auto const refused = [](std::string const& line) { return refusal(lenses, "1 1 0 0 0 0 0 0 1 a.png\n\n" + line + "\n\n"); };
    CHECK(refused("2 1 0 0 0 0 0 0 1 b.png").empty());
    CHECK(has(refused("x 1 0 0 0 0 0 0 1 b.png"), "i.txt line 3 is no image (IMAGE_ID is not a whole number)"));
    CHECK(has(refused("2 nan 0 0 0 0 0 0 1 b.png"), "QW is not a finite number"));
    CHECK(has(refused("2 1 0 0 0 0 1e38 0 1 b.png"), "TY is not a finite number"));
    CHECK(has(refused("2 1 0 0"), "QZ is not a finite number"));
    CHECK(has(refused("2 0 0 0 0 0 0 0 1 b.png"), "its quaternion is zero"));
    CHECK(has(refused("2 1 0 0 0 0 0 0 2 b.png"), "there is no camera 2 in c.txt"));
    CHECK(has(refused("2 1 0 0 0 0 0 0 b.png"), "CAMERA_ID is not a whole number"));
    CHECK(has(refused("2 1 0 0 0 0 0 0 1  "), "it has no NAME"));
    CHECK(has(refused("2 1 0 0 0 0 0 0 1 a.png"), "another image is called \"a.png\""));
    CHECK(has(refused("2 1 0 0 0 0 0 0 1 b\xff.png"), "NAME is not UTF-8 text"));
    CHECK(has(refused("2 1 0 0 0 0 0 0 1 b\x1b[1m"), "NAME is not UTF-8 text"));
    CHECK(refused("2 1 0 0 0 0 0 0 1 Z\u00fcrich.png").empty());
}

TEST_CASE("the line of 2-D points may have any length, and must be there")
{
    std::string const first = "1 1 0 0 0 0 0 0 1 a.png\n", second = "2 1 0 0 0 0 0 0 1 b.png\n";
    CHECK(has(refusal(lenses, first + second), "i.txt line 2 does not list the 2-D points of image \"a.png\""));
    CHECK(has(refusal(lenses, first + "2 1 0.5 0 0 0 0 4 1 001 002 003\n"), "does not list the 2-D points"));
    CHECK(has(refusal(lenses, first + "1 2\n"), "put an empty line after each image"));
    CHECK(read(lenses, first).size() == 1);
    // Near multiples of the 64 KiB that are read at a time, with words across the boundary.
    for (std::size_t const length : {65533u, 65534u, 65535u, 65536u, 65537u, 131072u, 200000u}) {
        std::string points;
        while (points.size() < length) points += "1.25 -2e1 -1 ";
        while (points.size() > length || points.back() != ' ') points.pop_back();
        CHECK(read(lenses, first + points.substr(0, points.rfind("1.25")) + "\n" + second).size() == 2);
        CHECK(read(lenses, first + points.substr(0, points.rfind("1.25"))).size() == 1);
    }
    CHECK(has(refusal(lenses, first + std::string(100000, '1') + "\n" + second), "does not list"));
    CHECK(read(lenses, first + std::string(100000, '1') + " 2 3\n" + second).size() == 2);
}

TEST_CASE("a model is named by its folder or by one of its files")
{
    TempFolder const folder;
    folder.write("cameras.txt", lenses);
    CHECK(has(error_of([&] { scene::load_cameras(folder.path()); }), "images.txt cannot be opened (no such file)"));
    folder.write("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n");
    for (auto const& path : {folder.path(), folder.path() / "cameras.txt", folder.path() / "images.txt"}) {
        CHECK(scene::load_cameras(path).size() == 1);
        CHECK(scene::load_colmap(path).size() == 1);
    }
    // The content counts, not the name.
    TempFolder const other;
    CHECK(scene::load_cameras(other.write("images.txt", " \n[]")).empty());
    CHECK(has(error_of([&] { scene::load_cameras(other.write("cameras.txt", "1 FOV 9 9 9 9 4 4 1"), nullptr, scene::DistortedLens::refused); }), "distortion (FOV"));
    CHECK(has(error_of([&] { scene::load_cameras(other.write("points.txt", "1 2 3")); }), "points.txt is not"));

    std::filesystem::remove(folder.path() / "images.txt");
    std::filesystem::create_directory(folder.path() / "images.txt");
    CHECK(has(error_of([&] { scene::load_cameras(folder.path()); }), "images.txt cannot be read (it is a directory)"));
}

namespace {

/// Writes the binary form of a model, from its public description.
class Bytes {
public:
    template <class T>
    Bytes& add(T value)
    {
        for (std::size_t i = 0; i < sizeof(T); ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
        return *this;
    }
    Bytes& number(double value)
    {
        std::uint64_t bits;
        std::memcpy(&bits, &value, sizeof bits);
        return add(bits);
    }
    Bytes& lens(std::uint32_t id, std::uint32_t model, std::uint64_t width, std::uint64_t height, std::vector<double> const& parameters)
    {
        add(id).add(model).add(width).add(height);
        for (double const value : parameters) number(value);
        return *this;
    }
    Bytes& image(std::uint32_t id, std::vector<double> const& pose, std::uint32_t lens_id, std::string const& name, std::uint64_t points = 0)
    {
        add(id);
        for (double const value : pose) number(value);
        add(lens_id);
        (text += name) += '\0';
        add(points);
        for (std::uint64_t i = 0; i < points; ++i) number(1.5).number(-2.5).add(~std::uint64_t{0});
        return *this;
    }
    std::string text;
};

std::vector<scene::NamedCamera> read_binary(std::string const& cameras, std::string const& images)
{
    std::istringstream cameras_bin(cameras), images_bin(images);
    return scene::read_colmap_binary(cameras_bin, images_bin, "c.bin", "i.bin", scene::DistortedLens::refused);
}
std::string binary_refusal(std::string const& cameras, std::string const& images)
{
    return error_of([&] { read_binary(cameras, images); });
}

/// The lenses and images of the first test case.
Bytes some_lenses()
{
    return Bytes().add(std::uint64_t{2}).lens(1, 1, 640, 480, {500, 510, 320.5, 239.5}).lens(7, 0, 1280, 720, {900, 640, 360});
}
Bytes some_images()
{
    return Bytes().add(std::uint64_t{3}).image(3, {1, 0, 1, 0, 1, 2, 3}, 1, "folder/a picture.png", 2).image(4, {2, 0, 0, 0, 0, 0, 0}, 7, "b.png")
        .image(5, {-1, 0, 0, 0, 0, 0, 0}, 7, "c.png", 50000);
}

} // namespace

TEST_CASE("a binary COLMAP model is the text model")
{
    auto const text = read(lenses, "3 1 0 1 0 1 2 3 1 folder/a picture.png\n\n4 2 0 0 0 0 0 0 7 b.png\n\n5 -1 0 0 0 0 0 0 7 c.png\n\n");
    auto const binary = read_binary(some_lenses().text, some_images().text);
    REQUIRE(binary.size() == 3);
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(binary[i].name == text[i].name);
        CHECK(splat::same_view(binary[i].camera, text[i].camera));
    }
    CHECK(read_binary(some_lenses().text, Bytes().add(std::uint64_t{0}).text).empty());

    // Every model, with coefficients of 0 and others.
    for (auto const& model : models) {
        CAPTURE(model.name);
        std::vector<double> values = model.focals == 1 ? std::vector<double>{500, 320, 240} : std::vector<double>{500, 510, 320, 240};
        values.resize(values.size() + model.coefficients, 0.0);
        auto const cameras = [&] { return Bytes().add(std::uint64_t{1}).lens(9, model.id, 640, 480, values).text; };
        auto const image = Bytes().add(std::uint64_t{1}).image(1, {1, 0, 0, 0, 0, 0, 0}, 9, "a").text;
        if (model.fisheye) CHECK(has(binary_refusal(cameras(), image), "c.bin camera 1 has a lens with distortion (" + model.name + ", a fisheye"));
        else
            CHECK(splat::same_view(read_binary(cameras(), image).at(0).camera,
                                   read("9 " + model.name + " 640 480" + parameters(model, 99) + "\n", "1 1 0 0 0 0 0 0 9 a\n").at(0).camera));
        if (model.coefficients == 0) continue;
        values.back() = 1e-9;
        CHECK(has(binary_refusal(cameras(), image), "has a lens with distortion (" + model.name));
        std::istringstream cameras_bin(cameras()), images_bin(image);
        Lines notes;
        CHECK(scene::read_colmap_binary(cameras_bin, images_bin, "c", "i", scene::DistortedLens::ignored, &notes).size() == 1);
        CHECK(notes.size() == 1);
    }
}

TEST_CASE("a binary COLMAP model that is cut short or lies is refused in one line")
{
    auto const cameras = some_lenses().text, images = some_images().text;
    for (std::size_t bytes = 0; bytes < cameras.size(); ++bytes) CHECK(has(binary_refusal(cameras.substr(0, bytes), images), "c.bin ends too early (in "));
    for (std::size_t bytes = 0; bytes < images.size(); bytes += bytes < 400 ? 1 : 4001)
        CHECK(has(binary_refusal(cameras, images.substr(0, bytes)), "i.bin ends too early (in "));
    CHECK(has(binary_refusal(cameras, images.substr(0, images.size() - 1)), "i.bin ends too early (in image 3 of 3); copy it again"));
    CHECK(has(binary_refusal(cameras + "x", images), "c.bin is damaged (1 bytes follow the last of its 2 cameras); export"));
    CHECK(has(binary_refusal(cameras, images + cameras), "i.bin is damaged ("));

    auto const with = [](std::string text, std::size_t at, std::uint64_t value) {
        for (std::size_t i = 0; i < 8; ++i) text[at + i] = static_cast<char>(value >> (8 * i) & 0xff);
        return text;
    };
    for (std::uint64_t const count : {~std::uint64_t{0}, std::uint64_t{1} << 63, (std::uint64_t{1} << 20) + 1})
        CHECK(has(binary_refusal(with(cameras, 0, count), images), "c.bin is not read (it says that it has " + std::to_string(count) + " cameras"));
    CHECK(has(binary_refusal(with(cameras, 0, 3), images), "ends too early (in camera 3 of 3)"));
    for (std::uint64_t const side : {std::uint64_t{0}, std::uint64_t{65536}, std::uint64_t{640} << 32}) {
        CHECK(has(binary_refusal(with(cameras, 16, side), images), "c.bin camera 1 is not usable (WIDTH is not from 1 to 65535)"));
        CHECK(has(binary_refusal(with(cameras, 24, side), images), "HEIGHT is not from 1 to 65535"));
    }
    // The count of 2-D points stands 21 bytes behind the first image's CAMERA_ID, which is at 8 + 4 + 56.
    std::size_t const points = 8 + 4 + 56 + 4 + 21;
    for (std::uint64_t const count : {~std::uint64_t{0}, ~std::uint64_t{0} / 24 + 1, std::uint64_t{1} << 61, std::uint64_t{60000}})
        CHECK(has(binary_refusal(cameras, with(images, points, count)), "i.bin ends too early (in image 1 of 3)"));

    auto const lens = [&](std::uint32_t model, double fx) {
        return binary_refusal(Bytes().add(std::uint64_t{1}).lens(1, model, 640, 480, {fx, 510, 320, 240}).text, images);
    };
    CHECK(has(lens(12, 500), "c.bin camera 1 has a camera model that is not known (MODEL_ID 12; 0 to 11 are)"));
    CHECK(has(lens(0xffffffffu, 500), "MODEL_ID 4294967295"));
    for (double const bad : {std::nan(""), 1e38, double{-INFINITY}}) CHECK(has(lens(1, bad), "c.bin camera 1 is not usable (a parameter is not a finite number)"));
    CHECK(has(lens(1, 0.0), "c.bin camera 1 is no camera (fx is not positive)"));
    CHECK(has(binary_refusal(Bytes().add(std::uint64_t{2}).lens(1, 0, 9, 9, {9, 4, 4}).lens(1, 0, 9, 9, {9, 4, 4}).text, images),
              "c.bin camera 2 is no camera (another camera has CAMERA_ID 1)"));
    auto const image = [&](std::vector<double> const& pose, std::uint32_t id, std::string const& name) {
        return binary_refusal(cameras, Bytes().add(std::uint64_t{2}).image(1, {1, 0, 0, 0, 0, 0, 0}, 1, "a").image(2, pose, id, name).text);
    };
    CHECK(image({1, 0, 0, 0, 0, 0, 0}, 1, "b").empty());
    CHECK(has(image({0, 0, 0, 0, 0, 0, 0}, 1, "b"), "i.bin image 2 is no image (its quaternion is zero)"));
    CHECK(has(image({1, 0, 0, 0, 0, INFINITY, 0}, 1, "b"), "i.bin image 2 is not usable (its pose is not of finite numbers)"));
    CHECK(has(image({1, 0, 0, 0, 0, 0, 0}, 2, "b"), "there is no camera 2 in c.bin"));
    CHECK(has(image({1, 0, 0, 0, 0, 0, 0}, 1, "a"), "another image is called \"a\""));
    CHECK(has(image({1, 0, 0, 0, 0, 0, 0}, 1, ""), "it has no NAME"));
    CHECK(has(image({1, 0, 0, 0, 0, 0, 0}, 1, "b\n"), "NAME is not UTF-8 text"));
    CHECK(image({1, 0, 0, 0, 0, 0, 0}, 1, std::string(65536, 'b')).empty());
    CHECK(has(image({1, 0, 0, 0, 0, 0, 0}, 1, std::string(65537, 'b')), "its name is too long"));
}

TEST_CASE("a folder with both forms stands for its text model; a file stands for its own form")
{
    TempFolder const folder;
    folder.write("images.bin", some_images().text);
    CHECK(has(error_of([&] { scene::load_cameras(folder.path()); }), "cameras.bin cannot be opened (no such file)"));
    folder.write("cameras.bin", some_lenses().text);
    for (auto const& path : {folder.path(), folder.path() / "cameras.bin", folder.path() / "images.bin"}) CHECK(scene::load_cameras(path).size() == 3);
    folder.write("cameras.txt", lenses);
    CHECK(scene::load_cameras(folder.path()).size() == 3);
    CHECK(has(error_of([&] { scene::load_cameras(folder.path() / "cameras.txt"); }), "images.txt cannot be opened"));
    folder.write("images.txt", "");
    CHECK(scene::load_cameras(folder.path()).empty());
    CHECK(scene::load_cameras(folder.path() / "cameras.txt").empty());
    CHECK(scene::load_cameras(folder.path() / "cameras.bin").size() == 3);
    Lines of_folder, of_file;
    scene::load_cameras(folder.path(), &of_folder), scene::load_cameras(folder.path() / "cameras.txt", &of_file);
    CHECK(of_folder == Lines{"the folder has a text model and a binary one: the text is read; name cameras.bin for the other"});
    CHECK(of_file.empty());
    // A binary model of 123 cameras begins with a bracket.
    auto many = Bytes().add(std::uint64_t{123});
    for (std::uint32_t i = 0; i < 123; ++i) many.lens(i, 0, 9, 9, {9, 4, 4});
    CHECK(many.text[0] == '{');
    folder.write("cameras.bin", many.text);
    CHECK(scene::load_cameras(folder.path() / "cameras.bin").size() == 3);
    TempFolder const none;
    CHECK(has(error_of([&] { scene::load_cameras(none.path()); }), "a directory without cameras.txt and images.txt, or cameras.bin and images.bin"));
}

TEST_CASE("masks of a project are found by their names; a folder whose files are no masks is noted")
{
    TempFolder const folder;
    folder.write("sparse/0/cameras.txt", lenses);
    folder.write("sparse/0/images.txt", "1 1 0 0 0 0 0 0 1 cam/a.JPG\n\n");
    auto const read = [&] {
        Lines notes;
        auto const cameras = scene::load_cameras(folder.path() / "sparse/0", &notes);
        return std::pair{std::filesystem::path(cameras.at(0).mask).filename().string(), notes};
    };
    CHECK(read() == std::pair{std::string(), Lines{}});
    folder.write("masks/a.JPG.png", ""); // of another folder
    auto const [none, notes] = read();
    CHECK(none.empty());
    REQUIRE(notes.size() == 1);
    CHECK(notes[0].starts_with("no file of the folder "));
    CHECK(notes[0].ends_with("/masks is the mask of a camera (a mask is NAME.png, as cam/a.JPG.png)"));
    for (auto const* name : {"a.PNG", "a.JPG.PNG", "a.png", "a.JPG.png"}) { // the later ones come first
        folder.write(std::string("masks/cam/") + name, "");
        CHECK(read() == std::pair{std::string(name), Lines{}});
    }
}

TEST_CASE("other models of a project are named")
{
    TempFolder const folder;
    auto const notes_of = [&](char const* path) {
        Lines notes;
        scene::load_cameras(folder.path() / path, &notes);
        return notes;
    };
    std::filesystem::create_directories(folder.path() / "project/sparse/2");
    for (auto const* model : {"project/sparse/0/", "project/sparse/a/"})
        for (auto const& [name, text] : {std::pair{"cameras.txt", std::string(lenses)}, std::pair{"images.txt", std::string()}}) folder.write(std::string(model) + name, text);
    CHECK(notes_of("project").size() == 1); // where they are; an empty folder and one without a number are no other models
    CHECK(notes_of("project/sparse/0").empty());
    folder.write("project/sparse/2/cameras.txt", lenses);
    auto const one = notes_of("project");
    REQUIRE(one.size() == 2);
    CHECK(one[1] == "the project has 1 other model beside this one (2): their cameras are not read");
    folder.write("project/sparse/1/cameras.bin", some_lenses().text);
    CHECK(notes_of("project/sparse/0") == Lines{"the project has 2 other models beside this one (1 and more): their cameras are not read"});
    CHECK(notes_of("project/sparse/a").empty());
}

TEST_CASE("images of one IMAGE_ID are all read, and noted")
{
    auto const notes_of = [](std::vector<int> const& ids) {
        std::string images;
        for (std::size_t i = 0; i < ids.size(); ++i) images += std::to_string(ids[i]) + " 1 0 0 0 0 0 0 1 p" + std::to_string(i) + ".png\n\n";
        std::istringstream lens_file("1 PINHOLE 64 48 50 50 32 24\n"), stream(images);
        Lines notes;
        CHECK(scene::read_colmap(lens_file, stream, "c.txt", "i.txt", scene::DistortedLens::refused, &notes).size() == ids.size());
        return notes;
    };
    CHECK(notes_of({0, 1, 2, 3}) == Lines{});
    for (auto const& [ids, count, first] : {std::tuple{std::vector{3, 19, 3}, "1 image has", "IMAGE_ID 3 of \"p2.png\""},
                                            {std::vector{7, 7, 7, 7}, "3 images have", "IMAGE_ID 7 of \"p1.png\""},
                                            {std::vector{0, 5, 2, 5, 0, 5, 8}, "3 images have", "IMAGE_ID 5 of \"p3.png\""}}) {
        auto const notes = notes_of(ids);
        REQUIRE(notes.size() == 1);
        CHECK(has(notes[0], first));
        CHECK(has(notes[0], std::string(count) + " an IMAGE_ID that an earlier image has"));
    }
}
