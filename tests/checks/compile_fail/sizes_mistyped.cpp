// EXPECT: (member named .*storage_slot|storage_slot.* does not refer to any field)
#include <tilemesh/splat/setup_types.hpp>

struct Setup : tilemesh::splat::Lossless {
    static constexpr tilemesh::splat::Sizes sizes{.storage_slot = 700};
};
