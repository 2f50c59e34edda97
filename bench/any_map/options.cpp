#include "options.hpp"

namespace any_map {

using shared::option;

namespace {
constexpr auto names = shared::words_of(map_names);
constexpr shared::Option<Options> rows[] = {
    option<&Options::write>("write", "DIR", "write README.md and its plot into this folder"),
    option<&Options::picture>("picture", "FILE",
                              "write the picture of the first page (bench/any_map/any_map.png), and measure nothing; needs playbot_250k"),
    shared::words<&Options::maps>("map", "NAME",
                                  "{}: the last two are the built-in map, densified to one or five million Gaussians; may be repeated [all]", names),
    option<&Options::threads>("threads", "N", "host threads of each machine; only host times depend on it [1]", {1, 64})};
} // namespace

shared::OptionTable table_of(Options& own)
{
    return bench::table_of({"any_map",
                            "Measures what a complete picture costs on one machine (Mk2, 40 x 36 tiles, 1280 x 720): rounds, exchanges,\n"
                            "hops and modelled time of the program of homes: with its fold, without it, and in slices with one cut for\n"
                            "all tiles. The anchored program and the paper's setup render the same views; they miss what finds no room.\n"
                            "Then the slots that a tile holds (K) go from 16 to 4,000, and the slots of a channel from 2 to 400. Times\n"
                            "are modelled with mk2(). A picture from which nothing is missing must have the bits of the naive\n"
                            "whole-frame loop.\n",
                            "a part of the built-in map, a small picture, few settings; takes seconds", "write a row per map, view and program"},
                           own, rows);
}

} // namespace any_map
