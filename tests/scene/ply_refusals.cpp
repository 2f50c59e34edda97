// test: unoptimised test asan tsan
#include "ply_writer.hpp"
#include "support.hpp"
#include <istream>
#include <sstream>
#include <tilemesh/scene/map_file.hpp>
#include <tuple>

using namespace scene_test;
using tilemesh::scene::load_ply;

TEST_CASE("a file cut anywhere is refused, in every format")
{
    for (char const* format : {little, big, ascii})
        for (Ply const& ply : variants(format)) {
            auto const bytes = ply.bytes();
            // Missing digits of the last number of an ASCII file cannot be detected.
            std::size_t const complete = format == std::string(ascii) ? bytes.find_last_of(" ") + 2 : bytes.size();
            std::size_t wrong = 0;
            for (std::size_t n = 0; n < bytes.size(); ++n) {
                auto const text = refusal(bytes.substr(0, n));
                wrong += text.empty() != (n >= complete);
                if (text.empty()) CHECK(has(read(bytes.substr(0, n)).notes.back(), "the last line has no end"));
            }
            CHECK(wrong == 0);
            CHECK(read(bytes).gaussians.size() == 3);
        }
    // Through a file as well.
    auto const bytes = several(2).bytes();
    for (std::size_t n = 0; n < bytes.size(); n += 7) {
        TempFile const file(bytes.substr(0, n), ".ply");
        CHECK_FALSE(error_of([&] { load_ply(file.path()); }).empty());
    }
}

TEST_CASE("counts that the body cannot hold are refused before memory is allocated")
{
    for (char const* format : {little, big, ascii})
        for (Ply ply : variants(format)) {
            if (!ply.elements_after.empty()) continue; // rows would be taken from the element behind
            CAPTURE(format);
            // The last one is the smallest whose bytes, times 56, wrap to less than are there.
            for (char const* count : {"4", "2147483648", "4294967296", "1099511627776", "18446744073709551615", "329406144173384851"}) {
                ply.count = count;
                CHECK(has(refusal(ply), std::string("element \"vertex\" (the header promises ") + count + " rows, "));
                if (format != ascii && !ply.lists) CHECK(has(refusal(ply), "3 are there"));
            }
            ply.count = "18446744073709551616";
            CHECK(has(refusal(ply), "below 2^64"));
            for (char const* count : {"-1", "3.0", "three", "0x3"}) {
                ply.count = count;
                CHECK(has(refusal(ply), "not a whole number"));
            }
            ply.count = "2";
            auto const map = read(ply);
            CHECK(map.gaussians.size() == 2);
            CHECK(map.gaussians.capacity() == 2);
            CHECK(has(map.notes.back(), "bytes after the last row skipped"));
            ply.count = "0";
            CHECK(read(ply).gaussians.empty());
        }
}

