// test: unoptimised tsan, without asan, needs data, cost 55
// The host moves references instead of records. Pictures, counters, bytes and losses are those of the machine that moves values.
#include "references.hpp"

using namespace tilemesh;
using namespace tilemesh::splat;
using support::compare, support::make_runner, support::path, support::Whole;

namespace {
scene::Map cloud(std::uint32_t n = 400, std::uint64_t seed = 21) { return support::map_of(support::cloud(n, seed)); }
} // namespace

// --- what the machine says of itself ------------------------------------------------------------------------------------------
template <class S>
constexpr bool takes_the_bytes_of_values = policy_words(setup_of<S>()).road_bytes == sizeof(RoadMessage<S>) && policy_words(setup_of<S>()).beam_bytes == sizeof(BeamMessage<S>);
static_assert(takes_the_bytes_of_values<Lossless> && takes_the_bytes_of_values<Paper> && takes_the_bytes_of_values<support::Screens> &&
                  takes_the_bytes_of_values<Fitted<Lossless, 3>>,
              "a reference takes the bytes of its record");
static_assert(sizeof(RoadMessage<Referenced<Lossless>>) == 12 && sizeof(BeamMessage<Referenced<Lossless>>) == 8);
// By reference, machine, sizes, degree, saturation, addressing, copies and colour format are values: one renderer's code serves them.
static_assert(std::is_same_v<PoliciesOf<Referenced<Lossless>>, PoliciesOf<Referenced<Fitted<support::Screens, 3>>>> &&
              std::is_same_v<PoliciesOf<Referenced<Lossless>>, PoliciesOf<Referenced<Prototype>>> &&
              std::is_same_v<PoliciesOf<Referenced<support::Planes>>, PoliciesOf<Referenced<support::DropScreens>>> &&
              std::is_same_v<PoliciesOf<Referenced<support::Planes>>, PoliciesOf<Referenced<support::ShadedScreens>>>);

TEST_CASE("references: the default renderer's ledger is that of the values")
{
    auto const values = render::ledger_of(render::setup_for<Lossless>()), ours = render::ledger_of(make_runner<Referenced<Lossless>>(support::map_of({}))->facts());
    REQUIRE(values.size() == ours.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        CHECK(std::string(values[i].name.text, values[i].name.size) == std::string(ours[i].name.text, ours[i].name.size));
        CHECK(values[i].bytes == ours[i].bytes);
    }
}

TEST_CASE("references: hold, carried, world copies: from room for all to a channel of one slot")
{
    compare<Whole>(cloud(), {.grid = {7, 6}}, path());
    compare<Whole>(cloud(), {.tile = {7, 13}, .channel_slots = 5}, path());
    auto const tight = compare<Whole>(cloud(), {.grid = {5, 9}, .channel_slots = 1, .waiting_slots = 1}, path());
    CHECK(tight.gaussians.held > 0);
    compare<Whole>(cloud(), {.grid = {1, 1}}, path());
    compare<Whole>(cloud(), {.grid = {30, 20}, .tile = {20, 16}}, path()); // most tiles are beyond the picture
}

TEST_CASE("references: the paper's drops: full channels, full storage")
{
    std::uint64_t lost = 0;
    lost += compare<support::Dropping>(cloud(500, 31), {.grid = {7, 6}, .channel_slots = 2}, path()).lost.size();
    lost += compare<support::Dropping>(cloud(500, 31), {.grid = {7, 6}, .storage_slots = 22}, path()).lost.size();
    CHECK(lost > 0);
}

TEST_CASE("references: hold with full storage: unplaced records, recalled copies, copies sent again")
{
    auto const far = [](float z, float turn) {
        auto camera = support::lens(120, 80, turn);
        camera.position[2] = z;
        return camera;
    };
    auto cameras = path();
    for (float z : {-30.0f, -30.0f, -29.0f, 0.0f, 0.0f, -10.0f, 0.5f}) cameras.push_back(far(z, 0));
    cameras.push_back(far(0, 3.1f));
    cameras.push_back(far(0, 0));
    compare<Whole>(cloud(500, 31), {.grid = {7, 6}, .storage_slots = 22}, cameras);
    compare<Whole>(cloud(500, 31), {.grid = {7, 6}, .storage_slots = 60}, cameras);
    compare<support::Screens>(cloud(500, 31), {.grid = {7, 6}, .storage_slots = 22}, cameras);
}

