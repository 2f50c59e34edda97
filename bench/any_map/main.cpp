// The cost of a complete picture: rounds, exchanges and modelled time of the program of homes, beside the anchored program and the paper's
// setup, which miss what finds no room.
#include "any_map.hpp"
#include <common/program.hpp>
#include <iostream>
#include <tilemesh/report/whole_file.hpp>

namespace {

using namespace any_map;
using shared::option;

constexpr char const* map_names[] = {"sloth", "salad", "playbot_250k", "built_in", "built_in_1m", "built_in_5m"};

constexpr auto names = shared::words_of(map_names);
constexpr shared::Option<Options> rows_of_options[] = {
    option<&Options::write>("write", "DIR", "write the plot slots.svg into this folder"),
    option<&Options::picture>("picture", "FILE",
                              "write the picture of the first page (bench/any_map/any_map.png), and measure nothing; needs playbot_250k"),
    shared::words<&Options::maps>("map", "NAME",
                                  "{}: the last two are the built-in map, densified to one or five million Gaussians; may be repeated [all]", names),
    option<&Options::threads>("threads", "N", "host threads of each machine; only host times depend on it [1]", {1, 64})};
shared::OptionTable table_of(Options& own)
{
    return bench::table_of({"any_map",
                            "Measures what a complete picture costs on one machine (Mk2, 40 x 36 tiles, 1280 x 720): rounds, exchanges,\n"
                            "hops and modelled time of the program of homes: with its fold, without it, and in slices with one cut for\n"
                            "all tiles. The anchored program and the paper's setup render the same views; they miss what finds no room.\n"
                            "Then the slots that a tile holds (K) go from 16 to 4,000, and the slots of a channel from 2 to 400. Times\n"
                            "are modelled with mk2(). A picture from which nothing is missing must have the bits of the naive\n"
                            "whole-frame loop.\n",
                            "a part of the built-in map, a small picture, few settings; takes seconds", "write a row per map, view and program"},
                           own, rows_of_options);
}

int run(Options const& options)
{
    for (auto const* file : {&options.csv, &options.picture}) bench::expect_folder_of(*file);
    if (!options.picture.empty()) {
        write_picture(options);
        return 0;
    }
    if (!options.write.empty()) bench::expect_folder_of(options.write / "slots.svg");
    std::vector<Row> rows;
    std::vector<std::string> broken;
    for (std::string const name : map_names) {
        if (!bench::chosen(options.maps, name)) continue;
        if (options.quick && options.maps.empty() && name != "built_in") continue;
        if (!bench::has_scene(name, options.data)) {
            bench::say_skipped(name);
            continue;
        }
        using tilemesh::scene::Size;
        auto const scene = bench::load_scene(name, options.data, options.quick ? Size{320, 180} : Size{1280, 720});
        measure(scene, options, options.quick || name == "salad" || name == "playbot_250k", rows, broken);
    }
    std::cout << view_table(rows) << "\n" << step_table(rows) << "\n" << sweep_table(rows) << "\n";
    for (auto const& sentence : findings(rows)) std::cout << sentence << "\n";
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv(rows));
    if (!options.write.empty()) write_plot(options.write, rows);
    return bench::verdict(broken);
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, table_of, run, "not enough memory (a million Gaussians take gigabytes); name one --map, or --quick");
}
