// test: unoptimised test asan
// The results that bench/error_vs_time finds in its rows: fronts, claims about host time, conditions that must hold, the file of all rows.
#include "../standard.hpp"
#include <error_vs_time/csv.hpp>
#include <error_vs_time/front.hpp>

namespace {

using namespace error_vs_time;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

Row row_of(std::string const& name, std::uint64_t pairs, double error, double modelled_ms = 1)
{
    Row row;
    row.scene = "sloth";
    row.camera = "orbit2";
    row.size = {640, 360};
    row.setting.name = name;
    row.setting.knob = "alpha and stop";
    row.counters.pairs = pairs;
    row.total = {error, 1, 0.5, -20 * std::log10(error), 0.99, error / 2, 0.001};
    row.cut = row.total;
    row.mesh = {0, 0, 0, infinite, 1, 0, 0};
    row.round = row.mesh;
    row.modelled_ms = modelled_ms;
    return row;
}
std::vector<bool> fronts(std::vector<Row>& rows, bool Row::*which = &Row::on_front)
{
    mark_fronts(rows);
    std::vector<bool> out;
    for (auto const& r : rows) out.push_back(r.*which);
    return out;
}
/// A view in which all conditions hold.
std::vector<Row> good_view()
{
    std::vector<Row> rows{row_of("default", 1000, 1e-3), row_of("evaluation", 1400, 1e-4), row_of("viewing", 900, 2e-3),
                          row_of("on_sensor", 750, 8e-3), row_of("other", 1200, 1e-3)};
    mark_fronts(rows);
    return rows;
}
bool says(std::vector<std::string> const& lines, std::string const& what)
{
    return std::any_of(lines.begin(), lines.end(), [&](std::string const& line) { return tests::has(line, what); });
}
std::vector<std::string> lines_of(std::string const& text)
{
    std::vector<std::string> out;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) out.push_back(line);
    return out;
}
/// The fields of a line of RFC 4180 without line breaks in it.
std::vector<std::string> fields_of_line(std::string const& line)
{
    std::vector<std::string> out{""};
    bool quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') out.back() += line[i++];
        else if (line[i] == '"') quoted = !quoted;
        else if (line[i] == ',' && !quoted) out.emplace_back();
        else out.back() += line[i];
    }
    return out;
}
/// Column to text, of each row.
std::vector<std::map<std::string, std::string>> table_of(std::string const& text)
{
    auto const lines = lines_of(text);
    auto const header = fields_of_line(lines.front());
    std::vector<std::map<std::string, std::string>> out;
    for (std::size_t i = 1; i < lines.size(); ++i) {
        auto const fields = fields_of_line(lines[i]);
        REQUIRE(fields.size() == header.size());
        out.emplace_back();
        for (std::size_t k = 0; k < fields.size(); ++k) out.back()[header[k]] = fields[k];
    }
    return out;
}

} // namespace

TEST_SUITE_BEGIN("report");

