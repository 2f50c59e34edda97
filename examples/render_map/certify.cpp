#include "certify.hpp"
#include "../shared/text.hpp"
#include "outputs.hpp"
#include <cmath>
#include <limits>
#include <tilemesh/report/causes.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/scene/records.hpp>

namespace {

using tilemesh::report::Image;
using tilemesh::report::Plane;

/// The least or the greatest value of a number, rounded outward: the sum and its conversion are off by less than a float.
float bound(double middle, double radius, bool upper)
{
    float const outward = upper ? std::numeric_limits<float>::infinity() : -std::numeric_limits<float>::infinity();
    return std::nextafter(static_cast<float>(upper ? middle + radius : middle - radius), outward);
}

} // namespace

tilemesh::report::Image render_map::bound_of(tilemesh::report::Enclosure const& e, bool upper)
{
    Image picture{e.width, e.height};
    for (std::size_t i = 0; i < picture.rgb.size(); ++i) picture.rgb[i] = bound(e.middle[i], e.radius[i], upper);
    return picture;
}

namespace {

void write_bounds(render_map::Options const& options, std::size_t frame, tilemesh::report::Enclosure const& e)
{
    for (bool const upper : {false, true}) {
        auto const path = [&](std::string const& what) {
            return render_map::frame_path(options, frame, what + (upper ? ".upper.pfm" : ".lower.pfm"));
        };
        tilemesh::report::write_pfm(path(""), render_map::bound_of(e, upper), render_map::outlasts(options));
        auto const plane = [&](std::string const& what, tilemesh::report::Enclosure::OfPlane const& of) {
            Plane out{e.width, e.height};
            for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] = bound(of.middle[i], of.radius[i], upper);
            tilemesh::report::write_pfm(path(what), out, render_map::outlasts(options));
        };
        if (options.choice.depth) plane(".depth", e.depth);
        if (options.choice.alpha) plane(".alpha", e.alpha);
    }
}

std::string at_worst(tilemesh::report::Certificate const& c)
{
    if (c.worst.empty()) return "";
    auto const& worst = c.worst.front();
    auto text = "; farthest at pixel " + std::to_string(worst.x) + ", " + std::to_string(worst.y) + ", most likely cause: " + worst.cause.word;
    if (worst.cause.id != 0) text += " of Gaussian " + std::to_string(worst.cause.id);
    if (worst.cause.other_id != 0) text += " and " + std::to_string(worst.cause.other_id);
    return text;
}

} // namespace

std::string render_map::certify(Options const& options, tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera,
                                tilemesh::splat::Rules const& rules, std::size_t frames, Frame& frame, std::optional<OtherPicture> const& other)
{
    namespace report = tilemesh::report;
    auto const threads = options.renderer.threads;
    bool const planes = options.choice.depth || options.choice.alpha;
    tilemesh::scene::visit_records(map, [&](auto const& records) {
        auto const enclosure = report::enclose(records, camera, rules, {.threads = threads, .planes = planes});
        if (options.pfm) write_bounds(options, frame.index, enclosure);
        auto const judge = [&](Image const& picture, report::Written const& written) {
            auto out = report::certify(enclosure, picture, written);
            report::explain(out, enclosure, records, camera, rules, picture, written, threads);
            return out;
        };
        auto& own = frame.entry.certified.emplace(judge(frame.rendered.image, {}));
        if (options.choice.depth) own.depth = report::certify(enclosure.depth, frame.rendered.depth);
        if (options.choice.alpha) own.alpha = report::certify(enclosure.alpha, frame.rendered.alpha);
        if (other) frame.entry.compared_certified = judge(other->image, {other->ends_at_1, other->ends_at_1 ? 0.5 / 255 : 0.0});
        return 0;
    });
    auto const& own = *frame.entry.certified;
    auto text = (frames == 1 ? "certified: " : "frame " + std::to_string(frame.index) + " is certified: ") + report::text_of(own) + at_worst(own);
    if (auto const& c = frame.entry.compared_certified)
        text += ". " + shared::one_line(options.compare->string()) + (other->ends_at_1 ? ", clamped to [0, 1] and apart from the half level of its 8 bits: " : ": ") +
                report::text_of(*c) + at_worst(*c);
    return text;
}
