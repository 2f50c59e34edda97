// The smallest way from a map to a picture: picture [MAP.ply] [OUT.png]. Without a map, it renders the built-in one.
#include "shared/png.hpp"
#include "shared/process.hpp"
#include "shared/text.hpp"
#include <filesystem>
#include <iostream>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/distinct_files.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/scene/records.hpp>
#include <unistd.h>

namespace {
constexpr char const* usage = "usage: picture [MAP.ply] [OUT.png] (default: the built-in map, and picture.png)\n";

/// The built-in map is composed for a camera of its own. Of any other map, the camera is a guess.
tilemesh::splat::Camera camera_of(tilemesh::scene::Map const& map, bool built_in)
{
    tilemesh::scene::Size const size{1280, 720};
    return built_in ? tilemesh::scene::built_in_camera(size) : tilemesh::scene::frame_whole(map, size);
}

int render(int argc, char** argv)
{
    namespace fs = std::filesystem;
    for (int i = 1; i < argc; ++i) {
        std::string const word = argv[i];
        if (word == "--help" || word == "-h") {
            std::cout << usage;
            return 0;
        }
        if (word.empty() || word[0] == '-' || i > 2)
            throw tilemesh::Error("\"" + word + "\" is no file for picture (it takes a map and the name of a PNG); see picture --help");
    }
    bool const built_in = argc == 1;
    fs::path const out = argc > 2 ? argv[2] : "picture.png";
    tilemesh::report::DistinctFiles files;
    if (!built_in) files.read(argv[1]);
    files.write_stream(STDOUT_FILENO, "standard output", "send it to another file");
    files.write(out, "the picture", "name another file as the second argument");

    auto const map = built_in ? tilemesh::scene::built_in_map() : tilemesh::scene::load_ply(argv[1]);
    tilemesh::Renderer renderer{at_degree(map, 0)}; // Mk2, 40 x 36 tiles, preset lossless; a Gaussian has one colour
    auto const frame = renderer.render(camera_of(map, built_in));
    shared::write_png(out, frame.image);

    std::cout << "The picture of " << map.gaussians.size() << " Gaussians: "
              << shared::one_line(fs::absolute(out).lexically_normal().string()) << '\n';
    if (map.sh_degree != 0) std::cout << "Each Gaussian has one colour here; render_map shows the colours that depend on the view.\n";
    if (!frame.report.lost.empty())
        std::cout << "It lacks " << frame.report.lost.size() << " records and copies (tiles are full); render_map renders such a map completely.\n";
    return 0;
}
} // namespace

int main(int argc, char** argv)
{
    return shared::run_softly("picture", [&] { return render(argc, argv); });
}
