// test: unoptimised test asan tsan
#include "map_writers.hpp"
#include "real_packing.hpp"
#include "support.hpp"
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/splat/rules.hpp>

using namespace scene_test;
using tilemesh::report::Image;
using tilemesh::scene::Map;
using tilemesh::scene::Turn;
using tilemesh::splat::Camera;

namespace {

Map read(Bytes const& bytes, std::string const& name = "test.splat")
{
    std::istringstream stream(bytes);
    return tilemesh::scene::read_map(stream, name, real_packing().codecs);
}

Image render(Map const& map, Camera const& camera)
{
    namespace report = tilemesh::report;
    auto const of_degree = [&]<std::uint32_t degree>(std::integral_constant<std::uint32_t, degree>) {
        return report::render_double(tilemesh::scene::records<tilemesh::splat::GaussianOfDegree<degree>>(map), camera, tilemesh::splat::Rules{},
                                     report::Cuts::none, 1);
    };
    switch (map.sh_degree) {
    case 0:
        return of_degree(std::integral_constant<std::uint32_t, 0>{});
    case 1:
        return of_degree(std::integral_constant<std::uint32_t, 1>{});
    case 2:
        return of_degree(std::integral_constant<std::uint32_t, 2>{});
    default:
        return of_degree(std::integral_constant<std::uint32_t, 3>{});
    }
}

/// The Gaussians lie one behind the other, further apart than any format moves them. Colours and harmonics are in the range of all formats.
PlainMap layers(std::uint32_t degree)
{
    Numbers numbers(20 + degree);
    PlainMap map{degree, {}};
    for (int i = 0; i < 16; ++i) {
        PlainRow row;
        row.mean = {numbers.between(-0.6, 0.6), numbers.between(-0.4, 0.4), 2.0 + 0.25 * i};
        for (double& v : row.f_dc) v = numbers.between(-1.2, 1.6);
        for (double& v : row.scale) v = numbers.between(-3.5, -1.0);
        for (double& v : row.rotation) v = numbers.between(-1, 1);
        row.logit = numbers.between(-3, 3);
        for (std::size_t k = 0; k < coefficients_of(degree); ++k) row.rest[k] = numbers.between(-0.2, 0.2);
        map.rows.push_back(row);
    }
    return map;
}

/// The ranges of a map's fields, from which a format computes its steps.
struct Widths {
    double mean = 0, log_mean = 0, scale = 0, f_dc = 0, logit = 0, rest = 0;
    double farthest = 0; ///< the largest number of a mean

