// test: unoptimised test asan
// Two host forms: the host runs all workers of a tile in one call, and uses handles instead of records.
#include "everywhere.hpp"
#include "programs.hpp"

using namespace engine_test;

namespace {

struct Numbers : Buffer<std::uint32_t, 20> {};
struct Seen {
    std::uint32_t calls, index, count;
};
struct Fill {
    void operator()(Numbers& numbers, Seen& seen, Here here) const noexcept
    {
        numbers.resize(here.tile.x() + here.tile.y());
        for (std::uint32_t i = 0; i < numbers.size(); ++i) numbers[i] = i;
        seen = {};
    }
};
/// Adds to each number its index. With Lie = 1, AllWorkers adds more, so it contradicts the kernel.
template <std::uint32_t Lie>
struct AddIndex {
    void operator()(Numbers& numbers, Worker worker) const noexcept
    {
        for (auto i = worker.index; i < numbers.size(); i += worker.count) numbers[i] += i;
    }
    struct AllWorkers {
        void operator()(Numbers& numbers, Worker worker) const noexcept
        {
            for (std::uint32_t i = 0; i < numbers.size(); ++i) numbers[i] += i + Lie * worker.count;
        }
    };
};
template <std::uint32_t Lie>
using Adding = Sequence<Superstep<Fill>, Repeat<AddIndex<Lie>>>;

struct Tell { // records how each engine calls the kernel
    void operator()(Seen& seen, Worker worker) const noexcept { seen = {seen.calls + 1, worker.index, worker.count}; }
    struct AllWorkers {
        void operator()(Seen& seen, Worker worker) const noexcept { seen = {seen.calls + 100, worker.index, worker.count}; }
    };
};

} // namespace

TEST_CASE("a kernel's AllWorkers leaves what its workers leave, on every engine")
{
    auto const p = everywhere<Adding<0>, Bench>({7, 5}, [](auto&) {}, 2, {{}, {3}});
    auto const numbers = p.mesh->state<Numbers>(TileId::at(6, 4));
    REQUIRE(numbers.size() == 10);
    for (std::uint32_t i = 0; i < 10; ++i) CHECK(numbers[i] == 4 * i);
}

TEST_CASE("an AllWorkers that does otherwise than its workers shows as a difference between the engines")
{
    CheckedMesh<Adding<1>, Bench> checked{{{}, {3}}, {7, 5}, {.digest = true}};
    Mesh<Adding<1>, Bench> mesh{{{}, {3}}, {7, 5}, {.threads = 2, .digest = true}};
    auto const a = checked.run(), b = mesh.run();
    REQUIRE(a.digests.size() == 4);
    REQUIRE(b.digests.size() == 4);
    CHECK(a.digests[0] == b.digests[0]);
    CHECK(a.digests[1] != b.digests[1]);
    CHECK(words_of(checked) != words_of(mesh));
}

TEST_CASE("Mesh calls AllWorkers once a tile with all workers, CheckedMesh the kernel for each")
{
    using Program = Sequence<Superstep<Fill>, Superstep<Tell>>;
    Mesh<Program> mesh{{}, {4, 3}};
    mesh.run();
    CheckedMesh<Program> checked{{}, {4, 3}};
    checked.run();
    for (std::uint32_t i = 0; i < 12; ++i) {
        auto const& whole = mesh.state<Seen>(mesh.grid().tile(i));
        CHECK(whole.calls == 100);
        CHECK(whole.index == 0);
        CHECK(whole.count == Mk2::workers);
        auto const& each = checked.state<Seen>(mesh.grid().tile(i));
        CHECK(each.calls == Mk2::workers);
        CHECK(each.index == 0); // CheckedMesh runs the last worker first
        CHECK(each.count == Mk2::workers);
    }
}

namespace {

struct Value {
    std::uint32_t number, rest[14];
};
struct Handle {
    static constexpr std::uint32_t wire_bytes = sizeof(Value);
    std::uint32_t number;
};
static_assert(wire_bytes<Value> == 60 && wire_bytes<Handle> == 60 && wire_bytes<std::uint32_t> == 4);
static_assert(sizeof(Handle) == 4);

template <class T, std::uint32_t N = 5>
struct Line : Channel<T, N> {};
static_assert(Line<Handle>::end_bytes(5) == 308 && Line<Value>::end_bytes(5) == 308);
template <class T>
struct Kept : Buffer<std::uint32_t, 40> {};
/// Each tile of columns x = 0 to 3 sends x + 1 messages eastwards once. A tile keeps the numbers that arrive from the west.
template <class T, std::uint32_t N>
struct Pass {
    void operator()(Kept<T>& kept, Here here, In<Line<T, N>> in, Out<Line<T, N>> out) const noexcept
    {
        if (kept.empty() && here.tile.x() < 4) {
            for (std::uint32_t i = 0; i <= here.tile.x(); ++i) {
                T message{};
                message.number = i;
                out[Direction::east].push(message);
            }
            kept.push(here.tile.x());
        }
        for (auto const& message : in[Direction::west]) kept.push(message.number);
    }
};
template <class T, std::uint32_t N>
using Passing = Sequence<Superstep<Pass<T, N>>, UntilQuiet<Pass<T, N>>>;

} // namespace

