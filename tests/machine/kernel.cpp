// test: unoptimised test asan tsan
#include <cstdint>
#include <doctest/doctest.h>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/run_kernel.hpp>
#include <tilemesh/machine/tile.hpp>
#include <type_traits>

using namespace tilemesh;

namespace {

struct Level {
    std::uint32_t word;
};
struct Pressure {
    float bar[2];
};
struct Pile : Buffer<std::uint32_t, 8> {};
struct Rate {
    float per_step;
};
struct Limit {
    std::uint32_t most;
};
struct Red : Channel<std::uint32_t, 2> {};
struct Blue : Channel<std::uint32_t, 2> {};

struct Everything {
    Vote operator()(Level&, Pressure const&, Pile&, Broadcast<Rate>, In<Red>, Out<Blue>, Here) const noexcept { return Vote::quiet; }
};
struct AllWorkers {
    void operator()(Pile const&, In<Blue>, Worker) const noexcept {}
};
struct Nothing {
    void operator()() const noexcept {}
};

// KernelTraits: the facts in the parameter list of a kernel.
using T = KernelTraits<Everything>;
static_assert(std::is_same_v<T::Arguments, machine::Types<Level&, Pressure const&, Pile&, Broadcast<Rate>, In<Red>, Out<Blue>, Here>>);
static_assert(std::is_same_v<T::Result, Vote> && std::is_same_v<KernelTraits<Nothing>::Result, void>);
static_assert(takes<Everything, Level&> && takes<Everything, Pressure const&> && takes<Everything, Here>);
static_assert(!takes<Everything, Level const&> && !takes<Everything, Pressure&>, "const is part of the declaration");
static_assert(!takes<Everything, Worker> && takes<AllWorkers, Worker>);
static_assert(takes<Everything, In<Red>> && !takes<Everything, Out<Red>> && !takes<Everything, In<Blue>>);
static_assert(T::reads<Red> && !T::reads<Blue> && T::writes<Blue> && !T::writes<Red>);
static_assert(T::sends && !KernelTraits<AllWorkers>::sends && !KernelTraits<Nothing>::sends);
static_assert(!T::multi_worker && KernelTraits<AllWorkers>::multi_worker && !KernelTraits<Nothing>::multi_worker);
static_assert(std::is_same_v<T::Links, machine::Types<Red, Blue>>, "in the order of the parameters");
static_assert(std::is_same_v<KernelTraits<AllWorkers>::Links, machine::Types<Blue>>);
static_assert(std::is_same_v<KernelTraits<Nothing>::Links, machine::Types<>>);
static_assert(std::is_same_v<T::Needs::States, machine::Types<Level, Pressure, Pile>>, "const or not, one region");
static_assert(std::is_same_v<T::Needs::Shareds, machine::Types<Rate>>);

struct BothEnds {
    void operator()(Out<Blue>, In<Blue>, Level&, Level const&) const noexcept {}
};
static_assert(std::is_same_v<KernelTraits<BothEnds>::Links, machine::Types<Blue>>, "a channel counts once");
static_assert(std::is_same_v<KernelTraits<BothEnds>::Needs::States, machine::Types<Level>>, "a state counts once");

// Needs of a program: the union over its kernels, each type once, in the order in which the kernels name them.
struct First {
    void operator()(Pressure&, Out<Red>, Broadcast<Limit>) const noexcept {}
};
using Nested = Sequence<Superstep<First>, Sequence<Repeat<Everything>, Sequence<>, UntilQuiet<AllWorkers>>, Superstep<First>>;
static_assert(std::is_same_v<machine::Needs<Nested>::States, machine::Types<Pressure, Level, Pile>>);
static_assert(std::is_same_v<machine::Needs<Nested>::Links, machine::Types<Red, Blue>>);
static_assert(std::is_same_v<machine::Needs<Nested>::Shareds, machine::Types<Limit, Rate>>);
static_assert(
    std::is_same_v<machine::Needs<Sequence<If<&Limit::most, Superstep<Nothing>>, Loop<Superstep<Everything>>>>::Shareds, machine::Types<Rate, Limit>>,
    "a condition's broadcast counts, after those of kernels");
static_assert(std::is_same_v<machine::Needs<Sequence<If<&Limit::most, Superstep<First>>>>::Shareds, machine::Types<Limit>>, "and once");

// Steps have numbers in program order, at any depth of nesting. Loops too have numbers in program order.
using Twisted = Sequence<Superstep<First>, Loop<If<&Limit::most, UntilQuiet<Everything>>, Loop<Superstep<Nothing>>>, Superstep<First>,
                         Loop<Repeat<Nothing>, UntilQuiet<Nothing>>>;
static_assert(std::is_same_v<StepsOf<Twisted>, machine::Types<Superstep<First>, UntilQuiet<Everything>, Superstep<Nothing>, Superstep<First>,
                                                              Repeat<Nothing>, UntilQuiet<Nothing>>>);
static_assert(step_of<Twisted, Everything>() == 1 && step_of<Twisted, Nothing>() == 2 && step_of<Twisted, Nothing, 2>() == 5);
static_assert(step_of<Twisted, First, 1>() == 3 && step_of<Twisted, First, 2>() == no_step && step_of<Twisted, AllWorkers>() == no_step);
constexpr bool is_at(LoopAt const& loop, std::uint32_t index, std::uint32_t first, std::uint32_t last)
{
    return loop.index == index && loop.first == first && loop.last == last;
}
static_assert(StepTraits<Twisted>::loops == 3 && is_at(loops_of<Twisted>().found[0], 0, 1, 2) && is_at(loops_of<Twisted>().found[1], 1, 2, 2) &&
              is_at(loops_of<Twisted>().found[2], 2, 4, 5));
static_assert(!votes_after<Twisted>(0) && votes_after<Twisted>(1) && votes_after<Twisted>(2) && !votes_after<Twisted>(3) &&
              !votes_after<Twisted>(4) && votes_after<Twisted>(5));
static_assert([] {
    Twisted program;
    get_step<Everything>(program).at_most = 7;
    get_step<Nothing, 1>(program).times = 9;
    auto const& loop = std::get<1>(program.steps);
    return std::get<0>(std::get<0>(loop.steps).steps).at_most == 7 && std::get<0>(std::get<3>(program.steps).steps).times == 9;
}());
static_assert([] { // the innermost loop; a condition is none
    Twisted program;
    get_loop<Everything>(program).at_most = 7;
    get_loop<Nothing>(program).at_most = 8;
    get_loop<Nothing, 2>(program).at_most = 9;
    auto const& loop = std::get<1>(program.steps);
    Loop<Superstep<Nothing>> alone;
    get_loop<Nothing>(alone).at_most = 5;
    return loop.at_most == 7 && std::get<1>(loop.steps).at_most == 8 && std::get<3>(program.steps).at_most == 9 && alone.at_most == 5;
}());
static_assert(std::is_same_v<machine::Needs<Superstep<Nothing>>, RegionTypes<machine::Types<>, machine::Types<>, machine::Types<>>>);
static_assert(std::is_same_v<machine::Needs<Sequence<>>, RegionTypes<machine::Types<>, machine::Types<>, machine::Types<>>>);
static_assert(std::is_same_v<machine::Needs<Repeat<Everything>>, machine::Needs<UntilQuiet<Everything>>>);

// Sending over unread mail. A program may run many times, so mail that its last step leaves is there for its first step.
struct Send {
    void operator()(Out<Red>) const noexcept {}
};
struct Read {
    void operator()(In<Red>) const noexcept {}
};
struct Relay {
    void operator()(In<Red>, Out<Red>) const noexcept {}
};
template <class... Steps>
constexpr bool clashes = detail::sends_over_unread_mail<Sequence<Steps...>, Red>();

static_assert(clashes<Superstep<Send>>, "the second run sends over the first one's mail");
static_assert(!clashes<Superstep<Read>> && !clashes<Superstep<Relay>> && !clashes<Superstep<Nothing>>);
static_assert(!clashes<Superstep<Send>, Superstep<Read>>);
static_assert(!clashes<Superstep<Read>, Superstep<Send>>, "cyclic: the read comes before the next send");
static_assert(clashes<Superstep<Send>, Superstep<Send>, Superstep<Read>>);
static_assert(clashes<Superstep<Read>, Superstep<Send>, Superstep<Send>>);
static_assert(!clashes<Superstep<Send>, Superstep<Nothing>, Superstep<Nothing>, Superstep<Read>>, "mail outlives other steps");
static_assert(clashes<Superstep<Send>, Superstep<Nothing>, Superstep<Send>, Superstep<Read>>);
static_assert(!clashes<Superstep<Send>, Superstep<Read>, Superstep<Send>, Superstep<Read>>);
static_assert(clashes<Superstep<Send>, Superstep<Relay>>, "a relay reads and sends: what it sent is unread");
static_assert(!clashes<Superstep<Send>, Superstep<Relay>, Superstep<Read>>);
static_assert(clashes<Superstep<Relay>, Superstep<Send>, Superstep<Read>>);
static_assert(!clashes<Superstep<Send>, UntilQuiet<Relay>>, "until quiet ends with everything read");
static_assert(!clashes<Superstep<Send>, UntilQuiet<Read>>);
static_assert(clashes<UntilQuiet<Send>, Superstep<Read>>, "it may send twice");
static_assert(clashes<Repeat<Send>, Superstep<Read>>, "how often is a value: it may be twice");
static_assert(!clashes<Superstep<Send>, Repeat<Read>>, "no times would leave it unread, and the engine would say so");
static_assert(!clashes<Repeat<Relay>>);
static_assert(clashes<Repeat<Relay>, Superstep<Send>, Superstep<Read>>);
static_assert(!clashes<Loop<Superstep<Send>, Superstep<Read>>> && !clashes<Superstep<Send>, Loop<Superstep<Relay>>, Superstep<Read>>);
static_assert(clashes<Loop<Superstep<Send>>, Superstep<Read>>, "the second round sends over the first one's mail");
static_assert(clashes<Superstep<Send>, Loop<Superstep<Read>>>, "no round leaves it unread");
static_assert(!clashes<If<&Limit::most, Superstep<Send>, Superstep<Read>>> && !clashes<If<&Limit::most, Superstep<Send>>, Superstep<Read>>);
static_assert(clashes<Superstep<Send>, If<&Limit::most, Superstep<Read>>>, "a run without it leaves it unread");
static_assert(clashes<Sequence<Superstep<Send>>, Sequence<Sequence<Superstep<Send>>>, Superstep<Read>>, "nesting hides nothing");
static_assert(!clashes<Sequence<Superstep<Send>, Sequence<Superstep<Read>>>>);
static_assert(!detail::sends_over_unread_mail<Superstep<Send>, Blue>(), "another channel's mail is no matter");

/// An interpreter of one tile for a unit test: its memory is arrays on the stack.
struct Alone {
    std::uint32_t level[1] = {41};
    float bar[2] = {1, 2};
    std::uint32_t pile_head[2] = {}, pile[8] = {};
    Rate rate{0.5f};
    std::uint32_t heads[2][4][2] = {}, items[2][4][2] = {};
    template <class X>
    machine::Place state() noexcept
    {
        if constexpr (std::is_same_v<X, Level>) return {nullptr, level, 1};
        else if constexpr (std::is_same_v<X, Pressure>) return {nullptr, reinterpret_cast<std::uint32_t*>(bar), 1};
        else return {pile_head, pile, 8};
    }
    template <class C>
    machine::Place in(Direction d) noexcept
    {
        return {heads[0][index(d)], items[0][index(d)], 2};
    }
    template <class C>
    machine::Place out(Direction d) noexcept
    {
        return {heads[1][index(d)], items[1][index(d)], 2};
    }
    template <class P>
    P const* shared() noexcept
    {
        return &rate;
    }
    Here here() noexcept { return {TileId::at(2, 1), {4, 3}}; }
    Worker worker() noexcept { return {0, 1}; }
};
struct Touch {
    Vote operator()(Level& level, Pressure const& pressure, Pile& pile, Broadcast<Rate> rate, In<Red> in, Out<Blue> out, Here here) const noexcept
    {
        ++level.word;
        pile.push(here.tile.x() * 100 + here.tile.y() * 10 + here.grid.height);
        for (Direction d : news)
            for (auto m : in[d]) out[opposite(d)].push(m + static_cast<std::uint32_t>(2 * (*rate).per_step));
        return pressure.bar[1] == 2.0f ? Vote::busy : Vote::quiet;
    }
};
struct CountMe {
    void operator()(Pile& pile, Worker w) const noexcept { pile.push(w.index * 10 + w.count); }
};

} // namespace

