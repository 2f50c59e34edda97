// EXPECT: a machine with more workers than Work counts for
#include <tilemesh/render/setup.hpp>

struct EightWorkers : tilemesh::Mk2 {
    static constexpr std::uint32_t workers = 8;
};
struct Setup : tilemesh::splat::Lossless {
    using Machine = EightWorkers;
};

tilemesh::render::Setup facts()
{
    return tilemesh::render::setup_for<Setup>();
}
