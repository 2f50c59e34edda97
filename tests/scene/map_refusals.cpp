// test: unoptimised test asan tsan
#include "map_writers.hpp"
#include "real_packing.hpp"
#include "support.hpp"
#include <tilemesh/scene/map_file.hpp>

using namespace scene_test;
using tilemesh::scene::Codecs;
using tilemesh::scene::Map;

namespace {

Map read(Bytes const& bytes, Codecs const& codecs = plain_codecs())
{
    std::istringstream stream(bytes);
    return tilemesh::scene::read_map(stream, "test.splat", codecs);
}
std::string refusal(Bytes const& bytes, Codecs const& codecs = plain_codecs())
{
    return error_of([&] { read(bytes, codecs); });
}

/// With a number of n bytes in place of those at `at`.
Bytes changed(Bytes bytes, std::size_t at, std::uint64_t value, std::size_t n)
{
    Bytes number;
    put_little(number, value, n);
    return bytes.replace(at, n, number);
}

bool finite(Map const& map)
{
    bool all = true;
    for (auto const& g : map.gaussians) {
        for (float v : g.mean_world) all = all && std::isfinite(v);
        for (float v : g.colour) all = all && std::isfinite(v);
        for (float v : g.log_scale) all = all && std::isfinite(v) && v >= -87.0f;
        float squares = 0;
        for (float v : g.rotation) squares += v * v;
        all = all && std::fabs(squares - 1.0f) < 1e-5f && g.opacity >= 0.0f && g.opacity <= 1.0f;
    }
    for (float v : map.harmonics) all = all && std::isfinite(v);
    return all && map.harmonics.size() == map.gaussians.size() * 3 * map.sh_degree * (map.sh_degree + 2);
}

struct Sample {
    std::string name;
    Bytes bytes;
    bool cut_is_whole = false; ///< a .splat that is cut between rows is a .splat
};

std::vector<Sample> samples(Packing const& packing)
{
    Numbers numbers(7);
    std::vector<Sample> out{{"compressed PLY", PackedPly::random(3, 1, true, numbers).bytes(), false}, {".splat", PackedSplat::random(3, numbers).bytes(), true}};
    for (std::uint32_t version = 1; version <= 4; ++version) {
        auto const packed = PackedSpz::random(3, version, version == 4 ? 1 : 0, numbers);
        out.push_back({"SPZ " + std::to_string(version), packed.bytes(packing), false});
        if (version < 4) out.push_back({"SPZ " + std::to_string(version) + " not compressed", packed.plain(), false});
    }
    for (std::uint32_t version = 1; version <= 2; ++version)
        out.push_back({"SOG " + std::to_string(version), write_zip(PackedSog::random(3, version, 1, numbers).files(packing), packing, version == 1), false});
    return out;
}

} // namespace

TEST_CASE("a compressed map that is cut anywhere is refused")
{
    for (bool real : {false, true}) {
        Packing const packing = real ? real_packing() : Packing{};
        for (auto const& [format, bytes, cut_is_whole] : samples(packing)) {
            auto const& name = format; // Clang 14 captures no structured binding
            CAPTURE(name);
            CHECK(finite(read(bytes, packing.codecs)));
            // Archives are long, and most of their bytes are alike.
            std::size_t const step = bytes.size() < 2000 ? 1 : fast() ? 37 : 7;
            std::size_t wrong = 0;
            for (std::size_t n = 0; n < bytes.size(); n += step) wrong += refusal(bytes.substr(0, n), packing.codecs).empty() != (cut_is_whole && n % 32 == 0 && n != 0);
            CHECK(wrong == 0);
        }
    }
}

