#include "folder.hpp"
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/image_file.hpp>

namespace {

namespace report = tilemesh::report;
using tests::contents, tests::error_of, tests::Folder, tests::put;

/// Is the text one line of the form "<problem> (<why>); <what to do>"?
bool well_formed(std::string const& text)
{
    return tests::has(text, " (") && tests::has(text, "); ") && !tests::has(text, "\n");
}

bool same_bits(report::Image const& a, report::Image const& b)
{
    return a.width == b.width && a.height == b.height && a.rgb.size() == b.rgb.size() &&
           std::memcmp(a.rgb.data(), b.rgb.data(), a.rgb.size() * sizeof a.rgb[0]) == 0;
}

report::Image numbered(std::uint32_t width, std::uint32_t height)
{
    report::Image image{width, height};
    std::iota(image.rgb.begin(), image.rgb.end(), 0.0f);
    return image;
}

} // namespace

TEST_SUITE_BEGIN("report");

TEST_CASE("a PFM keeps every bit")
{
    Folder const folder;
    using Limits = std::numeric_limits<float>;
    report::Image image{3, 2}, pixel{1, 1};
    image.rgb = {0.0f, -0.0f, -1.5f, 3.8f, 1e30f, 0.1f, 255.0f, 1e-30f, -1e-42f};
    for (float const each : {Limits::max(), Limits::lowest(), Limits::min(), Limits::denorm_min(), Limits::infinity(), -Limits::infinity(),
                             Limits::quiet_NaN(), 1.0f + Limits::epsilon(), 1.0f / 3.0f})
        image.rgb.push_back(each);
    pixel.rgb = {-2.0f, 0.5f, 7.0f};
    for (auto const& each : {image, pixel}) { // the second over the first
        report::write_pfm(folder.path / "a.pfm", each);
        CHECK(same_bits(report::read_pfm(folder.path / "a.pfm"), each));
        CHECK(folder.files() == 1); // no part is left
    }
}

TEST_CASE("a PFM is rows from the bottom, little endian")
{
    Folder const folder;
    report::Image image{1, 2};
    image.rgb = {1.0f, 2.0f, 4.0f, -1.0f, 0.5f, 0.0f};
    report::write_pfm(folder.path / "a.pfm", image);
    // IEEE 754: 1 = 3f800000, 2 = 40000000, 4 = 40800000, -1 = bf800000, 0.5 = 3f000000.
    std::string const expected{"PF\n1 2\n-1.0\n"
                               "\x00\x00\x80\xbf\x00\x00\x00\x3f\x00\x00\x00\x00"
                               "\x00\x00\x80\x3f\x00\x00\x00\x40\x00\x00\x80\x40",
                               12 + 24};
    CHECK(contents(folder.path / "a.pfm") == expected);
}

TEST_CASE("a big-endian PFM is read")
{
    Folder const folder;
    put(folder.path / "a.pfm", std::string{"PF 1 2 1\n"
                                           "\xbf\x80\x00\x00\x3f\x00\x00\x00\x00\x00\x00\x00"
                                           "\x3f\x80\x00\x00\x40\x00\x00\x00\x40\x80\x00\x00",
                                           9 + 24});
    auto const image = report::read_pfm(folder.path / "a.pfm");
    CHECK(image.width == 1);
    CHECK(image.height == 2);
    CHECK(image.rgb == std::vector<float>{1.0f, 2.0f, 4.0f, -1.0f, 0.5f, 0.0f});
}

TEST_CASE("8-bit values are clamped and rounded to nearest")
{
    report::Image image{3, 1};
    image.rgb = {0.0f,           1.0f,           0.5f,                                    // 127.5 goes up
                 -3.0f,          3.8f,           std::numeric_limits<float>::quiet_NaN(), //
                 0.49f / 255.0f, 0.51f / 255.0f, std::numeric_limits<float>::infinity()};
    std::vector<std::byte> expected;
    for (int value : {0, 255, 128, 0, 255, 0, 0, 1, 255}) expected.push_back(static_cast<std::byte>(value));
    CHECK(report::rgb8(image) == expected);
    CHECK(report::rgb8(report::Image{}).empty());

    // Every 8-bit value survives.
    report::Image ramp{256, 1};
    for (std::uint32_t i = 0; i < 256; ++i)
        for (int k = 0; k < 3; ++k) ramp.pixel(i, 0)[k] = static_cast<float>(i) / 255.0f;
    auto const bytes = report::rgb8(ramp);
    bool equal = bytes.size() == 768;
    for (std::size_t i = 0; equal && i < 768; ++i) equal = std::to_integer<std::size_t>(bytes[i]) == i / 3;
    CHECK(equal);
}

TEST_CASE("a PPM is rows from the top")
{
    Folder const folder;
    report::Image image{2, 2};
    image.rgb = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    report::write_ppm(folder.path / "a.ppm", image);
    CHECK(contents(folder.path / "a.ppm") == std::string{"P6\n2 2\n255\n\xff\0\0\0\xff\0\0\0\xff\xff\xff\xff", 11 + 12});
    CHECK(folder.files() == 1);
}

