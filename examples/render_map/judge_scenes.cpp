#include "judge_scenes.hpp"
#include "../shared/camera_file.hpp"
#include "../shared/output_files.hpp"
#include "../shared/text.hpp"
#include "certify.hpp"
#include "choice.hpp"
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <iterator>
#include <sstream>
#include <tilemesh/error.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/enclosure.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/report/json_text.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/ply_output.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/splat/gaussian.hpp>

namespace render_map {

namespace {

namespace fs = std::filesystem;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;

/// Random numbers by integer arithmetic (Steele, Lea and Flood 2014: SplitMix64), the same on every host.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    float uniform(float least, float most)
    {
        auto z = state_ += 0x9e3779b97f4a7c15u;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u, z = (z ^ (z >> 27)) * 0x94d049bb133111ebu, z ^= z >> 31;
        return least + (most - least) * static_cast<float>(z >> 40) * 0x1p-24f;
    }

private:
    std::uint64_t state_;
};

struct Judged {
    char const *name, *about;
    std::uint32_t degree;
    void (*fill)(scene::Map&, Random&);
    std::array<double, 3> eye{0, 0, -3}; ///< it looks at the origin
};

constexpr float side = 1.4f; ///< half of what the camera sees at the origin, and a little more

/// A splat at p of standard deviations s (logarithms), turned at random.
splat::Gaussian& add(scene::Map& map, Random& random, glm::vec3 p, glm::vec3 s, float opacity)
{
    splat::Gaussian g{};
    for (int k = 0; k < 3; ++k) g.mean_world[k] = p[k], g.log_scale[k] = s[k], g.colour[k] = random.uniform(0, 1);
    for (float& q : g.rotation) q = random.uniform(-1, 1);
    g.opacity = opacity;
    map.gaussians.push_back(g);
    return map.gaussians.back();
}
glm::vec3 anywhere(Random& r, float depth = 1)
{
    float const x = r.uniform(-side, side), y = r.uniform(-side, side), z = r.uniform(-depth, depth);
    return {x, y, z};
}
void cloud(scene::Map& map, Random& r, int n, float least_size, float most_size, float least_opacity, float most_opacity, float depth = 1)
{
    for (int i = 0; i < n; ++i) {
        auto const p = anywhere(r, depth);
        float const a = r.uniform(least_size, most_size), b = r.uniform(least_size, most_size), c = r.uniform(least_size, most_size);
        float const opacity = r.uniform(least_opacity, most_opacity);
        add(map, r, p, {a, b, c}, opacity);
    }
}
void shaded(scene::Map& map, Random& r)
{
    cloud(map, r, 60, -3, -1.5f, 0.3f, 1);
    for (std::size_t i = 0; i < 3 * splat::harmonics_per_channel(map.sh_degree) * map.gaussians.size(); ++i) map.harmonics.push_back(r.uniform(-.3f, .3f));
}
void straight(splat::Gaussian& g)
{
    g.rotation[0] = 1, g.rotation[1] = g.rotation[2] = g.rotation[3] = 0;
}

constexpr Judged scenes[] = {
    {"axes", "a red splat on +x, a green one on +y, a blue one on +z, a grey one at the origin: handedness and channels", 0,
     [](scene::Map& map, Random& r) {
         for (int k = 0; k < 4; ++k) {
             auto& g = add(map, r, {k == 0 ? 0.8f : 0.0f, k == 1 ? 0.6f : 0.0f, k == 2 ? 0.9f : 0.0f}, {-1.8f, -1.8f, -1.8f}, 0.9f);
             for (int c = 0; c < 3; ++c) g.colour[c] = k == 3 ? 0.5f : c == k ? 1.0f : 0.0f;
         }
     },
     {-1, -1.5, -2.6}},
    {"rotation", "ellipsoids in all directions, with quaternions of any length", 0, [](scene::Map& map, Random& r) { cloud(map, r, 80, -4, -1, 0.3f, 1); }},
    {"degree_1", "colours of degree 1", 1, shaded},
    {"degree_2", "colours of degree 2", 2, shaded},
    {"degree_3", "colours of degree 3", 3, shaded},
    {"ties", "twelve splats in each of ten places of one depth: the row in the file decides", 0,
     [](scene::Map& map, Random& r) {
         for (int i = 0; i < 10; ++i) {
             float const x = r.uniform(-1, 1), y = r.uniform(-.7f, .7f);
             for (int k = 0; k < 12; ++k) straight(add(map, r, {x, y, 0}, {-1.5f, -1.5f, -1.5f}, 0.4f));
         }
     }},
    {"close_depths", "splats whose depths differ in the last bits of a float32", 0,
     [](scene::Map& map, Random& r) {
         float z = 0.5f;
         for (int i = 0; i < 60; ++i) {
             auto const p = anywhere(r);
             add(map, r, {p.x, p.y, z}, {-1.5f, -1.5f, -1.5f}, 0.5f);
             z = std::nextafter(z, i % 2 == 0 ? 1.0f : 0.0f);
         }
     }},
    {"needles", "lengths to widths of 1,000 to 100,000", 0,
     [](scene::Map& map, Random& r) {
         for (int i = 0; i < 60; ++i) {
             auto const p = anywhere(r);
             float const length = r.uniform(-2, 0), width = r.uniform(-12, -7), depth = r.uniform(-12, -7), opacity = r.uniform(0.5f, 1);
             add(map, r, p, {length, width, depth}, opacity);
         }
     }},
    {"walls", "six layers that fill the picture, one behind the other", 0,
     [](scene::Map& map, Random& r) {
         for (int i = 0; i < 6; ++i) {
             float const opacity = r.uniform(0.2f, 0.7f);
             straight(add(map, r, {0, 0, 0.2f * static_cast<float>(i)}, {2, 2, -6}, opacity));
         }
         cloud(map, r, 20, -3, -1, 0.3f, 1);
     }},
    {"near_plane", "splats before, at and behind the near plane of 0.2, and behind the camera", 0,
     [](scene::Map& map, Random& r) {
         for (float const z : {-2.99f, -2.85f, -2.801f, -2.8f, -2.799f, -2.79f, -2.7f, -2.4f, -3.5f}) {
             float const x = r.uniform(-.1f, .1f), y = r.uniform(-.1f, .1f);
             add(map, r, {x, y, z}, {-4, -4, -4}, 0.6f);
         }
         cloud(map, r, 20, -3, -1.5f, 0.3f, 1);
     }},
    {"opaque", "opacities of .9 to 1, many layers: the clamp of alpha and the stop", 0, [](scene::Map& map, Random& r) { cloud(map, r, 200, -2, -1, 0.9f, 1); }},
    {"faint", "opacities from below 1/255 to .02, 400 of them: the cut", 0, [](scene::Map& map, Random& r) { cloud(map, r, 400, -2, -.5f, 0.003f, 0.02f); }},
};

char const* word_of(splat::Footprint footprint)
{
    using splat::Footprint;
    return footprint == Footprint::opacity_box ? "none" : footprint == Footprint::three_sigma_square ? "three_sigma_square" : "three_sigma_tiles";
}

} // namespace

