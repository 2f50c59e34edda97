#include "tables.hpp"
#include "views.hpp"
#include <algorithm>
#include <bitset>
#include <common/pictures.hpp>
#include <common/scenes.hpp>
#include <shared/png.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/splat/policies.hpp>
#include <unordered_map>

namespace paper {

namespace {

using Tiles = std::bitset<tiles>;

/// The list of losses of a frame, as the tiles that lack each Gaussian.
class Lacking {
public:
    Lacking(scene::Map const& map, splat::Camera const& camera, splat::Rules const& rules, report::FrameReport const& r) : tiling_(tiling_of(camera))
    {
        auto const view = splat::make_view(camera, rules);
        std::unordered_map<std::uint32_t, std::uint32_t> row_of;
        for (std::uint32_t row = 0; row < map.gaussians.size(); ++row) row_of.emplace(static_cast<std::uint32_t>(map.gaussians[row].id), row);
        for (auto const& l : r.lost) {
            auto const id = static_cast<std::uint32_t>(l.id);
            if (id >= of_.size()) of_.resize(id + 1, none);
            if (of_[id] == none) of_[id] = static_cast<std::uint32_t>(sets_.size()), sets_.emplace_back();
            auto& set = sets_[of_[id]];
            if (l.tile != report::Loss::whole) {
                set.set(l.tile);
                continue;
            }
            auto const s = splat::project(map.gaussians[row_of.at(id)], view, tiling_);
            if (!s.visible()) continue;
            for_each_tile(s, tiling_, [&](std::uint32_t tile) { set.set(tile); });
        }
        for (auto const& set : sets_) named_ |= set, copies_ += set.count();
    }
    std::uint32_t tile_of(std::uint32_t x, std::uint32_t y) const noexcept { return y / tiling_.tile_height * grid_columns + x / tiling_.tile_width; }
    /// For `render_naive`: does the tile of this pixel lack the Gaussian?
    bool operator()(splat::GaussianId id, std::uint32_t x, std::uint32_t y) const noexcept
    {
        auto const i = static_cast<std::uint32_t>(id);
        return i < of_.size() && of_[i] != none && sets_[of_[i]][tile_of(x, y)];
    }
    Tiles const& named() const noexcept { return named_; }
    std::uint64_t copies() const noexcept { return copies_; }

private:
    static constexpr std::uint32_t none = 0xffffffffu;
    splat::Tiling tiling_;
    std::vector<std::uint32_t> of_; ///< by id: index of its set
    std::vector<Tiles> sets_;
    Tiles named_;
    std::uint64_t copies_ = 0;
};

/// The image as the machine's 8-bit pixels show it.
report::Image as_rgbx8(report::Image image)
{
    for (auto& v : image.rgb) v = static_cast<float>(splat::Rgbx8Pixel::level(v)) / 255.0f;
    return image;
}

/// Calls f(x, y) for each pixel whose levels differ.
template <class F>
void for_each_difference(report::Image const& a, report::Image const& b, F const& f)
{
    for (std::uint32_t y = 0; y < a.height; ++y)
        for (std::uint32_t x = 0; x < a.width; ++x)
            if (!std::equal(a.pixel(x, y), a.pixel(x, y) + 3, b.pixel(x, y))) f(x, y);
}

/// Draws the tiles in the list grey.
report::Image tiles_of(report::Image const& like, Lacking const& lacking)
{
    report::Image image(like.width, like.height);
    for (std::uint32_t y = 0; y < image.height; ++y)
        for (std::uint32_t x = 0; x < image.width; ++x)
            if (lacking.named()[lacking.tile_of(x, y)]) std::fill_n(image.pixel(x, y), 3, 0.15f);
    return image;
}

} // namespace

void saturation(Context const& context, Rows& rows)
{
    std::string name = "playbot_250k";
    if (!bench::has_scene(name, context.data)) {
        rows.push_back(skipped("saturation", name, "pixels with holes", {}, "counted", "its map is not there"));
        name = "built_in";
    }
    auto const scene = bench::load_scene(name, context.data, context.quick ? scene::Size{640, 360} : scene::Size{1280, 720});
    std::optional<report::Image> complete;
    for (auto const& [channel, storage] : {std::pair{400u, 3200u}, std::pair{100u, 800u}}) {
        auto const frame = render_paper(scene.map, scene.camera, channel, storage, context.threads);
        if (!complete) complete = as_rgbx8(report::render_naive(scene.map.gaussians, scene.camera, frame.rules));
        Lacking const lacking(scene.map, scene.camera, frame.rules, frame.report);

        std::uint64_t holes = 0, matched = 0, unexplained = 0;
        Tiles seen;
        auto plan = tiles_of(frame.image, lacking);
        for_each_difference(frame.image, *complete, [&](std::uint32_t x, std::uint32_t y) {
            auto const tile = lacking.tile_of(x, y);
            ++holes;
            matched += lacking.named()[tile] ? 1 : 0;
            seen.set(tile);
            std::fill_n(plan.pixel(x, y), 3, 1.0f);
        });
        auto const without = as_rgbx8(report::render_naive(scene.map.gaussians, scene.camera, frame.rules, lacking));
        for_each_difference(frame.image, without, [&](std::uint32_t, std::uint32_t) { ++unexplained; });

        auto const row = name + ", " + std::to_string(channel) + " / " + std::to_string(storage) + " slots";
        auto const add = [&](char const* quantity, double value, std::string const& note = {}, bool broken = false) {
            rows.push_back({"saturation", row, quantity, {}, value, "counted", note, broken});
        };
        add("records dropped", static_cast<double>(frame.report.gaussians.dropped),
            std::to_string(scene.map.gaussians.size()) + " Gaussians, preset paper, cold start; channels of " +
                (channel == 400 ? "the paper's text" : "the slots that its public code has room for"));
        add("copies lacking", static_cast<double>(lacking.copies()), "pairs of a Gaussian and a tile, those of dropped records included");
        add("pixels with holes", static_cast<double>(holes),
            "of " + std::to_string(complete->rgb.size() / 3) + "; against the complete picture in 8-bit levels");
        add("holes in tiles of the drop list", static_cast<double>(matched), "every hole must lie in such a tile", matched != holes);
        add("holes that the drop list does not explain", static_cast<double>(unexplained),
            "pixels that differ from the complete picture without the listed records and copies; there must be none", unexplained != 0);
        add("tiles in the drop list", static_cast<double>(lacking.named().count()),
            std::to_string((lacking.named() & seen).count()) +
                " of them have a pixel that differs; in the others the missing terms are hidden, or fainter than a level");
        auto const measures = report::compare(frame.image, *complete);
        add("PSNR (dB)", measures.psnr_db, "against the complete picture");
        if (!context.out.empty())
            shared::write_png(context.out / ("saturation_" + std::to_string(channel) + ".png"), bench::side_by_side({frame.image, *complete, plan}));
    }
}

} // namespace paper