TEST_CASE("handles count as the records they stand for: live bytes, capacity bytes and the ledger")
{
    using Values = Passing<Value, 5>;
    using Handles = Passing<Handle, 5>;
    static_assert(Tile<Bench, Values>::channel_bytes<Line<Value>>() == 8 * (8 + 5 * 60));
    static_assert(Tile<Bench, Handles>::channel_bytes<Line<Handle>>() == Tile<Bench, Values>::channel_bytes<Line<Value>>());
    static_assert(Tile<Bench, Handles>::bytes == Tile<Bench, Values>::bytes);
    auto const values = everywhere<Values, Bench>({6, 3}, [](auto&) {});
    auto const handles = everywhere<Handles, Bench>({6, 3}, [](auto&) {});
    CHECK(values.step(0).messages == 3 * (1 + 2 + 3 + 4));
    CHECK(values.step(0).live_bytes == 60 * values.step(0).messages);
    CHECK(values.step(0).capacity_bytes == 6 * 3 * 4 * (8 + 5 * 60));
    for (std::size_t i = 0; i < 2; ++i) {
        CHECK(handles.step(i).messages == values.step(i).messages);
        CHECK(handles.step(i).live_bytes == values.step(i).live_bytes);
        CHECK(handles.step(i).capacity_bytes == values.step(i).capacity_bytes);
    }
}

TEST_CASE("slots of a dynamic channel of handles take the SRAM of the records")
{
    using Program = Passing<Handle, dynamic_capacity>;
    using C = Line<Handle, dynamic_capacity>;
    constexpr auto base = Tile<Bench, Program>::bytes;
    using Exact = TestMachine<base + 8 * 60 * 7>;
    on_each<Program, Exact>({6, 3}, [](auto& mesh) {
        CHECK(error_of([&] { mesh.template limit<C>(7); }).empty());
        CHECK(mesh.sram_bytes() == Exact::sram_bytes);
        CHECK(has(error_of([&] { mesh.template limit<C>(8); }), "480 bytes over"));
    });
}

namespace {

struct Prices {
    std::uint32_t of[3];
};
struct Priced {
    std::uint32_t number, price;
    static Priced make(std::uint32_t number, Prices const& prices) noexcept { return {number, prices.of[number]}; }
};
struct Ticket { // its price is in the broadcast
    static constexpr std::uint32_t wire_bytes = sizeof(Priced);
    std::uint32_t number;
    static Ticket make(std::uint32_t number, Prices const&) noexcept { return {number}; }
    using Whole = Priced;
    using WholeBy = Prices;
    Whole whole(Prices const& prices) const noexcept { return Priced::make(number, prices); }
};
template <class Item>
struct Counter : Channel<Item, 3> {};
template <class Item>
struct Shelf : Buffer<Item, 3> {};
template <class Item>
struct Serve {
    void operator()(Here here, Broadcast<Prices> prices, Shelf<Item>& shelf, In<Counter<Item>>, Out<Counter<Item>> out) const noexcept
    {
        shelf.truncate(0);
        for (std::uint32_t i = 0; i < 1 + here.tile.x(); ++i) {
            shelf.push(Item::make(i, *prices));
            out[Direction::east].push(Item::make(2 - i, *prices));
        }
    }
};
template <template <class...> class Engine, class Item>
std::uint64_t digest_of(std::uint32_t last_price)
{
    using Program = Sequence<Superstep<Serve<Item>>>;
    Engine<Program> mesh{Program{}, {3, 2}, {.digest = true}};
    mesh.template broadcast<Prices>() = {{7, 8, last_price}};
    return mesh.run().digests.at(0);
}

} // namespace

TEST_CASE("digests take the words of whole items where a host's items leave out what a broadcast says")
{
    auto const whole = digest_of<Mesh, Priced>(9);
    CHECK(digest_of<Mesh, Ticket>(9) == whole);
    CHECK(digest_of<CheckedMesh, Ticket>(9) == whole);
    CHECK(digest_of<CheckedMesh, Priced>(9) == whole);
    CHECK(digest_of<Mesh, Ticket>(10) != whole);
}
