// test: optimised, cost 5
// Pictures from files, as example programs read them: damage is found before a decoder sees it.
#include "../../examples/shared/checksums.hpp"
#include "../../examples/shared/depth_bytes.hpp"
#include "../../examples/shared/picture_check.cpp"
#include "folder.hpp"
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/pose.hpp>
#if __has_include(<stb/stb_image.h>) || __has_include(<stb_image.h>)
#    include "../../examples/shared/picture_input.cpp"
#    define TILEMESH_TEST_HAS_STB
#endif

namespace {

// Written by Python's zlib: codes of its own and two chunks of pixels, fixed codes, and stored blocks.
constexpr char const* own_codes =
    "iVBORw0KGgoAAAANSUhEUgAAABgAAAAQCAIAAACDRijCAAABCElEQVR42kWUS5YDMQgDwSy4/624FamiF+mZvI5tPkKSkxEvZqYzJrpjXkZFxEZnx+bMZmXOi15Da3vzvVlCk/jaiuFks2s"
    "o8drvkcvGVs1bE13F1Ob2VBdrgjPMezQzL/lSLpIUGtQM/bqag2d6Rhtp/52kbDV4kg/h0U/MOQe8IjuHhLcT5RFbVwlMy0RxD4PUvqqiu4lFB3r4IuQVQMbqhrOfgAhhw9O+BaJlOa8RS5"
    "RT7DAEhZMjiI1K2tP8sZYX/oG98eUxIvzdyrR3nJTNZRu8Y6dhCkh786ET0WsBXTpkJJXgf0VqPQR66sKqJRFtQYgM/D0JO+0QD46kiaj30AvZxraSekVgheG5dODAAAABB0lEQVRk82RSr"
    "K0nicAYRl1V704hY5ZlWA2DCA3ikfGTJszijIq4RVPEhw8yab2McLVJ1maokqIa3qA5F+TZRK/hJGcS07nOh0GO+jjpxZypS3HuWe2y+imhYu6hmjPN+Vp/qR9EgYd4+NrP7Sk9x1pcOnqU"
    "Mqw3ZiTl1VXwZWjr/iJ39CuPPqUeFuiTb0FShfmuuQaEmKnDttxAdhp77cbffZrjGZ7eNaQDJSp6qeYkBuqclM5rJG0W9zAHxdiYU5/zPkVgAH2KtmhSd7luAMhv7t1ARR+xeT8RF+DFWGc"
    "4x9xlUCQs2KopCnXWAvNZmsa573g/h63MA4feXHHvz/164BhNXPEDpCz8D2ngoqoAAAAASUVORK5CYII=";
constexpr char const* fixed_codes =
    "iVBORw0KGgoAAAANSUhEUgAAAAgAAAAECAAAAACWpiEsAAAAJElEQVR4AWNggANOIWkVXTN7BgYhFTOPqJw6BgZps8Cc9kV7ATVMBenHOvokAAAAAElFTkSuQmCC";
constexpr char const* stored_blocks =
    "iVBORw0KGgoAAAANSUhEUgAAAAgAAAAECAYAAACzzX7wAAAAj0lEQVR4AQGEAHv/AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAJEhskLTY/SFFaY2x1foeQmaKrtL3Gz9j"
    "h6vP8BQ4XAAASJDZIWmx+kKK0xtjq/A4gMkRWaHqMnrDC1Ob4ChwuAAAbNlFsh6K92PMOKURfepWwy+YBHDdSbYijvtn0DypFIJwrobwxt1sAAAAASUVORK5CYII=";
// Written by Pillow: grey of 16 bits, RGB with a transparent colour; a baseline and a progressive JPEG.
constexpr char const* grey_16 =
    "iVBORw0KGgoAAAANSUhEUgAAABAAAAAMEAAAAAAeHL4eAAAAMElEQVR42mNkYOdfILCAf4EAColgMTFw4YfEKmBEE2Yk2QQiFWCziCpW4PYBdXwBADLaEU+bU34lAAAAAElFTkSuQmCC";
constexpr char const* colour_key =
    "iVBORw0KGgoAAAANSUhEUgAAABAAAAAMCAIAAADkharWAAAABnRSTlMAyABkADIwypb3AAAAGklEQVR42mM4kWKEFRmnzcSKGEY1jGrArgEAbuH2AYy9DzkAAAAASUVORK5CYII=";
constexpr char const* baseline =
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAMCAgMCAgMDAwMEAwMEBQgFBQQEBQoHBwYIDAoMDAsKCwsNDhIQDQ4RDgsLEBYQERMUFRUVDA8XGBYUGBIUFRT/2wBDAQMEBAUEBQkFBQkUDQs"
    "NFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBT/wAARCAAMABADAREAAhEBAxEB/8QAFQABAQAAAAAAAAAAAAAAAAAABwj/xAAbEAACAQUAAAAAAA"
    "AAAAAAAAAABiMEByIyof/EABgBAAIDAAAAAAAAAAAAAAAAAAUHBAYI/8QAGhEAAgMBAQAAAAAAAAAAAAAAAAMEBSECMf/aAAwDAQACEQMRAD8AnVYtTpDwkqkgSmv/ADRbWLUaQ8Ci5A9aa"
    "/8ANFBZXKHGIo6mdGEKaY7NFtYXKHCILKZ0PWmmOzT/2Q==";
constexpr char const* progressive =
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAMCAgMCAgMDAwMEAwMEBQgFBQQEBQoHBwYIDAoMDAsKCwsNDhIQDQ4RDgsLEBYQERMUFRUVDA8XGBYUGBIUFRT/2wBDAQMEBAUEBQkFBQkUDQs"
    "NFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBT/wgARCAAMABADASIAAhEBAxEB/8QAFQABAQAAAAAAAAAAAAAAAAAABgf/xAAVAQEBAAAAAAAAAA"
    "AAAAAAAAABBP/aAAwDAQACEAMQAAABnS1QuYf/xAAXEAEBAQEAAAAAAAAAAAAAAAAEAAIF/9oACAEBAAEFAjcqNyox8Rj4v//EABcRAAMBAAAAAAAAAAAAAAAAAAADBSH/2gAIAQMBAT8Bj"
    "WGYf//EABYRAQEBAAAAAAAAAAAAAAAAAAMAAf/aAAgBAgEBPwE32//EABUQAQEAAAAAAAAAAAAAAAAAAAAx/9oACAEBAAY/AoiI/8QAFhABAQEAAAAAAAAAAAAAAAAAACEx/9oACAEBAAE/"
    "Ic3NnJz/2gAMAwEAAgADAAAAEGf/xAAVEQEBAAAAAAAAAAAAAAAAAAAAUf/aAAgBAwEBPxCk/8QAFREBAQAAAAAAAAAAAAAAAAAAACH/2gAIAQIBAT8Qkf/EABYQAQEBAAAAAAAAAAAAAAA"
    "AAPEAEP/aAAgBAQABPxAqO1O//9k=";

// Written by cjpeg: colour at half the size, a restart after each unit; and a progressive one with restarts.
constexpr char const* restarts =
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDABQODxIPDRQSEBIXFRQYHjIhHhwcHj0sLiQySUBMS0dARkVQWnNiUFVtVkVGZIhlbXd7gYKBTmCNl4x9lnN+gXz/2wBDARUXFx4aHjshITt8U0Z"
    "TfHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHz/wAARCAAYACgDASIAAhEBAxEB/8QAGAABAQEBAQAAAAAAAAAAAAAAAAMEBQb/xAAgEAABBAIDAA"
    "MAAAAAAAAAAAAAAQIDIRExIkFxUZGh/8QAFwEAAwEAAAAAAAAAAAAAAAAAAwQFAf/EAB4RAAICAgIDAAAAAAAAAAAAAAABAgMRITFBE1Fx/90ABAAB/9oADAMBAAIRAxEAPwDzLYERukzgs"
    "2BuqNrIeNJ18F2wpjVeGu1Y64A1Xn//0OK2BtUhZsDcpSG1sOqrws2G0r8BytXtDtV5/9HCyBudIDpthvS/QF/L8Lkb9H//0jYOOuiyQ1pcACDk8c9ESqbP/9PY2C0pSzYLSlAJkm97Fqps"
    "/9TsMgvQAIzlJdh4zeD/2Q==";
constexpr char const* progressive_restarts =
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDABQODxIPDRQSEBIXFRQYHjIhHhwcHj0sLiQySUBMS0dARkVQWnNiUFVtVkVGZIhlbXd7gYKBTmCNl4x9lnN+gXz/2wBDARUXFx4aHjshITt8U0Z"
    "TfHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHz/wgARCAAYACgDASIAAhEBAxEB/8QAGAABAQEBAQAAAAAAAAAAAAAAAAIDBAX/xAAYAQADAQEAAA"
    "AAAAAAAAAAAAACAwQABf/dAAQAAv/aAAwDAQACEAMQAAAB8y9tMGF7WNP/0MHSXdNi+H//0drJVWAo/8QAFRABAQAAAAAAAAAAAAAAAAAAABH/2gAIAQEAAQUCiP/QiP/RiP/SiP/TiP/Ui"
    "P/ViP/Wj//EABYRAQEBAAAAAAAAAAAAAAAAAAIAAf/aAAgBAwEBPwEuLv/Qxx2//9E7Zt//xAAYEQEAAwEAAAAAAAAAAAAAAAAAARESAv/aAAgBAgEBPwHSen//0NLf/9GVy//EABUQAQEA"
    "AAAAAAAAAAAAAAAAABAA/9oACAEBAAY/Aj//0D//0T//0j//0z//1D//1T//1r//xAAXEAEBAQEAAAAAAAAAAAAAAAABACEQ/9oACAEBAAE/ITMG/9AMG//RDGb/0il//9Mpf//UM8//1Sl"
    "//9Yv/9oADAMBAAIAAwAAABAo3//QMD//0Qw//8QAGBEBAQADAAAAAAAAAAAAAAAAAAEQESH/2gAIAQMBAT8Qx/8A/9Diu//Rurp//8QAGxEAAgIDAQAAAAAAAAAAAAAAAAERQSExUYH/2g"
    "AIAQIBAT8QaxWhPUf/0PI2jdH/0WecjRZ//8QAHRAAAwACAwEBAAAAAAAAAAAAAAEhETFBUXGRof/aAAgBAQABPxBK0WcGlD//0IojKUR//9HO0jiLjo//0kY1PDRJ4f/Top+FNP4f/9Tpc"
    "CjTwf/VqoyqjP/Wvo//2Q==";

std::string decoded(std::string_view base64)
{
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    std::uint32_t bits = 0;
    int count = 0;
    for (char const c : base64) {
        if (c == '=') break;
        bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
        count += 6;
        if (count >= 8) bytes.push_back(static_cast<char>(bits >> (count -= 8) & 0xffu));
    }
    return bytes;
}
std::string word(std::uint32_t value)
{
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(value >> shift & 0xffu));
    return bytes;
}
/// A chunk of a PNG with the right checksum.
std::string chunk(std::string const& name, std::string const& content)
{
    return word(static_cast<std::uint32_t>(content.size())) + name + content + word(shared::crc32(name + content));
}
std::string flipped(std::string bytes, std::size_t byte, unsigned bit)
{
    bytes[byte] = static_cast<char>(static_cast<unsigned char>(bytes[byte]) ^ 1u << bit);
    return bytes;
}
std::string damage(std::string const& file, std::size_t most = 1u << 20)
{
    return std::string(shared::picture_damage({reinterpret_cast<unsigned char const*>(file.data()), file.size()}, most));
}
/// A segment DHT of one table, with these numbers of codes of 1 to 16 bits.
std::string huffman_table(std::array<unsigned char, 16> const& counts)
{
    std::size_t codes = 0;
    std::string segment("\0", 1);
    for (auto const count : counts) {
        segment.push_back(static_cast<char>(count));
        codes += count;
    }
    segment.append(codes, '\1');
    auto const length = segment.size() + 2;
    return std::string("\xff\xc4") + static_cast<char>(length >> 8) + static_cast<char>(length & 0xffu) + segment;
}
constexpr std::array<unsigned char, 16> many_codes{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 255};   // 257: there is room for them
constexpr std::array<unsigned char, 16> no_room{3};                                                      // of three codes of one bit
constexpr std::array<unsigned char, 16> no_room_later{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 3};
constexpr std::array<unsigned char, 16> all_codes{0, 0, 0, 0, 0, 0, 0, 255, 1};                          // 256, which may be

