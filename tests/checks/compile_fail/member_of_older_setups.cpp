// EXPECT: a setup that names storage_slots, road_bytes, .* .its sizes are one value: they would change nothing.; give it static constexpr Sizes sizes
#include <tilemesh/render/setup_choice.hpp>

struct Setup : tilemesh::splat::Lossless {
    static constexpr std::uint32_t storage_slots = 700;
};

tilemesh::render::SetupFacts facts()
{
    return tilemesh::render::facts_of<Setup>();
}
