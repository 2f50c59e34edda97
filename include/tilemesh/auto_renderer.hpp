#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <tilemesh/any_renderer.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/scene/map.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

namespace render {

/// May anchored tiles render a frame? No if the records are more than the tiles have slots, or if the tiles have no room for the pixels.
struct MayFitAnchored {
    bool records;
    Cut cut;
    MachineSize machine;
    std::uint32_t tile_pixels;

    bool frame(Extent2 size) const noexcept { return fits(cut, size.width, size.height, machine, tile_pixels); }
};
inline MayFitAnchored may_fit_anchored(std::uint64_t records, Setup const& setup, RendererOptions const& options) noexcept
{
    std::uint64_t const tiles = options.grid.width != 0 ? std::uint64_t{options.grid.width} * options.grid.height : setup.machine.tiles;
    std::uint64_t const slots = options.storage_slots != 0 ? options.storage_slots : setup.sizes.storage;
    return {records <= tiles * slots, {options.grid, options.tile}, setup.machine, setup.sizes.tile_pixels};
}
} // namespace render

/// Renders with the anchored program as long as nothing is missing. A frame that would lack records or copies, or has more pixels than anchored
/// tiles have room for, is rendered with the program of homes instead, and so are all later frames.
///
/// The frame at the change runs both programs; its report is that of homes, with the host time of both. The model, the demand and the
/// picture's planes stay the same. If homes have no room for the map either, the anchored program goes on, and its reports list what is
/// missing.
class AutoRenderer : public AnyRenderer {
public:
    using MakeHomes = std::function<std::unique_ptr<AnyRenderer>(scene::Map const&)>;

    /// `make_homes` makes the renderer of homes from the records of the anchored one, for the same options, when it is needed. It may throw
    /// Error. A frame that may not fit is of homes at once.
    AutoRenderer(std::unique_ptr<AnyRenderer> anchored, MakeHomes make_homes, render::MayFitAnchored const& may_fit)
        : renderer_(std::move(anchored)), make_homes_(std::move(make_homes)), may_fit_(may_fit)
    {
    }

    RenderedFrame render(splat::Camera const& camera) override
    {
        if (!make_homes_) return renderer_->render(camera);
        render::check_camera(camera);
        RenderedFrame frame;
        bool const fits = may_fit_.frame({camera.width, camera.height}), may_fit = may_fit_.records && fits;
        if (may_fit) {
            frame = renderer_->render(camera);
            if (!lacks(frame.report)) return frame;
        }
        try {
            auto homes = std::exchange(make_homes_, nullptr)(renderer_->map());
            homes->rules() = renderer_->rules();
            if (demand_) homes->hold_to(*demand_);
            auto again = homes->render(camera);
            again.report.host_ms.total += frame.report.host_ms.total;
            change_ = may_fit ? why(frame.report) : fits ? "the records have no room" : "the pixels have no room";
            renderer_ = std::move(homes);
            return again;
        } catch (Error const& error) {
            change_refused_ = error.what();
            return may_fit ? std::move(frame) : renderer_->render(camera);
        }
    }

    splat::Rules& rules() override { return renderer_->rules(); }
    void hold_to(scene::Demand const& demand) override
    {
        renderer_->hold_to(demand);
        demand_.emplace();
        demand_->scanned = demand.scanned;
        demand_->culled = demand.culled;
    }
    scene::Map const& map() const override { return renderer_->map(); }
    Extent2 grid() override { return renderer_->grid(); }
    Extent2 tile() override { return renderer_->tile(); }
    render::Setup const& setup() const override { return renderer_->setup(); }

    /// The renderer of the last frame, and of the next one unless that would lack something.
    AnyRenderer& current() noexcept { return *renderer_; }
    /// Why it changed to homes, in words: "1200 records and 3 copies would be missing". Empty as long as it did not change.
    std::string const& change() const noexcept { return change_; }
    /// Why it could not change to homes: the text of the Error. Empty if it could, or need not.
    std::string const& change_refused() const noexcept { return change_refused_; }

private:
    static bool lacks(report::FrameReport const& r) noexcept { return !r.lost.empty() || r.gaussians.unplaced != 0 || r.gaussians.dropped != 0; }
    static std::string why(report::FrameReport const& r)
    {
        auto const records = static_cast<std::uint64_t>(
            std::count_if(r.lost.begin(), r.lost.end(), [](auto const& loss) { return loss.tile == report::Loss::whole; }));
        auto const text = [](std::uint64_t n, char const* what) { return std::to_string(n) + " " + what + (n == 1 ? "" : "s"); };
        auto const copies = r.lost.size() - records;
        return (records == 0 ? "" : text(records, "record")) + (records != 0 && copies != 0 ? " and " : "") +
               (copies == 0 ? "" : copies == 1 ? "1 copy" : text(copies, "copie")) + " would be missing";
    }

    std::unique_ptr<AnyRenderer> renderer_;
    MakeHomes make_homes_; ///< empty after the change
    render::MayFitAnchored may_fit_;
    std::optional<scene::Demand> demand_; ///< only the facts about views
    std::string change_, change_refused_;
};

}} // namespace tilemesh
