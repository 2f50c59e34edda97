// test: unoptimised test asan, needs data
#include "support.hpp"
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/trajectory.hpp>

using namespace scene_test;
using namespace tilemesh;

namespace {

scene::Trajectory load(std::string const& text)
{
    TempFile const file(text, ".tum");
    return scene::load_tum(file.path());
}
std::string refusal(std::string const& text)
{
    return error_of([&] { load(text); });
}

scene::Trajectory read_any(std::string const& text, std::optional<scene::TrajectoryFormat> format = {})
{
    std::istringstream stream(text);
    return scene::read_trajectory(stream, "here", scene::most_poses, format);
}
std::string refusal_of_any(std::string const& text)
{
    return error_of([&] { read_any(text); });
}

double distance(glm::dmat3 const& a, glm::dmat3 const& b)
{
    double most = 0.0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) most = std::fmax(most, std::fabs(a[i][j] - b[i][j]));
    return most;
}

} // namespace

TEST_CASE("a TUM line is camera to world")
{
    // A quarter turn about y, of length 2: the camera looks along world +x.
    auto const poses = load("# a comment\n\n  \t\n1.5 1 2 3 0 1.41421356237 0 1.41421356237\r\n   # another\n-2e3\t+0.5 0 0 0 0 0 -3");
    REQUIRE(poses.size() == 2);
    CHECK(poses[0].seconds == 1.5);
    CHECK(poses[0].pose.position == glm::dvec3{1, 2, 3});
    auto const ahead = poses[0].pose.rotation * glm::dvec3{1, 0, 0};
    CHECK(ahead.z == doctest::Approx(1.0));
    CHECK(std::fabs(ahead.x) < 1e-9);
    CHECK(poses[1].seconds == -2000.0);
    CHECK(poses[1].pose.position.x == 0.5);
    CHECK(distance(poses[1].pose.rotation, glm::dmat3{1.0}) < 1e-15);
}

TEST_CASE("a bad line is named by its number")
{
    std::string const good = "0 0 0 0 0 0 0 1\n";
    CHECK(load(good).size() == 1);
    CHECK(has(refusal("# c\n" + good + "0 0 0 0 0 0 1\n"), "line 3"));
    CHECK(has(refusal(good + "0 0 0 0 0 0 1\n"), "7 fields"));
    CHECK(has(refusal(good + "0 0 0 0 0 0 0 1 9\n"), "9 fields"));
    CHECK(has(refusal(good + "\n0 0 0 0 0 0 0 0\n"), "line 3"));
    CHECK(has(refusal("0 0 0 0 0 0 0 0\n"), "zero"));
    CHECK(has(refusal("0 0 x 0 0 0 0 1\n"), "field 3"));
    CHECK(has(refusal("0 0 0 1.2.3 0 0 0 1\n"), "field 4"));
    for (char const* bad : {"1e999", "1e38", "+", "nanx", "+-1", "--1", "0x1"}) CHECK(has(refusal(std::string("0 0 0 0 0 0 0 ") + bad), "field 8"));
}

TEST_CASE("comments, blank lines and line ends are where writers put them")
{
    auto const poses = load("\xef\xbb\xbf# head\r\n0 1 0 0 0 0 0 1 # tail, with commas, 1, 2\r\n\r\n#\n1 2 0 0 0 0 0 1#\n  # end");
    REQUIRE(poses.size() == 2);
    CHECK(poses[0].pose.position.x == 1.0);
    CHECK(poses[1].pose.position.x == 2.0);
    CHECK(load(std::string("\xef\xbb\xbf") + "0 0 0 0 0 0 0 1").size() == 1);
    CHECK(has(refusal("0 0 0 0 0 0 # 0 1\n"), "6 fields"));
}

TEST_CASE("files of other formats are refused by name")
{
    std::string const euroc = refusal("#timestamp, p_RS_R_x [m], p_RS_R_y [m]\n"
                                      "1403636580838555648,4.688,-1.786,0.783,0.534,-0.153,-0.827,-0.082,-0.027\n");
    CHECK(has(euroc, "line 2"));
    CHECK(has(euroc, "looks like the CSV of EuRoC); convert it: nanoseconds to seconds"));
    CHECK(has(refusal("0,5 0 0 0 0 0 0 1\n"), "it has a comma; TUM files are separated by blanks"));
    CHECK(has(refusal("1 0 0 0 0 1 0 0 0 0 1 0\n"), "12 fields where 8 are needed; this looks like the poses of KITTI"));
}