/// A JPEG without its n-th segment of a kind.
std::string without_segment(std::string const& file, char marker, std::size_t n)
{
    for (std::size_t at = 2; at + 4 < file.size();) {
        auto const length = 2 + (std::size_t{static_cast<unsigned char>(file[at + 2])} << 8 | static_cast<unsigned char>(file[at + 3]));
        if (file[at + 1] == marker && n-- == 0) return file.substr(0, at) + file.substr(at + length);
        if (file[at + 1] == '\xda') break;
        at += length;
    }
    return {};
}

char const* const all_png[] = {own_codes, fixed_codes, stored_blocks, grey_16, colour_key};
char const* const all_jpeg[] = {baseline, progressive, restarts, progressive_restarts};

TEST_CASE("depths with swapped bytes are found; right, noisy, constant, small and coarse ones are none")
{
    constexpr std::size_t width = 64, height = 48;
    unsigned state = 1;
    auto const random = [&] { return (state = state * 1664525u + 1013904223u) >> 8; };
    auto const is_swapped = [&](auto const& level) {
        std::vector<std::uint16_t> right, swapped;
        for (std::size_t i = 0; i < width * height; ++i) {
            right.push_back(static_cast<std::uint16_t>(level(static_cast<double>(i % width), static_cast<double>(i / width))));
            swapped.push_back(static_cast<std::uint16_t>(right.back() << 8 | right.back() >> 8));
        }
        return std::pair{shared::has_swapped_bytes(right, width), shared::has_swapped_bytes(swapped, width)};
    };
    auto const wall = [](double x, double y) { return 9000 + 37 * x + 21 * y; };
    auto const room = [&](double x, double y) { return std::fmod(x, 9) < 2 ? 0 : std::fmod(y, 16) < 8 ? wall(x, y) : 30000 - 90 * x; };
    CHECK(is_swapped(wall) == std::pair{false, true});
    CHECK(is_swapped(room) == std::pair{false, true});                                                            // holes and edges
    CHECK(is_swapped([&](double x, double y) { return wall(x, y) + random() % 200; }) == std::pair{false, true}); // a noisy sensor
    CHECK(is_swapped([](double x, double y) { return 700 + 2 * x + 3 * y; }) == std::pair{false, true});          // 1,000 levels a metre
    auto const neither = std::pair{false, false};
    CHECK(is_swapped([&](double, double) { return random() % 65536; }) == neither);
    CHECK(is_swapped([](double, double) { return 10000; }) == neither);
    CHECK(is_swapped([](double, double) { return 0; }) == neither);
    CHECK(is_swapped([](double x, double y) { return x + y; }) == neither);                                   // below 256 levels
    CHECK(is_swapped([&](double x, double y) { return 256 * std::floor(wall(x, y) / 256); }) == neither);     // 8 bits
    CHECK(is_swapped([&](double x, double y) { return 257 * std::floor(wall(x, y) / 256); }) == neither);     // 8 bits twice
    CHECK(is_swapped([&](double x, double) { return x < 32 ? 200 + 3 * x : 65000 - 5 * x; }).first == false); // a far background
    CHECK(shared::has_swapped_bytes({}, 0) == false);
}

