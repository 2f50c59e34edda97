#include "machines.hpp"
#include "naive_kernel.hpp"
#include "reference.hpp"
#include "../splat/support.hpp"
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/harmonics.hpp>

// Maps, cameras and rules that nobody would make on purpose.
using namespace tilemesh;
using namespace tilemesh::splat;
using stability::Kind;

namespace {

// --- covariances that float32 cannot hold ----------------------------------------------------------------------------------

/// Needles, discs and blades in a narrow view. Axes are e^-22 to e^1.5, so a Gaussian is up to 2.45e7 times as long as wide (a covariance
/// with a condition number of 6e14).
std::vector<Gaussian> stiff_map(std::uint32_t n, std::uint64_t seed)
{
    support::Random random(seed);
    auto map = support::cloud(n, seed);
    for (auto& g : map) {
        float const z = random.uniform(1, 4); // no ties
        g.mean_world[0] = random.uniform(-0.09f, 0.09f) * z;
        g.mean_world[1] = random.uniform(-0.06f, 0.06f) * z;
        g.mean_world[2] = z;
        stability::random_rotation(g, random);
        float const longest = random.uniform(-6, 1.5f), shortest = std::max(-22.0f, longest - random.uniform(4, 17.01f));
        float const axes[3] = {longest, shortest, random.uniform(shortest, longest)};
        std::uint32_t const first = random.below(3);
        for (std::uint32_t i = 0; i < 3; ++i) g.log_scale[(first + i) % 3] = axes[i];
    }
    return map;
}

/// Is this float32 matrix positive definite, as a Cholesky factorisation in float32 sees it?
bool factors(naive::Matrix3 const& sigma)
{
    float l[3][3] = {};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j <= i; ++j) {
            float sum = sigma.m[i][j];
            for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
            if (i == j && !(sum > 0)) return false;
            l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
        }
    return true;
}

/// Blends layers, nearest first, each with its alpha at a pixel, with the default model's cut-offs.
template <class T, class Layer, class Alpha>
report::Image blended(std::vector<Layer> const& nearest_first, Camera const& camera, Alpha const& alpha_at)
{
    Rules const m{};
    report::Image image(camera.width, camera.height);
    for (std::uint32_t y = 0; y < camera.height; ++y)
        for (std::uint32_t x = 0; x < camera.width; ++x) {
            T rgb[3] = {}, through = 1;
            for (Layer const& layer : nearest_first) {
                if (through < T(m.transmittance_min)) break;
                T const alpha = alpha_at(layer, x, y);
                if (!(alpha >= T(m.alpha_min))) continue;
                T const weight = alpha * through;
                for (int c = 0; c < 3; ++c) rgb[c] += weight * T(layer.g.colour[c]);
                through -= weight;
            }
            for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = static_cast<float>(rgb[c]);
        }
    return image;
}

} // namespace

TEST_CASE("maps whose float32 covariances are not positive definite: finite, bit-equal to the naive picture, 90 dB and more")
{
    auto const map = stiff_map(support::fast() ? 800 : 2000, 21);
    auto camera = support::lens(support::fast() ? 96 : 144, support::fast() ? 54 : 80, 0.01f);
    camera.fx = camera.fy = 1000; // a world unit is 250 to 1,000 pixels
    std::uint32_t not_definite = 0;
    double condition = 0, smallest = 0;
    for (auto const& g : map) {
        not_definite += factors(naive::covariance_world(g)) ? 0 : 1;
        auto const [low, high] = std::minmax_element(std::begin(g.log_scale), std::end(g.log_scale));
        condition = std::max(condition, std::exp(2 * (double{*high} - double{*low})));
        smallest = std::min(smallest, double{*low});
    }
    INFO(not_definite, " of ", map.size(), " float32 covariances fail a Cholesky; condition up to ", condition);
    CHECK(not_definite * 10 > map.size());
    CHECK(condition > 4e14);
    CHECK(smallest < -21);

    auto const runner = stability::make_runner(Kind::roomy, support::map_of(map), {.tile = {16, 8}});
    auto const frame = runner->render(camera);
    CHECK(runner->differing_pixels(frame, camera) == 0);
    CHECK(stability::finite(frame));

    // The order is that of the float depths. Which of two splats is nearer by less than a rounding is not a question of covariances.
    struct Layer {
        Gaussian g;
        float depth;
        stability::Truth<long double> truth;
        naive::Splat naive;
    };
    std::vector<Layer> layers;
    Rules const rules{};
    for (auto const& g : map) {
        auto const s = stability::our_splat(g, camera, rules);
        if (s.visible()) layers.push_back({g, s.depth(), stability::truth<long double>(g, camera, rules), naive::project(g, camera)});
    }
    CHECK(layers.size() * 2 > map.size());
    std::sort(layers.begin(), layers.end(),
              [](Layer const& a, Layer const& b) { return a.depth != b.depth ? a.depth < b.depth : a.g.id < b.g.id; });
    auto const reference = blended<long double>(layers, camera, [&](Layer const& l, std::uint32_t x, std::uint32_t y) {
        return stability::true_alpha(l.truth, camera, x, y);
    });
    auto const naively = blended<float>(layers, camera, [&](Layer const& l, std::uint32_t x, std::uint32_t y) {
        return naive::alpha_at(l.naive, x, y);
    });
    auto const ours = report::compare(frame.image, reference), theirs = report::compare(naively, reference);
    INFO("ours ", ours.psnr_db, " dB, ", ours.max_levels, " levels; naive ", theirs.psnr_db, " dB, ", theirs.max_levels, " levels");
    CHECK(ours.psnr_db >= 90);
    CHECK(theirs.psnr_db < 50);
}

