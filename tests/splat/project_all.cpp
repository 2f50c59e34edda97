// test: without tsan
#include "support.hpp"
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/splat/project_all.hpp>

// Vectors here have more lanes than the target. GCC warns of them as results, at the end of the file, although all functions are inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

using namespace tilemesh;
using namespace tilemesh::splat;
using splat::detail::FloatLanes, splat::detail::OneFloat;

namespace {
constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
constexpr float smallest = std::numeric_limits<float>::min();
constexpr float subnormal = std::numeric_limits<float>::denorm_min();

/// The number of records for which `project_all` differs from `project` in any bit. Also checks that it does not write beyond them.
template <std::uint32_t Lanes, class Record>
std::uint32_t wrong_in_lanes(std::vector<Record> const& records, std::vector<Splat> const& expected, View const& view,
                             Tiling const& tiling)
{
    auto const n = static_cast<std::uint32_t>(records.size());
    Splat guard{};
    guard.depth_key = 12345;
    std::vector<Splat> out(records.size() + 1, guard);
    project_all<Lanes>(records.data(), n, view, tiling, out.data());
    std::uint32_t wrong = std::memcmp(&out[n], &guard, sizeof guard) != 0 ? 1 : 0;
    for (std::uint32_t i = 0; i < n; ++i) wrong += std::memcmp(&out[i], &expected[i], sizeof guard) != 0 ? 1 : 0;
    return wrong;
}
struct Result {
    std::uint32_t wrong, visible;
};
/// The sum over all numbers of lanes.
template <class Record>
Result compare(std::vector<Record> const& records, Camera const& camera, Rules const& rules)
{
    auto const view = make_view(camera, rules);
    auto const tiling = make_tiling(camera.width, camera.height, 32, 20);
    std::vector<Splat> expected;
    Result result{0, 0};
    for (auto const& r : records) {
        expected.push_back(project(r, view, tiling));
        result.visible += expected.back().visible() ? 1 : 0;
    }
    result.wrong = wrong_in_lanes<1>(records, expected, view, tiling) + wrong_in_lanes<4>(records, expected, view, tiling) +
                   wrong_in_lanes<8>(records, expected, view, tiling) + wrong_in_lanes<16>(records, expected, view, tiling) +
                   wrong_in_lanes<splat::detail::lanes_in_use>(records, expected, view, tiling);
    return result;
}

/// A length between 1e-30 and 1e30; all magnitudes are equally likely.
float any_magnitude(support::Random& random)
{
    return std::exp(random.uniform(-69, 69));
}
/// An ordinary Gaussian in front of `support::lens`, with one or several of the faults that occur in maps.
Gaussian stiff(support::Random& random, float near_depth, float alpha_min)
{
    Gaussian g{};
    float const z = random.uniform(0.3f, 6);
    g.mean_world[0] = random.uniform(-0.8f, 0.8f) * z;
    g.mean_world[1] = random.uniform(-0.6f, 0.6f) * z;
    g.mean_world[2] = z;
    for (float& c : g.colour) c = random.uniform(0, 1.5f);
    g.opacity = random.uniform(0.01f, 1);
    for (float& q : g.rotation) q = random.uniform(-1, 1);
    for (float& s : g.log_scale) s = random.uniform(-6, -1);
    g.id = GaussianId{random.below(1000) + 1};
    auto const axis = [&] { return random.below(3); };
    auto const one_of = [&](std::initializer_list<float> values) {
        return values.begin()[random.below(static_cast<std::uint32_t>(values.size()))];
    };
    for (std::uint32_t ways = 1 + random.below(2); ways > 0; --ways) switch (random.below(16)) {
        case 0: // a needle
            g.log_scale[0] = random.uniform(-2, 4), g.log_scale[1] = g.log_scale[2] = random.uniform(-20, -7);
            break;
        case 1: // a disc, or a plane
            g.log_scale[0] = g.log_scale[1] = random.uniform(-2, 12), g.log_scale[2] = random.uniform(-87, -9);
            break;
        case 2: // any size, to both ends of the exponential's range
            for (float& s : g.log_scale) s = random.uniform(-100, 100);
            break;
        case 3: // around the largest axis that is projected in pixels
            for (float& s : g.log_scale) s = random.uniform(10, 24);
            break;
        case 4: g.log_scale[axis()] = one_of({infinity, -infinity, not_a_number, 3e38f, -3e38f, 88, -87, 1e30f}); break;
        case 5: // a quaternion of any length
            for (float const f = any_magnitude(random); float& q : g.rotation) q *= f;
            break;
        case 6: // around the lengths from which the square is taken without scaling
            for (float const f = one_of({1e-15f, 1e15f}) * random.uniform(0.5f, 2); float& q : g.rotation) q *= f;
            break;
        case 7: // no rotation, or almost none
            for (float& q : g.rotation) q = one_of({0, -0.0f, subnormal, -subnormal, smallest});
            break;
        case 8: g.rotation[random.below(4)] = one_of({infinity, -infinity, not_a_number, 3e38f, 2e19f, subnormal, 0}); break;
        case 9: // at the near plane and behind the camera
            g.mean_world[2] = one_of({near_depth, std::nextafter(near_depth, 0.0f), std::nextafter(near_depth, 1.0f), 0,
                                      -0.0f, -near_depth, -z, subnormal});
            break;
        case 10: // far away
            for (float& m : g.mean_world) m *= any_magnitude(random);
            break;
        case 11: g.mean_world[axis()] = one_of({infinity, -infinity, not_a_number, 3e38f, -3e38f, 1e37f, 9e36f, 0}); break;
        case 12: // where the logarithm is 0, and beyond it
            g.opacity = one_of({alpha_min, std::nextafter(alpha_min, 1.0f), std::nextafter(alpha_min, 0.0f), 0, -0.0f, 1,
                                std::nextafter(1.0f, 2.0f), 2, -1, infinity, -infinity, not_a_number, subnormal, 3e38f});
            break;
        case 13:
            g.colour[axis()] = one_of({1e6f, std::nextafter(1e6f, 2e6f), -1e6f, -1.1e6f, infinity, not_a_number, -0.0f});
            break;
        case 14: // off the frame's borders, all sides
            g.mean_world[random.below(2)] = random.uniform(-3, 3) * z;
            break;
        default: { // any word, any bits
            float const v = std::bit_cast<float>(random.bits());
            std::memcpy(reinterpret_cast<char*>(&g) + 4 * random.below(14), &v, 4);
        }
        }
    return g;
}
std::vector<Gaussian> stiff_map(std::uint32_t n, std::uint64_t seed, Camera const& camera, Rules const& rules)
{
    support::Random random(seed);
    std::vector<Gaussian> map;
    for (std::uint32_t i = 0; i < n; ++i) map.push_back(stiff(random, camera.near_depth, rules.alpha_min));
    return map;
}
template <std::uint32_t Degree>
std::vector<ShadedGaussian<Degree>> shaded(std::vector<Gaussian> const& plain, std::uint64_t seed)
{
    support::Random random(seed);
    std::vector<ShadedGaussian<Degree>> map;
    for (auto const& g : plain) {
        ShadedGaussian<Degree> s{};
        static_cast<Gaussian&>(s) = g;
        for (float& h : s.harmonics) h = random.uniform(-0.3f, 0.3f);
        if (random.below(50) == 0) s.harmonics[random.below(3)] = random.below(2) == 0 ? not_a_number : 1e7f;
        map.push_back(s);
    }
    return map;
}

/// The units in the last place between a float and the right value.
double ulps_off(float v, double right)
{
    int exponent;
    (void)std::frexp(right, &exponent);
    return std::fabs(double{v} - right) / std::ldexp(1.0, exponent - 24);
}
/// The number of lanes in which `in_lanes` differs from `alone`, over the list of floats. NaN equals NaN.
template <std::uint32_t N, class InLanes, class Alone>
std::uint32_t unlike(std::vector<float> const& values, InLanes const& in_lanes, Alone const& alone)
{
    std::uint32_t count = 0;
    for (std::size_t i = 0; i + N <= values.size(); i += N) {
        float out[N];
        in_lanes(&values[i], out);
        for (std::uint32_t k = 0; k < N; ++k) {
            float const right = alone(values[i + k]);
            count +=
                std::bit_cast<std::uint32_t>(out[k]) != std::bit_cast<std::uint32_t>(right) && !(std::isnan(out[k]) && std::isnan(right)) ? 1 : 0;
        }
    }
    return count;
}
/// Floats with every exponent, both signs and many fractions, including zeros, infinities and NaN. Whole blocks of 16.
std::vector<float> all_kinds_of_floats()
{
    std::vector<float> values;
    for (std::uint32_t bits = 0; bits < 0xffffffffu - 40009u; bits += 40009u) values.push_back(std::bit_cast<float>(bits));
    for (float const v : {0.0f, -0.0f, 1.0f, -1.0f, infinity, -infinity, not_a_number, subnormal, smallest, 3.4e38f})
        values.push_back(v);
    while (values.size() % 16 != 0) values.push_back(2.0f);
    return values;
}
} // namespace

