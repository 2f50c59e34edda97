#include "options.hpp"
#include "../shared/input_rows.hpp"

namespace track_camera {

namespace {

using namespace shared;
using tilemesh::track::Method;

constexpr Word methods[] = {{"hybrid", Method::hybrid}, {"forward", Method::forward}, {"gradient", Method::gradient}, {"esm", Method::esm}};
constexpr Option<Options> rows[] = {
    words<&Options::method>("method", "NAME", "{} [hybrid]", methods),
    option<&Options::one_in>("one-in", "N", "evaluates one in N blocks of pixels [1]", {1, 1'000'000}),
    option<&Options::tile>("tile", "WxH", "pixels of a tile [follows from the size]", {1, 65535}, {}, "32x20")};
constexpr Option<Options> outputs[] = {
    option<&Options::save_photos>("save-photos", "DIR", "also writes the pictures that are tracked, as --photos reads them")};

OptionTable table_of(Options& o)
{
    OptionTable table("track_camera",
                      "usage: track_camera [MAP] [options]\n"
                      "Finds the pose of each picture of a sequence from the last one. The pictures are real ones, or are\n"
                      "rendered from the map along a trajectory and spoilt as a camera would.\n"
                      "  MAP                   a map that render_map reads [the built-in map]\n",
                      true);
    table.takes_words("map", 1, [&o](std::string_view word) { o.map = word; });
    add_sequence(table, o, "size in pixels of rendered pictures [640x480]",
                 "folder for estimated.tum, truth.tum, cameras.json, paths.svg and residual.png [.]");
    table.add("What comes out", o, outputs);
    table.add("Tracking", o, rows);
    table.add("The host", o, host_rows);
    table.pair({{Pairing::excludes, "photos", "save-photos", "--save-photos is for rendered pictures, and --photos has its own"}});
    return table;
}

} // namespace

std::optional<Options> options_of(int argc, char** argv)
{
    Options o;
    o.without_depth = ", or use --no-depth";
    auto table = table_of(o);
    if (!read_command_line(table, o, &o, argc, argv)) return {};
    if (o.map) table.require({Pairing::needs, "photos", "cameras", "a picture needs the camera's lens and first pose"});
    return o;
}

} // namespace track_camera