TEST_CASE("a whole picture has no damage; one that is cut short has, at every length")
{
    for (char const* const base64 : all_png) {
        auto const file = decoded(base64);
        CHECK(damage(file) == "");
        CHECK(damage(file + "more") == "");
        for (std::size_t size = 8; size < file.size(); ++size) CHECK(damage(file.substr(0, size)) == "the file is cut short");
    }
    for (char const* const base64 : all_jpeg) {
        auto const file = decoded(base64);
        CHECK(damage(file) == "");
        CHECK(damage("\xff\xff" + file) == "");
        for (std::size_t size = 2; size < file.size(); ++size) CHECK(damage(file.substr(0, size)) == "the file is cut short");
    }
    CHECK(damage("neither") == "");
    CHECK(damage("") == "");
}

TEST_CASE("a PNG whose chunks are right but whose pixels are damaged is refused")
{
    std::string const signature("\x89PNG\r\n\x1a\n", 8), header = chunk("IHDR", std::string("\0\0\0\1\0\0\0\1\10\0\0\0\0", 13)), end = chunk("IEND", "");
    auto const png = [&](std::string const& packed) { return signature + header + chunk("IDAT", packed) + end; };
    // Stored: a row of the filter 0 and the level 7. Adler-32: a = 1 + 0 + 7 = 8, b = 1 + 8 = 9.
    std::string const good("\x78\x01\1\2\0\xfd\xff\0\7\0\x9\0\x8", 13);
    CHECK(damage(png(good)) == "");
    CHECK(damage(png(good + "more")) == "");
    CHECK(damage(png(good.substr(0, good.size() - 1))) == "its compressed pixels end early");
    for (std::size_t byte = 0; byte < good.size(); ++byte)
        for (unsigned bit = 0; bit < 8; ++bit) {
            if (byte == 2 && bit >= 3) continue; // padding behind the kind of the block, which no checksum covers
            CHECK_MESSAGE(damage(png(flipped(good, byte, bit))) != "", byte, " ", bit);
        }
    CHECK(damage(png("")) == "its compressed pixels end early");
    CHECK(damage(signature + header + end) == "its compressed pixels end early");
    CHECK(damage(png(good), 2) == "");
    CHECK(damage(png(good), 1) == "it unpacks to more than its pixels");
    // Apple's form has no checksum of its pixels, but chunks have theirs.
    CHECK(damage(signature + chunk("CgBI", "\x50\0\x20\6") + header + chunk("IDAT", "any") + end) == "");
}

