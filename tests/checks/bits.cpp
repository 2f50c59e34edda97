// Renders random Gaussians by the naive loop and on the mesh, and prints a hash of each picture's bits. It also prints a hash of very many
// projected records, because a difference that changes a bound by one pixel is rare. exact_bits.sh builds this with various flags and
// compares.
#include "hashed.hpp"
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/report/naive.hpp>
#include <vector>

namespace {
using namespace tilemesh;

scene::Map random_map(std::uint32_t count)
{
    Random random;
    scene::Map map;
    for (std::uint32_t id = 1; id <= count; ++id) {
        splat::Gaussian g{};
        g.mean_world[0] = random.next(-4, 8);
        g.mean_world[1] = random.next(-2, 4);
        g.mean_world[2] = random.next(-1, 8);
        for (float& c : g.colour) c = random.next(0, 2);
        g.opacity = random.next(0, 1);
        for (float& q : g.rotation) q = random.next(-1, 2);
        for (float& s : g.log_scale) s = random.next(-7, 6);
        g.id = static_cast<splat::GaussianId>(id);
        map.gaussians.push_back(g);
    }
    return map;
}

std::vector<splat::Splat> project(scene::Map const& map, splat::Camera const& camera, splat::Rules const& rules)
{
    auto const view = splat::make_view(camera, rules);
    auto const tiling = splat::make_tiling(camera.width, camera.height, 32, 20);
    std::vector<splat::Splat> splats;
    for (auto const& g : map.gaussians) splats.push_back(splat::project(g, view, tiling));
    return splats;
}
/// 8-bit levels of the values at which they change, so that one rounding more or less shows.
std::vector<std::uint32_t> levels()
{
    std::vector<std::uint32_t> out;
    for (std::uint32_t k = 0; k < 255; ++k)
        for (float const step : {-1.0f, 0.0f, 1.0f}) {
            float const middle = (static_cast<float>(k) + 0.5f) / 255.0f;
            out.push_back(splat::Rgbx8Pixel::level(std::nextafter(middle, middle + step)));
        }
    return out;
}
} // namespace

int main()
{
    std::printf("levels %016llx\n", hash(levels()));
    auto const map = random_map(600), many = random_map(300'000);
    splat::Camera const camera{
        {{0.96f, 0.0f, 0.28f}, {0.0f, 1.0f, 0.0f}, {-0.28f, 0.0f, 0.96f}}, {0.125f, -0.25f, -2.5f}, 110.7f, 111.3f, 77.9f, 38.3f, 0.2f, 156, 77};
    for (auto const footprint : {splat::Footprint::opacity_box, splat::Footprint::three_sigma_square}) {
        RendererOptions options;
        options.grid = {5, 4};
        options.footprint = footprint;
        options.arithmetic = splat::Arithmetic::precise;
        BasicRenderer<> renderer(map, options);
        splat::Rules rules = renderer.rules();
        rules.footprint = footprint;
        auto const naive = report::render_naive(map.gaussians, camera, rules);
        auto const mesh = renderer.render(camera);
        std::printf("projected %016llx naive %016llx mesh %016llx (%llu pairs)\n", hash(project(many, camera, rules)), hash(naive.rgb),
                    hash(mesh.image.rgb), static_cast<unsigned long long>(mesh.report.pairs_contributing));
        options.arithmetic = splat::Arithmetic::fast;
        std::printf("fast %016llx\n", hash(BasicRenderer<>(map, options).render(camera).image.rgb));
        if (hash(naive.rgb) != hash(mesh.image.rgb)) {
            std::puts("the mesh's picture is not the naive one");
            return 1;
        }
    }
}
