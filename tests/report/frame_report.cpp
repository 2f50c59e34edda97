// test: unoptimised test asan tsan
#include "../compare_reports.hpp"
#include "../standard.hpp"
#include "all_different.hpp"
#include <tilemesh/report/frame_csv.hpp>
#include <tilemesh/report/table.hpp>

namespace report = tilemesh::report;
using report::FrameReport;
using tilemesh::splat::GaussianId;

TEST_SUITE_BEGIN("report");

TEST_CASE("the table of a report's fields has every member once")
{
    // Width, height and two peaks have 32 bits, `lost` is a list, `losses` are its sums: all other fields are eight bytes. The program has
    // 32 bits too, beside padding; `unfinished` is a list whose size is a field.
    constexpr auto fields = std::size(report::report_fields);
    static_assert(sizeof(FrameReport) == sizeof(std::string) + sizeof(std::vector<report::Loss>) + sizeof(std::vector<std::uint64_t>) +
                                             sizeof(std::vector<report::UnfinishedTile>) + sizeof(std::optional<report::FullTiles>) +
                                             8 * (fields - 5 - report::causes) + 4 * 4 + 8,
                  "a member of FrameReport is not in report_fields, or a field is there twice");
    std::set<std::string_view> names;
    std::set<std::uint64_t> counts;
    std::set<double> times;
    auto const r = all_different();
    for (auto const& field : report::report_fields) {
        CAPTURE(field.name);
        CHECK(names.insert(field.name).second);
        CHECK(field.exact() != (field.milliseconds != nullptr));
        if (field.group() != "losses") CHECK((field.exact() ? counts.insert(field.count(r)).second : times.insert(field.milliseconds(r)).second));
        CHECK(field.exact() == (field.unit != "ms"));
        CHECK(field.exact() == (field.group() != "host_ms"));
        CHECK(field.meaning.ends_with("."));
        CHECK(field.line.empty() == field.phrase.empty());
        auto const& lines = report::text_lines;
        CHECK((std::find(std::begin(lines), std::end(lines), field.line) == std::end(lines)) == field.line.empty());
    }
}

TEST_CASE("a field is found by its name at compile time, and says its group and leaf")
{
    static_assert(report::report_field("gaussians.moved").group() == "gaussians");
    static_assert(report::report_field("gaussians.moved").leaf() == "moved");
    static_assert(report::report_field("copies").group().empty());
    static_assert(report::report_field("copies").leaf() == "copies");
    static_assert(report::report_field("copies").is_in("copies"));
    static_assert(!report::report_field("copies_lost").is_in("copies"));
    static_assert(report::report_field("gaussians.moved").is_in("gaussians"));
    auto r = all_different();
    r.gaussians.moved = 12;
    CHECK(report::report_field("gaussians.moved").count(r) == 12);
    report::report_field("gaussians.moved").add(r, 3);
    CHECK(r.gaussians.moved == 15);
    CHECK(report::report_field("lost").count(r) == 5);
    CHECK(report::report_field("exchanged_bytes.capacity").count(r) == 0xffffffffffffffffu);
    CHECK(report::report_field("host_ms.picture").milliseconds(r) == r.host_ms.picture);
}

TEST_CASE("a report's text")
{
    auto r = all_different();
    r.passes = {1005, 6, 7, 8};
    r.exchanges = {1001, 2, 3, 4};
    r.host_ms = {.project = 0.5, .route = 1.5, .bloom = 2.5, .composite = 3.5, .picture = 0.75, .total = 1008.5};
    r.copies = 31;
    r.lost_copies = 32;
    r.late_copies = 33;
    std::string lines;
    for (auto const line : report::text_lines)
        if (line != "homes") lines += std::string(line) + ": " + report::numbers_of(r, line) + "\n";
    std::ostringstream text;
    text << r;
    CHECK(text.str() == "    stage  passes  exchanges  host ms\n"
                        "---------  ------  ---------  -------\n"
                        "  project   1,005      1,001     0.50\n"
                        "    route       6          2     1.50\n"
                        "    bloom       7          3     2.50\n"
                        "composite       8          4     3.50\n"
                        "  picture       0          0     0.75\n"
                        "    other       0          0   999.75\n"
                        "    frame   1,026      1,010  1008.50\n" + lines);
    CHECK(lines.find("\nmissing: 5 records and copies (1 unplaced, 1 storage_full, 3 late)\ncopies: 31 on tiles, 32 lost, 33 late\nexchanged: ") != lines.npos);
    CHECK(lines.find(", 18,446,744,073,709,551,615 bytes if each exchange moved all channels whole\n") != lines.npos);
    for (auto const& field : report::report_fields)
        if (!field.line.empty() && field.line != "homes")
            CHECK(lines.find(" " + report::thousands(field.count(r)) + " " + std::string(field.phrase)) != lines.npos);
    CHECK(report::numbers_of(FrameReport{}, "missing") == "0 records and copies");
    CHECK(report::total(r, "passes") == 1026);
    CHECK(report::total(r, "passes.bloom") == 7);
    CHECK(report::total(r, "copies") == 31);
    CHECK(report::total(r, "host_ms") == 0);
    auto full = r;
    full.full_tiles = {1200, 17, 3105, 2000};
    std::ostringstream more;
    more << full;
    CHECK(more.str() == text.str() + "full tiles: 1,200, most of all tile 17: it needs 3,105 slots and has 2,000\n");
    CHECK(report::numbers_of(all_different(), "no such line").empty());
    auto homes = r;
    homes.program = report::Program::homes;
    homes.homes = {.rounds = 43, .parcels = 44, .entries = 45, .refused = 46, .unfinished_tiles = 47, .chapters = 48, .streamed_bytes = 49};
    homes.unfinished = {{4, 2.5f}, {9, 1.25f}, {11, 1.25f}};
    std::ostringstream rounds;
    rounds << homes;
    CHECK(rounds.str() == text.str() + "homes: 43 rounds, 44 parcels sent, 45 entries, 46 refused, 47 tiles unfinished, 48 chapters, 49 bytes streamed\n"
                                       "unfinished: 3 tiles, the nearest cut on tile 9: it is exact up to depth 1.25\n");
    CHECK(std::string(report::to_string(report::Program::automatic)) == "auto");
}

