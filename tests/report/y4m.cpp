// test: unoptimised test asan
#include "folder.hpp"
#include <tilemesh/report/y4m.hpp>

namespace {

namespace fs = std::filesystem;
using tests::contents, tests::Folder;
using tilemesh::report::FrameRate;
using tilemesh::report::Image;
using tilemesh::report::y4m_frame;
using tilemesh::report::Y4mVideo;

using Samples = std::array<int, 3>; ///< Y', Cb, Cr

/// A stream as a reader of the format understands it. Each frame: the samples of each pixel, row by row.
struct Parsed {
    std::size_t width = 0, height = 0;
    std::string rate;
    std::vector<std::vector<Samples>> frames;
};
std::optional<Parsed> parse(std::string const& stream)
{
    std::istringstream in(stream);
    std::string line, word;
    std::getline(in, line);
    std::istringstream words(line);
    words >> word;
    if (word != "YUV4MPEG2") return {};
    Parsed parsed;
    bool full_chroma = false;
    while (words >> word) {
        if (word[0] == 'W') parsed.width = std::stoul(word.substr(1));
        if (word[0] == 'H') parsed.height = std::stoul(word.substr(1));
        if (word[0] == 'F') parsed.rate = word.substr(1);
        if (word == "C444") full_chroma = true;
    }
    if (!full_chroma) return {};
    auto const pixels = parsed.width * parsed.height;
    while (std::getline(in, line)) {
        if (line != "FRAME") return {};
        std::string planes(3 * pixels, '\0');
        if (!in.read(planes.data(), static_cast<std::streamsize>(planes.size()))) return {};
        auto& frame = parsed.frames.emplace_back(pixels);
        for (std::size_t i = 0; i < pixels; ++i)
            for (std::size_t c = 0; c < 3; ++c) frame[i][c] = static_cast<unsigned char>(planes[c * pixels + i]);
    }
    return parsed;
}

Image picture_of(std::uint32_t width, std::uint32_t height, unsigned seed = 1)
{
    std::mt19937 random(seed);
    Image image{width, height};
    for (auto& value : image.rgb) value = std::uniform_real_distribution<float>(-0.2f, 1.2f)(random);
    return image;
}
Samples samples_of(float r, float g, float b)
{
    Image image{1, 1};
    image.rgb = {r, g, b};
    auto const frame = y4m_frame(image);
    REQUIRE(frame.size() == 9);
    CHECK(frame.substr(0, 6) == "FRAME\n");
    return {static_cast<unsigned char>(frame[6]), static_cast<unsigned char>(frame[7]), static_cast<unsigned char>(frame[8])};
}

} // namespace

TEST_SUITE_BEGIN("report");

TEST_CASE("y4m: the samples of black, white, grey and the colour bars are the published ones")
{
    // Bars of 100 % in 8 bits, as test signals of Rec. BT.601 have them.
    CHECK(samples_of(0, 0, 0) == Samples{16, 128, 128});
    CHECK(samples_of(1, 1, 1) == Samples{235, 128, 128});
    CHECK(samples_of(0.25f, 0.25f, 0.25f) == Samples{71, 128, 128});
    CHECK(samples_of(1, 0, 0) == Samples{81, 90, 240});
    CHECK(samples_of(0, 1, 0) == Samples{145, 54, 34});
    CHECK(samples_of(0, 0, 1) == Samples{41, 240, 110});
    CHECK(samples_of(1, 1, 0) == Samples{210, 16, 146});
    CHECK(samples_of(0, 1, 1) == Samples{170, 166, 16});
    CHECK(samples_of(1, 0, 1) == Samples{106, 202, 222});
}

TEST_CASE("y4m: a value outside [0, 1] is clamped, and a NaN is 0")
{
    constexpr auto infinity = std::numeric_limits<float>::infinity();
    CHECK(samples_of(3.8f, -1, -infinity) == samples_of(1, 0, 0));
    CHECK(samples_of(infinity, infinity, 1e30f) == samples_of(1, 1, 1));
    CHECK(samples_of(std::numeric_limits<float>::quiet_NaN(), 1, -std::numeric_limits<float>::quiet_NaN()) == samples_of(0, 1, 0));
}

TEST_CASE("y4m: every sample is the nearest to the product with the matrix of BT.601")
{
    // Its rows for R'G'B' from 0 to 1 and levels of 8 bits, to three decimals (Poynton, Digital Video and HD, "Y'CbCr from R'G'B'").
    constexpr double matrix[3][3] = {{65.481, 128.553, 24.966}, {-37.797, -74.203, 112.0}, {112.0, -93.786, -18.214}};
    constexpr double offset[3] = {16, 128, 128};
    auto const picture = picture_of(211, 97);
    auto const parsed = parse(tilemesh::report::y4m_header(211, 97, {}) + y4m_frame(picture));
    REQUIRE(parsed.has_value());
    REQUIRE(parsed->frames.size() == 1);
    double farthest = 0;
    for (std::uint32_t y = 0; y < 97; ++y)
        for (std::uint32_t x = 0; x < 211; ++x)
            for (std::size_t c = 0; c < 3; ++c) {
                double exact = offset[c];
                for (std::size_t k = 0; k < 3; ++k) exact += matrix[c][k] * std::clamp(double{picture.pixel(x, y)[k]}, 0.0, 1.0);
                farthest = std::max(farthest, std::abs(exact - parsed->frames[0][y * 211 + x][c]));
            }
    CHECK(farthest <= 0.5 + 3 * 0.0005);
    CHECK(farthest > 0.49); // of 61,401 samples some are near a half
}

