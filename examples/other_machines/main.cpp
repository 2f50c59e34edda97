// The cost of a frame on two machines that are not IPUs: 132 tiles of 256 KB, and a wafer of 1,000 x 850 tiles. Times are modelled, and the
// program prints its assumptions. tests/checks/compile_fail/pixel_processors.cpp shows why a pixel processor array cannot run a frame.
//
// usage: other_machines [--whole] [--out DIR]
// --whole: all of the wafer (100 s on two cores and 10.4 GB when it was measured); otherwise 160 x 136 tiles from its middle
// --out DIR: also each machine's cold start in files: a page (.html), its trace by tile and by superstep (.csv), a timeline for
//   ui.perfetto.dev (.trace.json), the numbers of its maps (.maps.csv), and the cost model (.model.txt)
#include "machines.hpp"
#include "report_on.hpp"
#include <cstddef>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/built_in.hpp>

int main(int argc, char** argv)
try {
    bool whole = false;
    std::filesystem::path out;
    for (int i = 1; i < argc; ++i) {
        std::string const argument = argv[i];
        if (argument == "--whole") whole = true;
        else if (argument == "--out" && i + 1 < argc && *argv[i + 1] != '\0') out = argv[++i];
        else throw tilemesh::Error("no such argument, or no DIR after it (usage: other_machines [--whole] [--out DIR]); correct " + argument);
    }
    auto const map = tilemesh::scene::built_in_map();
    // With the whole built-in map, the fullest of 132 tiles would hold 3,800 records (measured with more SRAM): show a third of the map.
    auto third = map;
    for (std::size_t i = 0; 3 * i < map.gaussians.size(); ++i) third.gaussians[i] = map.gaussians[3 * i];
    third.gaussians.resize((map.gaussians.size() + 2) / 3);
    bool ok = report_on<OnMultiprocessors>(third, tilemesh::assumed_model<Multiprocessors>(32, 1000), tilemesh::scene::built_in_camera({640, 360}),
                                           {.grid = {12, 11}, .tile = {54, 33}}, out);
    // Each tile has 2 x 2 pixels of 2,000 x 1,700. A part of the wafer shows its part of the picture.
    auto camera = tilemesh::scene::built_in_camera({2000, 1700});
    tilemesh::Extent2 const part = whole ? tilemesh::Extent2{1000, 850} : tilemesh::Extent2{160, 136};
    camera.cx -= static_cast<float>(1000 - part.width);
    camera.cy -= static_cast<float>(850 - part.height);
    camera.width = 2 * part.width;
    camera.height = 2 * part.height;
    ok = report_on<OnWafer>(map, tilemesh::assumed_model<Wafer>(4, 1850), camera, {.grid = part, .tile = {2, 2}}, out) && ok;
    return ok ? 0 : 1;
} catch (std::bad_alloc const&) {
    std::cerr << "the mesh does not fit into memory (--whole takes 10.4 GB, with --out more); leave --whole out or free memory\n";
    return 2;
} catch (std::exception const& error) { // Error, and what the system refuses
    std::cerr << error.what() << '\n';
    return 2;
}
