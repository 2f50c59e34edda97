// test: unoptimised test asan tsan
#include "programs.hpp"
#include "everywhere.hpp"

using namespace engine_test;

TEST_CASE("heat: two passes known by hand, then conservation, symmetry and decay")
{
    SUBCASE("two passes")
    {
        auto const heat = everywhere<Heat>(
            {5, 5},
            [](auto& mesh) {
                mesh.template broadcast<Conductivity>().per_step = 0.2f;
                mesh.template state<Cell>(TileId::at(2, 2)).kelvin = 1000;
                mesh.template state<Cell>(TileId::at(0, 0)).kelvin = 100;
            },
            1, Heat{{2}});
        auto const at = [&](std::uint32_t x, std::uint32_t y) { return heat.mesh->template state<Cell>(TileId::at(x, y)).kelvin; };
        CHECK(at(2, 2) == doctest::Approx(200));
        for (auto t : {TileId::at(1, 2), TileId::at(3, 2), TileId::at(2, 1), TileId::at(2, 3)}) CHECK(at(t.x(), t.y()) == doctest::Approx(200));
        CHECK(at(0, 0) == doctest::Approx(60)); // two sides of a corner return the tile's own message: they are insulated
        CHECK(at(1, 1) == 0);
        CHECK(at(4, 4) == 0);
        CHECK(heat.step(0).kernel == "Diffuse");
        CHECK(heat.step(0).passes == 2);
        CHECK(heat.step(0).exchanges == 2);
        CHECK(heat.step(0).tile_runs == 50);
        CHECK(heat.step(0).messages == 200);
        CHECK(heat.step(0).live_bytes == 800);
        CHECK(heat.step(0).capacity_bytes == 2 * 16 * 25 * 3);
        CHECK(heat.last().exchanges() == 2);
    }
    SUBCASE("many passes on an odd grid")
    {
        constexpr std::uint32_t size = 11;
        auto const heat = everywhere<Heat>(
            {size, size},
            [](auto& mesh) {
                mesh.template broadcast<Conductivity>().per_step = 0.2f;
                mesh.template state<Cell>(TileId::at(size / 2, size / 2)).kelvin = 1000;
            },
            2, Heat{{40}});
        auto const at = [&](std::uint32_t x, std::uint32_t y) { return heat.mesh->template state<Cell>(TileId::at(x, y)).kelvin; };
        double sum = 0;
        for (std::uint32_t y = 0; y < size; ++y)
            for (std::uint32_t x = 0; x < size; ++x) {
                sum += at(x, y);
                CHECK(at(x, y) == doctest::Approx(at(size - 1 - x, y)).epsilon(1e-5));
                CHECK(at(x, y) == doctest::Approx(at(x, size - 1 - y)).epsilon(1e-5));
                CHECK(at(x, y) == doctest::Approx(at(y, x)).epsilon(1e-5));
                CHECK(at(x, y) > 0);
            }
        CHECK(sum == doctest::Approx(1000).epsilon(1e-5));
        for (std::uint32_t x = 1; x <= size / 2; ++x) CHECK(at(x, size / 2) > at(x - 1, size / 2));
    }
}

namespace {

/// Slow, obvious Life on one flat board. Cells outside the board are dead.
std::vector<bool> next_generation(std::vector<bool> const& board, int width, int height)
{
    std::vector<bool> next(board.size());
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            int neighbours = 0;
            for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v)
                for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u)
                    neighbours += (u != x || v != y) && board[static_cast<std::size_t>(v * width + u)];
            auto const i = static_cast<std::size_t>(y * width + x);
            next[i] = neighbours == 3 || (board[i] && neighbours == 2);
        }
    return next;
}

template <class M>
std::vector<bool> board_of(M& mesh)
{
    auto const grid = mesh.grid();
    std::vector<bool> board;
    for (std::uint32_t y = 0; y < 8 * grid.height; ++y)
        for (std::uint32_t x = 0; x < 8 * grid.width; ++x)
            board.push_back((mesh.template state<Patch>(TileId::at(x / 8, y / 8)).row[y % 8] >> x % 8 & 1u) != 0);
    return board;
}

} // namespace

TEST_CASE("life: a random board is that of a flat one, generation by generation")
{
    Grid const grid{5, 3};
    std::vector<bool> board;
    auto const load = [&](auto& mesh) {
        Random random{42};
        for (std::uint32_t i = 0; i < grid.size(); ++i)
            for (auto& row : mesh.template state<Patch>(grid.tile(i)).row) row = random.bits() & 0xffu;
        board = board_of(mesh);
    };
    Mesh<Generation> mesh{{}, grid, {.threads = 2}};
    load(mesh);
    for (int i = 0; i < 30; ++i) {
        CAPTURE(i);
        mesh.run();
        board = next_generation(board, 40, 24);
        CHECK(board == board_of(mesh));
    }
    auto const life = everywhere<Generation>(grid, load, 5);
    CHECK(life.step(0).messages == grid.size() * 16);
    CHECK(life.step(1).messages == grid.size() * 2);
    CHECK(life.step(2).messages == 0);
    CHECK(life.step(2).exchanges == 0); // no tile sends, so there is no exchange
    CHECK(life.step(2).capacity_bytes == 0);
    CHECK(life.step(2).passes == 1);
}

