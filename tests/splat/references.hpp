#pragma once
#include "../compare_reports.hpp"
#include "runner.hpp"
#include "scenes.hpp"

// Renders with records moved by value and by reference, and compares all that can be seen.
namespace support {

inline std::uint64_t differing(report::Plane const& a, report::Plane const& b)
{
    if (a.values.size() != b.values.size()) return ~std::uint64_t{0};
    return a.values.empty() ? 0 : std::memcmp(a.values.data(), b.values.data(), a.values.size() * sizeof(float)) != 0 ? 1 : 0;
}

/// Renders the cameras with values, and by reference on 1, 2 and 3 threads. Returns the losses of the last frame with values.
template <class S>
report::FrameReport compare(scene::Map const& map, RendererOptions options, std::vector<splat::Camera> const& cameras)
{
    auto const values = make_runner<S>(map, options);
    std::unique_ptr<Runner> references[3];
    for (auto& runner : references) {
        runner = make_runner<Referenced<S>>(map, options);
        ++options.threads;
    }
    RenderedFrame frame, other;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        INFO("frame ", i);
        values->render_into(cameras[i], frame);
        auto const tiles = values->on_tiles();
        for (auto const& runner : references) {
            INFO("by ", &runner - references + 1, " threads");
            runner->render_into(cameras[i], other);
            CHECK(differing_pixels(other.image, frame.image) == 0);
            CHECK(differing(other.depth, frame.depth) == 0);
            CHECK(differing(other.alpha, frame.alpha) == 0);
            CHECK(report::first_difference(other.report, frame.report) == "");
            CHECK(runner->on_tiles() == tiles);
        }
    }
    return frame.report;
}

/// A camera path: still, steps of 0.1 degrees, of 2 degrees and more, jumps, a look away and back.
inline std::vector<splat::Camera> path(std::uint32_t width = 120, std::uint32_t height = 80)
{
    std::vector<splat::Camera> out;
    for (float turn : {0.0f, 0.0f, 0.0017f, 0.0034f, 0.0051f, 0.0051f, 0.04f, 0.08f, -0.4f, -0.4f, 1.5f, 3.1f, 3.1f, 0.01f, 0.01f, 0.02f,
                       -0.02f})
        out.push_back(lens(width, height, turn));
    return out;
}

} // namespace support
