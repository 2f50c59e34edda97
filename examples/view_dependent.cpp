// A map with view-dependent colour (spherical harmonics), on the smallest machine that its cameras need: view_dependent [MAP.ply].
#include "shared/kept_inputs.hpp"
#include "shared/text.hpp"
#include <iostream>
#include <span>
#include <tilemesh/error.hpp>
#include <tilemesh/fit_renderer.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <vector>

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;

int main(int argc, char** argv)
try {
    using splat::Fitted, splat::Lossless;
    if (argc > 1) shared::keep_inputs({argv[1]}, {"view_dependent.ppm"});
    auto const map = argc > 1 ? scene::load_ply(argv[1]) : scene::built_in_map();
    std::vector<splat::Camera> const path{scene::frame_whole(map, {1280, 720})}; // all cameras that will be used

    auto const tiling = [](splat::Camera const& camera) { return tilemesh::tiling_for({}, camera.width, camera.height); };
    auto const demand = scene::demand_of(map, std::span(path), splat::Rules{}, tiling);
    // The first setup with everything that the scene needs. A record holds the map's harmonics, and one view needs no routing.
    auto const renderer = tilemesh::fit_renderer<Fitted<Lossless, 0, false>, Fitted<Lossless, 3, false>>(map, demand);
    auto const frame = renderer->render(path[0]);

    std::cout << "degree " << demand.sh_degree << ": records of " << tilemesh::render::record_bytes(renderer->setup()) << " bytes, "
              << renderer->setup().sizes.storage << " slots a tile, " << demand.culled << " records not loaded, "
              << (renderer->setup().routes ? "with" : "without") << " routing\n";
    if (!frame.report.lost.empty()) std::cout << frame.report.lost.size() << " records and copies found no room\n";
    report::write_ppm("view_dependent.ppm", frame.image);
} catch (tilemesh::Error const& error) {
    std::cerr << shared::one_line(error.what()) << '\n';
    return 2;
}
