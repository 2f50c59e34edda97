// test: unoptimised test asan
#include "support.hpp"
#include <cmath>
#include <cstdint>
#include <cstring>
#include <doctest/doctest.h>
#include <filesystem>
#include <fstream>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <system_error>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <vector>

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
    return scene::read_colmap(cameras_txt, images_txt, "c.txt", "i.txt");
}
std::string refusal(std::string const& cameras, std::string const& images)
{
    return error_of([&] { read(cameras, images); });
}

/// The number of floats between two floats of the same sign.
std::uint32_t ulps_between(float a, float b)
{
    std::int32_t i, j;
    std::memcpy(&i, &a, sizeof i);
    std::memcpy(&j, &b, sizeof j);
    return static_cast<std::uint32_t>(i > j ? i - j : j - i);
}

/// A folder that removes itself.
class TempFolder {
public:
    TempFolder() : place_("", "_folder")
    {
        std::filesystem::remove(place_.path());
        std::filesystem::create_directory(place_.path());
    }
    ~TempFolder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(place_.path(), ignored);
    }
    std::filesystem::path const& path() const { return place_.path(); }
    std::filesystem::path write(std::string const& name, std::string const& bytes) const
    {
        std::ofstream(path() / name, std::ios::binary) << bytes;
        return path() / name;
    }

private:
    TempFile place_;
};

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
    CHECK(c.width == 640);
    CHECK(c.height == 480);
    CHECK(c.fx == 500.0f);
    CHECK(c.fy == 510.0f);
    CHECK(c.cx == 320.5f);
    CHECK(c.cy == 239.5f);
    CHECK(c.near_depth == 0.2f);
    CHECK(c.rotation[0][2] == 1.0f);
    CHECK(c.rotation[2][0] == -1.0f);
    CHECK(c.position[0] == 3.0f);
    CHECK(c.position[1] == -2.0f);
    CHECK(c.position[2] == -1.0f);
    CHECK(cameras[1].name == "b.png");
    CHECK(cameras[1].camera.fx == 900.0f);
    CHECK(cameras[1].camera.fy == 900.0f);
    CHECK(cameras[1].camera.cx == 640.0f);
    CHECK(cameras[2].name == "c.png");
    CHECK(scene::label(cameras[2]) == "c.png");
    CHECK(scene::select_cameras(cameras, "", "any map").size() == 3);

    CHECK(read(lenses, "").empty());
    CHECK(read("\xef\xbb\xbf" + lenses, "\xef\xbb\xbf"
                                        "3 1 0 1 0 1 2 3 1 a")
              .size() == 1);
}

TEST_CASE("one camera in the three forms is one camera")
{
    struct Example {
        double q[4], t[3];
        std::uint32_t most_ulps;
    };
    // Quarter and third turns have a rotation of integers: equal bits. For other turns, the files hold the centre or t, each rounded to
    // double, so the cameras differ at most in the last bit of a float.
    for (auto const& [q, t, most_ulps] :
         {Example{{1, 0, 1, 0}, {1, 2, 3}, 0}, Example{{1, 1, 1, 1}, {-0.25, 8, 1e5}, 0},
          Example{{0.6, -0.3, 0.2, 0.71}, {0.1, -2.3, 3.7}, 1}, Example{{-0.01, 0.9, 0.4, -0.1}, {11.3, 0.7, -5.1}, 1}}) {
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
        json const own = {{"cameras",
                           {{{"name", "a"},
                             {"width", 640},
                             {"height", 480},
                             {"fx", 500.1},
                             {"fy", 510.2},
                             {"cx", 320},
                             {"cy", 240},
                             {"world_to_camera", matrix}}}}};
        json const training = json::array({{{"id", 0},
                                            {"img_name", "a"},
                                            {"width", 640},
                                            {"height", 480},
                                            {"position", {centre.x, centre.y, centre.z}},
                                            {"rotation", rotation},
                                            {"fx", 500.1},
                                            {"fy", 510.2}}});
        auto const colmap = read("1 PINHOLE 640 480 500.1 510.2 320 240\n", image.str() + " 1 a\n\n").at(0);
        for (auto const& form : {own, training}) {
            std::istringstream stream(form.dump());
            auto const other = scene::read_cameras_json(stream, "form").at(0);
            CHECK(scene::label(other) == scene::label(colmap));
            scene::NamedCamera same = other;
            for (int row = 0; row < 3; ++row) {
                for (int column = 0; column < 3; ++column) {
                    float& r = same.camera.rotation[row][column];
                    CHECK(ulps_between(r, colmap.camera.rotation[row][column]) <= most_ulps);
                    r = colmap.camera.rotation[row][column];
                }
                CHECK(ulps_between(same.camera.position[row], colmap.camera.position[row]) <= most_ulps);
                same.camera.position[row] = colmap.camera.position[row];
            }
            CHECK(splat::same_view(same.camera, colmap.camera)); // all else: every bit
        }
    }
}

TEST_CASE("a lens that is not a pinhole is refused by name")
{
    for (std::string const model : {"SIMPLE_RADIAL", "RADIAL", "OPENCV", "OPENCV_FISHEYE", "FULL_OPENCV", "FOV",
                                    "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE", "THIN_PRISM_FISHEYE"}) {
        std::string const text = refusal(lenses + "9 " + model + " 640 480 500 320 240 0.1\n", "");
        CHECK(has(text, "c.txt line 5 has a lens with distortion (" + model));
        CHECK(has(text, "run colmap image_undistorter"));
    }
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
        CHECK(has(refused(std::string("1 PINHOLE ") + side + " 480 500 510 320 240"),
                  "WIDTH is not a whole number from 1 to 65535"));
        CHECK(has(refused(std::string("1 PINHOLE 640 ") + side + " 500 510 320 240"), "HEIGHT is not a whole number"));
    }
    for (char const* tail : {"500 510 320", "500 510 320 240 1", "500 510 320 nan", "inf 510 320 240", "500 510 1e999 240",
                             "500 x 320 240", ""})
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
    auto const refused = [](std::string const& line) {
        return refusal(lenses, "1 1 0 0 0 0 0 0 1 a.png\n\n" + line + "\n\n");
    };
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
    CHECK(has(error_of([&] { scene::load_cameras(other.write("cameras.txt", "1 FOV 1 1 1 1")); }), "distortion (FOV"));
    CHECK(has(error_of([&] { scene::load_cameras(other.write("points.txt", "1 2 3")); }), "points.txt is not"));

    std::filesystem::remove(folder.path() / "images.txt");
    std::filesystem::create_directory(folder.path() / "images.txt");
    CHECK(has(error_of([&] { scene::load_cameras(folder.path()); }), "images.txt cannot be read (it is a directory)"));
}

TEST_CASE("a binary model is refused with the command that converts it")
{
    TempFolder const folder;
    std::string const bytes("\1\0\0\0\0\0\0\0", 8);
    folder.write("images.bin", bytes);
    for (auto const& path : {folder.path(), folder.write("cameras.bin", bytes), folder.path() / "images.bin"})
        CHECK(has(error_of([&] { scene::load_cameras(path); }), "run colmap model_converter --output_type TXT"));
    // Next to a text model they do not matter.
    folder.write("cameras.txt", lenses);
    CHECK(has(error_of([&] { scene::load_cameras(folder.path()); }), "binary COLMAP model"));
    folder.write("images.txt", "");
    CHECK(scene::load_cameras(folder.path()).empty());
}