TEST_CASE("error against time: the front is what nothing beats in pairs and error at once; equal rows are on it together")
{
    std::vector<Row> rows{row_of("exact", 1000, 1e-5), row_of("good", 500, 1e-3), row_of("beaten", 600, 2e-3),
                          row_of("as many, worse", 500, 2e-3), row_of("more, as good", 800, 1e-3), row_of("cheap", 100, 1e-1)};
    CHECK(fronts(rows) == std::vector<bool>{true, true, false, false, false, true});
    for (std::size_t i : {0u, 1u, 3u, 5u}) CHECK(rows[i].front_pairs == 1); // no fewer pairs have the error of the fourth
    CHECK(rows[2].front_pairs == doctest::Approx(500.0 / 600));
    CHECK(rows[4].front_pairs == doctest::Approx(500.0 / 800));
    rows = {row_of("a", 500, 1e-3), row_of("b", 500, 1e-3), row_of("c", 501, 1e-3)};
    CHECK(fronts(rows) == std::vector<bool>{true, true, false});
    rows = {row_of("a", 500, 1e-3)};
    CHECK(fronts(rows) == std::vector<bool>{true});
    CHECK(rows[0].front_pairs == 1);
    rows.clear();
    CHECK(fronts(rows).empty());
    rows = {row_of("nothing to do", 0, 1e-3), row_of("something", 1, 1e-3)};
    CHECK(fronts(rows) == std::vector<bool>{true, false});
    CHECK(rows[0].front_pairs == 1);
    CHECK(rows[1].front_pairs == 0);

    // Four digits of the error decide, a ninth does not: all of these print as 1.235e-03.
    rows = {row_of("a", 500, 1.23456789e-3), row_of("b", 500, 1.23456780e-3), row_of("fewer", 499, 1.2350001e-3)};
    CHECK(fronts(rows) == std::vector<bool>{false, false, true});
    rows.pop_back();
    CHECK(fronts(rows) == std::vector<bool>{true, true});
    rows.push_back(row_of("seen", 500, 1.234e-3));
    CHECK(fronts(rows) == std::vector<bool>{false, false, true});
    CHECK(printed_error(row_of("", 1, 0)) == 0);
    CHECK(printed_error(row_of("", 1, 9.99951e-4)) == 1e-3); // rounding carries

    // The modelled front has its own order, as printed.
    rows = {row_of("few pairs, slow", 100, 1e-3, 2.0), row_of("many pairs, quick", 900, 1e-3, 1.0),
            row_of("as quick to four digits", 800, 1e-3, 1.00004)};
    CHECK(fronts(rows, &Row::on_front_modelled) == std::vector<bool>{false, true, true});
    CHECK(fronts(rows) == std::vector<bool>{true, false, false});
}

TEST_CASE("error against time: what failed is on no front and keeps nobody off it; fronts do not mix views")
{
    std::vector<Row> rows{row_of("a", 500, 1e-3), row_of("failed", 1, 1e-9)};
    rows[1].failed = "it did not fit";
    CHECK(fronts(rows) == std::vector<bool>{true, false});
    CHECK(rows[0].front_pairs == 1);
    rows[0].failed = "nor did it";
    CHECK(fronts(rows) == std::vector<bool>{false, false});
    rows[0].failed = rows[1].failed = "";
    rows[1].total.rmse = not_a_number;
    CHECK(fronts(rows) == std::vector<bool>{true, false});

    rows = {row_of("a", 500, 1e-3), row_of("a", 100, 1e-4), row_of("a", 100, 1e-4), row_of("b", 400, 1e-3)};
    rows[1].camera = "orbit2 x 6";
    rows[2].scene = "salad";
    CHECK(fronts(rows) == std::vector<bool>{false, true, true, true});
    CHECK(rows[0].front_pairs == doctest::Approx(0.8));
    rows.pop_back(); // marks of an earlier call go
    CHECK(fronts(rows) == std::vector<bool>{true, true, true});
    CHECK(rows[0].front_pairs == 1);
}

TEST_CASE("error against time: a band leaves out as many at both ends, the outer rank first")
{
    std::vector<double> values;
    for (int i = 15; i >= 1; --i) values.push_back(i);
    auto band = band_of(values, 0.2);
    CHECK(band.low == 3);
    CHECK(band.median == 8);
    CHECK(band.high == 13);
    band = band_of(values, 0.05);
    CHECK(band.low == 1);
    CHECK(band.high == 15);
    values.push_back(16);
    CHECK(band_of(values, 0.5).median == 8.5);
    CHECK(band_of({7}, 0.2).low == 7);
    CHECK(band_of({7}, 0.2).high == 7);
    CHECK(std::isnan(band_of({}, 0.2).median));
}

