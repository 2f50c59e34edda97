#include "options.hpp"
#include "scenes.hpp"
#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <iterator>
#include <thread>
#include <tilemesh/error.hpp>

namespace channel_capacity {

namespace {

using tilemesh::Error;

std::string quoted(std::string const& text)
{
    return "\"" + (text.size() > 60 ? text.substr(0, 60) + "..." : text) + "\"";
}

template <std::size_t N>
std::string one_of(std::string const& option, std::string const& value, char const* const (&names)[N])
{
    if (std::find(std::begin(names), std::end(names), value) != std::end(names)) return value;
    std::string all;
    for (auto const* name : names) all += (all.empty() ? "" : ", ") + std::string(name);
    throw Error(option + " cannot be " + quoted(value) + " (it is one of " + all + "); choose one of these");
}

} // namespace

Options parse(std::vector<std::string> const& words)
{
    Options options;
    options.threads = std::max(1u, std::thread::hardware_concurrency());
    bool data_given = false;
    for (std::size_t i = 0; i < words.size(); ++i) {
        auto const equals = words[i].find('=');
        auto const option = words[i].substr(0, equals);
        auto const value = [&] {
            if (equals != std::string::npos) return words[i].substr(equals + 1);
            if (i + 1 == words.size()) throw Error(option + " has no value (it is the last word); write one behind it");
            return words[++i];
        };
        auto const path = [&] {
            auto const text = value();
            if (text.empty()) throw Error(option + " has an empty value (it takes a path); write one behind it");
            return std::filesystem::path(text);
        };
        if (option == "--help" || option == "--quick") {
            if (equals != std::string::npos) throw Error(option + " has a value (it takes none); leave out what is behind =");
            (option == "--help" ? options.help : options.quick) = true;
        } else if (option == "--csv") {
            options.csv = path();
        } else if (option == "--latency") {
            options.latency = path();
        } else if (option == "--plots") {
            options.plots = path();
        } else if (option == "--data") {
            options.data = path();
            data_given = true;
        } else if (option == "--scene") {
            options.scenes.push_back(one_of(option, value(), scene_names));
        } else if (option == "--motion") {
            options.motions.push_back(one_of(option, value(), motion_names));
        } else if (option == "--threads") {
            auto const text = value();
            auto const [end, error] = std::from_chars(text.data(), text.data() + text.size(), options.threads);
            if (error != std::errc{} || end != text.data() + text.size() || options.threads == 0 || options.threads > 1024)
                throw Error("--threads cannot be " + quoted(text) +
                            " (it takes a whole number from 1 to 1024); write for example --threads 2");
        } else {
            throw Error(quoted(words[i]) + " is no option (see --help); leave it out");
        }
    }
    if (!data_given && !options.help) {
        char const* const folder = std::getenv("TILEMESH_DATA");
        options.data = folder != nullptr ? folder : "../shared/data";
    }
    if (data_given && !std::filesystem::is_directory(options.data / "maps"))
        throw Error("--data cannot be " + quoted(options.data.string()) +
                    " (there is no folder maps in it); name the folder that holds maps/, "
                    "trajectories/ and cameras.json");
    if (!data_given && !std::filesystem::is_directory(options.data / "maps")) options.data.clear();
    return options;
}

std::string help()
{
    return "Usage: channel_capacity [options]\n"
           "What a channel slot is worth on one machine (Mk2, 638,976 bytes a tile, 40 x 36 tiles, 1280 x 720): every channel gets c\n"
           "slots, from 1 to what leaves storage for one record, and storage gets the bytes that are left. Measured for both saturation\n"
           "policies on four maps and seven motions; then how late Gaussians are when the hops a frame are bounded. Prints the knees and\n"
           "checks what must hold.\n"
           "\n"
           "  --csv FILE       a row a setting\n"
           "  --latency FILE   CSV: distance in tiles against frames late\n"
           "  --plots DIR      SVG plots, and PNGs of saturated pictures beside complete ones\n"
           "  --data DIR       maps/, trajectories/ and cameras.json; default: the environment variable TILEMESH_DATA, or\n"
           "                   ../shared/data; what is not there is skipped\n"
           "  --scene NAME     sloth, salad, playbot_250k or built_in; may be repeated. Default: all\n"
           "  --motion NAME    static, orbit0.1, orbit0.5, orbit2, teleport, fr1_xyz or fr2_desk; may be repeated. Default: all\n"
           "  --threads N      motions measured at a time; default: as many as the machine has. Results do not depend on it\n"
           "  --quick          two maps, four motions, eight capacities, smaller pictures\n"
           "  --help           this text\n"
           "\n"
           "Exit status: 0; 1 when something that must hold does not; 2 with one line on standard error when something is wrong:\n"
           "what, why, what to do.\n";
}

} // namespace channel_capacity
