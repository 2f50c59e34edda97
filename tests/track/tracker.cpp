#include "points.hpp"
#include <tilemesh/track/tracker.hpp>

using namespace track_test;

namespace {

/// Points around the room, so that each camera sees some, and a camera that walks: pose k, rounded as an evaluator sees it.
struct Walk {
    std::vector<glm::dvec3> points;
    Random random;
    double noise_px = 0.0;

    Walk()
    {
        for (int i = 0; i < 2000; ++i) points.push_back(6.0 * random.direction());
    }
    static splat::Camera camera(double k)
    {
        return scene::make_camera({track::rotation_by({0.02 * k, 0.05 * k, -0.01 * k}), {0.02 * k, 0.01 * k, 0.03 * k}}, lens());
    }
    /// What a camera at pose k sees, and nothing else.
    Points frame(double k)
    {
        Points out;
        for (auto const& p : points)
            if (in_view(camera(k), p).z > 1.0) out.see(camera(k), p, noise_px * random.normal(), noise_px * random.normal());
        return out;
    }
};

double error_degrees(scene::Pose const& pose, double k)
{
    return degrees_between(pose.rotation, scene::pose_of(Walk::camera(k)).rotation);
}

track::TrackerOptions options()
{
    track::TrackerOptions o;
    o.rows_per_pixel = 2.0;
    o.harmless_cost = 0.1; // rows in pixels
    o.most_cost = 1e9;
    return o;
}

} // namespace

TEST_CASE("a walk is tracked, and a prediction at constant velocity begins nearer than the last pose")
{
    for (double const noise : {0.0, 0.2}) {
        Walk walk;
        walk.noise_px = noise;
        track::Tracker tracker(lens(), scale_of_points, scene::pose_of(Walk::camera(0)), options());
        std::uint32_t evaluations = 0;
        for (int k = 0; k < 20; ++k) {
            auto const f = tracker.track(walk.frame(k));
            CHECK(f.verdict == track::Verdict::converged);
            CHECK(f.why == "");
            CHECK(error_degrees(f.pose, k) < (noise > 0.0 ? 0.1 : 1e-5));
            if (k > 1) CHECK(error_degrees(f.start, k) < 0.3);
            if (k > 1) evaluations += f.solution.evaluations;
            CHECK(f.mean_cost == f.solution.at.cost / f.solution.at.pixels);
        }
        CHECK(evaluations <= 18 * 8); // three levels, all ask at least twice
    }
    Walk walk;
    auto o = options();
    o.constant_velocity = false;
    track::Tracker tracker(lens(), scale_of_points, scene::pose_of(Walk::camera(0)), o);
    for (int k = 0; k < 5; ++k) {
        auto const f = tracker.track(walk.frame(k));
        CHECK(f.verdict == track::Verdict::converged);
        if (k > 0) CHECK(error_degrees(f.start, k) > 2.0); // a step of the walk
    }
}

TEST_CASE("frames that are missing are steps of their own")
{
    Walk walk;
    track::Tracker tracker(lens(), scale_of_points, scene::pose_of(Walk::camera(0)), options());
    for (int const k : {0, 1, 2}) tracker.track(walk.frame(k));
    auto const f = tracker.track(walk.frame(5), 3.0);
    CHECK(error_degrees(f.start, 5) < 0.5);
    CHECK(f.verdict == track::Verdict::converged);
}