    explicit Widths(PlainMap const& map)
    {
        struct Range {
            double low = std::numeric_limits<double>::max(), high = -low;
            void add(double v) { low = std::min(low, v), high = std::max(high, v); }
            double width() const { return std::max(0.0, high - low); }
        };
        // One range for the three sizes, and one for the three channels: a list of values may serve all of them.
        std::array<Range, 3> means, logs;
        Range scales, colours, logits, rests;
        for (PlainRow const& row : map.rows) {
            for (std::size_t i = 0; i < 3; ++i) {
                means[i].add(row.mean[i]);
                logs[i].add(std::copysign(std::log1p(std::fabs(row.mean[i])), row.mean[i]));
                farthest = std::max(farthest, std::fabs(row.mean[i]));
                scales.add(row.scale[i]);
                colours.add(row.f_dc[i]);
            }
            logits.add(row.logit);
            for (std::size_t k = 0; k < coefficients_of(map.degree); ++k) rests.add(row.rest[k]);
        }
        for (std::size_t i = 0; i < 3; ++i) mean = std::max(mean, means[i].width()), log_mean = std::max(log_mean, logs[i].width());
        scale = scales.width(), f_dc = colours.width(), logit = logits.width(), rest = rests.width();
    }
};

/// How a format writes a rotation: all four numbers, or three of them, from which the reader derives w or the largest.
enum class Written { all, without_w, without_largest };

/// The largest change that the rounding of a format makes to one field; `rotation`: to one of the numbers that it writes.
struct Steps {
    double mean, scale, f_dc, opacity, rest, rotation;
    Written written;
};

/// The largest sine of half the angle by which the rounding turns the rotation w, x, y, z.
double largest_turn(float const (&rotation)[4], Steps const& steps)
{
    double const step = steps.rotation;
    // The sine of the angle between two quaternions, one of length 1, is at most their distance.
    if (steps.written == Written::all) return 2 * step;
    std::array<double, 4> const q{rotation[0], rotation[1], rotation[2], rotation[3]};
    std::size_t const derived = steps.written == Written::without_w ? 0 : largest_of(q);
    // The three change the square of the fourth, w, by so much. w^2 - v^2 = (w - v) (w + v) then bounds the change of w.
    double square = 3 * step * step;
    for (std::size_t i = 0; i < 4; ++i) square += i == derived ? 0 : 2 * step * std::fabs(q[i]);
    double const w = std::fabs(q[derived]);
    double const change = std::min(std::sqrt(square), square / (w + std::max(0.0, w - square / w)));
    return std::sqrt(3 * step * step + change * change);
}

/// With room for the rounding to float.
double widened(double step)
{
    return step * 1.0001 + 1e-6;
}

/// Do the fields of all Gaussians differ by no more than the steps?
bool within_steps(Map const& a, Map const& b, Steps const& steps)
{
    auto const near_to = [](double x, double y, double step) { return std::fabs(x - y) <= widened(step); };
    bool all = a.gaussians.size() == b.gaussians.size() && a.harmonics.size() == b.harmonics.size();
    for (std::size_t i = 0; all && i < a.gaussians.size(); ++i) {
        auto const &g = a.gaussians[i], &h = b.gaussians[i];
        double dot = 0, squares_g = 0, squares_h = 0; // rounded to float, the rotations have no length of exactly 1
        for (int k = 0; k < 4; ++k) {
            dot += double{g.rotation[k]} * h.rotation[k];
            squares_g += double{g.rotation[k]} * g.rotation[k];
            squares_h += double{h.rotation[k]} * h.rotation[k];
        }
        double const turn = std::sqrt(std::max(0.0, 1 - dot * dot / (squares_g * squares_h)));
        all = all && near_to(g.opacity, h.opacity, steps.opacity) && turn <= widened(largest_turn(g.rotation, steps));
        for (int k = 0; k < 3; ++k)
            all = all && near_to(g.mean_world[k], h.mean_world[k], steps.mean) && near_to(g.log_scale[k], h.log_scale[k], steps.scale) &&
                  near_to(g.colour[k], h.colour[k], steps.f_dc * 0.2821);
    }
    for (std::size_t i = 0; all && i < a.harmonics.size(); ++i) all = near_to(a.harmonics[i], b.harmonics[i], steps.rest);
    return all;
}

Map only(Map const& map, std::size_t i, bool white)
{
    Map one = map;
    std::size_t const floats = coefficients_of(map.sh_degree);
    one.gaussians = {map.gaussians[i]};
    one.harmonics.assign(map.harmonics.begin() + static_cast<std::ptrdiff_t>(i * floats), map.harmonics.begin() + static_cast<std::ptrdiff_t>((i + 1) * floats));
    if (white) {
        std::fill(one.harmonics.begin(), one.harmonics.end(), 0.0f);
        std::fill_n(one.gaussians[0].colour, 3, 1.0f);
    }
    return one;
}

/// What the steps can do to one Gaussian in a picture. Its covariance on the picture lies between 1/K and K times its own; its centre moves
/// by at most `shift`, in standard deviations; each channel of its colour changes by at most `colour`.
struct Reach {
    double k, shift, colour, opacity_low, opacity_high;