// Functions on lanes may only be called between these marks.
TILEMESH_EXACT_BEGIN
namespace {
template <std::uint32_t N>
void roots(float const* in, float* out)
{
    auto const v = splat::detail::load<N>(in);
    auto const root = FloatLanes<N>::square_root(v);
    std::memcpy(out, &root, sizeof root);
}
template <std::uint32_t N>
void logarithms(float const* in, float* out)
{
    auto const v = splat::detail::load<N>(in);
    auto const log = splat::detail::logarithm<FloatLanes<N>>(v);
    std::memcpy(out, &log, sizeof log);
}
template <std::uint32_t N>
void exponentials(float const* in, float* out)
{
    auto const v = splat::detail::load<N>(in);
    auto const power = FloatLanes<N>::exponential(v);
    std::memcpy(out, &power, sizeof power);
}
} // namespace
TILEMESH_EXACT_END

TEST_CASE("logarithm: within 1 ulp of the double logarithm over its whole range, exactly 0 at 1 alone")
{
    double worst = 0;
    std::uint32_t zeros = 0;
    auto const look = [&](std::uint32_t bits) {
        float const x = std::bit_cast<float>(bits), y = logarithm(x);
        if (x == 1) CHECK(std::bit_cast<std::uint32_t>(y) == 0);
        else
            worst = std::max(worst, ulps_off(y, std::log(double{x})));
        zeros += y == 0 ? 1 : 0;
    };
    for (std::uint32_t bits = 0x00800000u; bits < 0x7f800000u; bits += 1009) look(bits);
    for (std::uint32_t bits = 0x3f800000u - 300000; bits < 0x3f800000u + 300000; ++bits) look(bits); // where it is near 0
    MESSAGE("largest error: ", worst, " ulp");
    CHECK(worst < 1.0);
    CHECK(zeros == 1);
    CHECK(logarithm(smallest) == doctest::Approx(-87.3365));
    CHECK(logarithm(infinity) == infinity);
    for (float const x : {0.0f, -0.0f, subnormal, std::nextafter(smallest, 0.0f), -1.0f, -infinity, not_a_number})
        CHECK(std::isnan(logarithm(x)));
}

