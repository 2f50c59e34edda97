// test: optimised, cost 6
// Why a pixel is off: pictures with one known fault each, from a renderer of this test.
#include "../standard.hpp"
#include <tilemesh/report/causes.hpp>
#include <tilemesh/report/enclosure.hpp>

namespace {

using namespace tilemesh;
using report::detail::ReferenceSplat;
using tests::Random;

struct Faults {
    std::uint32_t without = 0, swapped = 0; ///< ids: one is left out, one comes after the next one
    bool half = false, coarse_depth = false;
    float cut = 1, stop = 1; ///< factors
};

/// To 11 significant bits, as float16 has them.
double to_half(double v)
{
    if (v == 0) return 0;
    int exponent = 0;
    double const m = std::frexp(v, &exponent);
    return std::ldexp(std::nearbyint(std::ldexp(m, 11)), exponent - 11);
}

template <class Record>
report::Image render(std::vector<Record> const& records, splat::Camera const& c, splat::Rules const& rules, Faults const& faults)
{
    std::vector<ReferenceSplat> all;
    auto const cuts = report::cut_offs(rules);
    for (auto const& g : records)
        if (auto const s = report::detail::project_reference(g, c, rules, cuts); s && static_cast<std::uint32_t>(g.id) != faults.without)
            all.push_back(*s);
    auto const key = [&](ReferenceSplat const& s) { return faults.coarse_depth ? std::floor(s.depth / 10 * 65535) : s.depth; }; // 16 bits of 10 m
    std::stable_sort(all.begin(), all.end(), [&](auto const& a, auto const& b) { return key(a) < key(b); });
    for (std::size_t i = 0; i + 1 < all.size(); ++i)
        if (static_cast<std::uint32_t>(all[i].id) == faults.swapped) {
            std::swap(all[i], all[i + 1]);
            break;
        }
    auto const rounded = [&](double v) { return faults.half ? to_half(v) : v; };
    report::Image out(c.width, c.height);
    for (std::uint32_t y = 0; y < c.height; ++y)
        for (std::uint32_t x = 0; x < c.width; ++x) {
            double t = 1, sum[3] = {};
            for (auto const& s : all) {
                double const dx = x + 0.5 - s.mean_x, dy = y + 0.5 - s.mean_y;
                double a = rounded(rounded(s.opacity) * std::exp(-0.5 * (s.conic_xx * dx * dx + s.conic_yy * dy * dy) - s.conic_xy * dx * dy));
                if (a < cuts.alpha_min * double{faults.cut}) continue;
                a = std::min(a, cuts.alpha_max);
                for (std::size_t k = 0; k < 3; ++k) sum[k] = rounded(sum[k] + rounded(rounded(t * a) * s.colour[k]));
                t = rounded(t * (1 - a));
                if (t < cuts.transmittance_min * double{faults.stop}) break;
            }
            for (std::uint32_t k = 0; k < 3; ++k) out.pixel(x, y)[k] = static_cast<float>(sum[k] + t * double{rules.background[k]});
        }
    return out;
}

template <class Record>
struct Scene {
    /// `layers`: splats of one slab lie within a thousandth of its depth.
    explicit Scene(bool layers = false) : random(7)
    {
        c.width = 96, c.height = 64, c.fx = c.fy = 80, c.cx = 48, c.cy = 32, c.near_depth = 0.2f;
        for (int i = 0; i < 3; ++i) c.rotation[i][i] = 1;
        for (std::uint32_t i = 0; i < 400; ++i) {
            Record g{};
            float const z = layers ? 1 + static_cast<float>(i % 5) + random.uniform(0, 1e-4f) : random.uniform(1, 6);
            g.mean_world[0] = random.uniform(-.7f, .7f) * z, g.mean_world[1] = random.uniform(-.45f, .45f) * z, g.mean_world[2] = z;
            for (float& v : g.rotation) v = random.uniform(-1, 1);
            for (float& v : g.log_scale) v = random.uniform(-4, -1.5f);
            for (float& v : g.colour) v = random.uniform(0, 1);
            g.opacity = random.uniform(.05f, 1);
            if constexpr (Record::sh_degree > 0)
                for (float& h : g.harmonics) h = random.uniform(-.3f, .3f);
            g.id = splat::GaussianId{i + 1};
            records.push_back(g);
        }
    }
    /// What a picture with the faults is called.
    report::Certificate judge(Faults const& faults, splat::Rules const& rendered, report::Written const& written = {}) const
    {
        auto picture = render(records, c, rendered, faults);
        if (written.clamped)
            for (float& v : picture.rgb) v = std::round(255 * std::clamp(v, 0.0f, 1.0f)) / 255;
        return judge(picture, written);
    }
    report::Certificate judge(report::Image const& picture, report::Written const& written = {}) const
    {
        auto const e = report::enclose(records, c, rules, {.threads = 2});
        auto out = report::certify(e, picture, written);
        report::explain(out, e, records, c, rules, picture, written);
        return out;
    }
    report::Certificate judge(Faults const& faults) const { return judge(faults, rules); }
    report::Certificate judge(splat::Rules const& other) const { return judge({}, other); }

