// The modelled cost of a frame: the built-in map on a Mk2 that keeps a trace, with the modelled cycles of each step.
#include <iostream>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/cost_table.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/splat/setup_types.hpp>

namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;

struct Watched : splat::Lossless { // the same setup on a machine that keeps a trace
    using Machine = tilemesh::Traced<tilemesh::Mk2>;
};

int main()
try {
    auto const map = scene::built_in_map();
    tilemesh::BasicRenderer<splat::Referenced<Watched>> renderer{map, {.threads = 2}};
    auto const model = tilemesh::mk2();
    for (auto const& camera : scene::orbit(scene::built_in_camera({1280, 720}), scene::robust_centre(map), 0.5, 2)) {
        renderer.render(camera);
        auto const& trace = renderer.trace();
        auto const cost = model_cost(model, trace, renderer.mesh().grid());
        std::cout << cost_table(model, trace, cost) << "frame: " << milliseconds_text(model, cost.cycles) << " ms modelled, "
                  << cost.supersteps.size() << " passes\n\n";
    }
} catch (tilemesh::Error const& error) {
    std::cerr << error.what() << '\n';
    return 2;
}
