#include "bound.hpp"
#include "outputs.hpp"
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/splat/bounded.hpp>
#include <tilemesh/splat/setup_types.hpp>

namespace render_map {

namespace {

/// On tiles with more memory than Mk2's, where a frame needs it. The default sizes are those that fit on Mk2.
template <std::uint32_t Degree>
struct OnRoomyTiles : tilemesh::splat::BoundedOf<Degree> {
    using Machine = tilemesh::splat::RoomyMachine;
};

bool lacks(tilemesh::report::FrameReport const& report) { return !report.lost.empty() || !report.unfinished.empty(); }

template <std::uint32_t Degree>
BoundRenderer renderer_of(tilemesh::scene::Map const& map, unsigned threads)
{
    using Setup = OnRoomyTiles<Degree>;
    struct State {
        std::unique_ptr<tilemesh::BasicRenderer<Setup>> renderer;
        std::uint32_t slots = Setup::sizes.storage;
    };
    return [&map, threads, state = std::make_shared<State>()](tilemesh::splat::Camera const& camera, tilemesh::splat::Rules const& rules) {
        for (;;) {
            auto& renderer = state->renderer;
            if (!renderer) {
                tilemesh::RendererOptions options{.threads = threads};
                options.sizes = Setup::sizes, options.sizes->storage = state->slots;
                renderer = std::make_unique<tilemesh::BasicRenderer<Setup>>(map, options);
            }
            renderer->rules() = rules;
            BoundFrame frame{renderer->render(camera), state->slots, state->slots == Setup::sizes.storage};
            auto const more = std::max(20'000u, static_cast<std::uint32_t>(map.gaussians.size() / 12)); // as in bench/frame
            if (!lacks(frame.frame.report) || state->slots == more) return frame;
            state->slots = more, renderer.reset();
        }
    };
}

} // namespace

BoundRenderer make_bound_renderer(tilemesh::scene::Map const& map, unsigned threads)
{
    return map.sh_degree == 0 ? renderer_of<0>(map, threads) : renderer_of<3>(map, threads);
}

std::string bound(Options const& options, BoundRenderer const& renderer, tilemesh::splat::Camera const& camera, tilemesh::splat::Rules const& rules,
                  std::size_t frames, Frame const& frame)
{
    std::string const of_frame = frames == 1 ? "bound: " : "bound of frame " + std::to_string(frame.index) + ": ";
    if (lacks(frame.entry.report)) return of_frame + "none, because the picture lacks something";
    auto const bounded = renderer(camera, rules);
    auto const& result = bounded.frame;
    if (lacks(result.report))
        return of_frame + "none, because records or copies find no room on tiles of " + std::to_string(bounded.slots) +
               " slots; --certify has no such limit";
    tilemesh::report::write_pfm(frame_path(options, frame.index, ".bound.pfm"), result.alpha, outlasts(options));
    auto levels = result.alpha.values;
    std::sort(levels.begin(), levels.end());
    auto const at = [&](double q) {
        return tilemesh::report::significant(255 * 1.01 * double{levels[static_cast<std::size_t>(std::ceil(q * static_cast<double>(levels.size() - 1)))]}, 3);
    };
    std::string const tiles = bounded.fits ? "on the tiles" : "on larger tiles (of " + std::to_string(bounded.slots) + " slots; mk2's were too small)";
    return of_frame + tiles + ", in float32, every channel is within " + at(1) + "/255 of the exact formula (p99 " + at(0.99) + ", median " +
           at(0.5) + "; each pixel's is in " + frame_file(frame.index, ".bound.pfm") + ")";
}

} // namespace render_map
