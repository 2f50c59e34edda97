// Jacobi's method for Laplace's equation: 16 x 16 cells a tile, until no cell of the whole grid changes by more than 1e-5.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/machine/channel.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/reduce.hpp>
#include <tilemesh/machine/superstep.hpp>
using tilemesh::Direction, tilemesh::Vote;
constexpr std::uint32_t n = 16;
struct Field { float u[n + 2][n + 2], change; };                       // the tile's cells, and on each side a halo of one cell
struct Halo : tilemesh::Channel<float, n, tilemesh::Edge::drop> {};    // at the edge of the grid, the halo is a boundary value
using Change = tilemesh::Member<&Field::change>;
/// Cell i along a side: of the halo (depth 0), or of the tile's own outermost cells (depth 1).
float& along(Field& f, Direction side, std::uint32_t i, std::uint32_t depth) noexcept
{
    auto const across = side == Direction::north || side == Direction::west ? depth : n + 1 - depth;
    return side == Direction::north || side == Direction::south ? f.u[across][i + 1] : f.u[i + 1][across];
}
struct Relax {
    Vote operator()(Field& f, tilemesh::In<Halo> in, tilemesh::Out<Halo> out) const noexcept
    {
        for (auto side : tilemesh::news)
            for (std::uint32_t i = 0; i < in[side].size(); ++i) along(f, side, i, 0) = in[side][i];
        Field const old = f;
        f.change = 0;
        for (std::uint32_t y = 1; y <= n; ++y)
            for (std::uint32_t x = 1; x <= n; ++x) {
                f.u[y][x] = 0.25f * (old.u[y - 1][x] + old.u[y + 1][x] + old.u[y][x - 1] + old.u[y][x + 1]);
                f.change = std::max(f.change, std::fabs(f.u[y][x] - old.u[y][x]));
            }
        for (auto side : tilemesh::news)
            for (std::uint32_t i = 0; i < n; ++i) out[side].push(along(f, side, i, 1));
        return Vote::busy; // so the Loop makes its first round
    }
};
struct Judge {
    Vote operator()(tilemesh::Reduced<Change, tilemesh::Most> const& largest) const noexcept
    {
        return largest.value > 1e-5f ? Vote::busy : Vote::quiet;       // every tile has the same value
    }
};
int main()
{
    tilemesh::Sequence program{tilemesh::Superstep<Relax>{}, tilemesh::Loop{tilemesh::Repeat<Relax>{100},
                               tilemesh::Reduce<Change, tilemesh::Most, tilemesh::ReduceTo::all>{}, tilemesh::Superstep<Judge>{}}};
    tilemesh::Mesh mesh{program, tilemesh::Grid{4, 3}, {.threads = 2}};
    for (auto [tile, f] : mesh.states<Field>()) std::fill_n(f.u[0], n + 2, tile.y() == 0 ? 1.0f : 0.0f); // the northern wall is hot
    auto const run = mesh.run();
    static double now[3 * n + 2][4 * n + 2], old[3 * n + 2][4 * n + 2], worst; // the same sweeps in double precision, without tiles
    std::fill_n(now[0], 4 * n + 2, 1.0);
    for (auto sweeps = run.steps[0].passes + run.steps[1].passes; sweeps > 0; --sweeps) {
        std::memcpy(old, now, sizeof now);
        for (std::uint32_t y = 1; y <= 3 * n; ++y)
            for (std::uint32_t x = 1; x <= 4 * n; ++x) now[y][x] = 0.25 * (old[y - 1][x] + old[y + 1][x] + old[y][x - 1] + old[y][x + 1]);
    }
    for (auto [tile, f] : mesh.states<Field>())
        for (std::uint32_t i = 0; i < n * n; ++i)
            worst = std::max(worst, std::fabs(f.u[i / n + 1][i % n + 1] - now[tile.y() * n + i / n + 1][tile.x() * n + i % n + 1]));
    std::cout << run.loops[0].rounds << " rounds of 100 sweeps; off by at most " << worst << " from the plain loop\n";
    return worst < 1e-4 && run.loops[0].rounds > 1 ? 0 : 1;
}