TEST_CASE("a frame of another place, of nothing, of NaN or of little is lost; the next good one is found again")
{
    for (std::string const what : {"other place", "nothing", "not a number", "little"}) {
        Walk walk;
        track::Tracker tracker(lens(), scale_of_points, scene::pose_of(Walk::camera(0)), options());
        for (int k = 0; k < 3; ++k) REQUIRE(tracker.track(walk.frame(k)).verdict == track::Verdict::converged);
        Points bad = walk.frame(3);
        if (what == "other place")
            for (auto& p : bad.points) p.u = 640.0 * std::fabs(walk.random.number()), p.v = 480.0 * std::fabs(walk.random.number());
        if (what == "nothing") bad.points.clear();
        if (what == "little") bad.points.resize(bad.points.size() / 10);
        auto const f = tracker.track(altered(bad, [&](auto& e) {
            if (what == "not a number") e.g[2] = std::numeric_limits<double>::quiet_NaN();
        }));
        INFO(what, ": ", f.why);
        CHECK(f.verdict == track::Verdict::lost);
        CHECK(f.why == (what == "other place" ? "the picture does not match the map at any pose nearby" : what == "little" ? "most of the view has left the map" : "no pixel could be compared, or the sums are not finite"));
        CHECK(f.pose.position == f.start.position);
        CHECK(error_degrees(f.pose, 3) < 0.3); // the prediction
        // Two more frames are gone. Then the wide pyramid begins at the last tracked pose.
        auto points = walk.frame(6);
        std::vector<std::uint32_t> cells;
        auto const again = tracker.track(altered(points, [&](auto&, auto const&, track::Level const& level) {
            if (cells.empty() || cells.back() != level.cell) cells.push_back(level.cell);
        }));
        CHECK(again.verdict == track::Verdict::converged);
        CHECK(error_degrees(again.start, 2) < 1e-4);
        CHECK(error_degrees(again.pose, 6) < 1e-4);
        CHECK(cells == std::vector<std::uint32_t>{8, 4, 2, 1});
        // At rest after the gap, then at constant velocity.
        CHECK(error_degrees(tracker.track(walk.frame(7)).start, 6) < 1e-4);
        CHECK(error_degrees(tracker.track(walk.frame(8)).start, 8) < 0.3);
    }
}

TEST_CASE("a frame beyond a jump of the cost is found from another start, which counts; without one it is lost")
{
    // Past a plane between the prediction and the frame, another picture is seen, as where a splat comes through the near plane.
    for (double const truth : {3.3, 2.7})
        for (bool const found : {true, false}) {
            CAPTURE(truth);
            CAPTURE(found);
            Walk walk;
            walk.noise_px = 0.3;
            auto o = options();
            o.harmless_cost = 0.0;
            if (!found) o.second_look_ratio = 1e9;
            track::Tracker tracker(lens(), scale_of_points, scene::pose_of(Walk::camera(0)), o);
            for (double const k : {0.0, 1.0, 2.0}) REQUIRE(tracker.track(walk.frame(k)).verdict == track::Verdict::converged);
            auto here = walk.frame(truth);
            walk.noise_px = 3.0;
            auto beyond = walk.frame(3.0 - 3.0 * (truth - 3.0));
            double const plane = 0.03 * (0.4 * 3.0 + 0.6 * truth);
            std::uint32_t calls = 0;
            auto const jumps = [&](splat::Camera const& camera, track::Level const& level) {
                ++calls;
                bool const past = (scene::pose_of(camera).position.z > plane) == (truth > 3.0);
                return past ? here(camera, level) : beyond(camera, level);
            };
            auto const f = tracker.track(jumps);
            INFO(f.why, " ", error_degrees(f.pose, truth), " ", f.mean_cost, " ", calls);
            CHECK((f.verdict == track::Verdict::converged) == found);
            if (found) CHECK(error_degrees(f.pose, truth) < 0.1); // the wrong picture is a degree away
            CHECK(f.solution.evaluations == calls);
        }
}

TEST_CASE("a view that leaves a motion open is weak and says which; what is known is right, and tracking goes on")
{
    // A vertical line of points, then a cloud.
    Walk walk;
    track::Tracker tracker(lens(), scale_of_points, scene::pose_of(Walk::camera(0)), options());
    auto first = walk.frame(0);
    REQUIRE(tracker.track(first).verdict == track::Verdict::converged);
    auto const truth = scene::pose_of(Walk::camera(1));
    Points line;
    for (int i = -100; i <= 100; ++i) line.see(Walk::camera(1), truth.position + glm::transpose(truth.rotation) * glm::dvec3{0.0, 0.018 * i, scale_of_points});
    while (line.points.size() < first(Walk::camera(0), {}).pixels) line.points.push_back(line.points[line.points.size() % 201]);
    auto const f = tracker.track(line);
    CHECK(f.verdict == track::Verdict::weak);
    CHECK(f.why == "sideways and in yaw");
    CHECK(f.accuracy.is_weak());
    auto const next = tracker.track(walk.frame(2));
    INFO(next.why, " ", error_degrees(next.start, 2), " ", next.solution.evaluations);
    CHECK(next.verdict == track::Verdict::converged);
    CHECK(error_degrees(next.pose, 2) < 1e-4);
}