TEST_CASE("a JPEG without a table that it needs is refused")
{
    auto const file = decoded(baseline);
    for (std::size_t n = 0; n < 4; ++n) { // two tables for DC, two for AC
        REQUIRE(!without_segment(file, '\xc4', n).empty());
        CHECK(damage(without_segment(file, '\xc4', n)) == "a table that its pixels need is missing");
    }
    CHECK(without_segment(file, '\xc4', 4).empty());
    for (char const* const base64 : all_jpeg)
        for (std::size_t n = 0; n < 2; ++n) CHECK(damage(without_segment(decoded(base64), '\xdb', n)) == "a table that its pixels need is missing");
    CHECK(damage(without_segment(decoded(progressive), '\xc4', 0)) == "a table that its pixels need is missing");
}

TEST_CASE("a JPEG whose blocks end before or behind their data is refused")
{
    std::string const damaged = "its compressed pixels are damaged";
    for (char const* const base64 : all_jpeg) {
        auto const file = decoded(base64);
        // The data of the first scan: from behind its header to the next marker.
        auto const scan = file.find("\xff\xda");
        REQUIRE(scan != file.npos);
        auto const begin = scan + 2 + static_cast<unsigned char>(file[scan + 3]);
        auto end = begin;
        while (file[end] != '\xff' || file[end + 1] == '\0') ++end;
        REQUIRE(end > begin);
        CHECK(damage(file.substr(0, end) + "x" + file.substr(end)) == damaged);
        CHECK(damage(file.substr(0, end - 1) + file.substr(end)) == damaged);
        CHECK(damage(file.substr(0, begin) + file.substr(end)) == damaged);
        // Markers of restarts count from 0 to 7.
        if (auto const restart = file.find("\xff\xd1"); base64 == restarts || base64 == progressive_restarts) {
            REQUIRE(restart != file.npos);
            for (unsigned bit = 0; bit < 3; ++bit) CHECK(damage(flipped(file, restart + 1, bit)) == damaged);
            CHECK(damage(file.substr(0, restart) + file.substr(restart + 2)) == damaged);
            CHECK(damage(file.substr(0, restart) + "\xff" + file.substr(restart)) == ""); // a fill byte
        }
        // A picture of another size.
        auto const frame = std::min(file.find("\xff\xc0"), file.find("\xff\xc2"));
        REQUIRE(frame != file.npos);
        for (auto const& changed : {std::pair{5u, 0u}, {6u, 4u}, {7u, 0u}, {8u, 5u}})
            CHECK_MESSAGE(damage(flipped(file, frame + changed.first, changed.second)) != "", changed.first);
        CHECK(damage(file.substr(0, scan) + "\xff\xd9") == "a part of its pixels is missing");
    }
}

