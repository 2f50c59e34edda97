#include "options.hpp"
#include "../shared/option_values.hpp"
#include "../shared/output_files.hpp"
#include <iostream>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>

namespace refine {

namespace {

using tilemesh::Error;

constexpr char const* help = R"(usage: refine MAP --cameras FILE --photos DIR [OPTION VALUE]...
Makes a map agree better with photographs. A step renders one photograph's view, compares,
    and moves the Gaussians that it shows. No Gaussian
is added or removed. The same command writes the same map, byte for byte, whatever the number of threads.
  MAP                        a map that render_map reads
  --cameras FILE             a camera file or a COLMAP model, as for render_map
  --photos DIR               the folder of the photographs, PNG or JPEG, named as the cameras
  --steps N                  so many steps [20 for each photograph that is not held out]
  --every N                  holds out one in N of the sorted names, from the first; they are only compared [8]
  --out FILE                 the refined map, a PLY [refined.ply]
  --report FILE              a report as JSON
  --optimiser NAME           by-kind | adam: a second moment a kind of parameter, or Adam [by-kind]
  --rate X                   times all rates; they fall to a tenth over the run [1]
  --scale N                  photographs divided by N [1]
  --background R,G,B         0 to 1: what shows through the map [0,0,0]
  --near D                   the near plane in world units [the file's; 0.2, or less in a small scene]
  --ignore-distortion        take lenses with distortion for pinholes
  --threads N                [1]
  --quiet                    print errors only
)";

constexpr shared::OptionValues values("refine");

std::array<float, 3> colour(std::string_view option, std::string_view text)
{
    std::array<float, 3> out{};
    auto rest = text;
    for (std::size_t i = 0; i < 3; ++i) {
        auto const comma = rest.find(',');
        if ((comma == std::string_view::npos) != (i == 2)) values.refuse(option, text, "it takes three numbers from 0 to 1, as in 1,1,1");
        out[i] = static_cast<float>(values.number(option, rest.substr(0, comma), 0, 1, "from 0 to 1, three times"));
        rest.remove_prefix(i == 2 ? rest.size() : comma + 1);
    }
    return out;
}

} // namespace

std::optional<Options> options_of(int argc, char** argv)
{
    Options o;
    for (int i = 1; i < argc; ++i) {
        std::string_view const name = argv[i];
        auto const value = [&] { return values.next(argc, argv, i); };
        if (name == "--help") {
            shared::print(help, "send it to a file or a terminal with room", std::cout);
            return {};
        }
        if (name == "--quiet") o.quiet = true;
        else if (name == "--ignore-distortion") o.ignores_distortion = true;
        else if (name == "--cameras") o.cameras = value();
        else if (name == "--photos") o.photos = value();
        else if (name == "--out") o.out = value();
        else if (name == "--report") o.report = value();
        else if (name == "--steps") o.steps = values.whole(name, value(), 1, 100'000'000);
        else if (name == "--every") o.every = values.whole(name, value(), 2, 1'000'000);
        else if (name == "--scale") o.scale = values.whole(name, value(), 1, 1024);
        else if (name == "--threads") o.threads = values.whole(name, value(), 1, 1024);
        else if (name == "--rate") o.rate = values.number(name, value(), 1e-6, 1e3, "from 1e-6 to 1000");
        else if (name == "--near") o.near_depth = static_cast<float>(values.number(name, value(), 1e-30, 1e30, "above 0"));
        else if (name == "--background") o.background = colour(name, value());
        else if (name == "--optimiser") {
            auto const text = value();
            if (text == "by-kind") o.optimiser = Optimiser::by_kind;
            else if (text == "adam") o.optimiser = Optimiser::adam;
            else values.refuse(name, text, "it takes by-kind or adam");
        } else if (name.substr(0, 1) == "-" || name.empty() || !o.map.empty()) values.refuse("an option", name,
            "there is no such option, or a second map");
        else o.map = name;
    }
    if (o.map.empty()) throw Error("no map is named (there is nothing to refine); name one: refine MAP --cameras FILE --photos DIR");
    if (o.cameras.empty()) throw Error("no cameras are named (photographs need their poses); add --cameras FILE");
    if (o.photos.empty()) throw Error("no photographs are named (a map is refined by them); add --photos DIR");
    return o;
}

} // namespace refine
