// test: unoptimised test asan
// The knobs of bench/error_vs_time: how a record is stored and cut, how splats are ordered, the list of settings and their cut-offs; and
// that the parts of a setting's error are measured against the right pictures.
#include "../standard.hpp"

// The bench is a program: its sources are compiled here.
#include <error_vs_time/measure.cpp>
#include <error_vs_time/settings.cpp>
#include <error_vs_time/with_knobs.cpp>
#include <error_vs_time/whole_frame.cpp>
#include <tilemesh/splat/quality.hpp>
#include <tilemesh/splat/setup_types.hpp>

using namespace error_vs_time;

namespace {

/// Shows the whole frame; one number of it is changed if channels drop.
class PretendedMachine final : public Machine {
public:
    PretendedMachine(scene::Map const& map, Setting const& setting)
        : gaussians_(tilemesh::scene::records<splat::Gaussian>(map)), setting_(setting)
    {
        if (setting.limits.storage_slots == 10) throw tilemesh::Error("too small (10 slots); choose more");
    }
    void settle(splat::Camera const& first, splat::Camera const&) override { render(first); }
    void render(splat::Camera const& camera) override
    {
        image_ = whole_frame(gaussians_, camera, setting_.rules, setting_.knobs);
        report_ = {};
        report_.pairs = 1000;
        if (!setting_.limits.drop) return;
        image_.rgb[4] += change;
        report_.lost = {{tilemesh::splat::GaussianId{1}, 0, report::Cause::storage_full}};
    }
    report::Image const& image() const override { return image_; }
    report::FrameReport const& counters() const override { return report_; }
    double modelled_ms() override { return 2; }
    double host_ms() const override { return 3; }

    static constexpr float change = 0.5f;

private:
    std::vector<splat::Gaussian> gaussians_;
    Setting setting_;
    report::Image image_;
    report::FrameReport report_;
};

} // namespace

std::unique_ptr<Machine> error_vs_time::make_machine(scene::Map const& map, Setting const& setting, std::uint32_t)
{
    return std::make_unique<PretendedMachine>(map, setting);
}
std::vector<splat::Camera> bench::cameras_of(std::string const&, Scene const& scene, std::uint32_t frames, std::filesystem::path const&)
{
    std::vector<splat::Camera> all(1 + frames, scene.camera);
    for (std::size_t i = 0; i < all.size(); ++i) all[i].position[0] += 0.01f * static_cast<float>(i);
    return all;
}

namespace {

constexpr std::uint32_t width = 96, height = 64;

/// Looks along z; the principal point is between pixels.
splat::Camera camera_of()
{
    return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}, 60, 60, 0.5f * width + 0.25f, 0.5f * height, 0.2f, width, height};
}
/// A number in [0, 1) that follows from n alone (Weyl's sequence of the golden ratio).
double weyl(std::uint32_t n)
{
    double const v = 0.6180339887498949 * (n + 1);
    return v - std::floor(v);
}
std::vector<splat::Gaussian> cloud(std::uint32_t n)
{
    std::vector<splat::Gaussian> all;
    for (std::uint32_t i = 0; i < n; ++i) {
        splat::Gaussian g{};
        auto const at = [&](std::uint32_t k, double low, double high) { return static_cast<float>(low + (high - low) * weyl(17 * i + 7919 * k)); };
        g.mean_world[2] = at(1, 1, 4);
        g.mean_world[0] = at(2, -0.9, 0.9) * g.mean_world[2];
        g.mean_world[1] = at(3, -0.6, 0.6) * g.mean_world[2];
        for (std::uint32_t c = 0; c < 3; ++c) g.colour[c] = at(4 + c, 0, 1);
        for (std::uint32_t c = 0; c < 4; ++c) g.rotation[c] = at(7 + c, -1, 1);
        for (std::uint32_t c = 0; c < 3; ++c) g.log_scale[c] = at(11 + c, -5, -1.5);
        g.opacity = at(14, 0.01, 1);
        g.id = splat::GaussianId{i + 1};
        all.push_back(g);
    }
    return all;
}
splat::Splat splat_with(float along, float slope, float across)
{
    splat::Splat s{};
    s.along = along, s.slope = slope, s.across = across;
    s.opacity = 0.9f;
    s.depth_key = splat::key_of_depth(1);
    s.columns = 0u | 40u << 16;
    s.rows = 0u | 30u << 16;
    s.mean_px[0] = s.mean_px[1] = 0;
    return s;
}
splat::Splat stored(splat::Splat s, Shape shape)
{
    Knobs knobs;
    knobs.shape = shape;
    REQUIRE(s.visible());
    apply(knobs, splat::make_view(camera_of(), {}), splat::make_tiling(width, height, 32, 20), s);
    return s;
}
/// -2 along is first^2, -2 across is second^2.
splat::Splat of_factor(float first, float slope, float second)
{
    return splat_with(-0.5f * first * first, slope, -0.5f * second * second);
}
/// The factor's first number as half precision has it, from one that squares exactly.
float first_of(float first)
{
    auto const s = stored(of_factor(first, 0, 1), Shape::half_factor);
    return std::sqrt(-2 * s.along);
}
float slope_of(float slope)
{
    return stored(of_factor(1, slope, 1), Shape::half_factor).slope;
}
Setting setting_of(std::string const& name)
{
    for (auto const& s : settings())
        if (s.name == name) return s;
    FAIL("no setting ", name);
    return {};
}
bool same_rules(splat::Rules const& a, splat::Rules const& b)
{
    return a.alpha_min == b.alpha_min && a.alpha_max == b.alpha_max && a.transmittance_min == b.transmittance_min &&
           a.dilation == b.dilation && a.jacobian_limit == b.jacobian_limit && a.footprint == b.footprint &&
           a.arithmetic == b.arithmetic;
}

} // namespace

