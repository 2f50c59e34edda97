// test: unoptimised test asan tsan
#include <cstdint>
#include <doctest/doctest.h>
#include <map>
#include <string>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/splat/frame_program.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;

namespace {

template <class S>
using FrameTile = Tile<typename S::Machine, Frame<S>, S>;

template <class S>
std::map<std::string, machine::Region> rows()
{
    std::map<std::string, machine::Region> out;
    for (machine::Region const& r : FrameTile<S>::ledger()) {
        std::string const name(r.name.text, r.name.size);
        CHECK_MESSAGE(out.emplace(name, r).second, "two rows are called ", name);
    }
    return out;
}

template <class S>
std::uint64_t budgeted_sum()
{
    std::uint64_t sum = 0;
    for (machine::Region const& r : FrameTile<S>::ledger()) sum += r.budgeted ? r.bytes : 0;
    return sum;
}

static_assert(sizeof(Gaussian) == 60, "the paper's record");

/// A hypothetical Mk2 with 2 MiB of SRAM per tile.
struct LargeMk2 : Mk2 {
    static constexpr char const* name = "large mk2";
    static constexpr std::uint32_t sram_bytes = 2 << 20;
};

/// All at once: the paper's storage and channels, FIFOs of 800 slots, and the screen cache that the kernels need.
struct Wishes : Lossless {
    static constexpr char const* name = "wishes";
    using Machine = LargeMk2;
    static constexpr Sizes sizes{.storage = 3200, .road = 400, .beam = 400, .waiting = 800, .tile_pixels = 32 * 20};
};
/// Wishes with one set of channels: more than 757 KB, which is the sum with 40 bytes per slot for the screen cache.
struct FewerWishes : Wishes {
    static constexpr char const* name = "fewer wishes";
    static constexpr Sizes sizes{
        .storage = 3200, .road = 400, .beam = 400, .waiting = 800, .tile_pixels = 32 * 20, .one_channel_memory = true};
};

} // namespace

TEST_CASE("the paper's ledger: framebuffer, channels, storage, code; the rest has no room in it")
{
    auto const ledger = rows<Paper>();
    CHECK(ledger.at("framebuffer").bytes == 2'560 + 8);
    CHECK(ledger.at("framebuffer").budgeted);
    CHECK(ledger.at("road").bytes == 8 * (400 * 60 + 8));
    CHECK(ledger.at("storage").bytes == 3'200 * 60 + 8);
    CHECK(ledger.at("storage").budgeted);
    CHECK(ledger.at("beam").bytes == 0); // the paper has one set of channels
    CHECK(FrameTile<Paper>::channel_bytes<Beam<Paper>>() == 8 * (400 * 60 + 8));
    CHECK(ledger.at("code and stacks").bytes == 130 * 1024);
    for (char const* name : {"marks", "projected records", "sort keys"}) {
        CAPTURE(name);
        REQUIRE(ledger.count(name) == 1);
        CHECK_FALSE(ledger.at(name).budgeted);
        CHECK(ledger.at(name).bytes > 0);
    }
    CHECK(ledger.count("waiting (side 0)") == 0); // Drop has no FIFOs
    CHECK(ledger.at("marks").bytes == 3'200 * sizeof(Mark) + 8);
    CHECK(ledger.at("projected records").bytes == 3'200 * sizeof(Splat) + 8);
    CHECK(ledger.at("sort keys").bytes == 3'200 * sizeof(SortKey) + 8);
    CHECK(FrameTile<Paper>::bytes == budgeted_sum<Paper>());
    CHECK(FrameTile<Paper>::bytes <= 638'976);
    auto const lists = ledger.at("marks").bytes + ledger.at("projected records").bytes + ledger.at("sort keys").bytes;
    CHECK(FrameTile<Paper>::bytes + lists > 638'976); // the lists do not fit, and the ledger says so
}

TEST_CASE("the prototype's ledger: 100 and 800 records")
{
    auto const ledger = rows<Prototype>();
    CHECK(ledger.at("road").bytes == 8 * (100 * 60 + 8));
    CHECK(ledger.at("storage").bytes == 800 * 60 + 8);
    CHECK(ledger.at("beam").bytes == 0);
    CHECK(FrameTile<Prototype>::bytes == budgeted_sum<Prototype>());
}

TEST_CASE("our ledger: every region counts, and all of it fits")
{
    auto const ledger = rows<Lossless>();
    for (auto const& row : ledger) CHECK_MESSAGE(row.second.budgeted, row.first);
    CHECK(ledger.at("storage").bytes == Lossless::sizes.storage * 60 + 8);
    CHECK(ledger.at("marks").bytes == Lossless::sizes.storage * sizeof(Mark) + 8);
    CHECK(ledger.at("projected records").bytes == Lossless::sizes.storage * sizeof(Splat) + 8);
    CHECK(ledger.at("sort keys").bytes == Lossless::sizes.storage * sizeof(SortKey) + 8);
    CHECK(ledger.at("framebuffer").bytes == 640 * 12 + 8); // pixels are three floats
    CHECK(ledger.at("road").bytes == 8 * (Lossless::sizes.road * sizeof(Addressed) + 8));
    CHECK(ledger.at("beam").bytes == 8 * (Lossless::sizes.beam * sizeof(Gaussian) + 8));
    CHECK(ledger.at("waiting (side 0)").bytes == Lossless::sizes.waiting * sizeof(Addressed) + 8);
    CHECK(ledger.at("waiting (side 1)").bytes == Lossless::sizes.waiting * sizeof(Addressed) + 8);
    CHECK(ledger.at("code and stacks").bytes == 130 * 1024);
    CHECK(FrameTile<Lossless>::bytes == budgeted_sum<Lossless>());
    CHECK(FrameTile<Lossless>::bytes <= 638'976);
}

TEST_CASE("all of the paper's numbers and all that the kernels keep do not fit in 624 KiB")
{
    CHECK(FrameTile<Wishes>::bytes > Mk2::sram_bytes);
    CHECK(FrameTile<Wishes>::bytes > FrameTile<FewerWishes>::bytes);
    CHECK(FrameTile<FewerWishes>::bytes > 757'000);
    CHECK(FrameTile<Wishes>::bytes == budgeted_sum<Wishes>());
    CHECK(FrameTile<FewerWishes>::bytes == budgeted_sum<FewerWishes>());
    CHECK(rows<FewerWishes>().at("beam").bytes == 0); // copies of 60 bytes lie within the memory of the road, whose messages have 64 bytes
}
