// test: unoptimised test asan tsan
#include "control.hpp"
#include "everywhere.hpp"

using namespace engine_test;

namespace {
template <class M>
void load(M& mesh)
{
    Random random{mesh.grid().width * 100 + mesh.grid().height};
    for (std::uint32_t i = 0; i < mesh.grid().size(); ++i)
        mesh.template state<Load>(mesh.grid().tile(i)) = {static_cast<float>(random.below(1u << 20)) * 0.001f - 300, random.bits() | 5u};
}
template <class M>
Total total_at(M& mesh, TileId t)
{
    return {mesh.template state<Reduced<Weight, Sum>>(t).value, mesh.template state<Reduced<Weight, Least>>(t).value,
            mesh.template state<Reduced<Weight, Most>>(t).value, mesh.template state<Reduced<Bits, And>>(t).value,
            mesh.template state<Reduced<Bits, Sum>>(t).value};
}
template <class M>
Total expected(M& mesh)
{
    auto const grid = mesh.grid();
    std::vector<float> weights;
    std::vector<std::uint32_t> bits;
    for (std::uint32_t i = 0; i < grid.size(); ++i) {
        weights.push_back(mesh.template state<Load>(grid.tile(i)).weight);
        bits.push_back(mesh.template state<Load>(grid.tile(i)).bits);
    }
    std::uint32_t all = 0xffffffffu, sum = 0;
    for (auto b : bits) {
        all &= b;
        sum += b;
    }
    return {reduce_on_host(weights, grid, [](float a, float b) { return a + b; }), *std::min_element(weights.begin(), weights.end()),
            *std::max_element(weights.begin(), weights.end()), all, sum};
}
void check_equal(Total const& a, Total const& b)
{
    CHECK(a.sum == b.sum);
    CHECK(a.least == b.least);
    CHECK(a.most == b.most);
    CHECK(a.all == b.all);
    CHECK(a.bits == b.bits);
}
template <ReduceTo Where>
void check_grid(Grid grid)
{
    CAPTURE(grid.width);
    CAPTURE(grid.height);
    auto const p = everywhere<Reducing<Where>>(grid, [](auto& mesh) { load(mesh); }, 2);
    auto const want = expected(*p.mesh);
    bool const all = Where == ReduceTo::all;
    for (std::uint32_t i = 0; i < (all ? grid.size() : 1); ++i) check_equal(total_at(*p.mesh, grid.tile(i)), want);
    std::uint64_t const hops = (grid.width - 1 + grid.height - 1) * (all ? 2 : 1);
    for (std::size_t r = 0; r < 5; ++r) {
        CHECK(p.step(2 * r).exchanges + p.step(2 * r + 1).exchanges == hops);
        CHECK(p.step(2 * r).passes + p.step(2 * r + 1).passes == hops + 1);
        // Each tile except tile (0, 0) sends one message. With ReduceTo::all, each of them also receives one.
        CHECK(p.step(2 * r).messages + p.step(2 * r + 1).messages == (grid.size() - 1) * (all ? 2u : 1u));
    }
}
} // namespace

TEST_CASE("Reduce: sum, least, most and and are those of a plain loop, at tile (0, 0) or at all, for W - 1 + H - 1 exchanges")
{
    for (Grid const grid : {Grid{1, 1}, Grid{7, 1}, Grid{1, 6}, Grid{2, 2}, Grid{5, 4}, Grid{3, 8}}) {
        check_grid<ReduceTo::one>(grid);
        check_grid<ReduceTo::all>(grid);
    }
}

namespace {
struct Idle {
    void operator()(Load const&) const noexcept {}
};
template <ReduceTo Where>
void check_reduce_on(Grid grid)
{
    CAPTURE(grid.width);
    CAPTURE(grid.height);
    Mesh known{reduce_on<Weight, Sum, Where>(grid), grid, Traced<Mk2>{}};
    Mesh usual{Reduce<Weight, Sum, Where>{}, grid, Traced<Mk2>{}};
    CheckedMesh checked{reduce_on<Weight, Sum, Where>(grid), grid, Traced<Mk2>{}};
    load(known);
    load(usual);
    load(checked);
    for (int i = 0; i < 2; ++i) { // nothing is left under way for the second run
        auto const a = known.run(), b = usual.run();
        check_same(checked.run(), a);
        CHECK(words_of(known) == words_of(usual));
        CHECK(words_of(known) == words_of(checked));
        CHECK(a.messages() == b.messages());
        CHECK(a.exchanges() == b.exchanges());
        CHECK(passes(a) == passes(b) + (grid.size() == 1 ? 1 : 0));
    }
    for (auto const& superstep : known.trace().supersteps) CHECK(!superstep.votes);
    bool votes = grid.size() == 1; // one tile has nothing to add up
    for (auto const& superstep : usual.trace().supersteps) votes = votes || superstep.votes;
    CHECK(votes);
}
} // namespace

TEST_CASE("reduce_on: a reduction of known length asks for no vote, and has the words, messages and passes of Reduce")
{
    for (Grid const grid : {Grid{1, 1}, Grid{7, 1}, Grid{1, 6}, Grid{2, 2}, Grid{5, 4}, Grid{3, 8}}) {
        check_reduce_on<ReduceTo::one>(grid);
        check_reduce_on<ReduceTo::all>(grid);
    }
}

