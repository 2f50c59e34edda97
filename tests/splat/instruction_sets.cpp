// test: without tsan
// Every instruction set that the processor has gives the same bits. What has no lanes is the judge.
#include "blended.hpp"
#include <tilemesh/splat/instruction_sets.hpp>
#include <tilemesh/splat/project_all.hpp>

#pragma GCC diagnostic ignored "-Wpsabi" // more lanes than the target has are passed between functions that vanish

using namespace tilemesh;
using namespace tilemesh::splat;
namespace inner = tilemesh::splat::detail;

namespace {
char const* name_of(InstructionSet set)
{
    return set == InstructionSet::avx512 ? "AVX-512" : set == InstructionSet::avx2 ? "AVX2" : "the compiler's";
}
/// Calls `look` for each set that the processor and the build have.
template <class Look>
void with_each_set(Look&& look)
{
    auto const before = instruction_set();
    for (auto const set : {InstructionSet::given, InstructionSet::avx2, InstructionSet::avx512}) {
        if (!use_instruction_set(set)) continue;
        INFO("instruction set: ", std::string(name_of(set)));
        CHECK(instruction_set() == set);
        look();
    }
    CHECK(use_instruction_set(before));
}
} // namespace

TEST_CASE("instruction sets: the compiler's is always there; a set that is not there is refused and changes nothing")
{
    auto const before = instruction_set();
    CHECK(use_instruction_set(InstructionSet::given));
    for (auto const set : {InstructionSet::avx2, InstructionSet::avx512}) {
        CHECK(use_instruction_set(InstructionSet::given));
        bool const taken = use_instruction_set(set);
        CHECK(instruction_set() == (taken ? set : InstructionSet::given));
        if (!taken) MESSAGE("not run, because the processor or the build does not have it: ", std::string(name_of(set)));
    }
    CHECK(use_instruction_set(before));
}

TEST_CASE("instruction sets: each blends the same bits and counts the same pairs, with depth and without")
{
    using Deep = WithDepth<FloatPixel>;
    Rules clamped;
    clamped.alpha_max = 0.99f;
    for (auto rules : {Rules{}, clamped})
        for (auto const arithmetic : {Arithmetic::precise, Arithmetic::fast}) {
            rules.arithmetic = arithmetic;
            support::SortedSplats const scene(support::varied(700, 81), support::lens(250, 131), rules);
            PixelRect const tile{3, 131, 2, 99}; // cuts blocks on all sides
            auto const stride = tile.x1 - tile.x0;
            auto const at = [&](std::uint32_t i) noexcept -> Splat const& { return scene.splats[i]; };
            // Lists that end below, at and above the lanes of each set and the size of a chunk.
            for (std::uint32_t const n : {0u, 1u, 4u, 7u, 8u, 9u, 16u, 17u, 127u, 129u, static_cast<std::uint32_t>(scene.splats.size())}) {
                INFO(n, " splats");
                REQUIRE(n <= scene.splats.size());
                std::vector<Deep> expected(std::size_t{stride} * (tile.y1 - tile.y0));
                auto const pairs = blend_tile<1>(tile, scene.camera, scene.rules, n, at, expected.data(), stride, Worker{0, 1});
                with_each_set([&] {
                    PairCount counts[6] = {}, plain_counts[6] = {};
                    std::vector<Deep> deep(expected.size());
                    std::vector<FloatPixel> plain(expected.size());
                    blend_whole_tile(tile, scene.camera, scene.rules, n, at, deep.data(), stride, counts, 6);
                    blend_whole_tile(tile, scene.camera, scene.rules, n, at, plain.data(), stride, plain_counts, 6);
                    std::size_t different = std::memcmp(deep.data(), expected.data(), deep.size() * sizeof(Deep)) != 0 ? 1 : 0;
                    for (std::size_t i = 0; i < plain.size(); ++i)
                        different += std::memcmp(plain[i].rgb, expected[i].colour.rgb, sizeof plain[i].rgb) != 0 ? 1 : 0;
                    CHECK(different == 0);
                    PairCount sum{};
                    for (auto const& c : counts) sum.evaluated += c.evaluated, sum.contributing += c.contributing;
                    CHECK(sum.evaluated == pairs.evaluated);
                    CHECK(sum.contributing == pairs.contributing);
                });
            }
        }
}

TEST_CASE("instruction sets: each projects the same bits, also of the records that lanes cannot compute")
{
    auto const camera = support::lens(640, 400);
    auto const view = make_view(camera, Rules{});
    auto const tiling = make_tiling(camera.width, camera.height, 32, 20);
    auto records = support::cloud(600, 82);
    for (auto& g : records) {
        auto const id = static_cast<std::uint32_t>(g.id);
        if (id % 7 == 0)
            for (float& q : g.rotation) q *= 1e20f; // its square is not a float
        if (id % 23 == 0) g.log_scale[1] = 40;
    }
    std::vector<Splat> expected;
    for (auto const& g : records) expected.push_back(project(g, view, tiling));
    with_each_set([&] {
        for (std::uint32_t n = 0; n <= records.size(); n += n < 40 ? 1 : 137) {
            INFO(n, " records");
            Splat guard{};
            guard.depth_key = 12345;
            std::vector<Splat> out(n + 1, guard);
            project_all(records.data(), n, view, tiling, out.data());
            CHECK(std::memcmp(&out[n], &guard, sizeof guard) == 0);
            CHECK(std::memcmp(out.data(), expected.data(), n * sizeof guard) == 0);
        }
    });
}
