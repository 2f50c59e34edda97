// test: unoptimised test asan tsan
#include "../../examples/heat/heat.hpp"
#include "../engine/everywhere.hpp"
#include "../report/folder.hpp"
#include "../report/html_elements.hpp"
#include <tilemesh/model/assumed_parameters.hpp>
#include <tilemesh/model/trace_page.hpp>

// The page of a run, for a program that is no splatting: the heat equation, and traces put together by hand.
using namespace engine_test;

namespace {
using tests::contents, tests::count, tests::Folder;
/// Two supersteps of two tiles; prices with sources.
Trace two_tiles()
{
    Trace trace;
    trace.kernels = {"Transpose", "Rest <1>"};
    trace.operations = {{"compare"}, {}};
    trace.supersteps = {{0, false, 20, true, {{0, {{4}}, {0, 20, 0, 0}}, {1, {{2}}, {}}}}, {1, true, 0, false, {{1, {}, {}}}}};
    return trace;
}
CostModel priced()
{
    auto m = mk2();
    m.name = "priced";
    set_parameter(m, "clock", 1000, "a test");
    set_price(m, "compare", 5000, "a test");
    return m;
}
constexpr Grid two{2, 1};
/// One of the large numbers of a page.
std::string figure(std::string const& html, std::string const& what)
{
    auto const before = "<dt>" + what + "</dt><dd>";
    auto const at = html.find(before);
    if (at == std::string::npos) return "there is none";
    return html.substr(at + before.size(), html.find('<', at + before.size()) - at - before.size());
}
/// No number that is none, and every element closed in order, but those that HTML never closes.
bool is_sound(std::string html)
{
    for (auto at = html.find(";base64,"); at != std::string::npos; at = html.find(";base64,", at + 1)) // its letters may say anything
        html.erase(at + 8, html.find('"', at) - at - 8);
    for (auto const* none : {"nan", "inf ", "inf<", "inf,", "inf\"", "inf%", "0 kind"})
        if (has(html, none)) return false;
    return elements_close(html);
}
struct Other : Mk2 {
    static constexpr char const* name = "other";
    static constexpr std::uint32_t workers = 3, clock_khz = 7;
};
} // namespace

TEST_CASE("trace page: the heat equation as files and a page")
{
    using Program = Repeat<Diffuse>;
    Grid const grid{4, 3};
    using Heated = Mesh<Program, Traced<Mk2>>;
    Heated mesh{Program{20}, grid};
    mesh.broadcast<Conductivity>() = {0.1f};
    mesh.state<Cell>(grid.tile(5)).kelvin = 100;
    mesh.run();
    Folder folder;
    TracePage page;
    page.title = "Heat & <more>";
    page.facts = {{"program", "heat"}};
    page.maps = {{"kelvin", "Temperature", "temperature after the run", false, {}, "K"}};
    for (std::uint32_t t = 0; t < grid.size(); ++t) page.maps[0].values.push_back(mesh.state<Cell>(grid.tile(t)).kelvin);
    auto const ledger = Tile<Mk2, Program>::ledger();
    page.ledger.assign(ledger.begin(), ledger.end());
    auto const written = write_trace_page(folder.path, "heat", mesh.trace(), mk2(), grid, page);
    CHECK(written == folder.path / "heat.html");
    CHECK(folder.names() == std::vector<std::string>{"heat.html", "heat.maps.csv", "heat.model.txt", "heat.supersteps.csv", "heat.tiles.csv",
                                                     "heat.trace.json"});
    auto const html = contents(written);
    CHECK(has(html, "<h1>Heat &amp; &lt;more&gt;</h1>"));
    CHECK(has(html, "Where the time goes, by step"));
    CHECK(has(html, "The run over time"));
    CHECK(has(html, "heat.tiles.csv"));
    CHECK(has(html, "<td>in the budget</td>"));
    CHECK_FALSE(has(html, " % of 1,000,000</td>"));
    auto const cost = model_cost(mk2(), mesh.trace(), grid);
    // The page opens with the sentence that names the bottleneck, then the numbers.
    auto const sentence = bottleneck_text(find_bottleneck(mk2(), mesh.trace(), cost, grid), mk2(), mesh.trace(), cost, grid);
    CHECK(has(html, "</h1>\n<p class=\"lead\">" + report::html_text(sentence) + "</p>"));
    CHECK(has(html, "count no operations, so that their compute costs no more than to start them: " + mesh.trace().kernels[0] + "."));
    CHECK(figure(html, "cycles") == report::thousands(cost.cycles));
    CHECK(figure(html, "passes") == "20");
    CHECK(figure(html, "exchanges") == "20");
    CHECK(figure(html, "tiles") == "4 x 3");
    CHECK(is_sound(html));
    CHECK(count(html, "data:image/bmp;base64,") == 1); // all tiles do the same, so only the caller's map differs from tile to tile
    CHECK(has(html, "<b>Temperature</b>"));
    CHECK(has(html, "<details><summary><h3>3 maps are the same on every tile</h3></summary>"));
    CHECK(has(html, "Channel fill: the fullest end of a channel, after the pass in which it was fullest. It is 100 % on every tile."));
    CHECK(has(html, "Idle cycles: modelled cycles that the tile waits for the slowest tile&#39;s compute. It is 0 cycles on every tile."));
    CHECK(has(html, "<td>exchange_cost</td><td>capacity</td><td></td>"));
    for (auto const& kernel : mesh.trace().kernels) CHECK(has(html, "<td>" + kernel + "</td>"));
    CHECK(has(html, "<td>all alike, such as (0, 0) in 20 of 20 passes: nothing counted</td></tr>"));
    std::ifstream model(folder.path / "heat.model.txt");
    CHECK(read_cost_model(model, "heat.model.txt") == mk2());
    // The same bytes again.
    write_trace_page(folder.path, "heat", mesh.trace(), mk2(), grid, page);
    CHECK(contents(written) == html);
    page.sram_bytes = 1'000'000;
    CHECK(has(contents(write_trace_page(folder.path, "heat", mesh.trace(), mk2(), grid, page)), " % of 1,000,000</td>"));
    CHECK(has(contents(write_trace_page(folder.path, "heat", mesh.trace(), grid, page)), " % of 1,000,000</td>"));
}