TEST_CASE("the first pose tells the form of a trajectory; one pose in the four forms is one pose")
{
    // A quarter turn about z: the camera's x is the world's y.
    auto const tum = read_any("# stamp\n1403636579.5 1 2 3 0 0 1 1\n1403636580 0 0 0 0 0 0 2\n");
    auto const euroc = read_any("#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m]\n1403636579500000000,1,2,3, 1 ,0,0,1,-0.2,x\r\n1403636580000000000,0,0,0,2,0,0,0\n");
    auto const kitti = read_any("0 -1 0 1 1 0 0 2 0 0 1 3\n\n1e0 0 0 0 0 +1 0 0 0 0 1 0 # end\n");
    auto const replica = read_any("0 -1 0 1 1 0 0 2 0 0 1 3 0 0 0 1\n1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n");
    CHECK(tum.format == scene::TrajectoryFormat::tum);
    CHECK(euroc.format == scene::TrajectoryFormat::euroc);
    CHECK(kitti.format == scene::TrajectoryFormat::kitti);
    CHECK(replica.format == scene::TrajectoryFormat::replica);
    for (auto const* each : {&tum, &euroc, &kitti, &replica}) {
        REQUIRE(each->size() == 2);
        auto const& pose = (*each)[0].pose;
        CHECK(pose.position == glm::dvec3{1, 2, 3});
        // World to camera: GLM's first column is the camera's view of the world's x, which is its -y.
        CHECK(distance(pose.rotation, {0, -1, 0, 1, 0, 0, 0, 0, 1}) <= 1e-15);
        CHECK((*each)[1].pose.rotation == glm::dmat3{1.0});
        bool const stamped = each == &tum || each == &euroc;
        CHECK(each->has_stamps() == stamped);
        CHECK((*each)[0].seconds == doctest::Approx(stamped ? 1403636579.5 : 0.0).epsilon(1e-15));
        CHECK((*each)[1].seconds == doctest::Approx(stamped ? 1403636580.0 : 1.0).epsilon(1e-15));
        CHECK(scene::trajectory_notes(*each).size() == (each == &euroc ? 2u : each == &tum ? 1u : 0u)); // quaternions of length 1.4 and 2
    }
    CHECK(has(scene::trajectory_notes(euroc)[0], "the poses of the IMU"));
    CHECK(tum.far_from_unit == 2);
    CHECK(euroc.far_from_unit == 2);
}

TEST_CASE("the unit of time stamps is found from their date or their step, or the header says it")
{
    auto const unit = [](std::vector<double> stamps) { return scene::detail::seconds_per_unit(std::move(stamps)); };
    CHECK(unit({}) == 1.0);
    CHECK(unit({0, 1, 2, 3}) == 1.0);
    CHECK(unit({0, 0.033, 0.066}) == 1.0);
    CHECK(unit({1305031102, 1305031103}) == 1.0);
    for (double const per_second : {1.0, 1e3, 1e6, 1e9})
        for (double const step : {0.001, 0.033, 1.0, 100.0}) {
            double const first = 1305031102.0 * per_second;
            CHECK(unit({first, first + step * per_second, first + 2 * step * per_second}) == 1.0 / per_second);
            CHECK(unit({first}) == 1.0 / per_second);
        }
    // The clock of a computer that was started twenty minutes ago.
    CHECK(unit({1.2e12, 1.2e12 + 33e6}) == 1e-9);
    CHECK(unit({1.2e9, 1.2e9 + 33e3}) == 1e-6);
    auto const stamps = [](std::string const& header) { return read_any(header + "5000,0,0,0,0,0,0,1\n5033,0,0,0,0,0,0,1\n")[1].seconds; };
    CHECK(stamps("#timestamp [ms],x,y,z,q_x,q_y,q_z,q_w\n") == doctest::Approx(5.033));
    CHECK(stamps("timestamp_us,x,y,z,q_x,q_y,q_z,q_w\n") == doctest::Approx(0.005033));
    CHECK(stamps("#timestamp [s],x,y,z,q_x,q_y,q_z,q_w\n") == 5033.0);
    auto const noted = read_any("1305031102175 0 0 0 0 0 0 1\n1305031102208 0 0 0 0 0 0 1\n");
    CHECK(noted[0].seconds == doctest::Approx(1305031102.175).epsilon(1e-15));
    CHECK(has(noted.reader_notes.at(0), ", in milliseconds"));
}

