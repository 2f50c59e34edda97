#include "any_map.hpp"
#include <common/homes_machine.hpp>
#include <common/machine.hpp>
#include <common/pictures.hpp>
#include <iostream>
#include <optional>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/splat/setup_types.hpp>

namespace any_map {

namespace {

namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
using tilemesh::report::Image;

/// A view: the frames that lead to it, and itself last.
struct View {
    std::string name;
    std::vector<splat::Camera> cameras;
};

/// The camera at `times` its distance from the middle of the map, in the same direction.
splat::Camera farther(bench::Scene const& s, double times)
{
    auto pose = scene::pose_of(s.camera);
    auto const middle = scene::robust_centre(s.map);
    pose.position = middle + times * (pose.position - middle);
    return scene::make_camera(pose, scene::lens_of(s.camera));
}
std::vector<View> views_of(bench::Scene const& s, Options const& options)
{
    auto const turned = [&](splat::Camera const& from, double degrees) { return scene::orbit(from, scene::robust_centre(s.map), degrees, 2); };
    std::vector<View> views{{"whole", {s.camera}}, {"0.5 degrees on", turned(s.camera, 0.5)}};
    auto const far = farther(s, 4);
    if (!options.quick) views.push_back({"2 degrees on", turned(s.camera, 2)});
    views.push_back({"teleport", bench::cameras_of("teleport", s, 1, options.data)});
    views.push_back({"4 x farther", {far}});
    if (!options.quick) {
        views.push_back({"4 x farther, 0.5 degrees on", turned(far, 0.5)});
        views.push_back({"16 x farther", {farther(s, 16)}});
        views.push_back({"inside", {farther(s, 0)}});
    }
    for (std::string const motion : {"fr1_xyz", "fr2_desk"})
        if (!options.quick && bench::has_motion(motion, options.data))
            views.push_back({motion, bench::cameras_of(motion, s, motion_frames, options.data)});
    return views;
}

Part part_of(std::string const& kernel)
{
    struct {
        char const* kernel;
        Part part;
    } const all[] = {{"project", Part::project}, {"begin", Part::project},    {"tell", Part::tell},       {"offer", Part::offer},
                     {"deliver", Part::deliver}, {"route", Part::deliver},    {"bloom", Part::deliver},   {"depth sort", Part::sort},
                     {"sort runs", Part::sort},  {"merge", Part::sort},       {"blend", Part::blend},     {"composite", Part::blend},
                     {"advance", Part::advance}, {"finish", Part::finish}};
    for (auto const& known : all)
        if (kernel == known.kernel) return known.part;
    throw tilemesh::Error("kernel " + kernel + " has no column (this bench does not know it); give it one in measure.cpp");
}

class Measurement {
public:
    Measurement(bench::Scene const& s, Options const& options, std::vector<Row>& rows, std::vector<std::string>& broken)
        : scene_(s), options_(options), grid_(options.quick ? tilemesh::Grid{10, 9} : tilemesh::Grid{40, 36}), rows_(rows), broken_(broken), views_(views_of(s, options)),
          pictures_(views_.size())
    {}