TEST_CASE("a compressed map with any changed byte is refused or finite")
{
    constexpr int changes[] = {1, 0x80, 0xff}; // the short form makes one change of each byte
    for (bool real : {false, true}) {
        Packing const packing = real ? real_packing() : Packing{};
        for (auto const& [format, bytes, ignored] : samples(packing)) {
            auto const& name = format;
            CAPTURE(name);
            std::size_t broken = 0, refused = 0;
            for (std::size_t at = 0; at < bytes.size(); at += bytes.size() < 2000 ? 1 : fast() ? 31 : 5)
                for (int change : changes) {
                    if (fast() && change != changes[at % 3]) continue;
                    bool whole = true;
                    auto const other = changed(bytes, at, static_cast<unsigned char>(bytes[at] ^ change), 1);
                    refused += error_of([&] { whole = finite(read(other, packing.codecs)); }).empty() ? 0 : 1;
                    broken += whole ? 0 : 1;
                }
            CHECK(broken == 0);
            CHECK((refused > 0) == (name != ".splat")); // every 32 bytes are a row
        }
    }
}

TEST_CASE("compressed PLY: headers that lie are refused")
{
    Numbers numbers(8);
    auto const packed = PackedPly::random(257, 1, true, numbers);
    Bytes const bytes = packed.bytes();
    auto const with = [&](std::string const& part, std::string const& other) { return refusal(replaced(bytes, part, other)); };
    CHECK(has(with("element chunk 2", "element chunk 1"), "257 rows are in 2 chunks of 256, and there are 1"));
    CHECK(has(with("element chunk 2", "element chunk 4294967296"), "promises 4294967296 rows"));
    CHECK(has(with("element chunk 2", "element other 2"), "no element chunk before"));
    CHECK(has(with("element vertex 257", "element vertex 18446744073709551615"), "promises 18446744073709551615 rows"));
    CHECK(has(with("element sh 257", "element sh 256"), "element \"sh\" has 256 rows for 257"));
    CHECK(has(with("property uchar f_rest_0", "property char f_rest_0"), "f_rest_0 of element \"sh\" is not of type uchar"));
    CHECK(has(with("uint packed_scale", "int packed_scale"), "no property packed_scale of type uint"));
    CHECK(has(with("float max_y", "double max_y"), "no property max_y of type float"));
    CHECK(has(with("float max_b", "float other"), "no property max_b of type float"));
    CHECK(has(with("binary_little_endian", "ascii"), "it is ASCII"));
    // Harmonics of a number of columns that no degree has are skipped.
    auto const map = read(replaced(bytes, "f_rest_8", "unused_8"));
    CHECK(map.sh_degree == 0);
    CHECK(map.gaussians.size() == 257);
    CHECK(has(map.notes[1], "element \"sh\": 257 rows skipped"));
}

TEST_CASE("SPZ: headers and tables that lie are refused before memory is set aside")
{
    Numbers numbers(9);
    Packing const packing;
    auto const packed = PackedSpz::random(3, 2, 1, numbers);
    Bytes const plain = packed.plain();
    for (bool gzipped : {false, true}) {
        auto const spz = [&](std::size_t at, std::uint64_t value, std::size_t n) {
            Bytes const bytes = changed(plain, at, value, n);
            return refusal(gzipped ? packing.gzip(bytes) : bytes);
        };
        CHECK(has(spz(4, 0, 4), "of version 0 (versions 1 to 4 are read)"));
        CHECK(has(spz(4, 5, 4), "of version 5"));
        CHECK(has(spz(8, 4, 4), "(the header promises 4 Gaussians)"));
        CHECK(has(spz(8, 0xffffffffu, 4), "promises "));
        CHECK(has(spz(12, 5, 1), "of degree 5"));
        CHECK(has(spz(13, 25, 1), "25 fractional bits (a mean has 24 bits)"));
    }
    CHECK(has(refusal(packing.gzip(changed(plain, 8, 70000, 4))), "promises 70000 Gaussians (it has "));
    CHECK(has(refusal(packing.gzip("ply\nformat")), "is not an SPZ map (what gzip compressed in it"));
    CHECK(has(refusal(packing.gzip(changed(plain, 4, 4, 4))), "of version 4 and compressed by gzip"));
    CHECK(has(refusal("NGSP"), "is not an SPZ map"));
    CHECK(has(refusal("\x1f\x8b\x08"), "is not an SPZ map"));

    auto four = packed;
    four.version = 4;
    Bytes const v4 = four.bytes(packing);
    auto const spz4 = [&](std::size_t at, std::uint64_t value, std::size_t n) { return refusal(changed(v4, at, value, n)); };
    CHECK(has(spz4(15, 5, 1), "it has 5 streams, and its Gaussians need 6"));
    CHECK(has(spz4(16, 31, 4), "its table of streams is not inside the file"));
    CHECK(has(spz4(16, 0xffffffffu, 4), "its table of streams is not inside the file"));
    CHECK(has(spz4(32, 0xffffffffffffffffu, 8), "stream 1 is cut off"));
    CHECK(has(spz4(40, 28, 8), "stream 1 has 28 bytes, and its Gaussians have 27"));
    CHECK(has(spz4(8, 70000, 4), "promises 70000 Gaussians"));
    CHECK(has(spz4(32, 37, 8), "stream 1 is damaged"));
    CHECK(has(refusal(v4.substr(0, 20)), "it ends inside its header"));
}

