#include "support.hpp"
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/rgbd_list.hpp>

using namespace scene_test;
using namespace tilemesh;

namespace {

std::vector<scene::RgbdFrame> frames(std::string const& text)
{
    std::istringstream stream(text);
    return scene::read_rgbd_list(stream, "list");
}
std::string refusal(std::string const& text)
{
    return error_of([&] { frames(text); });
}
std::vector<scene::StampedFile> at(std::vector<double> const& times)
{
    std::vector<scene::StampedFile> out;
    for (double const t : times) out.push_back({t, std::to_string(t)});
    return out;
}

} // namespace

TEST_CASE("lists of the TUM RGB-D benchmark are read in the order of time")
{
    auto const two = frames("# color and depth\n\n1305031102.2 rgb/b.png 1305031102.21 depth/b.png\r\n 1305031102.1\trgb/a.png 1305031102.08 depth/a.png  \n  # end");
    REQUIRE(two.size() == 2);
    CHECK(two[0].colour.seconds == 1305031102.1);
    CHECK(two[0].colour.file == "rgb/a.png");
    CHECK(two[0].depth.seconds == 1305031102.08);
    CHECK(two[1].depth.file == "depth/b.png");
    auto const one = frames("2 b.png\n1 a.png\n");
    CHECK(one[0].colour.file == "a.png");
    CHECK(one[0].depth.file.empty());
    std::istringstream stream("3 c\n1 a\n1 b\n");
    auto const list = scene::read_file_list(stream, "rgb.txt");
    CHECK(list[0].file == "a");
    CHECK(list[1].file == "b");
    CHECK(list[2].file == "c");
}

TEST_CASE("a bad line is named, and a list without a picture is refused")
{
    CHECK(has(refusal("1 a\nx b\n"), "list line 2 is not a picture of a sequence (\"x\" is not a time in seconds); write timestamp rgb_file"));
    CHECK(has(refusal("1 a\nnan b\n"), "is not a time"));
    CHECK(has(refusal("1 a\n1e38 b\n"), "is not a time"));
    CHECK(has(refusal("1\n"), "its last time has no file"));
    CHECK(has(refusal("1 a 2\n"), "its last time has no file"));
    CHECK(has(refusal("1 a 2 b\n1 a\n"), "2 words where 4 are needed"));
    CHECK(has(refusal("1 a\n1 a 2 b\n"), "4 words where 2 are needed"));
    CHECK(has(refusal("1 a 2 b c\n"), "more than 4 words"));
    CHECK(has(refusal("1 a\x01" "b\n"), "\"a?b\" is not a file name that can be printed"));
    CHECK(has(refusal(""), "lists no picture"));
    CHECK(has(refusal("# 1 a\n\n"), "lists no picture"));
    CHECK(has(refusal("1 " + std::string(70000, 'a')), "too long"));
    std::istringstream stream("1 a 2 b\n");
    CHECK(has(error_of([&] { scene::read_file_list(stream, "rgb.txt"); }), "more than 2 words"));
}

TEST_CASE("each picture has the nearest depth, no depth is used twice, and none is further than 20 ms: as all pairs say")
{
    auto const simple = scene::associate(at({1.0, 2.0, 3.0}), at({0.985, 1.01, 2.05, 3.015}));
    CHECK(simple[0].depth.seconds == 1.01);
    CHECK(simple[1].depth.file.empty());
    CHECK(simple[2].depth.seconds == 3.015);
    CHECK(scene::associate(at({1.0}), {})[0].depth.file.empty());
    CHECK(scene::associate({}, at({1.0})).empty());
    // One depth between two pictures: the nearer one has it.
    auto const shared = scene::associate(at({1.0, 1.01}), at({1.006}));
    CHECK(shared[0].depth.file.empty());
    CHECK(shared[1].depth.seconds == 1.006);

    tests::Random random(1);
    for (int trial = 0; trial < 200; ++trial) {
        auto const times = [&] {
            std::vector<double> t(random.below(20));
            for (double& time : t) time = random.below(64) / 256.0; // many ties
            std::sort(t.begin(), t.end());
            return t;
        };
        auto const colour = times(), depth = times();
        auto const out = scene::associate(at(colour), at(depth));
        REQUIRE(out.size() == colour.size());
        for (std::size_t i = 0; i < colour.size(); ++i) {
            double least = 1e9;
            for (double const z : depth) least = std::fmin(least, std::fabs(z - colour[i]));
            auto const& d = out[i].depth;
            if (least > 0.02) CHECK(d.file.empty());
            if (!d.file.empty()) CHECK(std::fabs(d.seconds - colour[i]) == least);
            // Without a depth, some other picture is at least as near to the one that it wanted.
            bool rival = false;
            for (std::size_t j = 0; j < colour.size(); ++j)
                rival = rival || (j != i && !out[j].depth.file.empty() && std::fabs(out[j].depth.seconds - colour[i]) == least && std::fabs(out[j].depth.seconds - colour[j]) <= least);
            if (least <= 0.02 && d.file.empty()) CHECK(rival);
        }
    }
}

