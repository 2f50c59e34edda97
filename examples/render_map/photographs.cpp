#include "photographs.hpp"
#include "../shared/photograph_of.hpp"
#include "../shared/picture_input.hpp"
#include "../shared/png.hpp"
#include "../shared/text.hpp"
#include "outputs.hpp"
#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/report/resample.hpp>
#include <tilemesh/scene/pose.hpp>

namespace render_map {

namespace {

namespace fs = std::filesystem;
namespace report = tilemesh::report;
using tilemesh::Error;
using tilemesh::scene::Size;

std::string by(Size size)
{
    return std::to_string(size.width) + " x " + std::to_string(size.height);
}

bool same(Size a, Size b)
{
    return a.width == b.width && a.height == b.height;
}

std::array<float, 3> background_of(Options const& options)
{
    return options.renderer.background.value_or(std::array<float, 3>{});
}

report::Comparison compare_with(fs::path const& file, report::Image const& rendered, OtherPicture const& other)
{
    return {file.string(), "", report::compare_pictures(other.ends_at_1 ? report::clamped(rendered) : rendered, other.image), ""};
}

} // namespace

void find_photographs(Options const& options, std::vector<Shot>& shots)
{
    if (!options.photos) return;
    std::error_code refused;
    auto const folder = shared::one_line(options.photos->string());
    if (!fs::is_directory(*options.photos, refused))
        throw Error("--photos cannot be " + folder + " (it is no directory" + (refused ? ": " + refused.message() : std::string()) +
                    "); name the folder of the photographs");
    std::map<fs::path, std::string> taken; // photographs, and the cameras that have them
    for (auto& shot : shots) {
        Photograph photo{shared::photograph_of(*options.photos, shot.picture), "", {}, false};
        if (photo.path.empty()) {
            photo.path = *options.photos / fs::path(shot.picture).relative_path();
            photo.problem = shared::one_line(photo.path.string()) + " is not compared (there is no such photograph, nor one of that name with .png or .jpg); "
                            "name the folder that has it with --photos";
            shot.photograph = photo;
            continue;
        }
        photo.found = true;
        auto const [camera, first] = taken.emplace(photo.path, shot.picture);
        try {
            if (!first && camera->second != shot.picture)
                throw Error(shared::one_line(photo.path.string()) + " is not compared (it may be that of \"" + shared::one_line(camera->second, 200) + "\" or of \"" +
                            shared::one_line(shot.picture, 200) + "\"); name the folder above with --photos");
            Size const whole{shot.full.width, shot.full.height}, wanted{shot.camera.width, shot.camera.height}, own = shared::picture_size(photo.path);
            auto const fits = [&](std::uint32_t side, std::uint32_t of) { return side == of / options.scale || side == (of + options.scale - 1) / options.scale; };
            if (fits(own.width, whole.width) && fits(own.height, whole.height)) shot.camera = tilemesh::scene::stretched(shot.full, own);
            else if (!same(own, whole))
                throw Error(shared::one_line(photo.path.string()) + " is not compared (it has " + by(own) + " pixels, its camera " + by(whole) +
                            (options.scale == 1 ? std::string() : ", or reduced " + by(wanted)) +
                            "); name the photographs of these cameras, or choose another --scale");
            photo.size = own;
        } catch (Error const& error) {
            photo.problem = error.what();
        }
        shot.photograph = photo;
    }
    if (taken.empty())
        throw Error("--photos " + folder + " has no photograph of these cameras (the first is \"" + shared::one_line(shots.front().picture, 200) +
                    "\"); name the folder that has it");
}

std::optional<OtherPicture> read_other(Options const& options, std::vector<Shot> const& shots)
{
    if (!options.compare) return {};
    auto const& path = *options.compare;
    if (shots.size() != 1)
        throw Error("--compare " + shared::one_line(path.string()) + " is one picture, and this run has " + std::to_string(shots.size()) +
                    " (which one it shows is not said); name one camera with --camera");
    Size const size{shots.front().camera.width, shots.front().camera.height};
    std::array<char, 2> magic{};
    if (std::error_code ignored; fs::is_regular_file(path, ignored)) std::ifstream(path, std::ios::binary).read(magic.data(), 2);
    bool const pfm = magic[0] == 'P' && (magic[1] == 'F' || magic[1] == 'f');
    OtherPicture other{{}, !pfm};
    if (pfm) other.image = report::read_pfm(path);
    Size const own = pfm ? Size{other.image.width, other.image.height} : shared::picture_size(path);
    if (!same(own, size))
        throw Error("--compare cannot be " + shared::one_line(path.string()) + " (it has " + by(own) + " pixels, the frame " + by(size) + "); add --size " +
                    std::to_string(own.width) + "x" + std::to_string(own.height) + " if it shows the same view");
    if (!pfm) other.image = shared::read_picture(path, size, background_of(options));
    return other;
}

bool compare_frame(Options const& options, Shot const& shot, std::optional<OtherPicture> const& other, report::Image const& rendered,
                   fs::path const& error_path, report::RunFrame& frame)
{
    std::optional<OtherPicture> photograph;
    if (shot.photograph) {
        auto const& photo = *shot.photograph;
        frame.photograph = report::Comparison{photo.path.string(), photo.problem, {}, ""};
        if (!photo.problem.empty()) return false;
        try {
            photograph = OtherPicture{shared::read_picture(photo.path, photo.size, background_of(options)), true};
        } catch (Error const& error) {
            frame.photograph->problem = error.what();
            return false;
        }
        auto& image = photograph->image;
        if (!same(photo.size, {rendered.width, rendered.height})) image = report::resized_as_photograph(image, rendered.width, rendered.height);
        frame.photograph = compare_with(photo.path, rendered, *photograph);
    }
    if (other) frame.compared = compare_with(*options.compare, rendered, *other);
    auto const& shown = photograph ? photograph : other;
    if (!options.error_picture || !shown) return false;
    shared::write_png(error_path, report::error_picture(shown->ends_at_1 ? report::clamped(rendered) : rendered, shown->image), outlasts(options));
    (photograph ? frame.photograph : frame.compared)->error = error_path.filename().string();
    return true;
}

std::vector<std::string> photograph_problems(report::RunReport const& run)
{
    std::vector<std::string> problems;
    for (auto const& frame : run.frames)
        if (frame.photograph && !frame.photograph->problem.empty()) problems.push_back(shared::one_line(frame.photograph->problem));
    return problems;
}

} // namespace render_map
