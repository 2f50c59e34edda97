// Records of 32 and 16 bytes: what comes back, within which bounds, and what is refused.
#include "../../bench/common/compact.hpp"
#include "support.hpp"

using namespace tilemesh;
using namespace tilemesh::splat;

namespace {
Gaussian packed_32(Gaussian const& g)
{
    Compact32 packed;
    REQUIRE(try_pack(g, packed));
    return unpacked(packed);
}
Gaussian packed_16(Gaussian const& g, CompactBox const& box)
{
    Compact16 packed;
    REQUIRE(try_pack(g, box, packed));
    return unpacked(packed, box);
}
/// The sine of half the angle between two rotations: 0 for equal ones.
double turn_between(Gaussian const& a, Gaussian const& b)
{
    double dot = 0, aa = 0, bb = 0;
    for (int i = 0; i < 4; ++i) {
        dot += double{a.rotation[i]} * b.rotation[i];
        aa += double{a.rotation[i]} * a.rotation[i];
        bb += double{b.rotation[i]} * b.rotation[i];
    }
    return std::sqrt(std::max(0.0, 1 - dot * dot / (aa * bb)));
}
} // namespace

TEST_CASE("compact: every half comes back, ties go to even, larger numbers become the largest half")
{
    for (std::uint32_t bits = 0; bits < 0x7c00; ++bits) {
        CHECK(splat::detail::half_bits(splat::detail::half_value(bits)) == bits);
        CHECK(splat::detail::half_bits(-splat::detail::half_value(bits)) == (bits | 0x8000u));
    }
    CHECK(splat::detail::half_value(0x3c00) == 1.0f);
    CHECK(splat::detail::half_value(0x0001) == 0x1p-24f);
    CHECK(splat::detail::half_value(0x7bff) == 65504.0f);
    CHECK(splat::detail::half_bits(1.0f + 0x1p-11f) == 0x3c00); // in the middle of two: the even one
    CHECK(splat::detail::half_bits(1.0f + 3 * 0x1p-11f) == 0x3c02);
    CHECK(splat::detail::half_bits(0x1p-25f) == 0);
    CHECK(splat::detail::half_bits(1e30f) == 0x7bff);
    CHECK(splat::detail::half_bits(65519.0f) == 0x7bff);
}

TEST_CASE("compact: 32 bytes: id and mean are exact, the rest is within its step; packing twice changes nothing")
{
    for (auto const& g : support::cloud(2000, 5)) {
        auto const back = packed_32(g);
        CHECK(back.id == g.id);
        for (int k = 0; k < 3; ++k) {
            CHECK(back.mean_world[k] == g.mean_world[k]);
            CHECK(std::fabs(back.colour[k] - g.colour[k]) <= 0x1p-11f * std::fabs(g.colour[k]));
            CHECK(std::fabs(back.log_scale[k] - g.log_scale[k]) <= 0.51f * 20 / (k < 2 ? 2047 : 1023));
        }
        CHECK(std::fabs(back.opacity - g.opacity) <= 0.51f / 65535);
        CHECK(turn_between(back, g) < 0.0026); // 3 steps of 1.41 / 1022, and the fourth component
        Compact32 once, twice;
        REQUIRE(try_pack(g, once));
        REQUIRE(try_pack(back, twice));
        CHECK(std::memcmp(&once, &twice, 24) == 0); // all but rotation and scales
        CHECK(once.words[6] == twice.words[6]);
    }
}