TEST_CASE("half precision: ties to even, subnormals, the largest")
{
    constexpr float step = 0x1p-10f; // from 1 on: eleven bits
    for (auto const& each : {std::pair(1 + step, 1 + step),
                             {1 + step / 2, 1.0f}, // a tie, to the even
                             {1 + 3 * step / 2, 1 + 2 * step},
                             {1 + step / 2 + 0x1p-20f, 1 + step},
                             {-(1 + 3 * step / 2), -(1 + 2 * step)},
                             {2 - step / 4, 2.0f}, // up into the next power
                             {2049.0f, 2048.0f},
                             {2051.0f, 2052.0f},
                             {0.0f, 0.0f},
                             {0x1p-14f, 0x1p-14f}, // subnormal below that, steps of 2^-24
                             {0x1p-14f - 0x1p-24f, 0x1p-14f - 0x1p-24f},
                             {0x1p-14f - 0x1p-25f, 0x1p-14f},
                             {3 * 0x1p-25f, 0x1p-23f},
                             {0x1p-25f, 0.0f},
                             {0x1.8p-25f, 0x1p-24f},
                             {65504.0f, 65504.0f}, // the largest; beyond it there is no infinity
                             {65519.0f, 65504.0f},
                             {65536.0f, 65504.0f},
                             {-1e30f, -65504.0f}})
        CHECK_MESSAGE(slope_of(each.first) == each.second, each.first); // the slope is stored as it is
    // The factor's other two numbers are squared.
    CHECK(first_of(0.375f) == 0.375f);
    CHECK(first_of(1 + step / 2) == 1.0f);
    CHECK(first_of(1 + 3 * step / 2) == 1 + 2 * step);
    auto const second = stored(of_factor(1, 0, 1 + 3 * step / 2), Shape::half_factor);
    CHECK(std::sqrt(-2 * second.across) == 1 + 2 * step);
}

TEST_CASE("half precision: what halves can hold is not changed, in either shape")
{
    for (auto const shape : {Shape::half_factor, Shape::half_conic}) {
        auto const s = stored(of_factor(0.5f, 0.25f, 2.0f), shape); // conic: yy 4, xy -1, xx 0.5
        CHECK(s.along == -0.125f);
        CHECK(s.slope == 0.25f);
        CHECK(s.across == -2.0f);
        CHECK(s.columns == (40u << 16));
        CHECK(s.rows == (30u << 16));
        CHECK(s.opacity == 0.9f);
    }
    // Shapes in 32-bit floats do not change.
    auto const odd = of_factor(0.3f, 1.1f, 0.7f), same = stored(odd, Shape::float32);
    CHECK(same.along == odd.along);
    CHECK(same.slope == odd.slope);
    CHECK(same.across == odd.across);
}

TEST_CASE("half conic: rounds xx, xy and yy, and gives back a form of the three")
{
    // yy = 1 + 2^-11 is a tie to 1; xy = -slope yy; xx = 0.25 + slope^2 yy.
    auto const s = stored(splat_with(-0.125f, 0.5f, -0.5f * (1.0f + 0x1p-11f)), Shape::half_conic);
    CHECK(s.across == -0.5f);
    CHECK(s.slope == 0.5f); // xy = -0.5 (1 + 2^-11), a tie to -0.5
    CHECK(s.along == -0.125f); // xx = 0.5 + 2^-13, to 0.5
}

