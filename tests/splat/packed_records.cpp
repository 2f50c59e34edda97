// test: unoptimised test asan tsan
// Tiles that store and send records of 32 and of 16 bytes: pictures, reports and ledger are those of records that were rounded before they
// were loaded; and a record that was unpacked packs to the same bits.
#include "../../bench/common/packed_record.hpp"
#include "../compare_reports.hpp"
#include "support.hpp"
#include <tilemesh/render/setup.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using support::Room;

namespace {

template <class Packed>
using Small = WithRecord<Room<>, Packed>;
template <class Packed>
using ByValue = render::FrameRenderer<PoliciesOf<Small<Packed>>, Mesh, AnyMachine>;

template <class Packed>
PackedParameters<Packed> parameters_of(std::vector<Gaussian> const& gaussians)
{
    PackedParameters<Packed> p{};
    if constexpr (std::is_same_v<Packed, Compact16>) p.box = CompactBox::of(gaussians.data(), static_cast<std::uint32_t>(gaussians.size()));
    return p;
}
bool pack(Gaussian const& g, PackedParameters<Compact32> const&, Compact32& to) { return splat::try_pack(g, to); }
bool pack(Gaussian const& g, PackedParameters<Compact16> const& p, Compact16& to) { return splat::try_pack(g, p.box, to); }

/// The records as they are after they were packed.
template <class Packed>
std::vector<Gaussian> rounded(std::vector<Gaussian> gaussians, PackedParameters<Packed> const& p)
{
    for (auto& g : gaussians) {
        Packed packed;
        REQUIRE(pack(g, p, packed));
        g = p.unpack(packed);
    }
    return gaussians;
}

/// Renders a path with records packed on tiles, and with rounded records of the map by reference whose messages have the packed bytes.
template <class Packed>
std::uint64_t same_frames(std::vector<Gaussian> const& gaussians, RendererOptions options)
{
    auto const p = parameters_of<Packed>(gaussians);
    auto const map = support::map_of(rounded(gaussians, p));
    ByValue<Packed> tiles(map, render::setup_for<Small<Packed>>(options), options, {});
    tiles.begin_with(p);
    options.threads = 1;
    auto setup = render::setup_for<Room<>>(options.sizes ? *options.sizes : Small<Packed>::sizes);
    setup.own_record_bytes = sizeof(Packed);
    render::HostRenderer floats(map, setup, options, {});
    std::uint64_t lost = 0;
    for (float const turn : {0.0f, 0.0f, 0.03f, 0.06f, -0.4f, 3.1f, 0.01f}) {
        INFO("turn ", turn);
        auto const camera = support::lens(96, 64, turn);
        auto const a = tiles.render(camera), b = floats.render(camera);
        CHECK(support::differing_pixels(a.image, b.image) == 0);
        CHECK(report::first_difference(a.report, b.report) == "");
        if (a.report.lost.empty())
            CHECK(support::differing_pixels(a.image, report::render_naive(map.gaussians, camera, tiles.rules())) == 0);
        auto const owned = support::owned_ids<PoliciesOf<Small<Packed>>>(tiles.mesh());
        CHECK(std::adjacent_find(owned.begin(), owned.end()) == owned.end());
        CHECK(owned.size() + a.report.gaussians.unplaced == gaussians.size());
        lost += a.report.lost.size();
    }
    return lost;
}
template <class Packed>
void same_frames_of_sizes()
{
    auto const gaussians = support::cloud(120, 1602);
    CHECK(same_frames<Packed>(gaussians, {.threads = 2, .tile = {11, 9}}) == 0);
    RendererOptions one{.tile = {11, 9}};
    one.sizes = support::sized<Room<>>(1, 120);
    CHECK(same_frames<Packed>(gaussians, one) == 0);
    RendererOptions full{.tile = {11, 9}};
    full.sizes = support::sized<Room<>>(8, 6);
    CHECK(same_frames<Packed>(gaussians, full) > 0);
}

template <class Packed>
void packs_again(std::vector<Gaussian> const& gaussians, std::uint32_t& otherwise)
{
    auto const p = parameters_of<Packed>(gaussians);
    otherwise = 0;
    for (auto const& g : gaussians) {
        Packed once, plain, again, thrice;
        REQUIRE(pack(g, p, once));
        auto const back = p.unpack(once);
        REQUIRE(p.try_pack(back, again));
        auto const twice = p.unpack(again);
        CHECK(std::memcmp(&twice, &back, sizeof back) == 0);
        REQUIRE(p.try_pack(twice, thrice));
        CHECK(std::memcmp(&thrice, &again, sizeof again) == 0);
        REQUIRE(pack(back, p, plain));
        auto const from_plain = p.unpack(plain);
        otherwise += std::memcmp(&from_plain, &back, sizeof back) != 0;
    }
}

} // namespace

TEST_CASE("packed records: frames are those of rounded records, with one slot in every channel, and on full tiles")
{
    same_frames_of_sizes<Compact32>();
    same_frames_of_sizes<Compact16>();
}

TEST_CASE("packed records: a record that was unpacked packs to the same bits; plain packing does not promise that")
{
    std::uint32_t otherwise = 0;
    packs_again<Compact32>(support::cloud(3000, 1603), otherwise);
    CHECK(otherwise > 0);
    packs_again<Compact16>(support::cloud(3000, 1604), otherwise);
    CHECK(otherwise > 0);
    // A record that was never rounded has no such bits.
    Compact32 to;
    CHECK_FALSE(try_pack_again(support::cloud(1, 1605)[0], to));
}

TEST_CASE("packed records: the ledger of Mk2")
{
    auto const half = render::setup_for<WithRecord<Lossless, Compact32>>(), quarter = render::setup_for<WithRecord<Lossless, Compact16>>();
    auto const whole = render::setup_for<Lossless>();
    CHECK(render::record_bytes(half) == 32);
    CHECK(render::record_bytes(quarter) == 16);
    CHECK(splat::road_bytes(half) == 36);
    CHECK(splat::road_bytes(quarter) == 20);
    CHECK(splat::beam_bytes(quarter) == 16);
    // A slot has a mark, a splat and a sort key of 76 bytes beside its record.
    CHECK(half.sizes.storage == 2000 * (60 + 76) / (32 + 76));
    CHECK(quarter.sizes.storage == 2000 * (60 + 76) / (16 + 76));
    CHECK(half.sizes.road == 200 * 64 / 36);
    CHECK(quarter.sizes.beam == 200 * 60 / 16);
    CHECK(render::sram_bytes_of(whole) == 637'316);
    CHECK(render::sram_bytes_of(half) == 637'060);
    CHECK(render::sram_bytes_of(quarter) == 637'268 + sizeof(CompactBox));
    CHECK(render::sram_bytes_of(half) <= Mk2::sram_bytes);
}

TEST_CASE("packed records: a map that was not rounded is refused before a frame")
{
    auto gaussians = support::cloud(20, 1606);
    auto const p = parameters_of<Compact16>(gaussians);
    auto map = support::map_of(rounded(gaussians, p));
    map.gaussians[7].mean_world[1] += 0.1f * p.box.mean_step;
    RendererOptions const options{.tile = {16, 16}};
    ByValue<Compact16> renderer(map, render::setup_for<Small<Compact16>>(options), options, {});
    renderer.begin_with(p);
    auto const why = tests::error_of([&] { (void)renderer.render(support::lens(96, 64)); });
    CHECK(why == "Gaussian 8 (the form that tiles store has no place for its numbers); give the renderer records that were rounded to "
                 "that form");
}