    Reach(Map const& map, std::size_t i, Camera const& camera, Steps const& steps)
    {
        auto const& g = map.gaussians[i];
        double const pi = 3.14159265358979323846;
        double const move = std::sqrt(3.0) * widened(steps.mean), wider = std::exp(widened(steps.scale));
        double away[3], depth = 0, distance = 0;
        for (int axis = 0; axis < 3; ++axis) {
            away[axis] = double{g.mean_world[axis]} - camera.position[axis];
            depth += camera.rotation[2][axis] * away[axis];
            distance += away[axis] * away[axis];
        }
        distance = std::sqrt(distance);
        auto const [least, most] = std::minmax({g.log_scale[0], g.log_scale[1], g.log_scale[2]});
        double const small = std::exp(double{least}) / wider, large = std::exp(double{most}) * wider;
        // In the world, R S S R^T: a factor of S is one of the covariance, twice. A turn Q, with |Q - 1| = 2 sin(angle / 2), is a factor of at
        // most (1 + |S^-1 (Q - 1) S|)^2. The map to the picture and the dilation keep factors.
        double const turn = 1 + large / small * 2 * widened(largest_turn(g.rotation, steps));
        // A mean that moves by d moves f x / z by J d z / (z + d_z), exactly. In standard deviations J d is at most |d| / the smallest size.
        double const nearer = depth / (depth - move);
        shift = move / small * nearer;
        // J itself changes by the factor z / (z + d_z), and by the move of the centre over the depth in its third column.
        double const bend = nearer * (1 + shift * large / (depth - move));
        k = wider * wider * turn * turn * bend * bend;
        // Harmonics of degree l: the squares of the 2l+1 functions add up to (2l+1) / 4 pi, those of their gradients to l (l+1) times that.
        colour = widened(steps.f_dc) * sh_c0;
        std::size_t const floats = coefficients_of(map.sh_degree);
        for (std::size_t l = 1; l <= map.sh_degree; ++l) {
            double const n = static_cast<double>(2 * l + 1), norm = std::sqrt(n / (4 * pi));
            double largest = 0;
            for (std::size_t channel = 0; channel < 3; ++channel) {
                double squares = 0;
                for (std::size_t c = l * l - 1; c < (l + 1) * (l + 1) - 1; ++c) squares += std::pow(double{map.harmonics[floats * i + 3 * c + channel]}, 2);
                largest = std::max(largest, std::sqrt(squares));
            }
            colour += norm * (std::sqrt(n) * widened(steps.rest) + largest * std::sqrt(static_cast<double>(l * (l + 1))) * std::asin(move / distance));
        }
        opacity_low = std::max(0.0, g.opacity - widened(steps.opacity));
        opacity_high = std::min(1.0, g.opacity + widened(steps.opacity));
    }
};

/// Two pictures of each Gaussian of a map alone: in white, the opacity of each pixel; and its colour.
struct Alone {
    Image alpha;
    std::array<double, 3> colour{};

    Alone(Map const& map, std::size_t i, Camera const& camera) : alpha(render(only(map, i, true), camera))
    {
        Image const coloured = render(only(map, i, false), camera);
        std::size_t const peak = static_cast<std::size_t>(std::max_element(alpha.rgb.begin(), alpha.rgb.end()) - alpha.rgb.begin()) / 3 * 3;
        for (std::size_t c = 0; c < 3; ++c) colour[c] = double{coloured.rgb[peak + c]} / alpha.rgb[peak + c];
    }
};

/// The largest change of each number of the picture that the steps of a format explain. The Gaussians lie in the order of their depths, and
/// no step changes that order.
///
/// A pixel is the sum of c_i a_i T_i, where T_i is the product of 1 - a_j of those before it. If they change one after the other, from the
/// front, Gaussian i changes the pixel by T_i (a_i' (c_i' - c_i) + (a_i' - a_i) (c_i - what is behind)).
std::vector<double> explained(Map const& map, std::vector<Alone> const& alone, Camera const& camera, Steps const& steps)
{
    std::array<double, 3> brightest{};
    for (Alone const& one : alone)
        for (std::size_t c = 0; c < 3; ++c) brightest[c] = std::max(brightest[c], one.colour[c]);
    std::vector<double> bound(alone[0].alpha.rgb.size(), 0.0), through(bound.size() / 3, 1.0);
    for (std::size_t i = 0; i < alone.size(); ++i) {
        Reach const reach(map, i, camera, steps);
        double const opacity = map.gaussians[i].opacity;
        for (std::size_t p = 0; p < through.size(); ++p) {
            double const alpha = alone[i].alpha.rgb[3 * p];
            // a = opacity e^(-r^2 / 2), with r in standard deviations. Below the smallest float r is that of the smallest float.
            double const r = std::sqrt(std::max(0.0, -2 * std::log(std::max(alpha, 1e-45) / opacity)));
            double const farther = std::sqrt(reach.k) * (r + reach.shift), nearer = std::max(0.0, r - reach.shift) / std::sqrt(reach.k);
            double const high = reach.opacity_high * std::exp(-nearer * nearer / 2);
            double const low = alpha == 0 ? 0 : reach.opacity_low * std::exp(-farther * farther / 2);
            double const change = std::max(high - alpha, alpha - low);
            for (std::size_t c = 0; c < 3; ++c)
                bound[3 * p + c] += through[p] * (high * reach.colour + change * brightest[c]);
            through[p] *= 1 - low;
        }
    }
    return bound;
}

double largest_difference(Image const& a, Image const& b)
{
    double largest = 0;
    for (std::size_t p = 0; p < a.rgb.size(); ++p) largest = std::max(largest, std::fabs(double{a.rgb[p]} - b.rgb[p]));
    return largest;
}

} // namespace