TEST_CASE("a frame that determines no motion is lost, also as the first frame")
{
    Random random;
    track::Tracker tracker(lens(), scale_of_points, scene::pose_of(Walk::camera(0)), options());
    auto rough = cloud(Walk::camera(0), 20, random, 100.0);
    auto const f = tracker.track(rough);
    CHECK(f.accuracy.weak_count() == 6);
    CHECK(f.verdict == track::Verdict::lost);
    CHECK(f.why == "the picture determines no motion");
    Walk walk;
    CHECK(tracker.track(walk.frame(0)).verdict == track::Verdict::converged);
}

TEST_CASE("a solver that does not converge loses the frame, unless its last steps were short")
{
    Walk walk;
    auto const at = scene::pose_of(Walk::camera(0));
    track::Tracker tracker(lens(), scale_of_points, track::moved(at, {{}, {0.05, 0.0, 0.0}}), options());
    auto points = walk.frame(0);
    auto const f = tracker.track(altered(points, [](auto& e) {
        for (double& g : e.g) g = -g;
    }));
    CHECK(f.verdict == track::Verdict::lost);
    CHECK(f.why == "no step lowers the cost");

    double cost = 1.0;
    for (double const step_px : {0.02, 5.0}) {
        track::Tracker endlessly(lens(), scale_of_points, at, options());
        auto const end = endlessly.track(altered(points, [&](auto& e) {
            e.cost = cost *= 0.9;
            std::fill_n(e.g, 8, 0.0);
            e.g[5] = step_px / 500.0 * e.h[5][5]; // about as much roll
        }));
        INFO(end.why, " ", end.solution.last_step_px);
        CHECK(end.solution.ending == track::Ending::spent);
        CHECK(end.verdict == (step_px < 1.0 ? track::Verdict::converged : track::Verdict::lost));
    }
}

TEST_CASE("forward mode takes wide steps where the start is unknown")
{
    Walk walk;
    auto o = options();
    o.method = track::Method::forward;
    track::Tracker tracker(lens(), scale_of_points, scene::pose_of(Walk::camera(0)), o);
    for (int k = 0; k < 2; ++k) {
        auto points = walk.frame(k);
        bool any_esm = false;
        tracker.track(altered(points, [&](auto&, auto const&, track::Level const& level) { any_esm |= level.jacobian == track::Jacobian::esm; }));
        CHECK(any_esm == (k == 0));
    }
}

TEST_CASE("exposure carries over to the next frame")
{
    track::Tracker tracker(lens(), scale_of_points, scene::pose_of(Walk::camera(0)), options());
    Walk walk;
    std::vector<double> asked;
    for (int k = 0; k < 3; ++k) {
        auto points = walk.frame(k);
        // The target is e^0.1k as bright; the two unknowns are apart from the pose.
        auto const ask = altered(points, [&](auto& e, auto const&, track::Level const& level) {
            asked.push_back(level.exposure.log_gain);
            e.unknowns = 8;
            double const gain[8] = {0, 0, 0, 0, 0, 0, 1, 0}, offset[8] = {0, 0, 0, 0, 0, 0, 0, 1};
            add_row(e, gain, level.exposure.log_gain - 0.1 * k, 1e9);
            add_row(e, offset, level.exposure.offset + 0.02 * k, 1e9);
        });
        asked.clear();
        auto const f = tracker.track(ask);
        CHECK(asked.front() == doctest::Approx(k == 0 ? 0.0 : 0.1 * (k - 1)).epsilon(1e-3));
        CHECK(f.exposure.log_gain == doctest::Approx(0.1 * k).epsilon(1e-3));
        CHECK(f.exposure.offset == doctest::Approx(-0.02 * k).epsilon(1e-3));
    }
}

