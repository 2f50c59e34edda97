#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/joined_threads.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <tilemesh/track/spoil.hpp>

namespace tilemesh { inline namespace v0_2 { namespace track {

TILEMESH_HOST void check(Spoiling const& s)
{
    auto const within = [](double value, double most, char const* what) {
        if (!(value >= 0.0 && value <= most))
            throw Error(std::string("pictures cannot be spoilt by ") + what + " of " + std::to_string(value) + " (it lies between 0 and " +
                        std::to_string(most) + "); choose another");
    };
    within(s.noise, 1.0, "a noise");
    within(s.depth_noise, 1.0, "a depth error");
    within(s.depth_holes, 1.0, "a share of holes");
    within(s.gain_drift, 0.9, "a drift of the gain");
    within(s.shutter, 1.0, "a shutter time");
}

TILEMESH_HOST double gain_of(Spoiling const& s, std::uint64_t frame)
{
    double const wave = std::sin(0.1 * static_cast<double>(frame));
    return 1.0 - s.gain_drift * wave * wave;
}

TILEMESH_HOST std::uint64_t random_bits(std::uint64_t seed, std::uint64_t frame, std::uint64_t pixel, std::uint64_t use) noexcept
{
    std::uint64_t h = seed;
    for (std::uint64_t const word : {frame, pixel, use}) {
        h = (h ^ word) + 0x9e3779b97f4a7c15u;
        h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
        h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
        h ^= h >> 31;
    }
    return h;
}

TILEMESH_HOST double random_normal(std::uint64_t seed, std::uint64_t frame, std::uint64_t pixel, std::uint64_t use) noexcept
{
    std::int64_t sum = 0;
    for (std::uint64_t part = 0; part < 3; ++part)
        for (std::uint64_t bits = random_bits(seed, frame, pixel, 16 * use + part), i = 0; i < 4; ++i, bits >>= 16)
            sum += static_cast<std::int64_t>(bits & 0xffff);
    // Each of the twelve has the mean 65,535 / 2 and the variance (65,536^2 - 1) / 12.
    return (static_cast<double>(sum) - 6.0 * 65535.0) / 65536.0;
}

TILEMESH_HOST void spoil(report::Image& picture, report::Plane& depth, std::uint64_t frame, Spoiling const& s, unsigned threads)
{
    check(s);
    if (!depth.empty() && (depth.width != picture.width || depth.height != picture.height))
        throw Error("a picture and its depth cannot be spoilt (they have different sizes); render both with one camera");
    double const gain = gain_of(s, frame);
    auto const rows = [&](std::uint32_t begin, std::uint32_t end) noexcept {
        for (std::size_t p = std::size_t{begin} * picture.width; p < std::size_t{end} * picture.width; ++p) {
            for (std::size_t c = 0; c < 3; ++c) {
                double value = gain * double{picture.rgb[3 * p + c]};
                if (s.noise > 0.0) value += s.noise * random_normal(s.seed, frame, p, c);
                if (s.eight_bits) value = std::floor(255.0 * std::clamp(value, 0.0, 1.0) + 0.5) / 255.0;
                picture.rgb[3 * p + c] = static_cast<float>(value);
            }
            if (depth.empty()) continue;
            float& z = depth.values[p];
            // 2^-64 of the whole range is one step.
            bool const hole = static_cast<double>(random_bits(s.seed, frame, p, 16 * 4)) * 0x1p-64 < s.depth_holes;
            if (hole || !(z > 0.0f) || !std::isfinite(z)) z = 0.0f;
            else if (s.depth_noise > 0.0)
                z = static_cast<float>(std::max(0.0, double{z} * (1.0 + s.depth_noise * random_normal(s.seed, frame, p, 3))));
        }
    };
    unsigned const bands = std::clamp(threads, 1u, std::max(picture.height, 1u));
    auto const border = [&](unsigned band) { return static_cast<std::uint32_t>(std::uint64_t{picture.height} * band / bands); };
    JoinedThreads workers;
    for (unsigned band = 1; band < bands; ++band) workers.start(rows, border(band), border(band + 1));
    rows(0, border(1));
}

TILEMESH_HOST std::array<scene::Pose, 3> shutter_poses(scene::Pose const& before, scene::Pose const& at,
                                                       scene::Pose const& after, double shutter)
{
    auto const part_of = [&](scene::Pose const& to) {
        Twist const way = twist_between(at, to);
        return moved(at, {0.5 * shutter * way.rho, 0.5 * shutter * way.phi});
    };
    return {part_of(before), at, part_of(after)};
}

TILEMESH_HOST report::Image mean_of(std::span<report::Image const> pictures)
{
    if (pictures.empty()) throw Error("no pictures have no mean (the list is empty); give at least one");
    report::Image out{pictures[0].width, pictures[0].height};
    for (auto const& picture : pictures)
        if (picture.width != out.width || picture.height != out.height)
            throw Error("pictures of different sizes have no mean (the first has another size); render all with one lens");
    for (std::size_t i = 0; i < out.rgb.size(); ++i) {
        double sum = 0.0;
        for (auto const& picture : pictures) sum += double{picture.rgb[i]};
        out.rgb[i] = static_cast<float>(sum / static_cast<double>(pictures.size()));
    }
    return out;
}

}}} // namespace tilemesh::track