TEST_CASE("run_kernel gives each parameter its own words and returns the vote")
{
    Alone tile;
    tile.heads[0][index(Direction::west)][0] = 1;
    tile.items[0][index(Direction::west)][0] = 6;
    CHECK(run_kernel<Touch>(tile) == Vote::busy);
    CHECK(tile.level[0] == 42);
    CHECK(tile.pile_head[0] == 1);
    CHECK(tile.pile[0] == 213);
    CHECK(tile.heads[1][index(Direction::east)][0] == 1);
    CHECK(tile.items[1][index(Direction::east)][0] == 7);
    for (Direction d : {Direction::north, Direction::west, Direction::south}) CHECK(tile.heads[1][index(d)][0] == 0);
    CHECK(tile.heads[0][index(Direction::west)][0] == 1); // run_kernel does not mark mail as read: the interpreter does
    tile.bar[1] = 3;
    CHECK(run_kernel<Touch>(tile) == Vote::quiet);
    CHECK(tile.level[0] == 43);
}

TEST_CASE("a kernel that returns nothing votes quiet, and a Worker is the interpreter's")
{
    Alone tile;
    CHECK(run_kernel<CountMe>(tile) == Vote::quiet);
    CHECK(tile.pile_head[0] == 1);
    CHECK(tile.pile[0] == 1);
}