TEST_CASE("time stamps scale the prediction; a stamp that comes again, goes back or is far away starts at the last pose")
{
    // Pose k at second 10 + 0.1 k, so a step of the walk is 0.1.
    auto const at = [](double k) { return 10.0 + 0.1 * k; };
    Walk walk;
    track::Tracker tracker(lens(), scale_of_points, scene::pose_of(Walk::camera(0)), options());
    auto const step = [&](double k, double seconds) {
        auto points = walk.frame(k);
        std::uint32_t coarsest = 0;
        auto const ask = altered(points, [&](auto&, auto const&, track::Level const& level) { coarsest = std::max(coarsest, level.cell); });
        auto const f = tracker.track_at(ask, seconds);
        CHECK(f.verdict == track::Verdict::converged);
        CHECK(error_degrees(f.pose, k) < 1e-4);
        return std::pair{f.start, coarsest};
    };
    CHECK(step(0, at(0)).second == 8);            // the first frame, whenever it is
    CHECK(error_degrees(step(1, at(1)).first, 0) < 1e-4); // no velocity yet
    CHECK(error_degrees(step(2, at(2)).first, 2) < 0.3);
    CHECK(error_degrees(step(4, at(4)).first, 4) < 0.5);     // one frame is missing
    CHECK(error_degrees(step(4.5, at(4.5)).first, 4.5) < 0.3); // half a step
    // The same stamp: from the last pose, and the velocity stays.
    CHECK(error_degrees(step(4.5, at(4.5)).first, 4.5) < 1e-4);
    CHECK(error_degrees(step(5.5, at(5.5)).first, 5.5) < 0.3);
    // No number is the last stamp.
    CHECK(error_degrees(step(5.5, std::numeric_limits<double>::quiet_NaN()).first, 5.5) < 1e-4);
    CHECK(error_degrees(step(6.5, at(6.5)).first, 6.5) < 0.3);
    // Back, and far ahead: from the last pose, on the wide pyramid, at rest afterwards.
    auto const back = step(5.5, at(2)), rest = step(6.5, at(3)), goes = step(7.5, at(4));
    CHECK(error_degrees(back.first, 6.5) < 1e-4);
    CHECK(back.second == 8);
    CHECK(error_degrees(rest.first, 5.5) < 1e-4);
    CHECK(rest.second == 4);
    CHECK(error_degrees(goes.first, 7.5) < 0.3);
    CHECK(step(8.5, at(12.1)).second == 8);
    CHECK(step(9.5, at(13.1)).second == 4);
    CHECK(step(10.5, at(20.9)).second == 4); // 7.8 steps ahead is near enough; the prediction is far off, and the pyramid finds the way
}

TEST_CASE("a black, a white or a constant picture is lost once, with and without exposure, also as the first frame")
{
    // Residuals of brightness: 400 pixels of a known picture, whose brightness changes along each of the six motions.
    Random random;
    std::vector<std::array<double, 8>> pixels(1000);
    for (auto& p : pixels) {
        for (double& slope : p) slope = 2.0 * random.number();
        p[6] = 0.5 + 0.4 * random.number();
        p[7] = 0.01 * random.number(); // noise
    }
    auto const truth = scene::pose_of(Walk::camera(0));
    for (bool const exposure : {true, false})
        for (int const bad_frame : {0, 2})
            for (double const brightness : {0.0, 1.0, 0.5}) {
                auto o = track::TrackerOptions{};
                o.rows_per_pixel = 3.0;
                track::Tracker tracker(lens(), scale_of_points, truth, o);
                for (int k = 0; k < 5; ++k) {
                    bool const bad = k == bad_frame;
                    auto const ask = [&](splat::Camera const& camera, track::Level const& level) {
                        auto const off = track::twist_between(truth, scene::pose_of(camera));
                        double const x[6] = {off.rho.x / scale_of_points, off.rho.y / scale_of_points, off.rho.z / scale_of_points, off.phi.x, off.phi.y, off.phi.z};
                        double const gain = std::exp(level.exposure.log_gain);
                        track::NormalEquations e;
                        e.unknowns = exposure ? 8 : 6;
                        for (auto const& p : pixels) {
                            double colour = p[6], j[8]{};
                            for (std::size_t i = 0; i < 6; ++i) colour += std::tanh(p[i] * x[i]) * 0.5, j[i] = gain * 0.5 * p[i] / std::pow(std::cosh(p[i] * x[i]), 2);
                            j[6] = gain * colour, j[7] = 1.0;
                            double const seen = bad ? brightness : p[6] + p[7];
                            ++e.pixels;
                            for (int channel = 0; channel < 3; ++channel) add_row(e, j, gain * colour + level.exposure.offset - seen, 0.1);
                        }
                        return e;
                    };
                    auto const f = tracker.track(ask);
                    INFO("exposure ", exposure, ", brightness ", brightness, ", frame ", k, ": ", f.why, "; gain ", std::exp(f.solution.exposure.log_gain), ", offset ", f.solution.exposure.offset, ", cost ", f.mean_cost);
                    // Without exposure, a grey first frame has small residuals: nothing tells it from a bad map.
                    if (bad && (exposure || k > 0 || brightness != 0.5)) CHECK(f.verdict == track::Verdict::lost);
                    if (!bad) {
                        CHECK(f.verdict == track::Verdict::converged);
                        CHECK(std::fabs(f.exposure.log_gain) < 0.05);
                        CHECK(degrees_between(f.pose.rotation, truth.rotation) < 0.5);
                    }
                }
            }
}