TEST_CASE("a folder has associations.txt, or rgb.txt with or without depth.txt; names start there")
{
    TempFolder const place;
    auto const& folder = place.path();
    CHECK(has(error_of([&] { scene::load_rgbd(folder); }), "is no sequence (it has neither associations.txt nor rgb.txt)"));
    place.write("rgb.txt", "1 rgb/1.png\n2 rgb/2.png\n");
    CHECK(scene::load_rgbd(folder)[1].colour.file == folder / "rgb/2.png");
    CHECK(scene::load_rgbd(folder)[1].depth.file.empty());
    place.write("depth.txt", "2.01 depth/2.png\n");
    CHECK(scene::load_rgbd(folder)[1].depth.file == folder / "depth/2.png");
    CHECK(scene::load_rgbd(folder)[0].depth.file.empty());
    place.write("associations.txt", "5 rgb/5.png 5 depth/5.png\n");
    CHECK(scene::load_rgbd(folder).size() == 1);
    CHECK(scene::load_rgbd(folder / "rgb.txt").size() == 2);
    CHECK(has(error_of([&] { scene::load_rgbd(folder / "none.txt"); }), "no such file"));
    place.write("depth.txt", "");
    std::filesystem::remove(folder / "associations.txt");
    CHECK(has(error_of([&] { scene::load_rgbd(folder); }), "depth.txt lists no picture"));
}

TEST_CASE("notes say the unit of stamps, how many pictures have a depth, and which depths are far from their picture")
{
    TempFile const list("", ".txt");
    auto const notes_of = [&](std::string const& text, std::optional<double> within = scene::most_seconds_apart) {
        std::ofstream(list.path()) << text;
        Lines notes;
        scene::load_rgbd(list.path(), within, &notes);
        return notes;
    };
    CHECK(notes_of("1 a.png 1.02 a.depth.png\n2 b.png 1.99 b.depth.png\n") == Lines{});
    CHECK(notes_of("1311868164.363400 a.png 1311868164.383400 d.png\n") == Lines{});
    CHECK(notes_of("1 a.png\n2.5 b.png\n") == Lines{"0 of 2 pictures have a depth"});
    CHECK(notes_of("1 a.png\n2.5 b.png\n", {}) == Lines{});
    // Whole stamps without a date: of pictures, of milliseconds or of seconds.
    CHECK(notes_of("0 a.png\n1 b.png\n2 c.png\n", {}) == Lines{});
    CHECK(notes_of("0 a.png 0 a.depth.png\n33 b.png 33 b.depth.png\n") == Lines{"whole time stamps are read as seconds"});
    CHECK(notes_of("1.5 a.png\n1.5 b.png\n1.5 c.png\n2 d.png\n", {}) == Lines{"pictures with the time stamp of an earlier one: 2 of 4"});
    std::string const three = "1 a.png 99 a.depth.png\n2 b.png 2 b.depth.png\n3 c.png 2.5 c.depth.png\n";
    CHECK(notes_of(three) == Lines{"pictures whose depth is more than 0.02 s away: 2, the furthest is 98 s away, of the picture at 1"});
    CHECK(notes_of(three, 0.5) == Lines{"pictures whose depth is more than 0.5 s away: 1, the furthest is 98 s away, of the picture at 1"});
    CHECK(notes_of(three, 98) == Lines{});
    CHECK(notes_of(three, {}) == Lines{});
    CHECK(notes_of("1305031102175304 a.png 1305031102180304 d.png\n") == Lines{"time stamps are read as microseconds"});
    // 5 / 256 s is within 0.02 s, and 6 / 256 s is not.
    CHECK(notes_of("1 a.png 1.01953125 d.png\n2 b.png 2.0234375 d.png\n") ==
          Lines{"pictures whose depth is more than 0.02 s away: 1, the furthest is 0.0234375 s away, of the picture at 2"});
}

TEST_CASE("stamps in any unit give the same frames, and backslashes are read as slashes")
{
    TempFolder const place;
    auto const& folder = place.path();
    for (double const start : {0.0, 1305031102.175})
        for (auto const& [per_second, name] : {std::pair{1.0, ""}, {1e3, "milliseconds"}, {1e6, "microseconds"}, {1e9, "nanoseconds"}}) {
            if (start == 0.0 && per_second == 1e3) continue; // 33 units a picture: nothing tells them from seconds
            std::string colour, depth;
            for (int i = 0; i < 5; ++i) {
                auto const stamp = [unit = per_second](double seconds) { return unit == 1.0 ? number_text(seconds) : decimals(seconds * unit, 0); };
                colour += stamp(start + 0.033 * i) + " rgb\\" + std::to_string(i) + ".png\n";
                depth += stamp(start + 0.033 * i + 0.005) + " depth\\sub\\" + std::to_string(i) + ".png\n";
            }
            place.write("rgb.txt", colour);
            place.write("depth.txt", depth);
            Lines notes;
            auto const out = scene::load_rgbd(folder, scene::most_seconds_apart, &notes);
            CHECK(notes == (per_second == 1.0 ? Lines{} : std::vector{"time stamps are read as " + std::string(name)}));
            REQUIRE(out.size() == 5);
            for (std::size_t i = 0; i < 5; ++i) {
                CHECK(std::fabs(out[i].colour.seconds - start - 0.033 * static_cast<double>(i)) < 1e-3);
                CHECK(out[i].colour.file == folder / "rgb" / (std::to_string(i) + ".png"));
                CHECK(out[i].depth.file == folder / "depth/sub" / (std::to_string(i) + ".png"));
            }
        }
    // Depths that are 30 ms late.
    place.write("rgb.txt", "1305031102.1 a.png\n1305031102.2 b.png\n");
    place.write("depth.txt", "1305031102.13 c.png\n1305031102.23 d.png\n");
    CHECK(has(error_of([&] { scene::load_rgbd(folder); }), "has a depth (0.02 s from a picture to its depth are allowed, and the nearest is 0.03 s away); allow more with --depth-within"));
    CHECK(scene::load_rgbd(folder, 0.03)[1].depth.file == folder / "d.png");
    CHECK(scene::load_rgbd(folder, {})[1].depth.file.empty());
    place.write("depth.txt", "1305031102.21 d.png\n");
    Lines notes;
    scene::load_rgbd(folder, 0.02, &notes);
    CHECK(notes == Lines{"1 of 2 pictures have a depth"});
}
