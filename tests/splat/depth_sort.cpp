// test: unoptimised asan, without tsan
#include "runner.hpp"

using namespace tilemesh::splat;

TEST_CASE("heap sort: every order of small inputs, and the hard ones")
{
    for (std::uint32_t n = 0; n <= 7; ++n) {
        std::vector<std::uint32_t> permutation(n);
        for (std::uint32_t i = 0; i < n; ++i) permutation[i] = i;
        do {
            auto keys = permutation;
            tilemesh::splat::detail::heap_sort(keys.data(), n);
            CHECK(std::is_sorted(keys.begin(), keys.end()));
        } while (std::next_permutation(permutation.begin(), permutation.end()));
    }
    support::Random random(5);
    for (std::uint32_t n : {8u, 100u, 3200u})
        for (int kind = 0; kind < 4; ++kind) {
            std::vector<SortKey> keys;
            for (std::uint32_t i = 0; i < n; ++i)
                keys.push_back({kind == 0 ? random.bits() : kind == 1 ? i : kind == 2 ? n - i : 7u, GaussianId{n - i}, i});
            auto expected = keys;
            std::sort(expected.begin(), expected.end());
            tilemesh::splat::detail::heap_sort(keys.data(), n);
            for (std::uint32_t i = 0; i < n; ++i) CHECK(keys[i].slot == expected[i].slot);
        }
}

TEST_CASE("heap sort: at most 2 n log2 n compares, sorted or equal input included")
{
    struct Counted {
        std::uint32_t value;
        std::uint64_t* compares;
        bool operator<(Counted const& other) const
        {
            ++*compares;
            return value < other.value;
        }
    };
    for (int kind = 0; kind < 3; ++kind) {
        std::uint64_t compares = 0;
        std::vector<Counted> keys;
        for (std::uint32_t i = 0; i < 3200; ++i) keys.push_back({kind == 0 ? i : kind == 1 ? 3200 - i : 1, &compares});
        tilemesh::splat::detail::heap_sort(keys.data(), 3200u);
        CHECK(compares <= 2 * 3200 * 12);
    }
}

TEST_CASE("repair: every kind of list is sorted, with any room behind it, and nothing is written beyond the room")
{
    support::Random random(8);
    constexpr auto fewest = tilemesh::splat::detail::fewest_by_digits;
    for (std::uint32_t n : {0u, 1u, 2u, 5u, 100u, fewest - 1, fewest, fewest + 1, 3200u})
        for (std::uint32_t listed : {0u, n / 4, n - n / 4, n - std::min(n, 4u), n - std::min(n, 5u), n})
            for (std::uint32_t room : {n, 2 * n - listed, 2 * n - std::min(n, 1u), 2 * n})
                for (int kind = 0; kind < 8; ++kind) {
                    std::vector<SortKey> keys;
                    for (std::uint32_t i = 0; i < n; ++i) {
                        std::uint32_t const any = random.bits();
                        std::uint32_t const depth = kind == 0   ? any              // any depths
                                                    : kind == 1 ? 0x40000000u + any % 300000 // depths that are close
                                                    : kind == 2 ? n - i            // the reverse order
                                                    : kind == 3 ? any % 3          // few depths, ids in order
                                                    : kind == 4 ? 7                // one depth, ids in the reverse order
                                                    : kind == 5 ? 16 * i + any % 32 // a few places off
                                                    : kind == 6 ? (i % 2 == 0 ? 0u : ~0u)
                                                                : i;               // in order, ids too
                        keys.push_back({depth, GaussianId{kind == 4 ? n - i : i + 1}, i});
                    }
                    if (kind != 2 && kind != 4 && kind != 6) std::sort(keys.begin(), keys.begin() + listed);
                    auto expected = keys;
                    std::sort(expected.begin(), expected.end());
                    SortKey const guard{12345, GaussianId{67}, 89};
                    keys.resize(room + 1, guard);
                    keys[room] = guard;
                    tilemesh::splat::detail::repair(keys.data(), listed, n, room);
                    std::uint32_t wrong = keys[room].slot != guard.slot ? 1 : 0;
                    for (std::uint32_t i = 0; i < n; ++i) wrong += keys[i].slot != expected[i].slot ? 1 : 0;
                    INFO(n, " keys, ", listed, " listed, room ", room, ", kind ", kind);
                    CHECK(wrong == 0);
                }
}

TEST_CASE("sort keys: depth first, then id; bits of positive floats order as the floats do")
{
    CHECK(SortKey{1, GaussianId{9}, 0} < SortKey{2, GaussianId{1}, 0});
    CHECK(SortKey{2, GaussianId{1}, 5} < SortKey{2, GaussianId{2}, 0});
    CHECK_FALSE(SortKey{2, GaussianId{2}, 0} < SortKey{2, GaussianId{2}, 9});
    support::Random random(6);
    for (int i = 0; i < 1000; ++i) {
        float const a = random.uniform(0.2f, 100), b = random.uniform(0.2f, 100);
        CHECK((a < b) == (__builtin_bit_cast(std::uint32_t, a) < __builtin_bit_cast(std::uint32_t, b)));
    }
}

TEST_CASE("depth ties: ids order them, in whatever order records were loaded, and in the slots of records that left")
{
    auto gaussians = support::cloud(300, 12);
    for (auto& g : gaussians) g.mean_world[2] = 2; // all at one depth, so only ids order them
    for (bool const reversed : {false, true}) {
        if (reversed) std::reverse(gaussians.begin(), gaussians.end());
        auto camera = support::lens(90, 60);
        auto const runner =
            support::make_runner<support::Whole>(support::map_of(gaussians), {.grid = {3, 3}, .sizes = support::sized<support::Whole>(8, 400)});
        for (int step = 0; step < 8; ++step, camera.position[0] += 0.2f) { // records cross tiles: slots are left and taken again
            auto const frame = runner->render(camera);
            CHECK(frame.report.lost.empty());
            CHECK(support::differing_pixels(frame.image, tilemesh::report::render_naive(gaussians, camera, Rules{})) == 0);
        }
    }
}
