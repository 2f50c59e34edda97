// test: unoptimised test asan tsan
#include "handler.hpp"
#include <algorithm>
#include <array>
#include <cstdint>
#include <doctest/doctest.h>
#include <numeric>
#include <tilemesh/machine/buffer.hpp>
#include <type_traits>
#include <vector>

using namespace tilemesh;
using machine_test::broken_contracts;
using machine_test::last_broken_contract;

namespace {

/// An item of several words. An int converted to a Parcel cannot pass for one.
struct Parcel {
    std::uint32_t id;
    float weight[3];
    std::uint32_t check;
    friend bool operator==(Parcel const& a, Parcel const& b)
    {
        return a.id == b.id && a.weight[0] == b.weight[0] && a.weight[1] == b.weight[1] && a.weight[2] == b.weight[2] && a.check == b.check;
    }
};
static_assert(sizeof(Parcel) == 20);

Parcel parcel(std::uint32_t id)
{
    auto const f = static_cast<float>(id);
    return {id, {f + 0.25f, -f, f * 1024.0f}, ~id};
}

constexpr std::uint32_t canary = 0xc0ffee00u;

/// Words for a list, with canaries before and after its items and after its head.
template <std::uint32_t Items, std::uint32_t ItemWords = 1>
struct Words {
    std::array<std::uint32_t, 3> head{0, 0, canary};
    std::array<std::uint32_t, Items * ItemWords + 2> items;
    Words() { items.fill(canary); }
    machine::Place place(std::uint32_t capacity = Items) { return {head.data(), items.data() + 1, capacity}; }
    bool intact() const { return head[2] == canary && items.front() == canary && items.back() == canary; }
};

template <class List>
std::vector<std::uint32_t> contents(List const& list)
{
    return {list.begin(), list.end()};
}
using Values = std::vector<std::uint32_t>;

using Four = Buffer<std::uint32_t, 4>;
using Sized = Buffer<std::uint32_t>;

// A view is two pointers and a capacity, both if a type gives the slots and if a value gives them.
static_assert(sizeof(Four) == 3 * sizeof(void*) && sizeof(Sized) == 3 * sizeof(void*));
static_assert(std::is_trivially_copyable_v<Four> && std::is_trivially_copyable_v<Sized>);
static_assert(Four::static_capacity == 4 && Sized::static_capacity == dynamic_capacity);
static_assert(Four::head_words == 2 && Four::item_words == 1 && Buffer<Parcel, 7>::item_words == 5);
static_assert(Four::words(0) == 2 && Four::words(1) == 3 && Four::words(4) == 6);
static_assert(Buffer<Parcel, 7>::words(7) == 2 + 35 && Buffer<Parcel, 7>::words(0) == 2);

} // namespace

TEST_CASE("push and unchecked_push write the same and are silent while there is room; a full list keeps its contents, and push alone reports")
{
    Words<3> checked, unchecked;
    Buffer<std::uint32_t, 3> a{checked.place()}, b{unchecked.place()};
    auto const before = broken_contracts();
    for (std::uint32_t i = 0; i < 3; ++i) {
        a.push(i * 17);
        b.unchecked_push(i * 17);
    }
    CHECK(checked.head == unchecked.head);
    CHECK(checked.items == unchecked.items);
    CHECK_FALSE(b.try_push(99));
    CHECK_FALSE(b.try_push(98));
    CHECK(broken_contracts() == before);
    a.push(4);
    CHECK(broken_contracts() == before + 1);
    CHECK(last_broken_contract().find("push into a full buffer") == 0);
    CHECK(last_broken_contract().find("; use try_push") != std::string::npos);
    for (auto const& list : {a, b}) CHECK(contents(list) == Values{0, 17, 34});
    CHECK(checked.intact());
    CHECK(unchecked.intact());
    a.truncate(2);
    a.push(5);
    CHECK(broken_contracts() == before + 1);
    CHECK(contents(a) == Values{0, 17, 5});
}

TEST_CASE("swap_remove of the first, a middle, the last and the only item")
{
    Words<4> words;
    Four b{words.place()};
    for (std::uint32_t v : {1u, 2u, 3u, 4u}) b.push(v);
    b.swap_remove(0);
    CHECK(contents(b) == Values{4, 2, 3});
    b.swap_remove(2);
    CHECK(contents(b) == Values{4, 2});
    b.push(5);
    b.swap_remove(1);
    CHECK(contents(b) == Values{4, 5});
    b.swap_remove(0);
    CHECK(contents(b) == Values{5});
    b.swap_remove(0);
    CHECK(b.empty());
    CHECK(b.room() == 4);
    CHECK(words.intact());
}

