#include "options.hpp"
#include <algorithm>
#include <common/scenes.hpp>
#include <thread>

namespace channel_capacity {

Options parse(std::vector<std::string> const& all)
{
    Options options;
    options.threads = std::max(1u, std::thread::hardware_concurrency());
    for (bench::Words words(all); words.next();) {
        auto const& option = words.option();
        if (options.take(words)) continue;
        if (option == "--latency") options.latency = words.path();
        else if (option == "--plots") options.plots = words.path();
        else if (option == "--scene") options.scenes.push_back(words.one_of(bench::scene_names));
        else if (option == "--motion") options.motions.push_back(words.one_of(bench::motion_names));
        else if (option == "--threads") options.threads = words.number(1, 1024);
        else words.refuse();
    }
    options.finish();
    return options;
}

std::string help()
{
    return std::string(
               "Usage: channel_capacity [options]\n"
               "Measures what a channel slot is worth on one machine (Mk2, 638,976 bytes a tile, 40 x 36 tiles, 1280 x 720). Every channel gets\n"
               "c slots, from 1 to the number that leaves storage for one record. Storage gets the remaining bytes. The bench measures both\n"
               "saturation policies on four maps and seven motions, and the program of homes, which loses nothing and takes more rounds. Then it\n"
               "measures how late Gaussians are if the hops of a frame are bounded.\n"
               "Times are modelled: our kernels on Mk2, an exchange moves all c slots of its channel, and a frame that is composited again\n"
               "counts twice. Prints the knees and the Pareto-optimal splits (PSNR and modelled time), and checks the results.\n"
               "\n"
               "  --csv FILE       write a row per setting\n"
               "  --latency FILE   write a CSV: distance in tiles, frames late\n"
               "  --plots DIR      write SVG plots, and PNGs of saturated pictures beside complete ones\n") +
           bench::help_of_data +
           "  --scene NAME     sloth, salad, playbot_250k or built_in; may be repeated. Default: all\n"
           "  --motion NAME    static, orbit0.1, orbit0.5, orbit2, teleport, fr1_xyz or fr2_desk; may be repeated. Default: all\n"
           "  --threads N      number of motions measured at a time; default: all host threads. Results do not depend on it\n"
           "  --quick          two maps, four motions, eight capacities, smaller pictures\n"
           "  --help           this text\n"
           "\n" +
           bench::help_of_exit;
}

} // namespace channel_capacity
