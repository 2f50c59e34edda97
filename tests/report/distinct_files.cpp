// test: unoptimised test asan tsan
#include "folder.hpp"
#include <fcntl.h>
#include <sys/stat.h>
#include <tilemesh/report/distinct_files.hpp>
#include <unistd.h>

namespace {

namespace fs = std::filesystem;
using tilemesh::report::DistinctFiles;

/// A folder with two folders in it, "read" and "written", and the file "read/map".
struct Folder : tests::Folder {
    fs::path map = path / "read/map", written = path / "written";
    Folder()
    {
        fs::create_directories(path / "read");
        fs::create_directories(written);
        tests::put(map, "a map");
    }
};

bool is_picture(std::string const& name)
{
    return name == "a.png" || name == "b.png";
}

/// The error of `write` for a path, if `map` is read and pictures go to `written`; empty: no error.
std::string refusal(Folder const& folder, fs::path const& path)
{
    DistinctFiles files;
    files.read(folder.map);
    return tests::error_of([&] {
        files.write_into(folder.written, is_picture, "a picture", "name another directory");
        files.write(path, "the report", "name another file");
    });
}

} // namespace

TEST_SUITE_BEGIN("report");

TEST_CASE("a file that is read is not written, whatever name leads to it")
{
    Folder const folder;
    auto const report = folder.path / "report";
    CHECK(refusal(folder, report) == "");
    CHECK(refusal(folder, folder.map) == "cannot write the report to " + folder.map.string() + " (this run reads that file); name another file");
    CHECK(tests::has(refusal(folder, folder.path / "written/../read/map"), "this run reads that file: it is " + folder.map.string()));
    fs::create_directory_symlink("read", folder.path / "link");
    fs::create_symlink("read/map", folder.path / "symlink");
    fs::create_hard_link(folder.map, folder.path / "hard link");
    for (auto const* name : {"link/map", "symlink", "hard link"}) CHECK(tests::has(refusal(folder, folder.path / name), "this run reads that file"));
    CHECK(tests::has(refusal(folder, folder.path / "absent/report"), "there is no directory"));
    CHECK(refusal(folder, folder.path / "read/other") == "");
}

TEST_CASE("a folder's files are looked at one by one, and only those that will be written")
{
    Folder const folder;
    auto const report = folder.path / "report", picture = folder.written / "a.png";
    auto const with_picture = [&](auto const& make) { // in place of the last one
        fs::remove(picture);
        make();
        return refusal(folder, report);
    };
    fs::create_symlink(folder.map, folder.written / "c.png");
    CHECK(refusal(folder, report) == "");
    CHECK(with_picture([&] { tests::put(picture, "an older picture"); }) == "");
    CHECK(tests::has(with_picture([&] { fs::create_symlink("../read/map", picture); }),
                     "cannot write a picture to " + picture.string() + " (this run reads that file: it is "));
    CHECK(tests::has(with_picture([&] { fs::create_hard_link(folder.map, picture); }), "this run reads that file"));
    CHECK(tests::has(with_picture([&] { REQUIRE(mkfifo(picture.c_str(), 0600) == 0); }), "it is a pipe or a socket"));
    CHECK(with_picture([&] { fs::create_symlink("/dev/null", picture); }) == "");
    DistinctFiles read_again, files;
    CHECK_THROWS_WITH_AS(read_again.write_into(folder.written, is_picture, "a picture", "go away", DistinctFiles::Devices::refused),
                         doctest::Contains("it is a device"), tilemesh::Error);
    fs::remove(picture);
    REQUIRE(mkfifo(report.c_str(), 0600) == 0);
    CHECK(refusal(folder, report) == "");
    CHECK_THROWS_WITH_AS(files.write_into(folder.path / "absent", is_picture, "a picture", "go away"), doctest::Contains("cannot look into"),
                         tilemesh::Error);
}

