#include "tables.hpp"
#include <algorithm>
#include <common/program.hpp>
#include <common/statistics.hpp>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/splat/exact.hpp>

namespace {

struct OnRoomyTiles : tilemesh::splat::Exact {
    using Machine = tilemesh::splat::RoomyMachine;
};
using ExactRenderer = tilemesh::BasicRenderer<OnRoomyTiles>;

tilemesh::RendererOptions roomy(tilemesh::scene::Map const& map, unsigned threads)
{
    tilemesh::RendererOptions options{.threads = threads};
    options.sizes = OnRoomyTiles::sizes;
    options.sizes->storage = std::max(20'000u, static_cast<std::uint32_t>(map.gaussians.size() / 12));
    return options;
}

} // namespace

FrameTimes time_frames(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& through_lens, std::uint32_t rounds, unsigned threads)
{
    auto straight = through_lens;
    straight.lens = {};
    tilemesh::Renderer pinhole{map, tilemesh::splat::lossless, {.threads = threads}}, lens{map, tilemesh::splat::lossless, {.threads = threads}};
    ExactRenderer exact_pinhole(map, roomy(map, threads)), exact_lens(map, roomy(map, threads));
    tilemesh::RenderedFrame frame;
    auto const time = [&](auto& renderer, tilemesh::splat::Camera camera, std::uint32_t round) {
        camera.position[0] += round % 2 == 0 ? 0.0f : 1e-3f; // a static view would keep its pixels
        bench::Stopwatch watch;
        renderer.render_into(camera, frame);
        return watch.lap();
    };
    std::vector<double> times[4], ratios[3];
    for (std::uint32_t round = 0; round < rounds + 3; ++round) {
        double const ms[] = {time(pinhole, straight, round), time(lens, through_lens, round), time(exact_pinhole, straight, round),
                             time(exact_lens, through_lens, round)};
        if (round < 3) continue; // tiles fill
        times[0].push_back(ms[0]);
        for (std::size_t i = 0; i < 3; ++i) ratios[i].push_back(ms[i + 1] / ms[0]);
    }
    return {bench::median(times[0]), bench::median(ratios[0]), bench::median(ratios[1]), bench::median(ratios[2])};
}