TEST_CASE("half conic: a needle whose rounded form is not definite stays finite and never brightens")
{
    std::uint32_t indefinite = 0;
    for (std::uint32_t i = 0; i < 400; ++i) {
        auto const long_sigma = static_cast<float>(std::exp(8 * weyl(3 * i)));
        auto const slope = static_cast<float>(40 * weyl(3 * i + 1) - 20);
        auto const given = splat_with(-0.5f / (long_sigma * long_sigma), slope, static_cast<float>(-1.6 * weyl(3 * i + 2)));
        for (auto const shape : {Shape::half_conic, Shape::half_factor}) {
            auto const s = stored(given, shape);
            REQUIRE(std::isfinite(s.along));
            REQUIRE(std::isfinite(s.slope));
            REQUIRE(std::isfinite(s.across));
            CHECK(s.along <= 0.0f);
            CHECK(s.across <= 0.0f);
            if (shape == Shape::half_conic && s.along == 0.0f) ++indefinite;
            for (int y = -20; y <= 20; y += 5)
                for (int x = -20; x <= 20; x += 5) {
                    float const alpha = splat::alpha_at(s, static_cast<float>(x), static_cast<float>(y));
                    CHECK(alpha <= s.opacity);
                    CHECK(alpha >= 0.0f);
                }
        }
    }
    CHECK(indefinite > 20); // of the conic that does happen
    auto const none = stored(splat_with(-0x1p-26f, 3.0f, -0x1p-28f), Shape::half_conic); // all below half's least
    CHECK(none.across == 0.0f);
    CHECK(none.slope == 0.0f);
    CHECK(none.along <= 0.0f);
}

TEST_CASE("a cut in standard deviations is the rectangle of long double, within what was there")
{
    auto const camera = camera_of();
    auto const tiling = splat::make_tiling(width, height, 32, 20);
    splat::Rules rules;
    rules.alpha_min = 1e-12f;
    auto const view = splat::make_view(camera, rules);
    std::uint32_t cut = 0, gone = 0, seen = 0;
    for (auto const& g : cloud(1500)) {
        auto const given = splat::project(g, view, tiling);
        if (!given.visible()) continue;
        ++seen;
        for (float const reach_sigmas : {0.05f, 0.5f, 2.0f, 3.33f, 7.0f}) {
            Knobs knobs;
            knobs.sigmas = reach_sigmas;
            auto s = given;
            apply(knobs, view, tiling, s);
            // The covariance of along dx^2 + across (dy - slope dx)^2, inverted.
            long double const xx = -2.0L * (given.along + 1.0L * given.slope * given.slope * given.across);
            long double const xy = 2.0L * given.slope * given.across, yy = -2.0L * given.across, determinant = xx * yy - xy * xy;
            auto const expected = [&](std::uint32_t span, long double centre, long double variance) {
                long double const reach = static_cast<long double>(reach_sigmas) * std::sqrt(variance);
                auto const first = std::max<long double>(span & 0xffffu, std::floor(centre - reach));
                auto const end = std::min<long double>(span >> 16, std::floor(centre + reach) + 1);
                return first < end ? static_cast<std::uint32_t>(first) | static_cast<std::uint32_t>(end) << 16 : 0u;
            };
            long double const u = 1.0L * given.mean_px[0] + camera.cx, v = 1.0L * given.mean_px[1] + camera.cy;
            auto const columns = expected(given.columns, u, yy / determinant), rows = expected(given.rows, v, xx / determinant);
            if (columns == 0 || rows == 0) {
                CHECK(!s.visible());
                ++gone;
                continue;
            }
            REQUIRE(s.visible());
            CHECK(s.columns == columns);
            CHECK(s.rows == rows);
            cut += s.columns != given.columns || s.rows != given.rows ? 1u : 0u;
            auto const r = s.rect(), before = given.rect();
            CHECK((r.x0 >= before.x0 && r.x1 <= before.x1 && r.y0 >= before.y0 && r.y1 <= before.y1));
            // The anchor: the tile of the mean's pixel, moved into the rectangle.
            auto const x = std::clamp<long double>(std::floor(u), r.x0, r.x1 - 1.0L);
            auto const y = std::clamp<long double>(std::floor(v), r.y0, r.y1 - 1.0L);
            CHECK(s.anchor == tilemesh::TileId::at(static_cast<std::uint32_t>(x) / 32, static_cast<std::uint32_t>(y) / 20));
            CHECK(splat::covers(s, tiling, s.anchor));
        }
    }
    CHECK(seen > 500);
    CHECK(cut > 500);
    CHECK(gone > 20); // the mean is outside the frame
}

