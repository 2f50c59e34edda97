// test: without tsan
#include "support.hpp"
#include <cmath>
#include <cstdint>
#include <cstring>
#include <doctest/doctest.h>
#include <tilemesh/splat/instruction_sets.hpp>
#include <tilemesh/splat/pose/rows.hpp>
#include <vector>

#pragma GCC diagnostic ignored "-Wpsabi" // more lanes than the target has are passed between functions that vanish

using namespace tilemesh;
using namespace tilemesh::splat;

namespace {
std::int64_t number(pose::Wide w)
{
    return static_cast<std::int64_t>(std::uint64_t{w.high} << 32 | w.low);
}
double value(pose::Wide w, float scale)
{
    return static_cast<double>(number(w)) / double{scale};
}
/// Powers of two as the host chooses them, for a clip of 64.
pose::SumRules rules()
{
    constexpr float clip = 64;
    return {1.0f, 0.0f, 0.1f, 0.05f, 1.0f, 16.0f, clip, 0x1p23f / (4 * clip * clip), 0x1p23f / (0.5f * clip), 0x1p21f};
}
/// Random rows. Some are beyond the clip, some beyond the Huber widths, some do not count.
pose::CellRows random_rows(support::Random& random)
{
    pose::CellRows rows{};
    for (std::uint32_t i = 0; i < block_width; ++i) {
        rows.counted[i] = random.below(4) == 0 ? 0.0f : 1.0f;
        rows.depth_counted[i] = rows.counted[i] > 0 && random.below(3) != 0 ? 1.0f : 0.0f;
        float const size = random.below(5) == 0 ? 400.0f : 60.0f;
        for (std::uint32_t c = 0; c < pose::CellRows::channels; ++c) {
            bool const counts = (c < 3 ? rows.counted : rows.depth_counted)[i] > 0;
            rows.residual[c][i] = counts ? random.uniform(-0.3f, 0.3f) : 0.0f;
            for (auto& column : rows.motion[c]) column[i] = counts ? random.uniform(-size, size) : 0.0f;
            if (c < 3) rows.gained[c][i] = counts ? random.uniform(0.0f, 1.0f) : 0.0f;
        }
    }
    return rows;
}
/// The same sums in double, without lanes.
struct Expected {
    double h[8][8] = {}, g[8] = {}, cost = 0;
    std::uint32_t cells = 0;

    void add(pose::CellRows const& rows, pose::SumRules const& r, std::uint32_t unknowns)
    {
        for (std::uint32_t i = 0; i < block_width; ++i) {
            cells += rows.counted[i] > 0 ? 1 : 0;
            for (std::uint32_t c = 0; c < 4; ++c) {
                if (!((c < 3 ? rows.counted : rows.depth_counted)[i] > 0)) continue;
                double j[8], most = 0, const_width = c < 3 ? r.huber_colour : r.huber_depth;
                for (std::uint32_t k = 0; k < 6; ++k) j[k] = rows.motion[c][k][i];
                j[6] = c < 3 ? double{rows.gained[c][i]} * r.exposure_unit : 0, j[7] = c < 3 ? r.exposure_unit : 0;
                for (std::uint32_t k = 0; k < unknowns; ++k) most = std::fmax(most, std::fabs(j[k]));
                double const e = std::fabs(rows.residual[c][i]);
                double w = e <= const_width ? 1 : const_width / e;
                cost += e <= const_width ? 0.5 * e * e : const_width * (e - 0.5 * const_width);
                if (most > r.clip) w *= r.clip / most * r.clip / most;
                for (std::uint32_t a = 0; a < unknowns; ++a) {
                    g[a] += w * j[a] * rows.residual[c][i];
                    for (std::uint32_t b = 0; b <= a; ++b) h[a][b] += w * j[a] * j[b];
                }
            }
        }
    }
};
template <std::uint32_t Lanes, std::uint32_t Unknowns>
pose::Totals totals_of(std::vector<pose::CellRows> const& all, bool backwards)
{
    pose::LaneSums sums{};
    pose::Totals totals{};
    for (std::size_t i = 0; i < all.size(); ++i) {
        splat::detail::GivenSet<Lanes>::template call<pose::detail::AddRows<Unknowns>>(all[backwards ? all.size() - 1 - i : i], rules(), sums);
        if (i % 5 == 4 || i + 1 == all.size()) pose::take_sums(sums, Unknowns, totals);
    }
    return totals;
}
template <std::uint32_t Unknowns>
void check_sums()
{
    support::Random random(Unknowns);
    std::vector<pose::CellRows> all;
    Expected expected;
    for (int i = 0; i < 203; ++i) {
        all.push_back(random_rows(random));
        expected.add(all.back(), rules(), Unknowns);
    }
    auto const totals = totals_of<16, Unknowns>(all, false);
    for (auto const& other : {totals_of<8, Unknowns>(all, false), totals_of<4, Unknowns>(all, false), totals_of<16, Unknowns>(all, true)})
        CHECK(std::memcmp(&totals, &other, sizeof totals) == 0);
    auto const r = rules();
    CHECK(totals.cells == expected.cells);
    double const cells = totals.cells;
    CHECK(value(totals.cost, r.cost_scale) == doctest::Approx(expected.cost).epsilon(1e-5));
    for (std::uint32_t a = 0, at = 0; a < Unknowns; ++a) {
        CHECK(std::fabs(value(totals.g[a], r.g_scale) - expected.g[a]) < 1e-4 + cells / double{r.g_scale});
        for (std::uint32_t b = 0; b <= a; ++b, ++at)
            CHECK(std::fabs(value(totals.h[at], r.h_scale) - expected.h[a][b]) < 1e-6 * expected.h[a][a] + cells / double{r.h_scale});
    }
    // A clipped row keeps its direction, so no sum of rows has a negative square.
    for (std::uint32_t a = 0, at = 0; a < Unknowns; at += a + 2, ++a) CHECK(number(totals.h[at]) >= 0);
}
} // namespace

