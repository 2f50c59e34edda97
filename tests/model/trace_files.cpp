// test: unoptimised test asan, without tsan
#include "model_by_hand.hpp"
#include <locale>
#include <nlohmann/json.hpp>
#include <tilemesh/model/trace_files.hpp>

// The files and sums made of a trace: hand-computed ones, names that need quoting, and how big a frame's timeline is.
using namespace tilemesh;
using engine_test::two_supersteps::by_hand;
using engine_test::model;
using engine_test::two_supersteps::row;

namespace {

template <class Write>
std::string written(Write write)
{
    std::ostringstream out;
    write(out);
    return out.str();
}
std::string trace_csv(Trace const& t, CostModel const& m, Grid g)
{
    return written([&](auto& out) { write_trace_csv(out, t, m, g); });
}
std::string step_csv(Trace const& t, CostModel const& m, Grid g)
{
    return written([&](auto& out) { write_step_csv(out, t, m, g); });
}
std::string chrome(Trace const& t, CostModel const& m, Grid g, std::uint32_t busiest = 64)
{
    return written([&](auto& out) { write_chrome_trace(out, t, m, g, busiest); });
}

using Names = std::map<std::uint32_t, std::string>;
struct Timeline {
    Names names; ///< of the tracks
    std::map<std::uint32_t, std::vector<nlohmann::json>> spans;
};
/// Checks what a viewer relies on.
Timeline timeline(std::string const& text)
{
    auto const json = nlohmann::json::parse(text);
    Timeline out;
    for (auto const& e : json.at("traceEvents")) {
        CHECK(e.at("pid") == 1);
        auto const tid = e.at("tid").get<std::uint32_t>();
        if (e.at("ph") == "M") {
            if (e.at("name") == "thread_name") CHECK(out.names.emplace(tid, e.at("args").at("name")).second);
            if (e.at("name") == "thread_sort_index") CHECK(e.at("args").at("sort_index") == tid);
            continue;
        }
        CHECK(e.at("ph") == "X");
        CHECK(e.at("args").at("cycles").get<std::uint64_t>() > 0);
        CHECK(out.names.contains(tid));
        out.spans[tid].push_back(e);
    }
    // As Perfetto reads times: none of a track overlaps the one before.
    for (auto const& [tid, spans] : out.spans) {
        std::int64_t end = 0;
        std::size_t overlaps = 0;
        for (auto const& e : spans) {
            auto const ts = static_cast<std::int64_t>(e.at("ts").get<double>() * 1000.0);
            overlaps += ts < end;
            end = ts + static_cast<std::int64_t>(e.at("dur").get<double>() * 1000.0);
        }
        CHECK(overlaps == 0);
    }
    return out;
}

/// A machine on which nothing takes time.
CostModel free_of_charge()
{
    CostModel m;
    m.prices = {{"slot", 0}, {"routed", 0}};
    return m;
}

double sum(std::vector<double> const& v)
{
    return std::accumulate(v.begin(), v.end(), 0.0);
}
double sum(RunCost const& cost)
{
    std::uint64_t cycles = 0;
    for (auto const& step : cost.busy) cycles = std::accumulate(step.begin(), step.end(), cycles);
    return static_cast<double>(cycles);
}

/// Every tile runs in every superstep, with six-digit counts of each operation: as wide as a frame's lines get.
Trace large(std::uint32_t supersteps, Grid grid)
{
    Trace trace;
    for (std::uint32_t i = 0; i < 7; ++i) trace.kernels.push_back("kernel_of_a_longer_name" + std::to_string(i));
    trace.operations.assign(7, engine_test::seven_kinds());
    std::uint32_t n = 1;
    for (std::uint32_t i = 0; i < supersteps; ++i) {
        SuperstepSample s{i % 7, i % 2 == 1, 24'000, true, {}};
        for (std::uint32_t tile = 0; tile < grid.size(); ++tile) {
            TileSample t{tile, {}, {}};
            for (std::uint32_t kind = 0; kind < 7; ++kind) {
                auto& count = t.operations.count[kind];
                n = n * 1'664'525 + 1'013'904'223; // the generator of Numerical Recipes
                count = 100'000 + n / 5000;        // to 958,993
            }
            t.operations.settled_bytes = t.operations.count[0];
            for (auto& bytes : t.sent_bytes) bytes = 10'000 + n % 9000;
            s.tiles.push_back(t);
        }
        trace.supersteps.push_back(s);
    }
    return trace;
}
constexpr Grid paper{40, 36};

/// Thousands with dots, as some locales have them.
struct Dots : std::numpunct<char> {
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
};
} // namespace

TEST_CASE("trace files: each round of a loop is a span of the timeline, with its number")
{
    auto trace = large(20, {2, 1});
    trace.loops = {{1, 5, 3}}; // supersteps 0 to 6, 7 to 13, 14 to 19
    auto const m = model();
    auto const cost = model_cost(m, trace, {2, 1});
    auto const seen = timeline(chrome(trace, m, {2, 1}));
    REQUIRE(seen.names.at(3) == "rounds");
    CHECK(seen.names.at(4).starts_with("tile "));
    auto const& spans = seen.spans.at(3);
    REQUIRE(spans.size() == 3);
    std::uint64_t all = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(spans[i].at("name") == "round " + std::to_string(i + 1) + " of 3");
        CHECK(spans[i].at("args").at("superstep") == 7 * i + 1);
        CHECK(spans[i].at("args").at("passes") == 5);
        std::uint64_t cycles = 0, before = 0;
        for (std::size_t s = 0; s < 7 * i + 1; ++s) before += cost.supersteps[s].total();
        for (std::size_t s = 7 * i + 1; s < 7 * i + 6; ++s) cycles += cost.supersteps[s].total();
        CHECK(spans[i].at("args").at("cycles") == cycles);
        CHECK(spans[i].at("ts").get<double>() * static_cast<double>(m.clock_khz) / 1000 == doctest::Approx(static_cast<double>(before)));
        all += cycles;
    }
    CHECK(all < cost.cycles);
    trace.loops = {{1, 5, 3}, {2, 4, 3}}; // two tracks
    auto const two_loops = timeline(chrome(trace, m, {2, 1}));
    CHECK(two_loops.names.at(3) == "rounds of " + trace.kernels[1] + " to " + trace.kernels[5]);
    CHECK(two_loops.names.at(4) == "rounds of " + trace.kernels[2] + " to " + trace.kernels[4]);
    CHECK(two_loops.spans.at(4).size() == 3);
    trace.loops = {{1, 5, 4}}; // one round has no superstep: none has a span
    CHECK(timeline(chrome(trace, m, {2, 1})).names.at(3).starts_with("tile "));
}

