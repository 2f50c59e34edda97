#include "options.hpp"
#include <common/scenes.hpp>

namespace channel_capacity {

using shared::option;

namespace {
constexpr auto all_scenes = shared::words_of(bench::scene_names);
constexpr auto all_motions = shared::words_of(bench::motion_names);
constexpr shared::Option<Options> rows[] = {
    option<&Options::latency>("latency", "FILE", "write a CSV: distance in tiles, frames late"),
    option<&Options::plots>("plots", "DIR", "write SVG plots, and PNGs of saturated pictures beside complete ones"),
    shared::words<&Options::scenes>("scene", "NAME", "{}; may be repeated [all]", all_scenes),
    shared::words<&Options::motions>("motion", "NAME", "{}; may be repeated [all]", all_motions),
    option<&Options::threads>("threads", "N", "number of motions measured at a time; results do not depend on it [all host threads]", {1, 1024})};
} // namespace

shared::OptionTable table_of(Options& own)
{
    return bench::table_of({"channel_capacity",
                            "Measures what a channel slot is worth on one machine (Mk2, 638,976 bytes a tile, 40 x 36 tiles, 1280 x\n"
                            "720). Every channel gets c slots, from 1 to the number that leaves storage for one record. Storage gets\n"
                            "the remaining bytes. The bench measures both saturation policies on four maps and seven motions, and the\n"
                            "program of homes, which loses nothing and takes more rounds. Then it measures how late Gaussians are if\n"
                            "the hops of a frame are bounded. Times are modelled: our kernels on Mk2, an exchange moves all c slots of\n"
                            "its channel, and a frame that is composited again counts twice. Prints the knees and the Pareto-optimal\n"
                            "splits (PSNR and modelled time), and checks the results.\n",
                            "two maps, four motions, eight capacities, smaller pictures", "write a row per setting", false},
                           own, rows);
}

} // namespace channel_capacity
