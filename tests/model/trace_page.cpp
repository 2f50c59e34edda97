// test: unoptimised test asan tsan
#include "../../examples/heat/heat.hpp"
#include "../engine/everywhere.hpp"
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <tilemesh/model/assumed_parameters.hpp>
#include <tilemesh/model/trace_page.hpp>
#include <tuple>

// The page of a run, for a program that is no splatting: the heat equation, and traces put together by hand.
using namespace engine_test;

namespace {
namespace fs = std::filesystem;
std::string text_of(fs::path const& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
/// A folder of its own, removed at the end.
struct Folder {
    fs::path path = fs::temp_directory_path() / "tilemesh_trace_page";
    Folder() { fs::remove_all(path); }
    ~Folder() { fs::remove_all(path); }
    std::vector<std::string> names() const
    {
        std::vector<std::string> out;
        for (auto const& file : fs::directory_iterator(path)) out.push_back(file.path().filename().string());
        std::sort(out.begin(), out.end());
        return out;
    }
};
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
struct Other {
    static constexpr char const* name = "other";
    static constexpr std::uint32_t workers = 3, clock_khz = 7;
};
} // namespace

TEST_CASE("trace page: the heat equation as files and a page")
{
    using Program = Repeat<Diffuse>;
    Grid const grid{4, 3};
    using Heated = Mesh<Program, Traced<Mk2>>;
    Heated mesh{grid, {}, Program{20}};
    mesh.broadcast<Conductivity>() = {0.1f};
    mesh.state<Cell>(grid.tile(5)).kelvin = 100;
    mesh.run();
    Folder folder;
    TracePage page;
    page.title = "Heat & <more>";
    page.facts = {{"program", "heat"}};
    auto const ledger = Tile<Mk2, Program>::ledger();
    page.ledger.assign(ledger.begin(), ledger.end());
    auto const written = write_trace_page(folder.path, "heat", mesh.trace(), mk2(), grid, page);
    CHECK(written == folder.path / "heat.html");
    CHECK(folder.names() == std::vector<std::string>{"heat.busy_cycles.ppm", "heat.channel_fill.ppm", "heat.html", "heat.idle_cycles.ppm",
                                                     "heat.maps.csv", "heat.model.txt", "heat.supersteps.csv", "heat.tiles.csv",
                                                     "heat.trace.json"});
    auto const html = text_of(written);
    CHECK(has(html, "<h1>Heat &amp; &lt;more&gt;</h1>"));
    CHECK(has(html, "Where the cycles go, by step"));
    CHECK(has(html, "Supersteps over time"));
    CHECK(has(html, "heat.tiles.csv"));
    CHECK(has(html, "in the budget"));
    auto const cost = model_cost(mk2(), mesh.trace(), grid);
    CHECK(has(html, report::thousands(cost.cycles) + " cycles, " + report::thousands(cost.supersteps.size()) + " supersteps"));
    for (auto const& kernel : mesh.trace().kernels) CHECK(has(html, "<td>" + kernel + "</td>"));
    std::ifstream model(folder.path / "heat.model.txt");
    CHECK(read_cost_model(model, "heat.model.txt") == mk2());
    // The same bytes again.
    write_trace_page(folder.path, "heat", mesh.trace(), mk2(), grid, page);
    CHECK(text_of(written) == html);
}

TEST_CASE("trace page: supersteps over time show the mean of the tiles; drawing one costs what its tiles did, not the grid")
{
    auto const trace = two_tiles();
    auto model = priced();
    model.run_cycles = 6;
    auto const cost = model_cost(model, trace, two);
    report::StackedBars chart;
    chart.title = "Supersteps over time: what the tiles do";
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
    CHECK(has(supersteps_svg(many, model, of_many, {1000, 850}), "Supersteps over time"));
}

TEST_CASE("trace page: pictures inside, maps of the caller, energy, and what is too long")
{
    Folder folder;
    EnergyModel joules;
    joules.name = "by hand";
    for (auto const* event : {"compare", "capacity_byte", "tile_cycle"}) set_energy(joules, event, 1'000'000, "a test");
    TracePage page;
    page.energy = &joules;
    page.maps = {{"numbers", "Numbers", "what a tile holds", true, {1.5, 2}}};
    page.png = [](report::Image const& image) { return "PNG" + std::to_string(image.width); };
    page.most_tile_lines = 2;
    page.most_timeline_bytes = 10;
    auto const html = text_of(write_trace_page(folder.path, "run", two_tiles(), priced(), two, page));
    CHECK(folder.names() ==
          std::vector<std::string>{"run.energy.csv", "run.html", "run.maps.csv", "run.model.txt", "run.supersteps.csv"});
    CHECK(has(html, "left out: 3 lines are more than 2"));
    CHECK(has(html, "no timeline: 2 supersteps take more than 10 bytes"));
    CHECK(has(html, "Rest &lt;1&gt;"));
    CHECK(has(html, "Numbers: what a tile holds. 0 to 2 a tile, 3.5 in all."));
    CHECK(has(html, "data:image/png;base64," + report::base64("PNG32"))); // 2 tiles of 16 pixels
    // Superstep 0: 20 + 20 cycles, 150 + 20 of exchange, 150 of sync; superstep 1: 20, 150 and a vote of 2,690.
    CHECK(priced().vote_cycles == 2690);
    auto const cycles = (20 + 20 + 150 + 20 + 150) + (20 + 150 + 2690);
    CHECK(has(html, report::thousands(static_cast<std::uint64_t>(cycles)) + " cycles, 2 supersteps"));
    // 6 compares, 2 * 4 * 20 bytes of capacity, every cycle of both tiles: a nanojoule each.
    CHECK(has(html, report::joules_text((6 + 160 + 2 * cycles) / 1e9) + " J by by hand"));
    CHECK(has(html, "<td>compare</td><td>6</td>"));
    CHECK(text_of(folder.path / "run.maps.csv") == "tile_x,tile_y,numbers,channel_fill,busy_cycles,idle_cycles\n"
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

    Region const regions[] = {{name_of<Cell>(), "state", 600, true}, {name_of<Wall>(), "channel, 8 ends", 1234, false}};
    std::ostringstream out;
    out << ledger_table(regions, 1000);
    CHECK(out.str() == "       region  bytes of a tile\n-------------  ---------------\n         Cell              600\n"
                       "         Wall            1,234\nsum, of 1,000              600\n");
}

TEST_CASE("trace page: a folder that is a file, a map of another grid and a price without a source are refused")
{
    Folder folder;
    fs::create_directories(folder.path);
    std::ofstream(folder.path / "file") << "x";
    CHECK(has(error_of([&] { write_trace_page(folder.path / "file", "run", two_tiles(), priced(), two); }), "name another folder"));
    TracePage page;
    page.maps = {{"numbers", "Numbers", "what a tile holds", true, {1.5}}};
    CHECK(has(error_of([&] { write_trace_page(folder.path, "run", two_tiles(), priced(), two, page); }),
              "map numbers cannot be shown (it has 1 numbers, and the grid 2 tiles)"));
    auto m = mk2();
    m.prices.push_back({"compare", 1});
    CHECK(has(error_of([&] { write_trace_page(folder.path, "run", two_tiles(), m, two); }), "parameter compare has no source"));
    CHECK(has(error_of([&] { write_trace_page(folder.path, "run", two_tiles(), mk2(), two); }), "operation compare of kernel Transpose"));
    CHECK(!fs::exists(folder.path / "run.html"));
}