TEST_CASE("a view for which the evaluator has no room is lost with its reason, and tracking goes on")
{
    Walk walk;
    track::Tracker tracker(lens(), scale_of_points, scene::pose_of(Walk::camera(0)), options());
    for (int k = 0; k < 5; ++k) {
        auto points = walk.frame(k);
        auto const f = tracker.track(altered(points, [&](auto&) {
            if (k == 2) throw track::NoRoom("5 splats without room on a tile (each tile has 4 slots); choose other tiles");
        }));
        CHECK((f.verdict == track::Verdict::lost) == (k == 2));
        CHECK((f.why.find("5 splats without room") == 0) == (k == 2));
    }
}

TEST_CASE("a quarter of the pixels is compared with all of them, and a copy of a tracker tracks a lost frame again")
{
    Walk walk;
    track::Tracker tracker(lens(), scale_of_points, scene::pose_of(Walk::camera(0)), options());
    for (int k = 0; k < 8; ++k) {
        auto all = walk.frame(k), part = all;
        part.points.clear();
        for (std::size_t i = static_cast<std::size_t>(k) % 4; i < all.points.size(); i += 4) part.points.push_back(all.points[i]);
        if (k == 4) part.points.resize(part.points.size() / 4);
        auto const before = tracker;
        auto f = tracker.track_at(part, 0.1 * k, 0.25);
        INFO(k, ": ", part.points.size(), " of ", all.points.size(), " ", f.why, ", ", f.solution.at.pixels);
        CHECK((f.verdict == track::Verdict::lost) == (k == 4));
        if (k == 4) {
            tracker = before;
            f = tracker.track_at(all, 0.1 * k);
            CHECK(error_degrees(f.start, k) < 0.3); // at the old velocity
        }
        CHECK(f.verdict == track::Verdict::converged);
    }
}

TEST_CASE("a start that is no pose, a depth that is none and odd cells are refused")
{
    auto const refusal = [](double scale, scene::Pose const& pose, std::uint32_t cell) {
        auto o = options();
        o.coarsest = cell;
        return tests::error_of([&] { track::Tracker{lens(), scale, pose, o}; });
    };
    CHECK(refusal(1.0, {}, 4) == "");
    double const bad = std::numeric_limits<double>::quiet_NaN();
    for (double const scale : {0.0, -1.0, bad, std::numeric_limits<double>::infinity()}) CHECK(refusal(scale, {}, 4).find("cannot be tracked from here (") != std::string::npos);
    scene::Pose nowhere;
    nowhere.position.y = bad;
    CHECK(refusal(1.0, nowhere, 4) != "");
    for (std::uint32_t const cell : {0u, 3u, 128u}) CHECK(refusal(1.0, {}, cell).find("cells of " + std::to_string(cell)) == 0);
    auto without_time = options();
    without_time.readout = bad;
    CHECK(tests::error_of([&] { track::Tracker{lens(), 1.0, {}, without_time}; }).find("a camera that reads its rows in no time") == 0);
    auto rolling = lens();
    rolling.shutter.turn[1] = 0.1f;
    CHECK(tests::error_of([&] { track::Tracker{rolling, 1.0, {}, options()}; }).find("a camera with a rolling shutter (a tracker") == 0);
    CHECK(std::string(track::name_of(track::Verdict::weak)) == "weak");
}
