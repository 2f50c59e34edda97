#include "track.hpp"
#include <algorithm>
#include <cstdlib>
#include <tilemesh/error.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/track/pose_evaluator.hpp>
#include <utility>
#include <vector>

namespace track_bench {

namespace {

using OnMk2 = track::TrackedByReference<splat::Lossless>;
struct Roomy : OnMk2 {
    using Machine = splat::RoomyMachine;
};
template <class Program, class Machine>
using TracedMesh = tilemesh::Mesh<Program, tilemesh::Traced<Machine>>;

template <class Setup, template <class, class> class Engine>
class Over final : public Evaluator {
public:
    Over(View const& view, track::EvaluatorOptions const& options) : evaluator_(view.map, {view.camera.width, view.camera.height}, options)
    {
        evaluator_.options().scene_depth = static_cast<float>(view.scale);
    }
    void set_target(report::Image colour, report::Plane depth) override { evaluator_.set_target({std::move(colour), std::move(depth)}); }
    void ask(Asked asked) override
    {
        auto& o = evaluator_.options();
        o.with_depth = asked.depth, o.with_exposure = asked.exposure, o.one_in = asked.one_in, o.seed = asked.seed;
    }
    track::NormalEquations operator()(splat::Camera const& camera, track::Level const& level) override { return evaluator_(camera, level); }
    std::uint64_t contributing() override
    {
        std::uint64_t sum = 0;
        for_each([&](auto const& mesh, tilemesh::TileId tile) {
            auto const& work = mesh.template state<splat::Work>(tile);
            for (auto const n : work.contributing) sum += n;
        });
        return sum;
    }
    std::uint32_t most_stored() override
    {
        std::uint32_t most = 0;
        for_each([&](auto const& mesh, tilemesh::TileId tile) { most = std::max(most, mesh.template state<splat::Marks<Policies>>(tile).size()); });
        return most;
    }
    tilemesh::Grid grid() override { return evaluator_.mesh().grid(); }
    tilemesh::Extent2 tile() override { return {evaluator_.tiling().tile_width, evaluator_.tiling().tile_height}; }
    std::uint32_t slots() override { return evaluator_.sizes().storage; }
    tilemesh::Trace const& trace() override
    {
        if constexpr (std::is_same_v<Engine<typename Type::Program, tilemesh::AnyMachine>, TracedMesh<typename Type::Program, tilemesh::AnyMachine>>)
            return evaluator_.mesh().trace();
        else
            std::abort(); // the caller asked for no trace
    }

private:
    using Type = track::BasicPoseEvaluator<Setup, Engine>;
    using Policies = typename Type::Policies;
    template <class F>
    void for_each(F const& f)
    {
        auto const& mesh = std::as_const(evaluator_.mesh());
        for (std::uint32_t i = 0; i < mesh.grid().size(); ++i) f(mesh, mesh.grid().tile(i));
    }
    Type evaluator_;
};

} // namespace

std::unique_ptr<Evaluator> make_evaluator(View const& view, std::uint32_t threads, On where)
{
    if (where == On::roomy) return std::make_unique<Over<Roomy, tilemesh::Mesh>>(view, track::EvaluatorOptions{threads, {16, 40}});
    if (where == On::mk2_traced) return std::make_unique<Over<OnMk2, TracedMesh>>(view, track::EvaluatorOptions{threads, {}});
    return std::make_unique<Over<OnMk2, tilemesh::Mesh>>(view, track::EvaluatorOptions{threads, {}});
}

View load_view(std::string const& name, std::filesystem::path const& data, scene::Size size)
{
    View view;
    if (name == "built_in") {
        view.map = scene::built_in_map();
        view.camera = scene::built_in_camera(size);
    } else {
        view.map = scene::load_ply(data / "maps" / (name + ".ply"));
        auto const cameras = scene::select_cameras(scene::load_cameras(data / "cameras.json"), name + "/front", name);
        view.camera = scene::resized(cameras.front().camera, size.width, size.height);
    }
    tilemesh::Renderer renderer(view.map, splat::with_planes(splat::lossless, true, true));
    auto frame = renderer.render(view.camera);
    if (!frame.report.lost.empty()) throw tilemesh::Error(name + " does not fit (records are lost); choose another scene");
    std::vector<float> depths;
    for (std::size_t i = 0; i < frame.depth.values.size(); ++i) {
        if (frame.alpha.values[i] > 0.5f) depths.push_back(frame.depth.values[i]);
        else frame.depth.values[i] = 0;
    }
    if (depths.empty()) throw tilemesh::Error(name + " shows nothing (no pixel is half covered); choose another scene");
    auto const middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    view.scale = double{*middle};
    view.colour = std::move(frame.image);
    view.depth = std::move(frame.depth);
    return view;
}

} // namespace track_bench
