// EXPECT: a region of this program names a member of sizes that were not given; name the setup that has them
#include <tilemesh/engine/contract.hpp>
#include <tilemesh/engine/mesh.hpp>

struct Slots {
    std::uint32_t pile = 0;
};
struct Pile : tilemesh::Buffer<std::uint32_t> {
    static constexpr auto slots = &Slots::pile;
};
struct Step {
    void operator()(Pile& pile) const noexcept { pile.truncate(0); }
};

void run()
{
    tilemesh::Mesh<tilemesh::Superstep<Step>>{{}, {2, 2}}.run();
}