TEST_CASE("a file that cannot be written is an error and leaves nothing")
{
    Folder const folder;
    auto const image = numbered(2, 2);
    auto bent = image;
    bent.rgb.pop_back();
    auto const nowhere = folder.path / "nowhere" / "a.pfm";
    using Path = std::filesystem::path;
    auto const ppm = [](Path const& path, report::Image const& picture) { report::write_ppm(path, picture); };
    auto const pfm = [](Path const& path, report::Image const& picture) { report::write_pfm(path, picture); };
    for (std::function<void(Path const&, report::Image const&)> const& write : {std::function(ppm), std::function(pfm)}) {
        auto const text = error_of([&] { write(nowhere, image); });
        CHECK(well_formed(text));
        CHECK(tests::has(text, nowhere.string()));
        CHECK(well_formed(error_of([&] { write(folder.path / "c", bent); })));
    }
    CHECK(well_formed(error_of([&] { report::write_pfm(folder.path / "c", report::Image{}); })));
    CHECK(folder.files() == 0);

    // The rename is refused: a folder that is not empty has the name.
    std::filesystem::create_directories(folder.path / "taken" / "inside");
    CHECK(well_formed(error_of([&] { report::write_pfm(folder.path / "taken", image); })));
    CHECK(folder.files() == 1);
}

TEST_CASE("a plane is a grey PFM, the last row first; one that is not whole is refused")
{
    Folder const folder;
    auto const path = folder.path / "depth.pfm";
    report::Plane plane(2, 2);
    plane.values = {1.0f, 2.0f, 3.0f, -0.0f};
    report::write_pfm(path, plane);
    CHECK(contents(path) == std::string("Pf\n2 2\n-1.0\n\0\0\x40\x40\0\0\0\x80\0\0\x80\x3f\0\0\0\x40", 28));
    plane.values.pop_back();
    CHECK(well_formed(error_of([&] { report::write_pfm(path, plane); })));
    CHECK(well_formed(error_of([&] { report::write_pfm(path, report::Plane{}); })));
}

TEST_CASE("a damaged PFM is refused")
{
    Folder const folder;
    auto const path = folder.path / "a.pfm";
    report::write_pfm(path, numbered(5, 4));
    auto const whole = contents(path);
    auto const refused = [&](std::string const& bytes) {
        put(path, bytes);
        auto const text = error_of([&] { (void)report::read_pfm(path); });
        return well_formed(text) && tests::has(text, path.string());
    };
    CHECK_FALSE(refused(whole));
    // Cut anywhere, or with one byte too many.
    std::size_t accepted = 0;
    for (std::size_t length = 0; length < whole.size(); ++length) accepted += refused(whole.substr(0, length)) ? 0 : 1;
    CHECK(accepted == 0);
    CHECK(refused(whole + '\0'));
    CHECK(refused("PF\n0 0\n-1\n"));

    auto const body = whole.substr(whole.size() - 240);
    CHECK_FALSE(refused("PF\n5 4\n-1\n" + body));
    for (std::string const head :
         {"PF\n6 4\n-1\n", "PF\n4 6\n-1\n" /* 24 pixels */, "PF\n9 2\n-1\n" /* 18 pixels, and 20 / 9 = 2 */, "PF\n0 4\n-1\n", "PF\n-5 -4\n-1\n",
          "PF\n5 4\n2\n", "PF\n5 4\n0\n", "PF\n5 4\nnan\n", "PF\n5 4\n-1x", "PF\n5 four\n-1\n", "Pf\n5 12\n-1\n", "P6\n5 4\n255\n"}) {
        CAPTURE(head);
        CHECK(refused(head + body));
    }
}

TEST_CASE("an absurd size is refused before anything is allocated")
{
    Folder const folder;
    auto const path = folder.path / "a.pfm";
    for (auto const* const size : {"4294967295 4294967295", "4294967296 1", "1 4294967296", "1000000 1000000", "99999999999999999999 1",
                                   // 12 * 2^31 * 2^31 = 0 modulo 2^64.
                                   "2147483648 2147483648"}) {
        CAPTURE(size);
        for (auto const& body : {std::string{}, std::string(12, '\0')}) {
            put(path, std::string{"PF\n"} + size + "\n-1.0\n" + body);
            CHECK(well_formed(error_of([&] { (void)report::read_pfm(path); })));
        }
    }
}

TEST_CASE("what is no file cannot be read")
{
    Folder const folder;
    CHECK(well_formed(error_of([&] { (void)report::read_pfm(folder.path / "missing"); })));
    CHECK(well_formed(error_of([&] { (void)report::read_pfm(folder.path); })));
}

TEST_SUITE_END();

TEST_CASE("a BMP file has its headers, rows from below, blue first, and rows of whole words")
{
    report::Image image(2, 2);
    float const rgb[] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5f, 2, -1};
    std::copy(std::begin(rgb), std::end(rgb), image.rgb.begin());
    auto const bytes = report::bmp(image);
    std::string const expected("BM\x46\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x02\0\0\0\x02\0\0\0\x01\0\x18\0\0\0\0\0\x10\0\0\0"
                               "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
                               "\xff\0\0\0\xff\x80\0\0"
                               "\0\0\xff\0\xff\0\0\0",
                               70);
    CHECK(bytes == expected);
    CHECK(report::bmp(report::Image(4, 3)).size() == 54 + 36); // no byte too many where a row is whole words
    CHECK_THROWS_AS(report::bmp(report::Image{}), tilemesh::Error);
    CHECK_THROWS_AS(report::bmp(report::Image(65'536, 1)), tilemesh::Error);
    report::Image cut(2, 2);
    cut.rgb.pop_back();
    CHECK_THROWS_AS(report::bmp(cut), tilemesh::Error);
}
