// test: unoptimised test asan tsan
// From counters to a report: made-up numbers go in, and the report comes out.
#include "../compare_reports.hpp"
#include "../splat/support.hpp"
#include <tilemesh/render/accounting.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;

namespace {
using Whole = PoliciesOf<Lossless>;
using Minimal = PoliciesOf<Fitted<Lossless, 0, false, false>>;

/// Step i took i + 1 exchanges, 100 (i + 1) passes and 10^i ms, and sent 100 (i + 1) messages of 2 bytes; its exchange moves 3 bytes per
/// message.
RunCounters run_of(std::uint32_t steps)
{
    RunCounters run;
    double ms = 1;
    for (std::uint32_t i = 0; i < steps; ++i, ms *= 10) {
        StepCounters s;
        s.exchanges = i + 1;
        s.passes = 100 * (i + 1);
        s.messages = 100 * (i + 1);
        s.live_bytes = 2 * s.messages;
        s.capacity_bytes = 3 * s.messages;
        s.milliseconds = ms;
        run.steps.push_back(s);
    }
    run.digests = {7, 8, 9};
    return run;
}
/// The sums of two tiles. The words of a tile are their places, and those of the second tile one less.
render::AnchoredSums sums()
{
    std::array<std::uint32_t, sizeof(Counts) / 4> counts{};
    std::array<std::uint32_t, sizeof(Work) / 4> work{};
    std::iota(counts.begin(), counts.end(), 1u);
    std::iota(work.begin(), work.end(), 11u);
    render::AnchoredSums out;
    out.add(std::bit_cast<Counts>(counts), std::bit_cast<Work>(work));
    for (auto& word : counts) --word;
    auto second = std::bit_cast<Counts>(counts);
    second.visible = 0xffffffffu; // a tile's counts have 32 bits, their sums more
    out.add(second, Work{});
    return out;
}
/// The report has these numbers in these fields.
void has_counts(report::FrameReport const& r, std::map<std::string, std::uint64_t> const& expected)
{
    for (auto const& each : expected) CHECK_MESSAGE(report::total(r, each.first) == each.second, each.first);
}
} // namespace

