// test: unoptimised test asan tsan
#include "map_writers.hpp"
#include "real_packing.hpp"
#include "support.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <doctest/doctest.h>
#include <map>
#include <sstream>
#include <string>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/splat/model.hpp>
#include <type_traits>
#include <utility>
#include <vector>

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
        return report::render_double(tilemesh::scene::records<tilemesh::splat::GaussianOfDegree<degree>>(map), camera, tilemesh::splat::Model{},
                                     report::Cuts::none, 1);
    };
    switch (map.sh_degree) {
    case 0:
        return of_degree(std::integral_constant<std::uint32_t, 0>{});
    case 1:
        return of_degree(std::integral_constant<std::uint32_t, 1>{});
    case 2:
        return of_degree(std::integral_constant<std::uint32_t, 2>{});
    default:
        return of_degree(std::integral_constant<std::uint32_t, 3>{});
    }
}

/// The Gaussians lie one behind the other, further apart than any format moves them. Colours and harmonics are in the range of all formats.
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

/// The largest change that the rounding of a format makes to one field. A rotation is compared as the sine of half the angle between.
struct Steps {
    double mean, scale, f_dc, opacity, rotation, rest;
};

Map only(Map const& map, std::size_t i, bool white)
{
    Map one = map;
    std::size_t const floats = coefficients_of(map.sh_degree);
    one.gaussians = {map.gaussians[i]};
    one.harmonics.assign(map.harmonics.begin() + static_cast<std::ptrdiff_t>(i * floats), map.harmonics.begin() + static_cast<std::ptrdiff_t>((i + 1) * floats));
    if (white) {
        std::fill(one.harmonics.begin(), one.harmonics.end(), 0.0f);
        std::fill_n(one.gaussians[0].colour, 3, 1.0f);
    }
    return one;
}

/// Do the fields of all Gaussians differ by no more than the steps?
bool within_steps(Map const& a, Map const& b, Steps const& steps)
{
    auto const near_to = [](double x, double y, double step) { return std::fabs(x - y) <= step * 1.0001 + 1e-6; };
    bool all = a.gaussians.size() == b.gaussians.size() && a.harmonics.size() == b.harmonics.size();
    for (std::size_t i = 0; all && i < a.gaussians.size(); ++i) {
        auto const &g = a.gaussians[i], &h = b.gaussians[i];
        double dot = 0;
        for (int k = 0; k < 4; ++k) dot += double{g.rotation[k]} * h.rotation[k];
        all = all && near_to(g.opacity, h.opacity, steps.opacity) && std::sqrt(std::max(0.0, 1 - dot * dot)) <= steps.rotation;
        for (int k = 0; k < 3; ++k)
            all = all && near_to(g.mean_world[k], h.mean_world[k], steps.mean) && near_to(g.log_scale[k], h.log_scale[k], steps.scale) &&
                  near_to(g.colour[k], h.colour[k], steps.f_dc * 0.2821);
    }
    for (std::size_t i = 0; all && i < a.harmonics.size(); ++i) all = near_to(a.harmonics[i], b.harmonics[i], steps.rest);
    return all;
}

/// Is the picture of `b` within what the differences of the Gaussians explain? A pixel is linear in the opacity alpha and in the colour times
/// alpha of each Gaussian. So it changes by the sum of what these change, with the brightest colour behind. Both come from pictures of one
/// Gaussian. Returns the largest ratio of a change and its bound.
double explained(Map const& a, Map const& b, Camera const& camera)
{
    Image const one = render(a, camera), other = render(b, camera);
    std::vector<double> bound(one.rgb.size(), 0.0), opacity_changes(one.rgb.size(), 0.0);
    double brightest = 0;
    for (std::size_t i = 0; i < a.gaussians.size(); ++i) {
        Image const colour_a = render(only(a, i, false), camera), colour_b = render(only(b, i, false), camera);
        Image const alpha_a = render(only(a, i, true), camera), alpha_b = render(only(b, i, true), camera);
        for (std::size_t p = 0; p < bound.size(); ++p) {
            bound[p] += std::fabs(double{colour_a.rgb[p]} - colour_b.rgb[p]);
            opacity_changes[p] += std::fabs(double{alpha_a.rgb[p]} - alpha_b.rgb[p]);
            if (alpha_a.rgb[p] > 1e-3f) brightest = std::max(brightest, double{colour_a.rgb[p]} / alpha_a.rgb[p]);
            if (alpha_b.rgb[p] > 1e-3f) brightest = std::max(brightest, double{colour_b.rgb[p]} / alpha_b.rgb[p]);
        }
    }
    double worst = 0;
    // 1e-5: the pictures are floats, and 64 of them are added.
    for (std::size_t p = 0; p < bound.size(); ++p)
        worst = std::max(worst, std::fabs(double{one.rgb[p]} - other.rgb[p]) / (bound[p] + brightest * opacity_changes[p] + 1e-5));
    return worst;
}

