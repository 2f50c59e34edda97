// The cost of a complete picture: rounds, exchanges and modelled time of the program of homes, beside the anchored program and the paper's
// setup, which miss what finds no room.
#include "findings.hpp"
#include "measure.hpp"
#include "options.hpp"
#include "picture.hpp"
#include <common/program.hpp>
#include <iostream>
#include <tilemesh/report/whole_file.hpp>

namespace {

using namespace any_map;

int run(Options const& options)
{
    for (auto const* file : {&options.csv, &options.picture}) bench::expect_folder_of(*file);
    if (!options.picture.empty()) {
        write_picture(options);
        return 0;
    }
    if (!options.write.empty()) bench::expect_folder_of(options.write / "README.md");
    std::vector<Row> rows;
    std::vector<std::string> broken;
    for (std::string const name : map_names) {
        if (!bench::chosen(options.maps, name)) continue;
        if (options.quick && options.maps.empty() && name != "built_in") continue;
        if (!has(name, options)) {
            std::cout << "skipped: " << name << " (its map is not there; name its folder with --data)\n";
            continue;
        }
        auto const scene = load(name, options);
        measure(scene, options, options.quick || name == "salad" || name == "playbot_250k", rows, broken);
    }
    std::cout << view_table(rows) << "\n" << step_table(rows) << "\n" << sweep_table(rows) << "\n";
    for (auto const& sentence : findings(rows)) std::cout << sentence << "\n";
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv(rows));
    if (!options.write.empty()) write_readme(options.write, rows, broken.empty());
    for (auto const& what : broken) std::cout << "BROKEN: " << what << "\n";
    std::cout << (broken.empty() ? "All that must hold does.\n" : "");
    return broken.empty() ? 0 : 1;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, table_of, run, "not enough memory (a million Gaussians take gigabytes); name one --map, or --quick");
}
