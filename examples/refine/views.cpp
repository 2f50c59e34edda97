#include "views.hpp"
#include "../shared/photograph_of.hpp"
#include "../shared/picture_input.hpp"
#include "../shared/text.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <system_error>
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

std::string by(scene::Size size)
{
    return std::to_string(size.width) + " x " + std::to_string(size.height);
}

/// The view of a camera and its photograph.
View view_of(Options const& options, scene::NamedCamera const& camera, fs::path photograph)
{
    scene::Size const whole{camera.camera.width, camera.camera.height}, own = shared::picture_size(photograph);
    auto const fits = [&](std::uint32_t side, std::uint32_t of) { return side == of / options.scale ||
                                                                 side == (of + options.scale - 1) / options.scale; };
    bool const reduced = fits(own.width, whole.width) && fits(own.height, whole.height);
    if (!reduced && (own.width != whole.width || own.height != whole.height))
        throw Error(shared::one_line(photograph.string()) + " is no photograph of its camera (it has " + by(own) +
                    " pixels, the camera " + by(whole) +
                    "); name the photographs of these cameras, or choose another --scale");
    auto const size = options.size ? *options.size : reduced ? own : scene::reduced(whole, options.scale);
    return {camera.name, scene::stretched(camera.camera, size), std::move(photograph), own, {}};
}

} // namespace

tilemesh::mapping::Target View::target() const
{
    tilemesh::mapping::Target t{camera.width, camera.height, std::vector<tilemesh::splat::TargetPixel>(levels.size() / 3)};
    for (std::size_t i = 0; i < t.pixels.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) t.pixels[i].rgb[c] = static_cast<float>(levels[3 * i + c]) / 255.0f;
        t.pixels[i].depth = 0;
    }
    return t;
}

Views find_views(Options const& options, scene::Map const& map)
{
    Views out;
    auto cameras = shared::load_cameras(options, shared::shape_of(map), options.size, out.notes, out.read);
    std::stable_sort(cameras.begin(), cameras.end(), [](auto const& a, auto const& b) { return a.name < b.name; });

    std::error_code refused;
    if (!fs::is_directory(*options.photos, refused))
        throw Error("--photos cannot be " + shared::one_line(options.photos->string()) + " (it is no directory" +
                    (refused ? ": " + refused.message() : std::string()) + "); name the folder of the photographs");
    std::vector<View> found;
    std::map<fs::path, std::string> taken; // photographs, and the cameras that have them
    for (auto const& camera : cameras) {
        auto photograph = shared::photograph_of(*options.photos, camera.name);
        if (photograph.empty()) continue;
        if (auto const [other, first] = taken.emplace(photograph, camera.name); !first)
            throw Error(shared::one_line(photograph.string()) + " is not clear (it may be that of \"" +
                        shared::one_line(other->second, 200) + "\" or of \"" + shared::one_line(camera.name, 200) +
                        "\"); name the folder above with --photos");
        out.read.push_back(photograph);
        found.push_back(view_of(options, camera, std::move(photograph)));
    }
    if (found.size() < 2)
        throw Error("--photos " + shared::one_line(options.photos->string()) + " has " +
                    (found.empty() ? "no photograph" : "one photograph") +
                    " of these cameras (one is compared, and others are needed; the first camera is \"" +
                    shared::one_line(cameras.front().name, 200) + "\"); name the folder that has them");
    if (found.size() < cameras.size())
        out.notes.push_back(std::to_string(cameras.size() - found.size()) + " of " + std::to_string(cameras.size()) +
                            " cameras have no photograph in " + options.photos->string() + ", and are left out");
    for (std::size_t i = 0; i < found.size(); ++i) (i % options.every == 0 ? out.held_out : out.used).push_back(std::move(found[i]));

    out.read = shared::files_read(options.inputs, options, {options.map}, std::move(out.read));
    return out;
}

void read_photographs(Options const& options, std::vector<View>& views)
{
    for (auto& view : views) {
        auto image = shared::read_picture(view.photograph, view.size, options.background.value_or(std::array<float, 3>{}));
        if (view.size.width != view.camera.width || view.size.height != view.camera.height)
            image = report::resized_as_photograph(image, view.camera.width, view.camera.height);
        view.levels.reserve(image.rgb.size());
        for (float const v : image.rgb) view.levels.push_back(static_cast<unsigned char>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255.0f)));
    }
}

} // namespace refine