TEST_CASE("error against time: no claim about host time within the noise")
{
    std::vector<Noise> const noise{{"sloth", {0.99, 1, 1, 1.05, 1.01, 0.98, 1, 1, 1, 1}}, {"salad", {1, 1, 1, 1, 1, 1, 1, 1, 1}}};
    CHECK(noise_of(noise, "sloth") == doctest::Approx(0.05));
    CHECK(std::isinf(noise_of(noise, "salad"))); // nine rounds
    CHECK(std::isinf(noise_of(noise, "built_in")));
    auto const times = [](double ratio, double off = 0) { return std::vector<double>{ratio - off, ratio, ratio, ratio, ratio + off}; };
    struct Case {
        std::vector<double> ratios;
        double noise;
        char const* claim;
    };
    for (auto const& each : std::vector<Case>{{times(0.97), 0.05, "no claim"},
                                              {times(0.5), 0.05, "faster"},
                                              {times(1.2), 0.05, "slower"},
                                              {times(0.9, 0.06), 0.05, "no claim"}, // its band reaches into the noise: 0.96
                                              {times(0.9, 0.04), 0.05, "faster"},
                                              {times(0.95), 0.05, "no claim"}, // at the noise, not beyond it
                                              {{0.5, 0.5, 0.5}, 0.05, "faster"},
                                              {{0.5, 0.5}, 0.05, "no claim"}, // too few rounds
                                              {{2, 2}, 0.05, "no claim"},
                                              {times(0.01), infinite, "no claim"}, // noise not measured
                                              {times(100), infinite, "no claim"}}) {
        INFO(each.ratios.front(), " to ", each.ratios.back(), ", noise ", each.noise);
        CHECK(std::string(to_string(claim_of(each.ratios, each.noise))) == each.claim);
    }
    CHECK(claim_of(times(0.5), 0.05).ratio == 0.5);
    CHECK(std::isnan(claim_of({}, 0.05).ratio));

    auto row = row_of("a", 1, 1);
    row.over_default = times(0.5);
    CHECK(claim_of(row, noise).faster);
    row.scene = "salad";
    CHECK(!claim_of(row, noise).faster);
    row.scene = "sloth";
    row.failed = "no";
    CHECK(!claim_of(row, noise).faster);

    // Noise is the farther end of the band, of all measured in a scene.
    auto const ten = [](double low, double others, double high) {
        return Noise{"a", {others, others, others, high, others, low, others, others, others, others}};
    };
    CHECK(noise_of({ten(0.8, 1, 1.1)}, "a") == doctest::Approx(0.2));
    CHECK(noise_of({ten(1.3, 1.3, 1.3)}, "a") == doctest::Approx(0.3)); // a shift is noise too
    CHECK(noise_of({ten(1, 1, 1), ten(1, 1, 1.2)}, "a") == doctest::Approx(0.2));
    std::vector<double> ratios(40, 1.0); // one in forty at either end is outside the middle 90 %
    ratios.front() = 0.1;
    ratios.back() = 9;
    CHECK(noise_of({{"a", ratios}}, "a") == 0);
}

TEST_CASE("error against time: the verdict finds each thing that does not hold")
{
    CHECK(verdict_of(good_view()).holds());
    CHECK(verdict_of(good_view()).notes.empty());
    CHECK(verdict_of({}).holds());
    std::ostringstream out;
    out << verdict_of(good_view());
    CHECK(out.str() == "All that must hold does.\n");

    using Rows = std::vector<Row>;
    struct Case {
        char const* broken; ///< what the verdict says; empty: all holds
        std::function<void(Rows&)> change;
    };
    std::vector<Case> cases{
        {"sloth, orbit2, other: nothing is missing", [](Rows& rows) { rows[4].mesh.max_levels = 1e-9; }},
        {"other: nothing is missing", [](Rows& rows) { rows[4].mesh_wrong = true; }}, // of a sequence, another frame than the worst
        {"", [](Rows& rows) { rows[1].split_off = 1e-9; }},
        {"evaluation: the split does not add up", [](Rows& rows) { rows[1].split_off = 1.1e-9; }},
        {"there is no default", [](Rows& rows) { rows[0].setting.name = "standard", mark_fronts(rows); }},
        {"viewing: the name is there twice", [](Rows& rows) { rows[4].setting.name = "viewing", rows[4].front_pairs = 1; }},
        {"on_sensor: a named setting has no result (it did not fit)", [](Rows& rows) { rows[3].failed = "it did not fit"; }},
        {"", [](Rows& rows) { rows[4].front_pairs = 0.5; }}}; // an unnamed setting may be far from the front
    for (auto const missing : {&Row::lost, &Row::late, &Row::unplaced})
        cases.push_back({"", [missing](Rows& rows) { rows[4].mesh.max_levels = 9, rows[4].*missing = 1; }});
    for (std::size_t i = 0; i < 4; ++i) {
        cases.push_back({"", [i](Rows& rows) { rows[i].front_pairs = 0.98; }});
        cases.push_back({": 97.9 %", [i](Rows& rows) { rows[i].front_pairs = 0.979; }});
    }
    for (auto const& each : cases) {
        CAPTURE(each.broken);
        auto rows = good_view();
        each.change(rows);
        auto const verdict = verdict_of(rows);
        bool const holds = *each.broken == '\0';
        CHECK(verdict.holds() == holds);
        if (holds) continue;
        CHECK(verdict.broken.size() == 1);
        CHECK(says(verdict.broken, each.broken));
        std::ostringstream text;
        text << verdict;
        CHECK(tests::has(text.str(), "BROKEN: "));
    }
}

