// test: unoptimised test asan, cost 6
// The public doors: every renderer refuses the same maps, cameras, rules and options, with one line, and renders as before afterwards.
#include "../splat/support.hpp"
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/demand.hpp>

using namespace tilemesh;
using report::Program;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity(), not_a_number = std::numeric_limits<float>::quiet_NaN();

struct Door {
    char const* name;
    std::function<Renderer(scene::Map const&, RendererOptions const&)> make;
};
std::vector<Door> doors()
{
    auto const of = [](Program program) {
        return [program](scene::Map const& map, RendererOptions options) {
            options.program = program;
            return Renderer(map, options);
        };
    };
    return {{"anchored", of(Program::anchored)},
            {"homes", of(Program::homes)},
            {"automatic", of(Program::automatic)},
            {"a setup", [](scene::Map const& map, RendererOptions const& options) {
                 auto setup = splat::fitted(splat::lossless, map.sh_degree);
                 setup.reusable = false;
                 return Renderer(map, setup, options);
             }},
            {"a setup of homes", [](scene::Map const& map, RendererOptions const& options) {
                 auto setup = splat::homes_setup;
                 setup.sh_degree = map.sh_degree;
                 return Renderer(map, setup, options);
             }}};
}
scene::Map cloud() { return support::map_of(support::cloud(60, 4)); }
splat::Camera sound() { return support::lens(64, 48); }

/// The error of this; it is one line, "<problem> (<why>); <what to do>".
template <class F>
std::string refusal(F const& f)
{
    auto const text = tests::error_of(f);
    CHECK(!tests::has(text, "\n"));
    CHECK((text.empty() || (tests::has(text, " (") && tests::has(text, "); "))));
    return text;
}
struct BadCamera {
    std::string what;
    splat::Camera camera;
};
std::vector<BadCamera> bad_cameras()
{
    std::vector<BadCamera> out;
    for (std::size_t word = 0; word < 17; ++word) // rotation, position, fx, fy, cx, cy, near
        for (float const value : {infinity, -infinity, not_a_number}) {
            auto camera = sound();
            std::memcpy(reinterpret_cast<char*>(&camera) + word * sizeof value, &value, sizeof value);
            out.push_back({"word " + std::to_string(word), camera});
        }
    for (float splat::Camera::*const member : {&splat::Camera::fx, &splat::Camera::fy, &splat::Camera::near_depth})
        for (float const value : {0.0f, -0.0f, -1.0f}) {
            auto camera = sound();
            camera.*member = value;
            out.push_back({"a member not above 0", camera});
        }
    for (char const* const fault : {"zero", "mirrored", "sheared", "scaled", "transposed and scaled"}) {
        auto camera = support::lens(64, 48, 0.3f);
        auto& r = camera.rotation;
        for (int i = 0; i < 3; ++i) {
            if (*fault == 'z') r[0][i] = r[1][i] = r[2][i] = 0;
            if (*fault == 'm') r[0][i] = -r[0][i];
            if (fault[1] == 'h') r[0][i] += 0.01f * r[1][i];
            if (fault[1] == 'c') r[1][i] *= 1.01f;
            if (*fault == 't') r[2][i] *= 2.0f;
        }
        out.push_back({fault, camera});
    }
    for (float const focal : {1e-3f, 3e7f}) { // less than a thousandth of the width; more than 2^24
        auto camera = sound();
        camera.fx = focal;
        out.push_back({"a focal length", camera});
    }
    for (std::uint32_t splat::Camera::*const member : {&splat::Camera::width, &splat::Camera::height})
        for (std::uint32_t const value : {0u, 65536u, 0xffffffffu}) {
            auto camera = sound();
            camera.*member = value;
            out.push_back({"a side", camera});
        }
    return out;
}

} // namespace

TEST_SUITE_BEGIN("render");

TEST_CASE("every renderer refuses a camera that is not finite, not above 0, no rotation, or has no size; and goes on")
{
    for (auto const& door : doors()) {
        INFO(door.name);
        auto renderer = door.make(cloud(), {});
        auto const before = renderer.render(sound());
        for (auto const& bad : bad_cameras()) {
            INFO(bad.what);
            CHECK_FALSE(refusal([&] { (void)renderer.render(bad.camera); }).empty());
        }
        CHECK(support::differing_pixels(renderer.render(sound()).image, before.image) == 0);
    }
}

TEST_CASE("an observer that renders, prepares, prefetches or observes with its own renderer gets an error, and its frame goes on")
{
    auto const turned = support::lens(64, 48, 0.2f);
    for (auto const& door : doors()) {
        INFO(door.name);
        auto renderer = door.make(cloud(), {});
        (void)renderer.render(sound());
        bool const homes = renderer.setup().program == splat::Program::homes; // they prepare nothing
        int calls = 0;
        renderer.observe([&](SuperstepEvent const&) {
            ++calls;
            for (auto const& camera : {sound(), turned, support::lens(640, 480)}) CHECK_FALSE(refusal([&] { (void)renderer.render(camera); }).empty());
            CHECK(homes == refusal([&] { renderer.prepare(640, 480); }).empty());
            CHECK_FALSE(refusal([&] { (void)renderer.prefetch(sound()); }).empty());
            CHECK_FALSE(refusal([&] { renderer.observe({}); }).empty());
            renderer.rules().background[1] = 0.5f; // of the next frame
        });
        auto const seen = renderer.render(turned);
        CHECK(calls > 0);
        CHECK(support::differing_pixels(seen.image, door.make(cloud(), {}).render(turned).image) == 0);
    }
}

