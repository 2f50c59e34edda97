#include "options.hpp"
#include "settings.hpp"
#include <common/scenes.hpp>
#include <tilemesh/error.hpp>

namespace error_vs_time {

using shared::option;

namespace {
/// Mk2 has tiles for 1280 x 720. Below 40 x 36 pixels a picture shows nothing.
void set_size(Options& o, shared::OptionValue const& given)
{
    o.size = {static_cast<std::uint32_t>(given.three[0]), static_cast<std::uint32_t>(given.three[1])};
    if (o.size.width < 40 || o.size.height > 720) throw shared::Misfit{"it takes WxH, 40 to 1280 by 36 to 720"};
}

constexpr auto all_scenes = shared::words_of(bench::scene_names);
constexpr shared::Option<Options> rows[] = {
    shared::words<&Options::scenes>("scene", "NAME", "{}; may be repeated [all, quick without playbot_250k]", all_scenes),
    option<&Options::settings>("setting", "NAME",
                               "measure this setting beside the default; may be repeated. The front holds measured settings only [all]"),
    option<&Options::list>("list", "", "print the names of all settings"),
    {{"size",
      "WxH",
      "size of a frame, 40x36 to 1280x720 [1280x720, quick 640x360]",
      shared::Form::size,
      36,
      1280,
      {},
      {},
      "640x360",
      "it takes WxH, 40 to 1280 by 36 to 720"},
     set_size},
    option<&Options::rounds>("rounds", "N",
                             "timed rounds; a claim needs 3, and 10 of the default setting, which runs in each batch of 22 settings [15, quick 5]",
                             {1, 1000}),
    option<&Options::single_views>("no-sequences", "", "single views only"),
    option<&Options::out>("out", "DIR", "write plots"),
    option<&Options::pfm>(
        "pfm", "DIR",
        "for default, on_sensor and \"drop 5 slots\", write the pictures of the mesh (MAP_SETTING_mesh.pfm), of the whole frame in float32 "
        "(_whole), in double with the cut-offs (_cut), and of the reference (_reference)"),
    option<&Options::threads>(
        "threads", "N", "threads that compute errors; results do not depend on them; times are always of one thread [all host threads]", {1, 1024})};
} // namespace

void Options::finish(shared::OptionTable const& given)
{
    bench::Options::finish(given);
    auto const all = error_vs_time::settings();
    for (auto const& name : settings)
        if (std::none_of(all.begin(), all.end(), [&](Setting const& s) { return s.name == name; }))
            throw tilemesh::Error("--setting cannot be \"" + name +
                                  "\" (no setting has that name); write for example --setting viewing, or see --list");
}

shared::OptionTable table_of(Options& own)
{
    return bench::table_of({"error_vs_time",
                            "Measures the cost and the error of some 170 settings per map. The error is against the picture in double\n"
                            "precision without cut-offs, split into the parts of the cut-offs, of rounding and of the mesh. Costs are\n"
                            "pairs, modelled time and host time. Prints the Pareto-optimal settings.\n",
                            "smaller frames, fewer rounds, one short sequence a map; below 6 minutes on two cores",
                            "write a line per setting, with everything needed to repeat it"},
                           own, rows);
}

} // namespace error_vs_time