TEST_CASE("trace page: supersteps over time show the mean of the tiles; drawing one costs what its tiles did, not the grid")
{
    auto const trace = two_tiles();
    auto model = priced();
    model.run_cycles = 6;
    auto const cost = model_cost(model, trace, two);
    report::StackedBars chart;
    chart.title = "The run over time: which step runs, and what the tiles do";
    chart.x_label = "modelled milliseconds";
    chart.y_label = "percent of tile time";
    chart.parts = {{"busy", 4}, {"idle", 7}, {"exchange", 1}, {"sync", 3}, {"vote", 6}};
    chart.layout = report::BarLayout::along_x;
    chart.y_high = 100;
    chart.width = 1200;
    // Tile 0 compares four times at 5 cycles, tile 1 twice; then tile 1 alone only enters and leaves.
    for (auto const& [at, busy, slowest] : {std::tuple{0u, 21.0, 26.0}, {1u, 3.0, 6.0}}) {
        auto const& c = cost.supersteps[at];
        CHECK(static_cast<double>(c.compute) == slowest);
        auto const share = [&](double cycles) { return 100 * cycles / static_cast<double>(c.total()); };
        chart.bars.push_back({"", {share(busy), share(slowest - busy), share(static_cast<double>(c.exchange)),
                                   share(static_cast<double>(c.sync)), share(static_cast<double>(c.vote))}});
        chart.bars.back().width = milliseconds(model, c.total());
        chart.spans.push_back({trace.kernels[at], milliseconds(model, c.total())});
    }
    CHECK(supersteps_svg(trace, model, cost, two) == svg(chart));

    // 20,000 supersteps of two of 850,000 tiles: minutes, if each looked at the whole grid.
    auto many = trace;
    auto of_many = cost;
    for (int i = 0; i < 20'000; ++i) {
        many.supersteps.push_back(trace.supersteps[0]);
        of_many.supersteps.push_back(cost.supersteps[0]);
        of_many.cycles += cost.supersteps[0].total();
    }
    CHECK(has(supersteps_svg(many, model, of_many, {1000, 850}), "The run over time"));
}

