// test: unoptimised test asan
// The threads of a mesh share work, take work from each other, and sleep. Also: sets of tiles.
#include "everywhere.hpp"
#include "programs.hpp"
#include <atomic>
#include <chrono>
#include <tilemesh/engine/team.hpp>
#include <tilemesh/engine/tile_set.hpp>

using namespace engine_test;
using engine::detail::Shares;
using engine::detail::Team;
using engine::detail::TileSet;

namespace {

/// How often the threads of the team took each of n items.
std::vector<int> taken(Team& team, Shares& shares, std::uint32_t n)
{
    std::vector<std::atomic<int>> count(n);
    shares.set(n);
    team.share([&](std::uint32_t w) noexcept {
        for (std::uint32_t first = 0, last = 0; shares.take(w, first, last);)
            for (auto i = first; i < last; ++i) ++count[i];
    });
    return std::vector<int>(count.begin(), count.end());
}

} // namespace

TEST_CASE("each item is taken once, by any number of threads, whoever comes")
{
    for (std::uint32_t threads : {1u, 2u, 3u, 8u}) {
        CAPTURE(threads);
        Team team{threads};
        CHECK(team.size() == threads);
        Shares shares{threads};
        for (int again = 0; again < (fast() ? 20 : 200); ++again)
            for (std::uint32_t n : {0u, 1u, 2u, 7u, 8u, 9u, 64u, 1440u})
                REQUIRE(taken(team, shares, n) == std::vector<int>(n, 1));
    }
}

TEST_CASE("one thread alone takes what the others leave, in pieces that end with single items")
{
    for (std::uint32_t threads : {1u, 2u, 5u})
        for (std::uint32_t w = 0; w < threads; ++w)
            for (std::uint32_t n : {1u, 5u, 100u, 1441u}) {
                CAPTURE(n);
                Shares shares{threads};
                shares.set(n);
                std::vector<int> count(n, 0);
                std::uint32_t last_size = 0, largest = 0, first = 0, last = 0;
                while (shares.take(w, first, last)) {
                    REQUIRE(first < last);
                    REQUIRE(last <= n);
                    for (auto i = first; i < last; ++i) ++count[i];
                    last_size = last - first;
                    largest = std::max(largest, last_size);
                }
                CHECK(count == std::vector<int>(n, 1));
                CHECK(last_size == 1);
                CHECK(largest <= (n / threads + 1 + 7) / 8); // pieces are small, because no other thread can take items of a piece
                CHECK_FALSE(shares.take(w, first, last));
            }
}

TEST_CASE("each() runs on every thread once, also on those that sleep")
{
    for (std::uint32_t threads : {1u, 2u, 8u}) {
        Team team{threads};
        std::vector<int> count(threads, 0);
        for (int i = 1; i <= 30; ++i) {
            if (i % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5)); // long enough for the threads to fall asleep
            team.each([&](std::uint32_t w) noexcept { ++count[w]; });
            REQUIRE(count == std::vector<int>(threads, i));
        }
    }
}

TEST_CASE("on_threads: each of the mesh's threads once, before, between and after runs")
{
    on_each<Post, Bench>({6, 5}, [](auto& mesh) {
        std::vector<int> count;
        auto const one_each = [&] {
            std::atomic<std::uint32_t> threads{0};
            count.assign(8, 0);
            mesh.on_threads([&](std::uint32_t thread, std::uint32_t n) {
                ++count.at(thread);
                threads = n;
            });
            for (std::uint32_t i = 0; i < 8; ++i) CHECK(count[i] == (i < threads ? 1 : 0));
            return threads.load();
        };
        auto const threads = one_each();
        mesh.run();
        CHECK(one_each() == threads);
        CHECK(mesh.run().steps[0].passes == 1);
        CHECK(one_each() == threads);
    });
}

