#include "scaling.hpp"
#include <cmath>
#include <common/statistics.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/setup_types.hpp>

namespace scaling {

bench::Scene synthetic(std::uint32_t gaussians, tilemesh::scene::Size size, std::uint32_t pixels_wide)
{
    namespace scene = tilemesh::scene;
    bench::Scene out;
    out.camera = scene::make_camera(scene::look_at({0, 0, 0}, {0, 0, 1}), scene::lens_from_field_of_view(60.0, size));
    out.map.name = "synthetic";
    out.map.gaussians.reserve(gaussians);
    // Half the view at depth 1, along both axes, and the size of a pixel at that depth.
    double const half_x = std::tan(30.0 * 3.14159265358979323846 / 180.0), half_y = half_x * size.height / size.width;
    double const pixel = 2 * half_x / pixels_wide;
    for (std::uint32_t i = 0; i < gaussians; ++i) {
        std::uint32_t which = 0;
        auto const next = [&] { return bench::even(i, which++); };
        tilemesh::splat::Gaussian g{};
        g.id = tilemesh::splat::GaussianId{i + 1};
        double const depth = 2.0 + 4.0 * next();
        g.mean_world[0] = static_cast<float>((2.0 * next() - 1.0) * 1.2 * half_x * depth);
        g.mean_world[1] = static_cast<float>((2.0 * next() - 1.0) * 1.2 * half_y * depth);
        g.mean_world[2] = static_cast<float>(depth);
        for (float& c : g.colour) c = static_cast<float>(next());
        g.opacity = static_cast<float>(0.05 + 0.55 * next());
        for (float& q : g.rotation) q = static_cast<float>(next() + next() + next() - 1.5);
        double const length = std::log(pixel * depth * std::exp(2.0 * next())); // 1 to 7.4 pixels
        for (float& s : g.log_scale) s = static_cast<float>(length - 2.0 * next());
        out.map.gaussians.push_back(g);
    }
    return out;
}

tilemesh::render::Setup roomy_setup()
{
    auto setup = tilemesh::splat::setup_of<tilemesh::splat::Lossless>();
    setup.machine = tilemesh::size_of_machine<tilemesh::splat::RoomyMachine>();
    setup.sizes.storage = 40'000;         // Sloth on 10 x 9 tiles, a million Gaussians on 1,440
    setup.sizes.tile_pixels = 128 * 80;   // 1280 x 720 on 10 x 9 tiles; 3840 x 2160 on 40 x 36 has 96 x 60
    return setup;
}

} // namespace scaling
