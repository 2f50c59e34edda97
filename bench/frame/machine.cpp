#include "machine.hpp"
#include <algorithm>
#include <tilemesh/render/frame_renderer.hpp>
#include <tilemesh/render/homes_renderer.hpp>

std::unique_ptr<frame::Machine> frame::make_machine(Kind kind, Pixels pixels, tilemesh::scene::Map const& map,
                                                    tilemesh::splat::Arithmetic arithmetic, std::uint32_t threads,
                                                    tilemesh::splat::Camera const& camera)
{
    auto setup = tilemesh::splat::setup_of<tilemesh::splat::Lossless>();
    setup.rules.transmittance_min = stop_of_3dgs;
    setup.rules.arithmetic = arithmetic;
    tilemesh::RendererOptions options{.threads = threads, .keep_pixels = pixels == Pixels::kept};
    if (kind == Kind::large) {
        setup.machine = tilemesh::size_of_machine<tilemesh::splat::RoomyMachine>();
        // An object capture has most of its records, and their copies, on a few tiles.
        setup.sizes.storage = std::max(20'000u, static_cast<std::uint32_t>(map.gaussians.size() / 12));
    }
    if (kind == Kind::wide) {
        auto const part = [](std::uint32_t size, std::uint32_t tiles) { return (size + tiles - 1) / tiles; };
        setup.machine = tilemesh::size_of_machine<tilemesh::TestMachine<tilemesh::Mk2::sram_bytes, 100'000>>();
        options.grid = {400, 250};
        options.tile = {part(camera.width, 40), part(camera.height, 36)};
    }
    return bench::make_machine(map, setup, options);
}

std::unique_ptr<tilemesh::AnyRenderer> frame::make_homes(tilemesh::scene::Map const& map, tilemesh::splat::Arithmetic arithmetic,
                                                         std::uint32_t threads)
{
    auto choice = tilemesh::splat::homes_setup;
    choice.fit = true;
    choice.rules.transmittance_min = stop_of_3dgs;
    choice.rules.arithmetic = arithmetic;
    return tilemesh::render::make_homes_renderer(map, choice, {.threads = threads});
}
