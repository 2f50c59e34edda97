#include "options.hpp"
#include <common/scenes.hpp>

namespace scaling {

Options parse(std::vector<std::string> const& all)
{
    Options options;
    for (bench::Words words(all); words.next();) {
        auto const& option = words.option();
        if (options.take(words, true)) continue;
        if (option == "--axis") options.axes.push_back(words.one_of(axis_names));
        else if (option == "--motion")
            options.motion = words.one_of({"static", "orbit0.1", "orbit0.5", "orbit2", "teleport"});
        else if (option == "--threads") options.threads.push_back(words.number(1, 64));
        else words.refuse();
    }
    options.finish();
    if (options.threads.empty()) options.threads = {1, 2};
    return options;
}

std::string help()
{
    return std::string(
               "Usage: scaling [options]\n"
               "Measures how a frame's host time and the machine's host memory grow, beside the time of a bare rasteriser:\n"
               "  gaussians   1,000 to 1,000,000 of one made-up distribution, 1280 x 720 pixels, 40 x 36 tiles\n"
               "  pixels      320 x 180 to 3840 x 2160, one map, 40 x 36 tiles\n"
               "  tiles       the same frame of 1280 x 720 on 10 x 9 to 160 x 144 tiles\n"
               "  idle_tiles  the same frame on 40 x 36 tiles of grids up to 400 x 250\n"
               "Prints the exponents of power laws (least squares of logarithms), and the bytes per Gaussian and per idle tile. The last\n"
               "three axes use Sloth if it is there, or else the built-in map. Times are medians of rounds that measure both in turn; the\n"
               "pictures must be equal in each round. Bytes are the growth of the process in the machine's first frame.\n"
               "\n"
               "  --csv FILE       write a row per value and number of threads\n") +
           bench::help_of_data +
           "  --axis NAME      gaussians, pixels, tiles or idle_tiles; may be repeated. Default: all\n"
           "  --motion NAME    static, orbit0.1, orbit0.5, orbit2 or teleport. Default: orbit0.5\n"
           "  --threads N      threads of rasteriser and mesh; may be repeated. Default: 1 and 2\n"
           "  --quick          measure few and small values, 2 rounds; write no file\n" +
           bench::help_of_spoil +
           "  --help           this text\n"
           "\n" +
           bench::help_of_exit;
}

} // namespace scaling