TEST_CASE("a lost frame of a trajectory is a comment line")
{
    scene::Pose const pose{glm::dmat3{1.0}, {1, 2, 3}};
    CHECK(scene::tum_text({{0.5, pose}, {1, pose}}, {true, false}) == "# timestamp tx ty tz qx qy qz qw\n# 0.5 lost\n1 1 2 3 0 0 0 1\n");
}

TEST_CASE("the fault of a pose of any form is named")
{
    std::string const kitti = "1 0 0 0 0 1 0 0 0 0 1 0\n", replica = kitti.substr(0, kitti.size() - 1) + " 0 0 0 1\n", euroc = "1,0,0,0,1,0,0,0\n";
    CHECK(refusal_of_any(kitti + kitti).empty());
    CHECK(has(refusal_of_any(kitti + replica), "here line 2 is not a pose (more than 12 fields where 12 are needed, as in the first line); write the 12 numbers"));
    CHECK(has(refusal_of_any(replica + kitti), "line 2 is not a pose (12 fields where 16 are needed, as in the first line); write the 16 numbers"));
    CHECK(has(refusal_of_any(euroc + kitti), "line 2 is not a pose (field 1 is not a number"));
    CHECK(has(refusal_of_any(euroc + "1,2,3,4\n"), "4 fields where 8 are needed, as in the first line); write timestamp,px,py,pz and the quaternion"));
    CHECK(has(refusal_of_any(euroc + "1,2,3 3,4,5,6,7,8\n"), "field 3 is not a number"));
    CHECK(has(refusal_of_any(euroc + "1,2,,4,5,6,7,8\n"), "field 3 is not a number"));
    CHECK(has(refusal_of_any(euroc + "1,2,3,4,0,-0,0,0\n"), "its quaternion is zero"));
    CHECK(has(refusal_of_any(kitti + "1 0 0 0 0 1 0 0 0 0 1e38 0\n"), "field 11 is not a number, or above 1e37"));
    CHECK(has(refusal_of_any(kitti + "1 0 0 0 0 1 0 0 0 0 1.01 0\n"), "its rotation is not orthonormal within 1e-3"));
    CHECK(has(refusal_of_any("1 0 0 0 0 1 0 0 0 0 -1 0\n"), "line 1 is not a pose (its rotation is mirrored"));
    CHECK(has(refusal_of_any("1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1\n"), "its last four numbers are not 0 0 0 1"));
    CHECK(has(refusal_of_any("1 2 3\n"), "3 fields where 8 are needed"));
    CHECK(has(refusal_of_any("# nothing\n"), "name a trajectory file"));
}

TEST_CASE("the memory of a trajectory is bounded")
{
    std::string const pose = "0 0 0 0 0 0 0 1\n";
    auto const of = [](std::string const& text, std::size_t most) {
        return error_of([&] {
            std::istringstream stream(text);
            scene::read_tum(stream, "here", most);
        });
    };
    CHECK(of(pose + pose + "#\n", 2).empty());
    CHECK(has(of(pose + pose + pose, 2), "here is too long (more than 2 poses)"));
    CHECK(of("#" + std::string(65535, 'x') + "\n" + pose, 2).empty());
    CHECK(of("#" + std::string(65535, 'x') + "\r\n" + pose, 2) == "here line 1 is too long (more than 65536 bytes); name a text file");
    CHECK(has(of(pose + std::string(65537, ' '), 2), "here line 2 is too long"));
    CHECK(has(of(std::string(1000000, '\0'), 2), "here line 1 is too long"));
    CHECK(of(pose + std::string(65536, ' '), 2).empty());
}