TEST_CASE("a JPEG with an impossible Huffman table is refused, also before the size of the picture")
{
    for (char const* const base64 : all_jpeg) {
        auto const file = decoded(base64);
        auto const with_table = [&](auto const& counts, std::size_t at) { return file.substr(0, at) + huffman_table(counts) + file.substr(at); };
        auto const scan = file.find("\xff\xda"); // the beginning of the first scan
        REQUIRE(scan != file.npos);
        for (auto const& counts : {many_codes, no_room, no_room_later})
            for (std::size_t const at : {std::size_t{2}, scan, file.size() - 2})
                for (char const* const before : {"", "\xff"})
                    CHECK(damage(before + with_table(counts, at)) == "a Huffman table has more codes than there can be");
        CHECK(damage(with_table(all_codes, 2)) == "");
        CHECK(damage(with_table(std::array<unsigned char, 16>{}, 2)) == "");
    }
}

#ifdef TILEMESH_TEST_HAS_STB
/// A file of one picture after the other.
class PictureFile {
public:
    /// The picture as a program reads it; nothing if it is refused, and `why` says why.
    std::optional<tilemesh::report::Image> read(std::string const& bytes)
    {
        tests::put(path_, bytes);
        return read_again();
    }
    /// The last picture with one bit changed.
    std::optional<tilemesh::report::Image> read_flipped(std::string const& bytes, std::size_t byte, unsigned bit)
    {
        std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
        auto const put = [&](char value) { file.seekp(static_cast<std::streamoff>(byte)).put(value).flush(); };
        put(flipped(bytes, byte, bit)[byte]);
        auto picture = read_again();
        put(bytes[byte]);
        return picture;
    }
    shared::PictureFacts facts(std::string const& bytes)
    {
        tests::put(path_, bytes);
        return shared::picture_facts(path_);
    }
    std::string why;

private:
    std::optional<tilemesh::report::Image> read_again()
    {
        std::optional<tilemesh::report::Image> picture;
        why = tests::error_of([&] { picture = shared::read_picture(path_, shared::picture_size(path_), {0.25f, 0.5f, 0.75f}); });
        return picture;
    }
    tests::Folder folder_;
    std::filesystem::path path_ = folder_.path / "picture";
};

