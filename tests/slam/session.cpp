// test: cost 4
#include "support.hpp"
#include <glm/geometric.hpp>
#include <tilemesh/scene/ply_output.hpp>
#include <tilemesh/slam/session.hpp>

using namespace tilemesh;
using slam::Frame, slam::Mapper, slam::Session, slam::SessionOptions;
using track::Verdict;
namespace on_slam = support::slam;

namespace {
Frame frame_at(Mapper& truth, std::size_t k)
{
    auto seen = on_slam::seen_from(truth, on_slam::pose(k));
    return {static_cast<double>(k), std::move(seen.colour), std::move(seen.depth)};
}
SessionOptions short_steps()
{
    SessionOptions o;
    o.mapper.first_steps = 40;
    o.mapper.steps = 16;
    return o;
}
Session begun(SessionOptions const& o, scene::Map map = {})
{
    return {std::move(map), on_slam::lens(), 2.3, on_slam::pose(0), o};
}
/// How far a pose of the session is off, in pixels at the wall. A shift and a turn nearly cancel on a wall, so this is no small share of a
/// pixel.
double pixels_off(scene::Pose const& estimated, std::size_t k)
{
    return glm::length(estimated.position - on_slam::pose(k).position) * on_slam::lens().fx / 2.3;
}
struct Run {
    std::vector<slam::FrameResult> frames;
    std::string ply;
};
Run run(SessionOptions const& o, std::size_t count)
{
    Mapper truth(on_slam::wall(), 2);
    auto session = begun(o);
    Run out;
    for (std::size_t k = 0; k < count; ++k) out.frames.push_back(session.add(frame_at(truth, k)));
    CHECK(session.frames() == count);
    out.ply = scene::ply_bytes(session.map());
    return out;
}
} // namespace

TEST_CASE("session: from an empty map, twelve frames are tracked, and map and poses have equal bits over threads and tiles")
{
    auto o = short_steps();
    auto const first = run(o, 12);
    std::size_t keyframes = 0;
    double worst = 0;
    for (std::size_t k = 0; k < 12; ++k) {
        auto const& f = first.frames[k];
        CHECK(f.tracked.verdict != Verdict::lost);
        worst = std::fmax(worst, pixels_off(f.tracked.pose, k));
        keyframes += f.keyframe.has_value();
        if (k == 0) CHECK(f.keyframe->inserted == 1440);
    }
    MESSAGE("off by at most " << worst << " pixels, " << keyframes << " keyframes");
    CHECK(first.frames[0].tracked.pose.position == on_slam::pose(0).position);
    CHECK(worst < 2);
    CHECK(keyframes >= 3);
    CHECK(keyframes < 12);

    o.mapper.threads = 3;
    o.mapper.tile = {16, 10};
    o.tile = {16, 8};
    auto const other = run(o, 12);
    CHECK(other.ply == first.ply);
    for (std::size_t k = 0; k < 12; ++k)
        CHECK(std::memcmp(&other.frames[k].tracked.pose, &first.frames[k].tracked.pose, sizeof(scene::Pose)) == 0);
}

TEST_CASE("session: keyframes come by count, and where a picture is open")
{
    Mapper truth(on_slam::wall(), 2);
    auto o = short_steps();
    o.keyframe_every = 3;
    o.most_open = 1;
    auto by_count = begun(o);
    for (std::size_t k = 0; k < 7; ++k) CHECK(by_count.add(frame_at(truth, k)).keyframe.has_value() == (k % 3 == 0));
    CHECK(by_count.mapper().keyframes() == 3);

    o.keyframe_every = 1000;
    o.most_open = 0.08;
    auto by_share = begun(o);
    bool came = false;
    for (std::size_t k = 0; k < 12; ++k) {
        auto const f = by_share.add(frame_at(truth, k));
        CHECK(f.keyframe.has_value() == (k == 0 || f.open_share > 0.08));
        came = came || (k > 0 && f.keyframe);
    }
    CHECK(came);
    o.most_open = 1;
    auto never = begun(o);
    for (std::size_t k = 0; k < 8; ++k) CHECK(never.add(frame_at(truth, k)).keyframe.has_value() == (k == 0));
}

TEST_CASE("session: a lost frame is never a keyframe, and the next good one is tracked")
{
    Mapper truth(on_slam::wall(), 2);
    auto o = short_steps();
    o.keyframe_every = 2;
    auto session = begun(o);
    for (std::size_t k = 0; k < 4; ++k) session.add(frame_at(truth, k));
    auto const before = scene::ply_bytes(session.map());
    auto const keyframes = session.mapper().keyframes();
    auto broken = frame_at(truth, 4);
    for (float& v : broken.colour.rgb) v = 1 - v; // no pose explains it
    for (float& d : broken.depth.values) d = d > 0 ? 0.3f : 0.0f;
    auto const lost = session.add(std::move(broken));
    CHECK(lost.tracked.verdict == Verdict::lost);
    CHECK_FALSE(lost.tracked.why.empty());
    CHECK_FALSE(lost.keyframe);
    CHECK(session.mapper().keyframes() == keyframes);
    CHECK(scene::ply_bytes(session.map()) == before);
    auto const next = session.add(frame_at(truth, 5));
    CHECK(next.tracked.verdict != Verdict::lost);
    CHECK(next.keyframe);
    CHECK(pixels_off(next.tracked.pose, 5) < 2);
}

