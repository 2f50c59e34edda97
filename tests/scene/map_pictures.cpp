// test: unoptimised test asan tsan
#include "map_writers.hpp"
#include "real_packing.hpp"
#include "support.hpp"
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/splat/rules.hpp>

using namespace scene_test;
using tilemesh::report::Image;
using tilemesh::scene::Map;
using tilemesh::scene::Turn;
using tilemesh::splat::Camera;

namespace {

Map read(Bytes const& bytes, std::string const& name = "test.splat")
{
    std::istringstream stream(bytes);
    return tilemesh::scene::read_map(stream, name, real_packing().codecs);
}

Image render(Map const& map, Camera const& camera)
{
    namespace report = tilemesh::report;
    auto const of_degree = [&]<std::uint32_t degree>(std::integral_constant<std::uint32_t, degree>) {
        return report::render_double(tilemesh::scene::records<tilemesh::splat::GaussianOfDegree<degree>>(map), camera, tilemesh::splat::Rules{},
                                     report::Cuts::none, 1);
    };
    return map.sh_degree == 0   ? of_degree(std::integral_constant<std::uint32_t, 0>{})
           : map.sh_degree == 1 ? of_degree(std::integral_constant<std::uint32_t, 1>{})
           : map.sh_degree == 2 ? of_degree(std::integral_constant<std::uint32_t, 2>{})
                                : of_degree(std::integral_constant<std::uint32_t, 3>{});
}

/// Gaussians one behind the other, whose colours and harmonics are in the range of all formats.
PlainMap layers(std::uint32_t degree)
{
    Numbers numbers(20 + degree);
    PlainMap map{degree, {}};
    for (int i = 0; i < 16; ++i) {
        PlainRow row;
        row.mean = {numbers.between(-0.6, 0.6), numbers.between(-0.4, 0.4), 2.0 + 0.25 * i};
        for (double& v : row.f_dc) v = numbers.between(-1.2, 1.6);
        for (double& v : row.scale) v = numbers.between(-3.5, -1.0);
        for (double& v : row.rotation) v = numbers.between(-1, 1);
        row.logit = numbers.between(-3, 3);
        for (std::size_t k = 0; k < coefficients_of(degree); ++k) row.rest[k] = numbers.between(-0.2, 0.2);
        map.rows.push_back(row);
    }
    return map;
}

/// The width of the range of what `values_of` gives of the rows.
template <class ValuesOf>
double width_of(PlainMap const& map, ValuesOf const& values_of)
{
    double low = std::numeric_limits<double>::max(), high = -low;
    for (PlainRow const& row : map.rows)
        for (double const v : values_of(row)) low = std::min(low, v), high = std::max(high, v);
    return high - low;
}
/// The widths of the ranges of a map's fields, from which a format computes its steps. The three sizes have one range, and the three channels
/// one: a list of values may serve all of them.
struct Widths {
    double mean = 0, log_mean = 0, scale, f_dc, logit, rest;
    double farthest = 0; ///< the largest number of a mean

