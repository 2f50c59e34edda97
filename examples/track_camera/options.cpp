#include "options.hpp"
#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <iostream>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>

namespace track_camera {

namespace {

using tilemesh::Error;

constexpr char const* help = R"(usage: track_camera [MAP] [OPTION VALUE]...
Renders a map along a trajectory, spoils the pictures as a camera would, and finds each pose again.
  MAP                        a map that render_map reads [the built-in map]
  --trajectory FILE          poses, camera to world: TUM, EuRoC, KITTI or Replica [a hand-held motion]
  --relative                 apply the trajectory's motion from its first pose to the camera
  --cameras FILE             a camera file, for the lens and the first pose
  --camera [SCENE/]NAME      the camera of that file
  --frames N                 at most so many frames [60]
  --size WxH                 size in pixels [1280x720]
  --noise SIGMA              0 to 1: noise; other than 0 also 8 bits, depth errors with holes, a drifting gain [0.02]
  --method NAME              hybrid | forward | gradient | esm [hybrid]
  --no-depth                 colour alone
  --threads N                [1]
  --report FILE              a report as JSON
  --out DIR                  folder for estimated.tum, truth.tum, paths.svg and residual.ppm [.]
  --quiet                    print errors only
)";

[[noreturn]] void refuse(std::string_view option, std::string_view text, std::string const& why)
{
    std::string shown(text.substr(0, 200));
    for (char& c : shown)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    throw Error(std::string(option) + " cannot be \"" + shown + "\" (" + why + "); see track_camera --help");
}

std::uint32_t whole(std::string_view option, std::string_view text, std::uint32_t most)
{
    std::uint32_t value = 0;
    auto const [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value < 1 || value > most) refuse(option, text, "it takes a whole number from 1 to " + std::to_string(most));
    return value;
}

} // namespace

std::optional<Options> options_of(int argc, char** argv)
{
    Options o;
    for (int i = 1; i < argc; ++i) {
        std::string_view const name = argv[i];
        auto const value = [&]() -> std::string_view {
            if (i + 1 == argc || argv[i + 1][0] == '\0') throw Error(std::string(name) + " has no value (it takes one); see track_camera --help");
            return argv[++i];
        };
        if (name == "--help") {
            std::cout << help;
            return {};
        }
        if (name == "--relative") o.relative = true;
        else if (name == "--quiet") o.quiet = true;
        else if (name == "--no-depth") o.depth = false;
        else if (name == "--trajectory") o.trajectory = value();
        else if (name == "--cameras") o.cameras = value();
        else if (name == "--camera") o.camera = value();
        else if (name == "--report") o.report = value();
        else if (name == "--out") o.out = value();
        else if (name == "--frames") o.frames = whole(name, value(), 1'000'000);
        else if (name == "--threads") o.threads = whole(name, value(), 1024);
        else if (name == "--size") {
            auto const text = value();
            auto const x = std::min(text.find('x'), text.size() - 1);
            o.size = {whole(name, text.substr(0, x), 65535), whole(name, text.substr(x + 1), 65535)};
        } else if (name == "--noise") {
            auto const text = std::string(value());
            char* end = nullptr;
            o.noise = std::strtod(text.c_str(), &end);
            if (end != text.c_str() + text.size() || !(o.noise >= 0.0 && o.noise <= 1.0)) refuse(name, text, "it takes a number from 0 to 1");
        } else if (name == "--method") {
            using tilemesh::track::Method;
            auto const text = value();
            if (text == "hybrid") o.method = Method::hybrid;
            else if (text == "forward") o.method = Method::forward;
            else if (text == "gradient") o.method = Method::gradient;
            else if (text == "esm") o.method = Method::esm;
            else refuse(name, text, "it takes hybrid, forward, gradient or esm");
        } else if (name.substr(0, 1) == "-" || name.empty() || o.map) refuse("an option", name, "there is no such option, or a second map");
        else o.map = name;
    }
    if (!o.camera.empty() && !o.cameras) throw Error("--camera needs a file (no --cameras is given); add --cameras FILE");
    if (o.relative && !o.trajectory) throw Error("--relative needs a trajectory (no --trajectory is given); add --trajectory FILE");
    return o;
}

} // namespace track_camera
