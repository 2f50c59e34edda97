// test: unoptimised test, without test asan tsan
// A step that a setup leaves out costs no byte and no counter. A step that it has but does not need changes no bit.
#include "../compare_reports.hpp"
#include "runner.hpp"

using namespace tilemesh;
using namespace tilemesh::splat;
using support::make_runner, support::Minimal, support::NoBloom, support::NoRouting, support::Shaded, support::Whole;

namespace {
// --- bytes -----------------------------------------------------------------------------------------------------------------------
static_assert(sizeof(GaussianOfDegree<0>) == 60 && sizeof(GaussianOfDegree<1>) == 96 && sizeof(GaussianOfDegree<2>) == 156 &&
              sizeof(GaussianOfDegree<3>) == 240);
template <std::uint32_t Degree>
constexpr std::size_t road_message = sizeof(RoadMessage<Fitted<Lossless, Degree>>);
static_assert(road_message<0> == 64 && road_message<1> == 100 && road_message<2> == 160 && road_message<3> == 244);
static_assert(sizeof(BeamMessage<Fitted<Lossless, 0>>) == 60 && sizeof(BeamMessage<Fitted<Lossless, 3>>) == 240);
static_assert(sizeof(FloatPixel) == 12 && sizeof(WithDepth<FloatPixel>) == 16 && sizeof(WithAlpha<FloatPixel>) == 16 &&
              sizeof(WithAlpha<WithDepth<FloatPixel>>) == 20 && sizeof(WithDepth<Rgbx8Pixel>) == 8);

// Slots of storage on Mk2: with all, without routing, without bloom, without both.
template <std::uint32_t Degree, std::uint32_t All, std::uint32_t NoRouting, std::uint32_t NoBloom, std::uint32_t Neither>
constexpr bool has_slots = Fitted<Lossless, Degree>::sizes.storage == All &&
                           Fitted<Lossless, Degree, false, true>::sizes.storage == NoRouting &&
                           Fitted<Lossless, Degree, true, false>::sizes.storage == NoBloom &&
                           Fitted<Lossless, Degree, false, false>::sizes.storage == Neither;
static_assert(has_slots<0, 2000, 2941, 2706, 3758>);
static_assert(has_slots<1, 1581, 2326, 2139, 2953>);
static_assert(has_slots<2, 1172, 1724, 1586, 2176>);
static_assert(has_slots<3, 860, 1266, 1164, 1590>);

// Channels whose slots `limit` gives keep that form for other records, and free only their heads. Sizes of 4 GiB and more do not wrap.
struct ByLimit : Lossless {
    static constexpr Sizes sizes{.storage = 2000, .road = dynamic_capacity, .beam = dynamic_capacity, .waiting = 200, .tile_pixels = 640};
};
static_assert(Fitted<ByLimit, 3>::sizes.road == dynamic_capacity && Fitted<ByLimit, 3>::sizes.beam == dynamic_capacity);
static_assert(Fitted<ByLimit, 3>::sizes.storage == 860 && Fitted<ByLimit, 0, true, false>::sizes.storage == 2000);
constexpr Setup huge = with(lossless, [](Setup& s) { s.sizes = {.storage = 1u << 30, .road = 1u << 30}; });
static_assert(refitted(huge, huge).sizes.road == 1u << 30 && refitted(huge, huge).sizes.storage == 1u << 30);

using Ledger = std::map<std::string, std::uint32_t>;
template <class S>
Ledger ledger()
{
    Ledger out;
    for (machine::Region const& r : Tile<Mk2, Frame<S>, S>::ledger()) out[std::string(r.name.text, r.name.size)] += r.bytes;
    return out;
}
std::set<std::string> names(Ledger const& rows)
{
    std::set<std::string> out;
    for (auto const& row : rows) out.insert(row.first);
    return out;
}
std::set<std::string> const always = {"storage",     "marks",       "projected records", "counters",       "sort keys",
                                      "framebuffer", "pair counters", "frame parameters",  "code and stacks"};
std::set<std::string> const of_routing = {"road", "waiting (side 0)", "waiting (side 1)", "credits and flow control"};
std::set<std::string> const of_bloom = {"beam", "bloom debts"};

/// The ledger of Lossless says which bytes routing and bloom take. A setup without them has the rows that it needs, and their bytes as
/// slots.
template <std::uint32_t Degree, bool Routes, bool Blooms>
void check_ledger()
{
    using S = Fitted<Lossless, Degree, Routes, Blooms>;
    INFO("degree ", Degree, Routes ? ", routing" : "", Blooms ? ", bloom" : "");
    auto const whole = ledger<Lossless>(), rows = ledger<S>();
    auto expected = always;
    std::uint32_t for_slots = Lossless::sizes.storage * (60 + sizeof(Mark) + sizeof(Splat) + sizeof(SortKey));
    for (auto const& [used, group] : {std::pair{Routes, of_routing}, std::pair{Blooms, of_bloom}})
        for (auto const& name : group) {
            if (used)
                expected.insert(name);
            else
                for_slots += whole.at(name);
        }
    CHECK(names(rows) == expected);
    CHECK(S::sizes.storage == for_slots / (sizeof(typename S::Record) + sizeof(MarkOf<S>) + sizeof(Splat) + sizeof(SortKey)));
    CHECK(Tile<Mk2, Frame<S>, S>::bytes <= Tile<Mk2, Frame<Lossless>, Lossless>::bytes);
    CHECK(Tile<Mk2, Frame<S>, S>::bytes <= Mk2::sram_bytes);
    std::uint64_t sum = 0;
    for (auto const& row : rows) sum += row.second;
    CHECK(sum == Tile<Mk2, Frame<S>, S>::bytes);
    CHECK(rows.at("storage") == 8 + S::sizes.storage * sizeof(typename S::Record));
}
template <std::uint32_t Degree>
void check_ledgers()
{
    check_ledger<Degree, true, true>();
    check_ledger<Degree, false, true>();
    check_ledger<Degree, true, false>();
    check_ledger<Degree, false, false>();
}

// --- frames ------------------------------------------------------------------------------------------------------------------------
bool no_routing(report::FrameReport const& r)
{
    return r.exchanges.route == 0 && r.hops == 0 && r.gaussians.moved == 0 && r.gaussians.under_way == 0 && r.refused.no_credit == 0;
}
bool no_bloom(report::FrameReport const& r)
{
    return r.exchanges.bloom == 0 && r.copies == 0 && r.messages == r.hops && r.refused.copies_full == 0 &&
           r.refused.copies_refused == 0;
}
bool same_splats(report::FrameReport const& a, report::FrameReport const& b)
{
    return a.gaussians.visible == b.gaussians.visible && a.gaussians.parked == b.gaussians.parked && a.pairs == b.pairs &&
           a.pairs_contributing == b.pairs_contributing;
}
bool no_exchange(report::FrameReport const& r)
{
    return r.exchanges.total() == 0 && r.messages == 0 && r.exchanged_live_bytes == 0 && r.exchanged_capacity_bytes == 0 &&
           r.peak_channel == 0;
}
std::set<std::pair<std::uint32_t, std::uint32_t>> listed(report::FrameReport const& r, report::Cause cause)
{
    std::set<std::pair<std::uint32_t, std::uint32_t>> out;
    for (auto const& l : r.lost)
        if (l.cause == cause) CHECK(out.insert({static_cast<std::uint32_t>(l.id), l.tile}).second);
    return out;
}

/// By brute force, in the order of the map: records for which a host that places records finds no slot, and tiles that lack a copy without
/// bloom.
struct Expected {
    std::set<std::pair<std::uint32_t, std::uint32_t>> unplaced, copies;
    std::vector<std::set<std::uint32_t>> anchored; ///< by tile
};
Expected expected(std::vector<Gaussian> const& gaussians, Camera const& camera, Tiling const& tiling, Grid grid, std::uint32_t slots)
{
    Expected e;
    e.anchored.resize(grid.size());
    for (auto const& g : gaussians) {
        auto const s = project(g, make_view(camera, {}), tiling);
        if (!s.visible()) continue;
        auto const id = static_cast<std::uint32_t>(g.id);
        auto& anchored = e.anchored[grid.index_of(s.anchor)];
        if (anchored.size() == slots) {
            e.unplaced.insert({id, report::Loss::whole});
            continue;
        }
        anchored.insert(id);
        for (std::uint32_t t = 0; t < grid.size(); ++t)
            if (covers(s, tiling, grid.tile(t)) && !(grid.tile(t) == s.anchor)) e.copies.insert({id, t});
    }
    return e;
}
/// The number of tiles with other anchored records, or other copies, than brute force gives. `copies` false: tiles that hold any copy.
std::uint32_t wrong_tiles(support::Runner& renderer, Expected const& e, bool copies)
{
    auto const grid = renderer.grid();
    std::uint32_t wrong = 0;
    for (std::uint32_t t = 0; t < grid.size(); ++t) {
        std::set<std::uint32_t> anchored, brought, want;
        bool twice = false;
        for (auto const& m : renderer.marks(grid.tile(t)))
            twice |= !(m.is(Mark::copy) ? brought : anchored).insert(static_cast<std::uint32_t>(m.id)).second;
        for (auto const& [id, tile] : e.copies)
            if (copies && tile == t) want.insert(id);
        wrong += twice || anchored != e.anchored[t] || brought != want ? 1 : 0;
    }
    return wrong;
}

constexpr RendererOptions tiles_of_16{.grid = {4, 3}, .tile = {16, 16}};
/// A ball in the middle of each tile of 16 x 16 pixels, several behind each other. None touches a second tile.
std::vector<Gaussian> middles(Camera const& camera)
{
    std::vector<Gaussian> out;
    std::uint32_t id = 0;
    for (std::uint32_t layer = 0; layer < 4; ++layer)
        for (std::uint32_t y = 0; y < 3; ++y)
            for (std::uint32_t x = 0; x < 4; ++x) {
                auto g = support::ball(++id, 16.0f * static_cast<float>(x) + 7.0f + 0.5f * static_cast<float>(layer),
                                       16.0f * static_cast<float>(y) + 8.0f, 0.4f + 0.2f * static_cast<float>(layer), 0.3f);
                g.colour[0] = 0.1f * static_cast<float>(x + layer);
                out.push_back(g);
            }
    auto const tiling = make_tiling(camera.width, camera.height, 16, 16);
    for (auto const& g : out) REQUIRE(tiles_of(project(g, make_view(camera, {}), tiling), tiling).count() == 1);
    return out;
}
} // namespace