TEST_CASE("trace files: tables of three tiles and two supersteps, by hand")
{
    CHECK(trace_csv(by_hand(), model(), row) == "superstep,step,kernel,tile_x,tile_y,slot,projection,routed,copied,comparison,pair,pixel,"
                                                "north_bytes,east_bytes,west_bytes,south_bytes,settled_bytes,compute_cycles\n"
                                                "0,0,Send,0,0,2,0,1,0,0,0,0,0,12,0,0,0,17\n"
                                                "0,0,Send,1,0,6,0,3,0,0,0,0,0,20,0,0,0,31\n"
                                                "0,0,Send,2,0,0,0,0,0,0,0,0,0,0,0,0,0,10\n"
                                                "1,1,Take,1,0,1,0,0,0,0,0,0,0,0,0,0,4,11\n"
                                                "1,1,Take,2,0,3,0,0,0,0,0,0,0,0,0,0,12,12\n");
    std::string const header = "superstep,step,kernel,tiles_run,compute_cycles,exchange_cycles,sync_cycles,vote_cycles,"
                               "slowest_x,slowest_y,bound_by\n";
    CHECK(step_csv(by_hand(), model(), row) == header + "0,0,Send,3,31,124,7,0,1,0,port in (0 0)\n1,1,Take,2,12,0,7,3,2,0,compute (2 0)\n");
    // In a column, x and y change places.
    CHECK(step_csv(by_hand(), model(), {1, 3}) == header + "0,0,Send,3,31,124,7,0,0,1,port in (0 0)\n1,1,Take,2,12,0,7,3,0,2,compute (0 2)\n");
    // A machine on which nothing takes time has no slowest tile.
    CHECK(step_csv(by_hand(), free_of_charge(), row) == header + "0,0,Send,3,0,0,0,0,,,\n1,1,Take,2,0,0,0,0,,,\n");
}