TEST_CASE("truncate keeps the first n and leaves room behind them")
{
    Words<4> words;
    Four b{words.place()};
    for (std::uint32_t v : {1u, 2u, 3u, 4u}) b.push(v);
    b.truncate(4);
    CHECK(contents(b) == Values{1, 2, 3, 4});
    b.truncate(3);
    CHECK(contents(b) == Values{1, 2, 3});
    CHECK(b.room() == 1);
    b.truncate(1);
    CHECK(contents(b) == Values{1});
    b.truncate(0);
    CHECK(b.empty());
    CHECK(b.room() == 4);
}

TEST_CASE("resize: to 0, n - 1 and n; beyond the capacity it is refused and the size kept")
{
    Words<4> words;
    Four b{words.place()};
    auto const before = broken_contracts();
    b.resize(4);
    CHECK(b.size() == 4);
    for (std::uint32_t i = 0; i < 4; ++i) b[i] = 100 + i;
    b.resize(3);
    CHECK(contents(b) == Values{100, 101, 102});
    b.resize(4);
    CHECK(b[3] == 103); // resize changes no word
    b.resize(0);
    CHECK(b.empty());
    b.resize(2);
    CHECK(broken_contracts() == before);
    b.resize(5);
    CHECK(broken_contracts() == before + 1);
    CHECK(last_broken_contract().find("resize of a buffer beyond its capacity") == 0);
    CHECK(b.size() == 2);
    b.resize(0xffffffffu);
    CHECK(b.size() == 2);
    CHECK(words.intact());
}

TEST_CASE_TEMPLATE("one rule of capacity: a list has the slots of its place, 0, 1, n - 1, n, n + 1, whatever its type names", List, Four, Sized)
{
    for (std::uint32_t slots : {0u, 1u, 3u, 4u, 5u}) {
        CAPTURE(slots);
        Words<8> words;
        List b{words.place(slots)};
        CHECK(b.capacity() == slots);
        CHECK(b.empty());
        CHECK(b.begin() == b.end());
        for (std::uint32_t taken = 0; taken < slots; ++taken) {
            CHECK(b.room() == slots - taken);
            CHECK(b.try_push(10 + taken));
            CHECK(b.size() == taken + 1);
        }
        CHECK_FALSE(b.try_push(99));
        CHECK(b.empty() == (slots == 0));
        CHECK(b.room() == 0);
        Values want(slots);
        std::iota(want.begin(), want.end(), 10u);
        CHECK(contents(b) == want);
        CHECK(words.head[0] == slots);
        CHECK(words.head[1] == 0);
        CHECK(words.items[1 + slots] == canary);
        CHECK(words.intact());
    }
}

TEST_CASE_TEMPLATE("push and resize are refused at the slots of the place", List, Four, Sized)
{
    Words<4> words;
    List b{words.place(2)};
    b.push(1);
    b.push(2);
    auto const before = broken_contracts();
    b.push(3);
    b.resize(3);
    CHECK(broken_contracts() == before + 2);
    CHECK(contents(b) == Values{1, 2});
    CHECK(words.items[3] == canary);
}

TEST_CASE_TEMPLATE("fewer slots than what is held leaves no room and refuses, instead of wrapping around", List, Four, Sized)
{
    Words<4> words;
    List wide{words.place(4)};
    for (std::uint32_t v : {1u, 2u, 3u}) wide.push(v);
    List narrow{words.place(2)};
    CHECK(narrow.room() == 0);
    CHECK_FALSE(narrow.try_push(4));
    CHECK(contents(narrow) == Values{1, 2, 3});
}

TEST_CASE("items of several words keep every word, through push, removal and a second view")
{
    Words<3, 5> words;
    Buffer<Parcel, 3> b{words.place()};
    for (std::uint32_t i = 0; i < 3; ++i) CHECK(b.try_push(parcel(i)));
    CHECK_FALSE(b.try_push(parcel(3)));
    CHECK(words.intact());
    for (std::uint32_t i = 0; i < 3; ++i) CHECK(b[i] == parcel(i));
    b.swap_remove(0);
    Buffer<Parcel, 3> const other{words.place()}; // a view holds no state: a second view sees the same list
    CHECK(other.size() == 2);
    CHECK(other[0] == parcel(2));
    CHECK(other[1] == parcel(1));
    CHECK(other.end() - other.begin() == 2);
    CHECK(words.items[1] == 2); // the id of the first item, as a word
    CHECK(words.items[1 + 4] == ~2u);
    CHECK(words.intact());
}

TEST_CASE("a buffer is written through begin() and []")
{
    Words<4> words;
    Four b{words.place()};
    for (std::uint32_t v : {3u, 1u, 2u}) b.push(v);
    for (auto& v : b) v *= 2;
    b[1] = 9;
    CHECK(contents(b) == Values{6, 9, 4});
    std::reverse(b.begin(), b.end()); // GCC 12 gives a false -Warray-bounds for std::sort here
    CHECK(contents(b) == Values{4, 9, 6});
    CHECK(words.items[4] == canary);
}
