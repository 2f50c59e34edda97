// test: without test asan, cost 3
#include "../report/html_elements.hpp"
#include "../splat/support.hpp"
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/cost_table.hpp>
#include <tilemesh/model/trace_page.hpp>
#include <tilemesh/track/pose_evaluator.hpp>

// The trace, the cost model and the page of an evaluation of a pose: they know its steps.
using namespace tilemesh;
using namespace tilemesh::track;

namespace {
template <class Program, class Machine>
using TracedMesh = Mesh<Program, Traced<Machine>>;
using Observed = BasicPoseEvaluator<TrackedByReference<splat::Lossless>, TracedMesh>;

std::string text_of(std::filesystem::path const& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
using tests::has;
/// The sum over the run of one operation of a kernel, by names; and the passes of the kernel.
std::uint64_t counted(Trace const& trace, std::string const& kernel, std::string const& operation)
{
    std::uint64_t sum = 0;
    for (auto const& s : trace.supersteps) {
        if (trace.kernels[s.step] != kernel) continue;
        auto const& names = trace.operations[s.step];
        auto const at = std::find(names.begin(), names.end(), operation) - names.begin();
        if (at == static_cast<std::ptrdiff_t>(names.size())) continue;
        for (auto const& t : s.tiles) sum += t.operations.count[at];
    }
    return sum;
}
std::uint64_t passes(Trace const& trace, std::string const& kernel)
{
    std::uint64_t n = 0;
    for (auto const& s : trace.supersteps) n += trace.kernels[s.step] == kernel ? 1 : 0;
    return n;
}
} // namespace

TEST_CASE("trace of an evaluation: the steps have names, operations and prices, and the page and the timeline show them")
{
    auto gaussians = support::cloud(200, 3);
    for (auto& g : gaussians)
        for (float& s : g.log_scale) s = std::min(s + 2.0f, -1.2f);
    auto const map = support::map_of(std::move(gaussians));
    auto const camera = support::lens(48, 80);
    Observed evaluator(map, {48, 80}, {1, {16, 40}}); // 3 x 2 tiles
    report::Image grey(48, 80);
    std::fill(grey.rgb.begin(), grey.rgb.end(), 0.5f);
    report::Plane depth(48, 80);
    std::fill(depth.values.begin(), depth.values.end(), 2.0f);
    evaluator.set_target({grey, depth});
    Grid const grid{3, 2};
    constexpr std::uint32_t pixels = 48 * 80;
    auto const folder = std::filesystem::temp_directory_path() / "tilemesh_pose_trace";
    std::filesystem::remove_all(folder);

    for (auto const jacobian : {Jacobian::forward, Jacobian::esm})
        for (bool const with_depth : {true, false}) {
            bool const forward = jacobian == Jacobian::forward;
            TrackOptions o;
            o.level.jacobian = jacobian;
            o.with_depth = with_depth;
            auto const sums = evaluator.evaluate(camera, o);
            CHECK(sums.pixels > 0);
            auto const& trace = evaluator.mesh().trace();
            // Forward mode or gradients ran, not both; the reduction takes W - 1 + H - 1 exchanges.
            CHECK(passes(trace, "composite with pose") == (forward ? 1 : 0));
            for (auto const* kernel : {"composite", "send cells", "add gradients"}) CHECK(passes(trace, kernel) == (forward ? 0 : 1));
            std::uint64_t reductions = 0;
            for (auto const& s : trace.supersteps) reductions += trace.kernels[s.step].rfind("sum sums of a tile", 0) == 0 && s.sent ? 1 : 0;
            CHECK(reductions == 2 + 1);

            std::uint64_t pairs = 0, n = 0;
            for (std::uint32_t i = 0; i < grid.size(); ++i) {
                auto const& work = evaluator.mesh().state<splat::Work>(grid.tile(i));
                for (auto const one : work.contributing) pairs += one;
                n += evaluator.mesh().state<splat::Order<Observed::Policies>>(grid.tile(i)).size();
            }
            if (forward) {
                auto const moving = counted(trace, "composite with pose", "moving_pair");
                CHECK(moving >= pairs); // all workers wait for the slowest
                CHECK(moving < 6 * pairs);
                CHECK(counted(trace, "composite with pose", "moving_depth") == (with_depth ? moving : 0));
                CHECK(counted(trace, "composite with pose", "row") == pixels * (with_depth ? 4 : 3));
                CHECK(counted(trace, "composite with pose", "splat_motions") == n * 42); // 40 rows of 16 pixels, 7 for each of 6 workers
            } else {
                CHECK(counted(trace, "send cells", "mean") == pixels);
                CHECK(counted(trace, "add gradients", "gradient") == sums.pixels * (with_depth ? 4 : 3));
            }
            auto const cost = model_cost(mk2(), trace, grid);
            std::uint64_t tracking = 0;
            for (auto const& s : step_costs(trace, cost))
                if (s.name == "composite with pose" || s.name == "add gradients") tracking += s.compute;
            CHECK(2 * tracking > cost.cycles); // this is what an evaluation spends its time on

            TracePage page;
            page.title = "A pose";
            auto const html = text_of(write_trace_page(folder, "pose", trace, mk2(), grid, page));
            auto const timeline = text_of(folder / "pose.trace.json"), tiles = text_of(folder / "pose.tiles.csv");
            for (auto const* kernel : {"composite with pose", "send cells", "add gradients"}) {
                bool const ran = forward == (std::string(kernel) == "composite with pose");
                CHECK(has(html, std::string("<td>") + kernel + "</td>"));
                CHECK(has(timeline, std::string("\"name\":\"") + kernel + "\"") == ran);
                CHECK(has(tiles, kernel) == ran);
            }
            CHECK(has(html, "sum sums of a tile"));
            CHECK(has(timeline, "sum sums of a tile"));
            CHECK(has(tiles, forward ? "moving_pair" : "gradient"));
        }

    // A subset of the blocks costs less; exposure costs more a row.
    TrackOptions all, some, exposed;
    some.one_in = 4;
    exposed.with_exposure = true;
    (void)evaluator.evaluate(camera, all);
    auto const rows = counted(evaluator.mesh().trace(), "composite with pose", "row");
    (void)evaluator.evaluate(camera, some);
    CHECK(counted(evaluator.mesh().trace(), "composite with pose", "row") < rows / 2);
    (void)evaluator.evaluate(camera, exposed);
    CHECK(counted(evaluator.mesh().trace(), "composite with pose", "row") > 3 * rows / 2);
    std::filesystem::remove_all(folder);
}