TEST_CASE("a folder whose list of names breaks off is refused")
{
    Folder const folder;
    std::ofstream(folder.written / "a.png") << "an older picture";
    struct stat own {};
    REQUIRE(stat(folder.written.c_str(), &own) == 0);
    // In the middle of the list, the descriptor of the folder becomes one of /dev/null, which has no names.
    auto const break_off = [&](std::string const&) {
        int const other = open("/dev/null", O_RDONLY);
        for (int descriptor = 0; descriptor < 256; ++descriptor) {
            struct stat each {};
            if (fstat(descriptor, &each) == 0 && each.st_dev == own.st_dev && each.st_ino == own.st_ino) dup2(other, descriptor);
        }
        close(other);
        return false;
    };
    DistinctFiles files;
    CHECK_THROWS_WITH_AS(files.write_into(folder.written, break_off, "a picture", "name another directory"),
                         doctest::Contains("cannot look into"), tilemesh::Error);
}

TEST_CASE("no two files have one name, there or not")
{
    Folder const folder;
    auto const report = folder.path / "report", picture = folder.written / "a.png";
    CHECK(tests::has(refusal(folder, picture), "a picture of this run has that name"));
    CHECK(tests::has(refusal(folder, folder.written / "A.png"), "a picture of this run has that name")); // one file on some file systems
    CHECK(refusal(folder, folder.written / "c.png") == "");
    // A link to a missing file, and one to another picture.
    fs::create_symlink("../report", picture);
    CHECK(tests::has(refusal(folder, report), "that is the file of a picture of this run, " + picture.string()));
    fs::remove(picture);
    fs::create_symlink("b.png", picture);
    CHECK(tests::has(refusal(folder, report), "it is a link to a picture of this run, "));
    fs::remove(picture);
    fs::create_symlink("../other", picture);
    fs::create_symlink("../other", folder.written / "A.png"); // where letters count, nobody writes to it
    CHECK(refusal(folder, report) == "");
    fs::remove(folder.written / "A.png");
    fs::remove(picture);
    fs::create_symlink("../report", folder.written / "b.png");
    fs::create_symlink("../report", picture);
    CHECK(tests::has(refusal(folder, folder.path / "other"), "that is the file of a picture of this run, "));
    fs::remove(folder.written / "b.png");

    // The order of the calls does not matter.
    DistinctFiles twice;
    twice.write(report, "the report", "name another file");
    CHECK_THROWS_WITH_AS(twice.write(report, "the list", "name another file"), doctest::Contains("that is the file of the report of this run"),
                         tilemesh::Error);
    DistinctFiles files;
    files.write(folder.path / "read/b.png", "the report", "name another file");
    files.write_into(folder.written, is_picture, "a picture", "name another directory");
    CHECK_THROWS_WITH_AS(files.write_into(folder.path / "read", is_picture, "a plot", "go away"), doctest::Contains("a plot of this run has that name"),
                         tilemesh::Error);

    // Hard links of one older file are replaced one by one. A device accepts several files.
    fs::remove(picture);
    std::ofstream(picture) << "an older picture";
    fs::create_hard_link(picture, folder.written / "b.png");
    fs::create_hard_link(picture, report);
    CHECK(refusal(folder, report) == "");
    fs::remove(picture);
    fs::remove(report);
    fs::create_symlink("/dev/null", picture);
    fs::create_symlink("/dev/null", report);
    CHECK(refusal(folder, report) == "");
}

TEST_CASE("a stream of the process is a file like others, where it goes to one")
{
    Folder const folder;
    auto* const stream = std::fopen((folder.path / "log").c_str(), "w");
    REQUIRE(stream != nullptr);
    DistinctFiles files;
    files.read(folder.map);
    files.write_stream(fileno(stream), "standard output", "send it elsewhere");
    files.write_stream(fileno(stream), "standard error", "send it elsewhere"); // both into one file, as shells do
    CHECK_THROWS_WITH_AS(files.write(folder.path / "log", "the report", "name another file"),
                         doctest::Contains("(standard output goes to that file)"), tilemesh::Error);
    files.write(folder.path / "report", "the report", "name another file");
    std::fclose(stream);
    auto* const input = std::fopen(folder.map.c_str(), "a");
    REQUIRE(input != nullptr);
    CHECK_THROWS_WITH_AS(files.write_stream(fileno(input), "standard output", "send it elsewhere"),
                         doctest::Contains("(this run reads that file); send it elsewhere"), tilemesh::Error);
    std::fclose(input);
    files.write_stream(-1, "a closed stream", "");
}

TEST_SUITE_END();