TEST_CASE("fitted: the ledger has no row for a part that is left out; its bytes are slots of storage")
{
    check_ledgers<0>();
    check_ledgers<1>();
    check_ledgers<2>();
    check_ledgers<3>();
    CHECK(ledger<Fitted<Lossless, 0>>() == ledger<Lossless>());
}

TEST_CASE("fitted: records with room for harmonics that are zero change no bit and no counter")
{
    auto const gaussians = support::cloud(250, 181);
    auto const plain = make_runner<Whole>(support::map_of(gaussians), tiles_of_16);
    auto const shaded = make_runner<Shaded>(support::map_of(gaussians), tiles_of_16);
    for (float turn : {0.0f, 0.0f, 0.02f, 0.4f}) {
        auto const camera = support::lens(64, 48, turn);
        auto const a = plain->render(camera), b = shaded->render(camera);
        INFO("turn ", turn);
        CHECK(a.report.gaussians.held + b.report.gaussians.held == 0); // a channel has bytes, so it holds fewer of the larger records
        CHECK(support::differing_pixels(a.image, b.image) == 0);
        CHECK(support::differing_pixels(a.image, report::render_naive(gaussians, camera, Rules{})) == 0);
        CHECK(report::first_difference(a.report, b.report, {"exchanged_bytes"}) == "");
        auto const copies = a.report.messages - a.report.hops;
        CHECK(a.report.exchanged_live_bytes >= 64 * a.report.hops + 60 * copies);
        CHECK(b.report.exchanged_live_bytes - a.report.exchanged_live_bytes == 180 * (a.report.hops + copies));
    }
}