TEST_CASE("unusual stamps and quaternions are noted, and nothing else")
{
    auto const notes = [](std::vector<double> const& stamps, std::string const& quaternion = "0 0 0 1") {
        std::string text;
        for (double const stamp : stamps) text += std::to_string(stamp) + " 0 0 0 " + quaternion + "\n";
        auto const trajectory = load(text);
        REQUIRE(trajectory.size() == stamps.size());
        for (std::size_t i = 0; i < stamps.size(); ++i) CHECK(trajectory[i].seconds == stamps[i]);
        return scene::trajectory_notes(trajectory);
    };
    CHECK(notes({5}) == Lines{});
    CHECK(notes({0, 1, 2, 7}) == Lines{});
    CHECK(notes({0, 1, 2, 7.5, 8, 20, 21}) == Lines{"gaps above 5 times the median step of 1 s: 2, the longest lasts 12 s, before pose 6 at 20"});
    CHECK(notes({0, 1, 2, 1.5, 2.5, 2.25}) == Lines{"stamps that go back in time: 2, the first is pose 4 at 1.5 after 2"});
    CHECK(notes({1, 1, 2, 2, 2}) == Lines{"stamps that an earlier pose has too: 3"});
    CHECK(notes({0, 1, 0, 1}) == Lines{"stamps that go back in time: 1, the first is pose 3 at 0 after 1", "stamps that an earlier pose has too: 2"});
    CHECK(notes({0, 1}, "0 0 0 1.009") == Lines{});
    CHECK(notes({0, 1}, "0 0 0.6 -0.7") == Lines{"quaternions normalised whose length was off 1 by more than 0.01: 2"});
    CHECK(notes({3, 3, 1, 2, 30}, "0 0 0 2").size() == 4);
    CHECK(scene::trajectory_notes({}).empty());
}

TEST_CASE("the recorded trajectories have notes only on their gaps")
{
    for (char const* name : {"fr1_xyz", "sloth_orbit", "salad_orbit"}) {
        auto const path = data_file("trajectories/" + std::string(name) + ".tum");
        if (path.empty()) continue;
        auto const trajectory = scene::load_tum(path);
        for (auto const& note : scene::trajectory_notes(trajectory)) MESSAGE(name, ": ", note);
        CHECK(scene::trajectory_notes(trajectory).empty());
        CHECK(trajectory.far_from_unit == 0);
    }
}

TEST_CASE("a file without a pose, or no file, is refused")
{
    CHECK(has(refusal(""), "no pose"));
    CHECK(has(refusal("# only\n\n"), "no pose"));
    check_that_only_files_are_opened([](auto const& path) { scene::load_tum(path); });
}

TEST_CASE("the recorded orbits begin at the benchmark cameras")
{
    for (std::string const name : {"sloth", "salad"}) {
        auto const orbit = data_file("trajectories/" + name + "_orbit.tum");
        auto const file = data_file("cameras.json");
        if (orbit.empty() || file.empty()) continue;
        auto const poses = scene::load_tum(orbit);
        CHECK(poses.size() == 720);
        auto const named = scene::select_cameras(scene::load_cameras(file), name + "/benchmark", name);
        scene::Pose const expected = scene::pose_of(named.at(0).camera);
        CHECK(distance(poses[0].pose.rotation, expected.rotation) < 1e-4);
        CHECK(glm::length(poses[0].pose.position - expected.position) < 1e-4);
    }
}

namespace {

using Format = scene::TrajectoryFormat;

/// A camera that goes ahead and turns about an axis of its own; its quaternions are camera to world.
struct Walk {
    std::vector<double> stamps; ///< seconds
    std::vector<glm::dvec3> places;
    std::vector<std::array<double, 4>> quaternions; ///< x, y, z, w

    Walk(std::size_t steps, std::mt19937& random, bool turns = true)
    {
        std::uniform_real_distribution<double> number(-1.0, 1.0);
        glm::dmat3 to_world = glm::transpose(scene::look_at({0, 0, 0}, {number(random), number(random), 1.5}).rotation);
        glm::dvec3 place{number(random), number(random), number(random)};
        double const half = turns ? 0.15 : 0.0; // of the angle of a step
        glm::dvec3 const axis = glm::normalize(glm::dvec3{number(random), 1.0, number(random)}) * std::sin(half);
        auto const turn = scene::rotation_matrix(std::cos(half), axis.x, axis.y, axis.z);
        for (std::size_t i = 0; i < steps; ++i) {
            auto const q = scene::quaternion_of(to_world);
            stamps.push_back(1403636579.75 + 0.05 * static_cast<double>(i));
            places.push_back(place);
            quaternions.push_back({q[1], q[2], q[3], q[0]});
            place += to_world * glm::dvec3{0.02 * number(random), 0.01, 0.4};
            to_world = to_world * turn;
        }
    }

