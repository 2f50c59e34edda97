#include "picture.hpp"
#include <algorithm>
#include <common/homes_machine.hpp>
#include <common/machine.hpp>
#include <common/scenes.hpp>
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
constexpr std::uint32_t left = 280, top = 190, width = 200, height = 90, times = 3, gap = 8;

void put(tilemesh::report::Image const& from, tilemesh::report::Image& to, std::uint32_t x)
{
    for (std::uint32_t j = 0; j < times * height; ++j)
        for (std::uint32_t i = 0; i < times * width; ++i)
            std::copy_n(from.pixel(left + i / times, top + j / times), 3, to.pixel(x + i, j));
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
    tilemesh::report::Image picture(2 * times * width + gap, times * height);
    std::fill(picture.rgb.begin(), picture.rgb.end(), 1.0f);
    put(anchored->image(), picture, 0);
    put(homes->image(), picture, times * width + gap);
    shared::write_png(options.picture, picture);
    using tilemesh::report::thousands;
    std::cout << "wrote " << options.picture.string() << ": left anchored, which lacks " << thousands(anchored->report().lost.size())
              << " records and copies; right homes, in " << thousands(homes->report().homes.rounds) << " rounds\n";
}

} // namespace any_map
