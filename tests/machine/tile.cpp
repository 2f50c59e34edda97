// test: unoptimised test asan tsan
#include "../engine/programs.hpp"
#include <cstdint>
#include <doctest/doctest.h>
#include <string>
#include <tilemesh/machine/tile.hpp>
#include <type_traits>

using namespace tilemesh;

namespace {

using engine_test::Cell;
using engine_test::Conductivity;
using engine_test::Heat;
using engine_test::Wall;
using HeatTile = Tile<Mk2, Heat>;

// 1 word of state, 1 word of broadcast, 8 ends of 2 + 1 words, and 130 KiB reserved for code and stacks.
static_assert(HeatTile::words<Cell>() == 1 && HeatTile::offset<Cell>() == 0 && HeatTile::state_words == 1);
static_assert(HeatTile::channel_bytes<Wall>() == 96 && HeatTile::own_channel_bytes<Wall>() == 96);
static_assert(HeatTile::bytes == 133'120 + 96 + 4 + 4);
static_assert(HeatTile::region_count == 4 && HeatTile::ledger().size() == 4);

std::string text(machine::Name n)
{
    return {n.text, n.size};
}

template <class Ledger>
std::uint64_t budgeted_sum(Ledger const& ledger)
{
    std::uint64_t sum = 0;
    for (machine::Region const& r : ledger) sum += r.budgeted ? r.bytes : 0;
    return sum;
}

// Several states: order and offsets follow the parameter lists.
struct Small {
    std::uint32_t word[3];
};
struct List : Buffer<std::uint32_t, 10> {
    static constexpr char const* name = "a list of ten";
};
struct Wide : Buffer<Small, 5> {};
struct Extra : Buffer<std::uint32_t, 100> {
    static constexpr bool budgeted = false;
};
struct Counted : Buffer<std::uint32_t, 1> {
    static constexpr bool budgeted = true;
};
struct Keep {
    void operator()(List&, Small const&, Extra&) const noexcept {}
};
struct KeepMore {
    void operator()(Wide&, Small&, Counted&, Broadcast<Small>) const noexcept {}
};
using Kept = Tile<TestMachine<4096>, Sequence<Superstep<Keep>, Superstep<KeepMore>>>;
static_assert(Kept::words<List>() == 12 && Kept::words<Small>() == 3 && Kept::words<Extra>() == 102);
static_assert(Kept::words<Wide>() == 2 + 15 && Kept::words<Counted>() == 3);
static_assert(Kept::offset<List>() == 0 && Kept::offset<Small>() == 12 && Kept::offset<Extra>() == 15);
static_assert(Kept::offset<Wide>() == 117 && Kept::offset<Counted>() == 134 && Kept::state_words == 137);
static_assert(Kept::bytes == 4 * (12 + 3 + 17 + 3) + 12, "all but what is outside the budget, and the broadcast");

// Channels that share memory.
template <std::uint32_t N>
struct Road : Channel<std::uint32_t, N> {};
template <std::uint32_t N, std::uint32_t M>
struct Beam : Channel<Small, N> {
    using memory_of = Road<M>;
};
template <class... C>
struct Talk {
    void operator()(In<C>... in, Out<C>... out) const noexcept
    {
        (void)std::initializer_list<int>{(static_cast<void>(in), static_cast<void>(out), 0)...};
    }
};
template <class... C>
using TalkTile = Tile<TestMachine<8192>, Superstep<Talk<C...>>>;

// A road of N slots takes 32 (2 + N) bytes, a beam of N slots 32 (2 + 3 N).
static_assert(TalkTile<Road<6>>::bytes == 256);
static_assert(TalkTile<Road<6>, Beam<1, 6>>::bytes == 256, "the smaller one lies within");
static_assert(TalkTile<Road<6>, Beam<2, 6>>::bytes == 256, "as large: nothing more");
static_assert(TalkTile<Road<6>, Beam<3, 6>>::bytes == 352, "the larger of the two");
static_assert(TalkTile<Road<6>, Beam<2, 6>>::own_channel_bytes<Beam<2, 6>>() == 0);
static_assert(TalkTile<Road<6>, Beam<3, 6>>::own_channel_bytes<Beam<3, 6>>() == 96);
static_assert(TalkTile<Beam<3, 6>, Road<6>>::bytes == 352, "whoever is named first");

struct Free : Channel<std::uint32_t> {};
static_assert(TalkTile<Free>::bytes == 64, "a dynamic channel counts as its heads; the engine counts the rest");
static_assert(SramLedger<Superstep<Talk<Free>>>::channel_bytes<Free>(NoSizes{}) == 64);

// The limit of the budget: exactly full fits. One word more is a compile-time error, which tests/checks tests.
template <std::uint32_t N>
struct Load : Buffer<std::uint32_t, N> {};
template <std::uint32_t N>
struct Use {
    void operator()(Load<N>&, In<Wall>, Out<Wall>) const noexcept {}
};
template <std::uint32_t Sram, std::uint32_t N>
using Loaded = Tile<TestMachine<Sram>, Superstep<Use<N>>>;
constexpr std::uint32_t exact = 4 * (2 + 10) + 96;
static_assert(Loaded<exact, 10>::bytes == exact, "exactly full fits");
static_assert(Loaded<exact, 9>::bytes == exact - 4);
static_assert(Loaded<exact + 4, 11>::bytes == exact + 4, "one word over needs one word more");
static_assert(Loaded<exact, 0>::bytes == exact - 40);

// Slots that are values: members of a setup's sizes, or values at run time. Flags among the sizes say whether bytes count.
struct Slots {
    std::uint32_t pile = 0, road = 0, beam = 0;
    bool counted = true, shared = false;
};
struct Pile : Buffer<Small> {
    static constexpr auto slots = &Slots::pile;
    static constexpr auto budgeted_if = &Slots::counted;
};
struct Way : Channel<std::uint32_t> {
    static constexpr auto slots = &Slots::road;
};
struct Ray : Channel<Small> {
    using memory_of = Way;
    static constexpr auto slots = &Slots::beam;
    static constexpr auto memory_shared = &Slots::shared;
};
struct Carry {
    void operator()(Pile&, In<Way>, Out<Way>, In<Ray>, Out<Ray>) const noexcept {}
};
using Carrying = Superstep<Carry>;
using Ledger = SramLedger<Carrying>;
template <std::uint32_t Sram, std::uint32_t N, bool Counted = true, bool Shared = false>
struct CarryingSetup {
    using Machine = TestMachine<Sram>;
    static constexpr Slots sizes{N, 6, 3, Counted, Shared};
    using Layout = Tile<Machine, Carrying, CarryingSetup>;
};
constexpr std::uint32_t ways = 8 * (8 + 6 * 4), rays = 8 * (8 + 3 * 12); // 256 and 352 bytes
static_assert(CarryingSetup<2000, 10>::Layout::bytes == ways + rays + 4 * (2 + 30));
static_assert(CarryingSetup<2000, 10, false>::Layout::bytes == ways + rays, "bytes that the flag takes out of the budget");
static_assert(CarryingSetup<2000, 10, true, true>::Layout::bytes == rays + 4 * (2 + 30), "the larger of the two");
static_assert(CarryingSetup<2000, 10, false, true>::Layout::words<Pile>() == 32, "still stored");
static_assert(CarryingSetup<ways + rays + 128, 10>::Layout::bytes == ways + rays + 128, "exactly full fits");
static_assert(!fits<TestMachine<ways + rays + 127>, Carrying, CarryingSetup<2000, 10>> && fits<TestMachine<ways + rays + 128>, Carrying, CarryingSetup<2000, 10>>);
static_assert(CarryingSetup<2000, 10>::Layout::machine.sram_bytes == 2000);

// A program without state.
struct Idle {
    void operator()() const noexcept {}
};
static_assert(Tile<TestMachine<0>, Superstep<Idle>>::bytes == 0 && Tile<Mk2, Superstep<Idle>>::bytes == 133'120);
static_assert(Tile<Mk2, Superstep<Idle>>::region_count == 1);

/// The paper's machine, and a machine that a user describes.
static_assert(Mk2::tiles == 1472 && Mk2::sram_bytes == 638'976 && Mk2::workers == 6 && Mk2::clock_khz == 1'325'000);
} // namespace
namespace tile_test {
struct Mine {
    static constexpr char const* name = "mine";
    static constexpr std::uint32_t tiles = 4, sram_bytes = 256, code_bytes = 100, workers = 2, clock_khz = 1;
};
} // namespace tile_test
namespace {
static_assert(Tile<tile_test::Mine, Heat>::bytes == 100 + 96 + 8);

// bytes_needed and fits answer without an error: exactly full fits, and one byte more does not fit.
template <std::uint32_t Bytes>
struct WithSram : tile_test::Mine {
    static constexpr std::uint32_t sram_bytes = Bytes;
};
static_assert(bytes_needed<WithSram<204>, Heat> == 204 && bytes_needed<WithSram<0>, Heat> == 204 && bytes_needed<Mk2, Heat> == HeatTile::bytes);
static_assert(fits<WithSram<204>, Heat> && !fits<WithSram<203>, Heat> && !fits<WithSram<0>, Heat> && fits<WithSram<0xffffffffu>, Heat>);

} // namespace

TEST_CASE("the ledger of heat: channels, states, broadcasts, then code and stacks")
{
    constexpr auto ledger = HeatTile::ledger();
    CHECK(text(ledger[0].name) == "Wall");
    CHECK(ledger[0].bytes == 96);
    CHECK(std::string(ledger[0].what) == "channel, 8 ends");
    CHECK(text(ledger[1].name) == "Cell");
    CHECK(ledger[1].bytes == 4);
    CHECK(std::string(ledger[1].what) == "state");
    CHECK(text(ledger[2].name) == "Conductivity");
    CHECK(ledger[2].bytes == 4);
    CHECK(std::string(ledger[2].what) == "broadcast");
    CHECK(text(ledger[3].name) == "code and stacks");
    CHECK(ledger[3].bytes == 133'120);
    for (machine::Region const& r : ledger) CHECK(r.budgeted);
    CHECK(budgeted_sum(ledger) == HeatTile::bytes);
}

TEST_CASE("what is outside the budget is listed and not counted")
{
    constexpr auto ledger = Kept::ledger();
    REQUIRE(ledger.size() == 7);
    CHECK(text(ledger[0].name) == "a list of ten");
    CHECK(text(ledger[2].name) == "Extra");
    CHECK(ledger[2].bytes == 408);
    CHECK_FALSE(ledger[2].budgeted);
    CHECK(ledger[4].budgeted); // the type says so itself
    CHECK(text(ledger[5].name) == "Small");
    CHECK(std::string(ledger[5].what) == "broadcast"); // the struct is a state and a broadcast: two regions
    CHECK(budgeted_sum(ledger) == Kept::bytes);
}

TEST_CASE("shared channel memory is one row's bytes, and rows add up to the total")
{
    constexpr auto within = TalkTile<Road<6>, Beam<1, 6>>::ledger();
    CHECK(within[0].bytes == 256);
    CHECK(within[1].bytes == 0);
    CHECK(text(within[1].name) == "Beam");
    CHECK(budgeted_sum(within) == TalkTile<Road<6>, Beam<1, 6>>::bytes);
    constexpr auto beyond = TalkTile<Road<6>, Beam<3, 6>>::ledger();
    CHECK(beyond[0].bytes == 256);
    CHECK(beyond[1].bytes == 96);
    CHECK(budgeted_sum(beyond) == TalkTile<Road<6>, Beam<3, 6>>::bytes);
}

TEST_CASE("the ledger of sizes that come at run time is that of the same constants, with both flags at both values")
{
    auto const machine = size_of_machine<tile_test::Mine>();
    CHECK(std::string(machine.name) == "mine");
    for (std::uint32_t pile : {0u, 1u, 9u, 10u, 11u})
        for (bool counted : {false, true})
            for (bool shared : {false, true}) {
                CAPTURE(pile);
                CAPTURE(counted);
                CAPTURE(shared);
                Slots const sizes{pile, 6, 3, counted, shared};
                auto const lines = Ledger::lines(machine, sizes);
                REQUIRE(lines.size() == 4);
                CHECK(text(lines[0].name) == "Way");
                CHECK(lines[0].bytes == ways);
                CHECK(lines[1].bytes == (shared ? rays - ways : rays));
                CHECK(lines[2].bytes == 8 + 12 * pile);
                CHECK(lines[2].budgeted == counted);
                CHECK(lines[3].bytes == 100);
                CHECK(budgeted_sum(lines) == Ledger::bytes(machine, sizes));
            }
    constexpr auto fixed = CarryingSetup<2000, 10, true, true>::Layout::ledger();
    auto const lines = Ledger::lines(size_of_machine<TestMachine<2000>>(), Slots{10, 6, 3, true, true});
    REQUIRE(fixed.size() == lines.size());
    for (std::size_t i = 0; i < lines.size(); ++i) {
        CHECK(fixed[i].bytes == lines[i].bytes);
        CHECK(fixed[i].budgeted == lines[i].budgeted);
        CHECK(text(fixed[i].name) == text(lines[i].name));
    }
}

TEST_CASE("slots beyond what 32 bits of bytes can count are counted, not wrapped around")
{
    auto const machine = size_of_machine<Mk2>();
    std::uint64_t const rest = 133'120 + 8 + std::uint64_t{ways + rays};
    CHECK(Ledger::bytes(machine, Slots{0x15555556u, 6, 3}) == rest + std::uint64_t{12} * 0x15555556u); // 2^32 + 8 bytes
    CHECK(Ledger::bytes(machine, Slots{0xffffffffu, 6, 3}) == rest + std::uint64_t{12} * 0xffffffffu);
    CHECK(Ledger::bytes(machine, Slots{0, 6, 0x0aaaaaabu}) == rest - rays + 8 * (8 + std::uint64_t{12} * 0x0aaaaaabu));
    CHECK(Ledger::lines(machine, Slots{0xffffffffu, 6, 3})[2].bytes == 0xffffffffu);
}
