#pragma once
#include <tilemesh/splat/policies.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace detail {
/// Sinks the key at `hole` of a heap of n keys, the largest first, to its place.
template <class Key>
void sift(Key* keys, std::uint32_t hole, std::uint32_t n) noexcept
{
    Key const key = keys[hole];
    for (;;) {
        std::uint32_t child = 2 * hole + 1;
        if (child >= n) break;
        if (child + 1 < n && keys[child] < keys[child + 1]) ++child;
        if (!(key < keys[child])) break;
        keys[hole] = keys[child];
        hole = child;
    }
    keys[hole] = key;
}
template <class Key>
void make_heap(Key* keys, std::uint32_t n) noexcept
{
    for (std::uint32_t i = n / 2; i-- > 0;) sift(keys, i, n);
}
/// Heap sort (Williams 1964): in place, iterative, at most 2 n log2 n compares for any input. A quicksort needs n^2 / 2 compares on sorted
/// or equal keys (tests/stability/order.cpp, row 62).
template <class Key>
void heap_sort(Key* keys, std::uint32_t n) noexcept
{
    make_heap(keys, n);
    for (std::uint32_t end = n; end-- > 1;) {
        Key const largest = keys[0];
        keys[0] = keys[end];
        keys[end] = largest;
        sift(keys, 0, end);
    }
}

/// Introsort (Musser 1997): quicksort by the median of three, insertion sort for short ranges, heap sort for a range that quicksort splits
/// badly too often. In place, iterative, at most O(n log n) compares; on keys in random order about a third of heap sort's time.
template <class Key>
void intro_sort(Key* keys, std::uint32_t n) noexcept
{
    constexpr std::uint32_t most_ranges = 32, shortest = 16; // a range that waits is at least as long as the one that goes on
    struct Range {
        std::uint32_t first, last, splits;
    };
    Range waiting[most_ranges];
    std::uint32_t ranges = 0, first = 0, last = n, splits = 0;
    for (std::uint32_t m = n; m > 1; m /= 2) splits += 2;
    for (;;) {
        if (last - first > shortest && splits == 0) {
            heap_sort(keys + first, last - first);
            first = last;
        }
        if (last - first <= shortest) {
            for (std::uint32_t i = first + 1; i < last; ++i) {
                Key const key = keys[i];
                std::uint32_t hole = i;
                for (; hole > first && key < keys[hole - 1]; --hole) keys[hole] = keys[hole - 1];
                keys[hole] = key;
            }
            if (ranges == 0) return;
            --ranges;
            first = waiting[ranges].first, last = waiting[ranges].last, splits = waiting[ranges].splits;
            continue;
        }
        Key const a = keys[first], b = keys[first + (last - first) / 2], c = keys[last - 1];
        Key const pivot = a < b ? (b < c ? b : a < c ? c : a) : (a < c ? a : b < c ? c : b);
        std::uint32_t i = first, j = last - 1;
        for (;; ++i, --j) { // Hoare's partition: the pivot stops both scans
            while (keys[i] < pivot) ++i;
            while (pivot < keys[j]) --j;
            if (i >= j) break;
            Key const swapped = keys[i];
            keys[i] = keys[j];
            keys[j] = swapped;
        }
        std::uint32_t const middle = i == j ? i + 1 : i; // [first, middle) <= pivot <= [middle, last)
        --splits;
        bool const left_is_longer = middle - first > last - middle;
        waiting[ranges++] = left_is_longer ? Range{first, middle, splits} : Range{middle, last, splits};
        (left_is_longer ? first : last) = middle;
    }
}

/// Insertion sort with a budget of `moves` moves a key. It is linear for keys that are nearly in order, as the keys of the last frame are.
/// If the budget is spent, it returns false and leaves the keys in some order.
template <class Key>
bool insertion_sort(Key* keys, std::uint32_t n, std::uint32_t moves) noexcept
{
    std::uint32_t budget = n * moves;
    for (std::uint32_t i = 1; i < n; ++i) {
        if (!(keys[i] < keys[i - 1])) continue;
        Key const key = keys[i];
        std::uint32_t hole = i;
        std::uint32_t const lowest = i > budget ? i - budget : 0;
        do {
            keys[hole] = keys[hole - 1];
            --hole;
        } while (hole > lowest && key < keys[hole - 1]);
        keys[hole] = key;
        budget -= i - hole;
        if (budget == 0) return false;
    }
    return true;
}
/// Merges the sorted keys [0, n) and [n, n + m), from the back. `spare`: room for m keys, outside both ranges.
template <class Key>
void merge(Key* keys, std::uint32_t n, std::uint32_t m, Key* spare) noexcept
{
    for (std::uint32_t i = 0; i < m; ++i) spare[i] = keys[n + i];
    while (m != 0) {
        if (n != 0 && spare[m - 1] < keys[n - 1]) {
            keys[n + m - 1] = keys[n - 1];
            --n;
        } else {
            keys[n + m - 1] = spare[m - 1];
            --m;
        }
    }
}
/// A key of the last order is rarely farther from its new place. A camera turn of 0.1 degrees moves a key by a fraction of a place, a turn
/// of 2 degrees by a few places. Beyond 8 moves a key, another sort is cheaper.
inline constexpr std::uint32_t moves_a_key = 8;
/// A tail of at most this length is inserted. Sorting and merging it would go through all keys once more.
inline constexpr std::uint32_t short_tail = 4;