TEST_CASE("logarithm: grows, so that more opacity is no smaller box")
{
    std::uint32_t falls = 0;
    for (std::uint32_t bits = 0x3f800000u; bits < 0x3f800000u + (1u << 20); ++bits)
        falls += logarithm(std::bit_cast<float>(bits)) > logarithm(std::bit_cast<float>(bits + 1)) ? 1 : 0;
    for (std::uint32_t bits = 0x00800000u; bits + 4099 < 0x7f800000u; bits += 4099)
        falls += logarithm(std::bit_cast<float>(bits)) > logarithm(std::bit_cast<float>(bits + 4099)) ? 1 : 0;
    CHECK(falls == 0);
}

TEST_CASE("lanes: square root, logarithm and exponential have the bits of one float's")
{
    auto const values = all_kinds_of_floats();
    auto const root = [](float v) { return std::sqrt(v); };
    auto const power = [](float v) { return exponential(v); };
    CHECK(unlike<4>(values, roots<4>, root) == 0);
    CHECK(unlike<8>(values, roots<8>, root) == 0);
    CHECK(unlike<16>(values, roots<16>, root) == 0);
    CHECK(unlike<4>(values, logarithms<4>, logarithm) == 0);
    CHECK(unlike<8>(values, logarithms<8>, logarithm) == 0);
    CHECK(unlike<16>(values, logarithms<16>, logarithm) == 0);
    CHECK(unlike<4>(values, exponentials<4>, power) == 0);
    CHECK(unlike<8>(values, exponentials<8>, power) == 0);
    CHECK(unlike<16>(values, exponentials<16>, power) == 0);
    double worst = 0;
    for (float const v : values)
        if (v > 0 && v < infinity) worst = std::max(worst, ulps_off(OneFloat::square_root(v), std::sqrt(double{v})));
    CHECK(worst <= 0.5 + 1e-6); // correctly rounded
}

