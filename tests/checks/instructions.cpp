// usage: instructions PART
// One small fixed frame of the built-in map on one thread, for callgrind, which counts the instructions of `measured_frame`. Exit status 1
// if the frame is wrong, so that no count is of a broken frame. In a static view all tiles composite too, except in `kept_fast`, where tiles
// keep their pixels. With -DTRACED the machine keeps a trace.
#include <common/direct.hpp>
#include <cstdint>
#include <cstdio>
#include <string>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/orbit.hpp>

namespace {

namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;

#ifdef TRACED
struct Watched : splat::Lossless {
    using Machine = tilemesh::Traced<tilemesh::Mk2>;
};
using Renderer = tilemesh::BasicRenderer<splat::Referenced<Watched>>;
#else
using Renderer = tilemesh::Renderer;
#endif

bench::Team team(1);
bench::Direct* direct = nullptr;
Renderer* mesh = nullptr;
splat::Camera camera;
splat::Rules rules;
tilemesh::RenderedFrame frame;

} // namespace

extern "C" [[gnu::noinline]] void measured_frame()
{
    if (direct != nullptr) direct->render(camera, rules, team);
    else mesh->render_into(camera, frame);
}

int main(int argc, char** argv)
{
    std::string const part = argc == 2 ? argv[1] : "";
    auto const ends_in = [&](std::string const& end) {
        return part.size() > end.size() && part.substr(part.size() - end.size()) == end;
    };
    if (!ends_in("_precise") && !ends_in("_fast")) {
        std::fprintf(stderr, "\"%s\" is no part (see instructions.sh); name one of its\n", part.c_str());
        return 2;
    }
    rules.arithmetic = ends_in("_fast") ? splat::Arithmetic::fast : splat::Arithmetic::precise;
    auto const work = part.substr(0, part.rfind('_'));

    // Every eighth record: all kinds of records, and few enough for 10 x 9 tiles.
    auto map = scene::built_in_map();
    for (std::size_t i = 0; 8 * i < map.gaussians.size(); ++i) map.gaussians[i] = map.gaussians[8 * i];
    map.gaussians.resize((map.gaussians.size() + 7) / 8);
    auto const start = scene::built_in_camera({320, 180});
    auto const turned = scene::orbit(start, scene::robust_centre(map), 2.0, 2).back();

    bench::Direct rasteriser(map.gaussians);
    Renderer renderer(map, {.tile = {32, 20}, .keep_pixels = work == "kept"});
    renderer.rules().arithmetic = rules.arithmetic;
    renderer.prepare(start.width, start.height);
    camera = start;
    if (work == "direct") {
        direct = &rasteriser;
        rasteriser.render(camera, rules, team); // allocates its memory
    } else {
        mesh = &renderer;
        if (work == "static" || work == "kept" || work == "moved") renderer.render_into(camera, frame);
        if (work == "moved") camera = turned;
    }
    measured_frame();

    if (direct == nullptr) rasteriser.render(camera, rules, team);
    else renderer.render_into(camera, frame);
    bool const ok = rasteriser.equals(frame.image) && rasteriser.pairs_contributing() > 100'000 &&
                    frame.report.lost.empty() && (work == "direct" || (frame.report.messages > 0) == (work != "static" && work != "kept"));
    if (!ok) std::printf("the frame of %s is not what it should be\n", part.c_str());
    return ok ? 0 : 1;
}
