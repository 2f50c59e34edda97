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
               "What a channel slot is worth on one machine (Mk2, 638,976 bytes a tile, 40 x 36 tiles, 1280 x 720): every channel gets c\n"
               "slots, from 1 to what leaves storage for one record, and storage gets the bytes that are left. Measured for both saturation\n"
               "policies on four maps and seven motions; then how late Gaussians are when the hops a frame are bounded. Times are modelled: our\n"
               "kernels on Mk2, an exchange moves all c slots of its channel, and a frame that is composited again counts twice. Prints the\n"
               "knees and the splits that no other beats in both PSNR and modelled time (Pareto), and checks what must hold.\n"
               "\n"
               "  --csv FILE       a row a setting\n"
               "  --latency FILE   CSV: distance in tiles against frames late\n"
               "  --plots DIR      SVG plots, and PNGs of saturated pictures beside complete ones\n") +
           bench::help_of_data +
           "  --scene NAME     sloth, salad, playbot_250k or built_in; may be repeated. Default: all\n"
           "  --motion NAME    static, orbit0.1, orbit0.5, orbit2, teleport, fr1_xyz or fr2_desk; may be repeated. Default: all\n"
           "  --threads N      motions measured at a time; default: as many as the machine has. Results do not depend on it\n"
           "  --quick          two maps, four motions, eight capacities, smaller pictures\n"
           "  --help           this text\n"
           "\n" +
           bench::help_of_exit;
}

} // namespace channel_capacity