TEST_CASE("a flip of any bit in a PNG is refused or changes no pixel")
{
    PictureFile file;
    for (char const* const base64 : all_png) {
        auto const bytes = decoded(base64) + "behind the end";
        auto const whole = file.read(bytes);
        REQUIRE(whole);
        std::size_t refused = 0;
        for (std::size_t byte = 0; byte < bytes.size(); ++byte)
            for (unsigned bit = 0; bit < 8; ++bit) {
                auto const read = file.read_flipped(bytes, byte, bit);
                refused += read ? 0 : 1;
                if (read) CHECK_MESSAGE((read->width == whole->width && read->rgb == whole->rgb), byte, " ", bit);
            }
        CHECK(refused == 8 * (bytes.size() - 14)); // every flip before the end is found
    }
}

TEST_CASE("a flip of any bit in a JPEG is refused or gives a picture of values from 0 to 1")
{
    PictureFile file;
    for (char const* const base64 : all_jpeg) {
        auto const bytes = decoded(base64);
        auto const whole = file.read(bytes);
        REQUIRE(whole);
        std::size_t refused = 0;
        for (std::size_t byte = 0; byte < bytes.size(); ++byte)
            for (unsigned bit = 0; bit < 8; ++bit) {
                auto const read = file.read_flipped(bytes, byte, bit);
                refused += read ? 0 : 1;
                if (!read) continue;
                CHECK(std::all_of(read->rgb.begin(), read->rgb.end(), [](float value) { return value >= 0.0f && value <= 1.0f; }));
                auto const again = file.read_flipped(bytes, byte, bit); // nothing depends on memory that was not written
                CHECK((again && again->rgb == read->rgb));
            }
        CHECK(100 * refused > 45 * 8 * bytes.size()); // the rest are values: a JPEG has no checksum
    }
}

TEST_CASE("no decoder sees an impossible Huffman table")
{
    PictureFile file;
    for (char const* const base64 : all_jpeg) {
        auto const bytes = decoded(base64);
        for (auto const& counts : {many_codes, no_room, no_room_later}) {
            CHECK(!file.read(bytes.substr(0, 2) + huffman_table(counts) + bytes.substr(2)));
            CHECK(tests::has(file.why, "a Huffman table has more codes than there can be"));
        }
        CHECK(file.read(bytes.substr(0, 2) + huffman_table(all_codes) + bytes.substr(2)));
    }
}