TEST_CASE("y4m: the header names size, rate, chroma and range, and fits into FFmpeg's 96 bytes")
{
    CHECK(tilemesh::report::y4m_header(1280, 720, {}) == "YUV4MPEG2 W1280 H720 F30:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n");
    CHECK(tilemesh::report::y4m_header(1, 3, {30000, 1001}) == "YUV4MPEG2 W1 H3 F30000:1001 Ip A1:1 C444 XCOLORRANGE=LIMITED\n");
    CHECK(tilemesh::report::y4m_header(65535, 65535, {1'000'000, 1'000'000}).size() <= 96);
}

TEST_CASE("y4m: a file has one header and all frames in order, at odd sizes too")
{
    for (auto const& size : {std::pair{1u, 1u}, std::pair{3u, 5u}, std::pair{64u, 1u}, std::pair{17u, 9u}}) {
        auto const width = size.first, height = size.second; // Clang 14 captures no structured binding
        CAPTURE(width);
        CAPTURE(height);
        Folder const folder;
        auto const path = folder.path / "a.y4m";
        std::vector<std::string> expected;
        Y4mVideo video(path, width, height, FrameRate{24000, 1001});
        for (unsigned i = 0; i < 3; ++i) {
            auto const picture = picture_of(width, height, i);
            expected.push_back(y4m_frame(picture));
            video.add(picture);
        }
        CHECK_FALSE(fs::exists(path));
        CHECK(folder.files() == 1); // its part
        video.finish();
        CHECK(folder.files() == 1);
        auto const text = contents(path);
        CHECK(text == tilemesh::report::y4m_header(width, height, {24000, 1001}) + expected[0] + expected[1] + expected[2]);
        auto const parsed = parse(text);
        REQUIRE(parsed.has_value());
        CHECK(parsed->width == width);
        CHECK(parsed->height == height);
        CHECK(parsed->rate == "24000:1001");
        CHECK(parsed->frames.size() == 3);
    }
}

TEST_CASE("y4m: a video that is not finished leaves nothing, and what had its name")
{
    Folder const folder;
    auto const path = folder.path / "a.y4m";
    std::ofstream(path) << "the old file";
    {
        Y4mVideo video(path, 4, 3);
        video.add(picture_of(4, 3));
    }
    CHECK(contents(path) == "the old file");
    CHECK(folder.files() == 1);
    Y4mVideo(path, 4, 3).finish(); // without a frame
    CHECK(contents(path) == tilemesh::report::y4m_header(4, 3, {}));
}

TEST_CASE("y4m: a stream has each frame at once, and stays open")
{
    tests::Stream const stream{std::tmpfile()};
    REQUIRE(stream.file != nullptr);
    auto const length = [&] { // what the system has
        std::error_code ignored;
        return fs::file_size("/proc/self/fd/" + std::to_string(fileno(stream.file)), ignored);
    };
    auto const header = tilemesh::report::y4m_header(2, 2, {}).size();
    Y4mVideo video(stream.file, "the video", 2, 2);
    video.add(picture_of(2, 2));
    if (fs::exists("/proc/self/fd")) CHECK(length() == header + 18);
    video.add(picture_of(2, 2));
    video.finish();
    CHECK(std::fputs("more", stream.file) >= 0);
    std::rewind(stream.file);
    std::string text(1000, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), stream.file));
    CHECK(text.size() == header + 36 + 4);
}

TEST_CASE("y4m: a frame of another size, sides and rates of 0, and a full disk are refused")
{
    Folder const folder;
    auto const path = folder.path / "a.y4m";
    Y4mVideo video(path, 4, 3);
    video.add(picture_of(4, 3));
    CHECK_THROWS_WITH_AS(video.add(picture_of(3, 4)), doctest::Contains("3 x 4 pixels is no frame of this video (its frames have 4 x 3)"), tilemesh::Error);
    CHECK_THROWS_AS(video.add(picture_of(4, 4)), tilemesh::Error);
    CHECK_THROWS_AS(video.add(picture_of(5, 3)), tilemesh::Error);
    video.add(picture_of(4, 3)); // the frames before and after are whole
    video.finish();
    CHECK(parse(contents(path)).value().frames.size() == 2);

    auto const other = folder.path / "b.y4m";
    CHECK_THROWS_AS(Y4mVideo(other, 0, 3), tilemesh::Error);
    CHECK_THROWS_AS(Y4mVideo(other, 3, 0), tilemesh::Error);
    CHECK_THROWS_AS(Y4mVideo(other, 3, 3, FrameRate{0, 1}), tilemesh::Error);
    CHECK_THROWS_AS(Y4mVideo(other, 3, 3, FrameRate{1, 0}), tilemesh::Error);
    CHECK_THROWS_WITH_AS(Y4mVideo(folder.path / "absent" / "a", 1280, 720), doctest::Contains("room for 2764806 bytes per frame"), tilemesh::Error);
    CHECK(folder.files() == 1);
    if (!fs::is_character_file("/dev/full")) {
        MESSAGE("skipped: there is no /dev/full");
        return;
    }
    Y4mVideo full("/dev/full", 4, 3);
    CHECK_THROWS_WITH_AS(full.add(picture_of(4, 3)), doctest::Contains("No space"), tilemesh::Error);
}

TEST_SUITE_END();
