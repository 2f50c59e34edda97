// test: unoptimised test, without test asan tsan
// The forms of the program of homes: records of all degrees, depth, alpha and 8-bit pixels, by value and by reference, and its ledger.
#include "../compare_reports.hpp"
#include "support.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/render/homes_renderer.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/splat/blending.hpp>

using namespace tilemesh;
namespace homes = splat::homes;
using splat::FloatPixel, splat::Rgbx8Pixel, splat::WithAlpha, splat::WithDepth;
using Planes = WithAlpha<WithDepth<FloatPixel>>;

namespace {
/// The default sizes on the paper's grid at 1280 x 720.
constexpr splat::Sizes default_sizes()
{
    auto sizes = splat::homes_setup.sizes;
    sizes.tile_blocks = homes::make_fold(1280, 720, {40, 36}, true).tile_blocks();
    sizes.tile_pixels = sizes.tile_blocks * splat::block_width * splat::block_height;
    sizes.columns = 40;
    sizes.tiles = 1440;
    return sizes;
}
struct Default {
    static constexpr splat::Sizes sizes = default_sizes();
};
static_assert(Default::sizes.tile_blocks == 8);
static_assert(Tile<Mk2, homes::Frame<homes::ValuePolicies<>>, Default>::bytes <= Mk2::sram_bytes);
static_assert(Tile<Mk2, homes::Frame<homes::ValuePolicies<0, Planes>>, Default>::bytes <= Mk2::sram_bytes);

template <std::uint32_t Degree, class Pixel>
void check_ledger(splat::Sizes const& sizes)
{
    using Ledger = SramLedger<homes::Frame<homes::ValuePolicies<Degree, Pixel>>>;
    auto c = splat::homes_setup;
    c.sh_degree = Degree;
    c.colour = splat::colour_format<Pixel>;
    c.depth = Pixel::has_depth;
    c.alpha = Pixel::has_alpha;
    c.sizes = sizes;
    auto const found = render::ledger_of(c);
    auto const expected = Ledger::lines(c.machine, sizes);
    REQUIRE(found.size() == expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        auto const& f = found[i];
        auto const& e = expected[i];
        auto const name = std::string(e.name.text, e.name.size);
        CAPTURE(name);
        CHECK(std::string(f.name.text, f.name.size) == name);
        CHECK(std::string(f.what) == e.what);
        CHECK(f.bytes == e.bytes);
        CHECK(f.budgeted == e.budgeted);
    }
    CHECK(render::sram_bytes_of(c) == Ledger::bytes(c.machine, sizes));
}
splat::Sizes laid_out(std::uint32_t homes, std::uint32_t held, std::uint32_t parcels, std::uint32_t waiting, std::uint32_t blocks, std::uint32_t columns,
                      std::uint32_t tiles)
{
    auto sizes = splat::homes::homes_sizes(homes, held, parcels, waiting);
    sizes.tile_blocks = blocks;
    sizes.tile_pixels = 80 * blocks;
    sizes.columns = columns;
    sizes.tiles = tiles;
    return sizes;
}
template <std::uint32_t Degree>
void check_ledgers(splat::Sizes const& sizes)
{
    check_ledger<Degree, FloatPixel>(sizes);
    check_ledger<Degree, Rgbx8Pixel>(sizes);
    check_ledger<Degree, WithDepth<FloatPixel>>(sizes);
    check_ledger<Degree, WithAlpha<FloatPixel>>(sizes);
    check_ledger<Degree, Planes>(sizes);
    check_ledger<Degree, WithDepth<Rgbx8Pixel>>(sizes);
}

scene::Map map_of_degree(std::uint32_t degree, std::uint32_t n)
{
    auto map = support::map_of(support::cloud(n, 40 + degree));
    support::Random random(degree);
    map.sh_degree = degree;
    for (std::size_t i = 0; degree != 0 && i < std::size_t{n} * 3 * splat::harmonics_per_channel(degree); ++i)
        map.harmonics.push_back(random.uniform(-0.4f, 0.4f));
    return map;
}
/// A machine on which tiles hold 12 splats and channels 3.
render::Setup choice_of(std::uint32_t degree)
{
    auto c = splat::homes_setup;
    c.machine.sram_bytes = 1u << 24;
    c.sizes = splat::homes::homes_sizes(100, 12, 3, 2);
    c.sh_degree = degree;
    return c;
}
RendererOptions on_grid(std::uint32_t threads = 1)
{
    return {.threads = threads, .grid = {4, 3}, .digest = true};
}
constexpr std::uint32_t width = 83, height = 47;
std::vector<splat::Camera> views()
{
    return {support::lens(width, height), support::lens(width, height, 0.03f), support::lens(width, height, 0.6f)};
}

/// The frame as one list, without tiles, with planes.
template <class Record>
std::vector<Planes> one_list(std::vector<Record> const& records, splat::Camera const& camera, splat::Rules const& rules)
{
    auto const splats = support::sorted_splats(records, splat::make_view(camera, rules));
    std::vector<Planes> pixels(width * height);
    auto const at = [&](std::uint32_t i) -> splat::Splat const& { return splats[i]; };
    splat::blend_tile({0, width, 0, height}, camera, rules, static_cast<std::uint32_t>(splats.size()), at, pixels.data(), width, Worker{0, 1});
    return pixels;
}
/// The number of pixels of a frame that differ from the list's, in its colours or in a plane that it has.
std::uint32_t differing(RenderedFrame const& frame, std::vector<Planes> const& pixels)
{
    std::uint32_t n = 0;
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            auto const& p = pixels[y * width + x];
            n += std::memcmp(frame.image.pixel(x, y), p.colour.colour.rgb, 12) != 0 ||
                 (!frame.alpha.empty() && frame.alpha.at(x, y) != p.alpha) || (!frame.depth.empty() && frame.depth.at(x, y) != p.colour.depth);
        }
    return n;
}

