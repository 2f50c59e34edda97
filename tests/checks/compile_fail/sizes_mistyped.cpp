// EXPECT: (no member named|has no non-static data member named|does not refer to any field).*storage_slot
#include <tilemesh/splat/setup.hpp>

struct Setup : tilemesh::splat::Lossless {
    static constexpr tilemesh::splat::Sizes sizes{.storage_slot = 700};
};