TEST_CASE("trace page: pictures inside, maps of the caller, energy, and what is too long")
{
    Folder folder;
    EnergyModel joules;
    joules.name = "by hand";
    for (auto const* event : {"compare", "capacity_byte", "tile_cycle"}) set_energy(joules, event, 1'000'000, "a test");
    TracePage page;
    page.energy = &joules;
    page.maps = {{"numbers", "Numbers", "what a tile holds", true, {1.5, 2}, "things"}};
    page.png = [](report::Image const& image) { return "PNG" + std::to_string(image.width) + "x" + std::to_string(image.height); };
    page.most_tile_lines = 2;
    page.most_timeline_bytes = 10;
    auto const html = contents(write_trace_page(folder.path, "run", two_tiles(), priced(), two, page));
    CHECK(folder.names() ==
          std::vector<std::string>{"run.energy.csv", "run.html", "run.maps.csv", "run.model.txt", "run.supersteps.csv"});
    CHECK(has(html, "left out: 3 lines are more than 2"));
    CHECK(has(html, "no timeline: 2 passes take more than 10 bytes"));
    CHECK(has(html, "Rest &lt;1&gt;"));
    CHECK(has(html, "<b>Numbers</b>what a tile holds. Most: 2 things on tile (1, 0). Sum: 3.5."));
    CHECK(has(html, "<span>0 things</span><span>1</span><span>2 things</span>"));
    CHECK(has(html, "data:image/png;base64," + report::base64("PNG2x1"))); // a pixel a tile
    CHECK(has(html, "<b>Energy</b>joules of all that is counted. Most: "));
    CHECK(is_sound(html));
    // Superstep 0: 20 + 20 cycles, 150 + 20 of exchange, 150 of sync; superstep 1: 20, 150 and a vote of 2,690.
    CHECK(priced().vote_cycles == 2690);
    auto const cycles = (20 + 20 + 150 + 20 + 150) + (20 + 150 + 2690);
    CHECK(figure(html, "cycles") == report::thousands(static_cast<std::uint64_t>(cycles)));
    CHECK(figure(html, "passes") == "2");
    CHECK(figure(html, "exchanges") == "1");
    // 6 compares, 2 * 4 * 20 bytes of capacity, every cycle of both tiles: a nanojoule each.
    CHECK(has(html, "<dt>energy</dt><dd>" + report::significant((6 + 160 + 2 * cycles) / 1e9, 6) + " J</dd>"));
    CHECK(has(html, "<td>compare</td><td>6</td>"));
    CHECK(has(html, "<p>The weakest prices behind this time are guessed: "));
    CHECK(contents(folder.path / "run.maps.csv") == "tile_x,tile_y,numbers,channel_fill,busy_cycles,idle_cycles\n"
                                                    "0,0,1.5,100,40,20\n1,0,2,0,50,10\n");
}

TEST_CASE("trace page: a ledger for a terminal, and what is assumed about a machine")
{
    auto const m = assumed_model<Other>(32, 40);
    CHECK(price_of(m, "slot") == price_of(mk2(), "slot") / 2); // 3 workers take turns, not 6
    CHECK(price_of(m, "pair") == price_of(mk2(), "pair"));     // of all workers
    CHECK(m.vote_cycles == 80);
    auto const text = assumed_text(m);
    CHECK(text.starts_with("assumed: clock 7 kHz, slot 12,000 millicycles, projection"));
    CHECK(has(text, ", exchange_byte 31 millicycles (a tile receives 32 bytes in a cycle; rounded to whole millicycles), sync 40 cycles, vote 80"));
    CHECK(assumed_text(mk2()).empty());

    machine::Region const regions[] = {{name_of<Cell>(), "state", 600, true}, {name_of<Wall>(), "channel, 8 ends", 1234, false}};
    std::ostringstream out;
    out << ledger_table(regions, 1000);
    CHECK(out.str() == "       region  bytes of a tile\n-------------  ---------------\n         Cell              600\n"
                       "         Wall            1,234\nsum, of 1,000              600\n");
}

