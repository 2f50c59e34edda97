#include "any_map.hpp"
#include <algorithm>
#include <common/homes_machine.hpp>
#include <common/machine.hpp>
#include <common/pictures.hpp>
#include <iostream>
#include <shared/png.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/splat/setup_types.hpp>

namespace any_map {

namespace {

/// The part of the frame that shows the seams, and how many pixels of the picture one of its pixels takes along each axis.
constexpr std::uint32_t left = 280, top = 190, width = 200, height = 90, times = 3;

tilemesh::report::Image enlarged(tilemesh::report::Image const& from)
{
    tilemesh::report::Image to(times * width, times * height);
    for (std::uint32_t j = 0; j < to.height; ++j)
        for (std::uint32_t i = 0; i < to.width; ++i) std::copy_n(from.pixel(left + i / times, top + j / times), 3, to.pixel(i, j));
    return to;
}

} // namespace

void write_picture(Options const& options)
{
    std::string const name = "playbot_250k";
    if (!bench::has_scene(name, options.data))
        throw tilemesh::Error("--picture needs map " + name + " (it is not there); name its folder with --data");
    auto const scene = bench::load_scene(name, options.data, {640, 360});
    auto const cameras = tilemesh::scene::orbit(scene.camera, tilemesh::scene::robust_centre(scene.map), 45, 2);
    auto const setup = tilemesh::splat::setup_of<tilemesh::splat::Lossless>();
    auto const anchored = bench::make_traced_machine(scene.map, setup, {.threads = options.threads, .grid = {40, 36}});
    auto const homes = bench::make_homes_machine(scene.map, {.rules = setup.rules, .threads = options.threads});
    for (auto const& camera : cameras) {
        anchored->render(camera);
        homes->render(camera);
    }
    shared::write_png(options.picture, bench::side_by_side({enlarged(anchored->image()), enlarged(homes->image())}));
    using tilemesh::report::thousands;
    std::cout << "wrote " << options.picture.string() << ": left anchored, which lacks " << thousands(anchored->report().lost.size())
              << " records and copies; right homes, in " << thousands(homes->report().homes.rounds) << " rounds\n";
}

} // namespace any_map