TEST_CASE("needles that reach into the frame from far outside it: bit-equal to the naive picture")
{
    // One world unit is one pixel. The distance to the mean is a float whose last bit is up to 4 pixels.
    for (float dilation : {0.3f, 0.01f, 0.0f})
        for (float far : {300.0f, 3e4f, 3e6f, 3e7f}) {
            support::Random random(71);
            auto camera = support::flat_camera(96, 64);
            camera.cx = 48;
            camera.cy = 32;
            std::vector<Gaussian> map;
            for (std::uint32_t id = 1; id <= (support::fast() ? 100u : 400u); ++id) {
                double const angle = double{random.uniform(-3.1415927f, 3.1415927f)}, away = double{far * random.uniform(0.3f, 1)};
                double const x = double{random.uniform(-48, 48)}, y = double{random.uniform(-32, 32)};
                auto g = support::ball(id, static_cast<float>(x - away * std::cos(angle)),
                                       static_cast<float>(y - away * std::sin(angle)), 1, random.uniform(0.1f, 1));
                g.rotation[0] = static_cast<float>(std::cos(angle / 2));
                g.rotation[3] = static_cast<float>(std::sin(angle / 2));
                g.log_scale[0] = static_cast<float>(std::log(away));
                g.log_scale[1] = random.uniform(-18, 0);
                g.log_scale[2] = -18;
                map.push_back(g);
            }
            INFO("dilation ", dilation, ", ", far, " px away");
            auto const runner = stability::make_runner(Kind::roomy, support::map_of(map), {.tile = {16, 8}});
            runner->rules().jacobian_limit = 0;
            runner->rules().dilation = dilation;
            auto const frame = runner->render(camera);
            CHECK(frame.report.pairs_contributing > 100);
            CHECK(runner->differing_pixels(frame, camera) == 0);
            CHECK(stability::finite(frame));
        }
}

// --- records, cameras and rules of hostile numbers --------------------------------------------------------------------------

