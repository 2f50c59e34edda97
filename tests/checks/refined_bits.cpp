// Refines a map of random Gaussians by 24 steps with each optimiser, and prints a hash of the map's bits. refined_bits.sh builds this
// with several compilers and flags, and compares.
#include "hashed.hpp"
#include <cstdint>
#include <cstdio>
#include <tilemesh/mapping/refiner.hpp>
#include <vector>

namespace {
using namespace tilemesh;

template <class Optimiser>
void refine(char const* name)
{
    Random random;
    scene::Map map;
    for (std::uint32_t id = 1; id <= 250; ++id) {
        splat::Gaussian g{};
        g.mean_world[0] = random.next(-2, 4), g.mean_world[1] = random.next(-1, 2), g.mean_world[2] = random.next(1, 3);
        for (float& c : g.colour) c = random.next(0, 1);
        g.opacity = random.next(0, 1);
        for (float& q : g.rotation) q = random.next(-1, 2);
        for (float& s : g.log_scale) s = random.next(-5, 4);
        g.id = static_cast<splat::GaussianId>(id);
        map.gaussians.push_back(g);
    }
    mapping::RefineOptions options;
    options.view.loss = {1, 0.5f, 0.05f, 0, 4};
    options.view.threads = 2;
    mapping::Refiner<Optimiser> refiner(map, options);
    splat::Camera camera{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}, 60.5f, 61.25f, 38.5f, 25.25f, 0.2f, 77, 51};
    mapping::Target target{77, 51, {}};
    for (std::uint32_t i = 0; i < 77 * 51; ++i) target.pixels.push_back({{random.next(0, 1), random.next(0, 1), random.next(0, 1)},
                                                                         random.next(0, 4)});
    double loss = 0;
    for (std::uint32_t step = 0; step < 24; ++step) {
        camera.position[0] = static_cast<float>(step % 4) * 0.125f;
        loss = refiner.step(camera, target, splat::map::faded(splat::map::usual_rates(2), static_cast<float>(step) / 24)).loss;
    }
    std::printf("%s %016llx loss %a\n", name, hash(refiner.map().gaussians), loss);
}
} // namespace

int main()
{
    refine<splat::map::Adam>("adam");
    refine<splat::map::SecondMomentByKind>("second moment by kind");
}