    /// `unit`: stamps a second; `digits` behind their point.
    std::string text(bool w_first, char const* separator, double unit, int digits, std::string const& header = "", std::string const& more = "") const
    {
        std::string out = header;
        for (std::size_t i = 0; i < stamps.size(); ++i) {
            auto const& q = quaternions[i];
            out += decimals(stamps[i] * unit, digits);
            for (int k = 0; k < 3; ++k) out += separator + number_text(places[i][k]);
            for (std::size_t k = 0; k < 4; ++k) out += separator + number_text(q[w_first ? (k + 3) % 4 : k]);
            out += more + "\n";
        }
        return out;
    }
};

void check_walk(scene::Trajectory const& read, Walk const& walk, Format format)
{
    CHECK(read.format == format);
    REQUIRE(read.size() == walk.stamps.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
        CHECK(read[i].seconds == doctest::Approx(walk.stamps[i]).epsilon(1e-12));
        CHECK(glm::length(read[i].pose.position - walk.places[i]) < 1e-12);
        auto const& q = walk.quaternions[i];
        CHECK(distance(read[i].pose.rotation, glm::transpose(scene::rotation_matrix(q[3], q[0], q[1], q[2]))) < 1e-12);
    }
}
} // namespace

TEST_CASE("the motion since the first pose is applied to the start, in the camera's own axes")
{
    // First it looks along world +x; then one step ahead and a quarter turn about its own y axis.
    auto const recorded = load("0 5 5 5 0 0.70710678118 0 0.70710678118\n1 6 5 5 0 1 0 0\n");
    scene::Pose const start = scene::look_at({1, 0, 0}, {1, 0, 9}); // looks along +z
    auto const moved = scene::relative_to_first(recorded, start);
    REQUIRE(moved.size() == 2);
    CHECK(moved[0].pose.rotation == start.rotation);
    CHECK(moved[0].pose.position == start.position);
    CHECK(moved[1].seconds == 1.0);
    CHECK(glm::length(moved[1].pose.position - glm::dvec3{1, 0, 1}) < 1e-9);
    CHECK((moved[1].pose.rotation * glm::dvec3{1, 0, 0}).z == doctest::Approx(1.0)); // looks along +x
    CHECK(scene::relative_to_first({}, start).empty());
    // Of any walk, camera to world: start o first^-1 o pose. From its own first pose a walk does not change.
    std::mt19937 random(4);
    auto const walk = read_any(Walk(40, random).text(false, " ", 1, 6));
    auto const& first = walk[0].pose;
    for (auto const& from : {scene::look_at({0, 0, 0}, {1, 0, 0}), first}) {
        auto const of_walk = scene::relative_to_first(walk, from);
        for (std::size_t i = 0; i < walk.size(); ++i) {
            auto const turned = glm::transpose(from.rotation) * first.rotation;
            CHECK(distance(of_walk[i].pose.rotation, walk[i].pose.rotation * glm::transpose(turned)) < 1e-12);
            CHECK(glm::length(of_walk[i].pose.position - from.position - turned * (walk[i].pose.position - first.position)) < 1e-12);
        }
    }
    CHECK(glm::length(walk.back().pose.position - first.position) > 1e-3);
}

TEST_CASE("a header tells the order of the quaternion and the unit of the stamps, whatever separates the numbers")
{
    std::mt19937 random(1);
    std::string const tum = "#timestamp,tx,ty,tz,qx,qy,qz,qw\n", bare = "timestamp tx ty tz q_x q_y q_z q_w\n",
                      euroc = "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n",
                      euroc_s = "time[s], px, py, pz, QW, QX, QY, QZ\r\n";
    for (int round = 0; round < 5; ++round)
        for (std::size_t steps : {1u, 2u, 30u})
            for (char const* separator : {",", ", ", " ", "\t"}) {
                Walk const walk(steps, random, round % 2 != 0);
                for (auto const& header : {tum, bare}) {
                    check_walk(read_any(walk.text(false, separator, 1, 6, header)), walk, Format::tum);
                    check_walk(read_any(walk.text(false, separator, 1e9, 0, header)), walk, Format::tum);
                }
                check_walk(read_any(walk.text(true, separator, 1e9, 0, euroc)), walk, Format::euroc);
                check_walk(read_any(walk.text(true, separator, 1, 6, euroc_s)), walk, Format::euroc);
            }
    auto const poses = read_any("#timestamp,tx,ty,tz,qx,qy,qz,qw\n1311868164.363400,0.05,0.02,-0.1,0.02,0.03,0.01,0.9993\n");
    CHECK(poses.format == Format::tum);
    CHECK(poses[0].pose.rotation[2][2] == doctest::Approx(0.9974).epsilon(1e-4)); // nearly no turn; w first it would be upside down
    CHECK(has(scene::trajectory_notes(poses).at(0), "read as timestamp, position, qx qy qz qw, as its header says, in seconds"));
    CHECK(has(refusal_of_any("# t qx qy qz qw tx ty tz\n0 0 0 0 1 1 2 3\n"), "its header has the quaternion from column 2, not 5"));
}

