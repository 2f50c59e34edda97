// The heat equation on 40 x 36 tiles, checked against the decay that the mathematics predicts.
#include "heat.hpp"
#include <cmath>
#include <cstdio>
#include <numbers>
#include <tilemesh/engine/mesh.hpp>
int main()
{
    tilemesh::Mesh mesh{tilemesh::Repeat<Diffuse>{1001}, tilemesh::Grid{40, 36}, {.threads = 2}}; // the first pass only sends
    mesh.broadcast<Conductivity>().per_step = 0.2f;
    auto const wave = [](tilemesh::TileId tile) { return 100 * std::cos(std::numbers::pi * (tile.x() + 0.5) / 40); };
    for (auto [tile, cell] : mesh.states<Cell>()) cell.kelvin = static_cast<float>(300 + wave(tile));
    auto const run = mesh.run();
    double worst = 0, fade = std::pow(1 - 2 * 0.2 * (1 - std::cos(std::numbers::pi / 40)), 1000); // of one cosine from west to east
    for (auto [tile, cell] : mesh.states<Cell>()) worst = std::fmax(worst, std::fabs(cell.kelvin - (300 + fade * wave(tile))));
    std::printf("%.0f messages; the wave fades to %.4f of its height, off by at most %.4f K\n", static_cast<double>(run.messages()), fade, worst);
    return worst < 0.01 ? 0 : 1;
}
