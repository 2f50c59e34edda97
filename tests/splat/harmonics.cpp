// test: without asan tsan, needs data
#include "runner.hpp"
#include "scenes.hpp"
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/scene/records.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using support::Random;

namespace {
template <std::uint32_t Degree>
ShadedGaussian<Degree> shaded(Gaussian const& g, Random& random, float size = 0.3f)
{
    ShadedGaussian<Degree> out{};
    static_cast<Gaussian&>(out) = g;
    for (float& h : out.harmonics) h = random.uniform(-size, size);
    return out;
}
bool same_bits(Splat const& a, Splat const& b)
{
    return std::memcmp(&a, &b, sizeof a) == 0;
}

/// The integral of the product of two basis functions over the sphere, by the midpoint rule in cos(theta) and phi.
double product(std::uint32_t a, std::uint32_t b)
{
    constexpr int n = 60;
    double sum = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < 2 * n; ++j) {
            double const z = -1 + (2 * i + 1.0) / n, r = std::sqrt(1 - z * z), phi = 3.14159265358979323846 * (j + 0.5) / n;
            float basis[harmonics_per_channel(3)];
            splat::detail::harmonic_basis<3>(
                {static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)), static_cast<float>(z)}, basis);
            sum += double{basis[a]} * double{basis[b]};
        }
    return sum * 4 * 3.14159265358979323846 / (2 * n * n);
}
} // namespace

TEST_CASE("harmonics: the basis is orthonormal, and its sign is that of the trained maps")
{
    for (std::uint32_t a = 0; a < 15; ++a)
        for (std::uint32_t b = 0; b <= a; ++b) {
            INFO(a, " ", b);
            CHECK(product(a, b) == doctest::Approx(a == b ? 1 : 0).epsilon(2e-3).scale(1));
        }
    float basis[15];
    splat::detail::harmonic_basis<3>({1, 0, 0}, basis);
    CHECK(basis[2] == doctest::Approx(-0.4886025)); // - sqrt(3 / 4 pi) x
    CHECK(basis[7] == doctest::Approx(0.5462742));
    CHECK(basis[14] == doctest::Approx(-0.5900436));
    splat::detail::harmonic_basis<3>({0, 1, 0}, basis);
    CHECK(basis[0] == doctest::Approx(-0.4886025));
    CHECK(basis[8] == doctest::Approx(0.5900436));
    splat::detail::harmonic_basis<3>({0, 0, 1}, basis);
    CHECK(basis[1] == doctest::Approx(0.4886025));
    CHECK(basis[5] == doctest::Approx(0.6307831));
    CHECK(basis[11] == doctest::Approx(0.7463527));
}

TEST_CASE("harmonics: the colour agrees with the definition in double, at every degree, far away and close by")
{
    Random random(7);
    auto const camera = support::lens(640, 360, 0.3f);
    auto const view = make_view(camera, Rules{});
    auto const tiling = make_tiling(640, 360, 32, 20);
    double worst = 0;
    std::uint32_t visible = 0, clamped = 0;
    auto const check = [&](auto const& g) {
        auto const s = project(g, view, tiling);
        if (!s.visible()) return;
        ++visible;
        auto const truth = report::detail::colour_seen(g, camera);
        for (std::size_t c = 0; c < 3; ++c) {
            worst = std::max(worst, std::fabs(double{s.colour[c]} - truth[c]));
            clamped += s.colour[c] == 0 ? 1 : 0;
        }
        auto base = project(static_cast<Gaussian const&>(g), view, tiling);
        std::memcpy(base.colour, s.colour, sizeof base.colour);
        CHECK(same_bits(base, s)); // only the colour differs
    };
    for (auto const& g : support::cloud(3000, 11)) {
        check(shaded<1>(g, random));
        check(shaded<2>(g, random));
        check(shaded<3>(g, random, 1.0f));
    }
    CHECK(visible > 5000);
    CHECK(clamped > 100);
    MESSAGE(visible, " visible, colour off by at most ", worst);
    CHECK(worst < 2e-6); // 16 terms of about 1, each rounded once or twice
}