TEST_CASE("lanes: tiles, spans and roundings are those of integers")
{
    std::uint32_t wrong = 0;
    std::vector<std::uint32_t> sizes{1000u, 32767u, 40503u, 65535u, 65536u, 1u << 24, ~0u};
    for (std::uint32_t size = 1; size <= 130; ++size) sizes.push_back(size);
    for (auto const size : sizes)
        for (std::uint32_t pixel = 0; pixel < 65536; ++pixel) {
            auto const tile = splat::detail::tile_at<OneFloat>(static_cast<float>(pixel), size);
            wrong += static_cast<std::uint32_t>(tile) != pixel / size ? 1 : 0;
        }
    support::Random random(5);
    auto const naive_span = [](double centre, double reach, double size) -> std::uint32_t { // for numbers that add exactly
        double const low = std::floor(centre - reach), high = std::floor(centre + reach) + 1;
        if (!(low < size) || !(high > 0)) return 0;
        return static_cast<std::uint32_t>(std::max(low, 0.0)) | static_cast<std::uint32_t>(std::min(high, size)) << 16;
    };
    auto const span = [](float centre, float reach, std::uint32_t size) {
        return static_cast<std::uint32_t>(splat::detail::pixel_span<OneFloat>(centre, reach, size));
    };
    for (std::uint32_t n = 0; n < 200000; ++n) {
        auto const size = random.below(3) == 0 ? random.below(4) : random.below(65536);
        auto const eighths = [&] { return static_cast<float>(random.below(1u << 20)) / 8 - 32768; };
        float const centre = random.below(2) == 0 ? std::round(eighths()) : eighths(), reach = std::fabs(eighths());
        wrong += span(centre, reach, size) != naive_span(double{centre}, double{reach}, double(size)) ? 1 : 0;
        float const v = std::fabs(eighths()) * (random.below(2) == 0 ? 1.0f : 1e-4f);
        wrong += splat::detail::round_up<OneFloat>(v) != std::ceil(v) ? 1 : 0;
    }
    CHECK(wrong == 0);
    CHECK(span(not_a_number, 1, 100) == 0);
    CHECK(span(1, not_a_number, 100) == 0);
    CHECK(span(5, infinity, 100) == (100u << 16));
    CHECK(span(5, 3e9f, 65535) == (65535u << 16));
    CHECK(span(-3e9f, 1, 100) == 0);
    CHECK(span(-0.0f, 0, 1) == (1u << 16));
    CHECK(span(100, 0, 100) == 0);
    CHECK(splat::detail::round_up<OneFloat>(infinity) == infinity);
    CHECK(splat::detail::round_up<OneFloat>(8388607.5f) == 8388608.0f);
    CHECK(std::isnan(splat::detail::round_up<OneFloat>(not_a_number)));
}

TEST_CASE("project_all: the bits of project, for ordinary maps and both footprints")
{
    Rules square;
    square.footprint = Footprint::three_sigma_square;
    for (auto const& rules : {Rules{}, square}) {
        auto const built_in = compare(scene::built_in_map().gaussians, scene::built_in_camera({640, 400}), rules);
        CHECK(built_in.wrong == 0);
        CHECK(built_in.visible > 1000);
        auto const cloud = compare(support::cloud(20000, 3), support::lens(1280, 720, 0.2f), rules);
        CHECK(cloud.wrong == 0);
        CHECK(cloud.visible > 10000);
    }
}

