#include "scaling.hpp"
#include <algorithm>
#include <common/machine.hpp>
#include <common/scenes.hpp>
#include <common/statistics.hpp>
#include <iostream>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>

namespace scaling {

int chips(Options const& options)
{
    bench::expect_folder_of(options.csv);
    constexpr tilemesh::scene::Size size{1280, 864}; // whole pixels on the tiles of each array
    auto const scene = bench::load_scene("built_in", options.data, size);
    auto const cameras = bench::cameras_of("orbit0.5", scene, 3, options.data);
    auto const borders = tilemesh::mk2_chips();
    std::string csv = "chips,frame,exchange,supersteps,one_chip_ms,array_ms,crossing_ms,busiest_border_bytes\n";
    tilemesh::report::Table table{{"chips", "frame", "exchange", "supersteps", "one big chip, ms", "array, ms", "array / chip", "longest border, bytes"}};
    for (std::uint32_t const side : {1u, 2u, 8u}) {
        if (options.quick && side == 8) continue;
        tilemesh::Grid const grid{side * borders.columns, side * borders.rows};
        auto const machine = bench::make_traced_machine(scene.map, roomy_setup(), {.threads = options.threads.back(), .grid = {grid.width, grid.height}});
        for (std::size_t frame = 0; frame < cameras.size(); ++frame) {
            machine->render(cameras[frame]);
            if (frame != 0 && frame + 1 != cameras.size()) continue;
            for (auto const cost : {tilemesh::ExchangeCost::capacity, tilemesh::ExchangeCost::live}) {
                auto model = tilemesh::mk2();
                model.exchange_cost = cost;
                auto const one = tilemesh::model_cost(model, machine->trace(), grid);
                model.chips = borders;
                auto const array = tilemesh::model_cost(model, machine->trace(), grid);
                std::uint64_t crossing = 0, busiest = 0;
                for (auto const& s : array.supersteps) {
                    crossing += s.crossing;
                    busiest = std::max(busiest, s.crossing_bytes);
                }
                auto const ms = [&](std::uint64_t cycles) { return tilemesh::milliseconds(model, cycles); };
                auto const name = std::to_string(side) + " x " + std::to_string(side);
                auto const what = frame == 0 ? "first" : "0.5 degrees later";
                auto const kind = cost == tilemesh::ExchangeCost::capacity ? "capacity" : "live";
                auto const n = std::to_string(array.supersteps.size());
                table.add_row({name, what, kind, n, bench::fixed(ms(one.cycles), 3), bench::fixed(ms(array.cycles), 3),
                               bench::fixed(static_cast<double>(array.cycles) / static_cast<double>(one.cycles), 2),
                               tilemesh::report::thousands(busiest)});
                csv += name + "," + what + "," + kind + "," + n + "," + bench::fixed(ms(one.cycles), 6) + "," + bench::fixed(ms(array.cycles), 6) +
                       "," + bench::fixed(ms(crossing), 6) + "," + std::to_string(busiest) + "\n";
            }
        }
    }
    std::cout << "Modelled: one picture of " << size.width << " x " << size.height << " pixels on arrays of chips of " << borders.columns << " x "
              << borders.rows << " tiles, as one grid, against one chip of as many tiles.\n"
              << table << "Borders: " << borders.crossing_cycles << " cycles of latency, " << borders.crossing_millicycles_a_byte
              << " millicycles a byte. " << borders.source << ".\n";
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv);
    return 0;
}

} // namespace scaling
