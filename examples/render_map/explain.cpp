#include "explain.hpp"
#include "../shared/text.hpp"
#include "ranks.hpp"
#include <cstdint>
#include <span>
#include <string>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/quality.hpp>

namespace render_map {

namespace {

namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
using tilemesh::report::thousands;

/// The bytes that a step takes on a tile, without its share of the storage.
std::uint64_t bytes_of(tilemesh::splat::Setup setup, bool tilemesh::splat::Setup::*step)
{
    auto const with = tilemesh::splat::frame_bytes(setup, 0);
    setup.*step = false;
    return with - tilemesh::splat::frame_bytes(setup, 0);
}

/// The bytes that routing takes on a tile of `lossless` with records of this degree.
std::uint64_t routing_bytes(std::uint32_t degree)
{
    namespace render = tilemesh::render;
    auto const setup = render::fitted(tilemesh::splat::lossless, degree, true, true);
    return bytes_of(setup, &tilemesh::splat::Setup::routes);
}

std::uint64_t bloom_bytes()
{
    return bytes_of(tilemesh::splat::lossless, &tilemesh::splat::Setup::blooms);
}

/// The first option that explores the machine as it is; empty: none.
std::string exploring_option(Options const& o)
{
    if (o.choice.trace) return "--trace";
    if (!o.choice.fit) return "--fit off";
    if (auto const preset = o.choice.preset(); preset != "lossless") return "--preset " + preset;
    if (o.choice.engine != EngineKind::threads) return "--engine sequential";
    if (o.renderer.hops != 0) return "--hops";
    if (o.channel_slots) return "--channel-slots";
    if (o.storage_slots) return "--storage-slots";
    using tilemesh::render::SetupField;
    for (auto const& field : tilemesh::render::setup_fields) // ranks alone need no record that is not seen
        if (field.use == SetupField::everyone && field.name != "priority" && o.choice.names(field.name)) return "--" + std::string(field.name);
    if (o.choice.planes()) return o.choice.depth ? "--depth" : "--alpha";
    return {};
}

std::string bytes_a_tile(std::uint64_t bytes)
{
    return thousands(bytes) + " bytes a tile";
}

std::string of_all(std::uint64_t n, std::uint64_t all)
{
    return thousands(n) + " of " + thousands(all) + (all == 1 ? " record" : " records");
}

} // namespace

Needs needs_of(Options const& options, scene::Map const& map, std::vector<splat::Camera> const& path)
{
    Needs needs;
    splat::Rules rules;
    if (options.choice.preset() != "lossless") rules.footprint = splat::Paper::footprint;
    rules = tilemesh::with_options(rules, options.renderer);
    if (ranks::number() > 1)
        needs.seen = ranks::parts().demand_of(path, rules, options.renderer);
    else
        needs.seen = scene::demand_of(map, std::span(path), rules, [&](splat::Camera const& camera) {
            return tilemesh::tiling_for(options.renderer, camera.width, camera.height);
        });
    needs.used = needs.seen;
    needs.kept_because = exploring_option(options);
    if (!needs.kept_because.empty()) {
        needs.used.moves = needs.used.spans = true;
        needs.used.visible.clear();
        needs.used.culled = 0;
    }
    if (!options.choice.fit) needs.used.sh_degree = map.sh_degree;
    return needs;
}

std::vector<tilemesh::report::RunReport::Feature> features(Options const& options, Needs const& needs, scene::Map const& map,
                                                           std::uint32_t file_degree, tilemesh::Renderer const& renderer)
{
    auto const& seen = needs.seen;
    std::vector<tilemesh::report::RunReport::Feature> out;
    auto const idle = [&](std::string const& why) {
        return why + "; kept: " + (needs.kept_because.empty() ? "a machine with routing or harmonics has bloom too" : needs.kept_because);
    };

    auto const degree = renderer.setup().sh_degree;
    std::string colour;
    if (file_degree > map.sh_degree) colour = "--sh-degree " + std::to_string(map.sh_degree) + " of the map's " + std::to_string(file_degree);
    else if (map.sh_degree == 0) colour = "the map has none";
    else if (seen.sh_degree == 0) colour = "its coefficients are 0";
    else colour = of_all(seen.shaded, seen.gaussians) + " have coefficients, up to degree " + std::to_string(seen.sh_degree);
    if (degree > seen.sh_degree) colour += "; kept for degree " + std::to_string(degree);
    auto const limit = options.renderer.storage_slots;
    out.push_back({"view-dependent colour", degree != 0,
                   colour + "; a record of " + std::to_string(tilemesh::render::record_bytes(renderer.setup())) + " bytes, " +
                       thousands(limit != 0 ? limit : renderer.setup().sizes.storage) + " slots a tile"});

    bool const homes = options.renderer.program == tilemesh::report::Program::homes;
    bool const still = !seen.moves;
    std::string const views = thousands(seen.views) + (seen.views == 1 ? " view" : " views");
    if (homes) out.push_back({"routing", false, "records stay on their homes, which send the splats of each view (--program homes)"});
    else if (!renderer.setup().routes)
        out.push_back({"routing", false,
                       (seen.views == 1 ? "one view, so nothing moves" : "all " + views + " are the same, so nothing moves") +
                           std::string("; the host puts each record onto its anchor tile; frees ") +
                           bytes_a_tile(routing_bytes(degree))});
    else
        out.push_back({"routing", true, still ? idle(views + ", nothing moves") : views + " that differ: anchors may change"});

    auto const footprint = "the largest footprint touches " + std::to_string(seen.footprint_columns) + " x " +
                           std::to_string(seen.footprint_rows) + " tiles" +
                           (seen.views > scene::views_scanned_whole ? " in the views looked at" : "");
    if (homes) out.push_back({"bloom", false, footprint + "; homes send a splat to each of them (--program homes)"});
    else if (!renderer.setup().blooms)
        out.push_back({"bloom", false, footprint + "; frees " + bytes_a_tile(bloom_bytes())});
    else
        out.push_back({"bloom", true, seen.spans ? footprint : idle(footprint)});

    out.push_back({"records", needs.used.culled == 0,
                   seen.culled == 0 ? "each has something on screen in some view"
                   : needs.used.culled == 0
                       ? idle(of_all(seen.culled, seen.gaussians) + " have nothing on screen in any view")
                       : of_all(seen.culled, seen.gaussians) + " have nothing on screen in any view: not loaded" +
                             (seen.too_faint == 0 ? "" : " (" + thousands(seen.too_faint) + " are too faint for any)")});

    bool const clamps = options.choice.preset() != "lossless" || options.renderer.quality == splat::Quality::training;
    out.push_back({"clamp at 0.99", clamps,
                   of_all(seen.nearly_opaque, seen.gaussians) + " are more opaque than that (opacity is " +
                       tilemesh::significant(double{seen.least_opacity}, 3) + " to " +
                       tilemesh::significant(double{seen.greatest_opacity}, 3) + ")" +
                       (clamps ? ", and the preset or the quality clamps" : "; preset lossless never clamps")});
    out.push_back({"order by id", true,
                   seen.ties == 0 ? "no two records have one depth in the first view, but they may in another"
                                  : of_all(seen.ties, seen.gaussians) + " have the depth of another in the first view"});
    auto const plane = [&](char const* name, bool asked, bool kept) {
        out.push_back({name, kept, asked ? "asked for" : "not asked for: 4 bytes less a pixel"});
    };
    plane("depth", options.choice.depth, renderer.setup().depth);
    plane("alpha", options.choice.alpha, renderer.setup().alpha);
    return out;
}

void explain(std::ostream& out, tilemesh::report::RunReport const& run)
{
    out << "what map " << shared::one_line(run.map.name) << " and its cameras need:\n";
    for (auto const& feature : run.features) {
        std::string line = "  " + feature.name;
        line.resize(25, ' ');
        out << line << (feature.kept ? "kept      " : "left out  ") << feature.why << '\n';
    }
}

} // namespace render_map
