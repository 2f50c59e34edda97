// test: unoptimised test, cost 4
#include "../slam/support.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/mapping/mesh_refiner.hpp>
#include <tilemesh/splat/map/grow.hpp>
#include <tilemesh/splat/map/optimise.hpp>

using namespace tilemesh;
using splat::map::Adam, splat::map::SecondMomentByKind, splat::map::Shaded;
namespace on_slam = support::slam;

namespace {
struct Case {
    scene::Map start;
    support::mapping::Views views;
};
/// A cloud whose colours depend on the direction, seen from three places. Ids descend. One record is not shown: its colour is not finite.
Case shaded_cloud(std::uint32_t degree)
{
    auto gaussians = support::cloud(70, 3);
    for (std::size_t i = 0; i < gaussians.size(); ++i) {
        for (float& s : gaussians[i].log_scale) s = std::max(s, -4.0f);
        gaussians[i].id = splat::GaussianId{static_cast<std::uint32_t>(500 - 3 * i)};
        if (i % 4 == 0) gaussians[i].colour[1] = -0.1f; // a first part below 0, which harmonics may lift
    }
    auto truth = support::map_of(std::move(gaussians));
    truth.sh_degree = degree;
    support::Random random(7);
    truth.harmonics.resize(truth.gaussians.size() * 3 * splat::harmonics_per_channel(degree));
    for (float& v : truth.harmonics) v = random.uniform(-0.3f, 0.3f);
    truth.harmonics[truth.harmonics.size() / 2] = 1e30f;
    auto views = support::mapping::views_of(truth, {support::lens(64, 45), support::lens(64, 45, 0.2f), support::lens(64, 45, -0.3f)});
    auto start = support::mapping::spoilt(truth, 2, 5);
    for (std::size_t i = 0; i < start.gaussians.size(); ++i)
        if (i % 4 == 0) start.gaussians[i].colour[1] = -0.1f;
    return {std::move(start), std::move(views)};
}
mapping::MeshRefineOptions options_for(splat::TileSize tile, std::uint32_t threads, std::uint32_t channel_slots)
{
    mapping::MeshRefineOptions o;
    o.refine.view = {tile, threads, {1, 0.5f, 0, 0, 4}};
    o.channel_slots = channel_slots;
    o.record_slots = 80;
    o.machine.sram_bytes = 16u << 20;
    return o;
}
/// The words of a map, by ids.
std::vector<float> words_of(scene::Map const& map)
{
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < map.gaussians.size(); ++i) rows.push_back(i);
    std::sort(rows.begin(), rows.end(), [&](auto a, auto b) { return map.gaussians[a].id < map.gaussians[b].id; });
    std::size_t const words = 3 * splat::harmonics_per_channel(map.sh_degree);
    std::vector<float> out;
    for (auto const row : rows) {
        auto const at = out.size();
        out.resize(at + sizeof(splat::Gaussian) / 4 + words);
        std::memcpy(out.data() + at, &map.gaussians[row], sizeof(splat::Gaussian));
        std::copy_n(map.harmonics.data() + words * row, words, out.data() + at + sizeof(splat::Gaussian) / 4);
    }
    return out;
}
using support::same_bits;
template <class Refiner>
std::vector<double> steps(Refiner& refiner, Case const& c)
{
    std::vector<double> losses;
    auto const rates = splat::map::usual_rates(2);
    for (std::uint32_t i = 0; i < 12; ++i) {
        if constexpr (requires { refiner.rest(c.views.cameras[0]); })
            if (i == 4) refiner.rest(c.views.cameras[2]);
        losses.push_back(refiner.step(c.views.cameras[i % 3], c.views.targets[i % 3], rates).loss);
    }
    return losses;
}
template <class Optimiser, template <class, class> class MeshOf, std::uint32_t Degree>
void check_against_host(mapping::MeshRefineOptions const& o)
{
    CAPTURE(Degree);
    auto const c = shaded_cloud(Degree);
    mapping::Refiner<Optimiser> host(c.start, o.refine);
    mapping::MeshRefiner<Shaded<Optimiser, Degree>, MeshOf> mesh(c.start, c.views.cameras[0], o);
    CHECK(same_bits(words_of(mesh.map()), words_of(c.start)));
    CHECK(steps(mesh, c) == steps(host, c));
    CHECK(mesh.lost().records + mesh.lost().copies == 0);
    auto const after = mesh.map();
    CHECK(after.sh_degree == Degree);
    CHECK(same_bits(words_of(after), words_of(host.map())));
    std::size_t moved = 0, negative = 0;
    auto by_id = c.start.harmonics; // ids descend: the rows are turned around
    std::size_t const words = Shaded<Optimiser, Degree>::words, n = c.start.gaussians.size();
    for (std::size_t k = 0; k < n; ++k)
        moved += std::memcmp(after.harmonics.data() + words * k, by_id.data() + words * (n - 1 - k), 4 * words) != 0;
    for (auto const& g : after.gaussians) negative += g.colour[1] < 0;
    CHECK(moved > n / 2);
    CHECK(moved < n);
    CHECK(negative > 0); // no clamp
}
} // namespace