    void all_views()
    {
        if (scene_.map.name == "built_in_5m") { // too large for the anchored program, and minutes on the host for each view
            for (std::size_t v = 0; v < 2; ++v) homes(v, {}, false);
            return;
        }
        for (std::size_t v = 0; v < views_.size(); ++v) {
            for (auto const program : {Program::anchored, Program::paper}) on_anchors(v, program);
            for (bool const folded : {true, false}) homes(v, {.folded = folded}, false);
            homes(v, {.folded = false, .one_cut = true}, false);
        }
    }
    void sweep()
    {
        std::size_t const view = 1;
        std::vector<std::uint32_t> held{16, 32, 64, 125, 250, 500, 1000, 1500, 2000, 2500, 3000, 4000};
        std::vector<std::uint32_t> slots{2, 5, 10, 20, 50, 100, 140, 200, 300, 400};
        if (options_.quick) held = {16, 125, 4000}, slots = {2, 20, 400};
        homes(view, {}, true);
        if (options_.quick) { // in three chapters
            homes(view, {.homes = static_cast<std::uint32_t>(scene_.map.gaussians.size()) / grid_.size() / 3 + 1}, true);
            if (rows_.back().chapters != 3) complain(rows_.back(), std::to_string(rows_.back().chapters) + " chapters, not 3");
        }
        for (auto const k : held) homes(view, {.held = k}, true);
        for (auto const c : slots) homes(view, {.slots = c}, true);
    }

private:
    Row& add(std::size_t view, Program program)
    {
        Row row;
        row.map = scene_.map.name;
        row.view = views_[view].name;
        row.program = program;
        row.gaussians = scene_.map.gaussians.size();
        rows_.push_back(row);
        return rows_.back();
    }
    /// The exact picture of a view, rendered once by the naive loop.
    Image const& exact(std::size_t view)
    {
        auto& picture = pictures_[view];
        if (!picture) {
            splat::Rules rules = tilemesh::splat::setup_of<splat::Lossless>().rules;
            rules.arithmetic = splat::Arithmetic::precise;
            if (options_.spoil) rules.alpha_max = bench::spoilt_alpha_max;
            picture = tilemesh::report::render_naive(scene_.map.gaussians, views_[view].cameras.back(), rules);
        }
        return *picture;
    }
    void complain(Row const& row, std::string const& what)
    {
        broken_.push_back(row.map + ", " + row.view + ", " + to_string(row.program) + ", K = " + std::to_string(row.held) + ", " +
                          std::to_string(row.slots) + " slots: " + what);
    }
    /// The numbers that all programs have.
    void fill(Row& row, std::size_t view, tilemesh::report::FrameReport const& r, tilemesh::Trace const& trace, Image const& image)
    {
        row.exchanges = r.exchanges.total();
        row.hops = r.hops;
        row.host_ms = r.host_ms.total - r.host_ms.picture;
        auto const cost = tilemesh::model_cost(bench::mk2_model(), trace, grid_);
        for (auto const& s : cost.supersteps) row.cycles[static_cast<std::uint32_t>(part_of(trace.kernels[s.step]))] += s.total();
        row.cycles[static_cast<std::uint32_t>(Part::host_link)] =
            (row.streamed_bytes * tilemesh::price_of(bench::mk2_model(), tilemesh::host_byte) + 999) / 1000;
        row.psnr_db = bench::psnr(image, exact(view));
        row.fits = row.sram_bytes <= tilemesh::Mk2::sram_bytes;
        if (row.missing == 0 && row.program != Program::paper && !std::isinf(row.psnr_db))
            complain(row, "nothing is missing and the picture is not the naive one");
        std::cerr << row.map << ", " << row.view << ", " << to_string(row.program) << ", K = " << row.held << ", " << row.slots << " slots\n";
    }
    void on_anchors(std::size_t view, Program program)
    {
        auto& row = add(view, program);
        auto setup = program == Program::paper ? tilemesh::splat::setup_of<splat::Paper>() : tilemesh::splat::setup_of<splat::Lossless>();
        setup.rules.arithmetic = splat::Arithmetic::precise;
        auto const machine = bench::make_traced_machine(
            scene_.map, setup, {.threads = options_.threads, .grid = {grid_.width, grid_.height}, .keep_pixels = false});
        for (auto const& camera : views_[view].cameras) machine->render(camera);
        auto const& r = machine->report();
        row.held = setup.sizes.storage;
        row.slots = setup.sizes.road;
        row.entries = r.copies;
        row.missing = r.lost.size();
        row.sram_bytes = setup.machine.sram_bytes;
        fill(row, view, r, machine->trace(), machine->image());
    }
    void homes(std::size_t view, bench::HomesSetting setting, bool sweep)
    {
        auto& row = add(view, setting.one_cut ? Program::one_cut : setting.folded ? Program::homes : Program::unfolded);
        setting.threads = options_.threads;
        setting.grid = grid_;
        auto const machine = bench::make_homes_machine(scene_.map, setting);
        for (auto const& camera : views_[view].cameras) machine->render(camera);
        auto const& r = machine->report();
        row.sweep = sweep;
        row.held = machine->setting().held;
        row.slots = machine->setting().slots;
        row.chapters = r.homes.chapters;
        row.streamed_bytes = r.homes.streamed_bytes;
        row.rounds = r.homes.rounds;
        row.entries = r.homes.entries;
        row.refused = r.homes.refused;
        row.sram_bytes = machine->sram_bytes();
        if (r.homes.unfinished_tiles != 0) complain(row, std::to_string(r.homes.unfinished_tiles) + " tiles are not finished");
        if (machine->trace().supersteps.size() != r.passes.total()) complain(row, "the trace lacks a pass");
        if (r.peak_storage > row.held || r.peak_channel > row.slots) complain(row, "a list held more than its slots");
        fill(row, view, r, machine->trace(), machine->image());
    }

    bench::Scene const& scene_;
    Options const& options_;
    tilemesh::Grid grid_; ///< the paper's; the small picture has a small one, so that its tiles have several blocks, too
    std::vector<Row>& rows_;
    std::vector<std::string>& broken_;
    std::vector<View> views_;
    std::vector<std::optional<Image>> pictures_;
};

} // namespace

double milliseconds(std::uint64_t cycles)
{
    return tilemesh::milliseconds(bench::mk2_model(), cycles);
}

void measure(bench::Scene const& s, Options const& options, bool sweeps, std::vector<Row>& rows, std::vector<std::string>& broken)
{
    Measurement m(s, options, rows, broken);
    m.all_views();
    if (sweeps) m.sweep();
}

} // namespace any_map
