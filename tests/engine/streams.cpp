// Where a thread's messages lie in memory: in its stretch, or, of full channels, in the memory of tiles. Each message is there until it is read,
// whatever the pieces of tiles that threads take, and however often they run before the exchange.
#include "everywhere.hpp"

using namespace engine_test;

namespace {

struct Note : Channel<std::uint32_t, 9> {};
struct Number {
    std::uint32_t value; ///< of the tile; it sends so many words of a number and a half, up to all of a channel
};
struct Say {
    void operator()(Number const& number, Out<Note> out) const noexcept
    {
        for (Direction d : news)
            for (std::uint32_t k = 0; k < number.value % 10; ++k) out[d].push(1000 * number.value + 100 * index(d) + k);
    }
};
struct Hear {
    void operator()(In<Note>) const noexcept {}
};
using Program = Sequence<Superstep<Say>, Superstep<Hear>>;

/// A mesh whose supersteps the test runs in parts.
struct Parts : Mesh<Program> {
    using Tiles = engine::MeshTiles<Program, false>;
    explicit Parts(std::uint32_t threads) : Mesh<Program>({}, Grid{6, 5}, {.threads = threads}) {}
    void say(std::uint32_t thread, std::vector<std::uint32_t> const& tiles)
    {
        Tiles::run_tiles<Say>(static_cast<Tiles*>(this), thread, tiles.data(), static_cast<std::uint32_t>(tiles.size()), false);
    }
    /// An exchange, a superstep that reads all messages, and one or two more exchanges: the next messages go into this bank or the other one.
    void exchange(bool other)
    {
        auto const flip = [this](std::size_t step) { this->flip(*engine::program_facts<Program>.steps[step].kernel); };
        flip(0);
        Tiles::run_tiles<Hear>(static_cast<Tiles*>(this), 0, nullptr, 30, false);
        flip(1);
        if (other) flip(0);
    }
    /// How many of the channel ends have the words that their tiles send.
    std::uint32_t right()
    {
        std::uint32_t n = 0;
        for (std::uint32_t tile = 0; tile < 30; ++tile)
            for (Direction d : news) {
                auto const place = this->sent(this->view(), 0, tile, d);
                bool all = place.head[0] == tile % 10;
                for (std::uint32_t k = 0; k < tile % 10 && all; ++k) all = place.items[k] == 1000 * tile + 100 * index(d) + k;
                n += all ? 1 : 0;
            }
        return n;
    }
    void number_tiles()
    {
        for (std::uint32_t tile = 0; tile < 30; ++tile) this->template state<Number>(this->grid().tile(tile)).value = tile;
    }
};
std::vector<std::uint32_t> tiles(std::uint32_t from, std::uint32_t to)
{
    std::vector<std::uint32_t> all(to - from);
    std::iota(all.begin(), all.end(), from);
    return all;
}

TEST_CASE("streams: a thread that gets no tile in its first run begins in its second")
{
    for (int exchanges = 0; exchanges < 3; ++exchanges) { // before the first one, and in either bank
        Parts mesh(2);
        mesh.number_tiles();
        for (int i = 0; i < exchanges; ++i) mesh.say(1, tiles(0, 30)), mesh.exchange(true);
        mesh.say(1, {});
        mesh.say(1, tiles(0, 30));
        CHECK(mesh.right() == 120);
    }
}

TEST_CASE("streams: pieces of any sizes, by threads in any order, in several runs of a superstep")
{
    tests::Random random(5);
    for (std::uint32_t const threads : {1u, 2u, 3u, 7u}) {
        Parts mesh(threads);
        mesh.number_tiles();
        for (int superstep = 0; superstep < 20; ++superstep) {
            for (std::uint32_t from = 0; from < 30;) {
                auto const to = std::min(30u, from + random.below(1 + random.below(12)));
                mesh.say(random.below(threads), tiles(from, to));
                from = to;
            }
            CHECK(mesh.right() == 120);
            mesh.exchange(random.below(2) == 0);
        }
    }
}

} // namespace
