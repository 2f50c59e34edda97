#include "options.hpp"

namespace any_map {

Options parse(std::vector<std::string> const& all)
{
    Options options;
    for (bench::Words words(all); words.next();) {
        auto const& option = words.option();
        if (options.take(words, true)) continue;
        if (option == "--write") options.write = words.path();
        else if (option == "--picture") options.picture = words.path();
        else if (option == "--map") options.maps.push_back(words.one_of(map_names));
        else if (option == "--threads") options.threads = words.number(1, 64);
        else words.refuse();
    }
    options.finish();
    return options;
}

std::string help()
{
    return std::string(
               "Usage: any_map [options]\n"
               "Measures what a complete picture costs on one machine (Mk2, 40 x 36 tiles, 1280 x 720): rounds, exchanges, hops and\n"
               "modelled time of the program of homes: with its fold, without it, and in slices with one cut for all tiles. The anchored\n"
               "program and the paper's setup render the same views; they miss what finds no room. Then the slots that a tile holds (K)\n"
               "go from 16 to 4,000, and the slots of a channel from 2 to 400. Times are modelled with mk2(). A picture from which\n"
               "nothing is missing must have the bits of the naive whole-frame loop.\n"
               "\n"
               "  --csv FILE       write a row per map, view and program\n"
               "  --write DIR      write README.md and its plot into this folder\n"
               "  --picture FILE   write the picture of the first page (bench/any_map/any_map.png), and measure nothing; needs playbot_250k\n") +
           bench::help_of_data +
           "  --map NAME       sloth, salad, playbot_250k, built_in, built_in_1m or built_in_5m (the built-in map, densified to one\n"
           "                   or five million Gaussians); may be repeated. Default: all\n"
           "  --threads N      host threads of each machine; default: 1. Only host times depend on it\n"
           "  --quick          a part of the built-in map, a small picture, few settings; takes seconds\n" +
           bench::help_of_spoil +
           "  --help           this text\n"
           "\n" +
           bench::help_of_exit;
}

} // namespace any_map
