#pragma once
#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/homes_layout.hpp>
#include <tilemesh/render/renderer_fields.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

namespace detail {
inline bool lacks(report::FrameReport const& r) noexcept { return !r.lost.empty() || r.gaussians.unplaced != 0 || r.gaussians.dropped != 0; }
inline std::string why_it_lacks(report::FrameReport const& r)
{
    auto const records = static_cast<std::uint64_t>(
        std::count_if(r.lost.begin(), r.lost.end(), [](auto const& loss) { return loss.tile == report::Loss::whole; }));
    auto const text = [](std::uint64_t n, char const* what) { return std::to_string(n) + " " + what + (n == 1 ? "" : "s"); };
    auto const copies = r.lost.size() - records;
    return (records == 0 ? "" : text(records, "record")) + (records != 0 && copies != 0 ? " and " : "") +
           (copies == 0 ? "" : copies == 1 ? "1 copy" : text(copies, "copie")) + " would be missing";
}
} // namespace detail

namespace render {

TILEMESH_HOST std::unique_ptr<Core> make_core(scene::Map map, Setup const& setup, RendererOptions const& options)
{
    bool const other = setup.program == splat::Program::homes || options.engine == EngineKind::checked;
#if defined(TILEMESH_COMPILED)
    if (other) return make_other_core(std::move(map), setup, options);
    HostRenderer::EngineOptions engine;
    engine.trace = options.trace;
    return std::make_unique<HostRenderer>(std::move(map), setup, options, std::move(engine));
#else
    if (make_other_core != nullptr) return make_other_core(std::move(map), setup, options);
    char const* const lacking = setup.program == splat::Program::homes                     ? "the program of homes"
                                : other                                                    ? "an engine that checks"
                                : options.trace                                            ? "a trace"
                                : setup.has_planes() || !setup.routes || !setup.blooms ? "a setup with planes, or without routing or bloom"
                                                                                           : nullptr;
    if (lacking != nullptr)
        throw Error(std::string(lacking) + " in a program that has headers alone (renderer.hpp has the whole anchored program on host threads); "
                                           "define TILEMESH_ALL_PROGRAMS in a source file that includes <tilemesh/all_programs.hpp>, or link "
                                           "tilemesh::compiled");
    using Policies = splat::PoliciesOf<splat::Referenced<splat::Lossless>>;
    return std::make_unique<FrameRenderer<Policies, Mesh, AnyMachine>>(std::move(map), setup, options, MeshOptions{});
#endif
}

} // namespace render

TILEMESH_HOST Renderer::Renderer(scene::Map map, RendererOptions const& options)
{
    auto const demand = scene::demand_of(map);
    make(scene::needed(std::move(map), demand), splat::fitted(splat::lossless, demand.sh_degree), options, {});
    hold_to(demand);
}

TILEMESH_HOST void Renderer::make(scene::Map map, render::Setup const& setup, RendererOptions const& options,
                                  std::optional<render::Setup> const& homes)
{
    using splat::Program;
    auto anchored = setup;
    if (options.sizes) anchored.sizes = *options.sizes;
    auto const program = setup.program != Program::anchored ? setup.program : options.program;
    if (setup.program != Program::homes) anchored.program = Program::anchored;
    auto const only = render::only_anchored(setup.program == Program::homes ? splat::lossless : setup, options);
    if (program == Program::homes && only)
        throw Error("the program of homes with " + only.text() + "; leave it out, or choose Program::anchored");
    auto const of_homes = homes ? *homes : setup.program == Program::homes ? setup : splat::as_homes(setup);
    if (program == Program::homes) {
        core_ = render::make_core(std::move(map), of_homes, options);
        return;
    }
    auto const records = map.gaussians.size();
    core_ = render::make_core(std::move(map), render::checked(anchored), options);
    if (program == Program::anchored || only) return;
    may_fit_ = render::may_fit_anchored(records, anchored, options);
    make_homes_ = [of_homes, within = render::within(of_homes, options)](scene::Map const& of) {
        return render::make_core(of, of_homes, within);
    };
}

TILEMESH_HOST void Renderer::render_into(splat::Camera const& camera, RenderedFrame& frame)
{
    core().require_idle();
    if (!make_homes_) return core().render_into(camera, frame);
    render::check_camera(camera);
    bool const fits = may_fit_.frame({camera.width, camera.height}), may_fit = may_fit_.records && fits;
    double before_ms = 0;
    std::string why = fits ? "the records have no room" : "the pixels have no room";
    if (may_fit) {
        core().render_into(camera, frame);
        if (!detail::lacks(frame.report)) return;
        before_ms = frame.report.host_ms.total;
        why = detail::why_it_lacks(frame.report);
    }
    bool observer_threw = false; // its Error says nothing about room
    try {
        auto homes = make_homes_(core().map());
        homes->rules() = core().rules();
        if (demand_) homes->hold_to(*demand_);
        if (observer_)
            homes->observe([&observer_threw, observer = observer_](SuperstepEvent const& event) {
                try {
                    observer(event);
                } catch (...) {
                    observer_threw = true;
                    throw;
                }
            });
        core_.swap(homes); // an observer sees the core that runs
        RenderedFrame again;
        try {
            core().render_into(camera, again);
        } catch (...) {
            core_.swap(homes);
            throw;
        }
        if (observer_) core().observe(observer_);
        again.report.host_ms.total += before_ms;
        frame = std::move(again);
        make_homes_ = nullptr;
        change_ = std::move(why);
    } catch (Error const& error) {
        if (observer_threw) throw;
        make_homes_ = nullptr;
        change_refused_ = error.what();
        if (!may_fit) core().render_into(camera, frame);
    }
}

TILEMESH_HOST void Renderer::hold_to(scene::Demand const& demand)
{
    core().hold_to(demand);
    demand_.emplace();
    demand_->scanned = demand.scanned;
    demand_->culled = demand.culled;
}

TILEMESH_HOST void Renderer::observe(Observer observer)
{
    core().observe(observer);
    observer_ = std::move(observer);
}

}} // namespace tilemesh
