#pragma once
#include <tilemesh/machine/buffer.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/types.hpp>

namespace tilemesh { inline namespace v0_2 {

namespace detail {
template <class T, class = void>
inline constexpr std::uint32_t wire_bytes_of = sizeof(T);
template <class T>
inline constexpr std::uint32_t wire_bytes_of<T, std::void_t<decltype(T::wire_bytes)>> = T::wire_bytes;
/// The head of an end that a channel does not have: no message, no note. Nobody writes it.
inline constexpr std::uint32_t no_messages[2] = {0, 0};
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
/// `Where` are the sides to which a tile can send. The channel has no end on the others, and pays nothing for them:
/// `struct Row : Channel<Block, 1, Edge::wrap, Sides::west> {};` has two ends in place of eight. A tile receives from the opposite sides.
/// If edges reflect, it also receives from the sides to which it sends, because messages may come back there.
///
/// Cost: N * wire_bytes<T> + 8 bytes of SRAM for each of the eight ends, of which four receive. The compile-time exchange moves the whole
/// capacity.
template <class T, std::uint32_t N = dynamic_capacity, Edge Ends = Edge::reflect, Sides Where = Sides::all>
struct Channel {
    static_assert(Where != Sides::none && static_cast<std::uint32_t>(Where) <= 15u,
                  "a channel to no side (Where is a set of Sides, and a tile sends to each of them); name at least one");
    static_assert(wire_bytes<T> % 4 == 0 || wire_bytes<T> == sizeof(T),
                  "wire_bytes is what the machine moves for a message (whole 32-bit words); make it a multiple of 4");
    using value_type = T;
    static constexpr std::uint32_t static_capacity = N;
    static constexpr bool is_channel = true;
    static constexpr Edge edge = Ends;
    static constexpr Sides sends_to = Where;
    static constexpr Sides receives_from = opposite(Where) | (Ends == Edge::reflect ? Where : Sides::none);
    /// Bytes of one end with n slots, including its head, on the modelled machine.
    TILEMESH_KERNEL static constexpr std::uint32_t end_bytes(std::uint32_t n) noexcept { return 8 + n * wire_bytes<T>; }

    /// The reading end: the messages that one neighbour sent in the previous superstep.
    class Receiver : public detail::List<T, N> {
    public:
        using detail::List<T, N>::List;
        TILEMESH_KERNEL std::uint32_t note() const noexcept { return this->head_[1]; }
        /// The end of a side that the channel does not have: no message, no note.
        TILEMESH_KERNEL static Receiver none() noexcept
        {
            return Receiver{machine::Place{const_cast<std::uint32_t*>(detail::no_messages), nullptr, 0}};
        }
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
        /// An end that has no room.
        TILEMESH_KERNEL Sender closed() const noexcept
        {
            return Sender{machine::Place{this->head_, reinterpret_cast<std::uint32_t*>(this->items_), 0}};
        }
    };
};

/// Is X a channel?
template <class X, class = void>
inline constexpr bool is_channel = false;
template <class X>
inline constexpr bool is_channel<X, std::void_t<decltype(X::is_channel)>> = true;

/// The tile and the side at which a channel is read that tile t writes towards d. Nobody reads it if `delivered` is false.
struct ChannelReader {
    bool delivered;
    TileId tile;
    Direction side;
};
constexpr ChannelReader reader_of(Edge edge, Grid grid, TileId t, Direction d) noexcept
{
    return {grid.delivers(t, d, edge), grid.neighbour(t, d, edge), grid.arrival(t, d, edge)};
}

namespace detail {
/// The sides of channel C: to which it sends, from which it receives. All for what is no channel, of which In and Out say so.
template <class C, class = void>
struct SidesOf {
    static constexpr Sides out = Sides::all, in = Sides::all;
};
template <class C>
struct SidesOf<C, std::void_t<decltype(C::sends_to)>> {
    static constexpr Sides out = C::sends_to, in = C::receives_from;
};
} // namespace detail

/// The number of incoming and of outgoing ends of channel C on a tile.
template <class C>
inline constexpr std::uint32_t ends_in = count(detail::SidesOf<C>::in);
template <class C>
inline constexpr std::uint32_t ends_out = count(detail::SidesOf<C>::out);

/// The incoming ends of channel C, indexed by the side from which the messages come. No message comes from a side without an end: `in[d]` is
/// empty there, and `in.from<d>()` does not compile.
template <class C>
struct In {
    static_assert(is_channel<C>, "In<C>: C is not a channel; write struct C : Channel<Message, slots> {}");
    static_assert(std::is_empty_v<C>, "a named channel with members of its own (a tile keeps its messages alone); keep them in a struct "
                                      "that kernels take as state");
    static constexpr Sides sides = detail::SidesOf<C>::in;
    typename C::Receiver side[ends_in<C>];
    TILEMESH_KERNEL decltype(auto) operator[](Direction d) const noexcept
    {
        if constexpr (sides == Sides::all)
            return (side[index(d)]); // a reference
        else
            return contains(sides, d) ? side[before(sides, d)] : C::Receiver::none();
    }
    template <Direction D>
    TILEMESH_KERNEL typename C::Receiver const& from() const noexcept
    {
        static_assert(contains(sides, D), "a channel that receives nothing from this side (its Sides are those to which tiles send); read "
                                          "another side, or give the channel more sides");
        return side[before(sides, D)];
    }
};

/// The outgoing ends of channel C, indexed by the side to which the messages go. At an edge of the grid, the channel's Edge says where
/// they go. To send to a side that the channel does not have: `out.to<d>()` does not compile, and `out[d]` is a broken contract and has no
/// room.
template <class C>
struct Out {
    static_assert(is_channel<C>, "Out<C>: C is not a channel; write struct C : Channel<Message, slots> {}");
    static_assert(std::is_empty_v<C>, "a named channel with members of its own (a tile keeps its messages alone); keep them in a struct "
                                      "that kernels take as state");
    static constexpr Sides sides = detail::SidesOf<C>::out;
    typename C::Sender side[ends_out<C>];
    TILEMESH_KERNEL decltype(auto) operator[](Direction d) noexcept
    {
        if constexpr (sides == Sides::all)
            return (side[index(d)]); // a reference
        else
            return TILEMESH_EXPECT(contains(sides, d), "a message to a side that the channel does not have (its Sides are part of the "
                                                       "program); send to another side, or give the channel more sides")
                       ? side[before(sides, d)]
                       : side[0].closed();
    }
    template <Direction D>
    TILEMESH_KERNEL typename C::Sender& to() noexcept
    {
        static_assert(contains(sides, D), "a message to a side that the channel does not have (its Sides are part of the program); send to "
                                          "another side, or give the channel more sides");
        return side[before(sides, D)];
    }
    /// Pushes the message to each side that the channel has.
    TILEMESH_KERNEL void to_all(typename C::value_type const& message) noexcept
    {
        for (auto& s : side) s.push(message);
    }
};

}} // namespace tilemesh