TEST_CASE("fitted: routing that has nothing to do changes no bit and no counter")
{
    auto gaussians = support::cloud(250, 182);
    auto const camera = support::lens(64, 48);
    auto const tiling = make_tiling(64, 48, 16, 16);
    // A record with nothing on screen is parked on a tile or stays with the host; only the peak of storage would show the difference.
    std::erase_if(gaussians, [&](Gaussian const& g) { return !project(g, make_view(camera, {}), tiling).visible(); });
    auto const routes = make_runner<Whole>(support::map_of(gaussians), tiles_of_16);
    auto const placed = make_runner<NoRouting>(support::map_of(gaussians), tiles_of_16);
    auto const cold = routes->render(camera), first = placed->render(camera);
    CHECK(cold.report.exchanges.route > 0);
    CHECK(cold.report.gaussians.moved > 0);
    CHECK(no_routing(first.report));
    CHECK(first.report.exchanges.bloom == cold.report.exchanges.bloom);
    CHECK(first.report.messages == cold.report.messages - cold.report.hops);
    auto const naive = report::render_naive(gaussians, camera, Rules{});
    for (int frame = 0; frame < 2; ++frame) {
        auto const still = routes->render(camera), same = placed->render(camera);
        CHECK(report::first_difference(still.report, same.report) == "");
        CHECK(still.report.pairs == first.report.pairs);
        CHECK(no_exchange(still.report));
        CHECK(no_exchange(same.report));
        CHECK(no_routing(same.report));
        CHECK(support::differing_pixels(still.image, naive) == 0);
        CHECK(support::differing_pixels(same.image, naive) == 0);
    }
    CHECK(support::differing_pixels(first.image, naive) == 0);
}

