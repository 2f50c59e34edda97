#include "options.hpp"
#include "../shared/option_values.hpp"
#include "../shared/output_files.hpp"
#include <iostream>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/trajectory.hpp>

namespace slam_program {

namespace {

using tilemesh::Error;

constexpr char const* help = R"(usage: slam [--photos DIR | --render MAP] [OPTION VALUE]...
Makes a map from pictures with depth, and finds the camera's pose in each: no map is needed. The same command writes the same map, byte for
byte, whatever the number of threads.
  --photos DIR               real pictures with depth: a folder of the TUM RGB-D benchmark, or an association file
  --render MAP               views of this map, spoilt as a camera would [of the built-in map]
  --map MAP                  start from this map [an empty one]
  --cameras FILE             a camera file, for the lens and the first pose
  --camera [SCENE/]NAME      the camera of that file
  --trajectory FILE          poses, camera to world: TUM, EuRoC, KITTI or Replica; with --photos, the truth [a hand-held motion]
  --trajectory-format NAME   the form of that file: tum, euroc, kitti or replica [the file tells it]
  --relative                 apply the trajectory's motion from its first pose to the camera
  --near D                   the near plane in world units [the file's; 0.2, or a tenth of the first picture's median depth if that is less]
  --depth-scale LEVELS       levels of the depth pictures a world unit [5000]
  --frames N                 at most so many frames [60]
  --every N                  every N-th pose or picture [1]
  --size WxH                 size in pixels of rendered pictures [320x240]
  --noise SIGMA              0 to 1: noise; other than 0 also 8 bits, depth errors with holes, a drifting gain, motion blur [0.02]
  --shutter SHARE            0 to 1: the share of a frame's time in which the shutter is open [0.5]
  --gain-drift SHARE         0 to 0.9: how far the gain drifts [0.1]
  --method NAME              how frames are tracked: hybrid | forward [hybrid; forward for pictures of less than 320 pixels across]
  --keyframe-every N         a keyframe after so many frames [5]
  --open SHARE               0 to 1: a keyframe where more of a picture is not covered [0.08]
  --steps N                  steps of refinement after a keyframe, twice as many after the first [30]
  --finish N                 steps by each keyframe after the last frame [5]
  --optimiser NAME           adam | by-kind [adam]
  --cell N                   new Gaussians stand for cells of N x N pixels [2]
  --threads N                [1]
  --report FILE              a report as JSON
  --page FILE                a page as HTML: numbers, three pictures of the map while it grows, the path
  --out DIR                  folder for map.ply, estimated.tum and truth.tum [.]
  --resume                   keep the state of the run in --out, and go on from the state of a run that was stopped
  --quiet                    print errors only
)";

constexpr shared::OptionValues values("slam");

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
        if (shared::read_option(o, values, argc, argv, i)) continue;
        if (name == "--resume") o.resume = true;
        else if (name == "--render") o.render = value();
        else if (name == "--map") o.map = value();
        else if (name == "--page") o.page = value();
        else if (name == "--gain-drift") o.gain_drift = values.number(name, value(), 0.0, 0.9, "from 0 to 0.9");
        else if (name == "--keyframe-every") o.keyframe_every = values.whole(name, value(), 1, 1'000'000);
        else if (name == "--open") o.most_open = values.number(name, value(), 0.0, 1.0, "from 0 to 1");
        else if (name == "--steps") o.steps = values.whole(name, value(), 0, 1'000'000);
        else if (name == "--finish") o.finish = values.whole(name, value(), 0, 1'000'000);
        else if (name == "--cell") o.cell = values.whole(name, value(), 1, 64);
        else if (name == "--optimiser") {
            auto const text = value();
            if (text != "adam" && text != "by-kind") values.refuse(name, text, "it takes adam or by-kind");
            o.optimiser = text == "adam" ? tilemesh::slam::Optimiser::adam : tilemesh::slam::Optimiser::by_kind;
        } else if (name == "--method") {
            auto const text = value();
            if (text != "hybrid" && text != "forward") values.refuse(name, text, "it takes hybrid or forward");
            o.method = text == "hybrid" ? tilemesh::track::Method::hybrid : tilemesh::track::Method::forward;
        } else values.refuse("an option", name, "there is no such option");
    }
    if (o.photos && o.render) throw Error("--photos and --render exclude each other (pictures come from one of them); leave one out");
    if (o.photos && !o.cameras) throw Error("--photos needs the camera's lens and first pose (no --cameras is given); add --cameras FILE");
    if (o.photos && o.size) throw Error("--size is for rendered pictures (--photos has its own); leave it out");
    shared::check_options(o);
    return o;
}

} // namespace slam_program