TEST_CASE("the same map in every format: fields are within the format's rounding, and the picture within the bound that follows from it")
{
    Packing const packing = real_packing();
    for (std::uint32_t degree = 0; degree <= 3; ++degree) {
        PlainMap const plain = layers(degree);
        Map const exact = read(write_plain_ply(plain));
        Camera const camera = tilemesh::scene::frame_whole(exact, {48, 32});
        Widths const width(plain);
        // Half a step of each number.
        double const half_8 = 0.5 / 255, smallest = std::sqrt(2.0); // of numbers from -1/sqrt(2) to 1/sqrt(2)
        double const spz_colour = half_8 / 0.15, spz_rest = 1.0 / 256, spz_scale = 1.0 / 32;
        // A mean of SOG is rounded in its logarithm, l = log(1 + |mean|): e^l changes by e^l times half a step, and by its square.
        double const log_step = width.log_mean / 65535 / 2, sog_mean = (1 + width.farthest) * log_step * (1 + log_step);
        Steps const spz_3{1.0 / 8192, spz_scale, spz_colour, half_8, spz_rest, smallest / 2 / 511 / 2, Written::without_largest};
        Steps const sog_2{sog_mean, width.scale * half_8, width.f_dc * half_8, half_8, width.rest * half_8, smallest * half_8, Written::without_largest};
        // Version 1 rounds the logit of an opacity, of which the slope is at most 1/4.
        Steps sog_1 = sog_2;
        sog_1.opacity = width.logit * half_8 / 4;
        std::vector<std::tuple<std::string, Bytes, Steps>> formats{
            // 10 or 11 bits. The harmonics are the middles of 256 parts, but the first and the last are their ends.
            {"compressed PLY", PackedPly::of(plain).bytes(),
             {width.mean / 1023 / 2, width.scale / 1023 / 2, width.f_dc * half_8, half_8, 8.0 / 256, smallest / 1023 / 2, Written::without_largest}},
            // A float16 below 8 has steps of 8 / 2048; x, y, z have 255 steps from -1 to 1.
            {"SPZ 1", PackedSpz::of(plain, 1).bytes(packing), {8.0 / 2048 / 2, spz_scale, spz_colour, half_8, spz_rest, 2 * half_8, Written::without_w}},
            {"SPZ 2", PackedSpz::of(plain, 2).bytes(packing), {1.0 / 8192, spz_scale, spz_colour, half_8, spz_rest, 2 * half_8, Written::without_w}},
            {"SPZ 3", PackedSpz::of(plain, 3).bytes(packing), spz_3},
            {"SPZ 4", PackedSpz::of(plain, 4).bytes(packing), spz_3},
            {"SOG 1", write_zip(PackedSog::of(plain, 1).files(packing), packing, true), sog_1},
            {"SOG 2", write_zip(PackedSog::of(plain, 2).files(packing), packing, true), sog_2}};
        // The byte of 1 is 255, and not 256, of 128.
        if (degree == 0) formats.push_back({".splat", PackedSplat::of(plain).bytes(), {0, 0, half_8 / sh_c0, half_8, 0, 1.0 / 128, Written::all}});
        std::vector<Alone> alone;
        for (std::size_t i = 0; i < exact.gaussians.size(); ++i) alone.emplace_back(exact, i, camera);
        Image const picture = render(exact, camera);
        for (auto const& [format, bytes, steps] : formats) {
            auto const& name = format; // Clang 14 captures no structured binding
            CAPTURE(name);
            CAPTURE(degree);
            Map const map = read(bytes);
            Map rounded = exact;
            auto before = alone;
            Image of_rounded = picture;
            if (name == ".splat") { // it has no colours outside [0, 1], so the map that it rounds has them clamped
                for (std::size_t i = 0; i < rounded.gaussians.size(); ++i)
                    for (std::size_t c = 0; c < 3; ++c) {
                        float& colour = rounded.gaussians[i].colour[c];
                        colour = std::clamp(colour, 0.0f, 1.0f);
                        before[i].colour[c] = colour;
                    }
                of_rounded = render(rounded, camera);
            }
            CHECK(within_steps(rounded, map, steps));
            Image const other = render(map, camera);
            auto const bound = explained(rounded, before, camera, steps);
            double worst = 0, sum = 0, changes = 0;
            for (std::size_t p = 0; p < bound.size(); ++p) {
                double const change = std::fabs(double{of_rounded.rgb[p]} - other.rgb[p]);
                worst = std::max(worst, change / (bound[p] + 1e-6)); // the pictures are floats
                sum += bound[p];
                changes += change;
            }
            CHECK(worst <= 1.0);
            INFO("bound / change of the picture: ", sum / changes);
            CHECK(sum < 200 * changes); // the bound is near enough to be one
        }
    }
}

