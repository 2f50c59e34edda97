// Where is the camera: how far off a start may be, how exact the pose is, and what an evaluation costs.
#include "track.hpp"
#include <algorithm>
#include <common/program.hpp>

namespace {

using namespace track_bench;
using shared::option;

constexpr char const* scene_names[] = {"built_in", "sloth", "salad"};
constexpr char const* table_names[] = {"basin", "subsets", "spoilt", "times", "model"};
constexpr auto all_scenes = shared::words_of(scene_names);
constexpr auto tables_of_it = shared::words_of(table_names);
constexpr auto all_methods = shared::words_of(method_names);
constexpr shared::Option<Options> rows[] = {
    shared::words<&Options::tables>(
        "table", "NAME",
        "basin (successes by start error, method, depth and cells, at 160 x 90) | subsets (the same with one in so many "
        "blocks) | spoilt (the error after noise, 8 bits, depth errors with holes and a change of exposure) | times (ms of "
        "an evaluation and of a frame at 640 x 480, beside 13 renders of the same renderer) | model (modelled ms on Mk2 at "
        "640 x 480, by steps); may be repeated [all]",
        tables_of_it),
    shared::words<&Options::scenes>("scene", "NAME", "{}; may be repeated [all]", all_scenes),
    shared::words<&Options::methods>("method", "NAME", "{}, for the first three tables; may be repeated [all]", all_methods),
    option<&Options::trials>("trials", "N", "starts of each row [20]", {1, 10'000}),
    option<&Options::rounds>("rounds", "N", "measured rounds of times [9]", {1, 10'000})};

shared::OptionTable table_of(Options& own)
{
    auto table = bench::table_of(
        {"track", "Finds the pose of a camera in a map: how far off a start may be, how exact the pose is, and what an\nevaluation costs.\n",
         "at most 4 starts and 3 rounds; unless named, hybrid on the built-in map, basin, times and model; 320 x 240 instead of 640 x 480",
         "write the rows of basin: scene,method,depth,coarsest,one_in,degrees,trials,fine,near,evaluations,worst_degrees"},
        own, rows);
    table.says("spoil", "targets stand on their heads: the checks must fail");
    return table;
}

int run(Options const& options)
{
    auto const wants = [&](char const* table) { return bench::chosen(options.tables, table); };
    int status = 0;
    if (wants("basin") || wants("subsets") || wants("spoilt")) status = basin(options);
    if (wants("times")) times(options);
    if (wants("model")) modelled(options);
    return status;
}

} // namespace

void track_bench::Options::finish(shared::OptionTable const& given)
{
    bench::Options::finish(given);
    if (!quick) return;
    trials = std::min(trials, 4u);
    rounds = std::min(rounds, 3u);
    if (tables.empty()) tables = {"basin", "times", "model"};
    if (methods.empty()) methods = {"hybrid"};
}

std::vector<std::string> track_bench::scenes_of(Options const& options)
{
    std::vector<std::string> names;
    for (std::string const name : scene_names) {
        if (!bench::chosen(options.scenes, name) || (options.quick && options.scenes.empty() && name != "built_in")) continue;
        if (name != "built_in" && options.data.empty()) bench::say_skipped(name);
        else names.push_back(name);
    }
    return names;
}

int main(int argc, char** argv)
{
    return bench::program(argc, argv, table_of, run, "not enough memory (each scene has a mesh); name one --scene");
}
