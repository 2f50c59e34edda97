// test: unoptimised test asan tsan
// A setup that is put together at run time has the facts and the ledger, to the byte, of the type with the same members.
#include <doctest/doctest.h>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/setup_choice.hpp>
#include <vector>

using namespace tilemesh;
using namespace tilemesh::splat;
using render::choice_of;
using render::facts_of;
using render::fitted;
using render::SetupChoice;
using render::with_planes;

namespace {
using Depth = WithDepth<FloatPixel>;
using Both = WithAlpha<WithDepth<FloatPixel>>;

struct ScreenCopied : Lossless {
    using Copies = ScreenCopies;
};
struct HoldingPaper : Paper {
    using Saturation = Hold;
    static constexpr Sizes sizes{.storage = 3200,
                                 .road = 400,
                                 .beam = 400,
                                 .waiting = 200,
                                 .tile_pixels = 32 * 20,
                                 .lists_fit = false,
                                 .one_channel_memory = true};
};
struct DroppingLossless : Lossless {
    using Saturation = Drop;
    using Addressing = Recomputed;
    using Pixel = Rgbx8Pixel;
};
struct RoomyLossless : Lossless {
    using Machine = RoomyMachine;
    static constexpr Sizes sizes = roomy(Lossless::sizes);
};

/// A record with an additional word takes its bytes, which no choice knows.
struct Labelled : Gaussian {
    std::uint32_t label;
};
struct OfLabelled : Lossless {
    using Record = Labelled;
};

/// Facts of a type without the checks, so that setups that do not fit can be compared too.
template <class S>
render::SetupFacts facts_of_type()
{
    return render::detail::facts_with<S>(S::sizes);
}

std::string line_of(machine::Region const& r)
{
    return std::string(r.name.text, r.name.size) + ", " + r.what + ": " + std::to_string(r.bytes) + (r.budgeted ? "" : ", not budgeted");
}
std::vector<std::string> lines_of(std::vector<machine::Region> const& ledger)
{
    std::vector<std::string> out;
    for (auto const& r : ledger) out.push_back(line_of(r));
    return out;
}

void same_ledger(std::vector<machine::Region> const& a, std::vector<machine::Region> const& b)
{
    auto const x = lines_of(a), y = lines_of(b);
    REQUIRE(x.size() == y.size());
    for (std::size_t i = 0; i < x.size(); ++i) CHECK(x[i] == y[i]);
}

/// `choice` has the facts of S.
template <class S>
void same_facts(SetupChoice const& choice)
{
    CAPTURE(choice.name);
    auto const type = facts_of_type<S>();
    auto const value = facts_of(choice);
    CHECK(std::string(value.name) == type.name);
    CHECK(std::string(value.machine.name) == type.machine.name);
    CHECK(value.machine.tiles == type.machine.tiles);
    CHECK(value.machine.sram_bytes == type.machine.sram_bytes);
    CHECK(value.machine.code_bytes == type.machine.code_bytes);
    CHECK(value.machine.workers == type.machine.workers);
    CHECK(value.sizes == type.sizes);
    CHECK(value.policies.holds == type.policies.holds);
    CHECK(value.policies.carried == type.policies.carried);
    CHECK(value.policies.reusable == type.policies.reusable);
    CHECK(value.policies.road_bytes == type.policies.road_bytes);
    CHECK(value.policies.beam_bytes == type.policies.beam_bytes);
    CHECK(value.sh_degree == type.sh_degree);
    CHECK(value.record_bytes == type.record_bytes);
    CHECK(value.colour == type.colour);
    CHECK(value.has_depth == type.has_depth);
    CHECK(value.has_alpha == type.has_alpha);
    CHECK(value.rules.footprint == type.rules.footprint);
    CHECK(value.rules.alpha_min == type.rules.alpha_min);
    CHECK(value.rules.alpha_max == type.rules.alpha_max);
    CHECK(value.rules.transmittance_min == type.rules.transmittance_min);
    CHECK(value.rules.arithmetic == type.rules.arithmetic);
    CHECK(value.sram_bytes == type.sram_bytes);
    CHECK(value.sram_bytes == render::sram_bytes_of(choice));
    same_ledger(value.ledger, type.ledger);
    same_ledger(render::ledger_of(choice), type.ledger);
}

std::string refusal(SetupChoice const& choice)
{
    try {
        (void)facts_of(choice);
        return {};
    } catch (Error const& error) {
        return error.what();
    }
}
} // namespace