TEST_CASE("error against time: the default has to change where nine tenths of its pairs do as well")
{
    auto rows = good_view();
    rows[4] = row_of("better", 900, 1e-3);
    mark_fronts(rows);
    auto verdict = verdict_of(rows);
    CHECK(says(verdict.broken, "better: has 90.0 % of the default's pairs"));
    CHECK(says(verdict.broken, "default: 90.0 % of its pairs reach its error"));
    CHECK(verdict.broken.size() == 2); // viewing has as many pairs as the better setting, so it is not above the front by pairs
    rows[4].counters.pairs = 901;
    mark_fronts(rows);
    CHECK(!says(verdict_of(rows).broken, "better"));
    rows[4] = row_of("worse in the fourth digit", 900, 1.001e-3);
    mark_fronts(rows);
    CHECK(verdict_of(rows).holds());
    rows[4] = row_of("failed", 100, 1e-3);
    rows[4].failed = "no";
    mark_fronts(rows);
    CHECK(verdict_of(rows).holds());

    // For a sequence the text is the same, but nothing is broken.
    rows[4] = row_of("better", 500, 1e-3);
    for (auto& r : rows) r.frames = 6, r.camera = "orbit2 x 6";
    mark_fronts(rows);
    verdict = verdict_of(rows);
    CHECK(verdict.holds());
    CHECK(says(verdict.notes, "better: has 50.0 %"));
    CHECK(says(verdict.notes, "default: 50.0 %"));
    rows[0].setting.name = "standard";
    CHECK(says(verdict_of(rows).broken, "there is no default"));
}

TEST_CASE("error against time: every number is finite, but the PSNR of equal pictures")
{
    auto const bad = [](auto const& spoil) {
        for (double const value : {not_a_number, infinite, -infinite}) {
            auto rows = good_view();
            spoil(rows[4], value);
            auto const verdict = verdict_of(rows);
            CHECK(says(verdict.broken, "is not finite"));
            rows[4].failed = "then nothing below means anything";
            CHECK(verdict_of(rows).holds());
        }
    };
    for (double Row::*each : {&Row::twice_products, &Row::split_off, &Row::certified_levels, &Row::popping, &Row::modelled_ms, &Row::front_pairs})
        bad([each](Row& r, double v) { r.*each = v; });
    using Errors = tilemesh::report::ErrorMeasures;
    for (auto const part : {&Row::total, &Row::cut, &Row::round, &Row::mesh})
        for (auto const each : {&Errors::max_levels, &Errors::rmse, &Errors::ssim, &Errors::mae, &Errors::p999_levels, &Errors::share_over_one_level})
            bad([=](Row& r, double v) { r.*part.*each = v; });
    bad([](Row& r, double v) { r.host_ms = {1, v}; });
    bad([](Row& r, double v) { r.over_default = {v}; });
    auto rows = good_view();
    rows[4].total.psnr_db = not_a_number;
    CHECK(says(verdict_of(rows).broken, "a PSNR is not finite"));
    rows[4].total.psnr_db = -infinite;
    CHECK(says(verdict_of(rows).broken, "a PSNR is not finite"));
    rows[4].total.psnr_db = infinite;
    CHECK(verdict_of(rows).holds());
}