TEST_CASE("trace page: without a cost model it shows what ran, and no times")
{
    Folder folder;
    TracePage page;
    page.title = "Untimed";
    page.run = "sort";
    auto const html = contents(write_trace_page(folder.path, "run", two_tiles(), two, page));
    CHECK(folder.names() == std::vector<std::string>{"run.html", "run.maps.csv", "run.tiles.csv"});
    CHECK(has(html, "</h1>\n<p class=\"lead\">The sort took 2 passes and 1 exchange; the most loaded tile is (0, 0), which sent 20 bytes, "
                    "2.0 times the mean.</p>"));
    CHECK(has(html, "No cost model is given"));
    CHECK(has(html, "<td>Transpose</td><td>1</td><td>1</td><td>2</td><td>20</td>"));
    CHECK(has(html, "<b>Operation compare</b>how often the tile did it. Most: 4 compare on tile (0, 0). Sum: 6."));
    CHECK_FALSE(has(html, "<svg"));
    CHECK_FALSE(has(html, " ms"));
    CHECK(is_sound(html));
    CHECK(contents(folder.path / "run.maps.csv") == "tile_x,tile_y,channel_fill,sent_bytes,tile_runs,operation_0\n0,0,100,20,1,4\n1,0,0,0,2,2\n");
    // Nothing ran: still a page.
    auto const empty = contents(write_trace_page(folder.path, "empty", Trace{}, two));
    CHECK(is_sound(empty));
    CHECK(has(empty, "The run took 0 passes and 0 exchanges."));
}

