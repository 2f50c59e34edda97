// test: without test asan tsan, cost 20
// References instead of values, as references.cpp: other policies, and programs without a part.
#include "references.hpp"

using namespace tilemesh;
using support::compare, support::path;

namespace {
scene::Map cloud_map(std::uint32_t n = 400, std::uint64_t seed = 21) { return support::map_of(support::cloud(n, seed)); }
/// A cloud with harmonics up to `degree`.
scene::Map shaded_cloud(std::uint32_t n, std::uint64_t seed, std::uint32_t degree)
{
    auto map = cloud_map(n, seed);
    map.sh_degree = degree;
    support::Random random(seed);
    map.harmonics.resize(std::size_t{3} * splat::harmonics_per_channel(degree) * n);
    for (float& v : map.harmonics) v = random.uniform(-0.3f, 0.3f);
    return map;
}
} // namespace

TEST_CASE("references: pairwise, hold or drop, world or screen, carried or recomputed, floats or bytes, planes, harmonics")
{
    using namespace support;
    std::uint64_t lost = 0;
    auto const check = [&]<class S>(S, scene::Map const& map) {
        lost += compare<S>(map, {.grid = {7, 6}}, path()).lost.size();
        lost += compare<S>(map, {.grid = {7, 6}, .channel_slots = 2}, path()).lost.size();
        lost += compare<S>(map, {.grid = {7, 6}, .storage_slots = 22}, path()).lost.size();
    };
    check(Room<DropBase>{}, cloud_map(500, 31));
    check(Screens{}, cloud_map(500, 31));
    check(Planes{}, cloud_map(500, 31));
    check(BytesAndPlanes{}, cloud_map(500, 31));
    check(DropScreens{}, shaded_cloud(500, 78, 3));
    check(ShadedScreens{}, shaded_cloud(500, 77, 3));
    check(Shaded{}, shaded_cloud(500, 77, 3));
    check(Shaded{}, shaded_cloud(500, 79, 1)); // coefficients that the map does not have are zero
    CHECK(lost > 0);
}

TEST_CASE("references: without routing, without bloom, with neither")
{
    using namespace support;
    compare<NoRouting>(cloud_map(), {.grid = {7, 6}}, path());
    compare<NoRouting>(cloud_map(), {.grid = {7, 6}, .storage_slots = 20}, path());
    compare<NoBloom>(cloud_map(), {.grid = {7, 6}}, path());
    compare<Minimal>(cloud_map(), {.grid = {7, 6}}, path());
    compare<Minimal>(cloud_map(), {.grid = {1, 1}}, path());
    std::vector<splat::Camera> turning;
    for (float turn : {0.1f, 0.5f, 0.5f, -0.4f, -0.4f, -0.4f, 0.2f}) turning.push_back(support::lens(96, 80, turn));
    for (std::uint32_t hops : {1u, 2u}) compare<NoRouting>(cloud_map(), {.grid = {6, 5}, .hops = hops}, turning);
}