TEST_CASE("pose sums: two words with a carry are an integer of 64 bits, whatever the order")
{
    support::Random random(1);
    pose::Wide w{}, backwards{};
    std::int64_t sum = 0;
    std::vector<std::int32_t> terms;
    for (int i = 0; i < 20000; ++i) {
        auto const v = static_cast<std::int32_t>(random.bits()) >> random.below(31);
        terms.push_back(i % 3 == 0 ? std::abs(v >> 1) : v >> 1);
        w.add(terms.back());
        sum += terms.back();
        REQUIRE(number(w) == sum);
    }
    pose::Wide half[2] = {};
    for (std::size_t i = terms.size(); i-- > 0;) half[i % 2].add(terms[i]);
    backwards = half[0] + half[1];
    CHECK(number(backwards) == sum);
    CHECK(sum > std::int64_t{1} << 32); // the high word took part
}

TEST_CASE("pose sums: Huber's weight, the clip of whole rows and the units agree with double; equal bits for 4, 8, 16 lanes and any order")
{
    check_sums<6>();
    check_sums<8>();
}

TEST_CASE("pose sums: cells are the means of the pixels that count, and have a depth if more than half of these do")
{
    support::Random random(9);
    auto const rows = random_rows(random), more = random_rows(random);
    for (std::uint32_t cell : {2u, 4u, 8u}) {
        pose::OpenCells open;
        open.clear();
        open.add(rows, cell);
        open.add(more, cell);
        open.close();
        for (std::uint32_t i = 0; i < block_width; ++i) {
            double n = 0, deep = 0, residual = 0, motion = 0, of_depth = 0;
            for (std::uint32_t k = i * cell; i < block_width / cell && k < (i + 1) * cell; ++k)
                for (auto const* r : {&rows, &more}) {
                    n += r->counted[k], deep += r->depth_counted[k];
                    residual += r->residual[1][k], motion += r->motion[2][4][k], of_depth += r->motion[3][5][k];
                }
            CHECK(open.sum.counted[i] == (n > 0 ? 1.0f : 0.0f));
            CHECK(open.sum.depth_counted[i] == (n > 0 && 2 * deep > n ? 1.0f : 0.0f));
            if (n > 0) CHECK(open.sum.residual[1][i] == doctest::Approx(residual / n).epsilon(1e-5));
            if (n > 0) CHECK(open.sum.motion[2][4][i] == doctest::Approx(motion / n).epsilon(1e-4));
            if (n > 0 && 2 * deep > n) CHECK(open.sum.motion[3][5][i] == doctest::Approx(of_depth / deep).epsilon(1e-4));
        }
    }
}
