#include "options.hpp"
#include <common/scenes.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>

namespace scaling {

namespace {
/// "LATENCY,OVERHEAD,BANDWIDTH" in microseconds, microseconds and GB/s.
tilemesh::HostNetwork network_of(std::string const& text)
{
    double figures[3] = {};
    auto const* at = text.data();
    auto const* const end = at + text.size();
    for (int i = 0; i < 3; ++i) {
        auto const [next, error] = tilemesh::read_number(at, end, figures[i]);
        if (error != std::errc{} || !(figures[i] >= 0) || (i < 2 ? next == end || *next != ',' : next != end || figures[i] == 0))
            throw tilemesh::Error("option --network " + text +
                                  " (not LATENCY,OVERHEAD,BANDWIDTH in microseconds, microseconds and GB/s); write for example 1.5,0.5,12");
        at = next + 1;
    }
    return {"your network", figures[0], figures[1], 1000 * figures[2], "Option --network"};
}
} // namespace

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
        else if (option == "--ranks" || option == "--frames" || option == "--predict" || option == "--chips") {
            words.flag();
            (option == "--ranks"     ? options.ranks
             : option == "--frames"  ? options.frames
             : option == "--predict" ? options.predict
                                     : options.chips) = true;
        } else if (option == "--network")
            options.network = network_of(words.value());
        else words.refuse();
    }
    if (options.ranks && options.predict)
        throw tilemesh::Error("options --ranks and --predict (one measures, the other predicts); give one of them");
    if (options.chips && (options.ranks || options.predict))
        throw tilemesh::Error("option --chips and another table (each prints its own); give one of them");
    if (options.network && !options.predict)
        throw tilemesh::Error("option --network without --predict (only a prediction needs a network); add --predict");
    if (options.frames && !options.ranks)
        throw tilemesh::Error("option --frames without --ranks (frames are measured over the ranks of MPI); add --ranks");
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
           "  --ranks          measure the engine over the ranks of MPI instead: mpirun -n N scaling --ranks. Only rank 0 prints\n"
           "  --frames         with --ranks: measure whole frames instead, one rank's threads against as many ranks\n"
           "  --predict        predict a frame over 1 to 1,024 hosts instead\n"
           "  --chips          model arrays of Mk2 chips against one chip of as many tiles instead\n"
           "  --network L,O,B  with --predict: one more network, of L us latency, O us overhead a message, B GB/s\n"
           "  --quick          measure few and small values, 2 rounds; write no file\n" +
           bench::help_of_spoil +
           "  --help           this text\n"
           "\n" +
           bench::help_of_exit;
}

} // namespace scaling