TEST_CASE("session: the second frame is judged by the first, although the first was not tracked")
{
    Mapper truth(on_slam::wall(), 2);
    auto o = short_steps();
    o.keyframe_every = 1;
    o.with_exposure = true;
    auto session = begun(o);
    session.add(frame_at(truth, 0));
    auto dark = frame_at(truth, 1); // of another scene: one bright column
    for (std::uint32_t y = 0; y < 60; ++y)
        for (std::uint32_t x = 0; x < 96; ++x)
            for (int c = 0; c < 3; ++c) dark.colour.pixel(x, y)[c] = x / 8 == 7 ? 1.0f : 0.0f;
    auto const second = session.add(std::move(dark));
    CHECK(second.tracked.verdict == Verdict::lost);
    CHECK_FALSE(second.keyframe);
    CHECK(session.add(frame_at(truth, 2)).tracked.verdict != Verdict::lost);

    auto other = begun(o);
    other.add(frame_at(truth, 0));
    auto few = frame_at(truth, 1); // a third of the pixels counts: less than half of the first frame's
    for (std::uint32_t y = 0; y < 60; ++y)
        for (std::uint32_t x = 0; x < 96; ++x)
            if (x % 24 >= 8) few.colour.pixel(x, y)[0] = std::numeric_limits<float>::quiet_NaN();
    auto const masked = other.add(std::move(few));
    CHECK(masked.tracked.verdict == Verdict::lost);
    CHECK(masked.tracked.why == "most of the view has left the map");
}

TEST_CASE("session: the tracker follows the map as it is after a keyframe")
{
    Mapper truth(on_slam::wall(), 2);
    auto o = short_steps();
    o.keyframe_every = 1;
    auto session = begun(o);
    auto half = frame_at(truth, 0);
    for (std::uint32_t y = 0; y < 60; ++y)
        for (std::uint32_t x = 48; x < 96; ++x) half.depth.at(x, y) = 0; // no Gaussian in the right half
    CHECK(session.add(std::move(half)).keyframe->inserted == 720);
    auto const second = session.add(frame_at(truth, 0));
    CHECK(second.keyframe->inserted > 600);
    auto const third = session.add(frame_at(truth, 0));
    MESSAGE("pixels that count: " << second.tracked.solution.at.pixels << ", " << third.tracked.solution.at.pixels);
    CHECK(second.tracked.solution.at.pixels < 3500); // only what the map covers counts
    CHECK(third.tracked.solution.at.pixels > 5000);
}

TEST_CASE("session: a map to start from is tracked from the first frame on")
{
    Mapper truth(on_slam::wall(), 2);
    SessionOptions o = short_steps();
    auto session = begun(o, on_slam::wall());
    auto const first = session.add(frame_at(truth, 1)); // not where the session begins
    CHECK(first.tracked.verdict == Verdict::converged);
    CHECK(pixels_off(first.tracked.pose, 1) < 0.02);
    REQUIRE(first.keyframe);
    CHECK(first.keyframe->inserted < 20);
}

TEST_CASE("session: with an exposure of its own for each picture, the map keeps the first one's")
{
    Mapper truth(on_slam::wall(), 2);
    SessionOptions o = short_steps();
    o.with_exposure = true;
    o.keyframe_every = 2;
    auto session = begun(o);
    for (std::size_t k = 0; k < 7; ++k) {
        auto frame = frame_at(truth, k);
        for (float& v : frame.colour.rgb) v = k > 0 ? 0.8f * v + 0.05f : v;
        auto const f = session.add(std::move(frame));
        CHECK(f.tracked.verdict != Verdict::lost);
        CHECK(pixels_off(f.tracked.pose, k) < 2);
        if (k > 0) CHECK(std::exp(f.tracked.exposure.log_gain) == doctest::Approx(0.8).epsilon(0.03));
    }
    // A view between keyframes agrees with the picture as the first frame's exposure has it.
    auto const seen = on_slam::seen_from(truth, on_slam::pose(5));
    auto const fit = session.mapper().measure(scene::make_camera(on_slam::pose(5), on_slam::lens()), mapping::make_target(seen.colour));
    MESSAGE("PSNR at the first exposure: " << fit.psnr_db());
    CHECK(fit.psnr_db() > 22);
}

