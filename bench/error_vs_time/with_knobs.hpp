#pragma once
#include "knobs.hpp"
#include <cstdint>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/splat/setup_types.hpp>

/// The library's frame with additional rules of this bench: its parameters contain knobs, and its kernels follow them.
namespace error_vs_time {

/// The frame's parameters by reference, and the knobs. The knobs stay from frame to frame.
struct ParametersWithKnobs : splat::TableParameters {
    static constexpr char const* name = "frame parameters and knobs";
    Knobs knobs;
};

/// Applies the knobs to a projected record: its shape as read back from storage, and its rectangle cut at `sigmas` standard deviations,
/// rounded outward to whole pixels.
void apply(Knobs const& knobs, splat::View const& view, splat::Tiling const& tiling, splat::Splat& s) noexcept;

/// The bits of a depth by which splats are ordered.
inline std::uint32_t key_of(Knobs const& knobs, std::uint32_t depth_key) noexcept
{
    return knobs.key_bits >= 32 ? depth_key : depth_key & ~(0xffffffffu >> knobs.key_bits);
}
/// `blend_tile_by` with the arithmetic of a model and the knobs.
template <class Pixel, class SplatAt>
void blend(splat::PixelRect const& tile, splat::View const& view, Knobs const& knobs, std::uint32_t n, SplatAt const& at, Pixel* pixels,
           std::uint32_t stride_px, tilemesh::Worker worker, splat::PairCount* counts, std::uint32_t workers) noexcept
{
    namespace kernel = splat::detail;
    if (tile.empty()) return;
    auto const by = [&]<class Rule, class Stop>() noexcept {
        kernel::blend_tile_by<Rule, Stop, kernel::native_lanes, 32, 128>(tile, view.camera, view.rules, n, at, pixels, stride_px, worker,
                                                                        counts, workers);
    };
    bool const fast = view.rules.arithmetic == splat::Arithmetic::fast && view.rules.alpha_min >= kernel::faintest_cut;
    bool const drops = knobs.crossing == Crossing::drop;
    if (!fast && drops) by.template operator()<kernel::EachPair, kernel::StopBeforeCrossing>();
    else if (!fast) by.template operator()<kernel::EachPair, kernel::StopEachPixel>();
    else if (drops) by.template operator()<kernel::FastRule, kernel::StopBeforeCrossing>();
    else if (knobs.degree == 3) by.template operator()<kernel::Recurrence<3>, kernel::StopEachPixel>();
    else if (knobs.degree == 4) by.template operator()<kernel::Recurrence<4>, kernel::StopEachPixel>();
    else by.template operator()<kernel::FastRule, kernel::StopEachPixel>();
}

/// The blending that Composite runs.
struct BlendWithKnobs {
    template <class SplatAt, class Pixel>
    static splat::PairCount tile(splat::PixelRect const& tile, ParametersWithKnobs const& frame, std::uint32_t n, SplatAt const& at,
                                 Pixel* pixels, std::uint32_t stride_px, tilemesh::Worker worker) noexcept
    {
        splat::PairCount pairs{};
        blend(tile, frame.view, frame.knobs, n, at, pixels, stride_px, worker, &pairs, 1);
        return pairs;
    }
    template <class SplatAt, class Pixel>
    static void whole(splat::PixelRect const& tile, ParametersWithKnobs const& frame, std::uint32_t n, SplatAt const& at,
                      Pixel* pixels, std::uint32_t stride_px, splat::PairCount* counts, std::uint32_t workers) noexcept
    {
        blend(tile, frame.view, frame.knobs, n, at, pixels, stride_px, tilemesh::Worker{0, 1}, counts, workers);
    }
};

/// `lossless` by reference, with knobs in its parameters.
struct WithKnobs : splat::Referenced<splat::Lossless> {
    using Parameters = ParametersWithKnobs;
    using Blending = BlendWithKnobs;
};

} // namespace error_vs_time

/// Kernels read the table as the library's kernels do, except for keys of fewer bits. The knobs change the splats that the host has
/// projected.
template <>
struct tilemesh::splat::Access<error_vs_time::ParametersWithKnobs> : TableAccess<error_vs_time::ParametersWithKnobs> {
    static std::uint32_t depth_key(error_vs_time::ParametersWithKnobs const& frame, SplatRow s) noexcept
    {
        return error_vs_time::key_of(frame.knobs, TableAccess::depth_key(frame, s));
    }
    static void adjust(error_vs_time::ParametersWithKnobs const& frame, View const& view, Tiling const& tiling, Splat* splats,
                       std::uint32_t n) noexcept
    {
        for (std::uint32_t i = 0; i < n; ++i) error_vs_time::apply(frame.knobs, view, tiling, splats[i]);
    }
};
