// The heat equation, checked against the decay that the mathematics predicts.
#include "heat.hpp"
#include <cmath>
#include <cstdio>
#include <numbers>
#include <tilemesh/engine/mesh.hpp>

int main()
{
    Mesh<Heat> mesh{Grid{40, 36}, {.threads = 2}, Heat{{{1001}}}}; // the first superstep only tells
    mesh.broadcast<Conductivity>().per_step = 0.2f;
    // One cosine from west to east: it keeps its shape and fades by 1 - 2 k (1 - cos(pi / 40)) a step.
    auto const shape = [](std::uint32_t x) { return std::cos(std::numbers::pi * (x + 0.5) / 40); };
    for (std::uint32_t i = 0; i < mesh.grid().size(); ++i)
        mesh.state<Cell>(mesh.grid().tile(i)).kelvin = static_cast<float>(300 + 100 * shape(mesh.grid().tile(i).x()));

    auto const run = mesh.run();

    double const fade = std::pow(1 - 2 * 0.2 * (1 - std::cos(std::numbers::pi / 40)), 1000);
    double worst = 0;
    for (std::uint32_t i = 0; i < mesh.grid().size(); ++i) {
        auto const t = mesh.grid().tile(i);
        double const error = mesh.state<Cell>(t).kelvin - (300 + 100 * fade * shape(t.x()));
        worst = std::fmax(worst, std::fabs(error));
    }
    std::printf("%llu supersteps, %llu messages; the wave fades to %.4f of its height, off by at most %.5f K\n",
                static_cast<unsigned long long>(run.supersteps()), static_cast<unsigned long long>(run.messages()), fade, worst);
    return worst < 0.01 ? 0 : 1;
}
