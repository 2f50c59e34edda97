// test: unoptimised test asan tsan
// The options of a renderer: sizes at run time replace those of a setup, and model() sets the rules of the picture.
#include "../compare_reports.hpp"
#include "../splat/runner.hpp"

using namespace tilemesh;
using namespace tilemesh::splat;
using support::make_runner;
using support::Whole;

namespace {
scene::Map cloud() { return support::map_of(support::cloud(400, 21)); }
std::vector<Camera> path()
{
    std::vector<Camera> out;
    for (float turn : {0.0f, 0.0f, 0.02f, -0.4f, 3.1f, 0.01f}) out.push_back(support::lens(120, 80, turn));
    return out;
}
void same_frames(support::Runner& a, support::Runner& b)
{
    for (auto const& camera : path()) {
        auto const x = a.render(camera), y = b.render(camera);
        CHECK(support::differing_pixels(x.image, y.image) == 0);
        CHECK(report::first_difference(x.report, y.report) == "");
        CHECK(x.report.digests == y.report.digests);
        CHECK(a.on_tiles() == b.on_tiles());
    }
}
void same_ledgers(std::vector<machine::Region> const& a, std::vector<machine::Region> const& b)
{
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        CHECK(std::string(a[i].name.text, a[i].name.size) == std::string(b[i].name.text, b[i].name.size));
        CHECK(a[i].bytes == b[i].bytes);
        CHECK(a[i].budgeted == b[i].budgeted);
    }
}
std::string refusal(Sizes const& sizes)
{
    return tests::error_of([&] { (void)make_runner<Lossless>(cloud(), {.sizes = sizes}); });
}
} // namespace

TEST_CASE("sizes at run time are those of a setup: picture, counters, digests, tiles and ledger")
{
    using Fixed = support::FixedSizes;
    RendererOptions const fixed{.grid = {7, 6}, .digest = true};
    auto told = fixed;
    told.sizes = Fixed::sizes;
    static_assert(!(Fixed::sizes == Whole::sizes));
    auto const a = make_runner<Fixed>(cloud(), fixed), b = make_runner<Whole>(cloud(), told);
    same_frames(*a, *b);
    same_ledgers(render::ledger_of(a->facts()), render::ledger_of(b->facts()));
    CHECK(render::sram_bytes_of(a->facts()) == render::sram_bytes_of(b->facts()));
    CHECK(b->facts().sizes == Fixed::sizes);
    auto const c = make_runner<Referenced<Fixed>>(cloud(), fixed), d = make_runner<Referenced<Whole>>(cloud(), told);
    same_frames(*c, *d);
    same_ledgers(render::ledger_of(a->facts()), render::ledger_of(d->facts()));
    // The sizes matter: with others it is another frame.
    auto const e = make_runner<Whole>(cloud(), fixed);
    CHECK(e->render(path()[0]).report.gaussians.held != make_runner<Whole>(cloud(), told)->render(path()[0]).report.gaussians.held);
}

TEST_CASE("sizes at run time that do not fit, or leave a setup without FIFOs, are refused with the sentence of the compiler")
{
    auto sizes = Lossless::sizes;
    CHECK(refusal(sizes).empty());
    sizes.storage = 2013; // 622.3 KiB of 624 are taken
    CHECK(refusal(sizes).find("the program does not fit in a tile's SRAM (machine mk2, region storage has ") == 0);
    sizes.storage = 2000 + (Mk2::sram_bytes - Tile<Mk2, Frame<Lossless>, Lossless>::bytes) / 136;
    CHECK(refusal(sizes).empty());
    ++sizes.storage;
    CHECK(refusal(sizes).find("bytes over); give it fewer slots") != std::string::npos);
    for (auto const member : {&Sizes::storage, &Sizes::road, &Sizes::beam, &Sizes::waiting, &Sizes::tile_pixels}) { // 32 bits would wrap
        sizes = Lossless::sizes;
        sizes.lists_fit = false;
        for (std::uint32_t slots : {71'582'789u, 1u << 29, 1u << 30, 0xfffffff0u}) {
            sizes.*member = slots;
            CHECK(refusal(sizes).find("the program does not fit in a tile's SRAM (machine mk2, region ") == 0);
        }
    }
    sizes = Lossless::sizes;
    sizes.waiting = 0;
    CHECK(refusal(sizes).find("a setup that holds needs FIFOs") == 0);
}

TEST_CASE("channels whose slots a limit gives: by value and by reference they fill what the machine's messages leave of the SRAM")
{
    auto sizes = Lossless::sizes;
    sizes.road = sizes.beam = dynamic_capacity;
    RendererOptions options{.grid = {7, 6}, .channel_slots = 3, .sizes = sizes};
    auto fixed = Lossless::sizes;
    fixed.road = fixed.beam = 3;
    auto const camera = path()[3];
    auto const truth = make_runner<Lossless>(cloud(), {.grid = {7, 6}, .sizes = fixed})->render(camera);
    for (auto const make : {make_runner<Lossless>, make_runner<Referenced<Lossless>>}) {
        auto const frame = make(cloud(), options)->render(camera);
        CHECK(support::differing_pixels(frame.image, truth.image) == 0);
        CHECK(report::first_difference(frame.report, truth.report) == "");
    }
    auto const message = [&](auto const make, std::uint32_t slots) {
        options.channel_slots = slots;
        return tests::error_of([&] { (void)make(cloud(), options)->render(camera); });
    };
    for (std::uint32_t slots : {100u, 300u}) {
        auto const refused = message(make_runner<Lossless>, slots);
        CHECK(refused == message(make_runner<Referenced<Lossless>>, slots));
        CHECK(refused.empty() == (slots == 100));
    }
    CHECK(message(make_runner<Referenced<Lossless>>, 0).find("has no slots (its capacity is dynamic") != std::string::npos);
}

