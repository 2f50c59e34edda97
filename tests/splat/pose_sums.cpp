// test: without tsan
#include "support.hpp"
#include <tilemesh/splat/instruction_sets.hpp>
#include <tilemesh/splat/pose/rows.hpp>
#include <tilemesh/splat/pose/tile.hpp>

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

namespace {
/// Rows in which one cell has one row; channel 3 is the depth.
pose::CellRows one_row(std::uint32_t channel, float residual, std::initializer_list<float> motion, float gained = 0)
{
    pose::CellRows rows{};
    rows.counted[5] = 1;
    rows.depth_counted[5] = channel == 3 ? 1.0f : 0.0f;
    rows.residual[channel][5] = residual;
    if (channel < 3) rows.gained[channel][5] = gained;
    std::uint32_t k = 0;
    for (float v : motion) rows.motion[channel][k++][5] = v;
    return rows;
}
template <std::uint32_t Unknowns>
pose::Totals totals_of(pose::CellRows const& rows)
{
    return totals_of<4, Unknowns>({rows}, false);
}
} // namespace

TEST_CASE("pose sums: known answers of one row: Huber's weight, the clip, depth, exposure columns")
{
    auto const r = rules(); // Huber 0.1 and 0.05, clip 64, exposure in units of 16
    auto const h = [&](pose::Totals const& t, std::uint32_t a, std::uint32_t b) { return value(t.h[a * (a + 1) / 2 + b], r.h_scale); };
    auto const g = [&](pose::Totals const& t, std::uint32_t a) { return value(t.g[a], r.g_scale); };
    auto const near = [](double v) { return doctest::Approx(v).epsilon(1e-4); };
    SUBCASE("inside Huber's width")
    {
        auto const t = totals_of<6>(one_row(0, -0.0625f, {1, 2, 0, -3, 0, 4}));
        CHECK(t.cells == 1);
        CHECK(h(t, 0, 0) == 1);
        CHECK(h(t, 3, 1) == -6);
        CHECK(h(t, 5, 3) == -12);
        CHECK(h(t, 2, 2) == 0);
        CHECK(g(t, 3) == 0.1875);
        CHECK(g(t, 5) == -0.25);
        CHECK(value(t.cost, r.cost_scale) == 0.001953125);
    }
    SUBCASE("beyond Huber's width: half the weight at twice the width, on both sides")
    {
        for (float sign : {1.0f, -1.0f}) {
            auto const t = totals_of<6>(one_row(2, sign * 0.2f, {0, 0, 8}));
            CHECK(h(t, 2, 2) == near(32));
            CHECK(g(t, 2) == near(double{sign} * 0.8));
            CHECK(value(t.cost, r.cost_scale) == near(0.1 * 0.15));
        }
    }
    SUBCASE("a depth has its own width")
    {
        auto const t = totals_of<6>(one_row(3, 0.1f, {0, 4}));
        CHECK(t.cells == 1);
        CHECK(h(t, 1, 1) == near(8));
        CHECK(value(t.cost, r.cost_scale) == near(0.05 * 0.075));
    }
    SUBCASE("a row at the clip keeps its weight, a row at twice the clip is half as long")
    {
        CHECK(h(totals_of<6>(one_row(0, 0, {64, 32})), 0, 0) == 4096);
        auto const t = totals_of<6>(one_row(0, 0.0625f, {-128, 32}));
        CHECK(h(t, 0, 0) == 4096);
        CHECK(h(t, 1, 0) == -1024);
        CHECK(h(t, 1, 1) == 256);
        CHECK(g(t, 0) == -2);
        CHECK(value(t.cost, r.cost_scale) == 0.001953125); // the clip does not change the cost
    }
    SUBCASE("sums are rounded to the nearest unit, not towards 0")
    {
        auto const t = totals_of<6>(one_row(0, 0, {0.0375f, -0.0375f, 0.03f})); // 0.72, 0.576 and 0.46 of a unit
        CHECK(number(t.h[0]) == 1);
        CHECK(number(t.h[1]) == -1);
        CHECK(number(t.h[3]) == 1);
        CHECK(number(t.h[5]) == 0);
    }
    SUBCASE("gain and offset are columns of the colours, and none of the depth")
    {
        auto const t = totals_of<8>(one_row(1, 0.0625f, {2}, 0.5f));
        // The other two colours of the cell have no motion, but the offset is a column of each.
        CHECK(h(t, 6, 0) == 2 * 8);
        CHECK(h(t, 7, 0) == 2 * 16);
        CHECK(h(t, 6, 6) == 64);
        CHECK(h(t, 7, 6) == 128);
        CHECK(h(t, 7, 7) == 3 * 256);
        CHECK(g(t, 7) == 1);
        auto depth = one_row(3, 0.03125f, {2});
        auto const d = totals_of<8>(depth);
        CHECK(h(d, 0, 0) == 4);
        CHECK(h(d, 6, 6) == 0);
        CHECK(h(d, 7, 0) == 0);
        CHECK(g(d, 7) == 0);
    }
}