TEST_CASE("trace files: each operation and side has its own column")
{
    Trace trace;
    trace.kernels = {"K"};
    trace.operations = {engine_test::seven_kinds()};
    trace.supersteps = {{0, false, 0, true, {{0, {{1, 2, 3, 4, 5, 6, 4'294'967'295u}, 10}, {7, 8, 9, 4'000'000'000u}}}}};
    auto m = model();
    m.prices.back().millicycles = most_millicycles; // of a pixel
    auto const text = trace_csv(trace, m, {1, 1});
    CHECK(text.substr(text.find('\n') + 1) == "0,0,K,0,0,1,2,3,4,5,6,4294967295,7,8,9,4000000000,10,429496729500029\n");
}

TEST_CASE("trace files: the timeline of three tiles and two supersteps, by hand")
{
    auto const t = timeline(chrome(by_hand(), model(), row));
    // Busy: 17, 42, 22.
    Names const names{{1, "steps"}, {2, "machine"}, {3, "tile 1, 0"}, {4, "tile 2, 0"}, {5, "tile 0, 0"}};
    CHECK(t.names == names);
    struct Span {
        std::string name;
        double begin, cycles;
    };
    std::map<std::uint32_t, std::vector<Span>> const expected = {
        {1, {{"Send", 0, 162}, {"Take", 162, 22}}},
        {2, {{"compute", 0, 31}, {"exchange", 31, 124}, {"sync", 155, 7}, {"compute", 162, 12}, {"sync", 174, 7}, {"vote", 181, 3}}},
        {3, {{"Send", 0, 31}, {"Take", 162, 11}}},
        {4, {{"Send", 0, 10}, {"Take", 162, 12}}},
        {5, {{"Send", 0, 17}}}};
    REQUIRE(t.spans.size() == expected.size());
    for (auto const& [tid, spans] : expected) {
        auto const& is = t.spans.at(tid);
        REQUIRE(is.size() == spans.size());
        for (std::size_t i = 0; i < spans.size(); ++i) {
            CHECK(is[i].at("name") == spans[i].name);
            CHECK(is[i].at("ts").get<double>() == doctest::Approx(spans[i].begin + 0.00025).epsilon(1e-12));
            CHECK(is[i].at("dur").get<double>() == spans[i].cycles);
            CHECK(is[i].at("args").at("cycles").get<double>() == spans[i].cycles);
        }
    }
    CHECK(t.spans.at(1)[1].at("args") == nlohmann::json{{"superstep", 1}, {"cycles", 22}, {"step", 1}, {"passes", 1}});
    CHECK(t.spans.at(3)[0].at("args") == nlohmann::json{{"superstep", 0}, {"cycles", 31}, {"slot", 6}, {"routed", 3}, {"sent_bytes", 20}});
    CHECK(t.spans.at(2)[3].at("args") == nlohmann::json{{"superstep", 1}, {"step", 1}, {"kernel", "Take"}, {"cycles", 12},
                                                        {"tiles_run", 2}, {"slowest", "tile 2, 0"}});

    CHECK(timeline(chrome(by_hand(), model(), row, 1)).names == Names{{1, "steps"}, {2, "machine"}, {3, "tile 1, 0"}});
    CHECK(timeline(chrome(by_hand(), model(), row, 0)).spans.size() == 2);
    CHECK(timeline(chrome(by_hand(), model(), row, 3)).spans.size() == 5);
    CHECK(timeline(chrome(by_hand(), free_of_charge(), row)).spans.empty()); // nothing takes time

    // Of tiles that are equally busy, the lower index comes first.
    auto equal = model();
    for (auto& p : equal.prices) p.millicycles = 0;
    CHECK(timeline(chrome(by_hand(), equal, row)).names == names);
    auto reversed = by_hand();
    reversed.supersteps.pop_back();
    CHECK(timeline(chrome(reversed, equal, row, 2)).names == Names{{1, "steps"}, {2, "machine"}, {3, "tile 0, 0"}, {4, "tile 1, 0"}});
}

TEST_CASE("trace files: on the timeline a step is one span until another step runs; steps of one kernel have different names")
{
    auto trace = by_hand();
    trace.kernels = {"Send", "Send"};
    trace.supersteps = {trace.supersteps[0], trace.supersteps[0], trace.supersteps[1], trace.supersteps[0]};
    auto const spans = timeline(chrome(trace, model(), row)).spans;
    REQUIRE(spans.at(1).size() == 3);
    std::vector<std::string> names;
    std::vector<std::uint64_t> cycles, passes;
    for (auto const& e : spans.at(1)) {
        names.push_back(e.at("name"));
        cycles.push_back(e.at("args").at("cycles"));
        passes.push_back(e.at("args").at("passes"));
    }
    CHECK(names == std::vector<std::string>{"Send 1", "Send 2", "Send 1"});
    CHECK(cycles == std::vector<std::uint64_t>{324, 22, 162});
    CHECK(passes == std::vector<std::uint64_t>{2, 1, 1});
    CHECK(spans.at(1)[2].at("args").at("superstep") == 3);
    CHECK(spans.at(3)[1].at("name") == "Send 1");
}

TEST_CASE("trace files: without a cost model the lines have no cycles")
{
    auto const with = trace_csv(by_hand(), model(), row);
    auto const without = written([&](auto& out) { write_trace_csv(out, by_hand(), row); });
    CHECK(without.starts_with("superstep,step,kernel,tile_x,tile_y,slot,"));
    std::istringstream a(with), b(without);
    std::string full, cut;
    while (std::getline(a, full)) {
        REQUIRE(std::getline(b, cut));
        CHECK(cut == full.substr(0, full.rfind(',')));
    }
    CHECK_FALSE(std::getline(b, cut));
    CHECK_THROWS_AS(written([&](auto& out) { write_trace_csv(out, by_hand(), {2, 1}); }), Error);
}

TEST_CASE("trace files: times are cut to nanoseconds, and cycles stay exact")
{
    auto m = model();
    m.clock_khz = 1'325'000; // 31 cycles are 23.39 ns, 155 are 116.98, 162 are 122.26
    auto const text = chrome(by_hand(), m, row, 0);
    CHECK(text.find("\"ts\":0.00025,\"dur\":0.023,\"name\":\"compute\"") != std::string::npos);
    CHECK(text.find("\"ts\":0.02325,\"dur\":0.093,\"name\":\"exchange\"") != std::string::npos);
    CHECK(text.find("\"ts\":0.11625,\"dur\":0.006,\"name\":\"sync\"") != std::string::npos);
    CHECK(timeline(text).spans.at(2)[1].at("args").at("cycles") == 124);

    // A run of days: no product of cycles passes 64 bits.
    Trace trace;
    trace.kernels = {"K"};
    trace.operations = {{"slot"}};
    trace.supersteps.assign(2, {0, false, 0, false, {{0, {{4'000'000'000u}}, {}}}});
    m.prices[0].millicycles = most_millicycles; // 4 * 10^14 cycles, and 10; 301,886,792,452.8377 us; a sync of 7
    auto const days = chrome(trace, m, {1, 1}, 0);
    CHECK(days.find("\"ts\":0.00025,\"dur\":301886792452.837,") != std::string::npos);
    CHECK(days.find("\"ts\":301886792452.84325,\"dur\":301886792452.837,") != std::string::npos);
}

TEST_CASE("trace files: names that need quoting")
{
    std::string const name = "a \"b\", c\\d\n\t\x01\x7f <\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80>";
    auto trace = by_hand();
    trace.kernels[1] = name;
    auto m = model();
    m.name = name;
    CHECK(tests::has(step_csv(trace, m, row), "1,1,\"a \"\"b\"\", c\\d\n\t\x01\x7f <\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80>\",2,12"));
    CHECK(trace_csv(trace, m, row).find("1,1,\"a \"\"b\"\", c") != std::string::npos);
    auto const text = chrome(trace, m, row);
    CHECK(text.find("c\\\\d\\n\\t\\u0001\x7f") != std::string::npos);
    auto const t = timeline(text);
    CHECK(t.spans.at(1)[1].at("name") == name);
    CHECK(t.spans.at(3)[1].at("name") == name);
    CHECK(t.spans.at(2)[3].at("args").at("kernel") == name);
    CHECK(nlohmann::json::parse(text).at("traceEvents")[0].at("args").at("name") == name);

    // Names that need none have none; an empty one is a field too.
    for (auto const& [name_of, field] : {std::pair("a b\\c", "a b\\c"), {"", ""}, {"a,b", "\"a,b\""}, {"\"", "\"\"\"\""}, {"a\rb", "\"a\rb\""}})
        CHECK(model_detail::csv_field(name_of) == field);
}

TEST_CASE("trace files: heat maps by hand")
{
    auto const t = by_hand();
    auto const m = model();
    using Values = std::vector<double>;
    CHECK(heat_map(t, m, row, TileSum::busy_cycles) == Values{17, 42, 22});
    CHECK(heat_map(t, m, row, TileSum::idle_cycles) == Values{26, 1, 21}); // of 31 and 12
    CHECK(heat_map(t, m, row, TileSum::sent_bytes) == Values{12, 20, 0});
    CHECK(heat_map(t, m, row, TileSum::tile_runs) == Values{1, 2, 2});
    CHECK(heat_map(t, m, row, TileSum::settled_bytes) == Values{0, 4, 12});
    CHECK(heat_map(t, m, row, TileSum::channel_fill) == Values{0.5, 20.0 / 24, 0}); // of 24 bytes
    CHECK(heat_map(t, row, "slot") == Values{2, 7, 3});
    CHECK(heat_map(t, row, "routed") == Values{1, 3, 0});
    CHECK(heat_map(t, row, "pixel") == Values{0, 0, 0});
    CHECK_THROWS_WITH_AS(heat_map(t, row, "swap"),
                         "no heat map of operation swap (the program's kernels count slot, projection, routed, copied, comparison, pair, "
                         "pixel); name one of these", Error);
    // A tile that never ran is idle all the time.
    CHECK(heat_map(t, m, {2, 2}, TileSum::idle_cycles) == std::vector<double>{26, 1, 21, 43});
    CHECK(std::string(name_of(TileSum::busy_cycles)) == "busy_cycles");
    CHECK(std::string(name_of(TileSum::tile_runs)) == "tile_runs");
    CHECK(std::string(name_of(TileSum::channel_fill)) == "channel_fill");
}

TEST_CASE("trace files: channel fill is the fullest side of the fullest superstep, 1 where no slot is left")
{
    Trace trace;
    trace.kernels = {"K", "L"};
    trace.supersteps = {{0, false, 40, true, {{0, {}, {8, 24, 0, 0}}, {1, {}, {39, 0, 0, 0}}, {2, {}, {0, 0, 0, 10}}}},
                        {1, false, 20, true, {{0, {}, {0, 0, 8, 0}}, {1, {}, {0, 0, 0, 20}}}},
                        {0, false, 0, false, {{2, {}, {}}}}}; // no channel, so nothing is full
    CHECK(heat_map(trace, model(), row, TileSum::channel_fill) == std::vector<double>{0.6, 1, 0.25});
    for (std::uint32_t i = 0; i < tile_sum_kinds; ++i)
        CHECK(heat_map(trace, model(), row, static_cast<TileSum>(i)).size() == row.size());
    CHECK(heat_map(Trace{}, model(), row, TileSum::channel_fill) == std::vector<double>(3, 0.0));
}

TEST_CASE("trace files: nothing ran")
{
    Trace none;
    CHECK(trace_csv(none, model(), row).find('\n') == trace_csv(none, model(), row).size() - 1);
    CHECK(step_csv(none, model(), row).find('\n') == step_csv(none, model(), row).size() - 1);
    auto const t = timeline(chrome(none, model(), row));
    CHECK(t.spans.empty());
    CHECK(t.names.size() == 2);
    CHECK(timeline(chrome(none, model(), {0, 0})).spans.empty());
    CHECK(heat_map(none, model(), row, TileSum::idle_cycles) == std::vector<double>(3, 0.0));
    none.operations = {{"slot"}};
    none.kernels = {"K"};
    CHECK(heat_map(none, {0, 0}, "slot").empty());

    // A superstep without tiles is still synchronised.
    Trace quiet;
    quiet.kernels = {"K"};
    quiet.supersteps = {{0, true, 0, false, {}}};
    CHECK(step_csv(quiet, model(), row).find("\n0,0,K,0,0,0,7,3,,,sync\n") != std::string::npos);
    auto const spans = timeline(chrome(quiet, model(), row)).spans;
    REQUIRE(spans.size() == 2);
    CHECK(spans.at(1).size() == 1);
    CHECK(spans.at(2).size() == 2);
}

TEST_CASE("trace files: a trace of another grid or program, and a model without a clock, are refused")
{
    auto const text = [](auto f) { return tests::error_of(f); };
    std::string const grid =
        "cannot read the trace (superstep 0 ran tile 2 of a grid of 2 x 1); give the trace and the grid of one run";
    CHECK(text([] { trace_csv(by_hand(), model(), {2, 1}); }) == grid);
    CHECK(text([] { step_csv(by_hand(), model(), {2, 1}); }) == grid);
    CHECK(text([] { chrome(by_hand(), model(), {2, 1}); }) == grid);
    CHECK(text([] { heat_map(by_hand(), model(), {2, 1}, TileSum::tile_runs); }) == grid);
    CHECK(text([] { heat_map(by_hand(), {2, 1}, "slot"); }) == grid);
    auto other = by_hand();
    other.kernels.pop_back();
    CHECK(text([&] { trace_csv(other, model(), row); }) ==
          "cannot read the trace (superstep 1 ran step 1 of a program of 1); give the trace and the grid of one run");
    auto stopped = model();
    stopped.clock_khz = 0;
    CHECK(text([&] { chrome(by_hand(), stopped, row); }) ==
          "cannot lay the trace over time (the clock of model \"by hand\" is 0 kHz); give it one from 1 to 1000000000 kHz");
    CHECK(text([&] { step_csv(by_hand(), stopped, row); }).empty());
    stopped.clock_khz = most_clock_khz;
    CHECK(text([&] { chrome(by_hand(), stopped, row); }).empty());
    ++stopped.clock_khz;
    CHECK(text([&] { chrome(by_hand(), stopped, row); }).find("is 1000000001 kHz") != std::string::npos);
    auto slow = model();
    slow.prices[0].millicycles = most_millicycles + 1; // sums that may not fit
    CHECK_THROWS_AS(trace_csv(by_hand(), slow, row), Error);
    CHECK_THROWS_AS(heat_map(by_hand(), slow, row, TileSum::busy_cycles), Error);
}

TEST_CASE("trace files: sums over tiles are the cost model's, for both ways of paying for the exchange")
{
    Grid const grid{9, 7};
    auto const trace = large(23, grid);
    for (auto exchange : {ExchangeCost::capacity, ExchangeCost::live}) {
        auto m = model();
        m.exchange_cost = exchange;
        m.clock_khz = 1'325'000;
        auto const cost = model_cost(m, trace, grid);
        double compute = 0;
        for (auto const& s : cost.supersteps) compute += static_cast<double>(s.compute);
        auto const busy = sum(heat_map(trace, m, grid, TileSum::busy_cycles));
        CHECK(busy == sum(cost));
        CHECK(busy + sum(heat_map(trace, m, grid, TileSum::idle_cycles)) == grid.size() * compute);
        CHECK(sum(heat_map(trace, m, grid, TileSum::tile_runs)) == grid.size() * 23.0);

        // All of them on the timeline: tracks end where the model does.
        auto const t = timeline(chrome(trace, m, grid, grid.size()));
        std::uint64_t steps = 0, machine = 0, tiles = 0;
        for (auto const& [tid, spans] : t.spans)
            for (auto const& e : spans) (tid == 1 ? steps : tid == 2 ? machine : tiles) += e.at("args").at("cycles").get<std::uint64_t>();
        CHECK(steps == cost.cycles);
        CHECK(machine == cost.cycles);
        CHECK(static_cast<double>(tiles) == busy);
        auto const& last = t.spans.at(2).back();
        auto const end = last.at("ts").get<double>() + last.at("dur").get<double>();
        CHECK(std::abs(end - milliseconds(m, cost.cycles) * 1000) < 0.002);
    }
}

TEST_CASE("trace files: the timeline of a frame on the paper's grid stays far below 20 MB")
{
    auto const trace = large(150, paper);
    auto m = model();
    m.clock_khz = 1'325'000;
    auto const text = chrome(trace, m, paper);
    CHECK(text.size() < 3'000'000);
    auto const t = timeline(text);
    CHECK(t.names.size() == 66);
    for (auto const& [tid, spans] : t.spans) CHECK((tid == 2 || spans.size() == 150));
    auto const csv = trace_csv(trace, m, paper);
    CHECK(csv.size() < 27'000'000);
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 150 * 1440 + 1);
}

TEST_CASE("trace files: the same bytes in any locale and with any format of the stream")
{
    auto const trace = large(3, {4, 2});
    auto const plain = chrome(trace, model(), {4, 2}) + trace_csv(trace, model(), {4, 2}) + step_csv(trace, model(), {4, 2});
    auto const before = std::locale::global(std::locale(std::locale::classic(), new Dots));
    std::ostringstream out;
    out.imbue(std::locale());
    out << std::hex;
    out.width(40);
    write_chrome_trace(out, trace, model(), {4, 2});
    write_trace_csv(out, trace, model(), {4, 2});
    write_step_csv(out, trace, model(), {4, 2});
    std::locale::global(before);
    CHECK(out.str() == plain);
}
