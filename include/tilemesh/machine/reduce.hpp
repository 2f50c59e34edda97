#pragma once
#include <initializer_list>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/name.hpp>

namespace tilemesh { inline namespace v0_2 {

/// An operator of `Reduce`. It combines two values into one: an empty functor `T operator()(T mine, T others) const noexcept`. It may have a
/// `name`; otherwise the type's name is used. It need be neither associative nor commutative.
struct Sum {
    static constexpr char const* name = "sum";
    template <class T>
    TILEMESH_KERNEL constexpr T operator()(T mine, T others) const noexcept
    {
        return mine + others;
    }
};
/// The smaller of two values. If they are equal, or if one is a NaN, the result is the tile's own value.
struct Least {
    static constexpr char const* name = "least";
    template <class T>
    TILEMESH_KERNEL constexpr T operator()(T mine, T others) const noexcept
    {
        return others < mine ? others : mine;
    }
};
struct Most {
    static constexpr char const* name = "most";
    template <class T>
    TILEMESH_KERNEL constexpr T operator()(T mine, T others) const noexcept
    {
        return mine < others ? others : mine;
    }
};
/// The bitwise and of two words.
struct And {
    static constexpr char const* name = "and";
    template <class T>
    TILEMESH_KERNEL constexpr T operator()(T mine, T others) const noexcept
    {
        return mine & others;
    }
};

/// The tiles that get the result of a `Reduce`: only tile (0, 0), or all tiles for twice the exchanges.
enum class ReduceTo : std::uint32_t { one, all };

/// The value that a tile contributes to a `Reduce`: a member of a state, `Member<&Cell::kelvin>`. To contribute a computed value, write an
/// empty functor `float operator()(Cell const&, Pile const&) const noexcept`. It takes states by const reference, broadcasts
/// and `Here`.
template <auto Pointer>
struct Member;
template <class X, class T, T X::*Pointer>
struct Member<Pointer> {
    static constexpr char const* name = "member";
    TILEMESH_KERNEL constexpr T operator()(X const& state) const noexcept { return state.*Pointer; }
};

namespace detail {
template <class Value>
using ValueOf = typename CallOf<Value>::Result;

/// The name of a Reduce's kernel, "least member begin". It contains operator and value, because the kernels of a program need unique names.
template <class Operator, class Value>
struct ReduceName {
    char text[96] = {};
    constexpr ReduceName(char const* end) noexcept
    {
        std::uint32_t at = 0;
        machine::Name const parts[] = {name_of<Operator>(), {" ", 1}, name_of<Value>(), as_name(end)};
        for (auto const& part : parts)
            for (std::uint32_t i = 0; i < part.size && at < sizeof text - 1; ++i) text[at++] = part.text[i];
    }
};
} // namespace detail

/// The state that holds the result of a `Reduce`. Tile (0, 0) has the combined value of all tiles. With `ReduceTo::all` the other tiles
/// have it too; otherwise they have a partial result. Cost: the value's bytes.
template <class Value, class Operator>
struct Reduced {
    using T = detail::ValueOf<Value>;
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 4 && sizeof(T) % 4 == 0,
                  "what a Reduce adds up is whole 32-bit words (it is a message and a state, so no double and no 64-bit integer); give "
                  "its value such a type");
    static constexpr detail::ReduceName<Operator, Value> text{" so far"};
    static constexpr char const* name = text.text;
    T value;
};

namespace detail {
template <class Value, class Operator>
struct Partial : Channel<ValueOf<Value>, 1> {
    static constexpr ReduceName<Operator, Value> text{" link"};
    static constexpr char const* name = text.text;
};

/// Sends the result from tile (0, 0) back, down column 0 and along each row to the east. With `ReduceTo::one` it sends nothing.
template <ReduceTo Where, class R, class Out>
TILEMESH_KERNEL void tell_all(Here const& here, R const& reduced, Out& out, [[maybe_unused]] bool down) noexcept
{
    if constexpr (Where == ReduceTo::all) {
        if (here.tile.x() + 1 < here.grid.width) out[Direction::east].unchecked_push(reduced.value);
        if (down && here.tile.y() + 1 < here.grid.height) out[Direction::south].unchecked_push(reduced.value);
    }
}
/// The step of a tile in column 0 when it has the values of all tiles east and south of it.
template <ReduceTo Where, class R, class Out>
TILEMESH_KERNEL void climb(Here const& here, R const& reduced, Out& out) noexcept
{
    if (here.tile.y() > 0)
        out[Direction::north].unchecked_push(reduced.value);
    else
        tell_all<Where>(here, reduced, out, true);
}
TILEMESH_KERNEL bool is_last_row(Here const& here) noexcept
{
    return here.tile.y() + 1 == here.grid.height;
}

template <class Value, class Operator, ReduceTo Where, class = typename CallOf<Value>::Arguments>
struct BeginReduce;
/// The first kernel of a Reduce. Every tile takes its value; the east end of each row sends its own to the west.
template <class Value, class Operator, ReduceTo Where, class... A>
struct BeginReduce<Value, Operator, Where, machine::Types<A...>> {
    static constexpr ReduceName<Operator, Value> text{Where == ReduceTo::all ? " of all begin" : " begin"};
    static constexpr char const* name = text.text;
    void operator()(Here here, A... a, Reduced<Value, Operator>& reduced, Out<Partial<Value, Operator>> out) const noexcept
    {
        reduced.value = Value{}(a...);
        if (here.tile.x() + 1 < here.grid.width) return;
        if (here.tile.x() > 0)
            out[Direction::west].unchecked_push(reduced.value);
        else if (is_last_row(here))
            climb<Where>(here, reduced, out);
    }
};
template <class Value, class Operator, ReduceTo Where>
struct GoOnReducing {
    static constexpr ReduceName<Operator, Value> text{Where == ReduceTo::all ? " of all" : ""};
    static constexpr char const* name = text.text;
    void operator()(Here here, Reduced<Value, Operator>& reduced, In<Partial<Value, Operator>> in,
                    Out<Partial<Value, Operator>> out) const noexcept
    {
        if constexpr (Where == ReduceTo::all) {
            for (auto d : {Direction::north, Direction::west})
                if (!in[d].empty()) {
                    reduced.value = in[d][0];
                    tell_all<Where>(here, reduced, out, d == Direction::north);
                }
        }
        bool const row = !in[Direction::east].empty(), column = !in[Direction::south].empty();
        if (row) reduced.value = Operator{}(reduced.value, in[Direction::east][0]);
        if (column) reduced.value = Operator{}(reduced.value, in[Direction::south][0]);
        if (row && here.tile.x() > 0) out[Direction::west].unchecked_push(reduced.value);
        if (here.tile.x() == 0 && (column || (row && is_last_row(here)))) climb<Where>(here, reduced, out);
    }
};
} // namespace detail

/// A reduction over all tiles, as a part of a program. `Reduce<Member<&Cell::kelvin>, Most>` leaves the largest kelvin of all tiles in the
/// state `Reduced<Member<&Cell::kelvin>, Most>` of tile (0, 0), or of every tile with `ReduceTo::all`. Later kernels take that state. A
/// Reduce consists of two ordinary kernels and one channel of one message, so engines need no code for it.
///
/// The order is fixed: each row from its east end to its west end, then column 0 from south to north. `mine` is the value of the tile that
/// combines. So a sum of floats is the same on every engine and for any number of threads. Least and Most need numbers: with a NaN the
/// result depends on the order.
///
/// On a Poplar machine the two kernels are vertices like others: `detail::BeginReduce<Value, Operator, Where>` and
/// `detail::GoOnReducing<Value, Operator, Where>`. A vertex name ends with the kernel's `name_of`.
///
/// Cost on a grid of W x H tiles: W - 1 + H - 1 exchanges (twice as many with `ReduceTo::all`), in each of which the tiles at the front
/// send one value; one more pass; SRAM for the value, and 8 * (8 + its bytes) for the channel.
template <class Value, class Operator, ReduceTo Where = ReduceTo::one>
using Reduce = Sequence<Superstep<detail::BeginReduce<Value, Operator, Where>>, UntilQuiet<detail::GoOnReducing<Value, Operator, Where>>>;

namespace detail {
/// The last kernel of a reduction of known length: it reads the last messages and sends none.
template <class Value, class Operator, ReduceTo Where>
struct FinishReducing {
    static constexpr ReduceName<Operator, Value> text{Where == ReduceTo::all ? " of all end" : " end"};
    static constexpr char const* name = text.text;
    void operator()(Reduced<Value, Operator>& reduced, In<Partial<Value, Operator>> in) const noexcept
    {
        if constexpr (Where == ReduceTo::all)
            for (auto d : {Direction::north, Direction::west})
                if (!in[d].empty()) reduced.value = in[d][0];
        for (auto d : {Direction::east, Direction::south})
            if (!in[d].empty()) reduced.value = Operator{}(reduced.value, in[d][0]);
    }
};
template <class Value, class Operator, ReduceTo Where>
using ReduceOn = SequenceOn<Superstep<BeginReduce<Value, Operator, Where>>, Repeat<GoOnReducing<Value, Operator, Where>>,
                            Superstep<FinishReducing<Value, Operator, Where>>>;
} // namespace detail

/// A `Reduce` whose number of passes is that of a grid, so it asks for no vote: `reduce_on<Member<&Cell::kelvin>, Most>(grid)` is a part of a
/// program, as `Reduce<Member<&Cell::kelvin>, Most>{}`, with the same messages, states and order. Its kernels are those of `Reduce` and
/// `detail::FinishReducing<Value, Operator, Where>`. `grid` must be that of the mesh: a mesh with another grid throws `Error` when it is
/// built.
///
/// Cost: that of `Reduce` without its votes; every tile runs in each pass. On one tile, one pass more.
template <class Value, class Operator, ReduceTo Where = ReduceTo::one>
constexpr detail::ReduceOn<Value, Operator, Where> reduce_on(Grid grid) noexcept
{
    std::uint32_t const exchanges = (Where == ReduceTo::all ? 2u : 1u) * (grid.width + grid.height - 2);
    return {{Superstep<detail::BeginReduce<Value, Operator, Where>>{},
             Repeat<detail::GoOnReducing<Value, Operator, Where>>{exchanges == 0 ? 0 : exchanges - 1},
             Superstep<detail::FinishReducing<Value, Operator, Where>>{}},
            grid};
}

}} // namespace tilemesh
