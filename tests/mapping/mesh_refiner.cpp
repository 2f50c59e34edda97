// test: unoptimised test, cost 6
#include "support.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/mapping/mesh_refiner.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/splat/footprint.hpp>

using namespace tilemesh;
using splat::map::Adam, splat::map::SecondMomentByKind;

namespace {

/// Every n-th Gaussian of the built-in map, spoilt; one that covers every view, one that none shows, and some with the depths of others.
struct Case {
    scene::Map start;
    support::mapping::Views views;
};
Case thinned(std::uint32_t n)
{
    auto const whole = scene::built_in_map();
    std::vector<splat::Gaussian> few;
    for (std::size_t i = 0; i < whole.gaussians.size(); i += n) few.push_back(whole.gaussians[i]);
    auto const first = scene::built_in_camera({96, 60});
    auto everywhere = few[few.size() / 2], behind = few[few.size() / 3];
    for (float& s : everywhere.log_scale) s = 1.0f;
    everywhere.opacity = 0.2f;
    everywhere.id = splat::GaussianId{4'000'000'000u};
    for (int i = 0; i < 3; ++i) // behind all cameras
        behind.mean_world[i] = first.position[i] - 50 * first.rotation[2][i];
    behind.id = splat::GaussianId{7};
    few.push_back(everywhere), few.push_back(behind);
    auto truth = support::map_of(std::move(few));
    std::vector<splat::Camera> cameras;
    for (auto const& c : scene::orbit(first, scene::robust_centre(whole), 12.0, 4)) cameras.push_back(c);
    auto views = support::mapping::views_of(truth, std::move(cameras));
    auto start = support::mapping::spoilt(truth, 2, 5);
    for (std::uint32_t i = 0; i < 30; ++i) {
        auto twin = start.gaussians[start.gaussians.size() / 31 * i];
        twin.id = splat::GaussianId{i % 2 == 0 ? 3'000'000'000u + i : 10 + i}; // the higher or the lower id
        for (float& c : twin.colour) c = 0.9f - 0.5f * c;
        start.gaussians.push_back(twin);
    }
    return {std::move(start), std::move(views)};
}
mapping::MeshRefineOptions options_for(splat::TileSize tile, std::uint32_t threads, std::uint32_t channel_slots, Grid grid = {0, 0})
{
    mapping::MeshRefineOptions o;
    o.refine.view = {tile, threads, {1, 0.5f, 0.05f, 0, 4}};
    o.channel_slots = channel_slots;
    o.grid = grid;
    return o;
}
splat::map::Rates rates_at(std::uint32_t step)
{
    return splat::map::faded(splat::map::usual_rates(2), static_cast<float>(step) / 24);
}
struct Result {
    std::vector<splat::Gaussian> records;
    std::vector<double> losses;
};
bool same(Result const& a, Result const& b)
{
    return a.losses == b.losses && support::same_bits(a.records, b.records);
}
/// `rests`: now and then, the records move to the tiles of a view.
template <class Refiner>
Result after_24_steps(Refiner& refiner, Case const& c, [[maybe_unused]] bool rests = false)
{
    Result out;
    for (std::uint32_t i = 0; i < 24; ++i) {
        if constexpr (requires { refiner.rest(c.views.cameras[0]); })
            if (rests && i % 5 == 2) refiner.rest(c.views.cameras[i / 5 % 4]);
        auto const fit = refiner.step(c.views.cameras[i % 4], c.views.targets[i % 4], rates_at(i));
        out.losses.push_back(fit.loss), out.losses.push_back(fit.squares), out.losses.push_back(static_cast<double>(fit.pixels));
    }
    out.records = refiner.map().gaussians;
    std::sort(out.records.begin(), out.records.end(), [](auto const& a, auto const& b) { return a.id < b.id; });
    return out;
}
template <class Optimiser>
Result on_the_host(Case const& c)
{
    mapping::RefineOptions const o = options_for({32, 20}, 1, 1).refine;
    mapping::Refiner<Optimiser> host(c.start, o);
    return after_24_steps(host, c);
}
template <class Refiner>
Result on_a_mesh(Case const& c, mapping::MeshRefineOptions const& o)
{
    Refiner mesh(c.start, c.views.cameras[0], o);
    auto out = after_24_steps(mesh, c);
    CHECK(mesh.lost().records == 0);
    CHECK(mesh.lost().copies == 0);
    return out;
}
using OnThreads = mapping::MeshRefiner<SecondMomentByKind>;
using Checked = mapping::MeshRefiner<SecondMomentByKind, CheckedMesh>;

using support::mapping::messages_of;
} // namespace

TEST_CASE("mapping step: after 24 steps over 4 views, the map on the mesh has the bits of the host's, and so has each loss")
{
    auto const c = thinned(support::fast() ? 120 : 40);
    auto const host = on_the_host<SecondMomentByKind>(c);
    std::uint32_t moved = 0;
    for (auto const& g : c.start.gaussians)
        moved += std::any_of(host.records.begin(), host.records.end(),
                             [&](auto const& h) { return h.id == g.id && std::memcmp(&h, &g, sizeof g) != 0; });
    CHECK(moved > c.start.gaussians.size() / 2);
    CHECK(same(host, on_a_mesh<OnThreads>(c, options_for({16, 15}, 1, 200))));
    CHECK(same(host, on_a_mesh<OnThreads>(c, options_for({16, 15}, 2, 1))));
    CHECK(same(host, on_a_mesh<OnThreads>(c, options_for({32, 20}, 3, 1))));
    CHECK(same(host, on_a_mesh<OnThreads>(c, options_for({16, 5}, 7, 200))));
    CHECK(same(host, on_a_mesh<OnThreads>(c, options_for({64, 40}, 2, 3))));   // the frame ends within tiles
    CHECK(same(host, on_a_mesh<OnThreads>(c, options_for({16, 15}, 2, 2, {9, 7})))); // tiles outside of the picture
    CHECK(same(host, on_a_mesh<Checked>(c, options_for({16, 15}, 1, 1))));
    CHECK(same(host, on_a_mesh<Checked>(c, options_for({32, 20}, 1, 200))));
}
TEST_CASE("mapping step: Adam gives the bits of the host, too")
{
    auto const c = thinned(120);
    CHECK(same(on_the_host<Adam>(c), on_a_mesh<mapping::MeshRefiner<Adam>>(c, options_for({16, 15}, 2, 1))));
}

TEST_CASE("mapping step: each copy is one message out and one back, as many as the tree of each splat has edges")
{
    auto const c = thinned(120);
    OnThreads mesh(c.start, c.views.cameras[0], options_for({16, 15}, 2, 200));
    auto const tiling = splat::make_tiling(96, 60, 16, 15);
    auto const view = splat::make_view(c.views.cameras[0], mapping::refining_rules());
    std::uint64_t edges = 0, visible = 0;
    for (auto const& g : c.start.gaussians) {
        auto const s = splat::project(g, view, tiling);
        if (!s.visible()) continue;
        ++visible;
        edges += splat::tiles_of(s, tiling).count() - 1;
    }
    mesh.step(c.views.cameras[0], c.views.targets[0], rates_at(0));
    CHECK(edges > 100);
    CHECK(messages_of(mesh.run(), "cast") == edges);
    CHECK(messages_of(mesh.run(), "return") == edges);
    std::uint64_t seen = 0, copies = 0;
    for (auto [tile, counts] : mesh.mesh().states<splat::map::MapCounts>()) {
        seen += counts.visible, copies += counts.copies;
        CHECK(counts.cast_held == 0);
        CHECK(counts.return_held == 0);
    }
    CHECK(seen == visible);
    CHECK(copies == edges);

    // With one slot, tiles wait, and no message is more.
    OnThreads narrow(c.start, c.views.cameras[0], options_for({16, 15}, 1, 1));
    narrow.step(c.views.cameras[0], c.views.targets[0], rates_at(0));
    CHECK(messages_of(narrow.run(), "cast") == edges);
    CHECK(messages_of(narrow.run(), "return") == edges);
    std::uint64_t held = 0, held_back = 0;
    for (auto [tile, counts] : narrow.mesh().states<splat::map::MapCounts>()) held += counts.cast_held, held_back += counts.return_held;
    CHECK(held > edges);
    CHECK(held_back > 0);

    // Answers of one slot beside copies of 200: a tile sends no more than the receiver can answer.
    OnThreads uneven(c.start, c.views.cameras[0], options_for({16, 15}, 1, 200));
    uneven.mesh().limit<splat::map::Answers>(1);
    uneven.step(c.views.cameras[0], c.views.targets[0], rates_at(0));
    CHECK(messages_of(uneven.run(), "return") == edges);

    // Seen from elsewhere, copies also pass tiles that they do not touch: along the row to the farthest column, and along each column.
    auto const turned = splat::make_view(c.views.cameras[3], mapping::refining_rules());
    std::uint64_t tree = 0, inside = 0;
    for (auto [tile, records] : mesh.mesh().states<splat::map::Records>())
        for (auto const& g : records) {
            auto const s = splat::project(g, turned, tiling);
            if (!s.visible()) continue;
            auto const box = splat::tiles_of(s, tiling);
            auto const row_edges = std::max(tile.x(), box.last.x()) - std::min(tile.x(), box.first.x());
            tree += row_edges + box.columns() * (std::max(tile.y(), box.last.y()) - std::min(tile.y(), box.first.y()));
            inside += box.count() - 1;
        }
    mesh.step(c.views.cameras[3], c.views.targets[3], rates_at(1));
    CHECK(tree > inside);
    CHECK(messages_of(mesh.run(), "cast") == tree);
    CHECK(messages_of(mesh.run(), "return") == tree);
}

namespace {
/// The tile on which each record rests, in the order of ids.
template <class Refiner>
std::vector<std::pair<std::uint32_t, std::uint32_t>> resting(Refiner& refiner)
{
    std::vector<std::pair<std::uint32_t, std::uint32_t>> out;
    for (auto [tile, records] : refiner.mesh().template states<splat::map::Records>())
        for (auto const& g : records) out.push_back({static_cast<std::uint32_t>(g.id), refiner.mesh().grid().index_of(tile)});
    std::sort(out.begin(), out.end());
    return out;
}
} // namespace

TEST_CASE("mapping step: records move to the tiles of a new view, and no bit changes")
{
    auto const c = thinned(120);
    auto const host = on_the_host<SecondMomentByKind>(c);
    OnThreads threads(c.start, c.views.cameras[0], options_for({16, 15}, 3, 200));
    CHECK(same(host, after_24_steps(threads, c, true)));
    Checked one_slot(c.start, c.views.cameras[0], options_for({16, 15}, 1, 1));
    CHECK(same(host, after_24_steps(one_slot, c, true)));
    mapping::MeshRefiner<Adam> adam(c.start, c.views.cameras[0], options_for({32, 20}, 2, 1));
    CHECK(same(on_the_host<Adam>(c), after_24_steps(adam, c, true)));

    // Where there is room, each record that the view shows comes to the tile of its mean; the others stay.
    auto o = options_for({16, 15}, 1, 200);
    o.record_slots = static_cast<std::uint32_t>(c.start.gaussians.size()) * 4; // a quarter for each side
    OnThreads roomy(c.start, c.views.cameras[0], o);
    auto const before = resting(roomy);
    auto const view = splat::make_view(c.views.cameras[3], mapping::refining_rules());
    auto const tiling = splat::make_tiling(96, 60, 16, 15);
    roomy.step(c.views.cameras[3], c.views.targets[3], {}); // no rate: the records stay as they are
    auto const far = messages_of(roomy.run(), "cast");
    auto expected = before;
    std::uint64_t hops = 0, farthest = 0;
    auto const records = roomy.map().gaussians;
    for (std::size_t k = 0; k < records.size(); ++k) {
        auto const s = splat::project(records[k], view, tiling);
        if (!s.visible()) continue;
        auto const from = roomy.mesh().grid().tile(before[k].second);
        auto const apart = [](std::uint32_t a, std::uint32_t b) { return a < b ? b - a : a - b; };
        std::uint64_t const way = apart(from.x(), s.anchor.x()) + apart(from.y(), s.anchor.y());
        hops += way, farthest = std::max(farthest, way);
        expected[k].second = roomy.mesh().grid().index_of(s.anchor);
    }
    roomy.rest(c.views.cameras[3]);
    CHECK(hops > 100);
    CHECK(resting(roomy) == expected);
    CHECK(messages_of(roomy.run(), "move records") == hops);
    CHECK(roomy.run().loops[0].rounds == farthest + 1); // in the last one nothing moves
    roomy.rest(c.views.cameras[3]);
    CHECK(roomy.run().messages() == 0);
    CHECK(roomy.run().loops[0].rounds == 0);
    roomy.step(c.views.cameras[3], c.views.targets[3], {});
    CHECK(messages_of(roomy.run(), "cast") < far);

    // Without free slots nothing moves, and nothing is lost.
    mapping::MeshRefineOptions tight = options_for({32, 20}, 1, 200);
    Case full = c;
    full.start.gaussians.resize(6);
    for (std::uint32_t i = 0; i < 6; ++i) {
        auto const column = static_cast<float>(i % 3), row = static_cast<float>(i / 3);
        full.start.gaussians[i] = support::ball(1 + i, 16 + 32 * column, 10 + 20 * row, 2);
    }
    auto const flat = support::flat_camera(96, 40);
    auto mirrored = flat; // a half turn about the picture's centre
    for (int i = 0; i < 2; ++i) mirrored.rotation[i][i] = -1;
    mirrored.cx += 96, mirrored.cy += 40;
    Checked still(full.start, flat, tight);
    auto const at_first = resting(still);
    still.rest(mirrored);
    CHECK(resting(still) == at_first);
    tight.record_slots = 5; // one for each side of a tile that holds one
    Checked moving(full.start, flat, tight);
    moving.rest(mirrored);
    auto swapped = at_first;
    for (std::uint32_t i = 0; i < 6; ++i) swapped[i].second = 5 - i;
    CHECK(resting(moving) == swapped);

    // Four records in the west and four in the east want to the tile between them, which has six slots.
    Case crowd = c;
    crowd.start.gaussians.resize(8);
    for (std::uint32_t i = 0; i < 8; ++i)
        crowd.start.gaussians[i] = support::ball(1 + i, i < 4 ? 10 : 86, 2 + 4 * static_cast<float>(i % 4), 2);
    auto small = support::flat_camera(96, 20); // all balls are near the centre
    small.fx = small.fy = 10;
    small.cx = 48, small.cy = 10;
    tight.record_slots = 6;
    Checked crowded(crowd.start, support::flat_camera(96, 20), tight);
    crowded.rest(small);
    auto const there = resting(crowded);
    CHECK(there.size() == 8);
    auto const between = std::count_if(there.begin(), there.end(), [](auto const& r) { return r.second == 1; });
    CHECK(between >= 3);
    CHECK(between <= 6);
}

namespace {
/// Two tiles of 32 x 20 pixels. Three balls rest on the western tile and reach over the border; `east` small ones rest on the eastern tile.
Case two_tiles(std::uint32_t east)
{
    std::vector<splat::Gaussian> balls;
    for (std::uint32_t i = 0; i < 3; ++i) {
        auto const step = static_cast<float>(i);
        balls.push_back(support::ball(1 + i, 27 + step, 5 + 4 * step, 3, 0.6f));
    }
    for (std::uint32_t i = 0; i < east; ++i) balls.push_back(support::ball(10 + i, 48 + 4 * static_cast<float>(i), 10, 0.5f, 0.7f));
    Case c{support::map_of(std::move(balls)), {{support::flat_camera(64, 20)}, {}}};
    c.views.targets.push_back({64, 20, std::vector<splat::TargetPixel>(64 * 20, {{0.3f, 0.4f, 0.5f}, 0})});
    return c;
}
mapping::MeshRefineOptions with_entries(std::uint32_t slots)
{
    auto o = options_for({32, 20}, 1, 2);
    o.entry_slots = slots;
    return o;
}
splat::map::Rates const steady{1e-2f, 5e-3f, 2e-3f, 2.5e-2f, 5e-3f};
} // namespace

TEST_CASE("mapping step: a tile that is full loses nothing; with one slot less, one copy is answered empty and counted")
{
    auto const c = two_tiles(2);
    auto const& camera = c.views.cameras[0];
    mapping::Refiner<> host(c.start, with_entries(9).refine);
    host.step(camera, c.views.targets[0], steady);
    Checked full(c.start, camera, with_entries(5)); // two own, three copies
    full.step(camera, c.views.targets[0], steady);
    CHECK(full.lost().copies == 0);
    CHECK(full.lost().records == 0);
    CHECK(support::same_bits(full.map().gaussians, host.map().gaussians));

    Checked one_less(c.start, camera, with_entries(4));
    one_less.step(camera, c.views.targets[0], steady);
    CHECK(one_less.lost().copies == 1);
    CHECK(one_less.lost().records == 0);
    CHECK(messages_of(one_less.run(), "cast") == 3 + 1); // three copies, one refusal
    CHECK(messages_of(one_less.run(), "return") == 2);
    auto const after = one_less.map().gaussians;
    for (std::size_t k = 0; k < 3; ++k) CHECK(std::memcmp(&after[k], &c.start.gaussians[k], sizeof after[k]) != 0); // all move

    // Nothing fits, and answers have one slot.
    Checked no_room(two_tiles(3).start, camera, with_entries(3));
    no_room.mesh().limit<splat::map::Answers>(1);
    no_room.step(camera, c.views.targets[0], steady);
    CHECK(no_room.lost().copies == 3);
    CHECK(messages_of(no_room.run(), "cast") == 3 + 3);
    CHECK(messages_of(no_room.run(), "return") == 0);

    // Two slots: a record of the western tile has none, and the view lacks it.
    Checked two(c.start, camera, with_entries(2));
    two.step(camera, c.views.targets[0], steady);
    CHECK(two.lost().records == 1);
    CHECK(two.lost().copies == 2);
    CHECK(std::memcmp(&two.map().gaussians[2], &c.start.gaussians[2], sizeof(splat::Gaussian)) == 0);
}
TEST_CASE("mapping step: if the eastern tile has no room, the western records follow the western pixels alone")
{
    auto const c = two_tiles(3);
    auto const& camera = c.views.cameras[0];
    OnThreads mesh(c.start, camera, with_entries(3));
    mesh.step(camera, c.views.targets[0], steady);
    CHECK(mesh.lost().copies == 3);
    auto west = c.views.targets[0];
    for (std::uint32_t y = 0; y < 20; ++y)
        for (std::uint32_t x = 32; x < 64; ++x) west.pixels[y * 64 + x].rgb[0] = std::numeric_limits<float>::quiet_NaN();
    mapping::Refiner<> host(c.start, with_entries(9).refine);
    host.step(camera, west, steady);
    CHECK(std::memcmp(mesh.map().gaussians.data(), host.map().gaussians.data(), 3 * sizeof(splat::Gaussian)) == 0);
    CHECK(std::memcmp(mesh.map().gaussians.data(), c.start.gaussians.data(), sizeof(splat::Gaussian)) != 0);
}

TEST_CASE("mapping step: a splat over the whole picture, one that no tile shows, and an empty map")
{
    auto const camera = support::flat_camera(96, 60);
    mapping::Target const grey{96, 60, std::vector<splat::TargetPixel>(96 * 60, {{0.5f, 0.5f, 0.5f}, 0})};
    auto const map = support::map_of({support::ball(1, 48, 30, 60, 0.5f), support::ball(2, 900, 900, 4, 0.8f)});
    for (std::uint32_t x : {8u, 40u, 88u}) { // the reference view decides where it rests
        auto reference = camera;
        reference.cx += static_cast<float>(x) - 48;
        Checked mesh(map, reference, options_for({16, 15}, 1, 1));
        mapping::Refiner<> host(map, options_for({16, 15}, 1, 1).refine);
        for (int i = 0; i < 3; ++i) mesh.step(camera, grey, steady), host.step(camera, grey, steady);
        CHECK(messages_of(mesh.run(), "cast") == 6 * 4 - 1);
        CHECK(messages_of(mesh.run(), "return") == 6 * 4 - 1);
        CHECK(support::same_bits(mesh.map().gaussians, host.map().gaussians));
        CHECK(std::memcmp(&mesh.map().gaussians[1], &map.gaussians[1], sizeof map.gaussians[1]) == 0);
        CHECK(mesh.mesh().state<splat::map::Records>(TileId::at(x / 16, 2)).size() == 1);
    }
    Checked none(support::map_of({}), camera, options_for({16, 15}, 1, 1));
    auto const fit = none.step(camera, grey, steady);
    CHECK(fit.pixels == 96 * 60);
    CHECK(fit.loss == doctest::Approx(96 * 60 * 0.475)); // less half of the Huber width
    CHECK(none.map().gaussians.empty());
    CHECK(none.run().messages() == 0);
}

TEST_CASE("mapping step: a tile's bytes, and the workers that walk")
{
    using splat::map::walkers_of;
    CHECK(walkers_of({32, 20}, 6) == 4); // 8 blocks: two each
    CHECK(walkers_of({16, 15}, 6) == 3);
    CHECK(walkers_of({64, 40}, 6) == 6); // 32 blocks: six each
    CHECK(walkers_of({16, 5}, 6) == 1);
    CHECK(walkers_of({32, 20}, 1) == 1);
    CHECK(splat::map::entry_bytes(4) == 240);
    CHECK(splat::map::record_bytes<SecondMomentByKind> == 88);
    CHECK(splat::map::record_bytes<Adam> == 180);
    auto const machine = size_of_machine<Mk2>();
    CHECK(splat::map::sizes_on<SecondMomentByKind>(machine, {32, 20}, 300, 100).entries == 1471);
    auto const sizes = splat::map::sizes_on<Adam>(machine, {32, 20}, 720, 100);
    CHECK(sizes.entries >= 1000);
    using Ledger = SramLedger<splat::map::MapStep<Adam>>;
    CHECK(Ledger::bytes(machine, sizes) <= machine.sram_bytes);
    CHECK(Ledger::bytes(machine, sizes) + splat::map::entry_bytes(sizes.walkers) > machine.sram_bytes);
}

TEST_CASE("mapping step: what does not fit is refused with a line")
{
    auto const c = two_tiles(2);
    auto const& camera = c.views.cameras[0];
    auto const with = [&](auto const& change) {
        auto map = c.start;
        auto o = options_for({32, 20}, 1, 10);
        change(map, o);
        return tests::error_of([&] { OnThreads r(map, camera, o); });
    };
    CHECK(with([](auto&, auto&) {}).empty());
    CHECK(with([](auto&, auto& o) { o.refine.view.tile = {24, 20}; }) ==
          "tiles cannot have 24 x 20 pixels (sums are rounded by blocks of 16 x 5); take multiples of these");
    CHECK(with([](auto& map, auto&) { map.sh_degree = 1; }).find("a map with harmonics of degree 1 cannot be refined on a mesh") == 0);
    CHECK(with([](auto& map, auto&) { map.gaussians[4].id = map.gaussians[0].id; }) ==
          "two Gaussians of the map have the id 1 (ids decide the order of equal depths); give each its own");
    CHECK(with([](auto&, auto& o) { o.channel_slots = 0; }).find("a channel without a slot carries nothing") == 0);
    CHECK(with([](auto&, auto& o) { o.grid = {1, 3}; }) ==
          "a picture of 64 x 20 pixels does not fit the mesh (it has 2 x 1 tiles of 32 x 20 pixels, the grid 1 x 3); take a larger grid, "
          "larger tiles or smaller pictures");

    // The bytes of all but entries, and 4 of them: the eastern tile has 5.
    auto machine = size_of_machine<Mk2>();
    auto const needed = [&](std::uint32_t entries) {
        auto sizes = splat::map::sizes_on<SecondMomentByKind>(machine, {32, 20}, 3, 10);
        sizes.entries = entries, sizes.sums = entries * sizes.walkers;
        return static_cast<std::uint32_t>(SramLedger<OnThreads::Program>::bytes(size_of_machine<Mk2>(), sizes));
    };
    auto const on = [&](std::uint32_t bytes) {
        auto o = options_for({32, 20}, 1, 10);
        o.machine.sram_bytes = bytes;
        return tests::error_of([&] { OnThreads r(c.start, camera, o); });
    };
    CHECK(on(needed(5)).empty());
    CHECK(on(needed(5) - 1) ==
          "a map of 5 Gaussians does not fit the tiles of mk2 (the fullest holds 3 records of 88 bytes, and its 5 splats of 240 bytes in "
          "the reference view take 1200 bytes; 960 are left); take smaller tiles, fewer slots of channels or a smaller map");
    OnThreads mesh(c.start, camera, options_for({32, 20}, 1, 10));
    CHECK(tests::error_of([&] { mesh.step(support::flat_camera(65, 20), {65, 20, std::vector<splat::TargetPixel>(65 * 20)}, steady); })
              .find("a picture of 65 x 20 pixels does not fit the mesh (it has 3 x 1 tiles") == 0);
    CHECK(tests::error_of([&] { mesh.step(camera, mapping::Target{64, 21, {}}, steady); }) ==
          "a target of 64 x 21 pixels is no picture of this camera (it has 64 x 20); give pictures of the camera's size");
}