TEST_CASE("fitted: bloom changes no bit and no counter if no footprint spans two tiles")
{
    auto camera = support::flat_camera(64, 48);
    auto const gaussians = middles(camera);
    auto const whole = make_runner<Whole>(support::map_of(gaussians), tiles_of_16);
    auto const routes = make_runner<NoBloom>(support::map_of(gaussians), tiles_of_16);
    auto const blooms = make_runner<NoRouting>(support::map_of(gaussians), tiles_of_16);
    auto const minimal = make_runner<Minimal>(support::map_of(gaussians), tiles_of_16);
    auto const check = [&](bool moved) {
        auto const naive = report::render_naive(gaussians, camera, Rules{});
        auto const a = whole->render(camera), b = routes->render(camera), c = blooms->render(camera), d = minimal->render(camera);
        for (auto const* frame : {&a, &b, &c, &d}) {
            CHECK(support::differing_pixels(frame->image, naive) == 0);
            CHECK(no_bloom(frame->report));
            CHECK(frame->report.lost.empty());
            CHECK(same_splats(frame->report, d.report));
        }
        CHECK((a.report.exchanges.route > 0) == moved);
        CHECK(report::first_difference(a.report, b.report, {"exchanged_bytes.capacity", "passes.bloom"}) == "");
        CHECK(report::first_difference(c.report, d.report, {"passes.bloom"}) == "");
        CHECK(no_exchange(c.report));
        CHECK(no_exchange(d.report));
    };
    check(true);
    CHECK(minimal->render(camera).report.gaussians.visible == gaussians.size());
    check(false);
    camera.cx += 16; // every record one tile to the right; those of the last column leave the frame
    check(true);
    check(false);
}

TEST_CASE("fitted: one tile that holds the frame needs neither; its planes change no colour")
{
    auto const gaussians = support::cloud(250, 183);
    RendererOptions const one{.grid = {1, 1}};
    auto const whole = make_runner<Whole>(support::map_of(gaussians), one);
    auto const minimal = make_runner<Minimal>(support::map_of(gaussians), one);
    auto const planes = make_runner<NoBloom>(support::map_of(gaussians), one);
    for (float turn : {0.0f, 0.0f, 0.3f}) {
        auto const camera = support::lens(64, 48, turn);
        auto const a = whole->render(camera), b = minimal->render(camera), c = planes->render(camera);
        CHECK(support::differing_pixels(b.image, report::render_naive(gaussians, camera, Rules{})) == 0);
        CHECK(support::differing_pixels(a.image, b.image) == 0);
        CHECK(support::differing_pixels(c.image, b.image) == 0);
        CHECK(report::first_difference(a.report, c.report, {"passes.bloom"}) == "");
        CHECK(no_exchange(a.report));
        CHECK(no_exchange(b.report));
        CHECK(no_routing(b.report));
        CHECK(no_bloom(b.report));
        CHECK(same_splats(a.report, b.report));
        CHECK(b.depth.empty());
        CHECK(b.alpha.empty());
        CHECK(c.depth.values.size() == 64 * 48);
        CHECK(c.alpha.values.size() == 64 * 48);
        CHECK(*std::max_element(c.alpha.values.begin(), c.alpha.values.end()) > 0.5f);
    }
    auto const nothing = make_runner<Minimal>(support::map_of({}), one)->render(support::lens(64, 48));
    CHECK(nothing.report.pairs == 0);
    CHECK(*std::max_element(nothing.image.rgb.begin(), nothing.image.rgb.end()) == 0.0f);
}