TEST_CASE("references: bounded hops, under way from view to view")
{
    std::vector<Camera> cameras;
    support::Random random(9);
    for (int i = 0; i < 60; ++i) {
        auto const turn = random.uniform(-0.6f, 0.6f);
        for (std::uint32_t again = random.below(4); again-- > 0;) cameras.push_back(support::lens(96, 80, turn));
    }
    for (std::uint32_t hops : {1u, 2u}) {
        auto const map = cloud(250, 41);
        compare<Whole>(map, {.grid = {6, 5}, .hops = hops}, cameras);
        compare<Whole>(map, {.grid = {6, 5}, .hops = hops, .channel_slots = 2, .waiting_slots = 2}, cameras);
        compare<Whole>(cloud(400, 47), {.grid = {6, 5}, .hops = hops, .channel_slots = 5, .storage_slots = 30}, cameras);
        compare<support::Screens>(map, {.grid = {6, 5}, .hops = hops}, cameras);
    }
}

TEST_CASE("references: another size of the frame, and a model that changes between frames")
{
    auto const map = cloud();
    RendererOptions const options{.tile = {16, 16}};
    auto const values = make_runner<Whole>(map, options), references = make_runner<Referenced<Whole>>(map, options);
    for (int i = 0; i < 6; ++i) {
        if (i == 3) values->rules().alpha_min = references->rules().alpha_min = 0.05f;
        if (i == 4) values->rules().footprint = references->rules().footprint = Footprint::three_sigma_square;
        auto const camera = i % 3 == 0 ? support::lens(96, 80) : support::lens(112, 96, 0.01f);
        auto const a = values->render(camera), b = references->render(camera);
        INFO("frame ", i);
        CHECK(support::differing_pixels(a.image, b.image) == 0);
        CHECK(report::first_difference(a.report, b.report) == "");
        CHECK(values->on_tiles() == references->on_tiles());
    }
}

TEST_CASE("references: real maps, every preset: cold start, still, orbits, teleports")
{
    for (auto const& s : support::scenes<640>()) {
        auto const& start = s.cameras.back().second;
        std::vector<Camera> cameras{start, start};
        auto const centre = scene::robust_centre(s.map);
        for (double degrees : {0.1, 0.5, 2.0})
            for (auto const& camera : scene::orbit(start, centre, degrees, 3)) cameras.push_back(camera);
        cameras.push_back(s.cameras.front().second);
        if (support::fast()) cameras.resize(4);
        compare<Lossless>(s.map, {}, cameras);
        if (support::fast()) return;
        compare<Paper>(s.map, {}, cameras);
        compare<Paper>(s.map, {.channel_slots = 10}, cameras);
    }
}

TEST_CASE("references: an existing frame is overwritten, for any content")
{
    auto const map = cloud();
    auto const renderer = make_runner<Referenced<Lossless>>(map, {.grid = {7, 6}, .arithmetic = Arithmetic::precise});
    auto const small = support::lens(112, 96), large = support::lens(140, 100, 0.2f);
    RenderedFrame frame;
    renderer->render_into(large, frame);
    frame.depth = report::Plane(3, 3);
    for (float& v : frame.image.rgb) v = 7;
    auto const* const memory = frame.image.rgb.data();
    renderer->render_into(large, frame);
    CHECK(frame.image.rgb.data() == memory);
    CHECK(frame.depth.empty());
    CHECK(support::differing_pixels(frame.image, report::render_naive(map.gaussians, large, renderer->rules())) == 0);
    renderer->render_into(small, frame);
    CHECK(support::differing_pixels(frame.image, report::render_naive(map.gaussians, small, renderer->rules())) == 0);
}
