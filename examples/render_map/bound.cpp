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
#include <vector>

namespace render_map {

namespace {

template <class S>
BoundRenderer renderer_of(tilemesh::scene::Map const& map, unsigned threads)
{
    auto const renderer = std::make_shared<tilemesh::BasicRenderer<S>>(map, tilemesh::RendererOptions{.threads = threads});
    return [renderer](tilemesh::splat::Camera const& camera, tilemesh::splat::Rules const& rules) {
        renderer->rules() = rules;
        return renderer->render(camera);
    };
}

} // namespace

BoundRenderer make_bound_renderer(tilemesh::scene::Map const& map, unsigned threads)
{
    return map.sh_degree == 0 ? renderer_of<tilemesh::splat::BoundedOf<0>>(map, threads) : renderer_of<tilemesh::splat::BoundedOf<3>>(map, threads);
}

std::string bound(Options const& options, BoundRenderer const& renderer, tilemesh::splat::Camera const& camera, tilemesh::splat::Rules const& rules,
                  std::size_t frames, Frame const& frame)
{
    auto const result = renderer(camera, rules);
    std::string const of_frame = frames == 1 ? "bound: " : "bound of frame " + std::to_string(frame.index) + ": ";
    auto const lacks = [](tilemesh::report::FrameReport const& r) { return !r.lost.empty() || !r.unfinished.empty(); };
    if (lacks(frame.entry.report)) return of_frame + "none, because the picture lacks something";
    if (lacks(result.report))
        return of_frame + "none, because " + std::to_string(result.report.lost.size()) +
               " records or copies find no room beside the bound's words (tiles of 1,400 slots); --certify has no such limit";
    tilemesh::report::write_pfm(frame_path(options, frame.index, ".bound.pfm"), result.alpha, outlasts(options));
    auto levels = result.alpha.values;
    std::sort(levels.begin(), levels.end());
    auto const at = [&](double q) {
        return tilemesh::report::significant(255 * 1.01 * double{levels[static_cast<std::size_t>(std::ceil(q * static_cast<double>(levels.size() - 1)))]}, 3);
    };
    return of_frame + "on the tiles, in float32, every channel is within " + at(1) + "/255 of the exact formula (p99 " + at(0.99) + ", median " +
           at(0.5) + "; each pixel's is in " + frame_file(frame.index, ".bound.pfm") + ")";
}

} // namespace render_map