TEST_CASE("error against time: the file begins with the columns that scripts rely on")
{
    auto const lines = lines_of(csv({}, {}, {}));
    REQUIRE(lines.size() == 1);
    CHECK(lines[0].rfind("scene,camera,setting,e_cut_rmse,e_round_rmse,e_mesh_max,psnr_db,ssim,max_levels,modelled_ms,host_ms,pairs,on_front,",
                         0) == 0);
    std::map<std::string, int> seen;
    for (auto const& column : fields_of_line(lines[0])) CHECK_MESSAGE(++seen[column] == 1, column);
    for (char const* column :
         {"knob", "gaussians", "width", "height", "frames", "alpha_min", "alpha_max", "transmittance_min", "dilation", "jacobian_limit", "footprint",
          "arithmetic", "sigmas", "shape", "key_bits", "degree", "crossing", "saturation", "channel_slots", "hops", "storage_slots", "rmse",
          "p999_levels", "share_over_one_level", "mae", "e_cut_max", "e_cut_psnr_db", "e_round_max", "e_round_psnr_db", "e_mesh_rmse",
          "e_mesh_psnr_db", "twice_products", "split_off", "certified_levels", "popping_rmse", "lost", "late", "unplaced", "exchanges", "messages",
          "live_bytes", "capacity_bytes", "copies", "peak_storage", "peak_channel", "pairs_contributing", "projected_bytes", "host_rounds",
          "host_ms_min", "host_ms_p20", "host_ms_p80", "host_over_default", "host_over_default_low", "host_over_default_high", "claim", "aa_noise",
          "on_front_modelled", "front_pairs", "status", "compiler", "native", "cpu", "threads", "rounds", "seed", "git", "program", "homes_rounds"})
        CHECK_MESSAGE(seen.count(column) == 1, column);
}