namespace {

float hostile(support::Random& random)
{
    using Limits = std::numeric_limits<float>;
    constexpr float values[] = {0,      Limits::denorm_min(), 1e-40f, Limits::min(), 1e-30f, 1e-20f,          1e-10f,
                                1e-3f,  0.5f,                 1,      10,            100,    1000,            1e6f,
                                1e10f,  1e20f,                1e30f,  Limits::max(), 1e37f,  Limits::infinity(), Limits::quiet_NaN()};
    std::uint32_t const which = random.below(std::size(values) + 4), sign = random.bits() & 0x80000000u;
    std::uint32_t const bits = which < std::size(values) ? __builtin_bit_cast(std::uint32_t, values[which]) : random.bits();
    return __builtin_bit_cast(float, bits ^ sign);
}

/// Replaces floats among `n` words: one of them, about a quarter, or all.
void spoil(float* words, std::uint32_t n, support::Random& random)
{
    std::uint32_t const how = random.below(4);
    if (how < 2) {
        words[random.below(n)] = hostile(random);
        return;
    }
    for (std::uint32_t i = 0; i < n; ++i)
        if (how == 3 || random.below(4) == 0) words[i] = hostile(random);
}

constexpr std::uint32_t record_words = 14; // all words except the id
Gaussian hostile_record(std::uint32_t id, Gaussian g, support::Random& random)
{
    float words[15];
    static_assert(sizeof words == sizeof g);
    std::memcpy(words, &g, sizeof g);
    spoil(words, record_words, random);
    std::memcpy(&g, words, sizeof g);
    g.id = GaussianId{id};
    return g;
}

/// Any camera with focal lengths and a near plane above 0: kernels must bear it. A renderer refuses those of which `check_camera` says so.
Camera hostile_camera(Camera c, support::Random& random)
{
    float words[17]; // rotation, position, fx, fy, cx, cy, near
    std::memcpy(words, &c, sizeof words);
    std::uint32_t const how = random.below(5);
    if (how == 0) spoil(words, 17, random);
    if (how == 1) spoil(words, 9, random);
    if (how == 2) spoil(words + 9, 3, random);
    if (how == 3) spoil(words + 12, 5, random);
    if (how == 4) { // a rotation of another scale
        float const scale = hostile(random);
        for (int i = 0; i < 9; ++i) words[i] *= scale;
    }
    float const sound[17] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, c.fx, c.fy, 0, 0, c.near_depth};
    for (int i : {12, 13, 16}) {
        words[i] = std::fabs(words[i]);
        if (!(words[i] > 0)) words[i] = sound[i];
    }
    std::memcpy(static_cast<void*>(&c), words, sizeof words);
    return c;
}
/// Any model that a renderer accepts: no value is negative, except the Jacobian's limit.
Rules hostile_rules(support::Random& random)
{
    constexpr float none_or_little[] = {0, 1e-45f, 1e-38f, 1e-30f, 1e-12f};
    auto const little = [&](float otherwise) { return random.below(3) == 0 ? none_or_little[random.below(5)] : otherwise; };
    Rules m;
    m.alpha_min = little(m.alpha_min);
    m.transmittance_min = little(m.transmittance_min);
    m.dilation = little(m.dilation);
    m.jacobian_limit = little(m.jacobian_limit);
    if (random.below(4) == 0) m.alpha_max = 0.99f;
    if (random.below(3) == 0) m.footprint = Footprint::three_sigma_square;
    float* const all[] = {&m.alpha_min, &m.alpha_max, &m.transmittance_min, &m.dilation};
    if (random.below(4) == 0)
        if (float const v = std::fabs(hostile(random)); v >= 0) *all[random.below(4)] = v;
    if (random.below(8) == 0) m.jacobian_limit = hostile(random);
    return m;
}

/// The fault of a visible splat; empty if there is none.
template <class Record>
char const* fault(Record const& record, Splat const& s, View const& view, Tiling const& tiling)
{
    Camera const& c = view.camera;
    auto const r = s.rect();
    if (r.empty() || r.x1 > c.width || r.y1 > c.height) return "rectangle";
    if (s.anchor.x() >= tiling.columns || s.anchor.y() >= tiling.rows || !covers(s, tiling, s.anchor)) return "anchor";
    if (!std::isfinite(s.depth()) || !(s.depth() >= c.near_depth)) return "depth";
    if (!(s.opacity >= 0 && s.opacity <= 1)) return "opacity";
    for (float colour : s.colour)
        if (!(colour <= largest_colour && colour >= (Record::sh_degree > 0 ? 0 : -largest_colour))) return "colour";
    for (std::uint32_t x : {r.x0, (r.x0 + r.x1 - 1) / 2, r.x1 - 1})
        for (std::uint32_t y : {r.y0, (r.y0 + r.y1 - 1) / 2, r.y1 - 1}) {
            float const alpha = alpha_at(s, static_cast<float>(x) + 0.5f - c.cx, static_cast<float>(y) + 0.5f - c.cy);
            if (!(alpha >= 0 && alpha <= 1)) return "alpha";
        }
    return record.id == GaussianId::none ? "id" : nullptr;
}

/// The number of visible samples, the number of faulty ones among them, and the first faulty one.
struct Seen {
    std::uint32_t samples = 0, visible = 0, faults = 0;
    std::string first;

    template <class Record>
    void add(Record const& record, View const& view, Tiling const& tiling)
    {
        ++samples;
        auto const s = project(record, view, tiling);
        if (!s.visible()) return;
        ++visible;
        auto const* const what = fault(record, s, view, tiling);
        if (what != nullptr && faults++ == 0) first = what + (" of sample " + std::to_string(samples));
    }
};