TEST_CASE("a choice of a setup has its facts")
{
    same_facts<Lossless>(choice_of<Lossless>());
    same_facts<Paper>(choice_of<Paper>());
    same_facts<Prototype>(choice_of<Prototype>());
    same_facts<ScreenCopied>(choice_of<ScreenCopied>());
    same_facts<HoldingPaper>(choice_of<HoldingPaper>());
    same_facts<DroppingLossless>(choice_of<DroppingLossless>());
    same_facts<RoomyLossless>(choice_of<RoomyLossless>());
    same_facts<Fitted<Paper, 2>>(choice_of<Fitted<Paper, 2>>());
    same_facts<WithPixel<Lossless, Both>>(choice_of<WithPixel<Lossless, Both>>());
}

TEST_CASE("a setup with a record of its own is no choice")
{
    static_assert(render::detail::is_of_the_library<Lossless> && render::detail::is_of_the_library<Fitted<Paper, 3>>);
    static_assert(!render::detail::is_of_the_library<OfLabelled>);
    auto sizes = Lossless::sizes;
    sizes.storage = 1000;
    auto const facts = facts_of<OfLabelled>(sizes);
    CHECK(facts.record_bytes == sizeof(Labelled));
    CHECK(line_of(facts.ledger[2]) == "storage, state: " + std::to_string(8 + 1000 * sizeof(Labelled)));
}

TEST_CASE("a choice that is changed has the facts of the type that says the same")
{
    auto paper = choice_of<Paper>();
    paper.holds = true;
    paper.sizes.waiting = 200;
    same_facts<HoldingPaper>(paper);

    auto lossless = choice_of<Lossless>();
    lossless.reusable = false;
    same_facts<ScreenCopied>(lossless);
    lossless.reusable = true;
    lossless.holds = lossless.carried = false;
    lossless.colour = render::ColourFormat::rgbx8;
    same_facts<DroppingLossless>(lossless);

    auto large = choice_of<Lossless>();
    large.machine = size_of_machine<RoomyMachine>();
    large.sizes = roomy(large.sizes);
    same_facts<RoomyLossless>(large);
}

TEST_CASE("a fitted choice has the sizes of Fitted")
{
    auto const lossless = choice_of<Lossless>();
    same_facts<Fitted<Lossless, 1>>(fitted(lossless, 1, true, true));
    same_facts<Fitted<Lossless, 2>>(fitted(lossless, 2, true, true));
    same_facts<Fitted<Lossless, 3>>(fitted(lossless, 3, true, true));
    same_facts<Fitted<Lossless, 0, false, true>>(fitted(lossless, 0, false, true));
    same_facts<Fitted<Lossless, 1, false, true>>(fitted(lossless, 1, false, true));
    same_facts<Fitted<Lossless, 2, false, true>>(fitted(lossless, 2, false, true));
    same_facts<Fitted<Lossless, 3, false, true>>(fitted(lossless, 3, false, true));
    same_facts<Fitted<Lossless, 0, true, false>>(fitted(lossless, 0, true, false));
    same_facts<Fitted<Lossless, 3, true, false>>(fitted(lossless, 3, true, false));
    same_facts<Fitted<Lossless, 0, false, false>>(fitted(lossless, 0, false, false));
    same_facts<Fitted<Lossless, 3, false, false>>(fitted(lossless, 3, false, false));
    same_facts<Fitted<ScreenCopied, 3>>(fitted(choice_of<ScreenCopied>(), 3, true, true));
    // The paper's presets keep routing and bloom, because these share their channels.
    same_facts<Fitted<Paper, 1>>(fitted(choice_of<Paper>(), 1, true, true));
    same_facts<Fitted<Paper, 3>>(fitted(choice_of<Paper>(), 3, true, true));
    same_facts<Fitted<Prototype, 3>>(fitted(choice_of<Prototype>(), 3, true, true));

    static_assert(fitted(choice_of<Lossless>(), 0, true, true).sizes == Lossless::sizes, "a fit of what is there changes nothing");
    static_assert(fitted(choice_of<Lossless>(), 3, true, true).sizes.storage == 860, "README says so");
}

TEST_CASE("a choice with planes has the sizes of WithPixel")
{
    auto const lossless = choice_of<Lossless>();
    same_facts<WithPixel<Lossless, Depth>>(with_planes(lossless, true, false));
    same_facts<WithPixel<Lossless, WithAlpha<FloatPixel>>>(with_planes(lossless, false, true));
    same_facts<WithPixel<Lossless, Both>>(with_planes(lossless, true, true));
    same_facts<WithPixel<Fitted<Lossless, 3>, Both>>(with_planes(fitted(lossless, 3, true, true), true, true));
    same_facts<WithPixel<Paper, WithAlpha<Rgbx8Pixel>>>(with_planes(choice_of<Paper>(), false, true));
    same_facts<WithPixel<RoomyLossless, Both>>(with_planes(choice_of<RoomyLossless>(), true, true));
    CHECK(with_planes(lossless, false, false).sizes == lossless.sizes);
    CHECK(with_planes(lossless, true, false).sizes.storage == 1993);
}

