// Maps in parts: each rank has its part of the rows, and results are those of the whole map.
#include "../splat/runner.hpp"
#include "same_frame.hpp"
#include "short_of_memory.hpp"
#include <tilemesh/render/ranks/host.hpp>
#include <tilemesh/render/ranks/row_shares.hpp>
#include <tilemesh/render/ranks/row_weights.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/ply.hpp>

using namespace mpi_test;
using support::Whole;

namespace {

/// The part of a map that this rank has. `weights`: the share of each rank, in any unit; the list begins again after its last item.
scene::Map part_of(scene::Map const& map, std::vector<std::uint32_t> const& weights)
{
    std::uint64_t before = 0, all = 0;
    for (std::uint32_t r = 0; r < ranks(); ++r) {
        before += r < rank() ? weights[r % weights.size()] : 0;
        all += weights[r % weights.size()];
    }
    auto const at = [&](std::uint64_t weight) {
        return map.gaussians.begin() + static_cast<std::ptrdiff_t>(render::RowShares::part_of(map.gaussians.size(), weight, all));
    };
    auto part = map;
    part.gaussians.assign(at(before), at(before + weights[rank() % weights.size()]));
    return part;
}
/// A binary PLY of a 3DGS map with n rows. Row 3, and every seventh row from there, is not finite.
std::string ply(std::uint32_t n)
{
    std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(n) + "\n";
    for (auto const* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
        text += std::string("property float ") + name + "\n";
    text += "end_header\n";
    auto const number = [&](float v) { text.append(reinterpret_cast<char const*>(&v), 4); };
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t k = 0; k < 14; ++k) number(i % 7 == 2 && k == 5 ? std::numeric_limits<float>::infinity() : static_cast<float>(i) * 0.1f + static_cast<float>(k) + 1);
    return text;
}
/// Counts the bytes that are read from a file of memory.
struct CountedFile : std::stringbuf {
    std::uint64_t bytes = 0;
    explicit CountedFile(std::string const& text) : std::stringbuf(text) {}
    std::streamsize xsgetn(char* to, std::streamsize n) override
    {
        auto const got = std::stringbuf::xsgetn(to, n);
        bytes += static_cast<std::uint64_t>(got);
        return got;
    }
};

} // namespace

TEST_CASE("a map in parts, also empty ones: pictures, reports and losses are those of the whole map")
{
    std::vector<splat::Camera> path;
    for (float turn : {0.0f, 0.0f, 0.0017f, -0.4f}) path.push_back(support::lens(120, 80, turn));
    auto const map = support::map_of(support::cloud(500, 31));
    for (std::uint32_t const slots : {0u, 22u, 60u}) {
        CAPTURE(slots);
        RendererOptions options{.grid = {7, 6}, .storage_slots = slots, .digest = true};
        BasicRenderer<Whole, Mesh> one{map, options};
        options.rows_of_all_parts = static_cast<std::uint32_t>(map.gaussians.size());
        BasicRenderer<Whole, MpiMesh> equal{part_of(map, {1}), options}, uneven{part_of(map, {ranks() == 1 ? 1u : 0u, 5, 1}), options};
        for (auto const& camera : path) {
            auto const wanted = one.render(camera);
            for (auto* renderer : {&equal, &uneven}) check_same_frame(renderer->render(camera), wanted);
            CHECK((slots == 22) == !wanted.report.lost.empty());
        }
    }
}

TEST_CASE("a renderer chooses bands of equal work, of a whole map and of parts; the results are those of one process")
{
    auto gaussians = support::cloud(600, 12);
    for (auto& g : gaussians) g.mean_world[1] = 0.45f * g.mean_world[2] + 0.1f * g.mean_world[1]; // below the middle of the picture
    auto const map = support::map_of(std::move(gaussians));
    auto const first = support::lens(96, 96), turned = support::lens(96, 96, 0.3f);
    RendererOptions options{.grid = {6, 12}, .digest = true};
    BasicRenderer<Whole, Mesh> one{map, options};
    RenderedFrame const wanted[] = {one.render(first), one.render(turned)};
    BasicRenderer<Whole, MpiMesh> whole{map, options};
    options.rows_of_all_parts = 600;
    BasicRenderer<Whole, MpiMesh> parts{part_of(map, {3, 1}), options};
    for (auto* renderer : {&whole, &parts}) {
        check_same_frame(renderer->render(first), wanted[0]);
        check_same_frame(renderer->render(turned), wanted[1]);
        render::RowWeights work(renderer->tiling(), 12);
        work.add_tiles();
        for (auto const& g : map.gaussians) work.add(splat::project(g, splat::make_view(first, renderer->rules()), renderer->tiling()));
        auto const& bands = renderer->mesh().bands();
        mpi::Bands const best(12, ranks(), work.weights()), equal(12, ranks());
        bool other = false;
        for (std::uint32_t r = 0; r < ranks(); ++r) {
            CHECK(bands.first(r) == best.first(r));
            CHECK(bands.last(r) == best.last(r));
            other = other || bands.last(r) != equal.last(r);
        }
        CHECK(other == (ranks() > 1));
    }
    options.rows_of_all_parts = 0;
    BasicRenderer<Whole, MpiMesh> own{map, options, MpiMeshOptions{.row_weights = std::vector<std::uint32_t>(12, 1)}}; // the user's weights
    own.render(first);
    CHECK(own.mesh().bands().last(0) == mpi::Bands(12, ranks(), std::vector<std::uint32_t>(12, 1)).last(0));
}

