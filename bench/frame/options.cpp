#include "options.hpp"
#include <common/scenes.hpp>

namespace frame {

Options parse(std::vector<std::string> const& all)
{
    Options options;
    for (bench::Words words(all); words.next();) {
        auto const& option = words.option();
        if (options.take(words, true)) continue;
        if (option == "--scene") options.scenes.push_back(words.one_of(scene_names));
        else if (option == "--map") options.maps.push_back(words.path());
        else if (option == "--motion") options.motions.push_back(words.one_of(bench::motion_names));
        else if (option == "--threads") options.threads.push_back(words.number(1, 64));
        else if (option == "--rounds") options.rounds = words.number(1, 10'000);
        else if (option == "--arithmetic")
            options.arithmetic = words.one_of({"precise", "fast"}) == "precise" ? tilemesh::splat::Arithmetic::precise
                                                                                : tilemesh::splat::Arithmetic::fast;
        else if (option == "--homes") words.flag(), options.homes = true;
        else if (option == "--wide") words.flag(), options.wide = true;
        else if (option == "--arithmetics") words.flag(), options.arithmetics = true;
        else words.refuse();
    }
    options.finish();
    if (options.threads.empty()) options.threads = {1, 2};
    return options;
}

std::string help()
{
    return std::string(
               "Usage: frame [options]\n"
               "Measures the host time of the machine's frame (lossless on Mk2, 40 x 36 tiles, 1280 x 720) beside a bare rasteriser with the\n"
               "same kernels and no mesh, and beside the FMA peak of the processor. All are measured in turn, round by round, so a busy\n"
               "machine slows all of them. Prints the medians of the rounds and of their ratios. In each round, mesh and rasteriser must\n"
               "have equal pictures, bit for bit.\n"
               "\n"
               "mesh_ms ends when the framebuffers are complete in the tiles. picture_ms is the time to assemble one picture on the host.\n"
               "In mesh_ms every tile composites. mesh_kept_ms is the time of a static view in which tiles keep their pixels.\n"
               "direct_over_roofline is the time of the evaluated pairs at FMA peak, 21 operations each, over direct_ms.\n"
               "cycles_per_block_splat is the rasteriser's blending, over all threads, in cycles of the measured clock per 80\n"
               "evaluated pairs. The columns _low and _high are the 20 % and 80 % quantiles. Counters are means over the measured frames.\n"
               "\n"
               "  --csv FILE       write a row per scene, motion, grid and number of threads\n") +
           bench::help_of_data +
           "  --scene NAME     sloth, salad, playbot_250k, built_in or built_in_1m (the built-in map, densified to a million Gaussians);\n"
           "                   may be repeated. Default: all, unless there is a --map\n"
           "  --map FILE       any map, seen whole and without its harmonics; may be repeated. A map of more than 100,000 Gaussians runs\n"
           "                   on a test machine with storage for it\n"
           "  --motion NAME    static, orbit0.1, orbit0.5, orbit2, teleport, fr1_xyz or fr2_desk; may be repeated\n"
           "  --threads N      threads of rasteriser and mesh; may be repeated; all are measured in turn. Default: 1 and 2\n"
           "  --rounds N       measured rounds per motion, after 3 warm-up rounds. Default: 25, and 7 for maps of half a million\n"
           "  --arithmetic A   precise or fast. Default: " +
           to_string(tilemesh::splat::Lossless::arithmetic) +
           "\n"
           "  --homes          also measure the program of homes on Mk2 (homes_ms), unless the view is static: it renders an unchanged view\n"
           "                   without running\n"
           "  --wide           also measure each mesh on a grid of 400 x 250 tiles, of which the frame occupies 40 x 36\n"
           "  --arithmetics    print another table instead: time, and error against the double reference with the same cut-offs, of the\n"
           "                   rasteriser with precise and fast arithmetic, polynomials of lower degree, and a stop by blocks. For\n"
           "                   Sloth and Salad unless scenes are named; --csv then has these columns\n"
           "  --quick          the built-in map unless scenes are named, 320 x 180, three motions, 3 rounds\n" +
           bench::help_of_spoil +
           "  --help           this text\n"
           "\n" +
           bench::help_of_exit;
}

} // namespace frame
