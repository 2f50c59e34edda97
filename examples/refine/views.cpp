#include "views.hpp"
#include "../shared/near_note.hpp"
#include "../shared/photographs_of.hpp"
#include "../shared/picture_input.hpp"
#include "../shared/rgbd_photo.hpp"
#include "../shared/text.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <tilemesh/error.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/resample.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <utility>

namespace refine {

namespace fs = std::filesystem;
namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
using tilemesh::Error;

namespace {

/// The view of a camera and its photograph.
View view_of(Options const& options, scene::NamedCamera const& camera, fs::path photograph)
{
    scene::Size const whole{camera.camera.width, camera.camera.height}, own = shared::picture_size(photograph);
    bool const reduced = shared::is_reduced(photograph, own, whole, options.scale, " is no photograph of its camera");
    if (!camera.mask.empty()) shared::require_mask(camera.mask, own, whole);
    auto const size = options.size ? *options.size : reduced ? own : scene::reduced(whole, options.scale);
    return {camera.name, scene::stretched(camera.camera, size), std::move(photograph), camera.mask, {}, own, {}};
}

/// Gives the views the depths that --depths has for their photographs.
void add_depths(Options const& options, std::vector<View>& views, Views& out)
{
    std::vector<std::string> of_list;
    std::map<fs::path, fs::path> depth_of;
    for (auto const& frame : scene::load_rgbd(*options.depths, options.depth_within, &of_list))
        if (!frame.depth.file.empty()) depth_of[fs::weakly_canonical(frame.colour.file)] = frame.depth.file;
    shared::add_notes(out.notes, *options.depths, of_list);
    for (auto const* const list : shared::rgbd_lists) out.read.push_back(*options.depths / list);
    std::size_t found = 0;
    for (auto& view : views)
        if (auto const at = depth_of.find(fs::weakly_canonical(view.photograph)); at != depth_of.end()) {
            out.read.push_back(view.depth = at->second);
            ++found;
        }
    if (found == 0)
        throw Error("--depths " + shared::one_line(options.depths->string()) +
                    " has no depth of these photographs (its pictures are other files than " + shared::one_line(views.front().photograph.string()) +
                    "); name the list of these pictures");
    if (found < views.size()) out.notes.push_back(std::to_string(found) + " of " + std::to_string(views.size()) + " photographs have a depth");
}

} // namespace

tilemesh::mapping::Target View::target() const
{
    tilemesh::mapping::Target t{camera.width, camera.height, std::vector<tilemesh::splat::TargetPixel>(levels.size() / 3)};
    for (std::size_t i = 0; i < t.pixels.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) t.pixels[i].rgb[c] = static_cast<float>(levels[3 * i + c]) / 255.0f;
        if (!counts.empty() && !counts[i]) t.pixels[i].rgb[0] = std::numeric_limits<float>::quiet_NaN();
        t.pixels[i].depth = depths.empty() ? 0 : depths[i];
    }
    return t;
}

Views find_views(Options const& options, scene::Map const& map)
{
    Views out;
    std::vector<std::string> all;
    auto cameras = shared::load_cameras(options, shared::shape_of(map), options.size, out.notes, out.read, &all);
    std::stable_sort(cameras.begin(), cameras.end(), [](auto const& a, auto const& b) { return a.name < b.name; });
    std::vector<std::string> names;
    for (auto const& camera : cameras) names.push_back(camera.name);
    auto const photographs = shared::photographs_of(*options.photos, names, all);
    std::vector<scene::NamedCamera> found;
    std::vector<View> views;
    std::size_t masks = 0;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        auto const& photograph = photographs[i];
        bool const repeated = i > 0 && names[i] == names[i - 1] && photograph.found();
        if (repeated || photograph.others.size() > 1)
            throw Error(shared::one_line(photograph.path.string()) + " is not clear (" +
                        (repeated ? "cameras of two scenes have its name" : photograph.why()) + "); name the folder above with --photos");
        if (!photograph.found()) continue;
        out.read.push_back(photograph.path);
        found.push_back(cameras[i]);
        views.push_back(view_of(options, cameras[i], photograph.path));
        masks += cameras[i].mask.empty() ? 0u : 1u;
    }
    if (found.size() < 2)
        throw Error("--photos " + shared::one_line(options.photos->string()) + " has " +
                    (found.empty() ? "no photograph" : "one photograph") +
                    " of these cameras (one is compared, and others are needed; the first camera is \"" +
                    shared::one_line(cameras.front().name, 200) + "\"); name the folder that has them");
    if (found.size() < cameras.size())
        out.notes.push_back(std::to_string(cameras.size() - found.size()) + " of " + std::to_string(cameras.size()) +
                            " cameras have no photograph in " + options.photos->string() + ", and are left out");
    if (options.depths) add_depths(options, views, out);
    std::vector<fs::path> pictures;
    for (auto const& view : views) pictures.push_back(view.photograph);
    shared::add_picture_notes(pictures, shared::shows_background, out.notes);
    if (masks != 0) out.notes.push_back(shared::mask_note(masks, found.size()));
    std::vector<tilemesh::splat::Camera> seen;
    for (auto const& view : views) seen.push_back(view.camera);
    shared::add_near_note(map, seen, out.notes);
    auto const splits = shared::splits_of(found, options.every.value_or(8), options.every.has_value(), out.notes);
    for (std::size_t i = 0; i < views.size(); ++i)
        if (splits[i] != scene::Split::unused) (splits[i] == scene::Split::held_out ? out.held_out : out.used).push_back(std::move(views[i]));
    if (out.held_out.empty() || out.used.empty())
        throw Error(std::string("no photograph ") + (out.used.empty() ? "is left to refine by" : "is held out") +
                    " (the lists of names in the camera file leave none); correct the camera file");

    out.read = shared::files_read(options.inputs, options, {options.map}, std::move(out.read));
    return out;
}

void read_photographs(Options const& options, std::vector<View>& views)
{
    for (auto& view : views) {
        auto image = shared::read_picture(view.photograph, view.size, options.background.value_or(std::array<float, 3>{}));
        if (view.size.width != view.camera.width || view.size.height != view.camera.height)
            image = report::resized_as_photograph(image, view.camera.width, view.camera.height);
        shared::apply_mask(image, view.mask);
        for (std::size_t i = 0; i < image.rgb.size() && !view.mask.empty(); i += 3) view.counts.push_back(!std::isnan(image.rgb[i]));
        if (!view.depth.empty()) { // the nearest: a mean of two depths is the depth of neither
            auto const plane = shared::read_photo({{0, view.photograph}, {0, view.depth}}, view.size, options.depth_levels, "").depth;
            for (std::uint32_t y = 0; y < view.camera.height; ++y)
                for (std::uint32_t x = 0; x < view.camera.width; ++x)
                    view.depths.push_back(plane.values[(std::size_t{2} * y + 1) * view.size.height / (std::size_t{2} * view.camera.height) * plane.width +
                                                       (std::size_t{2} * x + 1) * view.size.width / (std::size_t{2} * view.camera.width)]);
        }
        view.levels.reserve(image.rgb.size());
        for (float const v : image.rgb) view.levels.push_back(static_cast<unsigned char>(std::lround(v > 0.0f ? std::min(v, 1.0f) * 255.0f : 0.0f)));
    }
}

} // namespace refine