#if defined(TILEMESH_HAS_ZLIB) && defined(TILEMESH_HAS_WEBP)
TEST_CASE("SOG: a lossy picture is refused by its name, alone and in a container with other chunks; a lossless one is read from both")
{
    Numbers numbers(11);
    auto const packing = real_packing();
    auto const files = PackedSog::random(100, 2, 1, numbers).files(packing);
    auto const with = [&](std::string const& name, Bytes const& content) {
        auto other = files;
        other[name] = content;
        return refusal(write_zip(other, packing, false), packing.codecs);
    };
    Bytes const pixels(4 * 12 * 12, '\x55');
    std::uint8_t* data = nullptr;
    auto const size = WebPEncodeRGBA(reinterpret_cast<std::uint8_t const*>(pixels.data()), 12, 12, 48, 90.0f, &data);
    Bytes const lossy(reinterpret_cast<char const*>(data), size);
    WebPFree(data);
    auto const contained = [](Bytes const& picture) { // "VP8X", flags of an EXIF chunk, the sides less one; then an EXIF chunk of odd length
        Bytes const head("VP8X\x0a\0\0\0\x08\0\0\0\x0b\0\0\x0b\0\0", 18), exif("EXIF\x03\0\0\0abc\0", 12);
        Bytes out = "RIFF";
        put_little(out, 4 + head.size() + picture.size() - 12 + exif.size(), 4);
        return out + "WEBP" + head + picture.substr(12) + exif;
    };
    auto const& lossless = files.at("sh0.webp");
    for (auto const* name : {"means_l.webp", "sh0.webp", "shN_labels.webp"})
        for (Bytes const& picture : {lossy, contained(lossy)}) CHECK(has(with(name, picture), std::string("\"") + name + "\": it is a lossy WebP"));
    CHECK(with("sh0.webp", lossless) == "");
    CHECK(with("sh0.webp", contained(lossless)) == "");
}
#endif