TEST_CASE("pose sums: a frame of 1280 x 720 of the largest rows overflows nothing; no rows are 0; what does not count is not read")
{
    // The largest sums: each entry is at the clip, and each residual at Huber's width.
    auto r = rules();
    r.cost_scale = 0x1p21f;
    std::uint32_t const cells_a_row = block_width, rows_a_frame = 1280 * 720 / block_width;
    for (float sign : {1.0f, -1.0f})
        for (bool beyond : {false, true}) { // a residual far beyond any width, and the largest rows that a target can cause
            pose::CellRows rows{};
            for (std::uint32_t i = 0; i < block_width; ++i) {
                rows.counted[i] = rows.depth_counted[i] = 1;
                for (std::uint32_t c = 0; c < 4; ++c) {
                    rows.residual[c][i] = sign * (beyond ? 9e17f : c < 3 ? r.huber_colour : r.huber_depth);
                    for (auto& column : rows.motion[c]) column[i] = beyond ? 9e17f : r.clip;
                    if (c < 3) rows.gained[c][i] = 1;
                }
            }
            pose::LaneSums sums{};
            pose::Totals totals{};
            std::int64_t cell_h = 0, cell_g = 0, cell_cost = 0;
            for (std::uint32_t i = 0; i < rows_a_frame; ++i) {
                splat::detail::GivenSet<16>::call<pose::detail::AddRows<8>>(rows, r, sums);
                if (i == 0) cell_h = sums.field[0][3], cell_g = sums.field[36][3], cell_cost = sums.field[44][3];
                if (i % 5 == 4) pose::take_sums(sums, 8, totals);
            }
            CHECK(std::abs(cell_h) <= 1 << 23);
            CHECK(std::abs(cell_g) <= 1 << 23);
            CHECK(cell_cost <= 1 << 23);
            if (!beyond) {
                CHECK(cell_h > (1 << 23) - 100); // the bound is sharp
                CHECK(cell_g * (sign > 0 ? 1 : -1) > 1 << 21);
            } else {
                CHECK(cell_cost == 1 << 23);
            }
            std::int64_t const cells = std::int64_t{rows_a_frame} * cells_a_row;
            CHECK(totals.cells == cells);
            CHECK(number(totals.h[0]) == cell_h * cells);
            CHECK(number(totals.g[0]) == cell_g * cells);
            CHECK(number(totals.cost) == cell_cost * cells);
            for (auto const& of : sums.field)
                for (auto const v : of) CHECK(v == 0); // taken
        }
    auto const nothing = totals_of<8>(pose::CellRows{});
    pose::Totals const zero{};
    CHECK(std::memcmp(&nothing, &zero, sizeof zero) == 0);
    pose::LaneSums untouched{};
    pose::Totals none{};
    pose::take_sums(untouched, 8, none);
    CHECK(std::memcmp(&none, &zero, sizeof zero) == 0);
}

namespace {
/// A row of pixels that are all alike: T, a colour that moves by motion 4, a depth.
pose::MovingRow alike(float t)
{
    pose::MovingRow row{};
    for (std::uint32_t i = 0; i < block_width; ++i) {
        row.field[0][i] = t;
        for (std::uint32_t c = 0; c < 3; ++c) row.field[1 + c][i] = 0.25f, row.field[10 + 6 * c + 4][i] = 3;
        row.field[4 + 4][i] = -0.5f; // dT
        row.field[28][i] = 2 * (1 - t);
    }
    return row;
}
pose::CellRows rows_of(pose::MovingRow const& row, pose::detail::TargetRow const& target, pose::SumRules const& r)
{
    pose::CellRows rows{};
    float const background[3] = {0.5f, 0.5f, 0.5f};
    splat::detail::GivenSet<8>::call<pose::detail::MakeRows<true>>(row, target, background, r, false, rows);
    return rows;
}
} // namespace

