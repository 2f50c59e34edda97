#include "../standard.hpp"
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/image_file.hpp>
#if defined(__linux__)
#include <csignal>
#include <sys/resource.h>
#endif

namespace {

namespace fs = std::filesystem;
namespace report = tilemesh::report;

/// A fresh folder that goes away with its owner.
struct Folder {
    fs::path path;
    Folder()
    {
        std::random_device random;
        do path = fs::temp_directory_path() / ("tilemesh_" + std::to_string(random()));
        while (!fs::create_directory(path));
    }
    ~Folder()
    {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
    Folder(Folder const&) = delete;
    Folder& operator=(Folder const&) = delete;

    std::size_t entries() const
    {
        return static_cast<std::size_t>(
            std::distance(fs::directory_iterator{path}, fs::directory_iterator{}));
    }
};

std::string bytes_of(fs::path const& path)
{
    std::ifstream in{path, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, std::istreambuf_iterator<char>{}};
}

void put(fs::path const& path, std::string const& bytes)
{
    std::ofstream out{path, std::ios::binary};
    out << bytes;
}

/// The text of the error, or "" if nothing was thrown.
using tests::error_of;

/// Is the text one line of the form "<problem> (<why>); <what to do>"?
bool well_formed(std::string const& text)
{
    return text.find(" (") != std::string::npos && text.find("); ") != std::string::npos &&
           text.find('\n') == std::string::npos;
}

bool same_bits(report::Image const& a, report::Image const& b)
{
    if (a.width != b.width || a.height != b.height || a.rgb.size() != b.rgb.size()) return false;
    for (std::size_t i = 0; i < a.rgb.size(); ++i)
        if (std::bit_cast<std::uint32_t>(a.rgb[i]) != std::bit_cast<std::uint32_t>(b.rgb[i]))
            return false;
    return true;
}

report::Image numbered(std::uint32_t width, std::uint32_t height)
{
    report::Image image{width, height};
    for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = static_cast<float>(i);
    return image;
}

} // namespace

TEST_SUITE_BEGIN("report");

TEST_CASE("a PFM keeps every bit")
{
    Folder folder;
    using Limits = std::numeric_limits<float>;
    report::Image image{3, 2};
    image.rgb = {0.0f,
                 -0.0f,
                 -1.5f,
                 3.8f,
                 1e30f,
                 Limits::max(),
                 Limits::lowest(),
                 Limits::min(),
                 Limits::denorm_min(),
                 -1e-42f,
                 0.1f,
                 1.0f / 3.0f,
                 Limits::infinity(),
                 -Limits::infinity(),
                 Limits::quiet_NaN(),
                 1.0f + Limits::epsilon(),
                 255.0f,
                 1e-30f};
    report::write_pfm(folder.path / "a.pfm", image);
    CHECK(same_bits(report::read_pfm(folder.path / "a.pfm"), image));
    CHECK(folder.entries() == 1); // no part is left

    report::Image pixel{1, 1};
    pixel.rgb = {-2.0f, 0.5f, 7.0f};
    report::write_pfm(folder.path / "a.pfm", pixel); // over the other
    CHECK(same_bits(report::read_pfm(folder.path / "a.pfm"), pixel));
    CHECK(folder.entries() == 1);
}

TEST_CASE("a PFM is rows from the bottom, little endian")
{
    Folder folder;
    report::Image image{1, 2};
    image.rgb = {1.0f, 2.0f, 4.0f, -1.0f, 0.5f, 0.0f};
    report::write_pfm(folder.path / "a.pfm", image);
    // IEEE 754: 1 = 3f800000, 2 = 40000000, 4 = 40800000, -1 = bf800000, 0.5 = 3f000000.
    std::string const expected{"PF\n1 2\n-1.0\n"
                               "\x00\x00\x80\xbf\x00\x00\x00\x3f\x00\x00\x00\x00"
                               "\x00\x00\x80\x3f\x00\x00\x00\x40\x00\x00\x80\x40",
                               12 + 24};
    CHECK(bytes_of(folder.path / "a.pfm") == expected);
}

TEST_CASE("a big-endian PFM is read")
{
    Folder folder;
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
    image.rgb = {0.0f,           1.0f,           0.5f, // 127.5 goes up
                 -3.0f,          3.8f,           std::numeric_limits<float>::quiet_NaN(), //
                 0.49f / 255.0f, 0.51f / 255.0f, std::numeric_limits<float>::infinity()};
    std::vector<std::byte> expected;
    for (int value : {0, 255, 128, 0, 255, 0, 0, 1, 255})
        expected.push_back(static_cast<std::byte>(value));
    CHECK(report::rgb8(image) == expected);
    CHECK(report::rgb8(report::Image{}).empty());

    // Every 8-bit value survives.
    report::Image ramp{256, 1};
    for (std::uint32_t i = 0; i < 256; ++i)
        for (int k = 0; k < 3; ++k) ramp.pixel(i, 0)[k] = static_cast<float>(i) / 255.0f;
    auto const bytes = report::rgb8(ramp);
    bool equal = bytes.size() == 768;
    for (std::size_t i = 0; equal && i < 768; ++i)
        equal = std::to_integer<std::size_t>(bytes[i]) == i / 3;
    CHECK(equal);
}

TEST_CASE("a PPM is rows from the top")
{
    Folder folder;
    report::Image image{2, 2};
    image.rgb = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    report::write_ppm(folder.path / "a.ppm", image);
    CHECK(bytes_of(folder.path / "a.ppm") ==
          std::string{"P6\n2 2\n255\n\xff\0\0\0\xff\0\0\0\xff\xff\xff\xff", 11 + 12});
    CHECK(folder.entries() == 1);
}

TEST_CASE("a file that cannot be written is an error and leaves nothing")
{
    Folder folder;
    auto const image = numbered(2, 2);
    auto const nowhere = folder.path / "nowhere" / "a.pfm";
    auto text = error_of([&] { report::write_pfm(nowhere, image); });
    CHECK(well_formed(text));
    CHECK(text.find(nowhere.string()) != std::string::npos);
    text = error_of([&] { report::write_ppm(nowhere, image); });
    CHECK(well_formed(text));
    CHECK(text.find(nowhere.string()) != std::string::npos);
    CHECK(folder.entries() == 0);

    // The rename is refused: a folder that is not empty has the name.
    fs::create_directories(folder.path / "taken" / "inside");
    CHECK(well_formed(error_of([&] { report::write_pfm(folder.path / "taken", image); })));
    CHECK(folder.entries() == 1);

    CHECK(well_formed(error_of([&] { report::write_pfm(folder.path / "c", report::Image{}); })));
    auto bent = image;
    bent.rgb.pop_back();
    CHECK(well_formed(error_of([&] { report::write_pfm(folder.path / "c", bent); })));
    CHECK(well_formed(error_of([&] { report::write_ppm(folder.path / "c", bent); })));
    CHECK(folder.entries() == 1);
}

#if defined(__linux__)
TEST_CASE("a full disk is an error, and what had the name stays")
{
    // A limit on the size of files plays the full disk: writes fail in the same places.
    Folder folder;
    auto const path = folder.path / "a.pfm";
    rlimit before{};
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
    auto const handler = std::signal(SIGXFSZ, SIG_IGN);
    // Small enough to fail at the flush, and large enough to fail at a write.
    for (std::uint32_t width : {10u, 40'000u}) {
        CAPTURE(width);
        put(path, "the old file");
        rlimit const full{100, before.rlim_max};
        REQUIRE(setrlimit(RLIMIT_FSIZE, &full) == 0);
        auto const text = error_of([&] { report::write_pfm(path, numbered(width, 1)); });
        REQUIRE(setrlimit(RLIMIT_FSIZE, &before) == 0);
        CHECK(well_formed(text));
        CHECK(text.find("File too large") != std::string::npos);
        CHECK(bytes_of(path) == "the old file");
        CHECK(folder.entries() == 1);
    }
    std::signal(SIGXFSZ, handler);
}
#endif

TEST_CASE("a plane is a grey PFM, the last row first; one that is not whole is refused")
{
    Folder folder;
    auto const path = folder.path / "depth.pfm";
    report::Plane plane(2, 2);
    plane.values = {1.0f, 2.0f, 3.0f, -0.0f};
    report::write_pfm(path, plane);
    CHECK(bytes_of(path) == std::string("Pf\n2 2\n-1.0\n\0\0\x40\x40\0\0\0\x80\0\0\x80\x3f\0\0\0\x40", 28));
    plane.values.pop_back();
    CHECK(well_formed(error_of([&] { report::write_pfm(path, plane); })));
    CHECK(well_formed(error_of([&] { report::write_pfm(path, report::Plane{}); })));
}

TEST_CASE("a damaged PFM is refused")
{
    Folder folder;
    auto const path = folder.path / "a.pfm";
    report::write_pfm(path, numbered(5, 4));
    auto const whole = bytes_of(path);
    auto const refused = [&](std::string const& bytes) {
        put(path, bytes);
        auto const text = error_of([&] { (void)report::read_pfm(path); });
        return well_formed(text) && text.find(path.string()) != std::string::npos;
    };
    CHECK_FALSE(refused(whole));

    // Cut anywhere, or with one byte too many.
    std::size_t accepted = 0;
    for (std::size_t length = 0; length < whole.size(); ++length)
        accepted += refused(whole.substr(0, length)) ? 0 : 1;
    CHECK(accepted == 0);
    CHECK(refused(whole + '\0'));

    auto const body = whole.substr(whole.size() - 240);
    CHECK_FALSE(refused("PF\n5 4\n-1\n" + body));
    CHECK(refused("PF\n6 4\n-1\n" + body));
    CHECK(refused("PF\n4 6\n-1\n" + body)); // 24 pixels
    CHECK(refused("PF\n9 2\n-1\n" + body)); // 18 pixels, and 20 / 9 = 2
    CHECK(refused("PF\n0 4\n-1\n" + body));
    CHECK(refused("PF\n0 0\n-1\n"));
    CHECK(refused("PF\n-5 -4\n-1\n" + body));
    CHECK(refused("PF\n5 4\n2\n" + body));
    CHECK(refused("PF\n5 4\n0\n" + body));
    CHECK(refused("PF\n5 4\nnan\n" + body));
    CHECK(refused("PF\n5 4\n-1x" + body));
    CHECK(refused("PF\n5 four\n-1\n" + body));
    CHECK(refused("Pf\n5 12\n-1\n" + body));
    CHECK(refused("P6\n5 4\n255\n" + body));
    CHECK(refused(""));
}

TEST_CASE("an absurd size is refused before anything is allocated")
{
    Folder folder;
    auto const path = folder.path / "a.pfm";
    for (auto const* const size : {"4294967295 4294967295", "4294967296 1", "1 4294967296",
                                   "1000000 1000000", "99999999999999999999 1",
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
    Folder folder;
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