TEST_CASE("a cut in standard deviations of a round splat ends where it should")
{
    auto const view = splat::make_view(camera_of(), {});
    auto const tiling = splat::make_tiling(width, height, 32, 20);
    Knobs knobs;
    knobs.sigmas = 2;
    auto const from_column = [&](std::uint32_t first) {
        auto s = splat_with(-0.125f, 0, -0.125f); // sigma 2, so 4 pixels around (48.25, 32)
        s.columns = first | 96u << 16, s.rows = 0u | 64u << 16;
        apply(knobs, view, tiling, s);
        return s;
    };
    auto const whole = from_column(0);
    CHECK(whole.columns == (44u | 53u << 16));
    CHECK(whole.rows == (28u | 37u << 16));
    CHECK(whole.anchor == tilemesh::TileId::at(1, 1));
    CHECK(!from_column(53).visible()); // nothing is left
    CHECK(from_column(52).columns == (52u | 53u << 16));
    splat::Splat hidden{};
    apply(knobs, view, tiling, hidden);
    CHECK(!hidden.visible());
}

TEST_CASE("the key is the highest bits of the depth")
{
    struct Case {
        std::uint32_t bits, depth, key;
    };
    for (auto const& each :
         {Case{32, 0xffffffffu, 0xffffffffu}, Case{32, 0x3f812345u, 0x3f812345u}, Case{24, 0x3f812345u, 0x3f812300u},
          Case{24, 0xffffffffu, 0xffffff00u}, Case{16, 0x3f812345u, 0x3f810000u}, Case{1, 0x7fffffffu, 0u}, Case{1, 0x80000001u, 0x80000000u}}) {
        CAPTURE(each.bits);
        Knobs knobs;
        CHECK(knobs.key_bits == 32);
        knobs.key_bits = each.bits;
        CHECK(key_of(knobs, each.depth) == each.key);
    }
}

TEST_CASE("settings: sixty and more, each by a name of its own, the library's first")
{
    auto const all = settings();
    CHECK(all.size() >= 60);
    std::map<std::string, int> names;
    for (auto const& s : all) {
        CHECK(++names[s.name] == 1);
        CHECK(s.name.find(',') == std::string::npos);
        CHECK(!s.name.empty());
        CHECK(!s.knob.empty());
    }
    REQUIRE(all.front().name == "default");
    splat::Rules lossless;
    lossless.footprint = splat::Lossless::footprint;
    lossless.alpha_max = splat::Lossless::alpha_max;
    lossless.arithmetic = splat::Lossless::arithmetic;
    lossless.transmittance_min = splat::Lossless::transmittance_min;
    CHECK(same_rules(all.front().rules, lossless));
    CHECK(all.front().rules.transmittance_min == 5e-3f);
    CHECK(all.front().rules.alpha_min == 1.0f / 255);
    CHECK(all.front().knobs == Knobs{});
    CHECK(all.front().limits == Limits{});

    for (auto const q : {splat::Quality::evaluation, splat::Quality::viewing, splat::Quality::on_sensor}) {
        auto const s = setting_of(splat::name(q));
        CHECK(same_rules(s.rules, splat::with_quality(lossless, q)));
        CHECK(s.knobs == Knobs{});
        CHECK(s.limits == Limits{});
    }
    CHECK(setting_of("viewing").rules.transmittance_min == 5e-3f);
    // No setting occurs under two names.
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t k = 0; k < i; ++k) {
            auto const &one = all[k], &other = all[i];
            CHECK_MESSAGE(!(same_rules(one.rules, other.rules) && one.knobs == other.knobs && one.limits == other.limits), one.name,
                          " is ", other.name);
        }
    auto const few = settings_of_sequences();
    CHECK(few.front().name == "default");
    names.clear();
    for (auto const& s : few) CHECK(++names[s.name] == 1);
}