TEST_CASE("what an observer throws comes out of render, and the next frame is whole")
{
    auto const turned = support::lens(64, 48, 0.2f);
    for (auto const& door : doors()) {
        INFO(door.name);
        auto renderer = door.make(cloud(), {});
        renderer.observe([](SuperstepEvent const&) { throw Error("enough (of this); stop"); });
        CHECK(refusal([&] { (void)renderer.render(turned); }) == "enough (of this); stop");
        CHECK(renderer.change_refused().empty());
        renderer.observe({});
        CHECK(support::differing_pixels(renderer.render(turned).image, door.make(cloud(), {}).render(turned).image) == 0);
    }
}

TEST_CASE("a renderer that was moved from, or has no core, says so")
{
    for (auto const& door : doors()) {
        auto renderer = door.make(cloud(), {});
        auto const taken = std::move(renderer);
        CHECK(refusal([&] { (void)renderer.render(sound()); }).find("moved from") != std::string::npos); // NOLINT(bugprone-use-after-move)
        CHECK_FALSE(refusal([&] { renderer.observe({}); }).empty());
        CHECK_FALSE(refusal([&] { (void)renderer.map(); }).empty());
    }
    CHECK_FALSE(refusal([] { Renderer(std::unique_ptr<render::Core>()); }).empty());
}

TEST_CASE("every renderer refuses rules that are negative or not a number, and backgrounds outside 0 to 1")
{
    for (auto const& door : doors()) {
        INFO(door.name);
        auto renderer = door.make(cloud(), {});
        auto const before = renderer.render(sound());
        auto const rules = renderer.rules();
        auto const refused = [&](splat::Rules const& bad) {
            renderer.rules() = bad;
            CHECK_FALSE(refusal([&] { (void)renderer.render(sound()); }).empty());
            renderer.rules() = rules;
        };
        for (float const value : {-1.0f, -infinity, not_a_number}) {
            for (auto const member :
                 {&splat::Rules::alpha_min, &splat::Rules::alpha_max, &splat::Rules::transmittance_min, &splat::Rules::dilation}) {
                auto bad = rules;
                bad.*member = value;
                refused(bad);
            }
            for (int i = 0; i < 2; ++i) {
                auto bad = rules;
                bad.slope_limit[i] = value;
                refused(bad);
            }
        }
        for (float const value : {-0.1f, 1.1f, infinity, not_a_number}) {
            auto bad = rules;
            bad.background[1] = value;
            refused(bad);
        }
        CHECK(support::differing_pixels(renderer.render(sound()).image, before.image) == 0);
    }
}

TEST_CASE("every renderer refuses a map whose harmonics are not those of its degree")
{
    for (auto const& door : doors())
        for (auto const& bad : {std::pair(3u, 0u), std::pair(1u, 60u * 9u - 1u), std::pair(4u, 60u * 72u), std::pair(0u, 1u)}) {
            INFO(door.name, ", degree ", bad.first);
            auto map = cloud();
            map.sh_degree = bad.first;
            map.harmonics.resize(bad.second);
            CHECK_FALSE(refusal([&] { (void)door.make(map, {}).render(sound()); }).empty());
            CHECK_FALSE(refusal([&] { (void)scene::demand_of(map); }).empty());
        }
}

TEST_CASE("every renderer refuses grids, tiles and limits that no machine has")
{
    constexpr std::uint32_t most = 0xffffffffu;
    std::vector<RendererOptions> bad;
    for (Extent2 const e : {Extent2{most, 1}, Extent2{1, most}, Extent2{most, most}, Extent2{0, 5}, Extent2{5, 0}, Extent2{65536, 65536}}) {
        bad.push_back({.grid = e});
        if (e.width == 0 || e.height == 0) bad.push_back({.tile = e});
    }
    bad.insert(bad.end(), {{.threads = 1025}, {.threads = most}, {.channel_slots = most}, {.waiting_slots = most}, {.storage_slots = most}});
    for (auto const& door : doors())
        for (auto const& options : bad) {
            INFO(door.name, ", options ", &options - bad.data());
            CHECK_FALSE(refusal([&] { (void)door.make(cloud(), options).render(sound()); }).empty());
        }
    // A tile larger than the frame is one tile; homes have no tiles of a size.
    CHECK(refusal([] { (void)Renderer(cloud(), {.tile = {most, 1}, .program = Program::homes}); }).find("leave it out") != std::string::npos);
    CHECK_FALSE(refusal([] { (void)Renderer(cloud(), {.tile = {most, 1}, .program = Program::anchored}).render(sound()); }).empty());
    MachineSize const machine{"mk2", 1472, 638976, 0, 6, 0};
    CHECK_FALSE(refusal([&] { (void)render::layout_frame({{most, 1}, {}}, 64, 48, machine, 640, "lossless"); }).empty());
    CHECK_FALSE(refusal([&] { (void)render::layout_frame({{}, {most, most}}, 64, 48, machine, 640, "lossless"); }).empty());
}

TEST_SUITE_END();