TEST_CASE("an error says what is wrong with a file that is no whole picture")
{
    PictureFile file;
    auto const says = [&](std::string const& bytes, char const* text) {
        CHECK(!file.read(bytes));
        CHECK_MESSAGE(file.why.find(text) != std::string::npos, file.why);
    };
    says("", "it is neither PNG nor JPEG");
    says("text", "it is neither PNG nor JPEG");
    auto const png = decoded(fixed_codes), jpeg = decoded(baseline);
    says(png.substr(0, 20), "the file is cut short");
    says(png.substr(0, 40), "the file is cut short");
    says(flipped(png, 0, 0), "its signature is damaged");
    says(flipped(png, 19, 1), "its header is damaged");
    says(flipped(png, 45, 1), "the checksum of a chunk is wrong");
    says(jpeg.substr(0, 20), "its header cannot be read");
    says(jpeg.substr(0, jpeg.size() - 2), "the file is cut short");
    // A PNG that nobody can decode is a PNG: of each kind of pixels, too wide, too high, too many pixels, none.
    auto const of_size = [&](std::uint32_t width, std::uint32_t height, std::string const& kind) {
        return std::string("\x89PNG\r\n\x1a\n", 8) + chunk("IHDR", word(width) + word(height) + kind) + chunk("IDAT", "") + chunk("IEND", "");
    };
    for (auto const& kind : {std::string("\20\6\0\0\0", 5), std::string("\10\2\0\0\0", 5), std::string("\10\0\0\0\0", 5)})
        for (auto const& [width, height] : {std::pair{65535u, 65535u}, {100000u, 2u}, {2u, 2147483647u}, {40000u, 40000u}}) {
            says(of_size(width, height, kind), "is too large to be read (it has ");
            CHECK(file.why.find(std::to_string(width) + " x " + std::to_string(height) + " pixels; ") != std::string::npos);
            CHECK(file.why.ends_with("; write it smaller"));
        }
    says(of_size(0, 5, std::string("\10\2\0\0\0", 5)), "is of no picture: 0 x 5 pixels");
    // A JPEG says its size, and is refused for what follows.
    auto huge = jpeg;
    auto const frame = huge.find("\xff\xc0");
    REQUIRE(frame != huge.npos);
    for (std::size_t i = 5; i < 9; ++i) huge[frame + i] = '\xff';
    CHECK(!file.read(huge));
    CHECK(file.why.find("neither") == std::string::npos);
}

TEST_CASE("an orientation and an alpha channel are found in a header, whole or cut")
{
    PictureFile file;
    auto const jpeg = decoded(baseline), png = decoded(fixed_codes);
    auto const exif = [](bool little, int value) {
        auto const n = [little](unsigned v, unsigned count) {
            std::string out;
            for (unsigned i = 0; i < count; ++i) out += static_cast<char>(v >> 8 * (little ? i : count - 1 - i));
            return out;
        };
        return (little ? "II" : "MM") + n(42, 2) + n(8, 4) + n(2, 2) + n(0x100, 2) + n(4, 2) + n(1, 4) + n(6, 4) + n(0x112, 2) + n(3, 2) + n(1, 4) +
               n(static_cast<unsigned>(value), 2) + n(0, 2);
    };
    auto const in_jpeg = [&](std::string const& data) {
        auto const all = std::string("Exif\0\0", 6) + data;
        auto const head = std::string("\xff\xe0\0\4ab", 6) + "\xff\xe1" + static_cast<char>((all.size() + 2) >> 8) + static_cast<char>(all.size() + 2);
        return jpeg.substr(0, 2) + head + all + jpeg.substr(2);
    };
    auto const in_png = [&](std::string const& data) { return png.substr(0, 33) + chunk("eXIf", data) + png.substr(33); };
    for (bool const little : {true, false})
        for (int value = 0; value < 12; ++value) {
            CHECK(file.facts(in_jpeg(exif(little, value))).turned == (value > 1 && value <= 8));
            CHECK(file.facts(in_png(exif(little, value))).turned == (value > 1 && value <= 8));
        }
    CHECK(file.read(in_jpeg(exif(true, 6)))); // as it is stored
    auto const whole = in_jpeg(exif(true, 6));
    for (std::size_t n = 0; n < 100; ++n) CHECK(file.facts(whole.substr(0, n)).turned == (n >= whole.find("\x12\x01") + 12));
    for (auto const& bytes : {jpeg, png, in_jpeg(""), in_png(""), in_jpeg("II"), std::string()}) CHECK(!file.facts(bytes).turned);
    CHECK(!shared::picture_facts("/nowhere/at/all").turned);
    CHECK(file.facts(decoded(colour_key)).transparent);
    CHECK(!file.facts(decoded(own_codes)).transparent);
}
#else
TEST_CASE("pictures from files")
{
    MESSAGE("skipped: there is no stb_image.h");
}
#endif

} // namespace
