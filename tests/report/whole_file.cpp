// test: unoptimised test asan tsan
#include "folder.hpp"
#include <tilemesh/joined_threads.hpp>
#include <tilemesh/report/whole_file.hpp>
#if defined(__linux__)
#    include <csignal>
#    include <sys/resource.h>
#endif

namespace {

namespace fs = std::filesystem;
using tests::contents, tests::Folder;
using tilemesh::report::write_whole;

} // namespace

TEST_SUITE_BEGIN("report");

TEST_CASE("a whole file is its header and its body, and replaces what had the name")
{
    Folder const folder;
    auto const path = folder.path / "a";
    std::array const body{std::byte{'\0'}, std::byte{0xff}};
    write_whole(path, "head", body);
    CHECK(contents(path) == std::string("head\0\xff", 6));
    write_whole(path, "");
    CHECK(contents(path).empty());
    CHECK(folder.files() == 1);
}

TEST_CASE("a file that outlasts a power loss is written like any other")
{
    Folder const folder;
    auto const path = folder.path / "a", link = folder.path / "link";
    using tilemesh::report::Outlasts;
    write_whole(path, "head", {}, Outlasts::power_loss);
    CHECK(contents(path) == "head");
    fs::create_symlink("a", link);
    write_whole(link, "through a link", {}, Outlasts::power_loss);
    CHECK(contents(path) == "through a link");
    CHECK(folder.files() == 2);
    CHECK_THROWS_AS(write_whole(folder.path / "absent" / "a", "x", {}, Outlasts::power_loss), tilemesh::Error);
    if (fs::is_character_file("/dev/null")) write_whole("/dev/null", "gone", {}, Outlasts::power_loss);
    // In the working directory, which a plain file name does not mention.
    auto const before = fs::current_path();
    fs::current_path(folder.path);
    write_whole("b", "here", {}, Outlasts::power_loss);
    fs::current_path(before);
    CHECK(contents(folder.path / "b") == "here");
    CHECK(tilemesh::report::detail::sync_to_disk(-1) == std::errc::bad_file_descriptor);
}

TEST_CASE("a file that cannot be written leaves nothing, and what was there")
{
    Folder const folder;
    CHECK_THROWS_WITH_AS(write_whole(folder.path / "absent" / "a", "x"), doctest::Contains("room for 1 bytes"), tilemesh::Error);
    CHECK_THROWS_WITH_AS(write_whole(folder.path, "x"), doctest::Contains("directory"), tilemesh::Error);
    CHECK_THROWS_AS(write_whole(folder.path / std::string(300, 'n'), "x"), tilemesh::Error);
    CHECK(folder.files() == 0);
}

TEST_CASE("a file of several pieces has its name when it is finished, and never if it is not")
{
    using tilemesh::report::WholeFile;
    Folder const folder;
    auto const path = folder.path / "a";
    write_whole(path, "the old file");
    {
        WholeFile file(path, "a test");
        file.put("one ");
        file.put("");
        file.flush();
        CHECK(contents(path) == "the old file");
        CHECK(contents(path.string() + ".part") == "one ");
        file.put("two");
        file.finish();
        CHECK(contents(path) == "one two");
    }
    CHECK(contents(path) == "one two");
    {
        WholeFile file(path, "a test");
        file.put("half of a");
    }
    CHECK(contents(path) == "one two");
    CHECK(folder.files() == 1);
    CHECK_THROWS_WITH_AS(WholeFile(folder.path / "absent" / "a", "a test"), doctest::Contains("room for a test"), tilemesh::Error);
    if (!fs::is_character_file("/dev/full")) return;
    WholeFile file("/dev/full", "a test");
    file.put("a word");
    CHECK_THROWS_WITH_AS(file.flush(), doctest::Contains("No space"), tilemesh::Error);
}