TEST_CASE("fitted: without bloom a footprint ends at its anchor tile, and every missing copy is listed")
{
    auto const gaussians = support::cloud(250, 184);
    auto const check = [&](std::unique_ptr<support::Runner> const& renderer, bool routes, float turn) {
        auto const camera = support::lens(64, 48, turn);
        auto const frame = renderer->render(camera);
        auto const grid = renderer->grid();
        auto const e = expected(gaussians, camera, renderer->tiling(), grid, renderer->facts().sizes.storage);
        INFO("turn ", turn);
        CHECK(listed(frame.report, report::Cause::no_bloom) == e.copies);
        CHECK(frame.report.lost.size() == e.copies.size());
        CHECK(frame.report.lost_copies == e.copies.size());
        CHECK(no_bloom(frame.report));
        if (!routes) {
            CHECK(no_routing(frame.report));
            CHECK(wrong_tiles(*renderer, e, false) == 0);
        }
        auto const lacking = report::render_naive(gaussians, camera, Rules{}, support::Missing(frame.report, renderer->tiling(), grid));
        CHECK(support::differing_pixels(frame.image, lacking) == 0);
        if (!e.copies.empty())
            CHECK(support::differing_pixels(frame.image, report::render_naive(gaussians, camera, Rules{})) > 0);
        return e.copies.size();
    };
    auto const minimal = make_runner<Minimal>(support::map_of(gaussians), tiles_of_16);
    auto const routes = make_runner<NoBloom>(support::map_of(gaussians), tiles_of_16);
    for (float turn : {0.0f, 0.0f, 0.3f, -0.2f}) {
        CHECK(check(minimal, false, turn) > 50);
        CHECK(check(routes, true, turn) > 50);
    }
    CHECK(check(minimal, false, 3.14159265f) == 0); // the cloud is behind the camera
    CHECK(check(minimal, false, 0.1f) > 50);
}

TEST_CASE("fitted: without routing the host places every view anew, on both engines and any number of threads")
{
    auto const gaussians = support::cloud(300, 185);
    auto const options = [](std::uint32_t threads) { return RendererOptions{.threads = threads, .grid = {4, 3}, .tile = {16, 16}, .digest = true}; };
    auto const placed = make_runner<NoRouting>(support::map_of(gaussians), options(1));
    auto const threads = make_runner<NoRouting>(support::map_of(gaussians), options(3));
    auto const checked = make_runner<NoRouting, CheckedMesh>(support::map_of(gaussians), options(1));
    for (float turn : {0.0f, 0.4f, 0.4f, -0.5f, 3.14159265f, 0.01f, 0.0f}) {
        auto const camera = support::lens(64, 48, turn);
        auto const frame = placed->render(camera);
        INFO("turn ", turn);
        CHECK(support::differing_pixels(frame.image, report::render_naive(gaussians, camera, Rules{})) == 0);
        CHECK(frame.report.lost.empty());
        CHECK(no_routing(frame.report));
        CHECK(frame.report.gaussians.visible + frame.report.gaussians.parked == gaussians.size());
        auto const e = expected(gaussians, camera, placed->tiling(), placed->grid(), NoRouting::sizes.storage);
        CHECK(wrong_tiles(*placed, e, true) == 0);
        CHECK(frame.report.copies == e.copies.size());
        CHECK(frame.report.messages >= (turn == 0.4f ? 0 : frame.report.copies)); // each copy is sent again, except if a view is repeated
        for (auto const& other : {threads->render(camera), checked->render(camera)}) {
            CHECK(support::differing_pixels(other.image, frame.image) == 0);
            CHECK(other.report.digests.size() == frame.report.digests.size());
            CHECK(report::first_difference(other.report, frame.report) == "");
        }
    }
}