TEST_CASE("a turned map looks from a turned camera as before")
{
    for (std::uint32_t degree : {0u, 3u}) {
        Map const map = read(write_plain_ply(layers(degree)));
        Camera const camera = tilemesh::scene::frame_whole(map, {48, 32});
        Image const before = render(map, camera);
        for (int turn = 0; turn < 9; ++turn) {
            CAPTURE(turn);
            int const axis = turn / 3, quarters = turn % 3 + 1, u = (axis + 1) % 3, v = (axis + 2) % 3;
            // A camera's rows are its axes in the world: turn these, quarter by quarter.
            Camera moved = camera;
            for (int i = 0; i < quarters; ++i) {
                auto const quarter = [&](auto& vector) {
                    float const x = vector[u];
                    vector[u] = -vector[v];
                    vector[v] = x;
                };
                quarter(moved.position);
                for (auto& row : moved.rotation) quarter(row);
            }
            Map const after = tilemesh::scene::turned(map, static_cast<Turn>(turn));
            CHECK(largest_difference(before, render(after, moved)) < 2e-5);
            CHECK(largest_difference(before, render(map, moved)) > 0.05);
            // The rest of the full turn gives the map back.
            Map const back = tilemesh::scene::turned(after, static_cast<Turn>(3 * axis + 3 - quarters));
            for (std::size_t i = 0; i < map.gaussians.size(); ++i)
                for (int k = 0; k < 3; ++k) CHECK(back.gaussians[i].mean_world[k] == map.gaussians[i].mean_world[k]);
            for (std::size_t i = 0; i < map.harmonics.size(); ++i) CHECK(std::fabs(back.harmonics[i] - map.harmonics[i]) < 1e-6f);
        }
    }
}

TEST_CASE("the axes of an SPZ are turned back by x180")
{
    Numbers numbers(30);
    auto const packed = PackedSpz::random(50, 2, 3, numbers);
    Map const map = tilemesh::scene::turned(read(packed.plain()), Turn::x180);
    for (std::size_t i = 0; i < map.gaussians.size(); ++i) {
        auto const& row = packed.rows[static_cast<std::size_t>(map.gaussians[i].id) - 1];
        auto const fixed = [](std::uint32_t bits) { return static_cast<float>(static_cast<std::int32_t>(bits << 8) >> 8) / 4096.0f; };
        for (std::size_t k = 0; k < 3; ++k) CHECK(map.gaussians[i].mean_world[k] == fixed(row.mean[k]));
        for (std::size_t k = 0; k < 45; ++k) CHECK(map.harmonics[45 * i + k] == (static_cast<float>(row.sh[k]) - 128.0f) / 128.0f);
    }
}