double largest_difference(Image const& a, Image const& b)
{
    double largest = 0;
    for (std::size_t p = 0; p < a.rgb.size(); ++p) largest = std::max(largest, std::fabs(double{a.rgb[p]} - b.rgb[p]));
    return largest;
}

} // namespace

TEST_CASE("the same map in every format: fields are within the format's rounding, and the picture within what that explains")
{
    Packing const packing = real_packing();
    for (std::uint32_t degree = 0; degree <= 3; ++degree) {
        PlainMap const plain = layers(degree);
        Map const exact = read(write_plain_ply(plain));
        Camera const camera = tilemesh::scene::frame_whole(exact, {48, 32});
        // Half a step of each number. A rotation has four numbers, each off by half a step; where one is derived from three, it is at least 1/2,
        // so it is off by at most the sum of the three.
        double const widest_mean = 3.75, widest_scale = 2.5, widest_f_dc = 2.8, half_8 = 0.5 / 255, turn = std::sqrt(2.0);
        // From x, y, z in 8 bits, e off together, the square of w is off by 2 e + e^2 at most: so is w by the root of that.
        double const e = std::sqrt(3.0) * half_8, first_three = std::sqrt(e * e + 2 * e + e * e);
        auto const smallest_three = [&](double step) { return std::sqrt(3 * step * step + 9 * step * step); };
        std::vector<std::tuple<std::string, Bytes, Steps>> formats{
            {"compressed PLY", PackedPly::of(plain).bytes(),
             {widest_mean / 1023 / 2, widest_scale / 1023 / 2, widest_f_dc * half_8, half_8, smallest_three(turn / 1023 / 2), 8.0 / 256}},
            {"SPZ 1", PackedSpz::of(plain, 1).bytes(packing), {8.0 / 2048 / 2, 1.0 / 32, half_8 / 0.15, half_8, first_three, 1.0 / 256}},
            {"SPZ 2", PackedSpz::of(plain, 2).bytes(packing), {1.0 / 8192, 1.0 / 32, half_8 / 0.15, half_8, first_three, 1.0 / 256}},
            {"SPZ 3", PackedSpz::of(plain, 3).bytes(packing), {1.0 / 8192, 1.0 / 32, half_8 / 0.15, half_8, smallest_three(turn / 2 / 511 / 2), 1.0 / 256}},
            {"SPZ 4", PackedSpz::of(plain, 4).bytes(packing), {1.0 / 8192, 1.0 / 32, half_8 / 0.15, half_8, smallest_three(turn / 2 / 511 / 2), 1.0 / 256}},
            // A mean is rounded in its logarithm: by half a step times 1 + |mean|.
            {"SOG 2", write_zip(PackedSog::of(plain).files(packing), packing, true),
             {6.75 * 1.9 / 65535 / 2, widest_scale * half_8, widest_f_dc * half_8, half_8, smallest_three(turn * half_8), 0.4 * half_8}}};
        if (degree == 0) formats.push_back({".splat", PackedSplat::of(plain).bytes(), {0, 0, half_8 / 0.2820, half_8, std::sqrt(4.0) / 128, 0}});
        for (auto const& [name, bytes, steps] : formats) {
            CAPTURE(name);
            CAPTURE(degree);
            Map const map = read(bytes);
            // .splat has no colours outside [0, 1], so the map that it rounds has them clamped.
            Map rounded = exact;
            if (name == ".splat")
                for (auto& g : rounded.gaussians)
                    for (float& c : g.colour) c = std::clamp(c, 0.0f, 1.0f);
            CHECK(within_steps(rounded, map, steps));
            double const ratio = explained(rounded, map, camera);
            CHECK(ratio <= 1.0);
            CHECK(ratio > 0.01); // the bound is near enough to be one
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