TEST_CASE("pieces for an open stream leave it open, and its error has the caller's words")
{
    using tilemesh::report::WholeFile;
    Folder const folder;
    auto const path = folder.path / "a";
    {
        tests::Stream const stream{std::fopen(path.c_str(), "wb")};
        {
            WholeFile file(stream.file, "the words", "buy a disk");
            file.put("one ");
            file.finish();
            CHECK(contents(path) == "one ");
        }
        std::fputs("two", stream.file);
    }
    CHECK(contents(path) == "one two");
    tests::Stream const stream{std::fopen(path.c_str(), "rb")}; // no write goes there
    WholeFile file(stream.file, "the words", "buy a disk");
    CHECK_THROWS_WITH_AS(file.put("x"), "cannot write the words (Bad file descriptor); buy a disk", tilemesh::Error);
    CHECK(folder.files() == 1);
}

#if defined(__linux__)
TEST_CASE("a disk that is full leaves what had the name, and no part")
{
    // A file-size limit of this process plays the full disk: if SIGXFSZ is ignored, a write beyond it fails with EFBIG.
    struct FullDisk {
        rlimit before{};
        void (*handler)(int) = std::signal(SIGXFSZ, SIG_IGN);
        FullDisk()
        {
            getrlimit(RLIMIT_FSIZE, &before);
            rlimit none{0, before.rlim_max};
            setrlimit(RLIMIT_FSIZE, &none);
        }
        ~FullDisk()
        {
            setrlimit(RLIMIT_FSIZE, &before);
            std::signal(SIGXFSZ, handler);
        }
    };
    Folder const folder;
    auto const path = folder.path / "a";
    write_whole(path, "the old file");
    // Small enough to fail at the flush, and large enough to fail at a write.
    for (std::size_t size : {1u, 1'000'000u}) {
        CAPTURE(size);
        {
            FullDisk const full;
            CHECK_THROWS_WITH_AS(write_whole(path, std::string(size, 'x')), doctest::Contains("File too large"), tilemesh::Error);
        }
        CHECK(contents(path) == "the old file");
        CHECK(folder.files() == 1);
    }
}
#endif

TEST_CASE("the part of another writer is left alone")
{
    Folder const folder;
    auto const path = folder.path / "a";
    std::ofstream(path.string() + ".part") << "theirs";
    std::ofstream(path.string() + ".2.part") << "theirs too";
    write_whole(path, "ours");
    CHECK(contents(path) == "ours");
    CHECK(contents(path.string() + ".part") == "theirs");
    CHECK(contents(path.string() + ".2.part") == "theirs too");
    CHECK(folder.files() == 3);
}

TEST_CASE("of many writers at once, one has the name, whole")
{
    Folder const folder;
    auto const path = folder.path / "a";
    {
        tilemesh::JoinedThreads writers;
        for (char letter = 'a'; letter < 'e'; ++letter)
            writers.start([=] {
                for (int i = 0; i < 50; ++i) write_whole(path, std::string(100'000, letter));
            });
    }
    auto const text = contents(path);
    CHECK(text.size() == 100'000);
    CHECK(text.find_first_not_of(text[0]) == std::string::npos);
    CHECK(folder.files() == 1);
}

TEST_CASE("a link is followed, a device stays a device")
{
    Folder const folder;
    auto const path = folder.path / "a", link = folder.path / "link";
    write_whole(path, "old");
    fs::create_symlink(path, link);
    write_whole(link, "new");
    CHECK(fs::is_symlink(link));
    CHECK(contents(path) == "new");
    fs::create_symlink("absent", folder.path / "dangling"); // relative to its own folder
    write_whole(folder.path / "dangling", "there now");
    CHECK(fs::is_symlink(folder.path / "dangling"));
    CHECK(contents(folder.path / "absent") == "there now");
    fs::create_symlink("ring", folder.path / "ring");
    CHECK_THROWS_WITH_AS(write_whole(folder.path / "ring", "x"), doctest::Contains("in a ring"), tilemesh::Error);

    if (!fs::is_character_file("/dev/null") || !fs::is_character_file("/dev/full")) {
        MESSAGE("skipped: there is no /dev/null or no /dev/full");
        return;
    }
    write_whole("/dev/null", "gone");
    CHECK(fs::is_character_file("/dev/null"));
    CHECK_THROWS_AS(write_whole("/dev/full", "no room"), tilemesh::Error);
    CHECK(fs::is_character_file("/dev/full"));
}

TEST_SUITE_END();