TEST_CASE("a report as a line of CSV: the camera quoted, then every exact field under its name")
{
    CHECK(report::csv_header().starts_with("camera,size_px.width,size_px.height,passes.project,passes.route,"));
    auto r = all_different();
    r.camera = "a \"b\", c";
    std::string line = "\"a \"\"b\"\", c\"";
    for (auto const& field : report::report_fields)
        if (field.exact()) line += "," + std::to_string(field.count(r));
    CHECK(report::csv_row(r) == line);
    auto const header = report::csv_header(), row = report::csv_row(all_different());
    CHECK(std::count(header.begin(), header.end(), ',') == std::count(row.begin(), row.end(), ','));
}

TEST_CASE("two reports differ in the first exact field that differs, and host time is none")
{
    auto a = all_different();
    a.peak_channel = 42;
    a.gaussians.moved = 12;
    auto b = a;
    b.host_ms.total = 9;
    CHECK(report::first_difference(a, b).empty());
    CHECK(report::same_report(a, b));

    b.peak_channel = 43;
    CHECK(report::first_difference(a, b) == "peak.channel: 42 and 43");
    CHECK_FALSE(report::same_report(a, b));
    b.gaussians.moved = 99;
    CHECK(report::first_difference(a, b) == "gaussians.moved: 12 and 99");
    CHECK(report::first_difference(a, b, {"gaussians"}) == "peak.channel: 42 and 43");
    CHECK(report::first_difference(a, b, {"gaussians.held"}) == "gaussians.moved: 12 and 99");
    CHECK(report::first_difference(a, b, {"gaussians.moved", "peak"}).empty());
    b.camera = "sloth/back";
    CHECK(report::first_difference(a, b) == "camera: sloth/front and sloth/back");
    CHECK_THROWS_WITH_AS(
        report::first_difference(a, b, {"gausians"}),
        "cannot ignore gausians (a report has no such field); take a name or a group of report_fields", tilemesh::Error);
}

TEST_CASE("two reports with as many losses differ in the first loss that differs, and in digests that both have")
{
    auto a = all_different();
    a.digests = {51, 52};
    auto const differ = [&](std::string const& in, auto const& change, std::initializer_list<std::string_view> ignored = {}) {
        auto b = a;
        change(b);
        CHECK(report::first_difference(a, b, ignored) == in);
    };
    std::pair<std::string, void (*)(FrameReport&)> const losses[] = {
        {"lost[1]: Gaussian 8 on tile 1439 (storage_full) and Gaussian 8 on tile 1438 (storage_full)", [](FrameReport& b) { b.lost[1].tile = 1438; }},
        {"lost[2]: Gaussian 9 on tile 3 (late) and Gaussian 9 on tile 3 (storage_full)",
         [](FrameReport& b) { b.lost[2].cause = report::Cause::storage_full; }},
        {"lost[0]: Gaussian 7 (unplaced, tile 1000 is full) and Gaussian 7 (unplaced, tile 12 is full)",
         [](FrameReport& b) { b.lost[0].full_tile = 12; }},
        {"full_tiles: none and 2 with tile 17, which needs 3105 of 2000 slots",
         [](FrameReport& b) {
             b.full_tiles = {2, 17, 3105, 2000};
         }},
        {"lost: 5 and 4", [](FrameReport& b) { b.lost.pop_back(); }}};
    for (auto const& [text, change] : losses) {
        differ(text, change);
        differ("", change, {"lost"});
    }
    differ(losses[0].first, [&](FrameReport& b) { losses[0].second(b), losses[1].second(b); }); // the first one
    differ("digests[1]: 52 and 53", [](FrameReport& b) { b.digests[1] = 53; });
    differ("digests: 2 and 1", [](FrameReport& b) { b.digests = {51}; });
    differ("", [](FrameReport& b) { b.digests.clear(); }); // not asked for
}

TEST_SUITE_END();