TEST_CASE("session: a session that was saved goes on with the same bits, between keyframes and after a lost frame")
{
    Mapper truth(on_slam::wall(), 2);
    auto const frame = [&](std::size_t k) {
        auto f = frame_at(truth, k);
        for (float& v : f.colour.rgb) v = k == 4 ? 1 - v : k > 0 ? 0.8f * v + 0.05f : v; // frame 4 is of another scene
        if (k == 4)
            for (float& d : f.depth.values) d = 0.3f;
        return f;
    };
    auto shaded = on_slam::wall();
    shaded.sh_degree = 1;
    shaded.harmonics.assign(9 * shaded.gaussians.size(), 0.02f);
    for (bool const from_map : {false, true}) {
        CAPTURE(from_map);
        auto const map = from_map ? shaded : scene::Map{};
        SessionOptions o;
        o.mapper.first_steps = 12;
        o.mapper.steps = 8;
        o.mapper.optimiser = from_map ? slam::Optimiser::by_kind : slam::Optimiser::adam;
        o.with_exposure = true;
        o.keyframe_every = 3;
        auto straight = begun(o, map);
        std::vector<std::string> saved;
        std::vector<slam::FrameResult> found;
        for (std::size_t k = 0; k < 8; ++k) {
            found.push_back(straight.add(frame(k)));
            saved.push_back(straight.save());
        }
        CHECK(found[4].tracked.verdict == Verdict::lost);
        CHECK(straight.mapper().keyframes() >= 3);
        straight.mapper().refine(5);
        auto const ply = scene::ply_bytes(straight.map());
        for (std::size_t const at : {0u, 2u, 4u, 6u}) {
            CAPTURE(at);
            auto again = begun(o, map);
            std::size_t asked = 0;
            again.load(saved[at], [&](std::size_t k) { ++asked; return frame(k); });
            CHECK(again.frames() == at + 1);
            CHECK(asked == again.mapper().keyframes());
            CHECK(again.save() == saved[at]);
            for (auto k = at + 1; k < 8; ++k) {
                auto const f = again.add(frame(k));
                CHECK(f.tracked.verdict == found[k].tracked.verdict);
                CHECK(f.tracked.solution.evaluations == found[k].tracked.solution.evaluations);
                CHECK(f.keyframe.has_value() == found[k].keyframe.has_value());
                CHECK(std::memcmp(&f.tracked.pose, &found[k].tracked.pose, sizeof(scene::Pose)) == 0);
            }
            again.mapper().refine(5);
            CHECK(scene::ply_bytes(again.map()) == ply);
            CHECK(again.map().harmonics == straight.map().harmonics);
        }

        auto kept = begun(o, map);
        kept.add(frame(0));
        auto const before = kept.save();
        auto const refused = [&](Session& session, std::string const& state) {
            CHECK(tests::error_of([&] { session.load(state, frame); }).find("a run cannot go on from this state (it is damaged") == 0);
        };
        for (std::size_t const size : {std::size_t{0}, std::size_t{7}, saved[5].size() / 2, saved[5].size() - 1})
            refused(kept, saved[5].substr(0, size));
        refused(kept, saved[5] + "x");
        CHECK_THROWS_AS(kept.load(saved[5], [](std::size_t) -> Frame { throw std::runtime_error("no picture"); }), std::runtime_error);
        CHECK(kept.save() == before);
        o.mapper.optimiser = from_map ? slam::Optimiser::adam : slam::Optimiser::by_kind;
        auto other = begun(o, map);
        refused(other, saved[5]);
    }
}

TEST_CASE("session: medians of depths, and what it refuses with a line")
{
    report::Plane depth(3, 2);
    CHECK(slam::median_depth({}) == 0);
    CHECK(slam::median_depth(depth) == 0);
    depth.values = {4, 0, std::numeric_limits<float>::quiet_NaN(), 1, std::numeric_limits<float>::infinity(), 3};
    CHECK(slam::median_depth(depth) == 3);

    Mapper truth(on_slam::wall(), 2);
    auto session = begun({});
    auto frame = frame_at(truth, 0);
    frame.depth = {};
    CHECK(tests::error_of([&] { session.add(frame); }).find("depths of 0 x 0") != std::string::npos);
    frame.depth = report::Plane(96, 60);
    frame.colour = report::Image(60, 96);
    CHECK(tests::error_of([&] { session.add(frame); }).find("60 x 96") != std::string::npos);
    CHECK(session.frames() == 0);
    SessionOptions o;
    o.keyframe_every = 0;
    CHECK(tests::error_of([&] { begun(o); }).find("every 0 frames") != std::string::npos);
    o = {};
    o.most_open = std::numeric_limits<double>::quiet_NaN();
    CHECK(tests::error_of([&] { begun(o); }).find("is open") != std::string::npos);
    o = {};
    o.tracker.readout = 0.5;
    CHECK(tests::error_of([&] { begun(o); }).find("a session cannot map by a rolling shutter (") == 0);
    CHECK(tests::error_of([&] { Session({}, on_slam::lens(), 0, on_slam::pose(0)); }).find("scene depth") != std::string::npos);
}
