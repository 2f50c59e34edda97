// Several frames with depth, on several threads. Each frame starts with the records where the last frame left them.
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
#include <tilemesh/splat/setup.hpp>

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
using WithDepth = splat::WithPixel<splat::Lossless, splat::WithDepth<splat::FloatPixel>>; // storage gives up 7 of 2,000 slots

int main(int argc, char** argv)
try {
    auto const map = argc > 1 ? scene::load_ply(argv[1]) : scene::built_in_map();
    auto const first = scene::frame_whole(map, {640, 360});
    tilemesh::BasicRenderer<splat::Referenced<WithDepth>> renderer{map, {.threads = std::thread::hardware_concurrency()}};
    int number = 0;
    for (auto const& camera : scene::orbit(first, scene::robust_centre(map), 5.0, 4)) { // degrees a frame, frames
        auto const frame = renderer.render(camera);
        auto const name = "walk_" + std::to_string(number++);
        report::write_ppm(name + ".ppm", frame.image);
        report::write_pfm(name + ".depth.pfm", frame.depth);
        std::cout << name << ": " << frame.report.gaussians.moved << " moved, " << frame.report.messages << " messages\n";
    }
} catch (tilemesh::Error const& error) {
    std::cerr << error.what() << '\n';
    return 2;
}