TEST_CASE("mapping step with harmonics: records, harmonics and losses of degree 1 to 3 have the bits of the host's after 12 steps")
{
    check_against_host<SecondMomentByKind, Mesh, 1>(options_for({16, 15}, 2, 1));
    check_against_host<Adam, CheckedMesh, 2>(options_for({16, 15}, 1, 2));
    check_against_host<SecondMomentByKind, Mesh, 3>(options_for({32, 20}, 3, 200));
}

TEST_CASE("mapping step with harmonics: a map of degree 1 grows and shrinks on the mesh as on the host")
{
    slam::MapperOptions m;
    m.optimiser = slam::Optimiser::by_kind;
    m.first_steps = 5, m.steps = 3;
    m.remove.least_opacity = 0.72f;
    scene::Map empty;
    empty.sh_degree = 1;
    slam::Mapper host(empty, 2, m);
    auto o = options_for({16, 15}, 2, 3);
    o.refine.view.loss.depth = m.depth_weight;
    o.record_slots = 400;
    o.insert = m.insert, o.remove = m.remove;
    auto const views = on_slam::keyframes(2);
    mapping::MeshRefiner<Shaded<SecondMomentByKind, 1>, Mesh, AnyMachine, splat::map::GrowStep> mesh(empty, views.cameras[0], o);
    for (std::size_t k = 0; k < 2; ++k) {
        auto const facts = host.add(views.cameras[k], views.targets[k]);
        CHECK(facts.removed > 0);
        CHECK(on_slam::add_keyframe(mesh, views, k, m, 2) == std::array{facts.inserted, facts.removed});
    }
    auto const after = mesh.map();
    CHECK(std::any_of(after.harmonics.begin(), after.harmonics.end(), [](float v) { return v != 0; }));
    CHECK(same_bits(words_of(after), words_of(host.map())));
    REQUIRE(after.gaussians.size() == host.map().gaussians.size());
    for (std::size_t i = 0; i < after.gaussians.size(); ++i) CHECK(after.gaussians[i].id == host.map().gaussians[i].id);
}

TEST_CASE("mapping step with harmonics: the bytes of a record, none of them at degree 0, and another degree is refused")
{
    using splat::map::record_bytes;
    CHECK(record_bytes<SecondMomentByKind> == 88);
    CHECK(record_bytes<Shaded<SecondMomentByKind, 1>> == 88 + 8 + 36);
    CHECK(record_bytes<Shaded<Adam, 3>> == 180 + 8 + 180);
    auto const c = shaded_cloud(1);
    CHECK(tests::error_of([&] { mapping::MeshRefiner<Shaded<SecondMomentByKind, 1>> r({}, c.views.cameras[0]); }) ==
          "a map with harmonics of degree 0 cannot be refined on a mesh with states of degree 1 (the optimiser's states hold the "
          "harmonics); take splat::map::Shaded of the map's degree, or mapping::Refiner");
}
