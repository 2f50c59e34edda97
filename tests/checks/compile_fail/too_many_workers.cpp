// EXPECT: a machine with more workers than Work counts for
#include <tilemesh/render/setup_choice.hpp>

struct EightWorkers : tilemesh::Mk2 {
    static constexpr std::uint32_t workers = 8;
};
struct Setup : tilemesh::splat::Lossless {
    using Machine = EightWorkers;
};

tilemesh::render::SetupFacts facts()
{
    return tilemesh::render::facts_of<Setup>();
}
