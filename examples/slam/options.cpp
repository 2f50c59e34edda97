#include "options.hpp"
#include "../shared/input_rows.hpp"
#include <algorithm>

namespace slam_program {

namespace {

using namespace shared;
using tilemesh::slam::Optimiser;
using tilemesh::track::Method;

constexpr Word optimisers[] = {{"adam", Optimiser::adam}, {"by-kind", Optimiser::by_kind}};
constexpr Word methods[] = {{"hybrid", Method::hybrid}, {"forward", Method::forward}};
constexpr Option<Options> maps[] = {
    input<&Options::render>("render", "MAP", "views of this map, spoilt as a camera would [of the built-in map]"),
    input<&Options::map>("map", "MAP", "start from this map [an empty one]")};
constexpr Option<Options> rows[] = {
    words<&Options::method>("method", "NAME", "how frames are tracked: {} [hybrid; forward for pictures of less than 320 pixels across]", methods),
    option<&Options::keyframe_every>("keyframe-every", "N", "a keyframe after so many frames [5]", {1, 1'000'000}),
    option<&Options::most_open>("open", "SHARE", "{}: a keyframe where more of a picture is not covered [0.08]", {0, 1}),
    option<&Options::steps>("steps", "N", "steps of refinement after a keyframe, twice as many after the first [30]", {0, 1'000'000}),
    option<&Options::finish>("finish", "N", "steps by each keyframe after the last frame [5]", {0, 1'000'000}),
    words<&Options::optimiser>("optimiser", "NAME", "{} [adam]", optimisers),
    option<&Options::cell>("cell", "N", "new Gaussians stand for cells of N x N pixels [2]", {1, 64})};
constexpr Option<Options> outputs[] = {
    option<&Options::page>("page", "FILE", "a page as HTML: numbers, three pictures of the map while it grows, the path"),
    option<&Options::resume>("resume", "", "keep the state of the run in --out, and go on from the state of a run that was stopped")};

OptionTable table_of(Options& o)
{
    OptionTable table("slam",
                      "usage: slam [--photos DIR | --render MAP] [options]\n"
                      "Makes a map from pictures with depth, and finds the camera's pose in each: no map is needed. The\n"
                      "same command writes the same map, byte for byte, whatever the number of threads.\n",
                      true);
    table.add("The map", o, maps);
    add_sequence(table, o, "size in pixels of rendered pictures [320x240]",
                 "folder for map.ply, estimated.tum, truth.tum, cameras.json and keyframes.json [.]");
    table.add("What comes out", o, outputs);
    table.without("no-depth", "a map needs depths");
    table.without("rolling-shutter", "the derivative by the map takes a picture as seen at once");
    table.add("Mapping", o, rows);
    table.add("The host", o, host_rows);
    table.pair({{Pairing::excludes, "photos", "render", "they exclude each other: pictures come from one of them"},
                {Pairing::needs, "photos", "cameras", "a picture needs the camera's lens and first pose"}});
    return table;
}

/// Options that change no state of a run after a frame. --frames changes the built-in motion alone.
bool changes_nothing(Options const& o, std::string_view name)
{
    for (auto const other : {"threads", "finish", "out", "report", "quiet", "resume"})
        if (name == other) return true;
    return name == "frames" && (o.photos || o.trajectory);
}

} // namespace

std::optional<Options> options_of(int argc, char** argv)
{
    Options o;
    auto table = table_of(o);
    if (!read_command_line(table, o, &o, argc, argv)) return {};
    for (auto const& [row, text] : table.given()) {
        if (changes_nothing(o, row->name)) continue;
        bool const is_path = row->form >= Form::input;
        o.shaping.push_back(std::string(row->name) + (is_path ? "" : "=" + text));
    }
    // A map's name chooses among the cameras of a file.
    for (auto const& map : {o.render, o.map})
        if (map) o.shaping.push_back("name " + map->stem().string());
    std::sort(o.shaping.begin(), o.shaping.end());
    return o;
}

} // namespace slam_program
