#include "sequence.hpp"
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <tilemesh/report/exact_rays.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/slam/session.hpp>
#include <tilemesh/splat/rules.hpp>

using namespace tilemesh;

SequenceRow map_sequence(bench::Scene const& scene, std::filesystem::path const& data, std::uint32_t frames, std::uint32_t threads)
{
    auto const cameras = bench::cameras_of("fr1_xyz", scene, frames - 1, data);
    SequenceRow row;
    row.frames = static_cast<std::uint32_t>(cameras.size());
    auto const seen_from = [&](splat::Camera const& camera) {
        slam::Frame frame;
        frame.colour = report::render_exact_rays(scene.map.gaussians, camera, splat::Rules{}, threads, &frame.depth);
        return frame;
    };
    slam::SessionOptions options;
    options.mapper.threads = threads;
    auto first = seen_from(cameras.front());
    slam::Session session({}, scene::lens_of(cameras.front()), slam::median_depth(first.depth), scene::pose_of(cameras.front()), options);
    double squares = 0;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        auto frame = i == 0 ? std::move(first) : seen_from(cameras[i]);
        frame.seconds = static_cast<double>(i) / 30;
        auto const found = session.add(std::move(frame));
        row.lost += found.tracked.verdict == track::Verdict::lost && i != 0 ? 1 : 0;
        auto const off = found.tracked.pose.position - scene::pose_of(cameras[i]).position;
        squares += glm::dot(off, off);
    }
    row.ate = std::sqrt(squares / static_cast<double>(cameras.size()));
    double errors = 0, values = 0;
    for (std::size_t i = 2; i < cameras.size(); i += 10) { // between keyframes, most of them
        auto const truth = seen_from(cameras[i]).colour, shown = session.mapper().render(cameras[i]).colour;
        for (std::size_t k = 0; k < truth.rgb.size(); ++k, ++values) errors += std::pow(double{truth.rgb[k]} - double{shown.rgb[k]}, 2);
    }
    row.psnr = -10 * std::log10(errors / values);
    return row;
}