TEST_CASE("pose sums: residuals of pixels: gain, offset, background, coverage, targets that are not known")
{
    float const nan = std::numeric_limits<float>::quiet_NaN();
    auto r = rules();
    r.gain = 2, r.offset = 0.125f, r.scene_depth = 4;
    pose::detail::TargetRow target;
    for (auto& field : target.field)
        for (float& v : field) v = 0.25f;
    for (float& v : target.field[3]) v = 2.5f;
    target.field[1][2] = nan;                                   // no colour
    target.field[3][3] = 0, target.field[3][4] = nan;           // no depth
    target.field[3][6] = -1, target.field[0][7] = std::numeric_limits<float>::infinity();
    auto const rows = rows_of(alike(0.25f), target, r);
    for (std::uint32_t i = 0; i < block_width; ++i) {
        CAPTURE(i);
        bool const counts = i != 2 && i != 7, deep = counts && i != 3 && i != 4 && i != 6;
        CHECK(rows.counted[i] == (counts ? 1.0f : 0.0f));
        CHECK(rows.depth_counted[i] == (deep ? 1.0f : 0.0f));
        // The colour is 0.25 + T background; the target 0.25.
        CHECK(rows.gained[0][i] == (counts ? 0.75f : 0.0f));
        CHECK(rows.residual[0][i] == (counts ? 0.625f : 0.0f));
        CHECK(rows.motion[1][4][i] == (counts ? 2 * (3 - 0.25f) : 0.0f));
        CHECK(rows.motion[1][0][i] == 0);
        CHECK(rows.residual[3][i] == doctest::Approx(deep ? (2 - 2.5) / 2.5 : 0)); // a share of the target's depth
        CHECK(rows.motion[3][2][i] == doctest::Approx(deep ? 4 / 2.5 : 0));        // along the ray: W / W, in units of 4
        CHECK(rows.motion[3][4][i] == doctest::Approx(deep ? 2 * -0.5 / 0.75 / 2.5 : 0));
    }
    // A pixel counts above half a coverage, also if it has stopped (T below 0).
    for (auto const& [t, counts] : {std::pair{0.5f, false}, {0.499f, true}, {-0.001f, true}, {-0.75f, false}, {1.0f, false}, {-1.0f, false}})
        CHECK(rows_of(alike(t), target, r).counted[0] == (counts ? 1.0f : 0.0f));
    // Derivatives that are not finite do not count.
    auto row = alike(0.25f);
    row.field[10 + 4][0] = nan, row.field[10 + 6 + 4][1] = 1e30f, row.field[31 + 4][5] = nan;
    auto const bad = rows_of(row, target, r);
    CHECK(bad.counted[0] == 0);
    CHECK(bad.counted[1] == 0);
    CHECK(bad.counted[5] == 1);
    CHECK(bad.depth_counted[5] == 0);
    for (auto const& of : bad.motion)
        for (auto const& column : of)
            for (float const v : column) CHECK(std::isfinite(v));
}

TEST_CASE("pose sums: a subset has whole blocks of whole cells, of the frame's grid, and the share that was asked for")
{
    pose::Tracking t{};
    t.one_in = 0;
    CHECK(pose::is_chosen(t, 16, 5));
    for (std::uint32_t cell : {1u, 2u, 4u, 8u})
        for (std::uint32_t one_in : {1u, 2u, 10u, 64u}) {
            t.cell = cell, t.one_in = one_in;
            std::uint32_t chosen = 0, all = 0, moved = 0, split = 0;
            for (std::uint32_t row = 0; row < 200 * 5 * cell; row += 5 * cell)
                for (std::uint32_t column = 0; column < 3200; column += block_width) {
                    t.seed = 1;
                    bool const is = pose::is_chosen(t, column, row);
                    ++all, chosen += is ? 1 : 0;
                    for (std::uint32_t y = 0; y < 5 * cell; ++y) split += pose::is_chosen(t, column + y % block_width, row + y) != is ? 1 : 0;
                    t.seed = 2;
                    moved += is && !pose::is_chosen(t, column, row) ? 1 : 0;
                }
            CHECK(split == 0);
            double const share = 1.0 / one_in;
            CHECK(std::fabs(chosen - all * share) <= 5 * std::sqrt(all * share * (1 - share)));
            CHECK(std::fabs(moved - chosen * (1 - share)) <= 5 * std::sqrt(chosen * share)); // another seed chooses others
        }
    t = {};
    t.cell = 1, t.one_in = 10, t.seed = 7;
    std::uint32_t digest = 0;
    for (std::uint32_t row = 0; row < 480; row += 5)
        for (std::uint32_t column = 0; column < 640; column += 16) digest = digest * 31 + (pose::is_chosen(t, column, row) ? 1 : 0);
    CHECK(digest == 4006601288u); // so that a sequence that was tracked with a seed is tracked again
}