TEST_CASE("without a header, columns, stamps and the motion tell TUM from EuRoC; an undecided file is refused until its form is named")
{
    std::mt19937 random(2);
    for (int round = 0; round < 10; ++round) {
        Walk const walk(40, random), straight(40, random, false), brief(5, random);
        for (auto const* each : {&walk, &straight, &brief}) {
            check_walk(read_any(each->text(false, " ", 1, 6)), *each, Format::tum);
            check_walk(read_any(each->text(false, " ", 1e9, 6)), *each, Format::tum); // as ORB-SLAM3 writes it
            check_walk(read_any(each->text(true, ",", 1e9, 0)), *each, Format::euroc);
            check_walk(read_any(each->text(true, ",", 1, 6, "", ",0.1,0.2,0.3")), *each, Format::euroc);
            check_walk(read_any(each->text(true, " ", 1, 6, "", " 1 2 3 4 5 6 7 8 9")), *each, Format::euroc);
        }
        for (bool const w_first : {false, true}) {
            auto const form = w_first ? Format::euroc : Format::tum;
            std::string const seconds = walk.text(w_first, ",", 1, 6), blanks = walk.text(w_first, " ", 1e9, 0);
            check_walk(read_any(seconds), walk, form);
            CHECK(has(scene::trajectory_notes(read_any(seconds)).at(0), "because the camera moves steadily only so"));
            check_walk(read_any(blanks), walk, form);
            for (auto const* each : {&straight, &brief}) {
                CHECK(has(refusal_of_any(each->text(w_first, ",", 1, 6)), "name the form with --trajectory-format tum or euroc"));
                CHECK(has(refusal_of_any(each->text(w_first, " ", 1e9, 0)), "name the form with --trajectory-format tum or euroc"));
                check_walk(read_any(each->text(w_first, ",", 1, 6), form), *each, form);
                check_walk(read_any(each->text(w_first, " ", 1e9, 0), form), *each, form);
            }
        }
    }
    CHECK(scene::trajectory_format("tum") == Format::tum);
    CHECK(scene::trajectory_format("euroc") == Format::euroc);
    CHECK(scene::trajectory_format("kitti") == Format::kitti);
    CHECK(scene::trajectory_format("replica") == Format::replica);
    CHECK_FALSE(scene::trajectory_format("TUM"));
    CHECK(read_any("1,0,0,0,0,1,0,0,0,0,1,0\n", Format::kitti).size() == 1);
    CHECK(has(error_of([] { read_any("0 0 0 0 0 0 0 1\n", Format::replica); }), "8 fields where 16 are needed"));
}

TEST_CASE("rows with NaN or infinite numbers are left out and named; poses without stamps keep the number of their row")
{
    auto const tum = load("0 0 0 0 0 0 0 1\n# c\n1 nan nan nan nan nan nan nan\n2 1 0 0 0 0 0 1\n3 0 0 0 0 0 0 -inf\n");
    REQUIRE(tum.size() == 2);
    CHECK(tum[1].seconds == 2.0);
    CHECK(tum.left_out == 2);
    CHECK(has(scene::trajectory_notes(tum).at(0), "rows left out because a number is not finite: 2 (line 3, line 5)"));
    auto const kitti = read_any("nan 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 NaN 0 1 0 0 0 0 1 0\n1 0 0 7 0 1 0 0 0 0 1 0\n");
    REQUIRE(kitti.size() == 2);
    CHECK(kitti[0].seconds == 1.0);
    CHECK(kitti[1].seconds == 3.0);
    CHECK(kitti.left_out == 2);
    CHECK(has(refusal("0 0 0 0 0 0 0 nan\n"), "holds no pose"));
}
