// test: optimised, without asan tsan, needs data, cost 170
#include "runner.hpp"
#include "scenes.hpp"

// The project's strongest promise: if nothing is lost, the mesh's picture is the naive one, bit for bit.
using namespace tilemesh;
using namespace tilemesh::splat;
using support::naive, support::Scene, support::scenes;

namespace {
enum class Motion { cold, teleport, orbit };

/// Tiles of any size. Capacities are those of `lossless`, or are given when the mesh is made.
Sizes sizes_of(bool whole, bool dynamic)
{
    auto sizes = Lossless::sizes;
    sizes.storage = whole ? 40'000 : 6000;
    sizes.tile_pixels = whole ? 1u << 20 : 64 * 40;
    if (dynamic) sizes.road = sizes.beam = dynamic_capacity;
    return sizes;
}

/// Renders one combination. Returns the number of pixels that differ from the naive picture, over all compared frames.
std::uint64_t differing(Scene const& s, std::size_t camera, Extent2 tile, std::uint32_t threads, bool dynamic, bool screen,
                        Motion motion, std::uint32_t step)
{
    RendererOptions const options{.threads = threads,
                                  .tile = tile,
                                  .channel_slots = dynamic ? 37u : 0u,
                                  .arithmetic = Arithmetic::precise,
                                  .sizes = sizes_of(tile.width > 64, dynamic)};
    auto const renderer = screen ? support::make_runner<support::Screens>(s.map, options) : support::make_runner<support::Whole>(s.map, options);
    auto const& view = s.cameras[camera].second;
    std::uint64_t differ = 0;
    if (motion == Motion::orbit) {
        auto const path = scene::orbit(view, scene::robust_centre(s.map), 0.5, 20);
        for (std::uint32_t i = 0; i < path.size(); ++i) {
            auto const frame = renderer->render(path[i]);
            CHECK(frame.report.lost.empty());
            if ((i + 1) % step == 0) differ += support::differing_pixels(frame.image, naive(s, path[i]));
        }
        return differ;
    }
    if (motion == Motion::teleport) (void)renderer->render(s.cameras[(camera + 1) % s.cameras.size()].second);
    auto const frame = renderer->render(view);
    CHECK(frame.report.lost.empty());
    return support::differing_pixels(frame.image, naive(s, view));
}
constexpr Extent2 tile_sizes[] = {{16, 20}, {32, 20}, {64, 40}, {24, 24}, {7, 13}, {1280, 720}};
constexpr std::uint32_t thread_counts[] = {1, 2, 3, 7};

/// Row t of a camera's rows: camera x tile is complete; the other axes step at rates that make every pair of values occur.
struct Row {
    std::uint32_t threads;
    bool dynamic, screen;
    Motion motion;
};
Row row_of(std::uint32_t camera_of_all, std::uint32_t t)
{
    std::uint32_t const row = camera_of_all * 6 + t;
    return {(row / 2 + t) % 4, (row + camera_of_all) % 2 != 0, (row / 2 + row / 12) % 2 != 0,
            static_cast<Motion>((row + row / 6 + row / 18) % 3)};
}
} // namespace

TEST_CASE("identity: mesh and naive picture, a pairwise cover of camera, tile, threads, capacities, copies and motion")
{
    std::uint32_t camera_of_all = 0;
    for (auto const& s : scenes<640>())
        for (std::size_t camera = 0; camera < s.cameras.size(); ++camera, ++camera_of_all)
            for (std::uint32_t t = 0; t < 6; ++t) {
                if (support::fast() && (camera_of_all * 6 + t) % 12 != 2) continue;
                auto const row = row_of(camera_of_all, t);
                INFO(s.map.name, "/", s.cameras[camera].first, " tile ", tile_sizes[t].width, "x", tile_sizes[t].height, ", ",
                     thread_counts[row.threads], " threads, ", row.dynamic ? "dynamic" : "static", ", ",
                     row.screen ? "screen" : "world", ", motion ", static_cast<int>(row.motion));
                CHECK(differing(s, camera, tile_sizes[t], thread_counts[row.threads], row.dynamic, row.screen, row.motion, 10) ==
                      0);
            }
}

TEST_CASE("the cover above is pairwise complete over the real maps' eight cameras")
{
    std::set<std::array<std::uint32_t, 4>> pairs;
    for (std::uint32_t camera = 0; camera < 8; ++camera)
        for (std::uint32_t t = 0; t < 6; ++t) {
            auto const row = row_of(camera, t);
            std::uint32_t const v[] = {camera, t, row.threads, row.dynamic, row.screen, static_cast<std::uint32_t>(row.motion)};
            for (std::uint32_t a = 0; a < 6; ++a)
                for (std::uint32_t b = a + 1; b < 6; ++b) pairs.insert({a, v[a], b, v[b]});
        }
    std::uint32_t const sizes[] = {8, 6, 4, 2, 2, 3};
    std::uint32_t missing = 0;
    for (std::uint32_t a = 0; a < 6; ++a)
        for (std::uint32_t b = a + 1; b < 6; ++b)
            for (std::uint32_t i = 0; i < sizes[a]; ++i)
                for (std::uint32_t j = 0; j < sizes[b]; ++j) missing += pairs.count({a, i, b, j}) == 0 ? 1 : 0;
    CHECK(missing == 0);
}

TEST_CASE("slow: identity, the full product")
{
    for (auto const& s : scenes<640>())
        for (std::size_t camera = 0; camera < s.cameras.size(); ++camera)
            for (auto const& tile : tile_sizes)
                for (auto threads : thread_counts)
                    for (bool dynamic : {false, true})
                        for (bool screen : {false, true})
                            for (auto motion : {Motion::cold, Motion::teleport, Motion::orbit}) {
                                INFO(s.map.name, "/", s.cameras[camera].first, " tile ", tile.width, "x", tile.height, ", ",
                                     threads, " threads, ", dynamic, screen, static_cast<int>(motion));
                                CHECK(differing(s, camera, tile, threads, dynamic, screen, motion, 1) == 0);
                            }
}
