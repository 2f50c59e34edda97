// test: unoptimised tsan, without asan, cost 20
// Planes, routing, bloom, the trace and the engine as words of a run: the renderer of all setups by reference (render::HostRenderer), and
// the renderers whose types say planes and steps, have the same pictures, reports, digests and tiles.
#include "references.hpp"
#include <tilemesh/render/homes_renderer.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using render::HostRenderer;
using support::make_runner;

namespace {

// One renderer serves the setups that differ in planes, steps, rules, sizes and degree. Setups with policies of their own have their own.
template <class S>
using CoreOf = typename BasicRenderer<Referenced<S>, PortMesh>::Core;
struct ColumnFirst : RowFirst {};
struct OwnRouting : support::Whole {
    using Routing = ColumnFirst;
};
struct OwnPixel : FloatPixel {};
static_assert(std::is_same_v<CoreOf<support::Whole>, HostRenderer> && std::is_same_v<CoreOf<support::Planes>, HostRenderer> &&
              std::is_same_v<CoreOf<support::Minimal>, HostRenderer> && std::is_same_v<CoreOf<support::DropScreens>, HostRenderer> &&
              std::is_same_v<CoreOf<Fitted<Paper, 3>>, HostRenderer>);
static_assert(!is_served_by_words<Referenced<OwnRouting>> && !is_served_by_words<Referenced<WithPixel<support::Whole, OwnPixel>>> &&
              !is_served_by_words<support::Whole>);
static_assert(std::is_same_v<BasicRenderer<support::Whole, PortMesh>::Core, BasicRenderer<support::Whole, Mesh>::Core>,
              "by value there is no port");

/// Two frames have the same pictures, planes, reports and digests.
void check_same(RenderedFrame const& a, RenderedFrame const& b)
{
    CHECK(support::differing_pixels(a.image, b.image) == 0);
    CHECK(support::differing(a.depth, b.depth) == 0);
    CHECK(support::differing(a.alpha, b.alpha) == 0);
    CHECK(report::first_difference(a.report, b.report) == "");
    CHECK(a.report.digests == b.report.digests);
}
/// Renders the cameras with the types of setup S by reference, and with its words on 1 and 2 threads and on the engine that checks.
/// Returns the digests of all frames.
template <class S>
std::vector<std::uint64_t> same_as_types(scene::Map const& map, RendererOptions options, std::vector<Camera> const& cameras)
{
    options.digest = true;
    auto const types = make_runner<Referenced<S>, Mesh>(map, options);
    HostRenderer::EngineOptions threads, checked;
    threads.trace = checked.trace = true;
    checked.make = make_checked_port<HostRenderer::Program>;
    auto more = options;
    more.threads = 2;
    auto const facts = render::setup_for<S>(options);
    HostRenderer one(map, facts, options, threads), two(map, facts, more, threads), checks(map, facts, options, checked);
    RenderedFrame frame, other;
    std::vector<std::uint64_t> digests;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        INFO("frame ", i);
        types->render_into(cameras[i], frame);
        for (auto* const renderer : {&one, &two, &checks}) {
            INFO("renderer ", renderer == &one ? 1 : renderer == &two ? 2 : 3);
            renderer->render_into(cameras[i], other);
            check_same(other, frame);
            CHECK(other.depth.values.empty() == !S::Pixel::has_depth);
            CHECK(other.alpha.values.empty() == !S::Pixel::has_alpha);
            CHECK(renderer->trace() == one.trace());
        }
        digests.insert(digests.end(), frame.report.digests.begin(), frame.report.digests.end());
    }
    CHECK(!digests.empty());
    return digests;
}
scene::Map cloud(std::uint32_t n, std::uint64_t seed) { return support::map_of(support::cloud(n, seed)); }
std::vector<Camera> views()
{
    std::vector<Camera> out;
    for (float turn : {0.0f, 0.0f, 0.02f, -0.4f, 3.1f, 0.01f}) out.push_back(support::lens(67, 41, turn));
    return out;
}

} // namespace

TEST_CASE("host words: planes")
{
    auto const plain = same_as_types<support::Whole>(cloud(150, 71), {.grid = {6, 5}}, views());
    CHECK(same_as_types<support::Planes>(cloud(150, 71), {.grid = {6, 5}}, views()) != plain); // the digests have the pixels
    (void)same_as_types<support::DropScreens>(cloud(150, 72), {.grid = {6, 5}, .channel_slots = 3}, views());
}

