// Several frames with depth, on several threads. Each frame starts with the records where the last frame left them.
#include "shared/kept_inputs.hpp"
#include "shared/text.hpp"
#include <cstddef>
#include <filesystem>
#include <iostream>
#include <string>
#include <thread>
#include <tilemesh/error.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <vector>

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;

constexpr std::size_t frames = 4;
std::string name_of(std::size_t frame)
{
    return "walk_" + std::to_string(frame);
}
std::vector<std::filesystem::path> outputs()
{
    std::vector<std::filesystem::path> files;
    for (std::size_t i = 0; i < frames; ++i)
        for (char const* const extension : {".ppm", ".depth.pfm"}) files.emplace_back(name_of(i) + extension);
    return files;
}

using WithDepth = splat::WithPixel<splat::Lossless, splat::WithDepth<splat::FloatPixel>>; // storage gives up 7 of 2,000 slots

int main(int argc, char** argv)
try {
    if (argc > 1) shared::keep_inputs({argv[1]}, outputs()); // no picture takes the place of the map
    auto const map = argc > 1 ? scene::load_ply(argv[1]) : scene::built_in_map();
    auto const first = scene::frame_whole(map, {640, 360});
    tilemesh::BasicRenderer<splat::Referenced<WithDepth>> renderer{map, {.threads = std::thread::hardware_concurrency()}};
    std::size_t number = 0;
    for (auto const& camera : scene::orbit(first, scene::robust_centre(map), 5.0, frames)) { // degrees a frame
        auto const frame = renderer.render(camera);
        auto const name = name_of(number++);
        report::write_ppm(name + ".ppm", frame.image);
        report::write_pfm(name + ".depth.pfm", frame.depth);
        std::cout << name << ": " << frame.report.gaussians.moved << " moved, " << frame.report.messages << " messages\n";
    }
} catch (tilemesh::Error const& error) {
    std::cerr << shared::one_line(error.what()) << '\n';
    return 2;
}
