#include "options.hpp"
#include <common/scenes.hpp>
#include <span>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>

namespace scaling {

using shared::option;

namespace {
/// "LATENCY,OVERHEAD,BANDWIDTH" in microseconds, microseconds and GB/s.
void set_network(Options& o, shared::OptionValue const& given)
{
    if (given.three[2] == 0) throw shared::Misfit{"its bandwidth is above 0"};
    o.network = {"your network", given.three[0], given.three[1], 1000 * given.three[2], "Option --network"};
}

constexpr auto all_axes = shared::words_of(axis_names);
constexpr auto motions = shared::words_of(bench::motion_names);
constexpr shared::Option<Options> rows[] = {
    shared::words<&Options::axes>("axis", "NAME", "{}; may be repeated [all]", all_axes),
    shared::words<&Options::motion>("motion", "NAME", "{} [orbit0.5]", std::span(motions).first(5)), // without recorded ones
    option<&Options::threads>("threads", "N", "threads of rasteriser and mesh; may be repeated [1 and 2]", {1, 64}),
    option<&Options::ranks>("ranks", "", "measure the engine over the ranks of MPI instead: mpirun -n N scaling --ranks. Only rank 0 prints"),
    option<&Options::frames>("frames", "", "with --ranks: measure whole frames instead, one rank's threads against as many ranks"),
    option<&Options::predict>("predict", "", "predict a frame over 1 to 1,024 hosts instead"),
    option<&Options::chips>("chips", "", "model arrays of Mk2 chips against one chip of as many tiles instead"),
    {{"network",
      "L,O,B",
      "with --predict: one more network, of L us latency, O us overhead a message, B GB/s",
      shared::Form::three,
      0,
      1e6,
      {},
      {},
      "1.5,0.5,12"},
     set_network}};
constexpr shared::Pairing pairings[] = {{shared::Pairing::excludes, "ranks", "predict", "one measures, the other predicts"},
                                        {shared::Pairing::excludes, "chips", "ranks", "each prints a table of its own"},
                                        {shared::Pairing::excludes, "chips", "predict", "each prints a table of its own"},
                                        {shared::Pairing::needs, "network", "predict", "only a prediction needs a network"},
                                        {shared::Pairing::needs, "frames", "ranks", "frames are measured over the ranks of MPI"}};
} // namespace

void Options::finish(shared::OptionTable const& given)
{
    bench::Options::finish(given);
    for (auto const& pairing : pairings) given.require(pairing);
    if (threads.empty()) threads = {1, 2};
}

shared::OptionTable table_of(Options& own)
{
    return bench::table_of({"scaling",
                            "Measures how a frame's host time and the machine's host memory grow, beside the time of a bare rasteriser:\n"
                            "  gaussians   1,000 to 1,000,000 of one made-up distribution, 1280 x 720 pixels, 40 x 36 tiles\n"
                            "  pixels      320 x 180 to 3840 x 2160, one map, 40 x 36 tiles\n"
                            "  tiles       the same frame of 1280 x 720 on 10 x 9 to 160 x 144 tiles\n"
                            "  idle_tiles  the same frame on 40 x 36 tiles of grids up to 400 x 250\n"
                            "Prints the exponents of power laws (least squares of logarithms), and the bytes per Gaussian and per idle\n"
                            "tile. The last three axes use Sloth if it is there, or else the built-in map. Times are medians of rounds\n"
                            "that measure both in turn; the pictures must be equal in each round. Bytes are the growth of the process\n"
                            "in the machine's first frame.\n",
                            "measure few and small values, 2 rounds; write no file", "write a row per value and number of threads"},
                           own, rows);
}

} // namespace scaling
