#include "options.hpp"
#include "../shared/option_values.hpp"
#include "../shared/output_files.hpp"
#include <iostream>
#include <string_view>
#include <tilemesh/error.hpp>

namespace track_camera {

namespace {

using tilemesh::Error;

constexpr char const* help = R"(usage: track_camera [MAP] [OPTION VALUE]...
Finds the pose of each picture of a sequence from the last one. The pictures are real ones, or are rendered from the map along a
trajectory and spoilt as a camera would.
  MAP                        a map that render_map reads [the built-in map]
  --trajectory FILE          poses, camera to world: TUM, EuRoC, KITTI or Replica [a hand-held motion]
  --trajectory-format NAME   the form of that file: tum, euroc, kitti or replica [the file tells it]
  --relative                 apply the trajectory's motion from its first pose to the camera
  --cameras FILE             a camera file, for the lens and the first pose
  --camera [SCENE/]NAME      the camera of that file
  --near D                   the near plane in world units [the file's; 0.2, or a tenth of the first picture's median depth if that is less]
  --photos DIR               real pictures: a folder of the TUM RGB-D benchmark, or an association file; --trajectory is then the truth
  --depth-scale LEVELS       levels of the depth pictures a world unit [5000]
  --frames N                 at most so many frames [60]
  --every N                  every N-th pose or picture [1]
  --size WxH                 size in pixels of rendered pictures [640x480]
  --noise SIGMA              0 to 1: noise; other than 0 also 8 bits, depth errors with holes, a drifting gain, motion blur [0.02]
  --shutter SHARE            0 to 1: the share of a frame's time in which the shutter is open [0.5]
  --method NAME              hybrid | forward | gradient | esm [hybrid]
  --one-in N                 evaluates one in N blocks of pixels [1]
  --no-depth                 colour alone
  --tile WxH                 pixels of a tile [follows from the size]
  --threads N                [1]
  --report FILE              a report as JSON
  --save-photos DIR          also writes the pictures that are tracked, as --photos reads them
  --out DIR                  folder for estimated.tum, truth.tum, paths.svg and residual.ppm [.]
  --quiet                    print errors only
)";

constexpr shared::OptionValues values("track_camera");

} // namespace

std::optional<Options> options_of(int argc, char** argv)
{
    Options o;
    o.without_depth = ", or use --no-depth";
    for (int i = 1; i < argc; ++i) {
        std::string_view const name = argv[i];
        auto const value = [&] { return values.next(argc, argv, i); };
        if (name == "--help") {
            shared::print(help, "send it to a file or a terminal with room", std::cout);
            return {};
        }
        if (shared::read_option(o, values, argc, argv, i)) continue;
        if (name == "--no-depth") o.depth = false;
        else if (name == "--one-in") o.one_in = values.whole(name, value(), 1, 1'000'000);
        else if (name == "--save-photos") o.save_photos = value();
        else if (name == "--tile") o.tile = shared::size_value(values, name, value());
        else if (name == "--method") {
            using tilemesh::track::Method;
            auto const text = value();
            if (text == "hybrid") o.method = Method::hybrid;
            else if (text == "forward") o.method = Method::forward;
            else if (text == "gradient") o.method = Method::gradient;
            else if (text == "esm") o.method = Method::esm;
            else values.refuse(name, text, "it takes hybrid, forward, gradient or esm");
        } else if (name.substr(0, 1) == "-" || name.empty() || o.map) values.refuse("an option", name, "there is no such option, or a second map");
        else o.map = name;
    }
    if (o.photos && o.map && !o.cameras) throw Error("--photos needs the camera's lens and first pose (no --cameras is given); add --cameras FILE");
    if (o.photos && (o.size || o.save_photos)) throw Error("--size and --save-photos are for rendered pictures (--photos has its own); leave them out");
    shared::check_options(o);
    return o;
}

} // namespace track_camera