TEST_CASE("project_all: the bits of project, for every way in which a record is stiff")
{
    std::uint32_t visible = 0, seed = 100;
    Rules few;
    few.alpha_min = 0.3f;
    Rules square;
    square.footprint = Footprint::three_sigma_square;
    Rules sharp;
    sharp.dilation = 0;
    sharp.jacobian_limit = 0;
    Rules dimmed;
    dimmed.coverage = Coverage::preserved;
    for (auto const& rules : {Rules{}, few, square, sharp, dimmed}) {
        auto const camera = support::lens(1280, 720, 0.1f);
        auto const result = compare(stiff_map(support::fast() ? 5000 : 25000, ++seed, camera, rules), camera, rules);
        CHECK(result.wrong == 0);
        visible += result.visible;
    }
    CHECK(visible > (support::fast() ? 5000u : 25000u));
}

TEST_CASE("project_all: the bits of project, for rules and cameras at their ends")
{
    std::uint32_t visible = 0, seed = 200;
    auto const look = [&](Camera const& camera, Rules const& rules) {
        auto const result = compare(stiff_map(1000, ++seed, camera, rules), camera, rules);
        CHECK(result.wrong == 0);
        visible += result.visible;
    };
    for (auto const footprint : {Footprint::opacity_box, Footprint::three_sigma_square}) {
        auto const camera = support::lens(640, 400);
        Rules rules;
        rules.footprint = footprint;
        auto const with = [&](float Rules::*member, std::initializer_list<float> values) {
            for (float const v : values) {
                Rules m = rules;
                m.*member = v;
                look(camera, m);
            }
        };
        with(&Rules::alpha_min, {0.0f, -0.0f, -1.0f, subnormal, 1e-42f, smallest, 1e-36f, 1.0f, 2.0f, infinity, not_a_number});
        for (auto const member : {&Rules::dilation, &Rules::jacobian_limit})
            with(member, {0.0f, 1e-30f, 1e10f, 1e20f, 3e38f, infinity, -1.0f, not_a_number});
        for (float const v : {0.0f, 1e-20f, 1e20f, -100.0f, infinity, not_a_number})
            for (auto* const word : {+[](Camera& c) { return &c.fx; }, +[](Camera& c) { return &c.cy; }, +[](Camera& c) { return &c.position[1]; },
                                     +[](Camera& c) { return &c.rotation[2][2]; }, +[](Camera& c) { return &c.near_depth; }}) {
                Camera c = camera;
                *word(c) = v;
                look(c, rules);
            }
        for (auto const size : {1u, 2u, 65535u}) {
            Camera c = camera;
            c.width = size;
            look(c, rules);
            c.height = size;
            look(c, rules);
        }
    }
    CHECK(visible > 10000);
}

TEST_CASE("project_all: any number of records, and nothing is written after the last")
{
    auto const camera = support::lens(640, 400);
    for (std::uint32_t const n : {0u, 1u, 2u, 3u, 4u, 5u, 7u, 8u, 9u, 15u, 16u, 17u, 31u, 32u, 33u, 47u}) {
        INFO(n, " records");
        CHECK(compare(support::cloud(n, 10 + n), camera, Rules{}).wrong == 0);
        CHECK(compare(stiff_map(n, 20 + n, camera, Rules{}), camera, Rules{}).wrong == 0);
        CHECK(compare(shaded<2>(support::cloud(n, 30 + n), n), camera, Rules{}).wrong == 0);
    }
}

TEST_CASE("project_all: the bits of project, for records with harmonics")
{
    auto const camera = support::lens(1280, 720, 0.3f);
    auto const ordinary = support::cloud(3000, 6);
    auto const broken = stiff_map(3000, 7, camera, Rules{});
    std::uint32_t visible = 0;
    auto const look = [&](auto const& records) {
        auto const result = compare(records, camera, Rules{});
        CHECK(result.wrong == 0);
        visible += result.visible;
    };
    look(shaded<1>(ordinary, 1));
    look(shaded<2>(ordinary, 2));
    look(shaded<3>(ordinary, 3));
    look(shaded<1>(broken, 4));
    look(shaded<2>(broken, 5));
    look(shaded<3>(broken, 6));
    CHECK(visible > 6000);
}