TEST_CASE("error against time: the file has each number as a reader needs it")
{
    auto row = row_of("sigma 3, \"square\"", 12'345'678'901, 1.23456e-3, 4.00004);
    row.total.psnr_db = 58.16989;
    row.total.max_levels = 3.25;
    row.certified_levels = 3.25001;
    row.setting.rules.alpha_min = 1.0f / 255.0f;
    row.setting.limits = {true, 8, 2, 300};
    row.setting.knobs = {3.5f, Shape::half_conic, 16, 4, Crossing::drop};
    row.counters.exchanges = {1, 2, 3, 4};
    row.host_ms = {5, 4, 3, 2, 1};
    row.over_default = {0.5, 0.5, 0.5, 0.5, 0.5};
    row.lost = 7, row.late = 8, row.unplaced = 9;
    row.counters.messages = 11, row.counters.exchanged_live_bytes = 12, row.counters.exchanged_capacity_bytes = 13;
    row.counters.copies = 14, row.counters.peak_storage = 15, row.counters.peak_channel = 16, row.counters.pairs_contributing = 17;
    auto other = row_of("equal", 1, 0);
    other.total.psnr_db = infinite;
    other.frames = 6;
    other.popping = 0.25;
    std::vector<Row> rows{row, other};
    mark_fronts(rows);
    auto const text = csv(rows, {{"sloth", {1, 1, 1, 1, 1.02, 1, 1, 1, 1, 1}}}, {"g++ 12", "a \"fast\" one", "abc", "Release", "error_vs_time --quick", 2, 5, true});
    CHECK(text.find("\nsloth,orbit2,\"sigma 3, \"\"square\"\"\",1.2346e-03,") != std::string::npos); // quotes where they are needed alone
    auto const table = table_of(text);
    REQUIRE(table.size() == 2);
    for (auto const& [column, value] : std::map<std::string, std::string>{
             {"scene", "sloth"}, {"camera", "orbit2"}, {"setting", "sigma 3, \"square\""}, {"e_cut_rmse", "1.2346e-03"},
             {"e_round_rmse", "0.0000e+00"}, {"e_mesh_max", "0.0000"}, {"psnr_db", "58.170"}, {"ssim", "0.990000"}, {"max_levels", "3.2500"},
             {"modelled_ms", "4.0000"}, {"host_ms", "3.0000"}, {"pairs", "12345678901"}, {"on_front", "0"}, {"alpha_min", "0.003921569"},
             {"sigmas", "3.5"}, {"shape", "half_conic"}, {"key_bits", "16"}, {"degree", "4"}, {"crossing", "drop"}, {"saturation", "drop"},
             {"channel_slots", "8"}, {"hops", "2"}, {"storage_slots", "300"}, {"rmse", "1.2346e-03"}, {"mae", "6.1728e-04"},
             {"share_over_one_level", "0.001000"}, {"e_mesh_psnr_db", "inf"}, {"certified_levels", "3.2501"}, {"popping_rmse", "NaN"}, {"lost", "7"},
             {"late", "8"}, {"unplaced", "9"}, {"exchanges", "10"}, {"messages", "11"}, {"live_bytes", "12"}, {"capacity_bytes", "13"},
             {"copies", "14"}, {"peak_storage", "15"}, {"peak_channel", "16"}, {"pairs_contributing", "17"}, {"projected_bytes", "56"},
             {"host_rounds", "5"}, {"host_ms_min", "1.0000"}, {"host_ms_p20", "1.0000"}, {"host_ms_p80", "5.0000"}, {"host_over_default", "0.5000"},
             {"claim", "faster"}, {"aa_noise", "0.0200"}, {"front_pairs", "0.0000"}, {"status", "ok"}, {"compiler", "g++ 12"}, {"native", "yes"},
             {"cpu", "a \"fast\" one"}, {"threads", "2"}, {"rounds", "5"}, {"seed", "none"}, {"git", "abc"}, {"build", "Release"},
             {"command", "error_vs_time --quick"}, {"tile", "32x20"}, {"e_mesh_mae", "0.0000e+00"}, {"e_round_p999_levels", "0.0000"}}) {
        auto const& name = column; // Clang 14 captures no structured binding
        CAPTURE(name);
        REQUIRE(table[0].count(column) == 1);
        CHECK(table[0].at(column) == value);
    }
    CHECK(table[1].at("psnr_db") == "inf");
    CHECK(table[1].at("popping_rmse") == "2.5000e-01");
    CHECK(table[1].at("certified_levels") == "NaN");
    CHECK(table[1].at("host_ms") == "NaN"); // no times
    CHECK(table[1].at("claim") == "no claim");
    CHECK(table[1].at("on_front") == "1");
}

TEST_CASE("error against time: what failed stays in the file, with its knobs, NaN and the reason")
{
    std::vector<Row> rows{row_of("ran", 10, 1e-3), row_of("failed", 10, 1e-3)};
    rows[1].failed = "no room (1,000 slots, \"hold\"); give it more";
    rows[1].host_ms = rows[1].over_default = {1, 1, 1, 1, 1};
    rows[1].setting.limits.channel_slots = 3;
    mark_fronts(rows);
    auto const text = csv(rows, {}, {});
    CHECK(text.find("\"no room (1,000 slots, \"\"hold\"\"); give it more\"") != std::string::npos);
    auto const table = table_of(text);
    REQUIRE(table.size() == 2);
    auto const& row = table[1];
    CHECK(row.at("status") == rows[1].failed);
    for (char const* column :
         {"e_cut_rmse", "e_round_rmse", "e_mesh_max", "psnr_db", "ssim", "max_levels", "modelled_ms", "host_ms", "pairs", "rmse", "mae",
          "p999_levels", "share_over_one_level", "split_off", "twice_products", "lost", "exchanges", "host_ms_min", "host_over_default",
          "front_pairs", "projected_bytes"})
        CHECK_MESSAGE(row.at(column) == "NaN", column);
    CHECK(row.at("on_front") == "0");
    CHECK(row.at("on_front_modelled") == "0");
    CHECK(row.at("claim") == "no claim");
    CHECK(row.at("channel_slots") == "3");
    CHECK(row.at("width") == "640");
    CHECK(table[0].at("status") == "ok");
    CHECK(table[0].at("aa_noise") == "inf"); // it was not measured
    // Every row has a text in every column.
    std::set<std::string> const may_be_empty{"compiler", "cpu", "git", "build", "command"};
    for (auto const& each : table[0]) CHECK_MESSAGE((!each.second.empty() || may_be_empty.contains(each.first)), each.first);
}

TEST_SUITE_END();