    explicit Widths(PlainMap const& map)
        : scale(width_of(map, [](auto const& row) { return row.scale; })), f_dc(width_of(map, [](auto const& row) { return row.f_dc; })),
          logit(width_of(map, [](auto const& row) { return std::array{row.logit}; })), rest(width_of(map, [](auto const& row) { return row.rest; }))
    {
        for (std::size_t i = 0; i < 3; ++i) {
            mean = std::max(mean, width_of(map, [i](auto const& row) { return std::array{row.mean[i]}; }));
            auto const log_of = [i](auto const& row) { return std::array{std::copysign(std::log1p(std::fabs(row.mean[i])), row.mean[i])}; };
            log_mean = std::max(log_mean, width_of(map, log_of));
            for (PlainRow const& row : map.rows) farthest = std::max(farthest, std::fabs(row.mean[i]));
        }
    }
};

/// How a format writes a rotation: all four numbers, or three of them, from which the reader derives w or the largest.
enum class Written { all, without_w, without_largest };

/// The largest change that the rounding of a format makes to one field; `rotation`: to one of the numbers that it writes.
struct Steps {
    double mean, scale, f_dc, opacity, rest, rotation;
    Written written;
};

/// The largest sine of half the angle by which the rounding turns the rotation w, x, y, z.
double largest_turn(float const (&rotation)[4], Steps const& steps)
{
    double const step = steps.rotation;
    // The sine of the angle between two quaternions, one of length 1, is at most their distance.
    if (steps.written == Written::all) return 2 * step;
    std::array<double, 4> const q{rotation[0], rotation[1], rotation[2], rotation[3]};
    std::size_t const derived = steps.written == Written::without_w ? 0 : largest_of(q);
    // The three change the square of the fourth, w, by so much. w^2 - v^2 = (w - v) (w + v) then bounds the change of w.
    double square = 3 * step * step;
    for (std::size_t i = 0; i < 4; ++i) square += i == derived ? 0 : 2 * step * std::fabs(q[i]);
    double const w = std::fabs(q[derived]);
    double const change = std::min(std::sqrt(square), square / (w + std::max(0.0, w - square / w)));
    return std::sqrt(3 * step * step + change * change);
}

/// With room for the rounding to float.
double widened(double step)
{
    return step * 1.0001 + 1e-6;
}

/// Do the fields of all Gaussians differ by no more than the steps?
bool within_steps(Map const& a, Map const& b, Steps const& steps)
{
    auto const near_to = [](double x, double y, double step) { return std::fabs(x - y) <= widened(step); };
    bool all = a.gaussians.size() == b.gaussians.size() && a.harmonics.size() == b.harmonics.size();
    for (std::size_t i = 0; all && i < a.gaussians.size(); ++i) {
        auto const &g = a.gaussians[i], &h = b.gaussians[i];
        double dot = 0, squares_g = 0, squares_h = 0; // rounded to float, the rotations have no length of exactly 1
        for (int k = 0; k < 4; ++k) {
            dot += double{g.rotation[k]} * h.rotation[k];
            squares_g += double{g.rotation[k]} * g.rotation[k];
            squares_h += double{h.rotation[k]} * h.rotation[k];
        }
        double const turn = std::sqrt(std::max(0.0, 1 - dot * dot / (squares_g * squares_h)));
        all = all && near_to(g.opacity, h.opacity, steps.opacity) && turn <= widened(largest_turn(g.rotation, steps));
        for (int k = 0; k < 3; ++k)
            all = all && near_to(g.mean_world[k], h.mean_world[k], steps.mean) && near_to(g.log_scale[k], h.log_scale[k], steps.scale) &&
                  near_to(g.colour[k], h.colour[k], steps.f_dc * 0.2821);
    }
    for (std::size_t i = 0; all && i < a.harmonics.size(); ++i) all = near_to(a.harmonics[i], b.harmonics[i], steps.rest);
    return all;
}

double largest_difference(Image const& a, Image const& b)
{
    double largest = 0;
    for (std::size_t p = 0; p < a.rgb.size(); ++p) largest = std::max(largest, std::fabs(double{a.rgb[p]} - b.rgb[p]));
    return largest;
}

} // namespace

TEST_CASE("the same map in every format: fields are within the format's rounding, and the picture within its bound")
{
    Packing const packing = real_packing();
    for (std::uint32_t degree = 0; degree <= 3; ++degree) {
        PlainMap const plain = layers(degree);
        Map const exact = read(write_plain_ply(plain));
        Camera const camera = tilemesh::scene::frame_whole(exact, {48, 32});
        Image const picture = render(exact, camera);
        Widths const width(plain);
        // Half a step of each number.
        double const half_8 = 0.5 / 255, smallest = std::sqrt(2.0); // of numbers from -1/sqrt(2) to 1/sqrt(2)
        double const spz_colour = half_8 / 0.15, spz_rest = 1.0 / 256, spz_scale = 1.0 / 32;
        // A mean of SOG is rounded in its logarithm, l = log(1 + |mean|): e^l changes by e^l times half a step, and by its square.
        double const log_step = width.log_mean / 65535 / 2, sog_mean = (1 + width.farthest) * log_step * (1 + log_step);
        Steps const spz_3{1.0 / 8192, spz_scale, spz_colour, half_8, spz_rest, smallest / 2 / 511 / 2, Written::without_largest};
        Steps const sog_2{sog_mean, width.scale * half_8, width.f_dc * half_8, half_8, width.rest * half_8, smallest * half_8, Written::without_largest};
        // Version 1 rounds the logit of an opacity, of which the slope is at most 1/4.
        Steps sog_1 = sog_2;
        sog_1.opacity = width.logit * half_8 / 4;
        // x, y, z have 255 steps from -1 to 1. In version 1 the means are float16, which have steps of 8 / 2048 below 8.
        Steps const spz_2{1.0 / 8192, spz_scale, spz_colour, half_8, spz_rest, 2 * half_8, Written::without_w};
        Steps spz_1 = spz_2;
        spz_1.mean = 8.0 / 2048 / 2;
        // 10 or 11 bits. The harmonics are the middles of 256 parts, but the first and the last are their ends.
        double const half_10 = 0.5 / 1023, rest = 8.0 / 256;
        Steps const ply{width.mean * half_10, width.scale * half_10, width.f_dc * half_8, half_8, rest, smallest * half_10, Written::without_largest};
        // The byte of 1 is 255, and not 256, of 128.
        Steps const splat{0, 0, half_8 / sh_c0, half_8, 0, 1.0 / 128, Written::all};
        // With the largest change of a channel of the picture, over the degrees: as measured, and a fifth more.
        std::vector<std::tuple<std::string, Bytes, Steps, double>> formats{
            {"compressed PLY", PackedPly::of(plain).bytes(), ply, 0.015},
            {"SPZ 1", PackedSpz::of(plain, 1).bytes(packing), spz_1, 0.028},
            {"SPZ 2", PackedSpz::of(plain, 2).bytes(packing), spz_2, 0.028},
            {"SPZ 3", PackedSpz::of(plain, 3).bytes(packing), spz_3, 0.022},
            {"SPZ 4", PackedSpz::of(plain, 4).bytes(packing), spz_3, 0.022},
            {"SOG 1", write_zip(PackedSog::of(plain, 1).files(packing), packing, true), sog_1, 0.005},
            {"SOG 2", write_zip(PackedSog::of(plain, 2).files(packing), packing, true), sog_2, 0.005}};
        if (degree == 0) formats.push_back({".splat", PackedSplat::of(plain).bytes(), splat, 0.003});
        for (auto const& [format, bytes, steps, pixel] : formats) {
            auto const& name = format; // Clang 14 captures no structured binding
            CAPTURE(name);
            CAPTURE(degree);
            Map const map = read(bytes);
            CHECK(within_steps(exact, map, steps));
            CHECK(largest_difference(picture, render(map, camera)) <= pixel);
        }
    }
}