TEST_CASE("invalid headers are refused")
{
    CHECK(has(refusal("ply\nformat binary_middle_endian 1.0\n"), "unknown format \"binary_middle_endian\""));
    CHECK(has(refusal("ply\nformat\n"), "a format without a name"));
    CHECK(has(refusal("ply\nformat ascii 1.0\nformat ascii 1.0\n"), "line 3: a second format"));
    CHECK(has(refusal("ply\nelement vertex 0\nend_header\n"), "no format"));
    CHECK(has(refusal("ply\nelement vertex\n"), "a name and a count"));
    CHECK(has(refusal("ply\nelement a 1\nelement a 1\n"), "element \"a\" comes twice"));
    CHECK(has(refusal("ply\nelement a 1\nproperty int b\nproperty float b\n"), "line 4: property \"b\" comes twice"));
    CHECK(has(refusal("ply\nelement a 1\nproperty quad b\n"), "unknown type \"quad\""));
    CHECK(has(refusal("ply\nelement a 1\nproperty int\n"), "a type and a name"));
    CHECK(has(refusal("ply\nproperty list int int a\n"), "before the first element"));
    CHECK(has(refusal("ply\nproperty float x\nend_header\n"), "before the first element"));
    CHECK(has(refusal("ply\nend_header\n"), "no format"));
    CHECK(has(refusal("ply\nhello\nend_header\n"), "line 2: unknown word \"hello\""));
    CHECK(has(refusal("ply\nformat binary_little_endian 1.0\n"), "end_header"));
    CHECK(has(refusal("ply\nformat binary_little_endian 1.0\nend_header\n"), "no element vertex"));
    for (char const* bytes : {"", "pl", "\x89PNG\r\n\x1a\n", "plyx\n"}) CHECK(has(refusal(bytes), "not a PLY"));
    for (int field = 0; field < 14; ++field) {
        Ply ply;
        ply.order.erase(ply.order.begin() + field);
        CHECK(has(refusal(ply), std::string("no property ") + names[field] + " ("));
    }
    Ply few;
    few.order = {0, 1, 2};
    CHECK(has(refusal(few), "f_dc_0, f_dc_1, f_dc_2, opacity"));
    CHECK(has(refusal("ply\ncomment " + std::string(300'000, 'x') + "\nformat ascii 1.0\nend_header\n"), "end_header"));
    CHECK(has(refusal("ply\n" + std::string(300'000, '\n')), "end_header"));
    CHECK(has(refusal(std::string("ply\0\nformat ascii 1.0\n", 22)), "its first line"));
    CHECK(has(refusal(std::string("ply\nformat\0 ascii 1.0\n", 22)), "unknown word \"format?\""));
    CHECK(has(refusal(std::string("ply\nformat ascii\0 1.0\n", 22)), "unknown format \"ascii?\""));
    CHECK(has(refusal("ply\rformat ascii 1.0\r"), "its first line"));
    CHECK(has(refusal("ply\n" + std::string(100, 'y') + "\n"), "yyy...\""));

    // The longest header that is read, full of properties or elements: the time stays short.
    std::string properties, elements;
    for (int i = 0; properties.size() < 240'000; ++i) properties += "property char " + std::to_string(i) + "\n";
    for (int i = 0; elements.size() < 240'000; ++i) elements += "element " + std::to_string(i) + " 0\n";
    Ply many;
    many.elements_after = properties;
    CHECK(has(refusal(many), "ends inside row 1"));
    many.elements_after = elements;
    auto const map = read(many);
    CHECK(map.gaussians.size() == 1);
    REQUIRE(map.notes.size() == 6);
    CHECK(has(map.notes[5], "more elements skipped"));
}

TEST_CASE("other formats of maps are refused by name, with advice")
{
    std::string const bytes(64, '\x07');
    for (auto const& [name, part] : {std::pair{"a.splat", "is a .splat map (32 bytes a Gaussian"}, {"a.SPLAT", ".splat map"},
                                     {"a.ksplat", "is a .ksplat map"}, {"a.spz", "is an SPZ map"}, {"a.sog", "is an SOG map"},
                                     {"a.sogs", "is an SOG map"}, {"meta.json", "is a JSON file"}}) {
        CHECK(has(refusal(bytes, name), part));
        CHECK(has(refusal(bytes, name), "uncompressed PLY"));
    }
    for (auto const& [name, text, part] : {std::tuple{"a.glb", "glTF\2", "is a binary glTF scene"},
                                           {"a.npz", "PK\3\4", "is a NumPy archive"},
                                           {"a.pt", "PK\3\4", "is a PyTorch checkpoint"},
                                           {"a.ckpt", "PK\3\4", "is a PyTorch checkpoint"},
                                           {"a.npy", "\x93NUMPY", "is a NumPy array"},
                                           {"a.rad", "??", "is a RAD map"},
                                           {"a.lcc", "{}", "is an LCC map"}}) {
        CHECK(has(refusal(text, name), part));
        std::istringstream stream(text);
        CHECK(has(error_of([&, n = name] { tilemesh::scene::read_map(stream, n); }), part));
        CHECK(has(refusal(text, name), "uncompressed PLY"));
    }
    for (char const* name : {"a.ply", "a.spz", "a.splat", "a.sog"}) {
        for (auto const& [text, part] : {std::pair{"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "run git lfs pull"},
                                         {"<!DOCTYPE html>\n<html>", "is a web page"}}) {
            std::istringstream stream(text);
            CHECK(has(error_of([&, n = name] { tilemesh::scene::read_map(stream, n); }), part));
        }
    }
    CHECK(has(refusal(bytes, "a.zip"), "unpack it"));
    CHECK(has(refusal(bytes, "a.bin"), "does not begin with \"ply\""));
    for (char const* name : {"a.ply", "a.gz"}) CHECK(has(refusal("\x1f\x8b\x08", name), "compressed by gzip"));
    CHECK(has(refusal("\x1f\x8b\x08", "a.spz"), "is an SPZ map (compressed by gzip)"));
    CHECK(has(refusal("NGSP\x04", "a.ply"), "is an SPZ map"));
    for (char const* name : {"a.ply", "a.sog", "a.zip"}) CHECK(has(refusal("PK\x03\x04..", name), "is a ZIP archive"));
    CHECK(has(refusal("", "a.ply"), "is empty"));
    CHECK(has(refusal("", "a.splat"), "is empty"));
    CHECK(read(Ply{}.bytes(), "misnamed.splat").gaussians.size() == 1); // what it is counts, not how it is called

    std::string const points = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n"
                               "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
    CHECK(has(refusal(points), "is a point cloud"));
    CHECK(has(refusal(points), "point_cloud/iteration_N/point_cloud.ply"));
    CHECK(has(refusal("ply\nformat ascii 1.0\nelement points 1\nend_header\n"), "no element vertex"));
    CHECK(has(refusal("", "two\nlines.ply"), "two?lines.ply"));
}

TEST_CASE("only regular files are opened: nothing blocks")
{
    check_that_only_files_are_opened([](auto const& path) { load_ply(path); });
    TempFile const empty("", ".ply");
    CHECK(has(error_of([&] { load_ply(Ply{}.bytes().substr(0, 20) + std::string(5000, 'a')); }), "cannot be opened"));
    CHECK(has(error_of([&] { load_ply(empty.path()); }), "is empty"));
}

TEST_CASE("a stream is read from its current position; one without a size is refused")
{
    std::istringstream stream("before" + Ply{}.bytes());
    stream.seekg(6);
    CHECK(tilemesh::scene::read_ply(stream, "part.ply").gaussians.size() == 1);
    std::istringstream failed(Ply{}.bytes());
    failed.setstate(std::ios::badbit);
    CHECK(has(error_of([&] { tilemesh::scene::read_ply(failed, "failed.ply"); }), "its size is not known"));

    // A file that becomes shorter while it is read.
    struct Shrinking : std::stringbuf {
        using std::stringbuf::stringbuf;
        bool was_at_end = false;
        pos_type seekoff(off_type off, std::ios::seekdir way, std::ios::openmode which) override
        {
            was_at_end = was_at_end || way == std::ios::end;
            return std::stringbuf::seekoff(off, way, which) + off_type(was_at_end ? 56 : 0);
        }
    } buffer(several(2).bytes());
    std::istream shrinking(&buffer);
    CHECK(has(error_of([&] { tilemesh::scene::read_ply(shrinking, "shrinking.ply"); }), "it changed, or the disk failed"));
}