TEST_CASE("host words: frames without routing, without bloom, and without both; the digests leave out what these steps would keep")
{
    std::vector<Camera> const still{support::lens(67, 41), support::lens(67, 41), support::lens(67, 41, 0.02f)};
    (void)same_as_types<support::NoRouting>(cloud(150, 73), {.grid = {6, 5}}, views());
    (void)same_as_types<support::NoBloom>(cloud(150, 74), {.grid = {6, 5}}, views());
    (void)same_as_types<support::Minimal>(cloud(150, 75), {.grid = {6, 5}}, still);
    (void)same_as_types<support::Minimal>(cloud(400, 76), {.grid = {6, 5}, .storage_slots = 30}, still);
}

TEST_CASE("host words: full storage, where the host recalls copies and the program runs twice")
{
    auto cameras = views();
    for (float z : {-30.0f, -30.0f, 0.0f, -10.0f, 0.5f}) {
        cameras.push_back(support::lens(67, 41));
        cameras.back().position[2] = z;
    }
    (void)same_as_types<support::Whole>(cloud(400, 31), {.grid = {6, 5}, .storage_slots = 22}, cameras);
}

TEST_CASE("host words: a renderer on a machine that is not Traced keeps no trace, and says so")
{
    BasicRenderer<Referenced<Lossless>, PortMesh> plain(cloud(20, 77), {.grid = {3, 3}});
    (void)plain.render(support::lens(30, 20));
    CHECK_THROWS_AS((void)plain.trace(), Error);
    struct Watched : support::Whole {
        using Machine = Traced<support::Whole::Machine>;
    };
    BasicRenderer<Referenced<Watched>, PortMesh> watched(cloud(20, 77), {.grid = {3, 3}});
    (void)watched.render(support::lens(30, 20));
    CHECK(watched.trace().supersteps.size() > 3);
}

TEST_CASE("host words: a renderer by types refuses the facts of a setup with other steps or planes")
{
    using Types = BasicRenderer<Referenced<support::Whole>, Mesh>::Core;
    auto const make = [](render::Setup const& facts) { Types(cloud(5, 1), facts, {}, {}); };
    make(render::setup_for<support::Whole>());
    CHECK_THROWS_AS(make(render::setup_for<support::NoRouting>()), Error);
    CHECK_THROWS_AS(make(render::setup_for<support::Minimal>()), Error);
    CHECK_THROWS_AS(make(render::setup_for<support::Planes>()), Error);
}

TEST_CASE("host words: the program of homes, with and without planes, on threads and sequentially")
{
    using Planes = WithAlpha<WithDepth<FloatPixel>>;
    auto const map = cloud(support::fast() ? 80 : 200, 78);
    RendererOptions const options{.grid = {4, 3}, .digest = true};
    auto more = options;
    more.threads = 2;
    for (auto const& planes : {std::pair{false, false}, {true, false}, {false, true}, {true, true}}) {
        bool const depth = planes.first, alpha = planes.second;
        INFO("depth ", depth, ", alpha ", alpha);
        auto choice = splat::homes_setup;
        choice.machine.sram_bytes = 1u << 24;
        choice.sizes = splat::homes::homes_sizes(100, 12, 3, 2); // several rounds
        choice.depth = depth;
        choice.alpha = alpha;
        std::unique_ptr<render::Core> types;
        if (depth || alpha) types = std::make_unique<render::HomesRenderer<homes::HostPolicies<Planes>>>(map, choice, options);
        else types = std::make_unique<render::HomesRenderer<homes::HostPolicies<>>>(map, choice, options);
        render::HostHomesRenderer::EngineOptions threads, checked;
        threads.trace = checked.trace = true;
        checked.make = make_checked_port<render::HostHomesRenderer::Program>;
        render::HostHomesRenderer two(map, choice, more, threads), checks(map, choice, options, checked);
        for (auto const& camera : views()) {
            auto const frame = types->render(camera);
            for (auto* const renderer : {&two, &checks}) {
                auto const other = renderer->render(camera);
                check_same(other, frame);
                CHECK(frame.depth.values.empty() == !depth);
                CHECK(renderer->trace() == two.trace());
            }
        }
    }
}
