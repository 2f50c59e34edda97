// test: unoptimised test asan tsan
// A setup as a value has the ledger, to the byte, of the type with the same members: regions say their bytes as functions of the value, and
// the types have sizes of their own.
#include "../standard.hpp"
#include <tilemesh/render/setup.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;

namespace {
using Depth = WithDepth<FloatPixel>;
using Both = WithAlpha<WithDepth<FloatPixel>>;

struct ScreenCopied : Lossless {
    using Copies = ScreenCopies;
};
struct HoldingPaper : Paper {
    using Saturation = Hold;
    static constexpr Sizes sizes{
        .storage = 3200, .road = 400, .beam = 400, .waiting = 200, .tile_pixels = 32 * 20, .lists_fit = false, .one_channel_memory = true};
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

constexpr Setup narrow = with(lossless, [](Setup& s) {
    s.sizes.road = 8;
    s.holds = s.carried = false;
    s.colour = ColourFormat::rgbx8;
    s.depth = s.alpha = true;
    s.sh_degree = 1;
    s.sizes.storage = 100;
});
struct Narrow : SetupType<narrow> {};
constexpr Setup too_large = with(lossless, [](Setup& s) { s.sizes.storage = 2500; });
struct Large : SetupType<too_large> {};

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

/// `setup` has the members of S, and the ledger of the program whose types S names.
template <class S>
void same_facts(Setup const& setup)
{
    CAPTURE(setup.name);
    auto const type = setup_of<S>();
    CHECK(std::string(setup.name) == type.name);
    CHECK(std::string(setup.machine.name) == S::Machine::name);
    auto const machine = size_of_machine<typename S::Machine>();
    for (auto const member : {&MachineSize::tiles, &MachineSize::sram_bytes, &MachineSize::code_bytes, &MachineSize::workers})
        CHECK(setup.machine.*member == machine.*member);
    CHECK(setup.sizes == S::sizes);
    CHECK(setup.holds == S::Saturation::holds);
    CHECK(setup.carried == S::Addressing::carried);
    CHECK(setup.reusable == S::Copies::reusable);
    CHECK(road_bytes(setup) == wire_bytes<RoadMessage<S>>);
    CHECK(beam_bytes(setup) == wire_bytes<BeamMessage<S>>);
    CHECK(setup.sh_degree == S::Record::sh_degree);
    CHECK(record_bytes(setup) == sizeof(typename S::Record));
    CHECK(setup.colour == type.colour);
    CHECK(setup.depth == S::Pixel::has_depth);
    CHECK(setup.alpha == S::Pixel::has_alpha);
    CHECK(pixel_bytes(setup) == sizeof(typename S::Pixel));
    CHECK(setup.rules.footprint == S::footprint);
    CHECK(setup.rules.alpha_max == S::alpha_max);
    CHECK(setup.rules.transmittance_min == S::transmittance_min);
    CHECK(setup.rules.arithmetic == S::arithmetic);
    using Ledger = SramLedger<Frame<S>>; // with plain sizes, regions have the bytes of their types
    auto const lines = Ledger::lines(machine, S::sizes);
    same_ledger(render::ledger_of(setup), {lines.begin(), lines.end()});
    CHECK(render::sram_bytes_of(setup) == Ledger::bytes(machine, S::sizes));
    CHECK(bytes_needed<typename S::Machine, Frame<S>, S> == render::sram_bytes_of(setup));
}

std::string refusal(Setup const& choice)
{
    return tests::error_of([&] { render::check_setup(choice); });
}
} // namespace

TEST_CASE("a choice of a setup has its facts")
{
    auto const each = [](auto... setups) { (same_facts<decltype(setups)>(setup_of<decltype(setups)>()), ...); };
    each(Lossless{}, Paper{}, Prototype{}, ScreenCopied{}, HoldingPaper{}, DroppingLossless{}, RoomyLossless{}, Fitted<Paper, 2>{},
         WithPixel<Lossless, Both>{});
}

TEST_CASE("a setup with a record of its own has its bytes")
{
    same_facts<OfLabelled>(setup_of<OfLabelled>());
    auto sizes = Lossless::sizes;
    sizes.storage = 1000;
    auto const setup = render::setup_for<OfLabelled>(sizes);
    CHECK(setup.own_record_bytes == sizeof(Labelled));
    CHECK(line_of(render::ledger_of(setup)[2]) == "storage, state: " + std::to_string(8 + 1000 * sizeof(Labelled)));
}

TEST_CASE("the value of the library's setup types is the library's setup; `with` changes a copy, also for a type")
{
    static_assert(setup_of<Lossless>().sizes == lossless.sizes && setup_of<Paper>().sizes == paper.sizes);
    for (auto const& [type, value] : {std::pair(setup_of<Lossless>(), lossless), std::pair(setup_of<Paper>(), paper), std::pair(setup_of<Prototype>(), prototype)}) {
        CHECK(std::string(type.name) == value.name);
        CHECK(lines_of(render::ledger_of(type)) == lines_of(render::ledger_of(value)));
        CHECK(std::memcmp(&type.rules, &value.rules, sizeof value.rules) == 0);
    }
    static_assert(Narrow::sizes.road == 8 && lossless.sizes.road == 200);
    same_facts<Narrow>(narrow);
    static_assert(fits<Mk2, Frame<Narrow>, Narrow> && !fits<Mk2, Frame<Large>, Large>, "a setup that is too large does not compile as a Tile");
}

TEST_CASE("a choice that is changed has the facts of the type that says the same")
{
    auto paper = setup_of<Paper>();
    paper.holds = true;
    paper.sizes.waiting = 200;
    same_facts<HoldingPaper>(paper);

    auto lossless = setup_of<Lossless>();
    lossless.reusable = false;
    same_facts<ScreenCopied>(lossless);
    lossless.reusable = true;
    lossless.holds = lossless.carried = false;
    lossless.colour = ColourFormat::rgbx8;
    same_facts<DroppingLossless>(lossless);

    auto large = setup_of<Lossless>();
    large.machine = size_of_machine<RoomyMachine>();
    large.sizes = roomy(large.sizes);
    same_facts<RoomyLossless>(large);
}

/// The fits of S to these degrees.
template <class S, bool Routes, bool Blooms, std::uint32_t... Degrees>
void same_fits()
{
    (same_facts<Fitted<S, Degrees, Routes, Blooms>>(fitted(setup_of<S>(), Degrees, Routes, Blooms)), ...);
}

TEST_CASE("a fitted choice has the sizes of Fitted")
{
    same_fits<Lossless, true, true, 1, 2, 3>();
    same_fits<Lossless, false, true, 0, 1, 2, 3>();
    same_fits<Lossless, true, false, 0, 3>();
    same_fits<Lossless, false, false, 0, 3>();
    same_fits<ScreenCopied, true, true, 3>();
    // The paper's presets keep routing and bloom, because these share their channels.
    same_fits<Paper, true, true, 1, 3>();
    same_fits<Prototype, true, true, 3>();

    static_assert(fitted(setup_of<Lossless>(), 0, true, true).sizes == Lossless::sizes, "a fit of what is there changes nothing");
    static_assert(fitted(setup_of<Lossless>(), 3, true, true).sizes.storage == 860, "README says so");
}

TEST_CASE("a choice with planes has the sizes of WithPixel")
{
    auto const lossless = setup_of<Lossless>();
    same_facts<WithPixel<Lossless, Depth>>(with_planes(lossless, true, false));
    same_facts<WithPixel<Lossless, WithAlpha<FloatPixel>>>(with_planes(lossless, false, true));
    same_facts<WithPixel<Lossless, Both>>(with_planes(lossless, true, true));
    same_facts<WithPixel<Fitted<Lossless, 3>, Both>>(with_planes(fitted(lossless, 3, true, true), true, true));
    same_facts<WithPixel<Paper, WithAlpha<Rgbx8Pixel>>>(with_planes(setup_of<Paper>(), false, true));
    same_facts<WithPixel<RoomyLossless, Both>>(with_planes(setup_of<RoomyLossless>(), true, true));
    CHECK(with_planes(lossless, false, false).sizes == lossless.sizes);
    CHECK(with_planes(lossless, true, false).sizes.storage == 1993);
}

TEST_CASE("a choice that does not fit is refused with the region and the bytes")
{
    // 136 bytes a slot with its lists; one slot more than the SRAM has room for.
    auto choice = setup_of<Lossless>();
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
    choice = setup_of<Lossless>();
    choice.sh_degree = 3;
    auto const over = render::sram_bytes_of(choice) - choice.machine.sram_bytes;
    auto const why = refusal(choice);
    CHECK(why.find("machine mk2, region storage has 480008 bytes, and the sum is " + std::to_string(over) + " bytes over") != std::string::npos);

    // A framebuffer for a large tile, of bytes and of floats: 4 bytes a pixel fit, 12 do not.
    choice = setup_of<Paper>();
    choice.sizes.tile_pixels = 20'000;
    CHECK(refusal(choice) == "");
    choice.colour = ColourFormat::float32;
    CHECK(refusal(choice).find("region framebuffer has 240008 bytes") != std::string::npos);
    choice.depth = choice.alpha = true;
    CHECK(refusal(choice).find("region framebuffer has 400008 bytes") != std::string::npos);
}

TEST_CASE("a choice that is exactly full fits, and one byte less of SRAM does not hold it")
{
    for (auto choice : {setup_of<Lossless>(), setup_of<Paper>(), fitted(setup_of<Lossless>(), 3, false, true),
                        with_planes(setup_of<Lossless>(), true, true)}) {
        CAPTURE(choice.name);
        auto const bytes = render::sram_bytes_of(choice);
        choice.machine.sram_bytes = static_cast<std::uint32_t>(bytes);
        CHECK(refusal(choice) == "");
        choice.machine.sram_bytes -= 1;
        CHECK(refusal(choice).find("the sum is 1 bytes over") != std::string::npos);
    }
    // With planes, storage gives up the bytes that are missing, and no slot if none are missing.
    auto tight = setup_of<Lossless>();
    tight.machine.sram_bytes = static_cast<std::uint32_t>(render::sram_bytes_of(tight));
    auto const planes = with_planes(tight, true, true);
    CHECK(refusal(planes) == "");
    CHECK(planes.sizes.storage == tight.sizes.storage - (2 * 4 * 640 + 135) / 136);
}

TEST_CASE("a machine with more workers than a frame counts for, or with none, is refused")
{
    for (std::uint32_t workers : {0u, 1u, 6u, 7u}) {
        CAPTURE(workers);
        auto choice = setup_of<Lossless>();
        choice.machine.workers = workers;
        CHECK(refusal(choice) == (workers == 1 || workers == 6 ? ""
                                                               : "machine mk2 with " + std::to_string(workers) +
                                                                     " workers (a tile counts the work of 1 to 6); give the machine 1 to 6 workers"));
    }
}

TEST_CASE("a choice that holds without FIFOs is refused")
{
    auto choice = setup_of<Paper>();
    choice.holds = true;
    REQUIRE(choice.sizes.waiting == 0);
    CHECK(refusal(choice).find("needs FIFOs") != std::string::npos);
    choice.sizes.waiting = 1;
    CHECK(refusal(choice) == "");
    // Without routing no record waits.
    choice = fitted(setup_of<Lossless>(), 0, false, true);
    choice.sizes.waiting = 0;
    CHECK(refusal(choice) == "");
}
