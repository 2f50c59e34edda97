#include "frame.hpp"

namespace frame {

namespace {

namespace splat = tilemesh::splat;
namespace kernel = tilemesh::splat::detail;

/// A block goes on with all its pixels until the last one has stopped. This is not the model's rule; it is measured for comparison, with
/// `precise` alone: cells have no such rule.
struct StopWholeBlock {
    static constexpr bool each_pixel = false, drops_crossing = false;
};

/// As splat::blend_whole_tile, with another rule for alpha or for the stop.
template <class Rule, class Stop>
splat::PairCount blend_by(splat::PixelRect const& tile, splat::View const& view, std::uint32_t n,
                          splat::Splat const* splats, std::uint32_t const* rows, splat::FloatPixel* pixels,
                          std::uint32_t stride_px) noexcept
{
    splat::PairCount count{};
    kernel::blend_tile_by<Rule, Stop, kernel::native_lanes, 32, 128>(
        tile, view.camera, view.rules, n, [=](std::uint32_t i) noexcept -> splat::Splat const& { return splats[rows[i]]; },
        pixels, stride_px, tilemesh::Worker{0, 1}, &count, 1);
    return count;
}

static_assert(kernel::FastRule::degree == 5, "the table says which degree `fast` has");

} // namespace

std::vector<BlendWay> blend_ways()
{
    using kernel::EachPair;
    using kernel::Recurrence;
    using kernel::StopEachPixel;
    return {{"precise", "pixel", blend_by<EachPair, StopEachPixel>},
            {"precise", "block", blend_by<EachPair, StopWholeBlock>},
            {"fast (degree 5)", "pixel", blend_by<Recurrence<5>, StopEachPixel>},
            {"degree 4", "pixel", blend_by<Recurrence<4>, StopEachPixel>},
            {"degree 3", "pixel", blend_by<Recurrence<3>, StopEachPixel>}};
}

} // namespace frame