TEST_CASE("one rank out of memory, at each allocation of a frame in turn: every rank gets an Error, and the next frame is whole")
{
    auto const map = support::map_of(support::cloud(120, 31));
    auto const first = support::lens(60, 40), second = support::lens(60, 40, 0.2f);
    RendererOptions options{.grid = {3, 4}, .storage_slots = 17, .digest = true}; // full tiles: lists of losses, a second run of a frame
    BasicRenderer<Whole, Mesh> one{map, options};
    std::vector<RenderedFrame> wanted;
    for (auto const& camera : {first, second, second}) wanted.push_back(one.render(camera));
    CHECK_FALSE(wanted.front().report.lost.empty());
    using OnRanks = BasicRenderer<Whole, MpiMesh>;
    for (bool const in_parts : {false, true}) {
        CAPTURE(in_parts);
        auto const mine = in_parts ? part_of(map, {1}) : map;
        if (in_parts) options.rows_of_all_parts = 120;
        each_allocation_fails([&] { return std::make_unique<OnRanks>(mine, options); }, [&](OnRanks& renderer) { renderer.render(first); },
                              [&](OnRanks& renderer, bool failed) {
                                  if (failed) check_same_frame(renderer.render(first), wanted[0]);
                                  check_same_frame(renderer.render(second), wanted[1]);
                              });
    }
    each_allocation_fails(
        [&] {
            auto renderer = std::make_unique<OnRanks>(part_of(map, {1}), options);
            renderer->render(first);
            return renderer;
        },
        [&](OnRanks& renderer) { renderer.render(second); },
        [&](OnRanks& renderer, bool failed) {
            if (failed) check_same_frame(renderer.render(first), wanted[0]);
            check_same_frame(renderer.render(second), wanted[failed ? 1 : 2]);
        });
}

TEST_CASE("parts that are not those of one map are refused on all ranks")
{
    auto const map = support::map_of(support::cloud(100, 3));
    RendererOptions options{.grid = {7, 6}};
    options.rows_of_all_parts = 101;
    BasicRenderer<Whole, MpiMesh> other{part_of(map, {1}), options};
    CHECK(has(error_of([&] { other.render(support::lens(120, 80)); }), "parts of a map with 100 rows (the options say 101)"));
    if (ranks() > 1) {
        auto part = part_of(map, {1});
        if (rank() + 1 == ranks()) part.gaussians.back().id = splat::GaussianId{1}; // the first row's
        options.rows_of_all_parts = 100;
        BasicRenderer<Whole, MpiMesh> twice{part, options};
        CHECK(error_of([&] { twice.render(support::lens(120, 80)); }) ==
              "two Gaussians with id 1, or an id of 0 (a record is known by its id); number them from 1");
    }
    options.rows_of_all_parts = 100;
    CHECK(has(error_of([&] { BasicRenderer<Whole, Mesh>{map, options}; }), "a part of a map on an engine of one process"));
}

TEST_CASE("a rank reads its rows of a PLY: the header, its share, and no more")
{
    std::uint32_t const n = 100000; // 5.6 MB
    auto const text = ply(n);
    std::istringstream whole(text);
    auto const wanted = scene::read_ply(whole, "many.ply");
    CountedFile file(text);
    std::istream stream(&file);
    auto part = scene::read_ply_part(stream, "many.ply", rank(), ranks());
    REQUIRE(part);
    CHECK(file.bytes <= std::uint64_t{n} / ranks() * 56 + (2u << 20)); // it reads 1 MiB at a time: the header, then the rows
    if (ranks() > 1) CHECK(file.bytes < text.size());

    mpi::detail::Ranks const all(MPI_COMM_WORLD);
    std::uint64_t rejected = part->map.rejected;
    all.sum(&rejected, 1);
    CHECK(rejected == wanted.rejected);
    auto gaussians = part->map.gaussians;
    all.join(gaussians);
    if (rank() != 0) return;
    part->map.rejected = rejected;
    auto const joined = scene::with_all_notes(std::move(*part));
    CHECK(joined.notes == wanted.notes); // the first five rejected rows are of the first part
    REQUIRE(gaussians.size() == wanted.gaussians.size());
    CHECK(std::memcmp(gaussians.data(), wanted.gaussians.data(), gaussians.size() * sizeof(splat::Gaussian)) == 0);
}

TEST_CASE("the demand of a map in parts is that of the whole map")
{
    auto map = support::map_of(support::cloud(700, 9));
    map.gaussians[5].opacity = 0.999f;
    map.gaussians[650].opacity = 0.001f;
    std::vector<splat::Camera> path;
    for (float turn : {0.0f, 0.3f, 3.1f}) path.push_back(support::lens(120, 80, turn));
    auto const tiling_of = [](splat::Camera const& c) { return tiling_for(RendererOptions{.grid = {7, 6}}, c.width, c.height); };
    mpi::detail::Ranks const all(MPI_COMM_WORLD);
    for (std::size_t const views : {std::size_t{0}, std::size_t{1}, std::size_t{3}}) {
        CAPTURE(views);
        auto const some = std::span<splat::Camera const>(path).first(views);
        auto const wanted = scene::demand_of(map, some, {}, tiling_of);
        auto const d = scene::demand_of(part_of(map, {2, 1}), some, {}, tiling_of, all);
        CHECK(d.gaussians == wanted.gaussians);
        CHECK(d.least_opacity == wanted.least_opacity);
        CHECK(d.greatest_opacity == wanted.greatest_opacity);
        CHECK(d.nearly_opaque == wanted.nearly_opaque);
        CHECK(d.too_faint == wanted.too_faint);
        CHECK(d.culled == wanted.culled);
        CHECK(d.footprint_columns == wanted.footprint_columns);
        CHECK(d.footprint_rows == wanted.footprint_rows);
        CHECK(d.spans == wanted.spans);
        CHECK(d.scanned == wanted.scanned);
        if (rank() == 0) CHECK(d.ties == wanted.ties);
    }
}