TEST_CASE("facts of a setup with other records, rules or planes than a renderer's policies are refused")
{
    using render::check_policies;
    auto const choice = splat::setup_of<Lossless>();
    auto const refused = [](auto policies, render::Setup const& c) {
        return tests::has(tests::error_of([&] { check_policies<decltype(policies)>(render::checked(c)); }), "on a renderer of other policies");
    };
    PoliciesOf<Lossless> const by_value{};
    PoliciesOf<Referenced<Lossless>> const by_reference{};
    PoliciesOf<Referenced<WithPixel<Lossless, WithDepth<FloatPixel>>>> const planes{};
    auto const shaded = render::fitted(choice, 1, true, true);
    auto dropping = choice, screen = choice, recomputed = choice;
    dropping.holds = screen.reusable = recomputed.carried = false;
    for (auto const& c : {choice, shaded, dropping, screen, recomputed}) {
        CHECK(refused(by_value, c) == !(c.sh_degree == 0 && c.holds && c.reusable && c.carried));
        CHECK(!refused(by_reference, c));
    }
    for (bool depth : {false, true})
        for (bool alpha : {false, true}) {
            auto const c = render::with_planes(choice, depth, alpha);
            CHECK(refused(by_reference, c) == (depth || alpha));
            CHECK(refused(by_value, c) == (depth || alpha));
            CHECK(!refused(planes, c));
        }
}

TEST_CASE("model() says from the beginning what the options asked for, and a later change wins")
{
    auto const map = cloud();
    auto const camera = support::lens(120, 80);
    RendererOptions const options{
        .tile = {20, 10}, .footprint = Footprint::three_sigma_square, .arithmetic = Arithmetic::fast, .quality = Quality::viewing};
    auto const runner = make_runner<Referenced<Whole>>(map, options);
    CHECK(runner->rules().footprint == Footprint::three_sigma_square);
    CHECK(runner->rules().arithmetic == Arithmetic::fast);
    CHECK(runner->rules().alpha_min == 1.0f / 128);
    CHECK(runner->rules().transmittance_min == 5e-3f);
    CHECK(runner->rules().alpha_max == Whole::alpha_max);
    auto const plain = make_runner<Referenced<Whole>>(map);
    CHECK(plain->rules().footprint == Whole::footprint);
    CHECK(plain->rules().arithmetic == Whole::arithmetic);

    runner->rules().arithmetic = Arithmetic::precise;
    auto const squares = runner->render(camera).image;
    CHECK(support::differing_pixels(squares, report::render_naive(map.gaussians, camera, runner->rules())) == 0);
    runner->rules().footprint = Footprint::opacity_box;
    runner->rules().alpha_min = 1.0f / 32;
    auto const boxes = runner->render(camera).image;
    CHECK(support::differing_pixels(boxes, report::render_naive(map.gaussians, camera, runner->rules())) == 0);
    CHECK(support::differing_pixels(boxes, squares) > 0);
    CHECK(runner->rules().footprint == Footprint::opacity_box); // and stays
}

static bool same_floats(std::vector<float> const& a, std::vector<float> const& b)
{
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
}

TEST_CASE("rgbx8 by reference and by value: the same bits, of colours below 0, above 1 and of none")
{
    auto gaussians = support::cloud(300, 23);
    float const odd[] = {-0.5f, -1e-3f, 7.5f, 3e38f, std::numeric_limits<float>::quiet_NaN(), 1e-40f, 254.5f / 255};
    for (std::size_t i = 0; i < gaussians.size(); i += 3) gaussians[i].colour[i % 9 / 3] = odd[i / 3 % 7];
    auto const map = support::map_of(gaussians);
    RendererOptions const options{.threads = 2, .grid = {7, 6}};
    auto const values = make_runner<support::BytesAndPlanes>(map, options), references = make_runner<Referenced<support::BytesAndPlanes>>(map, options);
    auto const paper = make_runner<support::Dropping>(map, options), paper_references = make_runner<Referenced<support::Dropping>>(map, options);
    auto const same = [](RenderedFrame const& a, RenderedFrame const& b) {
        CHECK(support::differing_pixels(a.image, b.image) == 0);
        CHECK(same_floats(a.depth.values, b.depth.values));
        CHECK(same_floats(a.alpha.values, b.alpha.values));
        for (float v : a.image.rgb) CHECK((v >= 0 && v <= 1));
        CHECK(*std::max_element(a.image.rgb.begin(), a.image.rgb.end()) == 1);
    };
    for (auto const& camera : path()) {
        if (camera.rotation[0][0] < 0) continue; // nothing there
        same(values->render(camera), references->render(camera));
        same(paper->render(camera), paper_references->render(camera));
    }
}

TEST_CASE("a grid of tiles is two numbers or a Grid")
{
    RendererOptions const numbers{.grid = {4, 2}}, grid{.grid = Grid{4, 2}};
    for (auto const& options : {numbers, grid}) {
        auto const tiling = tiling_for(options, 64, 32);
        CHECK((tiling.columns == 4 && tiling.rows == 2));
        CHECK((tiling.tile_width == 16 && tiling.tile_height == 16));
    }
}
