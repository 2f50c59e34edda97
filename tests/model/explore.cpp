// test: unoptimised test asan, without tsan
// Fronts and knees of studies: by brute force, by hand, and what may not be on them.
#include "../splat/support.hpp"
#include <tilemesh/model/explore.hpp>

using namespace tilemesh;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

StudyPoint point(std::string name, double psnr, double ms, std::uint64_t sram = 100, std::uint64_t bytes = 100)
{
    StudyPoint p;
    p.name = std::move(name);
    p.psnr_db = psnr, p.modelled_ms = ms, p.sram_bytes = sram, p.exchanged_bytes = bytes;
    return p;
}
using tests::has;

} // namespace

TEST_CASE("the front of 60 random studies is that of a loop over all pairs and all measures")
{
    support::Random random(4321);
    for (std::uint32_t round = 0; round < 60; ++round) {
        std::vector<StudyPoint> points;
        for (std::uint32_t i = 0; i < 1 + random.below(40); ++i) { // few values, so that many are equal
            points.push_back(point(std::to_string(i), random.below(4) == 0 ? infinite : 40.0 + random.below(4), 1.0 + random.below(5), random.below(4), random.below(4)));
            if (random.below(6) == 0) points.back().refused = "it does not fit";
            if (random.below(6) == 0) points.back().left_out = "vote";
            points.back().lost = random.below(4) / 3;
            points.back().map = random.below(3) == 0 ? "b" : "a";
            points.back().whole_channels = random.below(2) == 0;
        }
        std::vector<std::size_t> by_hand;
        for (std::size_t i = 0; i < points.size(); ++i) {
            double const mine[4] = {-points[i].psnr_db, points[i].modelled_ms, double(points[i].sram_bytes), double(points[i].exchanged_bytes)};
            bool on_front = points[i].refused.empty() && points[i].left_out.empty() && points[i].lost == 0;
            for (auto const& other : points) {
                double const its[4] = {-other.psnr_db, other.modelled_ms, double(other.sram_bytes), double(other.exchanged_bytes)};
                bool all = other.refused.empty() && other.left_out.empty() && other.lost == 0 && other.map == points[i].map, some = false;
                int const measures = other.whole_channels == points[i].whole_channels ? 4 : 3; // the last are bytes: of one kind only
                for (int k = 0; k < measures; ++k) {
                    all = all && its[k] <= mine[k];
                    some = some || its[k] < mine[k];
                }
                if (all && some) on_front = false;
            }
            if (on_front) by_hand.push_back(i);
        }
        auto front = front_of(points);
        CHECK(std::is_sorted(front.begin(), front.end(), [&](std::size_t a, std::size_t b) { return points[a].modelled_ms < points[b].modelled_ms; }));
        std::vector<std::size_t> of_maps;
        for (auto const& one : fronts_of(points))
            for (auto const i : one.points) {
                CHECK(points[i].map == one.map);
                of_maps.push_back(i);
            }
        std::sort(of_maps.begin(), of_maps.end());
        std::sort(front.begin(), front.end());
        CHECK(of_maps == front);
        CHECK(front == by_hand);
    }
}

TEST_CASE("bytes of messages are no fewer than bytes of whole channels: a front compares bytes of one kind")
{
    std::vector<StudyPoint> points{point("channels", 40, 2, 100, 3300), point("messages", 40, 4, 100, 78), point("narrow", 40, 3, 100, 3000)};
    points[0].whole_channels = points[2].whole_channels = true;
    CHECK(beats(points[0], points[1]));
    CHECK(front_of(points) == std::vector<std::size_t>{0, 2});
    points[1].whole_channels = true;
    CHECK_FALSE(beats(points[0], points[1]));
    CHECK(front_of(points) == std::vector<std::size_t>{0, 2, 1});
}

TEST_CASE("the knee: the point above the chord, of gains in PSNR, then in SRAM; fewer than three points have none")
{
    // From (1 ms, 40 dB) to (11 ms, 60 dB): at 2 ms, 55 dB is 0.75 - 0.1 above the chord, at 5 ms 58 dB is 0.9 - 0.4.
    std::vector<StudyPoint> points{point("slow", 60, 11), point("fast", 40, 1), point("knee", 55, 2), point("late", 58, 5), point("worse", 39, 3)};
    auto const front = front_of(points);
    CHECK(front == std::vector<std::size_t>{1, 2, 3, 0});
    CHECK(knee_of(points, front) == std::size_t{2});
    std::vector<StudyPoint> const third{point("fast", 40, 1), point("first", 41, 2), point("knee", 58, 3), point("slow", 60, 11)};
    CHECK(knee_of(third, front_of(third)) == std::size_t{2});
    CHECK(knee_text(points, front) ==
          "The knee, where more time buys more PSNR, is knee (55.00 dB, 2.0000 ms modelled, 100 bytes of SRAM a tile): the point with the most PSNR, slow, takes 5.50 times as long.");
    // A time with losses is on no front and in no sentence, and beats no complete point.
    points[1].lost = 1234;
    CHECK(front_of(points) == std::vector<std::size_t>{2, 3, 0});
    CHECK_FALSE(has(knee_text(points, front_of(points)), "fast ("));
    points[2].lost = 1;
    CHECK(front_of(points) == std::vector<std::size_t>{4, 3, 0});

    // Equal pictures: the gain is SRAM that is not used.
    std::vector<StudyPoint> equal{point("a", infinite, 1, 900), point("b", infinite, 2, 300), point("c", infinite, 9, 200), point("d", infinite, 9, 900)};
    auto const of_equal = front_of(equal);
    CHECK(of_equal == std::vector<std::size_t>{0, 1, 2});
    CHECK(knee_of(equal, of_equal) == std::size_t{1});
    CHECK(has(knee_text(equal, of_equal), "equal pictures"));
    CHECK(has(knee_text(equal, of_equal), "more time buys less SRAM, is b ("));
    CHECK(knee_text(std::span(equal).first(1), front_of(std::span(equal).first(1))) ==
          "The front has one point, and no knee: a (equal pictures, 1.0000 ms modelled, 900 bytes of SRAM a tile).");
    auto bytes = equal; // of equal pictures and SRAM, the gain is bytes exchanged
    for (auto& p : bytes) p.exchanged_bytes = p.sram_bytes, p.sram_bytes = 500;
    CHECK(has(knee_text(bytes, front_of(bytes)), "more time buys fewer bytes exchanged, is b ("));

    CHECK_FALSE(knee_of(std::span(equal).first(2), front_of(std::span(equal).first(2))));
    CHECK(has(knee_text(std::span(equal).first(2), front_of(std::span(equal).first(2))), "The front has no knee: fewer than three of its 2 points buy less SRAM with more time."));
    for (auto& p : equal) p.left_out = "barrier";
    CHECK(front_of(equal).empty());
    CHECK(has(knee_text(equal, front_of(equal)), "No point has a front"));
    CHECK(mark_of(equal[0]) == "at least: without barrier");
    equal[0].lost = 2;
    CHECK(mark_of(equal[0]) == "loses 2; at least: without barrier");
    equal[0].refused = "no room";
    CHECK(mark_of(equal[0]) == "does not run");
}
