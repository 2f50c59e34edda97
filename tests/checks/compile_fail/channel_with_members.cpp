// EXPECT: a named channel with members of its own
#include <tilemesh/engine/mesh.hpp>

struct Wire : tilemesh::Channel<float, 4> {
    float sum;
};
struct Step {
    void operator()(tilemesh::In<Wire>, tilemesh::Out<Wire> out) const noexcept { out.to_all(0); }
};

int main()
{
    tilemesh::Mesh mesh{tilemesh::Superstep<Step>{}, tilemesh::Grid{2, 2}};
    mesh.run();
}
