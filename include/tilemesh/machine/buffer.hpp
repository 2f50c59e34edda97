#pragma once
#include <cstdint>
#include <cstring>
#include <tilemesh/config.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 {

/// The capacity of a list whose number of slots is a value, given when the mesh is built (see `capacity_of` in machine/tile.hpp). Lists
/// with any number of slots share one type, and so the code of their kernels.
inline constexpr std::uint32_t dynamic_capacity = 0xffffffffu;

namespace machine {
/// Words of a tile's SRAM that hold a list: two words of head, then the items. The head need not be next to the items: a host engine keeps
/// all heads together, a Poplar tensor holds both in one piece.
struct Place {
    std::uint32_t* head;     ///< {size, note}
    std::uint32_t* items;    ///< capacity * sizeof(T) / 4 words
    std::uint32_t capacity;  ///< in items
};
} // namespace machine

namespace detail {
/// The common part of Buffer and of the two ends of a Channel: a view of a list in external words. Its capacity is that of its Place.
template <class T, std::uint32_t N>
class List {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 4 && sizeof(T) % 4 == 0,
                  "an item is copied by the exchange fabric: it must be trivially copyable and whole 32-bit words (of alignment 4: no "
                  "double, no 64-bit integer)");

public:
    using value_type = T;
    static constexpr std::uint32_t static_capacity = N;
    static constexpr std::uint32_t head_words = 2;
    static constexpr std::uint32_t item_words = sizeof(T) / 4;
    /// The words of a list of n items, including its head.
    TILEMESH_KERNEL static constexpr std::uint32_t words(std::uint32_t n) noexcept { return head_words + n * item_words; }

    TILEMESH_KERNEL List(machine::Place p) noexcept // not explicit: so a named list is made from a Place as an aggregate
        : head_(p.head), items_(reinterpret_cast<T*>(p.items)), capacity_(p.capacity)
    {
    }
    TILEMESH_KERNEL std::uint32_t capacity() const noexcept { return capacity_; }
    TILEMESH_KERNEL std::uint32_t size() const noexcept { return head_[0]; }
    TILEMESH_KERNEL std::uint32_t room() const noexcept { return size() < capacity() ? capacity() - size() : 0; }
    TILEMESH_KERNEL bool empty() const noexcept { return size() == 0; }
    TILEMESH_KERNEL T const* begin() const noexcept { return items_; }
    TILEMESH_KERNEL T const* end() const noexcept { return items_ + size(); }
    TILEMESH_KERNEL T const& operator[](std::uint32_t i) const noexcept { return items_[i]; }

protected:
    TILEMESH_KERNEL void append(T const& item) noexcept
    {
        append_at(head_[0], item);
    }
    TILEMESH_KERNEL bool try_append(T const& item) noexcept
    {
        auto const n = size();
        if (n >= capacity()) return false;
        append_at(n, item);
        return true;
    }
    /// Item n is the first one after the last. The size is read only once, because the compiler must assume that the copy may change it.
    TILEMESH_KERNEL void append_at(std::uint32_t n, T const& item) noexcept
    {
        std::memcpy(items_ + n, &item, sizeof(T));
        head_[0] = n + 1;
    }
    std::uint32_t* head_;
    T* items_;
    std::uint32_t capacity_;
};
} // namespace detail

/// A fixed-capacity list in a tile's SRAM: a view, the words belong to the tile. A program names its regions by types:
/// `struct Stock : Buffer<Item, 1800> {};`. A named buffer has no members of its own; kernels that take it refuse some.
///
/// Capacity: a `Buffer<T, N>` has N slots. A `Buffer<T>` has the number of slots that a value names when the mesh is built. `limit` lowers
/// either.
///
/// When full, `push` reports a broken contract and keeps the list as it is, `try_push` returns false, `unchecked_push` must
/// not be called. Cost: N * sizeof(T) + 8 bytes of SRAM. Items must be read by the type they were written as.
template <class T, std::uint32_t N = dynamic_capacity>
class Buffer : public detail::List<T, N> {
    using Base = detail::List<T, N>;

public:
    using Base::Base;
    using list_type = Buffer;
    using Base::begin;
    using Base::end;
    using Base::operator[];
    TILEMESH_KERNEL T* begin() noexcept { return this->items_; }
    TILEMESH_KERNEL T* end() noexcept { return this->items_ + this->size(); }
    TILEMESH_KERNEL T& operator[](std::uint32_t i) noexcept { return this->items_[i]; }

    TILEMESH_KERNEL void push(T const& item) noexcept
    {
        if (TILEMESH_EXPECT(this->size() < this->capacity(), "push into a full buffer (its capacity is part of the "
                                                             "program); use try_push and count what is refused"))
            this->append(item);
    }
    [[nodiscard]] TILEMESH_KERNEL bool try_push(T const& item) noexcept { return this->try_append(item); }
    TILEMESH_KERNEL void unchecked_push(T const& item) noexcept { this->append(item); }

    /// Removes item i by moving the last item into its place. The order changes.
    TILEMESH_KERNEL void swap_remove(std::uint32_t i) noexcept
    {
        auto const last = --this->head_[0];
        if (i != last) std::memcpy(this->items_ + i, this->items_ + last, sizeof(T));
    }
    /// Keeps the first n items, n <= size().
    TILEMESH_KERNEL void truncate(std::uint32_t n) noexcept { this->head_[0] = n; }
    /// Sets the size to n, n <= capacity(). New items have the old content of their words; write them before you read them.
    TILEMESH_KERNEL void resize(std::uint32_t n) noexcept
    {
        if (TILEMESH_EXPECT(n <= this->capacity(), "resize of a buffer beyond its capacity (its capacity is part of the "
                                                   "program); give the region more slots"))
            this->head_[0] = n;
    }
};

}} // namespace tilemesh