TEST_CASE("compact: 16 bytes: the id is exact, the rest is within its step of the box")
{
    auto const map = support::cloud(2000, 6);
    auto const box = CompactBox::of(map.data(), static_cast<std::uint32_t>(map.size()));
    for (auto const& g : map) {
        auto const back = packed_16(g, box);
        CHECK(back.id == g.id);
        for (int k = 0; k < 3; ++k) {
            CHECK(std::fabs(back.mean_world[k] - g.mean_world[k]) <= 0.51f * box.mean_step);
            CHECK(std::fabs(back.log_scale[k] - g.log_scale[k]) <= 0.51f * box.scale_step);
            CHECK(std::fabs(std::sqrt(back.colour[k]) - std::sqrt(g.colour[k])) <= 0.51f * 2 / 127);
        }
        CHECK(std::fabs(back.opacity - g.opacity) <= 0.51f / 127);
        CHECK(turn_between(back, g) < 0.25);
    }
    // A cube of 2 x 32,767 units and scales of 63 steps: known words.
    CompactBox const known{{-10, 0, 0}, 2, -6, 0.125f};
    Gaussian g{{-10 + 2 * 5, 2 * 32767, 0}, {0, 1, 4}, 1, {1, 0, 0, 0}, {-6, -6 + 0.125f * 63, -6 + 0.125f}, GaussianId{0xabcdef}};
    Compact16 packed;
    REQUIRE(try_pack(g, known, packed));
    GaussianId const id = packed.id;
    CHECK(id == GaussianId{0xabcdefu});
    CHECK((packed.first | (packed.words[0] & 0x7fu) << 8) == 5);
    CHECK((packed.words[0] >> 7 & 0x7fffu) == 32767);
    auto const back = unpacked(packed, known);
    CHECK(back.mean_world[0] == 0);
    CHECK(back.colour[2] == 4);
    CHECK(back.colour[0] == 0);
    CHECK(back.opacity == 1);
    CHECK(back.rotation[0] == 1);
    CHECK(back.rotation[1] == 0);
    CHECK(back.log_scale[1] == -6 + 0.125f * 63);
}

TEST_CASE("compact: opacity 0 and 1, tiny and huge scales, quaternions of any length")
{
    auto g = support::ball(7, 1, 2);
    auto const box = CompactBox::of(&g, 1);
    for (float opacity : {0.0f, 1.0f}) {
        g.opacity = opacity;
        CHECK(packed_32(g).opacity == opacity);
        CHECK(packed_16(g, box).opacity == opacity);
    }
    g.log_scale[0] = -80, g.log_scale[1] = 8;
    CHECK(packed_32(g).log_scale[0] == -12);
    CHECK(packed_32(g).log_scale[1] == 8);
    for (float length : {1e-12f, 3.0f, 1e12f}) {
        g.rotation[0] = 0.5f * length, g.rotation[1] = -0.5f * length, g.rotation[2] = 0.5f * length, g.rotation[3] = -0.5f * length;
        CHECK(turn_between(packed_32(g), support::ball(1, 0, 0)) == doctest::Approx(std::sqrt(0.75)).epsilon(2e-3));
        CHECK(turn_between(packed_32(g), g) < 0.0026);
    }
}

TEST_CASE("compact: what is not finite, has no rotation or is outside the box is refused")
{
    auto const good = support::ball(7, 1, 2);
    auto const box = CompactBox::of(&good, 1);
    auto const refused = [&](auto const& change, bool only_16 = false) {
        auto g = good;
        change(g);
        Compact32 a;
        Compact16 b;
        return (only_16 || !try_pack(g, a)) && !try_pack(g, box, b);
    };
    CHECK_FALSE(refused([](Gaussian&) {}));
    using Limits = std::numeric_limits<float>;
    for (float bad : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()}) {
        CHECK(refused([&](Gaussian& g) { g.mean_world[1] = bad; }));
        CHECK(refused([&](Gaussian& g) { g.colour[2] = bad; }));
        CHECK(refused([&](Gaussian& g) { g.opacity = bad; }));
        CHECK(refused([&](Gaussian& g) { g.rotation[3] = bad; }));
        CHECK(refused([&](Gaussian& g) { g.log_scale[0] = bad; }));
    }
    CHECK(refused([](Gaussian& g) { g.rotation[0] = 0; }));
    CHECK(refused([](Gaussian& g) { g.log_scale[2] = 100.0f; }));
    CHECK(refused([](Gaussian& g) { g.mean_world[0] += 1e6f; }, true));
    CHECK(refused([](Gaussian& g) { g.id = GaussianId{1u << 24}; }, true));
}
