#include "options.hpp"
#include "settings.hpp"
#include <algorithm>
#include <common/scenes.hpp>
#include <iterator>
#include <thread>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>

namespace error_vs_time {

namespace {

tilemesh::scene::Size size_of(std::string const& text)
{
    tilemesh::scene::Size size{0, 0};
    auto const* const end = text.data() + text.size();
    auto const width = tilemesh::read_number(text.data(), end, size.width);
    bool good = width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x';
    if (good) {
        auto const height = tilemesh::read_number(width.ptr + 1, end, size.height);
        good = height.ec == std::errc{} && height.ptr == end;
    }
    // Mk2 has tiles for 1280 x 720. Below 40 x 36 pixels a picture shows nothing.
    if (!good || size.width < 40 || size.width > 1280 || size.height < 36 || size.height > 720)
        throw tilemesh::Error("--size cannot be \"" + text +
                              "\" (it takes WxH, 40 to 1280 by 36 to 720); write for example --size 640x360");
    return size;
}

/// The name of a setting.
std::string setting_of(std::string text)
{
    auto const all = settings();
    if (std::any_of(all.begin(), all.end(), [&](Setting const& s) { return s.name == text; })) return text;
    throw tilemesh::Error("--setting cannot be \"" + text +
                          "\" (no setting has that name); write for example --setting viewing, or see --list");
}

} // namespace

Options parse(std::vector<std::string> const& all)
{
    Options options;
    options.threads = std::max(1u, std::thread::hardware_concurrency());
    for (bench::Words words(all); words.next();) {
        auto const& option = words.option();
        if (options.take(words, true)) continue;
        if (option == "--scene") options.scenes.push_back(words.one_of({std::begin(bench::scene_names), std::end(bench::scene_names)}));
        else if (option == "--setting") options.settings.push_back(setting_of(words.value()));
        else if (option == "--size") options.size = size_of(words.value());
        else if (option == "--threads") options.threads = words.number(1, 1024);
        else if (option == "--rounds") options.rounds = words.number(1, 1000);
        else if (option == "--out") options.out = words.path();
        else if (option == "--pfm") options.pfm = words.path();
        else if (option == "--list") words.flag(), options.list = true;
        else if (option == "--no-sequences") words.flag(), options.sequences = false;
        else words.refuse();
    }
    options.finish();
    return options;
}

std::string help()
{
    return std::string(
               "Usage: error_vs_time [options]\n"
               "Measures the cost and the error of some 170 settings per map. The error is against the picture in double precision\n"
               "without cut-offs, split into the parts of the cut-offs, of rounding and of the mesh. Costs are pairs, modelled time and\n"
               "host time. Prints the Pareto-optimal settings.\n"
               "\n"
               "  --scene NAME     sloth, salad, playbot_250k or built_in; may be repeated. Default: all, quick without playbot_250k\n"
               "  --setting NAME   measure this setting beside the default; may be repeated. Default: all. The front holds measured settings only\n"
               "  --list           prints the names of all settings\n"
               "  --size WxH       size of a frame, 40x36 to 1280x720; default: 1280x720, quick 640x360\n"
               "  --rounds N       timed rounds; default: 15, quick 5. A claim needs 3 rounds, and 10 of the default setting, which runs\n"
               "                   in each batch of 22 settings\n"
               "  --no-sequences   single views only\n"
               "  --csv FILE       write a line per setting, with everything needed to repeat it\n"
               "  --out DIR        write plots\n"
               "  --pfm DIR        for default, on_sensor and \"drop 5 slots\", write the pictures of the mesh (MAP_SETTING_mesh.pfm), of the whole\n"
               "                   frame in float32 (_whole), in double with the cut-offs (_cut), and of the reference (_reference)\n") +
           bench::help_of_data +
           "  --threads N      threads that compute errors; default: all host threads. Results do not depend on it; times are always of\n"
           "                   one thread\n"
           "  --quick          smaller frames, fewer rounds, one short sequence a map; below 6 minutes on two cores\n"
           "  --spoil          give all meshes but the default's other blending rules than their references: the checks must fail\n"
           "  --help           this text\n"
           "\n" +
           "In the CSV e_cut_... is cut against reference, e_round_... whole against cut, e_mesh_... mesh against whole; ..._max and\n"
           "..._levels are levels of 255, rmse and mae are of colours of 0 to 1. front_pairs is the fewest pairs of a setting whose\n"
           "error is no larger, over this one's: 1 on the front. sigmas 0: no such cut; key_bits 32, degree 5 and hops 0 (until\n"
           "quiet) are the library's own; storage_slots 0: room for all.\n"
           "\n" +
           bench::help_of_exit;
}

} // namespace error_vs_time