TEST_CASE("bounce: one token, one tile a pass; idle tiles are not run")
{
    for (std::uint32_t throws : {0u, 1u, 2u, 7u, 100u}) {
        CAPTURE(throws);
        constexpr std::uint32_t width = 6;
        auto const bounce = everywhere<Bounce>({width, 3}, [&](auto& mesh) { mesh.template state<Ball>(TileId::at(2, 1)).throws = throws; });
        CHECK(bounce.step(0).passes == 1);
        CHECK(bounce.step(0).tile_runs == 18);
        CHECK(bounce.step(0).messages == (throws == 0 ? 0 : 1));
        CHECK(bounce.step(0).exchanges == (throws == 0 ? 0 : 1));
        CHECK(bounce.step(1).passes == throws);
        CHECK(bounce.step(1).tile_runs == throws); // one tile per pass
        CHECK(bounce.step(1).messages == (throws == 0 ? 0 : throws - 1));
        CHECK(bounce.step(1).exchanges == (throws == 0 ? 0 : throws - 1));
        CHECK(bounce.last().messages() == throws);

        // The token goes to the edge, returns once to the tile at the edge, and goes the other way.
        std::vector<std::uint32_t> visits(width, 0);
        std::uint32_t x = 2;
        bool east = true;
        for (std::uint32_t i = 0; i < throws; ++i) {
            if (east ? x + 1 < width : x > 0) x = east ? x + 1 : x - 1;
            else east = !east;
            ++visits[x];
        }
        for (std::uint32_t y = 0; y < 3; ++y)
            for (std::uint32_t i = 0; i < width; ++i) CHECK(bounce.mesh->state<Visits>(TileId::at(i, y)).count == (y == 1 ? visits[i] : 0));
    }
}

TEST_CASE("bounce across a machine of more tiles than a bitmap word, threads asleep in between")
{
    constexpr std::uint32_t width = 200;
    std::uint32_t const throws = fast() ? 200 : 500;
    auto const bounce = everywhere<Bounce, Bench>({width, 2}, [&](auto& mesh) {
        mesh.template state<Ball>(TileId::at(63, 1)).throws = throws;
        mesh.template state<Ball>(TileId::at(64, 0)).throws = throws / 2;
    });
    CHECK(bounce.step(1).passes == throws);
    CHECK(bounce.step(1).tile_runs == throws + throws / 2);
}

TEST_CASE("post: parcels from anywhere to anywhere arrive once, in as many supersteps as the farthest has to go")
{
    struct Sent {
        TileId from, to;
    };
    for (Grid const grid : {Grid{1, 1}, Grid{1, 7}, Grid{9, 1}, Grid{13, 11}}) {
        CAPTURE(grid.width);
        CAPTURE(grid.height);
        std::vector<Sent> sent;
        auto const load = [&](auto& mesh) {
            Random random{grid.size()};
            sent.clear();
            for (std::uint32_t i = 0; i < grid.size(); ++i) {
                auto outbox = mesh.template state<Outbox>(grid.tile(i));
                auto const n = random.below(33);
                for (std::uint32_t k = 0; k < n; ++k) {
                    auto const to = grid.tile(random.below(grid.size()));
                    auto const id = static_cast<std::uint32_t>(sent.size());
                    REQUIRE(outbox.try_push({id, to, {static_cast<float>(id), -1.0f}}));
                    sent.push_back({grid.tile(i), to});
                }
            }
        };
        auto const post = everywhere<Post, Bench>(grid, load);
        std::uint64_t hops = 0;
        std::uint32_t farthest = 0;
        for (auto const& s : sent) {
            hops += distance(s.from, s.to);
            farthest = std::max(farthest, distance(s.from, s.to));
        }
        CHECK(post.last().messages() == hops);
        CHECK(post.last().exchanges() == farthest);
        CHECK(post.step(1).passes == farthest);
        CHECK(post.step(0).live_bytes + post.step(1).live_bytes == hops * sizeof(Parcel));
        CHECK(post.step(0).capacity_bytes + post.step(1).capacity_bytes == std::uint64_t{16} * grid.size() * (2 + 4096 * 4) * farthest);
        std::set<std::uint32_t> arrived;
        std::uint32_t peak = 0;
        for (std::uint32_t i = 0; i < grid.size(); ++i) {
            auto const inbox = post.mesh->state<Inbox>(grid.tile(i));
            peak = std::max(peak, inbox.size());
            for (Parcel const& p : inbox) {
                CHECK(arrived.insert(p.id).second);
                REQUIRE(p.id < sent.size());
                CHECK(p.to == sent[p.id].to);
                CHECK(p.to == grid.tile(i));
                CHECK(p.contents[0] == static_cast<float>(p.id));
            }
            CHECK(post.mesh->state<Outbox>(grid.tile(i)).empty());
        }
        CHECK(arrived.size() == sent.size());
        REQUIRE(post.last().peaks.size() == 3);
        CHECK(post.last().peaks[0].region == "Outbox");
        CHECK(post.last().peaks[0].items == 0); // the list is empty at the end of every compute phase
        CHECK(post.last().peaks[0].capacity == 32);
        CHECK(post.last().peaks[1].region == "Inbox");
        CHECK(post.last().peaks[1].items == peak);
        CHECK(post.last().peaks[2].region == "Road");
        CHECK(post.last().peaks[2].capacity == 4096);
    }
}

