// The modelled cost of a frame: the built-in map on a Mk2 that keeps a trace, with the modelled cycles of each step.
#include <iostream>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/cost_table.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/orbit.hpp>

namespace scene = tilemesh::scene;

int main()
try {
    auto const map = scene::built_in_map();
    tilemesh::Renderer renderer{map, {.threads = 2, .trace = true}};
    auto const model = tilemesh::mk2();
    for (auto const& camera : scene::orbit(scene::built_in_camera({1280, 720}), scene::robust_centre(map), 0.5, 2)) {
        renderer.render(camera);
        auto const& trace = renderer.trace();
        auto const cost = model_cost(model, trace, {renderer.grid().width, renderer.grid().height});
        std::cout << cost_table(model, trace, cost) << "frame: " << milliseconds_text(model, cost.cycles) << " ms modelled, "
                  << cost.supersteps.size() << " passes\n\n";
    }
} catch (tilemesh::Error const& error) {
    std::cerr << error.what() << '\n';
    return 2;
}