TEST_CASE("SOG: archives, lists and pictures that lie are refused")
{
    Numbers numbers(10);
    Packing const packing;
    auto const packed = PackedSog::random(100, 2, 2, numbers);
    auto const files = packed.files(packing);
    auto const with = [&](std::string const& name, Bytes const& content) {
        auto other = files;
        other[name] = content;
        return refusal(write_zip(other, packing, false));
    };
    auto const with_meta = [&](std::string const& part, std::string const& text) { return with("meta.json", replaced(packed.meta(), part, text)); };
    CHECK(has(with_meta("\"version\":2", "\"version\":3"), "of another version (1 and 2 are read)"));
    CHECK(has(with_meta("\"version\":2", "\"version\":1"), "the number of Gaussians is not"));
    CHECK(has(with_meta("\"count\":100", "\"count\":-1"), "the number of Gaussians is not a whole number"));
    CHECK(has(with_meta("\"count\":100", "\"count\":1.5"), "the number of Gaussians is not a whole number"));
    CHECK(has(with_meta("\"count\":100", "\"count\":4000000000"), "promises 4000000000 Gaussians"));
    CHECK(has(with_meta("\"count\":100", "\"count\":1000"), "12 x 12 pixels, 1000 to"));
    CHECK(has(with_meta("\"count\":100", "\"count\":\"100\""), "the number of Gaussians is not a whole number"));
    CHECK(has(with_meta("\"means\"", "\"other\""), "is a JSON file without means, scales, quats and sh0"));
    CHECK(has(with_meta("means_u.webp", "../means_u.webp"), "\"../means_u.webp\" leaves the map's folder"));
    CHECK(has(with_meta("means_u.webp", "/etc/passwd"), "\"/etc/passwd\" leaves the map's folder"));
    CHECK(has(with_meta("means_u.webp", "absent.webp"), "has no \"absent.webp\""));
    CHECK(has(with_meta(",\"means_u.webp\"", ""), "means.files names 1 files, not 2"));
    CHECK(has(with_meta("\"bands\":2", "\"bands\":4"), "shN has no bands of 0 to 3"));
    CHECK(has(with_meta("\"bands\":2", "\"bands\":3"), "a palette of harmonics 512 pixels wide"));
    CHECK(has(with_meta("\"count\":100,\"bands\"", "\"count\":70000,\"bands\""), "shN has no count"));
    CHECK(has(with_meta("\"count\":100,\"bands\"", "\"count\":1,\"bands\""), "of 1); export"));
    CHECK(has(with_meta("\"codebook\":[", "\"codebook\":[0,"), "at most 256 numbers"));
    CHECK(has(with_meta("\"codebook\":[", "\"unused\":["), "scales has no codebook of 256 numbers"));
    CHECK(has(with_meta("\"codebook\":[", "\"codebook\":[null,"), "scales.codebook is not a list of at most 256 numbers"));
    CHECK(has(with_meta("\"codebook\":[", "\"codebook\":[0,null,"), "scales.codebook has null at entry 1; only entry 0 of a codebook may be null"));
    CHECK(has(with_meta("\"codebook\":[", "\"codebook\":[true,"), "scales.codebook is not a list of at most 256 numbers"));
    CHECK(has(with_meta("\"mins\":[", "\"mins\":[null,"), "means.mins has null at entry 0"));
    CHECK(has(with_meta("\"files\":[", "\"files\":[7,"), "means.files is not a list of one or two names"));
    CHECK(has(with_meta("\"bands\":2", "\"bands\":1"), "its key shN.bands says degree 1"));
    CHECK(has(with_meta("\"count\":100,\"bands\"", "\"count\":-1,\"bands\""), "shN has no count"));
    CHECK(has(with("meta.json", "[]"), "it is not an object"));
    CHECK(has(with("meta.json", packed.meta() + "]"), "is not JSON"));
    CHECK(has(with("meta.json", "{\"cameras\":[]}"), "cameras are no map"));
    CHECK(has(with("meta.json", std::string(100, '[')), "it is not an object"));
    CHECK(has(with("sh0.webp", "not a picture"), "\"sh0.webp\": it is not WebP"));
    CHECK(has(with("sh0.webp", plain_picture(12, 12, "short")), "\"sh0.webp\": it is damaged"));
    CHECK(has(with("sh0.webp", plain_picture(4, 4, Bytes(64, 'x'))), "\"sh0.webp\": 4 x 4 pixels, 100 to"));
    CHECK(has(with("sh0.webp", plain_picture(65535, 65535, "")), "\"sh0.webp\": 65535 x 65535 pixels"));
    CHECK(has(with("sh0.webp", plain_picture(16, 12, Bytes(4 * 16 * 12, 'x'))), "pictures of different sizes (\"sh0.webp\""));
    CHECK(has(with("shN_centroids.webp", plain_picture(100, 1, Bytes(400, 'x'))), "100 pixels wide"));
    CHECK(has(with("shN_centroids.webp", plain_picture(960, 65535, "")), "960 x 65535 pixels"));
    CHECK(read(write_zip(files, packing, false)).gaussians.size() == 100);

    // The directory of an archive, one entry.
    Bytes const zip = write_zip({{"meta.json", "{}"}}, packing, false);
    std::size_t const entry = zip.find("PK\x01\x02"), end = zip.find("PK\x05\x06");
    auto const zipped = [&](std::size_t at, std::uint64_t value, std::size_t n) { return refusal(changed(zip, at, value, n)); };
    CHECK(has(refusal(zip), "is a JSON file without means"));
    CHECK(has(zipped(end + 4, 1, 2), "it has several parts"));
    CHECK(has(zipped(end + 16, 0xffffffffu, 4), "it is a ZIP64 archive"));
    CHECK(has(zipped(end + 12, 0xfffffff0u, 4), "its directory is not inside the file"));
    CHECK(has(zipped(end + 20, 1, 2), "it has no directory"));
    CHECK(has(zipped(entry, 0, 4), "its directory is damaged"));
    CHECK(has(zipped(entry + 8, 1, 2), "is encrypted"));
    CHECK(has(zipped(entry + 10, 12, 2), "by another method than deflate"));
    CHECK(has(zipped(entry + 16, 1, 4), "its checksum differs"));
    CHECK(has(zipped(entry + 20, 0xfffffff0u, 4), "is cut off"));
    CHECK(has(zipped(entry + 24, 0xfffffff0u, 4), "promises more bytes than it can hold"));
    CHECK(has(zipped(entry + 24, 3, 4), "is stored and has two sizes"));
    CHECK(has(zipped(entry + 28, 0xffff, 2), "its directory is damaged"));
    CHECK(has(zipped(entry + 42, 0xfffffff0u, 4), "has no header"));
    CHECK(has(zipped(26, 0xffff, 2), "is cut off"));
    CHECK(has(refusal("PK\x03\x04"), "it ends inside its directory"));
}