TEST_CASE("harmonics: coefficients of zero change no bit; a record that is not finite is invisible, or its colour is finite")
{
    auto const camera = support::lens(640, 360);
    auto const view = make_view(camera, Rules{});
    auto const tiling = make_tiling(640, 360, 32, 20);
    for (auto const& g : support::cloud(500, 3)) {
        ShadedGaussian<3> zero{};
        static_cast<Gaussian&>(zero) = g;
        CHECK(same_bits(project(zero, view, tiling), project(g, view, tiling)));
    }
    Gaussian plain = support::ball(1, 0, 0, 1.0f);
    plain.mean_world[2] = 5;
    for (float bad : {HUGE_VALF, -HUGE_VALF, std::nanf(""), 3e38f, -3e38f, 1e-45f})
        for (int i = 0; i < 45; ++i) {
            ShadedGaussian<3> g{};
            static_cast<Gaussian&>(g) = plain;
            g.harmonics[i] = bad;
            auto const s = project(g, view, tiling);
            if (!s.visible()) continue;
            for (float c : s.colour) CHECK((c >= 0 && c <= largest_colour));
        }
    // A mean so far away that no float holds its square.
    ShadedGaussian<1> far{};
    static_cast<Gaussian&>(far) = plain;
    far.mean_world[2] = 1e30f;
    for (float& s : far.log_scale) s = 66;
    far.harmonics[3] = 1; // red of z
    auto const s = project(far, view, tiling);
    REQUIRE(s.visible());
    CHECK(s.colour[0] == doctest::Approx(far.colour[0] + 0.4886025));
}

TEST_CASE("harmonics on the mesh: bit-equal to the naive picture over tilings, copies and motion; at least 90 dB against double")
{
    Random random(5);
    scene::Map map = support::map_of(support::cloud(700, 21));
    map.sh_degree = 2;
    for (std::size_t i = 0; i < 24 * map.gaussians.size(); ++i) map.harmonics.push_back(random.uniform(-0.4f, 0.4f));
    auto const gaussians = scene::records<ShadedGaussian<2>>(map);
    auto const check = [&](std::unique_ptr<support::Runner> const& runner) {
        for (float turn : {0.0f, 0.02f, 0.5f, 0.0f}) {
            auto const camera = support::lens(200, 120, turn);
            auto const frame = runner->render(camera);
            CHECK(frame.report.lost.empty());
            CHECK(support::differing_pixels(frame.image, report::render_naive(gaussians, camera, Rules{})) == 0);
            auto const error =
                report::compare(frame.image, report::render_double(gaussians, camera, Rules{}, report::Cuts::same));
            CHECK(error.psnr_db > 90);
        }
    };
    auto const sizes = support::sized<support::Whole>(20, 700);
    using World = Fitted<support::Whole, 2>;
    using Screen = Fitted<support::Screens, 2>;
    check(support::make_runner<World>(map, {.threads = 2, .tile = {32, 20}, .sizes = sizes}));
    check(support::make_runner<World>(map, {.tile = {13, 7}, .sizes = sizes}));
    check(support::make_runner<Referenced<World>>(map, {.tile = {16, 9}, .sizes = sizes}));
    check(support::make_runner<Referenced<Screen>>(map, {.tile = {20, 30}, .sizes = sizes}));

    // A setup of degree 0 refuses the map.
    CHECK_THROWS_WITH_AS(scene::records<Gaussian>(map),
                         "a map with view-dependent colour of degree 2 (the setup's records hold degree 0); render it with "
                         "fit_renderer or a Fitted<Lossless, 2> setup, or give up the rest with scene::at_degree",
                         Error);
}

TEST_CASE("harmonics on Mk2: fruit_drops of degree 3 and playbot of degree 2 have at least 90 dB against double with the same cut-offs")
{
    auto const folder = support::data();
    if (folder.empty()) {
        MESSAGE("skipped: no real maps (TILEMESH_DATA)");
        return;
    }
    for (auto const& [file, degree] : {std::pair("fruit_drops_sh3.ply", 3u), std::pair("playbot_31k_sh2.ply", 2u)}) {
        auto const map = scene::load_ply(folder / "maps" / file);
        REQUIRE(map.sh_degree == degree);
        auto const first = support::fast() ? scene::frame_whole(map, {640, 360}) : scene::frame_whole(map, {1280, 720});
        auto const renderer =
            support::fit_shared<Fitted<Lossless, 2>, Fitted<Lossless, 3>>(map, scene::demand_of(map), {.threads = 2});
        REQUIRE(renderer);
        CHECK(renderer->setup().sh_degree == degree);
        for (auto const& camera : scene::orbit(first, scene::robust_centre(map), 4, support::fast() ? 1 : 2)) {
            auto const frame = renderer->render(camera);
            CHECK(frame.report.lost.empty());
            auto const truth = [&]<class Record>(Record) {
                auto const records = scene::records<Record>(map);
                return report::compare(frame.image, report::render_double(records, camera, Rules{}, report::Cuts::same, 2));
            };
            auto const error = degree == 2 ? truth(ShadedGaussian<2>{}) : truth(ShadedGaussian<3>{});
            auto const flat = report::compare(
                frame.image, report::render_double(scene::at_degree(map, 0).gaussians, camera, Rules{}, report::Cuts::same, 2));
            MESSAGE(std::string(file), ": ", error.psnr_db, " dB; without the dependence on the view it would be ", flat.psnr_db, " dB");
            CHECK(error.psnr_db >= 90);
            CHECK(flat.psnr_db < 50);
        }
    }
}
