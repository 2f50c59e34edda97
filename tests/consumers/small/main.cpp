// A user's program that compiles quickly, for tests that differ only in where the library is found.
#include <iostream>
#include <tilemesh/engine/mesh.hpp>

struct Count { std::uint32_t seen; };
struct Ring : tilemesh::Channel<std::uint32_t, 1> {};
struct Pass {
    void operator()(Count& count, tilemesh::In<Ring> in, tilemesh::Out<Ring> out) const noexcept
    {
        for (auto d : tilemesh::news)
            for (std::uint32_t neighbour : in[d]) count.seen += neighbour;
        for (auto d : tilemesh::news) out[d].unchecked_push(1);
    }
};
using Program = tilemesh::Sequence<tilemesh::Repeat<Pass>>;

int main()
{
    tilemesh::Mesh<Program> mesh{Program{{3}}, tilemesh::Grid{4, 3}, {.threads = 2}};
    auto const run = mesh.run();
    std::cout << "exchanges " << run.exchanges() << '\n'
              << "messages " << run.messages() << '\n'
              << "seen " << mesh.state<Count>(mesh.grid().tile(0)).seen << '\n';
}
