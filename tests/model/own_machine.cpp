// test: unoptimised test asan tsan
// The guide's machine, whose list takes the rest of the SRAM.
#include "../engine/everywhere.hpp"
#include <tilemesh/model/assumed_parameters.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/cost_table.hpp>

using engine_test::error_of, engine_test::has;

struct Mine { // all members of a machine
    static constexpr char const* name = "mine";
    static constexpr std::uint32_t tiles = 256, workers = 4, clock_khz = 500'000;
    static constexpr std::uint32_t sram_bytes = 32 * 1024, code_bytes = 8 * 1024; // of each tile: all; the part for code and stacks
};
struct Sizes { std::uint32_t stock; };
struct Stock : tilemesh::Buffer<std::uint32_t> { static constexpr auto slots = &Sizes::stock; };
struct Total { std::uint32_t sum; };
struct Add {
    void operator()(Stock const& stock, Total& total) const noexcept { for (auto n : stock) total.sum += n; }
};
using Adding = tilemesh::Repeat<Add>;

struct Empty { static constexpr Sizes sizes{0}; };
struct Full { // as many slots as fit beside all other regions
    static constexpr Sizes sizes{(Mine::sram_bytes - tilemesh::bytes_needed<Mine, Adding, Empty>) / sizeof(std::uint32_t)};
};

struct Over {
    static constexpr Sizes sizes{Full::sizes.stock + 1};
};
static_assert(tilemesh::fits<Mine, Adding, Full> && !tilemesh::fits<Mine, Adding, Over>);

TEST_CASE("a machine of one's own runs a program whose list takes the rest of its SRAM")
{
    auto const sizes = tilemesh::mesh_sizes<Adding, Mine, Full>();
    tilemesh::Mesh<Adding, tilemesh::Traced<Mine>> mesh{Adding{3}, tilemesh::Grid{16, 16}, sizes, {.threads = 2}};
    for (auto [tile, stock] : mesh.states<Stock>()) {
        CHECK(stock.capacity() == 6 * 1024 - 2 - 1); // 24 KiB without the list's head and the total
        stock.push(tile.x());
        stock.push(1);
    }
    mesh.run();
    for (auto [tile, total] : mesh.states<Total>()) CHECK(total.sum == 3 * (tile.x() + 1));
    CHECK(mesh.sram_bytes() == Mine::sram_bytes);

    auto const other = tilemesh::mesh_sizes<Adding>(tilemesh::size_of_machine<Mine>(), Sizes{100}); // known only at run time
    tilemesh::Mesh<Adding, tilemesh::Traced<Mine>> small{Adding{3}, tilemesh::Grid{16, 16}, other};
    CHECK(small.state<Stock>(tilemesh::TileId::at(0, 0)).capacity() == 100);
    CHECK(has(error_of([] { (void)tilemesh::mesh_sizes<Adding>(tilemesh::size_of_machine<Mine>(), Over::sizes); }), "does not fit"));
    CHECK(has(error_of([&] { tilemesh::Mesh<Adding, Mine> large{Adding{3}, tilemesh::Grid{17, 16}, other}; }), "(mine has 256)"));

    // run 20, sync 100; no channel, and no operation is counted
    auto const model = tilemesh::assumed_model<Mine>(4, 100);
    CHECK(model_cost(model, mesh.trace(), mesh.grid()).cycles == 3 * (20 + 100));
    CHECK(model.clock_khz == 500'000);

    std::ostringstream out;
    out << tilemesh::ledger_table(tilemesh::Tile<Mine, Adding, Full>::ledger(), Mine::sram_bytes);
    CHECK(has(out.str(), "32,768"));
    std::uint32_t sum = 0;
    for (auto const& region : tilemesh::Tile<Mine, Adding, Full>::ledger()) sum += region.bytes;
    CHECK(sum == Mine::sram_bytes);
}

namespace {
std::uint64_t byte_price(double bytes_a_cycle)
{
    return tilemesh::assumed_model<Mine>(bytes_a_cycle, 100).exchange_millicycles_a_byte;
}
std::string source_of(tilemesh::CostModel const& model, std::string const& name)
{
    return std::find_if(model.parameters.begin(), model.parameters.end(), [&](auto const& p) { return p.name == name; })->source;
}
} // namespace

TEST_CASE("an assumed model takes any rate of bytes that has a price, and refuses the others")
{
    for (auto const& each :
         {std::pair(4.0, 250u), {32.0, 31u}, {2.9, 345u} /* 344.8 */, {0.5, 2000u}, {2000.0, 1u} /* 0.5 */, {0.00001, 100'000'000u}})
        CHECK_MESSAGE(byte_price(each.first) == each.second, each.first);
    auto const model = tilemesh::assumed_model<Mine>(0.5, 100);
    CHECK(source_of(model, "exchange_byte") == "assumed: a tile receives 0.5 bytes in a cycle; rounded to whole millicycles");
    for (double const rate : {0.0, -4.0, 2001.0, 0.000009, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
        CHECK(has(error_of([&] { (void)byte_price(rate); }), " bytes in a cycle (a byte takes 1 to 100,000,000 thousandths of a cycle: a rate from 0.00001 to 2,000)"));
    CHECK(has(error_of([] { (void)byte_price(-2.5); }), "a tile cannot receive -2.5 bytes in a cycle"));
}

TEST_CASE("an assumed model says which numbers are mk2's, and for how many workers")
{
    auto const mk2 = tilemesh::mk2();
    auto model = tilemesh::assumed_model<Mine>(4, 100);
    for (std::string const name : {"pair", "pixel", "moving_pair", "moving_depth", "splat_motions", "row"}) {
        CAPTURE(name);
        CHECK(price_of(model, name) == price_of(mk2, name));
        CHECK(source_of(model, name) == "kept from mk2, because all workers of a tile, here 4, issue one instruction a cycle together; " + source_of(mk2, name));
    }
    CHECK(source_of(model, "run") == "kept from mk2; " + source_of(mk2, "run"));
    CHECK(source_of(model, "exchange") == "kept from mk2; " + source_of(mk2, "exchange"));
    CHECK(price_of(model, "slot") == 4 * 4000); // four instructions of one worker
    CHECK(price_of(model, "host_byte") == 16);  // 0.5 GHz over 32 GB/s is 0.0156
    set_parameter(model, "exchange_byte", 300, "measured");
    std::ostringstream out;
    write_cost_model(out, model);
    CHECK(has(out.str(), "measured"));
}