TEST_CASE("settings: each leaves out in double what it leaves out in float")
{
    for (auto const& s : settings()) {
        auto const cuts = cut_offs_of(s);
        CHECK(cuts.alpha_min == double{s.rules.alpha_min});
        CHECK(cuts.alpha_max == double{s.rules.alpha_max});
        CHECK(cuts.transmittance_min == double{s.rules.transmittance_min});
        CHECK(cuts.footprint == s.rules.footprint);
        CHECK(cuts.sigmas == double{s.knobs.sigmas});
        CHECK(cuts.blends_crossing == (s.knobs.crossing == Crossing::blend));
    }
    auto const paper = cut_offs_of(setting_of("3DGS"));
    CHECK(!paper.blends_crossing);
    CHECK(paper.alpha_max == double{0.99f});
    CHECK(paper.transmittance_min == double{1e-4f});
    CHECK(paper.footprint == splat::Footprint::three_sigma_square);
    CHECK(cut_offs_of(setting_of("sigma 2.5 alpha 0")).sigmas == 2.5);
    CHECK(cut_offs_of(setting_of("sigma 2.5 alpha 0")).alpha_min == double{no_alpha_cut});
    CHECK(cut_offs_of(setting_of("no cut")).transmittance_min == 0);
    CHECK(cut_offs_of(setting_of("default")).sigmas == 0);
}

TEST_CASE("a view is measured against three pictures: double without cut-offs, double with them, the whole frame in float")
{
    bench::Scene scene;
    scene.map.name = "pretended";
    scene.map.gaussians = cloud(600);
    scene.camera = camera_of();
    auto const camera = bench::cameras_of("", scene, 1, {})[1];
    std::vector<Setting> chosen;
    for (char const* name : {"default", "on_sensor", "3DGS", "sigma 2 alpha 0", "half conic", "12-bit keys", "drop 5 slots", "storage 10"})
        chosen.push_back(setting_of(name));
    MeasureOptions options;
    options.rounds = 2;
    options.threads = 2;
    Noise noise;
    auto const rows = measure_view(scene, chosen, options, noise);
    REQUIRE(rows.size() == chosen.size());

    auto const gaussians = scene.map.gaussians;
    auto const none = report::render_double(gaussians, camera, splat::Rules{}, report::no_cut_offs(no_alpha_cut));
    double const n = 3.0 * width * height;
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
        auto const& row = rows[i];
        auto const& s = chosen[i];
        CAPTURE(s.name);
        REQUIRE(row.failed.empty());
        auto const cut = report::render_double(gaussians, camera, s.rules, cut_offs_of(s));
        auto const whole = whole_frame(gaussians, camera, s.rules, s.knobs);
        auto mesh = whole;
        if (s.limits.drop) mesh.rgb[4] += PretendedMachine::change;
        auto const same = [&](report::ErrorMeasures const& part, report::ErrorMeasures const& whole_of_it) {
            CHECK(part.rmse == doctest::Approx(whole_of_it.rmse).epsilon(1e-12));
            CHECK(part.mae == doctest::Approx(whole_of_it.mae).epsilon(1e-12));
            CHECK(part.max_levels == whole_of_it.max_levels);
            CHECK((part.psnr_db == whole_of_it.psnr_db || part.psnr_db == doctest::Approx(whole_of_it.psnr_db).epsilon(1e-12)));
        };
        same(row.total, report::compare(mesh, none));
        same(row.cut, report::compare(cut, none));
        same(row.round, report::compare(whole, cut));
        same(row.mesh, report::compare(mesh, whole));
        CHECK(row.total.ssim == report::compare(mesh, none).ssim);
        CHECK(row.cut.rmse > 0);
        CHECK(row.split_off < 1e-12);
        double const parts = row.cut.rmse * row.cut.rmse + row.round.rmse * row.round.rmse + row.mesh.rmse * row.mesh.rmse;
        CHECK(parts + row.twice_products == doctest::Approx(row.total.rmse * row.total.rmse).epsilon(1e-11));
        if (s.limits.drop) {
            CHECK(row.mesh.rmse == doctest::Approx(PretendedMachine::change / std::sqrt(n)).epsilon(1e-6));
            CHECK(row.lost == 1);
            CHECK(!row.complete());
        } else {
            CHECK(row.mesh.rmse == 0);
            CHECK(row.mesh.max_levels == 0);
            CHECK(row.complete());
        }
        CHECK(!row.mesh_wrong);
        CHECK(row.modelled_ms == 2);
    }
    CHECK(rows.back().failed == "too small (10 slots); choose more");
    CHECK(rows[1].host_ms == std::vector<double>{3, 3});
    CHECK(noise.ratios == std::vector<double>{1, 1});

    // A mesh that lacks nothing but shows another picture is detected.
    options.spoil = true;
    auto const spoilt = measure_view(scene, {chosen[0], chosen[1]}, options, noise);
    CHECK(!spoilt[0].mesh_wrong);
    CHECK(spoilt[1].mesh_wrong);
    CHECK(spoilt[1].mesh.rmse > 0);
}