TEST_CASE("sorting network: every row of 0s and 1s is sorted, and so every row (0-1 principle)")
{
    constexpr std::uint32_t width = 8, height = 256; // one row for each input of 8 bits
    auto const sorted = everywhere<SortRows, Bench>(
        {width, height},
        [](auto& mesh) {
            for (std::uint32_t y = 0; y < height; ++y)
                for (std::uint32_t x = 0; x < width; ++x) mesh.template state<Key>(TileId::at(x, y)).value = y >> x & 1u;
        },
        1, SortRows{{width}, {}});
    for (std::uint32_t y = 0; y < height; ++y) {
        auto const ones = static_cast<std::uint32_t>(__builtin_popcount(y));
        bool right = true;
        for (std::uint32_t x = 0; x < width; ++x) right = right && sorted.mesh->state<Key>(TileId::at(x, y)).value == (x >= width - ones ? 1u : 0u);
        CHECK(right);
    }
    // A row has 8 offers in an even phase, and 6 offers in an odd phase.
    CHECK(sorted.step(0).messages == height * (4 * 8 + 4 * 6));
    CHECK(sorted.step(1).messages == 0);
}

TEST_CASE("sorting network: random keys, rows of odd and even length and of one")
{
    for (std::uint32_t const width : {1u, 2u, 9u, 16u}) {
        Grid const grid{width, 5};
        std::vector<WordList> rows(grid.height);
        auto const load = [&](auto& mesh) {
            Random random{width};
            for (auto& row : rows) row.clear();
            for (std::uint32_t i = 0; i < grid.size(); ++i) {
                auto const value = random.bits();
                mesh.template state<Key>(grid.tile(i)).value = value;
                rows[i / width].push_back(value);
            }
        };
        auto const sorted = everywhere<SortRows>(grid, load, 1, SortRows{{width}, {}});
        for (std::uint32_t y = 0; y < grid.height; ++y) {
            std::sort(rows[y].begin(), rows[y].end());
            for (std::uint32_t x = 0; x < width; ++x) CHECK(sorted.mesh->state<Key>(TileId::at(x, y)).value == rows[y][x]);
        }
    }
}

TEST_CASE("digests tell machines apart: another start, another superstep, another place for the same word")
{
    auto const run = [](TileId at, float kelvin) {
        CheckedMesh<Heat> mesh{Heat{{3}}, {5, 4}, {.digest = true}};
        mesh.broadcast<Conductivity>().per_step = 0.125f;
        mesh.state<Cell>(at).kelvin = kelvin;
        return mesh.run().digests;
    };
    auto const a = run(TileId::at(1, 1), 8);
    REQUIRE(a.size() == 3);
    CHECK(a == run(TileId::at(1, 1), 8));
    CHECK(a[0] != a[1]);
    CHECK(a[1] != a[2]);
    auto const b = run(TileId::at(1, 1), 9), c = run(TileId::at(2, 1), 8);
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(a[i] != b[i]);
        CHECK(a[i] != c[i]);
    }
}

TEST_CASE("digests cover what is under way: two machines that differ in a message alone")
{
    auto const thrown = [](auto mesh, std::uint32_t throws) {
        mesh->template state<Ball>(TileId::at(1, 0)).throws = throws;
        return mesh->run().digests.at(0); // the ball is under way, and all states hold equal words
    };
    auto const checked = [] { return std::make_unique<CheckedMesh<Bounce>>(Bounce{}, Grid{3, 1}, CheckedMeshOptions{.digest = true}); };
    auto const threads = [] { return std::make_unique<Mesh<Bounce>>(Bounce{}, Grid{3, 1}, MeshOptions{.threads = 2, .digest = true}); };
    CHECK(thrown(checked(), 5) == thrown(checked(), 5));
    CHECK(thrown(checked(), 5) != thrown(checked(), 6));
    CHECK(thrown(threads(), 5) != thrown(threads(), 6));
}
