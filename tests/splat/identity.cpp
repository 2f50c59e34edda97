#include "scenes.hpp"
#include <array>

// The project's strongest promise: with nothing lost, the mesh's picture is the naive one, bit for bit.
using namespace tilemesh;
using namespace tilemesh::splat;
using support::naive;
using support::Scene;
using support::scenes;

namespace {
enum class Motion { cold, teleport, orbit };

struct ScreenBase : Lossless {
    using Copies = ScreenCopies;
};
/// Tiles up to 64 x 40 on any number of tiles; capacities as in lossless, or dynamic.
template <class Base, bool Dynamic>
struct Tiles : Base {
    using Machine = TestMachine<8u << 20>;
    static constexpr std::uint32_t storage_slots = 6000;
    static constexpr std::uint32_t tile_pixels = 64 * 40;
    static constexpr std::uint32_t road_bytes = Dynamic ? dynamic_capacity : Base::road_bytes;
    static constexpr std::uint32_t beam_bytes = Dynamic ? dynamic_capacity : Base::beam_bytes;
};
template <class Base, bool Dynamic>
struct Whole : Tiles<Base, Dynamic> {
    using Machine = typename Roomy<Base>::Machine;
    static constexpr std::uint32_t storage_slots = 40'000;
    static constexpr std::uint32_t tile_pixels = 1u << 20;
};

/// Renders one combination; the number of pixels that differ from the naive picture, over all compared frames.
template <class S>
std::uint64_t differing(Scene const& s, std::size_t camera, Extent2 tile, std::uint32_t threads, Motion motion, std::uint32_t step)
{
    RendererOptions options{.threads = threads, .tile = tile};
    if (S::road_bytes == dynamic_capacity) options.channel_slots = 37;
    BasicRenderer<S> renderer{s.map, options};
    auto const& view = s.cameras[camera].second;
    std::uint64_t differ = 0;
    if (motion == Motion::orbit) {
        auto const path = scene::orbit(view, scene::robust_centre(s.map), 0.5, 20);
        for (std::uint32_t i = 0; i < path.size(); ++i) {
            auto const frame = renderer.render(path[i]);
            CHECK(frame.report.lost.empty());
            if ((i + 1) % step == 0) differ += support::differing_pixels(frame.image, naive(s, path[i]));
        }
        return differ;
    }
    if (motion == Motion::teleport) (void)renderer.render(s.cameras[(camera + 1) % s.cameras.size()].second);
    auto const frame = renderer.render(view);
    CHECK(frame.report.lost.empty());
    return support::differing_pixels(frame.image, naive(s, view));
}
std::uint64_t differing(Scene const& s, std::size_t camera, Extent2 tile, std::uint32_t threads, bool dynamic, bool screen,
                        Motion motion, std::uint32_t step)
{
    bool const whole = tile.width > 64;
    if (whole && dynamic && screen) return differing<Whole<ScreenBase, true>>(s, camera, tile, threads, motion, step);
    if (whole && dynamic) return differing<Whole<Lossless, true>>(s, camera, tile, threads, motion, step);
    if (whole && screen) return differing<Whole<ScreenBase, false>>(s, camera, tile, threads, motion, step);
    if (whole) return differing<Whole<Lossless, false>>(s, camera, tile, threads, motion, step);
    if (dynamic && screen) return differing<Tiles<ScreenBase, true>>(s, camera, tile, threads, motion, step);
    if (dynamic) return differing<Tiles<Lossless, true>>(s, camera, tile, threads, motion, step);
    if (screen) return differing<Tiles<ScreenBase, false>>(s, camera, tile, threads, motion, step);
    return differing<Tiles<Lossless, false>>(s, camera, tile, threads, motion, step);
}
constexpr Extent2 tile_sizes[] = {{16, 20}, {32, 20}, {64, 40}, {24, 24}, {7, 13}, {1280, 720}};
constexpr std::uint32_t thread_counts[] = {1, 2, 3, 7};
} // namespace

TEST_CASE("identity: mesh and naive picture, a pairwise cover of camera, tile, threads, capacities, copies and motion")
{
    std::uint32_t row = 0;
    for (auto const& s : scenes())
        for (std::size_t camera = 0; camera < s.cameras.size(); ++camera)
            for (std::uint32_t t = 0; t < 6; ++t, ++row) {
                if (support::fast() && row % 8 != 2) continue;
                // camera x tile is complete; the other axes step at rates that make every pair of values meet.
                auto const threads = thread_counts[(row / 2 + t) % 4];
                bool const dynamic = (row + camera) % 2 != 0, screen = (row / 2 + row / 12) % 2 != 0;
                auto const motion = static_cast<Motion>((row + row / 6 + row / 18) % 3);
                auto const n = differing(s, camera, tile_sizes[t], threads, dynamic, screen, motion, 10);
                INFO(s.map.name, "/", s.cameras[camera].first, " tile ", tile_sizes[t].width, "x", tile_sizes[t].height, ", ",
                     threads, " threads, ", dynamic ? "dynamic" : "static", ", ", screen ? "screen" : "world", ", motion ",
                     static_cast<int>(motion));
                CHECK(n == 0);
            }
}

TEST_CASE("the cover above is pairwise complete")
{
    // Values per axis: tile 6, threads 4, dynamic 2, screen 2, motion 3, over 2 scenes x 4 cameras.
    std::set<std::array<std::uint32_t, 4>> pairs;
    std::uint32_t row = 0;
    for (std::uint32_t scene = 0; scene < 2; ++scene)
        for (std::uint32_t camera = 0; camera < 4; ++camera)
            for (std::uint32_t t = 0; t < 6; ++t, ++row) {
                std::uint32_t const v[] = {scene * 4 + camera, t, (row / 2 + t) % 4, (row + camera) % 2, (row / 2 + row / 12) % 2,
                                           (row + row / 6 + row / 18) % 3};
                for (std::uint32_t a = 0; a < 6; ++a)
                    for (std::uint32_t b = a + 1; b < 6; ++b) pairs.insert({a, v[a], b, v[b]});
            }
    std::uint32_t const sizes[] = {8, 6, 4, 2, 2, 3};
    std::uint32_t missing = 0;
    for (std::uint32_t a = 0; a < 6; ++a)
        for (std::uint32_t b = a + 1; b < 6; ++b)
            for (std::uint32_t i = 0; i < sizes[a]; ++i)
                for (std::uint32_t j = 0; j < sizes[b]; ++j)
                    if (pairs.count({a, i, b, j}) == 0) {
                        ++missing;
                        MESSAGE("axis ", a, " value ", i, " never meets axis ", b, " value ", j);
                    }
    CHECK(missing == 0);
}

TEST_CASE("slow: identity, the full product")
{
    for (auto const& s : scenes())
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