template <std::uint32_t Degree>
ShadedGaussian<Degree> hostile_shaded(Gaussian const& sound, support::Random& random)
{
    ShadedGaussian<Degree> out{};
    constexpr std::uint32_t n = 3 * harmonics_per_channel(Degree);
    float harmonics[n];
    for (float& h : harmonics) h = random.uniform(-0.5f, 0.5f);
    spoil(harmonics, n, random);
    static_cast<Gaussian&>(out) = random.below(2) == 0 ? sound : hostile_record(static_cast<std::uint32_t>(sound.id), sound, random);
    std::memcpy(out.harmonics, harmonics, sizeof harmonics);
    return out;
}

} // namespace

TEST_CASE("no record, camera or rule makes a splat that is not finite, or outside the frame")
{
    support::Random random(41);
    auto const sound = support::cloud(64, 42);
    std::uint32_t const cameras = support::fast() ? 600 : 6000, records = 64;
    Seen spoilt_record, spoilt_camera, both, shaded;
    constexpr std::uint32_t sizes[] = {1, 2, 17, 96, 640, 65535};
    for (std::uint32_t i = 0; i < cameras; ++i) {
        bool const odd_size = random.below(4) == 0;
        auto const width = odd_size ? sizes[random.below(6)] : 96, height = odd_size ? sizes[random.below(6)] : 64;
        auto const tiling = make_tiling(width, height, 1 + random.below(width), 1 + random.below(height));
        auto const lens = support::lens(width, height, random.uniform(-0.3f, 0.3f));
        auto const rules = i % 2 == 0 ? Rules{} : hostile_rules(random);
        auto const view = make_view(lens, rules), hostile_view = make_view(hostile_camera(lens, random), rules);
        for (std::uint32_t k = 0; k < records; ++k) {
            auto const g = hostile_record(k + 1, sound[k], random);
            spoilt_record.add(g, view, tiling);
            spoilt_camera.add(sound[k], hostile_view, tiling);
            both.add(g, hostile_view, tiling);
            auto const& v = random.below(3) == 0 ? hostile_view : view;
            if (k % 3 == 0) shaded.add(hostile_shaded<1>(sound[k], random), v, tiling);
            if (k % 3 == 1) shaded.add(hostile_shaded<2>(sound[k], random), v, tiling);
            if (k % 3 == 2) shaded.add(hostile_shaded<3>(sound[k], random), v, tiling);
        }
    }
    auto const check = [&](Seen const& seen) {
        INFO(seen.visible, " of ", cameras * records, " visible; ", seen.first);
        CHECK(seen.faults == 0);
        CHECK(seen.visible * 30 > cameras * records); // hostile, but many are visible
    };
    check(spoilt_record);
    check(spoilt_camera);
    check(both);
    check(shaded);
}

TEST_CASE("no record, camera or rule makes a pixel that is not finite")
{
    support::Random random(51);
    std::uint32_t pictures = 0, refused = 0, lit = 0;
    for (std::uint32_t m = 0; m < (support::fast() ? 10 : 60); ++m) {
        auto map = support::cloud(90, 52 + m);
        for (std::uint32_t i = 0; i < 60; ++i) map[i] = hostile_record(i + 1, map[i], random);
        auto const runner = stability::make_runner(Kind::roomy, support::map_of(map), {.tile = {16, 10}});
        for (std::uint32_t k = 0; k < 10; ++k) {
            auto camera = support::lens(96, 64, random.uniform(-0.3f, 0.3f));
            if (k % 3 == 1) camera = hostile_camera(camera, random);
            if (k % 4 == 3) {
                float* const field[] = {&camera.fx, &camera.fy, &camera.near_depth};
                *field[random.below(3)] = hostile(random);
            }
            runner->rules() = k % 2 == 0 ? Rules{} : hostile_rules(random);
            INFO("map ", m, ", picture ", k);
            try {
                auto const frame = runner->render(camera);
                ++pictures;
                lit += frame.report.pairs_contributing > 0 ? 1 : 0;
                CHECK(stability::finite(frame));
                CHECK(std::all_of(frame.alpha.values.begin(), frame.alpha.values.end(), [](float a) { return a >= 0 && a <= 1; }));
                CHECK(frame.report.lost.empty());
                CHECK(runner->differing_pixels(frame, camera) == 0);
                CHECK(runner->wrong_tiles(camera) == 0);
                CHECK(runner->owned_ids().size() == map.size());
            } catch (Error const& e) {
                ++refused;
                std::string const text = e.what();
                CHECK_FALSE(text.empty());
                CHECK(text.find('\n') == std::string::npos);
                CHECK_THROWS_AS(scene::check_camera(camera), Error);
            }
        }
    }
    INFO(pictures, " pictures, ", lit, " of them with something in them, ", refused, " refused");
    CHECK(lit * 2 > pictures);
    CHECK(refused > 0);
}