    Random random;
    splat::Camera c{};
    splat::Rules rules;
    std::vector<Record> records;
};

/// The share of the pixels that were looked at which have this cause.
double share(report::Certificate const& c, std::string const& word)
{
    std::uint64_t all = 0, of_word = 0;
    for (auto const& [w, n] : c.causes) all += n, of_word += w == word ? n : 0;
    return all == 0 ? 0 : static_cast<double>(of_word) / static_cast<double>(all);
}

TEST_CASE("the exact picture has no cause")
{
    Scene<splat::Gaussian> const s;
    auto const c = s.judge(Faults{});
    CHECK(c.beyond == 0);
    CHECK(c.causes.empty());
}

TEST_CASE("a splat that is missing, and one that comes too late, are named")
{
    Scene<splat::Gaussian> const s(true);
    for (std::uint32_t const id : tests::fast() ? std::vector{17u} : std::vector{17u, 333u}) {
        auto const missing = s.judge({.without = id});
        REQUIRE(missing.beyond > 20);
        INFO(report::text_of(missing));
        CHECK(share(missing, "missing") > 0.9);
        CHECK(missing.worst.front().cause.word == "missing");
        CHECK(missing.worst.front().cause.id == id);
        CHECK(missing.worst.front().cause.left < 0.01);
        auto const in_bytes = s.judge({.without = id}, s.rules, {true, 0.5 / 255}); // where many explanations are as good
        CHECK(in_bytes.worst.front().cause.left < in_bytes.worst.front().levels / 10);
    }
    std::uint32_t named = 0;
    for (std::uint32_t id = 1; id < (tests::fast() ? 14 : 40); ++id) {
        auto const late = s.judge({.swapped = id});
        if (late.beyond == 0) continue; // the two have no pixel in common
        INFO(report::text_of(late));
        CHECK(share(late, "order") > 0.8); // where the stop comes between the two, one of them is missing
        named += late.worst.front().cause.word == "order" && late.worst.front().cause.id == id ? 1 : 0;
    }
    CHECK(named > (tests::fast() ? 0 : 3));
}

TEST_CASE("a cut, and a stop, that came a little sooner or later")
{
    Scene<splat::Gaussian> s;
    for (float const factor : {0.995f, 1.005f}) {
        auto const cut = s.judge({.cut = factor}), stop = s.judge({.stop = factor});
        REQUIRE(cut.beyond > 20);
        REQUIRE(stop.beyond > 0);
        INFO(report::text_of(cut), report::text_of(stop));
        CHECK(share(cut, "cut") > 0.95);
        CHECK(share(stop, "stop") > 0.95);
    }
    s.rules.stop = splat::Stop::before_crossing, s.rules.alpha_max = 0.99f;
    auto other = s.rules;
    other.stop = splat::Stop::after_crossing;
    CHECK(s.judge(other).beyond > 20);
}

TEST_CASE("other rules: each is named")
{
    Scene<splat::ShadedGaussian<1>> const s;
    auto const named = [&](std::string const& word, auto const& change) {
        auto other = s.rules;
        change(other);
        auto const c = s.judge(other);
        INFO(word, ": ", report::text_of(c));
        CHECK(c.beyond > 100);
        CHECK(share(c, word) > 0.5);
        CHECK(c.causes.front().first == word);
    };
    named("dilation 0", [](splat::Rules& r) { r.dilation = 0; });
    named("background", [](splat::Rules& r) { r.background[0] = 1, r.background[2] = 0.25f; });
    if (tests::fast()) return;
    named("dilation 0.1", [](splat::Rules& r) { r.dilation = 0.1f; });
    named("antialias", [](splat::Rules& r) { r.coverage = splat::Coverage::preserved; });
    named("alpha_min 0", [](splat::Rules& r) { r.alpha_min = 1e-7f; });
    std::vector<splat::Gaussian> const flat(s.records.begin(), s.records.end());
    auto const c = s.judge(render(flat, s.c, s.rules, {}));
    INFO(report::text_of(c));
    CHECK(c.causes.front().first == "harmonics");
}

TEST_CASE("pixels that are not finite, an interval that is wide, and a picture of many faults in little time")
{
    Scene<splat::Gaussian> const s(true);
    report::Image broken(s.c.width, s.c.height);
    for (float& v : broken.rgb) v = std::numeric_limits<float>::quiet_NaN();
    auto const c = s.judge(broken);
    REQUIRE(c.causes.size() == 1);
    CHECK(c.causes[0].first == "not finite");
    CHECK(c.causes[0].second > 800);
    // The middle of an undecided pixel is in its interval.
    auto one = s;
    one.c.width = one.c.height = 1, one.c.cx = one.c.cy = 0.5f;
    one.records = {{{0, 0, 2}, {1, 1, 1}, 0.25f, {1, 0, 0, 0}, {}, splat::GaussianId{1}}};
    one.rules.alpha_min = 0.25f;
    auto const both = report::enclose(one.records, one.c, one.rules);
    report::Image middle(1, 1);
    for (std::size_t k = 0; k < 3; ++k) middle.rgb[k] = static_cast<float>(both.middle[k]);
    CHECK(one.judge(middle).causes == std::vector<std::pair<std::string, std::uint64_t>>{{"undecided", 1}});
}

TEST_CASE("renderers as others write them: one in float16, one that sorts by 16 bits of depth")
{
    Scene<splat::Gaussian> const s(true);
    auto const half = s.judge({.half = true}), coarse = s.judge({.coarse_depth = true});
    INFO(report::text_of(half), "   ", report::text_of(coarse));
    CHECK(half.beyond > 1000);
    CHECK(half.causes.front().first == "rounding");
    CHECK(coarse.beyond > 20);
    CHECK(coarse.causes.front().first == "order");
    CHECK(share(coarse, "order") > 0.75); // dozens of splats of one key
}

} // namespace