std::string write_judge_scenes(Options const& options)
{
    namespace report = tilemesh::report;
    auto const& folder = *options.judge_scenes;
    shared::make_folder(folder, "--judge-scenes");
    bool const is_ours = fs::exists(folder / "scenes.json");
    for (auto const& judged : scenes)
        if (auto const map = folder / (std::string(judged.name) + ".ply"); !is_ours && fs::exists(map))
            throw tilemesh::Error("cannot write " + shared::one_line(map.string()) + " (it exists, and there is no scenes.json beside it); name an empty folder with --judge-scenes");
    auto const rules = tilemesh::with_options(setup_of(options.choice, 0).rules, options.renderer);
    std::string lines;
    auto const write = [&](std::string const& name, std::string const& text) { report::write_whole(folder / name, text); };
    for (std::size_t n = 0; n < std::size(scenes); ++n) {
        auto const& judged = scenes[n];
        std::string const name = judged.name;
        Random random(n + 1);
        scene::Map made;
        made.sh_degree = judged.degree;
        judged.fill(made, random);
        auto const bytes = scene::ply_bytes(made, rules.coverage);
        write(name + ".ply", bytes);
        std::istringstream file(bytes); // the bounds are those of what a reader finds
        auto const map = scene::read_map(file, name);
        auto const& e = judged.eye;
        auto const pose = scene::look_at({e[0], e[1], e[2]}, {0, 0, 0});
        scene::Intrinsics const lens{150, 150, 80, 60, 0.2f, 160, 120};
        write(name + ".json", shared::camera_file_text({{name, pose}}, lens));
        auto const enclosure = scene::visit_records(
            map, [&](auto const& records) { return report::enclose(records, scene::make_camera(pose, lens), rules, {.threads = options.threads}); });
        for (bool const upper : {false, true}) report::write_pfm(folder / (name + (upper ? ".upper.pfm" : ".lower.pfm")), bound_of(enclosure, upper));
        lines += (lines.empty() ? "\n  " : ",\n  ") + report::json_line([&](auto& json) {
                     json.member("name", name);
                     json.member("about", judged.about);
                     json.member("map", name + ".ply");
                     json.member("cameras", name + ".json");
                     json.member("lower", name + ".lower.pfm");
                     json.member("upper", name + ".upper.pfm");
                     json.member("gaussians", map.gaussians.size());
                     json.member("degree", judged.degree);
                     json.member("widest_interval_levels", 255 * enclosure.widest());
                     json.member("pixels_undecided", enclosure.count(report::Enclosure::Decided::undecided));
                 });
    }
    auto const of_rules = report::json_line([&](auto& json) {
        json.member("order", "depth along z, then row in the file");
        json.member("near", double{rules.near_plane == splat::NearPlane::fixed ? splat::fixed_near_depth : 0.2f});
        json.member("alpha_min", double{rules.alpha_min});
        json.member("alpha_max", double{rules.alpha_max});
        json.member("transmittance_min", double{rules.transmittance_min});
        json.member("blends_the_term_that_crosses", rules.stop == splat::Stop::after_crossing);
        json.member("dilation", double{rules.dilation});
        json.member("antialias", rules.coverage == splat::Coverage::preserved);
        json.member("slope_limit", double{rules.jacobian_limit});
        json.member("slope_limit_of_half_width", rules.slope_border == splat::SlopeBorder::of_half_width);
        json.member("footprint", word_of(rules.footprint));
        json.list("background", rules.background);
    });
    write("scenes.json", "{\"rules\": " + of_rules + ",\n \"scenes\": [" + lines + "\n ]}\n");
    return "wrote " + shared::one_line((folder / "scenes.json").string()) + ", and " + std::to_string(std::size(scenes)) +
           " maps, their cameras and bounding pictures beside it\n";
}

} // namespace render_map