/// Two reports of one frame, by value and by reference.
void check_same_work(report::FrameReport const& a, report::FrameReport const& b)
{
    for (auto const& field : report::report_fields) {
        CAPTURE(field.name);
        if (field.homes.word != nullptr || field.homes.of_workers != nullptr) CHECK(field.count(a) == field.count(b));
    }
    CHECK(a.homes.rounds == b.homes.rounds);
    CHECK(a.messages == b.messages);
    CHECK(a.exchanged_live_bytes == b.exchanged_live_bytes);
    CHECK(a.passes.total() == b.passes.total());
    CHECK(a.exchanges.total() == b.exchanges.total());
    CHECK(a.peak_storage == b.peak_storage);
    CHECK(a.peak_channel == b.peak_channel);
}
/// Renderers by value and by reference show the list's pixels, by the same work.
template <class Record>
void check_both(auto& values, auto& rows, std::vector<Record> const& records)
{
    for (auto const& view : views()) {
        auto const list = one_list(records, view, values.rules());
        auto const a = values.render(view), r = rows.render(view);
        CHECK(differing(a, list) == 0);
        CHECK(differing(r, list) == 0);
        check_same_work(a.report, r.report);
    }
}
} // namespace

TEST_CASE("homes: the ledger of a choice is that of the program, line by line")
{
    for (splat::Sizes const& sizes : {Default::sizes, laid_out(1, 1, 1, 1, 1, 1, 1), laid_out(0, 7, 3, 2, 6, 5, 35)}) {
        check_ledgers<0>(sizes);
        check_ledgers<1>(sizes);
        check_ledgers<2>(sizes);
        check_ledgers<3>(sizes);
    }
}

TEST_CASE("homes: degree 1 with depth and alpha, by value and by reference, on both engines")
{
    auto const map = map_of_degree(1, support::fast() ? 60 : 150);
    auto const records = scene::records<splat::ShadedGaussian<1>>(map);
    auto c = choice_of(1);
    c.depth = c.alpha = true;
    render::HomesRenderer<homes::ValuePolicies<1, Planes>> values(map, c, on_grid());
    render::HomesRenderer<homes::ValuePolicies<1, Planes>, CheckedMesh> checked(map, c, on_grid());
    render::HomesRenderer<homes::HostPolicies<Planes>> rows(map, c, on_grid(3));
    for (auto const& view : views()) {
        auto const list = one_list(records, view, values.rules());
        auto const a = values.render(view), b = checked.render(view), r = rows.render(view);
        REQUIRE(!a.depth.empty());
        REQUIRE(!a.alpha.empty());
        CHECK(differing(a, list) == 0);
        CHECK(differing(b, list) == 0);
        CHECK(differing(r, list) == 0);
        CHECK(a.report.digests == b.report.digests);
        check_same_work(a.report, b.report);
        check_same_work(a.report, r.report);
        CHECK(a.report.homes.rounds > 1);
        CHECK(support::differing_pixels(a.image, report::render_naive(records, view, values.rules())) == 0);
    }
    // A choice with one plane shows one.
    c.alpha = false;
    auto const depth = render::HomesRenderer<homes::HostPolicies<Planes>>(map, c, on_grid()).render(views()[0]);
    CHECK(depth.alpha.empty());
    CHECK(differing(depth, one_list(records, views()[0], c.rules)) == 0);
}

TEST_CASE("homes: degree 2 with 8-bit pixels, by value and by reference")
{
    auto const map = map_of_degree(2, support::fast() ? 60 : 150);
    auto const records = scene::records<splat::ShadedGaussian<2>>(map);
    auto c = choice_of(2);
    c.colour = render::ColourFormat::rgbx8;
    render::HomesRenderer<homes::ValuePolicies<2, Rgbx8Pixel>> values(map, c, on_grid(2));
    render::HomesRenderer<homes::HostPolicies<>> rows(map, c, on_grid());
    for (auto const& view : views()) {
        auto expected = report::render_naive(records, view, values.rules());
        for (std::uint32_t y = 0; y < height; ++y) render::detail::round_to_levels(expected.pixel(0, y), 3 * width);
        auto const a = values.render(view), r = rows.render(view);
        CHECK(support::differing_pixels(a.image, expected) == 0);
        CHECK(support::differing_pixels(r.image, expected) == 0);
        check_same_work(a.report, r.report);
    }
}

