#include "options.hpp"
#include "../shared/input_rows.hpp"
#include <tilemesh/error.hpp>

namespace refine {

namespace {

using namespace shared;
using tilemesh::Error;

constexpr Word optimisers[] = {{"by-kind", Optimiser::by_kind}, {"adam", Optimiser::adam}};
constexpr Option<Options> rows[] = {
    option<&Options::steps>("steps", "N", "so many steps [20 for each photograph that is not held out]", {1, 100'000'000}),
    option<&Options::every>("every", "N",
                            "holds out one in N of the sorted names, from the first; they are only compared [what the camera file lists, or 8]",
                            {2, 1'000'000}),
    words<&Options::optimiser>("optimiser", "NAME", "{}: a second moment a kind of parameter, or Adam [by-kind]", optimisers),
    option<&Options::rate>("rate", "X", "times all rates; they fall to a tenth over the run [1]", {1e-6, 1e3})};
constexpr Option<Options> own_depth_rows[] = {input<&Options::depths>(
    "depths", "PATH",
    "their depths, which the map then keeps to: an RGB-D list (associations.txt), or a folder with it, or with rgb.txt and depth.txt")};
constexpr Pairing depth_pairings[] = {{Pairing::needs, "depth-scale", "depths", "it is the scale of depth pictures"},
                                      {Pairing::needs, "depth-within", "depths", "it belongs to a list of depths"}};
constexpr Option<Options> outputs[] = {option<&Options::out>("out", "FILE", "the refined map, a PLY [refined.ply]"),
                                       option<&Options::report>("report", "FILE", "a report as JSON")};

OptionTable table_of(Options& o)
{
    OptionTable table("refine",
                      "usage: refine MAP --cameras FILE --photos DIR [options]\n"
                      "Makes a map agree better with photographs. A step renders one photograph's view, compares,\n"
                      "and moves the Gaussians that it shows. No Gaussian is added or removed. The same command writes\n"
                      "the same map, byte for byte, whatever the number of threads.\n"
                      "  MAP                   a map that render_map reads\n",
                      true);
    table.takes_words("map", 1, [&o](std::string_view word) { o.map = word; });
    table.add("The map", o, map_rows);
    table.add("The photographs", o, photograph_rows, photograph_pairings);
    table.says("photos", "the folder of the photographs, PNG or JPEG, named as the cameras");
    table.says("background", "{}: what shows through the map [0,0,0]");
    table.add("The photographs", o, own_depth_rows);
    table.add("The photographs", o, depth_rows, depth_pairings);
    table.add("The cameras", o, camera_rows, camera_pairings);
    table.says("cameras", "a camera file or a COLMAP model, as for render_map");
    table.says("size", "the size to which photographs and cameras are resized [their own]");
    table.says("scale", "photographs divided by N [1]");
    table.without("camera", "a map is refined by many views, and others are held out");
    for (auto const name : {"from", "look", "up", "fov"}) table.without(name, "photographs need the cameras that took them: --cameras");
    table.add("The run", o, rows);
    table.add("What comes out", o, outputs);
    table.add("The host", o, host_rows);
    return table;
}

} // namespace

std::optional<Options> options_of(int argc, char** argv)
{
    Options o;
    o.bends = true;
    auto table = table_of(o);
    if (!read_command_line(table, o, &o, argc, argv)) return {};
    if (o.map.empty()) throw Error("no map is named (there is nothing to refine); name one: refine MAP --cameras FILE --photos DIR");
    if (!o.cameras) throw Error("no cameras are named (photographs need their poses); add --cameras FILE");
    if (!o.photos) throw Error("no photographs are named (a map is refined by them); add --photos DIR");
    return o;
}

} // namespace refine