#if defined(TILEMESH_HAS_ZLIB)
TEST_CASE("a bomb of gzip or ZIP is refused without its content")
{
    Packing const packing = real_packing();
    Bytes spz = "NGSP";
    put_little(spz, 2, 4);
    put_little(spz, 1u << 20, 4);
    put_little(spz, 0, 4);
    Bytes const bomb = packing.gzip(spz + Bytes(19u << 20, '\0'));
    CHECK(bomb.size() < 30000);
    CHECK(has(refusal(bomb, packing.codecs), "promises 1048576 Gaussians (it has "));
    Numbers numbers(11);
    auto files = PackedSog::random(1, 2, 0, numbers).files(packing);
    files["meta.json"] = Bytes(16u << 20, ' ') + files["meta.json"];
    CHECK(has(refusal(write_zip(files, packing, true), packing.codecs), "\"meta.json\" promises more bytes than it can hold"));
    // A stream that says less than it has, and one whose checksum is wrong.
    Bytes const good = packing.gzip(PackedSpz::random(2, 3, 0, numbers).plain());
    Bytes wrong = good;
    wrong[wrong.size() - 6] = static_cast<char>(wrong[wrong.size() - 6] ^ 1);
    CHECK(has(refusal(wrong, packing.codecs), "its gzip stream is damaged"));
    CHECK(has(refusal(good.substr(0, good.size() - 1), packing.codecs), "its gzip stream is cut off"));
}
#endif

TEST_CASE("load_map opens regular files and folders with meta.json only")
{
    using tilemesh::scene::load_map;
    check_that_only_files_are_opened([](auto const& path) { load_map(path); }, "is a folder without meta.json");
    TempFile const empty("", ".splat"), list("[1]", ".json"), cameras("{\"cameras\":[]}", ".json");
    CHECK(has(error_of([&] { load_map(empty.path()); }), "is empty"));
    CHECK(has(error_of([&] { load_map(list.path()); }), "is a JSON file"));
    CHECK(has(error_of([&] { load_map(cameras.path()); }), "cameras are no map"));
}
