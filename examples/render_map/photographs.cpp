#include "photographs.hpp"
#include "../shared/photographs_of.hpp"
#include "../shared/picture_input.hpp"
#include "../shared/png.hpp"
#include "../shared/text.hpp"
#include "outputs.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/report/resample.hpp>
#include <tilemesh/scene/pose.hpp>
#include <utility>

namespace render_map {

namespace {

namespace fs = std::filesystem;
namespace report = tilemesh::report;
using shared::by, shared::same;
using tilemesh::Error;
using tilemesh::scene::Size;

std::array<float, 3> background_of(Options const& options)
{
    return options.renderer.background.value_or(std::array<float, 3>{});
}

report::Comparison compare_with(fs::path const& file, report::Image const& rendered, OtherPicture const& other)
{
    return {file.string(), "", report::compare_pictures(other.ends_at_1 ? report::clamped(rendered) : rendered, other.image), ""};
}

} // namespace

void find_photographs(Options const& options, std::vector<std::string> const& names, std::vector<Shot>& shots, std::vector<std::string>& notes)
{
    if (!options.photos) return;
    std::vector<std::string> wanted;
    for (auto const& shot : shots) wanted.push_back(shot.picture);
    auto const photographs = shared::photographs_of(*options.photos, wanted, names);
    std::size_t found = 0, masks = 0;
    for (std::size_t i = 0; i < shots.size(); ++i) {
        auto& shot = shots[i];
        auto const& of = photographs[i];
        Photograph photo{of.path, shot.mask, "", {}, of.found()};
        found += of.path.empty() ? 0u : 1u;
        if (of.path.empty()) {
            photo.path = *options.photos / fs::path(shot.picture).relative_path();
            photo.problem = shared::one_line(photo.path.string()) + " is not compared (there is no such photograph, nor one of that name with .png or .jpg); "
                            "name the folder that has it with --photos";
        } else if (!of.found()) {
            photo.problem = shared::one_line(of.path.string()) + " is not compared with \"" + shared::one_line(shot.picture, 200) + "\" (" +
                            of.why() + "); name the folder above with --photos";
        } else {
            try {
                Size const whole{shot.full.width, shot.full.height};
                photo.size = shared::picture_size(photo.path);
                if (shared::is_reduced(photo.path, photo.size, whole, options.scale, " is not compared"))
                    shot.camera = tilemesh::scene::stretched(shot.full, photo.size);
            } catch (Error const& error) {
                photo.problem = error.what();
            }
        }
        if (photo.problem.empty() && !photo.mask.empty()) {
            shared::require_mask(photo.mask, photo.size, {shot.full.width, shot.full.height});
            ++masks;
        }
        shot.photograph = photo;
    }
    if (found == 0)
        throw Error("--photos " + shared::one_line(options.photos->string()) + " has no photograph of these cameras (the first is \"" +
                    shared::one_line(shots.front().picture, 200) + "\"); name the folder that has it");
    std::vector<fs::path> pictures;
    for (auto const& of : photographs)
        if (of.found()) pictures.push_back(of.path);
    shared::add_picture_notes(pictures, shared::shows_background, notes);
    if (masks != 0) notes.push_back(shared::mask_note(masks, shots.size()));
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
    if (!std::all_of(other.image.rgb.begin(), other.image.rgb.end(), [](float value) { return std::isfinite(value); }))
        throw Error("--compare cannot be " + shared::one_line(path.string()) + " (a value of it is not finite); find what rendered it");
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
            auto image = shared::read_picture(photo.path, photo.size, background_of(options));
            if (!same(photo.size, {rendered.width, rendered.height})) image = report::resized_as_photograph(image, rendered.width, rendered.height);
            shared::apply_mask(image, photo.mask);
            photograph = OtherPicture{std::move(image), true};
            frame.photograph = compare_with(photo.path, rendered, *photograph);
        } catch (Error const& error) {
            frame.photograph->problem = error.what();
            return false;
        }
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