TEST_CASE("reduce_on: a mesh with another grid refuses the program when it is built")
{
    auto const refused = [](auto const& program, Grid grid) {
        auto const text = error_of([&] { Mesh mesh{program, grid}; });
        CHECK(error_of([&] { CheckedMesh mesh{program, grid}; }) == text);
        return text;
    };
    using Busy = Superstep<Idle>;
    Grid const grid{8, 6};
    auto const known = reduce_on<Weight, Sum>(grid);
    CHECK(refused(known, grid).empty());
    CHECK(refused(known, {8, 7}) == "a part of the program for a grid of 8 x 6 tiles (the mesh has 8 x 7); give reduce_on the grid of the mesh");
    for (Grid const other : {Grid{7, 6}, Grid{9, 6}, Grid{8, 5}, Grid{6, 8}, Grid{1, 1}}) CHECK(!refused(known, other).empty());
    // at any depth of a program
    CHECK(has(refused(Sequence{Busy{}, Sequence{known}}, {7, 6}), "for a grid of 8 x 6 tiles (the mesh has 7 x 6)"));
    CHECK(has(refused(Sequence{Busy{}, Loop{2, known, Busy{}}}, {7, 6}), "for a grid of 8 x 6 tiles (the mesh has 7 x 6)"));
    CHECK(refused(Sequence{Busy{}, Loop{2, known, Busy{}}}, grid).empty());
}

TEST_CASE("Reduce: its ledger is a word of state and a channel of one message; a value may look at several things")
{
    using Layout = Tile<Mk2, Reduce<Weight, Sum>>;
    CHECK(Layout::words<Reduced<Weight, Sum>>() == 1);
    CHECK(Layout::bytes == Mk2::code_bytes + 8 + 4 + 8 * (8 + 4));
    CHECK(Layout::ledger().size() == 4);
    CHECK(engine::text(Layout::ledger()[2].name) == "sum weight so far");
}

namespace {
struct Where {
    float weight;
    std::uint32_t tile;
};
struct Heaviest {
    Where operator()(Load const& load, Here here) const noexcept { return {load.weight, here.grid.index_of(here.tile)}; }
};
struct ByWeight {
    static constexpr char const* name = "heaviest";
    constexpr Where operator()(Where mine, Where others) const noexcept { return others.weight > mine.weight ? others : mine; }
};
} // namespace

TEST_CASE("Reduce: a value and an operator of one's own say where the heaviest is")
{
    auto const p = everywhere<Reduce<Heaviest, ByWeight, ReduceTo::all>>({6, 5}, [](auto& mesh) { load(mesh); });
    auto const grid = p.mesh->grid();
    std::uint32_t best = 0;
    for (std::uint32_t i = 1; i < grid.size(); ++i)
        if (p.mesh->state<Load>(grid.tile(i)).weight > p.mesh->state<Load>(grid.tile(best)).weight) best = i;
    for (std::uint32_t i = 0; i < grid.size(); ++i) CHECK(p.mesh->state<Reduced<Heaviest, ByWeight>>(grid.tile(i)).value.tile == best);
}

namespace {
struct Span { float low, high; };
struct Room { Span kelvin; };
struct Cover { // an empty struct: the value of the tile that combines, and that of its neighbour to the east or south
    Span operator()(Span mine, Span others) const noexcept { return {std::min(mine.low, others.low), std::max(mine.high, others.high)}; }
};
using Widest = tilemesh::Reduce<tilemesh::Member<&Room::kelvin>, Cover, tilemesh::ReduceTo::all>;

struct Digits {
    std::uint32_t value;
};
struct Append { // neither associative nor commutative
    std::uint32_t operator()(std::uint32_t mine, std::uint32_t others) const noexcept { return 31 * others + mine; }
};
} // namespace

TEST_CASE("Reduce: an operator without a name combines structs")
{
    auto const p = everywhere<Widest>({3, 2}, [](auto& mesh) {
        for (auto [tile, room] : mesh.template states<Room>())
            room.kelvin = {300 - static_cast<float>(tile.x()), 300 + static_cast<float>(tile.y())};
    });
    for (auto [tile, widest] : p.mesh->template states<Reduced<Member<&Room::kelvin>, Cover>>()) {
        CHECK(widest.value.low == 298);
        CHECK(widest.value.high == 301);
    }
}

TEST_CASE("Reduce: the order is fixed, so that an operator need be neither associative nor commutative; without `all`, other tiles hold parts")
{
    using Program = Reduce<Member<&Digits::value>, Append>;
    for (Grid const grid : {Grid{1, 1}, Grid{1, 5}, Grid{5, 1}, Grid{3, 4}}) {
        CAPTURE(grid.width);
        std::vector<std::uint32_t> values;
        for (std::uint32_t i = 0; i < grid.size(); ++i) values.push_back(i + 1);
        auto const p = everywhere<Program>(grid, [&](auto& mesh) {
            for (std::uint32_t i = 0; i < grid.size(); ++i) mesh.template state<Digits>(grid.tile(i)).value = values[i];
        });
        auto const at = [&](std::uint32_t i) { return p.mesh->template state<Reduced<Member<&Digits::value>, Append>>(grid.tile(i)).value; };
        CHECK(at(0) == reduce_on_host(values, grid, Append{}));
        CHECK(at(grid.size() - 1) == grid.size()); // the part of the last tile is its own value
    }
}
