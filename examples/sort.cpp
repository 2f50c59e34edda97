// Odd-even transposition sort: one number a tile, neighbours compare and exchange, as many passes as there are tiles.
#include <algorithm>
#include <iostream>
#include <random>
#include <tilemesh/engine/mesh.hpp>
#include <vector>

using tilemesh::Direction;

struct Key { std::uint32_t value, pass; };
struct Wire : tilemesh::Channel<std::uint32_t, 1, tilemesh::Edge::drop> {}; // the ends of the row have no partner

struct CompareExchange {
    void operator()(tilemesh::Here here, Key& key, tilemesh::In<Wire> in, tilemesh::Out<Wire> out) const noexcept
    {
        for (std::uint32_t other : in[Direction::east]) key.value = std::min(key.value, other);
        for (std::uint32_t other : in[Direction::west]) key.value = std::max(key.value, other);
        bool const even = (here.tile.x() + key.pass++) % 2 == 0;
        out[even ? Direction::east : Direction::west].push(key.value);
    }
};

int main()
{
    constexpr std::uint32_t n = 1000;
    tilemesh::Mesh mesh{tilemesh::Repeat<CompareExchange>{n + 1}, tilemesh::Grid{n, 1}}; // the first pass only sends
    std::mt19937 random{1};
    std::vector<std::uint32_t> expected, sorted;
    for (auto [tile, key] : mesh.states<Key>()) expected.push_back(key.value = static_cast<std::uint32_t>(random()));

    auto const run = mesh.run();

    for (auto [tile, key] : mesh.states<Key>()) sorted.push_back(key.value);
    std::sort(expected.begin(), expected.end());
    std::cout << n << " numbers " << (sorted == expected ? "are" : "are NOT") << " sorted after " << run.steps[0].passes << " passes and "
              << run.messages() << " messages\n";
    return sorted == expected ? 0 : 1;
}
