// EXPECT: wire_bytes is what the machine moves for a message
#include <tilemesh/machine/channel.hpp>

struct Handle {
    static constexpr std::uint32_t wire_bytes = 6;
    std::uint32_t row;
};
struct Road : tilemesh::Channel<Handle, 4> {};

static_assert(Road::static_capacity == 4);