TEST_CASE("homes: degree 3, by value and by reference, precise and fast; rows and columns that are longer than a parcel")
{
    auto const map = map_of_degree(3, support::fast() ? 60 : 150);
    auto const records = scene::records<splat::ShadedGaussian<3>>(map);
    static_assert(homes::make_fold(width, height, {6, 12}, true).y.tiles > homes::parcel_rows);
    for (auto const& [grid, arithmetic] : {std::pair{Extent2{4, 3}, splat::Arithmetic::precise}, std::pair{Extent2{4, 3}, splat::Arithmetic::fast},
                                           std::pair{Extent2{6, 12}, splat::Arithmetic::precise}}) {
        RendererOptions const o{.grid = grid, .arithmetic = arithmetic, .digest = true};
        render::HomesRenderer<homes::ValuePolicies<3>> values(map, choice_of(3), o);
        render::HomesRenderer<homes::HostPolicies<>> rows(map, choice_of(3), o);
        check_both(values, rows, records);
    }
}

TEST_CASE("homes: hundreds of splats arrive on a tile in one pass, and some reach many blocks, by value and by reference")
{
    auto const map = map_of_degree(0, 700);
    auto const records = scene::records<splat::Gaussian>(map);
    auto c = choice_of(0);
    c.sizes = splat::homes::homes_sizes(250, 700, 250, 250);
    auto o = on_grid();
    o.grid = {3, 1};
    render::HomesRenderer<homes::ValuePolicies<>> values(map, c, o);
    render::HomesRenderer<homes::HostPolicies<>> rows(map, c, o);
    std::uint32_t most = 0, before = 0; // that end on the middle tile in one pass
    rows.observe([&](SuperstepEvent const& event) {
        auto const arrived = std::as_const(rows.mesh()).state<homes::Counts>(TileId::at(1, 0)).arrived;
        if (event.kernel == homes::Deliver<homes::HostPolicies<>>::name) most = std::max(most, arrived - before);
        before = arrived;
    });
    check_both(values, rows, records);
    CHECK(most > 128); // more than a host notes at once (deliver.hpp)
}

TEST_CASE("homes: choices and sizes that cannot work are refused, and lose nothing")
{
    using Rows = render::HomesRenderer<homes::HostPolicies<>>;
    using Values = render::HomesRenderer<homes::ValuePolicies<3>>;
    auto const map = map_of_degree(0, 24);
    auto const view = support::lens(width, height);
    auto const error = [&](render::Setup const& c, auto tag, RendererOptions const& o = on_grid()) -> std::string {
        return tests::error_of([&] { typename decltype(tag)::type(map, c, o).render(view); });
    };
    auto const good = choice_of(0);
    machine::Tag<Rows> const rows;
    CHECK(error(good, rows) == "");
    auto const slots = [&](splat::Sizes const& sizes) {
        auto c = good;
        c.sizes = sizes;
        return error(c, rows);
    };
    auto const no_slots = [](char const* list) {
        return "list " + std::string(list) + " with 0 slots (with fewer than 1 its program makes no progress); give it more slots";
    };
    CHECK(slots(homes::homes_sizes(100, 0, 3, 2)) == no_slots("held splats"));
    CHECK(slots(homes::homes_sizes(100, 30, 0, 2)) == no_slots("parcels"));
    CHECK(slots(homes::homes_sizes(100, 30, 3, 0)) == no_slots("waiting (side 0)"));
    CHECK(slots(homes::homes_sizes(2, 1, 1, 1)) == ""); // 24 records on 12 tiles
    CHECK(slots(homes::homes_sizes(1, 1, 1, 1)) == ""); // in chapters
    CHECK(slots(homes::homes_sizes(0, 1, 1, 1)) == "tiles without homes (every record lives in one); give a tile at least one");
    std::string const differ = "a setup with records or pixels that the renderer's policies do not store (degree, colour format, depth or alpha "
                               "differ); give both the same";
    auto c = good;
    c.depth = true;
    CHECK(error(c, rows) == differ);
    CHECK(error(good, machine::Tag<Values>{}) == differ);
    c = good;
    c.machine.workers = 7;
    CHECK(error(c, rows) == "machine mk2 with 7 workers (a tile counts the work of 1 to 6); give the machine 1 to 6 workers");
    c = good;
    c.machine.sram_bytes = 140'000;
    CHECK(error(c, rows).find("the program does not fit in a tile's SRAM") == 0);

    // A frame that is refused leaves the renderer as it was.
    Rows renderer(map, good, on_grid());
    auto const first = renderer.render(view);
    CHECK_THROWS_AS(renderer.render(support::lens(0, 10)), Error);
    CHECK(support::differing_pixels(renderer.render(view).image, first.image) == 0);
    // An empty map is black.
    Rows empty(support::map_of({}), good, on_grid());
    auto const black = empty.render(view);
    CHECK(support::differing_pixels(black.image, report::Image(width, height)) == 0);
    CHECK(black.report.homes.entries == 0);
}
