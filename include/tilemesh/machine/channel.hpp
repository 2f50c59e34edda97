#pragma once
#include <tilemesh/machine/buffer.hpp>
#include <tilemesh/machine/grid.hpp>

namespace tilemesh { inline namespace v0_2 {

namespace detail {
template <class T, class = void>
inline constexpr std::uint32_t wire_bytes_of = sizeof(T);
template <class T>
inline constexpr std::uint32_t wire_bytes_of<T, std::void_t<decltype(T::wire_bytes)>> = T::wire_bytes;
} // namespace detail

/// The bytes of a message of type T on the modelled machine, in a channel and in an exchange: sizeof(T), or the member `static
/// constexpr std::uint32_t wire_bytes` of T. T needs that member if the host moves a reference and the machine moves the record itself.
/// Ledgers, and the counted bytes of channels, are in wire bytes.
template <class T>
inline constexpr std::uint32_t wire_bytes = detail::wire_bytes_of<T>;

/// A link of fixed capacity from a tile to each of its four neighbours. The neighbour can read a message after the exchange that follows
/// the write. The message stays until a kernel reads it once. To send on a channel with unread mail is an error, which engines report. A
/// program names its own channels: `struct Road : Channel<Parcel, 400> {};`
///
/// A full channel refuses a message and never overwrites one: saturation is a result to be counted, not an error. Besides its messages a
/// channel carries one `note`, a free word (credits); it is 0 if no kernel wrote it.
///
/// `using memory_of = Other;` inside the named type places the channel in the SRAM of channel Other. The two must never carry mail at
/// the same time; the sequential engine checks this. The ledger counts the larger of the two. With
/// `static constexpr auto memory_shared = &Sizes::member;` beside it, a flag of the sizes decides whether the channels share memory.
///
/// `Ends` says where messages go that are sent over an edge of the grid: `struct Ring : Channel<float, 1, Edge::wrap> {};`
///
/// Cost: 2 * (N * wire_bytes<T> + 8) bytes of SRAM per direction. The compile-time exchange moves the whole capacity.
template <class T, std::uint32_t N = dynamic_capacity, Edge Ends = Edge::reflect>
struct Channel {
    static_assert(wire_bytes<T> % 4 == 0 || wire_bytes<T> == sizeof(T),
                  "wire_bytes is what the machine moves for a message (whole 32-bit words); make it a multiple of 4");
    using value_type = T;
    static constexpr std::uint32_t static_capacity = N;
    static constexpr bool is_channel = true;
    static constexpr Edge edge = Ends;
    /// Bytes of one end with n slots, including its head, on the modelled machine.
    TILEMESH_KERNEL static constexpr std::uint32_t end_bytes(std::uint32_t n) noexcept { return 8 + n * wire_bytes<T>; }

    /// The reading end: the messages that one neighbour sent in the previous superstep.
    class Receiver : public detail::List<T, N> {
    public:
        using detail::List<T, N>::List;
        TILEMESH_KERNEL std::uint32_t note() const noexcept { return this->head_[1]; }
    };

    /// The writing end: empty when compute begins.
    class Sender : public detail::List<T, N> {
    public:
        using detail::List<T, N>::List;
        TILEMESH_KERNEL void push(T const& message) noexcept
        {
            if (TILEMESH_EXPECT(this->size() < this->capacity(), "push into a full channel (its capacity is part of the "
                                                                 "program); use try_push and count what is refused"))
                this->append(message);
        }
        [[nodiscard]] TILEMESH_KERNEL bool try_push(T const& message) noexcept { return this->try_append(message); }
        TILEMESH_KERNEL void unchecked_push(T const& message) noexcept { this->append(message); }
        /// The messages, for kernels that write many at once: write [begin(), begin() + n), then resize(n), n <= capacity().
        TILEMESH_KERNEL T* begin() noexcept { return this->items_; }
        TILEMESH_KERNEL void resize(std::uint32_t n) noexcept
        {
            if (TILEMESH_EXPECT(n <= this->capacity(), "resize of a channel beyond its capacity (its capacity is part of the program); "
                                                       "send at most capacity() messages"))
                this->head_[0] = n;
        }
        TILEMESH_KERNEL void set_note(std::uint32_t word) noexcept { this->head_[1] = word; }
    };
};

/// Is X a channel?
template <class X, class = void>
inline constexpr bool is_channel = false;
template <class X>
inline constexpr bool is_channel<X, std::void_t<decltype(X::is_channel)>> = true;

/// The four incoming ends of channel C, indexed by the side from which the messages come.
template <class C>
struct In {
    static_assert(is_channel<C>, "In<C>: C is not a channel; write struct C : Channel<Message, slots> {}");
    static_assert(std::is_empty_v<C>, "a named channel with members of its own (a tile keeps its messages alone); keep them in a struct "
                                      "that kernels take as state");
    typename C::Receiver side[4];
    TILEMESH_KERNEL typename C::Receiver const& operator[](Direction d) const noexcept { return side[index(d)]; }
};

/// The four outgoing ends of channel C, indexed by the side to which the messages go. At an edge of the grid, the channel's Edge says where
/// they go.
template <class C>
struct Out {
    static_assert(is_channel<C>, "Out<C>: C is not a channel; write struct C : Channel<Message, slots> {}");
    static_assert(std::is_empty_v<C>, "a named channel with members of its own (a tile keeps its messages alone); keep them in a struct "
                                      "that kernels take as state");
    typename C::Sender side[4];
    TILEMESH_KERNEL typename C::Sender& operator[](Direction d) noexcept { return side[index(d)]; }
    /// Pushes the message to each of the four sides.
    TILEMESH_KERNEL void to_all(typename C::value_type const& message) noexcept
    {
        for (auto& s : side) s.push(message);
    }
};

}} // namespace tilemesh