TEST_CASE("a choice that does not fit is refused with the region and the bytes")
{
    // 136 bytes a slot with its lists; one slot more than the SRAM has room for.
    auto choice = choice_of<Lossless>();
    auto const free = choice.machine.sram_bytes - render::sram_bytes_of(choice);
    choice.sizes.storage += static_cast<std::uint32_t>(free / 136);
    CHECK(refusal(choice) == "");
    auto const left = choice.machine.sram_bytes - render::sram_bytes_of(choice);
    REQUIRE(left < 136);
    choice.sizes.storage += 1;
    CHECK(refusal(choice) == "the program does not fit in a tile's SRAM (machine mk2, region storage has " +
                                 std::to_string(8 + 60 * choice.sizes.storage) + " bytes, and the sum is " + std::to_string(136 - left) +
                                 " bytes over); give it fewer slots");

    // Records grow and the sizes stay, because nothing refits them.
    choice = choice_of<Lossless>();
    choice.sh_degree = 3;
    auto const over = render::sram_bytes_of(choice) - choice.machine.sram_bytes;
    auto const why = refusal(choice);
    CHECK(why.find("machine mk2, region storage has 480008 bytes, and the sum is " + std::to_string(over) + " bytes over") != std::string::npos);

    // A framebuffer for a large tile, of bytes and of floats: 4 bytes a pixel fit, 12 do not.
    choice = choice_of<Paper>();
    choice.sizes.tile_pixels = 20'000;
    CHECK(refusal(choice) == "");
    choice.colour = render::ColourFormat::float32;
    CHECK(refusal(choice).find("region framebuffer has 240008 bytes") != std::string::npos);
    choice.depth = choice.alpha = true;
    CHECK(refusal(choice).find("region framebuffer has 400008 bytes") != std::string::npos);
}

TEST_CASE("a choice that is exactly full fits, and one byte less of SRAM does not hold it")
{
    for (auto choice : {choice_of<Lossless>(), choice_of<Paper>(), fitted(choice_of<Lossless>(), 3, false, true),
                        with_planes(choice_of<Lossless>(), true, true)}) {
        CAPTURE(choice.name);
        auto const bytes = render::sram_bytes_of(choice);
        choice.machine.sram_bytes = static_cast<std::uint32_t>(bytes);
        CHECK(refusal(choice) == "");
        CHECK(facts_of(choice).sram_bytes == bytes);
        choice.machine.sram_bytes -= 1;
        CHECK(refusal(choice).find("the sum is 1 bytes over") != std::string::npos);
    }
    // With planes, storage gives up the bytes that are missing, and no slot if none are missing.
    auto tight = choice_of<Lossless>();
    tight.machine.sram_bytes = static_cast<std::uint32_t>(render::sram_bytes_of(tight));
    auto const planes = with_planes(tight, true, true);
    CHECK(refusal(planes) == "");
    CHECK(planes.sizes.storage == tight.sizes.storage - (2 * 4 * 640 + 135) / 136);
}

TEST_CASE("a machine with more workers than a frame counts for, or with none, is refused")
{
    for (std::uint32_t workers : {0u, 1u, 6u, 7u}) {
        CAPTURE(workers);
        auto choice = choice_of<Lossless>();
        choice.machine.workers = workers;
        bool const counted = workers == 1 || workers == 6;
        CHECK((refusal(choice) == "") == counted);
        if (!counted)
            CHECK(refusal(choice) == "machine mk2 with " + std::to_string(workers) +
                                         " workers (a tile counts the work of 1 to 6); give the machine 1 to 6 workers");
    }
}

TEST_CASE("a choice that holds without FIFOs is refused")
{
    auto choice = choice_of<Paper>();
    choice.holds = true;
    REQUIRE(choice.sizes.waiting == 0);
    CHECK(refusal(choice).find("needs FIFOs") != std::string::npos);
    choice.sizes.waiting = 1;
    CHECK(refusal(choice) == "");
    // Without routing no record waits.
    choice = fitted(choice_of<Lossless>(), 0, false, true);
    choice.sizes.waiting = 0;
    CHECK(refusal(choice) == "");
}