TEST_CASE("trace page: for each step the slowest tile, and what it counted in the passes in which it is the slowest")
{
    Trace trace;
    trace.kernels = {"Work", "Rest", "Never", "Even"};
    trace.operations = {{"compare", "move", "skip"}, {}, {"compare"}, {"compare"}};
    auto const work = [&](TileSample const& first, TileSample const& second) { trace.supersteps.push_back({0, false, 0, false, {first, second}}); };
    work({0, {{90}}, {}}, {1, {{80}}, {}});          // 20 cycles to start, and 5 each: 470 of tile 0; the 80 of tile 1 do not count
    work({0, {{70}}, {}}, {1, {{1200, 1000}}, {}});  // 20 + 6,000 + 1,000 of tile 1
    work({0, {{1}}, {}}, {1, {{34, 600}}, {}});      // 20 + 170 + 600 of tile 1
    trace.supersteps.push_back({1, true, 0, false, {{1, {}, {}}}});
    trace.supersteps.push_back({3, true, 0, false, {{0, {{4}}, {}}, {1, {{4}}, {}}}});
    auto model = priced();
    set_price(model, "move", 1000, "a test");
    set_price(model, "skip", 1000, "a test");
    Folder folder;
    auto const row_of = [&](std::string const& step) {
        auto const html = contents(write_trace_page(folder.path, "run", trace, model, two));
        CHECK(has(html, "<th>share</th><th>bounded by, in passes</th><th>slowest tile and its operations</th></tr>"));
        CHECK(has(html, "<table class=\"l1 l13 l14 w14\">")); // words stand left, with room for some in a line
        CHECK(is_sound(html));
        auto const row = html.substr(html.find("<tr><td>" + step + "</td>"));
        return row.substr(0, row.find("</tr>"));
    };
    // 6,170 and 1,600 of 7,810 cycles; nothing was skipped.
    CHECK(row_of("Work").ends_with("<td>(1, 0) in 2 of 3 passes:\n1,234 compare (79.0 %)\n1,600 move (20.5 %)</td>"));
    CHECK(row_of("Rest").ends_with("<td>(1, 0): nothing counted</td>"));
    CHECK(row_of("Never").ends_with("<td></td>"));
    CHECK(row_of("Even").ends_with("<td>all alike, such as (0, 0):\n4 compare (50.0 %)</td>"));
    // The operation with the most cycles is first: 16,000 of 22,210.
    set_price(model, "move", 10'000, "a test");
    CHECK(row_of("Work").ends_with("<td>(1, 0) in 2 of 3 passes:\n1,600 move (72.0 %)\n1,234 compare (27.8 %)</td>"));
    // A tile that did as much in all, but not in each pass, is not alike.
    trace.supersteps.push_back({3, true, 0, false, {{0, {{3}}, {}}, {1, {{2}}, {}}}});
    trace.supersteps.push_back({3, true, 0, false, {{0, {{2}}, {}}, {1, {{3}}, {}}}});
    CHECK(row_of("Even").ends_with("<td>(0, 0) in 2 of 3 passes:\n7 compare (46.7 %)</td>"));
}

TEST_CASE("trace page: every step is named once on the timeline and has its own name in each table")
{
    auto trace = two_tiles();
    trace.kernels = {"Transpose", "Transpose", "Never"};
    trace.operations = {{"compare"}, {}, {}};
    trace.supersteps[0].tiles[1].operations.settled_bytes = 12; // so the page has the table of ideal routing
    Folder folder;
    auto const html = contents(write_trace_page(folder.path, "run", trace, priced(), two));
    auto const timeline = html.substr(html.find("The run over time"), html.find("</svg>", html.find("The run over time")) - html.find("The run over time"));
    CHECK(count(timeline, ">Transpose 1</text>") == 1);
    CHECK(count(timeline, ">Transpose 2</text>") == 1);
    CHECK(count(timeline, "Never") == 0); // it never ran
    auto const bars = html.substr(html.find("Where the time goes, by step"));
    for (auto const* name : {"Transpose 1", "Transpose 2", "Never"}) {
        CHECK(count(bars.substr(0, bars.find("</svg>")), ">" + std::string(name) + "</text>") == 1);
        CHECK(count(html, "<td>" + std::string(name) + "</td>") == (name == std::string("Never") ? 2 : 1)); // ideal routing joins the first two
    }
    CHECK(has(html, "<h3>Ideal routing</h3>"));
    CHECK(has(html, "<td>Transpose 1 to Transpose 2</td>"));
    trace.supersteps[0].tiles[1].operations.settled_bytes = 0; // every bound would be 0
    CHECK_FALSE(has(contents(write_trace_page(folder.path, "run", trace, priced(), two)), "Ideal routing"));
    CHECK(has(html, "Slowest: the synchronisation of step Transpose 2; "));
}

TEST_CASE("trace page: a program's reason stands in the first sentence; the slowest tile is outlined in the picture and in each map")
{
    Folder folder;
    auto trace = two_tiles();
    trace.supersteps[0].tiles[1].operations.count[0] = 2000;
    TracePage page;
    page.run = "frame";
    page.because = [](Bottleneck const& b) { return "tile " + std::to_string(b.tile) + " of step " + std::to_string(b.step) + " has <many>"; };
    report::Image picture(60, 20); // of two tiles of 32 x 20 pixels; the second one's last 4 columns are outside
    page.picture = &picture;
    page.tile_px = {32, 20};
    auto const html = contents(write_trace_page(folder.path, "run", trace, priced(), two, page));
    CHECK(has(html, "Slowest: tile (1, 0); "));
    CHECK(has(html, " of the frame is its compute in step Transpose, 2.0 times the mean of all tiles, because tile 1 of step 0 has &lt;many&gt;; "));
    CHECK(count(html, "style=\"aspect-ratio: 60.000 / 20.000\"") == 4);
    CHECK(count(html, "<img alt=\"a map of the grid: ") == 3);
    CHECK(count(html, "style=\"width: 106.667%; height: 100.000%\"") == 3);
    CHECK(count(html, "<i style=\"left: 53.333%; top: 0.000%; width: 53.333%; height: 100.000%\"></i>") == 4);
    CHECK(has(html, "<b>The picture</b>60 x 20 pixels, on 2 x 1 tiles"));
    CHECK(is_sound(html));
    page.tile_px = {32, 0};
    CHECK(has(error_of([&] { write_trace_page(folder.path, "run", trace, priced(), two, page); }), "a tile has no pixels"));
}

TEST_CASE("trace page: each round of a loop is one span of the timeline if its steps would be too many, then all rounds are")
{
    Trace trace;
    trace.kernels = {"Start", "A", "B", "End"};
    auto const add = [&](std::uint32_t step) { trace.supersteps.push_back({step, false, 0, false, {{0, {}, {}}}}); };
    auto const names = [&](std::uint64_t rounds) {
        trace.supersteps.clear();
        trace.loops = {{1, 2, rounds}};
        add(0);
        for (std::uint64_t i = 0; i < rounds; ++i) add(1), add(2);
        add(3);
        std::vector<std::string> out;
        double all = 0;
        for (auto const& span : step_spans(trace, priced(), model_cost(priced(), trace, two))) out.push_back(span.name), all += span.width;
        CHECK(all == doctest::Approx(milliseconds(priced(), model_cost(priced(), trace, two).cycles)));
        return out;
    };
    CHECK(names(19).size() == 40);
    auto const each = names(20);
    REQUIRE(each.size() == 22);
    CHECK(each[0] == "Start");
    CHECK(each[1] == "round 1");
    CHECK(each[20] == "round 20");
    CHECK(each[21] == "End");
    CHECK(names(38).size() == 40);
    CHECK(names(39) == std::vector<std::string>{"Start", "39 rounds of A, B", "End"});
    {   // The run comes to its loop twice, as a frame in chapters.
        auto const once = trace.supersteps;
        trace.loops[0].rounds = 78;
        trace.supersteps.insert(trace.supersteps.end(), once.begin(), once.end());
        auto const spans = step_spans(trace, priced(), model_cost(priced(), trace, two));
        REQUIRE(spans.size() == 6);
        CHECK(spans[1].name == "39 rounds of A, B");
        CHECK(spans[4].name == "39 rounds of A, B");
    }
    names(20);
    trace.loops[0].rounds = 21; // a round of which no superstep ran: they cannot be told apart
    CHECK(step_spans(trace, priced(), model_cost(priced(), trace, two))[1].name == "21 rounds of A, B");
    trace.loops = {{0, 3, 1}, {1, 2, 20}}; // the outer one comes first
    auto const cost = model_cost(priced(), trace, two);
    REQUIRE(step_spans(trace, priced(), cost).size() == 1);
    CHECK(step_spans(trace, priced(), cost)[0].name == "1 round of Start, A, B, End");
}

TEST_CASE("trace page: a map's picture for a file has the shape of the tiles")
{
    TileMap const map{"m", "M", "m", true, std::vector<double>(40 * 36, 1.0)};
    auto const size = [&](std::array<std::uint32_t, 2> tile_px) {
        auto const image = map_image(map, {40, 36}, tile_px);
        return std::pair(image.width, image.height);
    };
    CHECK(size({32, 20}) == std::pair(40u * 16, 36u * 10)); // 8 x 5, twice
    CHECK(size({1, 1}) == std::pair(40u * 16, 36u * 16));
    CHECK(size({37, 23}) == std::pair(40u * 16, 36u * 10)); // no whole number of times: 16 x 9.9
    CHECK(size({1000, 1}) == std::pair(640u, 36u));
    TileMap const wide{"m", "M", "m", true, std::vector<double>(1000, 1.0)};
    CHECK(map_image(wide, {1000, 1}).width == 1000);
}

TEST_CASE("trace page: the cost model's table has the prices of operations that the run counted, and no others")
{
    Folder folder;
    auto model = priced();
    set_price(model, "never_counted", 7, "assumed: 7");
    auto const cell = [](std::string const& name) { return "<td>" + name + "</td>"; };
    auto const counted = contents(write_trace_page(folder.path, "run", two_tiles(), model, two));
    CHECK(has(counted, cell("compare")));
    CHECK(has(counted, cell("exchange_byte"))); // no operation
    CHECK_FALSE(has(counted, cell("never_counted")));
    CHECK(has(counted, "prices of operations that this run did not count"));
    CHECK(has(contents(folder.path / "run.model.txt"), "never_counted"));
    auto few = two_tiles();
    for (auto& superstep : few.supersteps)
        for (auto& tile : superstep.tiles) tile.operations = {};
    CHECK_FALSE(has(contents(write_trace_page(folder.path, "few", few, model, two)), cell("compare")));
}

TEST_CASE("trace page: a folder that is a file, a map of another grid and a price without a source are refused")
{
    Folder folder;
    tests::put(folder.path / "file", "x");
    CHECK(has(error_of([&] { write_trace_page(folder.path / "file", "run", two_tiles(), priced(), two); }), "name another folder"));
    TracePage page;
    page.maps = {{"numbers", "Numbers", "what a tile holds", true, {1.5}}};
    CHECK(has(error_of([&] { write_trace_page(folder.path, "run", two_tiles(), priced(), two, page); }),
              "map numbers cannot be shown (it has 1 numbers, and the grid 2 tiles)"));
    auto m = mk2();
    m.prices.push_back({"compare", 1});
    CHECK(has(error_of([&] { write_trace_page(folder.path, "run", two_tiles(), m, two); }), "parameter compare has no source"));
    CHECK(has(error_of([&] { write_trace_page(folder.path, "run", two_tiles(), mk2(), two); }), "operation compare of kernel Transpose"));
    CHECK(!std::filesystem::exists(folder.path / "run.html"));
}