/// Fewer keys are sorted by comparisons: to clear and to add up the digits' counts costs as much as to sort some hundred keys.
inline constexpr std::uint32_t fewest_by_digits = 96;
/// Insertion sort waits for a wrongly predicted branch at every key that is less than the one before it. If more than this share of the keys
/// is, sorting by digits costs less.
inline constexpr std::uint32_t keys_a_descent = 5;

/// Sorts n keys by two digits of their depths, the lower digit first (LSD radix sort), and then by insertion. `spare`: room for n keys,
/// outside the keys. The digits are the 16 bits below the highest one in which the depths differ, so keys with equal digits are few. If
/// they are many, introsort sorts them. At most O(n log n).
template <class Key>
void sort_by_digits(Key* keys, std::uint32_t n, Key* spare) noexcept
{
    constexpr std::uint32_t bits = 8, digits = 1u << bits;
    std::uint32_t lowest = 0xffffffffu, highest = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        std::uint32_t const depth = keys[i].depth_key;
        lowest = depth < lowest ? depth : lowest;
        highest = depth > highest ? depth : highest;
    }
    std::uint32_t shift = 0;
    while (n != 0 && (highest - lowest) >> shift >> bits >> bits != 0) ++shift;
    auto const digit = [=](Key const& key, std::uint32_t d) noexcept { return (key.depth_key - lowest) >> (shift + d * bits) & (digits - 1); };
    std::uint32_t places[2][digits] = {}, next[2] = {};
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t d = 0; d < 2; ++d) ++places[d][digit(keys[i], d)];
    for (std::uint32_t v = 0; v < digits; ++v)
        for (std::uint32_t d = 0; d < 2; ++d) {
            std::uint32_t const count = places[d][v];
            places[d][v] = next[d];
            next[d] += count;
        }
    for (std::uint32_t i = 0; i < n; ++i) spare[places[0][digit(keys[i], 0)]++] = keys[i];
    for (std::uint32_t i = 0; i < n; ++i) keys[places[1][digit(spare[i], 1)]++] = spare[i];
    if (!insertion_sort(keys, n, moves_a_key)) intro_sort(keys, n);
}
/// Sorts n keys in any order, in a buffer of `room` keys. At most O(n log n).
template <class Key>
void sort_all(Key* keys, std::uint32_t n, std::uint32_t room) noexcept
{
    if (n >= fewest_by_digits && n <= room - n)
        sort_by_digits(keys, n, keys + n);
    else
        intro_sort(keys, n);
}

/// Sorts n keys of which the first `listed` are nearly in order, in a buffer of `room` keys. At most O(n log n) for any keys.
template <class Key>
void repair(Key* keys, std::uint32_t listed, std::uint32_t n, std::uint32_t room) noexcept
{
    std::uint32_t const tail = n - listed;
    bool const insert = tail <= short_tail;
    if (n >= fewest_by_digits && n <= room - n) {
        std::uint32_t descents = tail;
        for (std::uint32_t i = 1; i < listed; ++i) descents += keys[i].depth_key < keys[i - 1].depth_key ? 1 : 0;
        if (descents * keys_a_descent > n) {
            sort_by_digits(keys, n, keys + n);
            return;
        }
    }
    bool const fits = insert || (tail <= room - n && tail < listed);
    if (!fits || !insertion_sort(keys, insert ? n : listed, moves_a_key + (insert ? tail : 0))) {
        sort_all(keys, n, room);
        return;
    }
    if (insert) return;
    intro_sort(keys + listed, tail);
    merge(keys, listed, tail, keys + n);
}
} // namespace detail

namespace kernel {
template <class S>
struct DepthSort {
    static constexpr char const* name = "depth sort";
    using Access = AccessOf<S>;