TEST_CASE("accounting: every counter goes to its place in the report")
{
    auto run = run_of(6); // project, route, bloom's first, bloom, sort, composite
    run.peaks = {{"storage", 41, 2000}, {"marks", 99, 2000}, {"road", 42, 200}, {"beam", 43, 200}};
    auto const r = render::account<Whole>(run, sums(), true);
    has_counts(r, {{"gaussians.visible", 0x100000000u}, {"gaussians.parked", 2 + 1}, {"gaussians.moved", 3 + 2}, {"hops", 4 + 3},
                   {"copies", 11 + 10}, {"pairs", (11 + 12 + 13 + 14 + 15 + 16) * 16}, {"pairs_contributing", 17 + 18 + 19 + 20 + 21 + 22},
                   {"exchanges.project", 1}, {"exchanges.route", 2}, {"exchanges.bloom", 3 + 4}, {"exchanges.composite", 6},
                   {"passes.project", 100}, {"passes.route", 200}, {"passes.bloom", 300 + 400}, {"passes.composite", 500 + 600},
                   {"messages", 2100}, {"exchanged_bytes.live", 4200}, {"exchanged_bytes.capacity", 6300},
                   {"peak.storage", 41}, {"peak.channel", 43}});
    CHECK(r.host_ms.project == 1);
    CHECK(r.host_ms.route == 10);
    CHECK(r.host_ms.bloom == 1100);
    CHECK(r.host_ms.composite == 110'000);
    CHECK(r.gaussians.held == r.refused.by_channels());
    CHECK(r.refused.by_channels() == 5 + 4 + 6 + 5);
    CHECK(r.refused.by_storage() == 7 + 6 + 8 + 7);
    CHECK(r.refused.copies_refused == 9 + 8);
    for (auto const& field : report::report_fields)
        if (auto const word = field.anchored.word; word != nullptr) CHECK_MESSAGE(field.count(r) == sums()[word], field.name);
    CHECK(r.digests == std::vector<std::uint64_t>{7, 8, 9});
    CHECK(r.lost.empty());

    CHECK(render::account<Whole>(run, sums(), false).gaussians.held == 0); // with `drop`, no record waits
}

TEST_CASE("accounting: a part that a setup does without took nothing")
{
    auto run = run_of(3); // project, sort, composite
    run.peaks = {{"storage", 41, 2000}, {"road", 42, 200}};
    auto const r = render::account<Minimal>(run, sums(), true);
    has_counts(r, {{"exchanges.project", 1}, {"exchanges.route", 0}, {"exchanges.bloom", 0}, {"exchanges.composite", 3},
                   {"passes.project", 100}, {"passes.route", 0}, {"passes.bloom", 0}, {"passes.composite", 200 + 300}});
    CHECK(r.host_ms.route == 0);
    CHECK(r.host_ms.bloom == 0);
    CHECK(r.host_ms.composite == 110);
}

TEST_CASE("accounting: the first sum that does not hold is named")
{
    using report::Cause;
    auto const says = [](report::FrameReport const& r, std::uint64_t records, std::uint64_t gone) -> std::string {
        auto const* const text = render::wrong_sum(r, records, gone);
        return text == nullptr ? "" : text;
    };
    report::FrameReport none;
    CHECK(says(none, 0, 0) == "");
    CHECK(says(none, 1, 0) == "visible, parked and earlier lost records are not the records of the map");

    report::FrameReport r;
    r.gaussians.visible = 7;
    r.gaussians.parked = 2;
    r.gaussians.dropped = 3;
    r.gaussians.unplaced = 2;
    r.lost_copies = 3;
    r.late_copies = 1;
    r.lost = {{GaussianId{4}, report::Loss::whole, Cause::unplaced}, {GaussianId{5}, 8, Cause::unplaced}, {GaussianId{5}, 9, Cause::unplaced},
              {GaussianId{6}, 1, Cause::storage_full},              {GaussianId{6}, 2, Cause::late},     {GaussianId{7}, report::Loss::whole, Cause::late}};
    CHECK(says(r, 12, 3) == "");
    for (std::uint64_t gone : {2u, 4u}) CHECK(says(r, 12, gone) == "visible, parked and earlier lost records are not the records of the map");
    auto wrong = r;
    auto const spoilt = [&](auto const& spoil) {
        wrong = r;
        spoil(wrong);
        return says(wrong, 12, 3);
    };
    CHECK(spoilt([](auto& w) { w.gaussians.dropped = 2; }) == "records that were lost before are not among the dropped");
    CHECK(spoilt([](auto& w) { w.gaussians.visible = 1, w.gaussians.parked = 8; }) == "there are unplaced records that are not visible");
    CHECK(spoilt([](auto& w) { w.gaussians.unplaced = 1; }) == "the list of losses has more unplaced records than there are");
    CHECK(spoilt([](auto& w) { w.gaussians.unplaced = 3; }) == ""); // one of them left copies on all its tiles
    for (std::uint64_t const by : {~std::uint64_t{0}, std::uint64_t{1}}) { // one less, one more
        CHECK(spoilt([by](auto& w) { w.lost_copies += by; }) == "copies_lost is not the number of copies in the list of losses");
        CHECK(spoilt([by](auto& w) { w.late_copies += by; }) == "copies_late is not the number of late copies in the list of losses");
    }
    CHECK_NOTHROW(render::check_sums(r, 12, 3));
    CHECK_THROWS_WITH_AS(render::check_sums(wrong, 12, 3),
                         "a report whose sums do not hold (copies_late is not the number of late copies in the list of losses); "
                         "report this, and do not use the frame",
                         Error);
}

TEST_CASE("accounting: a second run replaces what it decides, and what it took comes on top")
{
    auto const first = render::account<Whole>(run_of(6), sums(), true);
    auto run = run_of(6);
    run.digests = {10};
    auto again = render::account<Whole>(run, {}, true);
    again.copies = 51;
    again.pairs = 52;
    again.pairs_contributing = 53;
    again.lost_copies = 54;
    again.late_copies = 55;
    again.lost = {{GaussianId{5}, 6, report::Cause::late}};
    again.full_tiles = {1, 2, 3, 4};
    auto both = first;
    render::add_second_run(both, again);
    has_counts(both, {{"copies", 51}, {"pairs", 52}, {"pairs_contributing", 53}, {"copies_lost", 54}, {"copies_late", 55}});
    CHECK(both.lost == again.lost);
    CHECK(both.host_ms.composite == 220'000);
    CHECK(both.digests == std::vector<std::uint64_t>{7, 8, 9, 10});
    CHECK(both.full_tiles == again.full_tiles);
    using Stages = report::FrameReport::ByStage;
    for (auto const stage : {&Stages::project, &Stages::route, &Stages::bloom, &Stages::composite})
        CHECK(both.passes.*stage == 2 * first.passes.*stage);
    // All other numbers are those of the first run.
    CHECK(both.exchanges.total() == first.exchanges.total());
    CHECK(both.messages == first.messages);
    CHECK(both.gaussians.visible == first.gaussians.visible);
    CHECK(both.refused.copies_full == first.refused.copies_full);
}
