// EXPECT: memory_of names a channel that itself lies in another's memory
#include <tilemesh/machine/tile.hpp>

struct House : tilemesh::Channel<std::uint32_t, 4> {};
struct Guest : tilemesh::Channel<std::uint32_t, 4> {
    using memory_of = House;
};
struct GuestOfGuest : tilemesh::Channel<std::uint32_t, 4> {
    using memory_of = Guest;
};
template <class C>
struct Touch {
    void operator()(tilemesh::In<C>, tilemesh::Out<C>) const noexcept {}
};
using Program = tilemesh::Sequence<tilemesh::Superstep<Touch<House>>, tilemesh::Superstep<Touch<Guest>>, tilemesh::Superstep<Touch<GuestOfGuest>>>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
