// How few bytes a pixel can hold a picture: storage, channels and records become smaller, then the map.
#include <algorithm>
#include <cmath>
#include <common/compact.hpp>
#include <common/machine.hpp>
#include <common/pictures.hpp>
#include <common/program.hpp>
#include <common/scenes.hpp>
#include <filesystem>
#include <iostream>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/report/plot.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <utility>

namespace {

namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
namespace render = tilemesh::render;
using bench::db;
using bench::fixed;
using bench::Image;
using bench::psnr;
using tilemesh::report::thousands;

struct Options : bench::Options {
    std::filesystem::path write; ///< the folder of curve.svg; empty: not written
};
constexpr shared::Option<Options> options_of_it[] = {shared::option<&Options::write>("write", "DIR", "write the plot curve.svg into this folder")};
shared::OptionTable table_of(Options& own)
{
    return bench::table_of({"bytes_a_pixel",
                            "Renders 256 x 256 pixels on 8 x 8 tiles whose SRAM is 2,000 to 10 bytes a pixel (code is not counted).\n",
                            "the built-in map alone, few rows", "write a row per map, bytes a pixel and record"},
                           own, options_of_it);
}

struct Row {
    std::string map;
    std::uint32_t budget = 0, record_bytes = 60;
    std::uint64_t bytes = 0; ///< of a tile, without code
    std::uint32_t storage = 0, channel = 0;
    std::uint64_t gaussians = 0;       ///< of the shrunk map
    double shrunk_db = 0, psnr_db = 0; ///< the error of the shrunk map alone; and of the picture
    std::uint64_t missing = 0, exchanges = 0;
};
constexpr std::uint32_t side = 256, tiles = 64, tile_pixels = side * side / tiles;

/// The n Gaussians that are largest: opacity times the product of their two larger axes.
scene::Map shrunk(scene::Map map, std::uint64_t n)
{
    if (map.gaussians.size() <= n) return map;
    auto const size_of = [](splat::Gaussian const& g) {
        auto const& s = g.log_scale;
        return g.opacity * std::exp(s[0] + s[1] + s[2] - std::min({s[0], s[1], s[2]}));
    };
    std::stable_sort(map.gaussians.begin(), map.gaussians.end(), [&](auto const& a, auto const& b) { return size_of(a) > size_of(b); });
    map.gaussians.resize(n);
    return map;
}
/// The map as it is after its records were packed into 16 bytes.
scene::Map packed(scene::Map map)
{
    auto const box = splat::CompactBox::of(map.gaussians.data(), static_cast<std::uint32_t>(map.gaussians.size()));
    for (auto& g : map.gaussians) {
        splat::Compact16 quarter;
        if (!try_pack(g, box, quarter)) throw tilemesh::Error("a Gaussian of " + map.name + " has no place in 16 bytes; choose another map");
        g = unpacked(quarter, box);
    }
    return map;
}
/// A tile's bytes that are not code.
std::uint64_t data_bytes(render::Setup const& setup, std::uint32_t record_bytes)
{
    auto const& s = setup.sizes;
    auto const all = render::sram_bytes_of(setup) - setup.machine.code_bytes;
    return all - (60 - record_bytes) * (s.storage + 8 * (std::uint64_t{s.road} + s.beam) + 2 * s.waiting);
}
Row measure(bench::Scene const& scene, Image const& exact, std::uint32_t budget, std::uint32_t record_bytes)
{
    auto setup = splat::setup_of<splat::Lossless>();
    setup.rules.arithmetic = splat::Arithmetic::precise;
    setup.ranks = true;
    setup.machine.sram_bytes = 1u << 30;
    setup.sizes.tile_pixels = tile_pixels;
    // Floats where they take less than a quarter of the bytes, otherwise the paper's 8 bits a channel.
    if (budget < 48) setup.colour = render::ColourFormat::rgbx8;
    auto& sizes = setup.sizes;
    sizes.road = sizes.beam = sizes.waiting = std::max(1u, budget / 16);
    sizes.storage = 0;
    auto const without = data_bytes(setup, record_bytes);
    sizes.storage = 1;
    auto const slot = data_bytes(setup, record_bytes) - without, room = std::uint64_t{budget} * tile_pixels;
    if (room < without + slot) throw tilemesh::Error("no room for a record in " + std::to_string(budget) + " bytes a pixel; choose more");
    sizes.storage = static_cast<std::uint32_t>((room - without) / slot);
    Row row{scene.map.name, budget, record_bytes, data_bytes(setup, record_bytes), sizes.storage, sizes.road};
    auto const map = shrunk(scene.map, std::uint64_t{sizes.storage} * tiles);
    row.gaussians = map.gaussians.size();
    splat::Rules const rules = setup.rules;
    row.shrunk_db = psnr(tilemesh::report::render_naive(map.gaussians, scene.camera, rules), exact);
    auto const machine = bench::make_machine(record_bytes == 16 ? packed(map) : map, setup, {.grid = {8, 8}, .keep_pixels = false});
    machine->render(scene.camera);
    row.psnr_db = psnr(machine->image(), exact);
    row.missing = machine->report().lost.size();
    row.exchanges = machine->report().exchanges.total();
    return row;
}

void write_plot(std::filesystem::path const& folder, std::vector<Row> const& rows)
{
    tilemesh::report::Plot plot{
        "256 x 256 pixels, 8 x 8 tiles, LargestFirst", {"bytes a pixel", tilemesh::report::PlotScale::logarithmic}, {"PSNR, dB"}, {}, "exact"};
    for (auto const& r : rows) {
        auto const name = r.map + ", " + std::to_string(r.record_bytes) + " bytes";
        if (plot.series.empty() || plot.series.back().name != name)
            plot.series.push_back({.name = name, .points = {}, .colour = static_cast<std::uint32_t>(plot.series.size())});
        plot.series.back().points.emplace_back(static_cast<double>(r.bytes) / tile_pixels, r.psnr_db);
    }
    tilemesh::report::write_svg(folder / "curve.svg", plot);
}
int run(Options const& options)
{
    bench::expect_folder_of(options.csv);
    if (!options.write.empty()) bench::expect_folder_of(options.write / "curve.svg");
    std::vector<Row> rows;
    std::vector<std::string> broken;
    for (std::string const name : {"sloth", "salad", "built_in"}) {
        if ((options.quick && name != "built_in") || !bench::has_scene(name, options.data)) continue;
        auto const scene = bench::load_scene(name, options.data, {side, side});
        auto rules = splat::setup_of<splat::Lossless>().rules;
        rules.arithmetic = splat::Arithmetic::precise;
        if (options.spoil) rules.alpha_max = bench::spoilt_alpha_max;
        auto const exact = tilemesh::report::render_naive(scene.map.gaussians, scene.camera, rules);
        std::vector<std::uint32_t> budgets{2000, 1400, 998, 700, 500, 350, 250, 180, 128, 90, 64, 45, 32, 24, 16, 10};
        if (options.quick) budgets = {2000, 64, 10};
        for (std::uint32_t const record : {60u, 16u})
            for (auto const budget : budgets) {
                rows.push_back(measure(scene, exact, budget, record));
                auto const& r = rows.back();
                bool const whole = r.missing == 0 && r.gaussians == scene.map.gaussians.size() && record == 60 && budget >= 48;
                if ((whole && !std::isinf(r.psnr_db)) || r.bytes > std::uint64_t{budget} * tile_pixels)
                    broken.push_back(name + ", " + std::to_string(budget) + " bytes a pixel: not exact, or too large");
            }
    }
    tilemesh::report::Table table{
        {"map", "bytes a pixel", "record, bytes", "slots", "channel", "Gaussians", "shrunk map, dB", "picture, dB", "missing", "exchanges"}};
    std::string csv = "map,budget,record_bytes,tile_bytes,storage,channel,gaussians,shrunk_db,psnr_db,missing,exchanges\n";
    for (auto const& r : rows) {
        table.add_row({r.map, fixed(static_cast<double>(r.bytes) / tile_pixels, 1), std::to_string(r.record_bytes), thousands(r.storage),
                       thousands(r.channel), thousands(r.gaussians), db(r.shrunk_db), db(r.psnr_db), thousands(r.missing), thousands(r.exchanges)});
        csv += r.map;
        for (std::uint64_t const n :
             {std::uint64_t{r.budget}, std::uint64_t{r.record_bytes}, r.bytes, std::uint64_t{r.storage}, std::uint64_t{r.channel}, r.gaussians})
            csv += "," + std::to_string(n);
        csv += "," + db(r.shrunk_db) + "," + db(r.psnr_db) + "," + std::to_string(r.missing) + "," + std::to_string(r.exchanges) + "\n";
    }
    std::cout << table;
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv);
    if (!options.write.empty()) write_plot(options.write, rows);
    return bench::verdict(broken);
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, table_of, run, "not enough memory; take --quick");
}
