// test: unoptimised test asan tsan
#include "handler.hpp"
#include <array>
#include <cstdint>
#include <doctest/doctest.h>
#include <tilemesh/machine/channel.hpp>
#include <type_traits>
#include <vector>

using namespace tilemesh;
using machine_test::broken_contracts;
using machine_test::last_broken_contract;

namespace {

struct Letter {
    std::uint32_t to, from;
    float text;
};
struct Post : Channel<Letter, 3> {};
struct Wire : Channel<std::uint32_t, 4> {};
struct Pipe : Channel<std::uint32_t> {};

static_assert(Post::static_capacity == 3 && Pipe::static_capacity == dynamic_capacity);
static_assert(Post::Receiver::words(3) == 2 + 9 && Wire::Sender::words(4) == 6);
static_assert(sizeof(Post::Sender) == 3 * sizeof(void*) && sizeof(Post::Receiver) == 3 * sizeof(void*));
static_assert(sizeof(Wire::Sender) == 3 * sizeof(void*) && sizeof(Pipe::Receiver) == 3 * sizeof(void*));
static_assert(sizeof(In<Post>) == 4 * sizeof(Post::Receiver) && sizeof(Out<Post>) == 4 * sizeof(Post::Sender));
static_assert(std::is_same_v<Post::value_type, Letter>);

/// Can a kernel write to this end? It cannot write to a reading end.
template <class End, class = void>
constexpr bool can_push = false;
template <class End>
constexpr bool can_push<End, std::void_t<decltype(std::declval<End&>().unchecked_push({}))>> = true;
template <class End, class = void>
constexpr bool can_assign = false;
template <class End>
constexpr bool can_assign<End, std::void_t<decltype(std::declval<End&>()[0] = {})>> = true;
static_assert(can_push<Post::Sender> && !can_push<Post::Receiver>);
static_assert(!can_assign<Post::Sender> && !can_assign<Post::Receiver>, "what is sent or received is not edited in place");

/// Words of the four ends of one tile.
template <class C, std::uint32_t Capacity>
struct Ends {
    static constexpr std::uint32_t item_words = C::Receiver::item_words;
    std::array<std::array<std::uint32_t, 2>, 4> heads{};
    std::array<std::array<std::uint32_t, Capacity * item_words + 1>, 4> items{}; // one more word: a canary
    machine::Place place(Direction d, std::uint32_t capacity = Capacity) { return {heads[index(d)].data(), items[index(d)].data(), capacity}; }
    In<C> in()
    {
        using R = typename C::Receiver;
        return {{R{place(news[0])}, R{place(news[1])}, R{place(news[2])}, R{place(news[3])}}};
    }
    Out<C> out(std::uint32_t capacity = Capacity)
    {
        using S = typename C::Sender;
        return {{S{place(news[0], capacity)}, S{place(news[1], capacity)}, S{place(news[2], capacity)}, S{place(news[3], capacity)}}};
    }
};

} // namespace

TEST_CASE("what is sent on a side is on that side's words and on no other")
{
    Ends<Post, 3> ends;
    auto out = ends.out();
    for (Direction d : news) {
        CHECK(out[d].empty());
        CHECK(out[d].room() == 3);
        CHECK(out[d].capacity() == 3);
    }
    out[Direction::west].unchecked_push({1, 2, 3.5f});
    CHECK(out[Direction::west].size() == 1);
    for (Direction d : {Direction::north, Direction::east, Direction::south}) CHECK(out[d].empty());
    auto const in = ends.in(); // the same words, as a reader: after an exchange the neighbour has these words
    REQUIRE(in[Direction::west].size() == 1);
    CHECK(in[Direction::west][0].to == 1);
    CHECK(in[Direction::west][0].from == 2);
    CHECK(in[Direction::west][0].text == 3.5f);
}

TEST_CASE("a full channel refuses and keeps its messages")
{
    Ends<Post, 3> ends;
    auto out = ends.out();
    auto& east = out[Direction::east];
    auto const before = broken_contracts();
    for (std::uint32_t i = 0; i < 3; ++i) {
        CHECK(east.room() == 3 - i);
        CHECK(east.try_push({i, i + 10, 0.0f}));
        out[Direction::north].push({i, i, 1.0f}); // silent while there is room
        CHECK(out[Direction::north].size() == i + 1);
    }
    CHECK_FALSE(east.try_push({77, 77, 0.0f}));
    CHECK(broken_contracts() == before);
    east.push({78, 78, 0.0f});
    CHECK(broken_contracts() == before + 1);
    CHECK(last_broken_contract().find("push into a full channel") == 0);
    CHECK(east.size() == 3);
    CHECK(east.room() == 0);
    std::uint32_t next = 0;
    for (Letter const& l : east) {
        CHECK(l.to == next);
        CHECK(l.from == next + 10);
        ++next;
    }
    CHECK(next == 3);
    CHECK(ends.items[index(Direction::east)][9] == 0); // the word after the third message
}

TEST_CASE("the note travels beside the messages: 0 when unwritten, alone or with them")
{
    Ends<Post, 3> ends;
    auto out = ends.out();
    auto const in = ends.in();
    CHECK(in[Direction::south].note() == 0);
    out[Direction::south].set_note(0xfeedf00du);
    CHECK(in[Direction::south].note() == 0xfeedf00du);
    CHECK(in[Direction::south].empty());
    out[Direction::south].unchecked_push({1, 1, 1.0f});
    CHECK(in[Direction::south].note() == 0xfeedf00du);
    CHECK(in[Direction::south].size() == 1);
    out[Direction::south].set_note(0);
    CHECK(in[Direction::south].note() == 0);
    CHECK(in[Direction::north].note() == 0);
}

TEST_CASE("channels with and without a number hold what the machine gave them: 0, 1, n - 1, n, n + 1")
{
    for (std::uint32_t limit : {0u, 1u, 3u, 4u, 5u}) {
        Ends<Wire, 5> wires;
        auto wire = wires.out(limit);
        Ends<Pipe, 5> pipes;
        auto pipe = pipes.out(limit);
        std::uint32_t in_wire = 0, in_pipe = 0;
        while (wire[Direction::north].try_push(in_wire)) ++in_wire;
        while (pipe[Direction::north].try_push(in_pipe)) ++in_pipe;
        CHECK(in_wire == limit);
        CHECK(in_pipe == limit);
        CHECK(wire[Direction::north].room() == 0);
        CHECK(wire[Direction::north].capacity() == limit);
        CHECK(pipe[Direction::north].capacity() == limit);
    }
}
