// A user's first program: a map, a camera, a picture. Run with the name of a 3DGS PLY file, or without for the built-in map.
#include "shared/kept_inputs.hpp"
#include "shared/text.hpp"
#include <iostream>
#include <tilemesh/error.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/scene/records.hpp>

int main(int argc, char** argv)
try {
    if (argc > 1) shared::keep_inputs({argv[1]}, {"first_frame.pfm", "first_frame.ppm"});
    auto const map = argc > 1 ? tilemesh::scene::load_ply(argv[1]) : tilemesh::scene::built_in_map();
    auto const camera = tilemesh::scene::frame_whole(map, {1280, 720});

    tilemesh::Renderer renderer{at_degree(map, 0)}; // Mk2, 40 x 36 tiles, preset lossless; a Gaussian has one colour
    auto const frame = renderer.render(camera);

    tilemesh::report::write_pfm("first_frame.pfm", frame.image);
    tilemesh::report::write_ppm("first_frame.ppm", frame.image);
    std::cout << frame.report;                 // passes, exchanges, messages, losses, peaks, milliseconds by stage
} catch (tilemesh::Error const& error) {
    std::cerr << shared::one_line(error.what()) << '\n';
    return 2;
}
