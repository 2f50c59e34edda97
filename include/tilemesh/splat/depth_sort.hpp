#pragma once
#include <tilemesh/splat/policies.hpp>

namespace tilemesh::splat {

namespace detail {
/// Heap sort (Williams 1964): in place, iterative, at most 2 n log2 n compares whatever the input; a quicksort on sorted or
/// equal keys needs n^2 / 2 (numerics, row 62).
template <class Key>
void heap_sort(Key* keys, std::uint32_t n) noexcept
{
    auto const sift = [keys](std::uint32_t hole, std::uint32_t size) noexcept {
        Key const key = keys[hole];
        for (;;) {
            std::uint32_t child = 2 * hole + 1;
            if (child >= size) break;
            if (child + 1 < size && keys[child] < keys[child + 1]) ++child;
            if (!(key < keys[child])) break;
            keys[hole] = keys[child];
            hole = child;
        }
        keys[hole] = key;
    };
    for (std::uint32_t i = n / 2; i-- > 0;) sift(i, n);
    for (std::uint32_t end = n; end-- > 1;) {
        Key const largest = keys[0];
        keys[0] = keys[end];
        keys[end] = largest;
        sift(0, end);
    }
}
} // namespace detail

/// Lists what touches the tile, front to back: by depth, ties by id, so that the order is a function of view and scene alone,
/// the same on every tile and for every order of arrival. No exchange.
template <class S>
struct DepthSort {
    static constexpr char const* name = "depth sort";

    void operator()(Here here, Broadcast<FrameParameters> frame, Marks<S> const& marks, Splats<S> const& splats,
                    Order<S>& order) const noexcept
    {
        order.truncate(0);
        for (std::uint32_t i = 0, n = splats.size(); i < n; ++i)
            if (covers(splats[i], frame->tiling, here.tile))
                order.unchecked_push({__builtin_bit_cast(std::uint32_t, splats[i].depth), marks[i].id, i});
        detail::heap_sort(order.begin(), order.size());
    }
};

} // namespace tilemesh::splat