    void operator()(Here here, Broadcast<typename S::Parameters> parameters, Marks<S>& marks, Splats<S> const& splats, Order<S>& order,
                    Counts& counts) const noexcept
    {
        auto const& frame = Access::hold(*parameters);
        std::uint32_t const n = splats.size();
        if (counts.changes == 0) {
            if (frame.view_changed == 0) return;
            Access::about_to_read(order);
            Access::about_to_read(splats);
            for (SortKey& key : order) key.depth_key = Access::depth_key(frame, splats[key.slot]);
            detail::repair(order.begin(), order.size(), order.size(), order.capacity());
            return;
        }
        counts.changes = 0;
        Access::list_changed(here, frame);
        Access::about_to_read(order);
        Access::about_to_read(marks);
        Access::about_to_read(splats);
        // A record is here if it is a copy, because Project drops the copies that touch no pixel of the tile; or if it is anchored here and
        // visible. A visible record has a depth that is not 0. Only a record that still waits to leave must be asked.
        auto const depth_here = [&](std::uint32_t slot, std::uint32_t bits) noexcept {
            std::uint32_t const depth = Access::depth_key(frame, splats[slot]);
            if ((bits & (Mark::leaving | Mark::copy)) == Mark::leaving) return Access::is_here(here, frame, splats[slot]) ? depth : 0u;
            return depth;
        };
        constexpr std::uint32_t ahead = 16; // keys: the host's memory answers that late
        std::uint32_t kept = 0, copies = 0;
        [[maybe_unused]] bool const parts = routes_in<S>(frame) || blooms_in<S>(frame);
        if constexpr (S::routes || S::blooms) {
            if (parts)
                for (std::uint32_t k = 0, keys = order.size(); k < keys; ++k) {
                    SortKey const key = order[k];
                    std::uint32_t const slot = key.slot;
                    if (k + ahead < keys)
                        if (std::uint32_t const later = order[k + ahead].slot; later < n) Access::about_to_order(frame, splats[later]);
                    if (slot >= n) continue;
                    std::uint32_t const bits = marks[slot].bits, depth = depth_here(slot, bits);
                    std::uint32_t const stays = marks[slot].id == key.id && depth != 0 ? 1u : 0u;
                    copies += stays & ((bits & Mark::copy) != 0 ? 1u : 0u);
                    marks[slot].bits = bits | (stays != 0 ? Mark::listed : 0u);
                    order[kept] = {depth, key.id, slot}; // the next key overwrites one that does not stay
                    kept += stays;
                }
        }
        order.truncate(kept);
        auto const add = [&](std::uint32_t slot, std::uint32_t bits) noexcept {
            if (std::uint32_t const depth = depth_here(slot, bits); depth != 0) order.unchecked_push({depth, marks[slot].id, slot});
        };
        if constexpr (S::routes || S::blooms) {
            if (parts) {
                for (std::uint32_t begin = 0; begin < n;) {
                    std::uint32_t const end = n - begin < 16 ? n : begin + 16;
                    std::uint32_t listed = Mark::listed;
                    for (std::uint32_t i = begin; i < end; ++i) listed &= marks[i].bits;
                    if (listed == 0)
                        for (std::uint32_t i = begin; i < end; ++i) {
                            std::uint32_t const bits = marks[i].bits;
                            if ((bits & Mark::listed) != 0) continue;
                            copies += (bits & Mark::copy) != 0 ? 1 : 0;
                            add(i, bits);
                        }
                    for (; begin < end; ++begin) marks[begin].bits &= ~Mark::listed;
                }
            }
        }
        if (!parts)
            for (std::uint32_t i = 0; i < n; ++i) add(i, marks[i].bits);
        counts.copies = copies;
        detail::repair(order.begin(), kept, order.size(), order.capacity());
    }

    /// For a cost model. In a new view, the kernel looks at every record and sorts the keys with n ceil(log2 n) comparisons. The model
    /// ignores that repairing a nearly sorted order costs less.
    static Operations operations(Broadcast<typename S::Parameters> parameters, Splats<S> const& splats, Order<S> const& order) noexcept
    {
        Operations o;
        if (parameters->view_changed == 0) return o;
        std::uint32_t levels = 0;
        while (levels < 31 && (1u << levels) < order.size()) ++levels;
        o[Operation::slot] = splats.size();
        o[Operation::comparison] = times(order.size(), levels);
        return o;
    }
};
} // namespace kernel

/// Lists the splats that touch the tile, front to back: by depth, and by id for depths of one key. The order depends only on view and scene. It
/// is the same on every tile and for every order of arrival. No exchange.
///
/// It repairs the order of the last frame. Keys get their new depths. Keys whose slot is gone or no longer touches the tile leave. New
/// slots are added at the end. Then it sorts the keys, which are nearly in order. If the view and the slots are those of the last frame, it
/// does nothing.
template <class S>
using DepthSort = kernel::DepthSort<PoliciesOf<S>>;

}}} // namespace tilemesh::splat