TEST_CASE("on_threads throws what the lowest thread threw, and the mesh runs on")
{
    for (auto threads : thread_counts) {
        Mesh<Post, Bench> mesh{{}, {6, 5}, {.threads = threads}};
        mesh.template state<Outbox>(TileId::at(0, 0)).push({1, TileId::at(5, 4), {}});
        auto const fails = [&](std::uint32_t from) {
            mesh.on_threads([&](std::uint32_t thread, std::uint32_t) {
                if (thread >= from) throw std::out_of_range(std::to_string(thread));
            });
        };
        CHECK_THROWS_WITH_AS(fails(0), "0", std::out_of_range);
        if (threads > 2) CHECK_THROWS_WITH_AS(fails(1), "1", std::out_of_range);
        CHECK_NOTHROW(fails(threads));
        mesh.run();
        CHECK(mesh.template state<Inbox>(TileId::at(5, 4)).size() == 1);
    }
    CheckedMesh<Post, Bench> checked{{}, {6, 5}};
    CHECK_THROWS_WITH_AS(checked.on_threads([](std::uint32_t, std::uint32_t) { throw std::out_of_range("it"); }), "it",
                         std::out_of_range);
}

TEST_CASE("a set of tiles is a set, at the edges of its words and groups of words")
{
    Random random{11};
    for (std::uint32_t tiles : {1u, 63u, 64u, 65u, 4095u, 4096u, 4097u, 300'000u}) {
        CAPTURE(tiles);
        TileSet set(tiles), other(tiles);
        std::vector<std::uint32_t> out(tiles);
        for (int again = 0; again < 20; ++again) {
            std::set<std::uint32_t> want;
            auto const from = random.below(tiles), to = std::min(tiles, from + random.below(again % 2 == 0 ? 20 : 300));
            set.insert(from, to);
            for (auto t = from; t < to; ++t) want.insert(t);
            auto const n = random.below(50);
            for (std::uint32_t i = 0; i < n; ++i) {
                auto const t = i == 0 ? tiles - 1 : i == 1 ? 0 : random.below(tiles);
                (i % 3 == 0 ? set : other).insert(t);
                want.insert(t);
            }
            CHECK((set.empty() && other.empty()) == want.empty());
            set.take(other);
            CHECK(other.empty());
            if (again % 4 == 3) {
                set.clear();
                want.clear();
            }
            auto const listed = set.list(out.data());
            REQUIRE(std::vector<std::uint32_t>(out.begin(), out.begin() + listed) ==
                    std::vector<std::uint32_t>(want.begin(), want.end()));
            CHECK(set.empty());
            CHECK(set.list(out.data()) == 0);
        }
    }
}

namespace {

/// A wave from one corner: few tiles run, then many, then few.
struct Reached {
    std::uint32_t distance; ///< 0: the wave has not come yet
    std::uint32_t told;     ///< 1: the tile has told its neighbours
};
struct Front : Channel<std::uint32_t, 1> {};
struct Start {
    Vote operator()(Reached& reached, Here here) const noexcept
    {
        reached = {here.tile == TileId::at(0, 0) ? 1u : 0u, 0};
        return reached.distance != 0 ? Vote::busy : Vote::quiet;
    }
};
struct Spread {
    void operator()(Reached& reached, In<Front> in, Out<Front> out) const noexcept
    {
        for (Direction d : news)
            for (auto from : in[d])
                if (reached.distance == 0) reached.distance = from + 1;
        if (reached.distance == 0 || reached.told != 0) return;
        for (Direction d : news) out[d].push(reached.distance);
        reached.told = 1;
    }
};
using Wave = Sequence<Superstep<Start>, UntilQuiet<Spread>, Superstep<Start>, UntilQuiet<Spread>>;

} // namespace

TEST_CASE("a wave that grows from one tile and dies in one: as many supersteps alone as together, and equal counters")
{
    Grid const grid{40, 9};
    auto const p = everywhere<Wave>(grid, [](auto&) {}, 2);
    for (std::uint32_t i = 0; i < grid.size(); ++i) {
        auto const t = grid.tile(i);
        CHECK(p.mesh->state<Reached>(t).distance == t.x() + t.y() + 1);
    }
    CHECK(p.step(1).passes >= 40 + 9 - 1);
}