TEST_CASE("a turned map looks from a turned camera as before")
{
    for (std::uint32_t degree : {0u, 3u}) {
        Map const map = read(write_plain_ply(layers(degree)));
        Camera const camera = tilemesh::scene::frame_whole(map, {48, 32});
        Image const before = render(map, camera);
        for (int turn = 0; turn < 9; ++turn) {
            CAPTURE(turn);
            int const axis = turn / 3, quarters = turn % 3 + 1, u = (axis + 1) % 3, v = (axis + 2) % 3;
            // A camera's rows are its axes in the world: turn these, quarter by quarter.
            Camera moved = camera;
            for (int i = 0; i < quarters; ++i) {
                auto const quarter = [&](auto& vector) {
                    float const x = vector[u];
                    vector[u] = -vector[v];
                    vector[v] = x;
                };
                quarter(moved.position);
                for (auto& row : moved.rotation) quarter(row);
            }
            Map const after = tilemesh::scene::turned(map, static_cast<Turn>(turn));
            CHECK(largest_difference(before, render(after, moved)) < 2e-5);
            CHECK(largest_difference(before, render(map, moved)) > 0.05);
            // The rest of the full turn gives the map back.
            Map const back = tilemesh::scene::turned(after, static_cast<Turn>(3 * axis + 3 - quarters));
            for (std::size_t i = 0; i < map.gaussians.size(); ++i)
                for (int k = 0; k < 3; ++k) CHECK(back.gaussians[i].mean_world[k] == map.gaussians[i].mean_world[k]);
            for (std::size_t i = 0; i < map.harmonics.size(); ++i) CHECK(std::fabs(back.harmonics[i] - map.harmonics[i]) < 1e-6f);
        }
    }
}

TEST_CASE("the axes of an SPZ are turned back by x180")
{
    Numbers numbers(30);
    auto const packed = PackedSpz::random(50, 2, 3, numbers);
    Map const map = tilemesh::scene::turned(read(packed.plain()), Turn::x180);
    for (std::size_t i = 0; i < map.gaussians.size(); ++i) {
        auto const& row = packed.rows[static_cast<std::size_t>(map.gaussians[i].id) - 1];
        auto const fixed = [](std::uint32_t bits) { return static_cast<float>(static_cast<std::int32_t>(bits << 8) >> 8) / 4096.0f; };
        for (std::size_t k = 0; k < 3; ++k) CHECK(map.gaussians[i].mean_world[k] == fixed(row.mean[k]));
        for (std::size_t k = 0; k < 45; ++k) CHECK(map.harmonics[45 * i + k] == (static_cast<float>(row.sh[k]) - 128.0f) / 128.0f);
    }
}