TEST_CASE("fitted: without routing a record whose tile is full is listed, and the picture lacks exactly these records")
{
    auto const gaussians = support::cloud(300, 186);
    RendererOptions const options{.grid = {4, 3}, .tile = {16, 16}, .storage_slots = 20};
    auto const minimal = make_runner<Minimal>(support::map_of(gaussians), options);
    auto const blooms = make_runner<NoRouting>(support::map_of(gaussians), options);
    std::uint64_t most_unplaced = 0;
    for (float turn : {0.0f, 0.0f, 0.5f, 3.14159265f, 0.9f, 0.0f}) {
        auto const camera = support::lens(64, 48, turn);
        auto const a = minimal->render(camera), b = blooms->render(camera);
        auto const grid = minimal->grid();
        auto const e = expected(gaussians, camera, minimal->tiling(), grid, 20);
        INFO("turn ", turn);
        most_unplaced = std::max<std::uint64_t>(most_unplaced, e.unplaced.size());
        CHECK(listed(a.report, report::Cause::unplaced) == e.unplaced);
        CHECK(listed(a.report, report::Cause::no_bloom) == e.copies);
        CHECK(a.report.lost.size() == e.unplaced.size() + e.copies.size());
        CHECK(listed(b.report, report::Cause::unplaced) == e.unplaced);
        CHECK(listed(b.report, report::Cause::storage_full).size() == b.report.lost_copies);
        CHECK(b.report.copies + b.report.lost_copies == e.copies.size());
        for (auto const* frame : {&a, &b}) {
            CHECK(frame->report.gaussians.unplaced == e.unplaced.size());
            CHECK(frame->report.gaussians.visible + frame->report.gaussians.parked == gaussians.size());
            CHECK(no_routing(frame->report));
            auto const lacking =
                report::render_naive(gaussians, camera, Rules{}, support::Missing(frame->report, minimal->tiling(), grid));
            CHECK(support::differing_pixels(frame->image, lacking) == 0);
        }
    }
    CHECK(most_unplaced > 20);
}

TEST_CASE("without routing, bounded hops: a message under way from another view does not prove a copy; a static view shows all records in the end")
{
    auto const gaussians = support::cloud(250, 184);
    for (std::uint32_t hops : {1u, 2u}) {
        auto const renderer = make_runner<NoRouting>(support::map_of(gaussians), {.grid = {6, 5}, .hops = hops});
        for (int i = 0; i < 8; ++i) (void)renderer->render(support::lens(96, 80, 0.07f * static_cast<float>(i)));
        report::FrameReport last;
        for (int i = 0; i < 30; ++i) last = renderer->render(support::lens(96, 80, 0.2f)).report;
        CHECK(last.lost.empty());
        CHECK(last.copies > 100);
    }
}

TEST_CASE("a view that the demand does not cover is refused while records are missing; records that are not loaded count as parked")
{
    auto const gaussians = support::cloud(250, 184);
    auto const map = support::map_of(gaussians);
    std::vector<splat::Camera> const path{support::lens(96, 80, 1.0f)};
    RendererOptions const options{.grid = {6, 5}};
    auto const demand = scene::demand_of(map, std::span(path), splat::Rules{}, [&](splat::Camera const& c) {
        return tiling_for(options, c.width, c.height);
    });
    REQUIRE(demand.culled > 0);
    auto renderer = support::renderer_for<NoRouting>(map, demand, options);
    auto const r = renderer.render(path[0]).report;
    CHECK(r.gaussians.visible + r.gaussians.parked == gaussians.size());
    CHECK_THROWS_WITH_AS(renderer.render(support::lens(96, 80)),
                         doctest::Contains("a view that the demand was not made for"), Error);
    renderer.rules().alpha_min = 0.001f;
    CHECK_THROWS_AS(renderer.render(path[0]), Error);
}
