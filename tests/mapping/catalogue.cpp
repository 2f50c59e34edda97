// test: optimised, cost 2
#include "support.hpp"

// Refinement of the records of the stability catalogue (tests/stability): steps by a picture that they do not show leave no value that is
// not finite, and no record that is not valid. Rows about order, mesh and number formats have no record of their own.
using namespace tilemesh;
using splat::Gaussian;

namespace {

struct Row {
    int row;
    std::string what;
    std::vector<Gaussian> records;
    bool moves = true; ///< at least one record must move
};

constexpr float inf = std::numeric_limits<float>::infinity();

/// A grey Gaussian at depth z in front of `support::lens`, at (x, y) of its normalised picture.
Gaussian at(float x, float y, float z, float s0, float s1, float s2, float opacity = 0.7f)
{
    return {{x * z, y * z, z}, {0.4f, 0.5f, 0.6f}, opacity, {0.9f, 0.3f, -0.2f, 0.1f}, {std::log(s0), std::log(s1), std::log(s2)},
            splat::GaussianId{1}};
}
Gaussian ball_at(float x, float y, float z, float s, float opacity = 0.7f)
{
    return at(x, y, z, s, s, s, opacity);
}
Gaussian with_rotation(Gaussian g, float w, float x, float y, float z)
{
    float const q[4] = {w, x, y, z};
    std::memcpy(g.rotation, q, sizeof q);
    return g;
}
Gaussian with_log_scale(Gaussian g, float s)
{
    for (float& v : g.log_scale) v = s;
    return g;
}
Gaussian moved(Gaussian g, float dx, float dy, float dz)
{
    g.mean_world[0] += dx, g.mean_world[1] += dy, g.mean_world[2] += dz;
    return g;
}
std::vector<Gaussian> layers(std::uint32_t n, float opacity, float step = 1e-3f)
{
    std::vector<Gaussian> out;
    for (std::uint32_t i = 0; i < n; ++i) out.push_back(moved(ball_at(0, 0, 2, 0.2f, opacity), 0, 0, step * static_cast<float>(i)));
    return out;
}

std::vector<Row> rows()
{
    support::Random random(7);
    std::vector<Gaussian> needles, close;
    for (int i = 0; i < 40; ++i) {
        auto needle = at(random.uniform(-0.5f, 0.5f), random.uniform(-0.3f, 0.3f), random.uniform(0.5f, 5), random.uniform(0.13f, 2.7f),
                         1e-4f, 1e-4f);
        for (float& q : needle.rotation) q = random.uniform(-1, 1);
        needles.push_back(needle);
        auto near = at(random.uniform(-0.5f, 0.5f), random.uniform(-0.3f, 0.3f), random.uniform(0.2f, 1), 0, 0, 0);
        for (float& s : near.log_scale) s = random.uniform(-6, 0);
        close.push_back(near);
    }
    auto black = ball_at(0, 0, 2, 0.3f, 1), white = ball_at(0, 0, 2.1f, 0.3f, 1);
    for (float& c : black.colour) c = 0;
    for (float& c : white.colour) c = 1;
    auto const one = [](Gaussian const& g) { return std::vector<Gaussian>{g}; };
    return {
        {1, "needles", needles},
        {2, "long needle, two thin axes", one(at(0, 0, 2, 20, 1e-3f, 1e-3f))},
        {5, "a standard deviation of a thousand pixels", one(ball_at(0.1f, 0, 2, 40))},
        {6, "disc", one(at(0, 0.1f, 2, 0.3f, 0.3f, 1e-6f))},
        {7, "close to the camera", close},
        {9, "no extent: the dilation alone", one(with_log_scale(ball_at(0, 0, 2, 1), -100))},
        {16, "a quaternion of zeros", one(with_rotation(ball_at(0, 0, 2, 0.1f), 0, 0, 0, 0)), false},
        {17, "a quaternion of length 1e-23", one(with_rotation(ball_at(0, 0, 2, 0.1f), 1e-23f, 0, 1e-23f, 0)), false},
        {18, "a quaternion of length 1e20", one(with_rotation(ball_at(0, 0, 2, 0.1f), 1e20f, 1e20f, 0, 0)), false},
        {19, "a quaternion that is not normalised", one(with_rotation(ball_at(0, 0, 2, 0.1f), 2, 0.5f, 0, 1))},
        {20, "log-scales of 22, 44, 88", {with_log_scale(ball_at(0, 0, 2, 1), 22.2f), with_log_scale(ball_at(0, 0, 2, 1), 44.4f),
                                           with_log_scale(ball_at(0, 0, 2, 1), 88.8f)}, false},
        {21, "log-scales of -26, -44, -52", {with_log_scale(ball_at(0, 0, 2, 1), -26), with_log_scale(ball_at(0.1f, 0, 2, 1), -43.7f),
                                              with_log_scale(ball_at(-0.1f, 0, 2, 1), -52)}},
        {22, "a log-scale of minus infinity; opacities of 0 and 1", {with_log_scale(ball_at(0, 0, 2, 1), -inf),
                                                                      ball_at(0.1f, 0, 2, 0.1f, 0), ball_at(-0.1f, 0, 2, 0.1f, 1)}},
        {24, "a depth of 1e-10", one(ball_at(0, 0, 1e-10f, 0.01f)), false},
        {26, "at the near plane, and just behind it", {ball_at(0.1f, 0, 0.2f, 0.05f), ball_at(0, 0.1f, std::nextafter(0.2f, 1.0f), 0.05f)}},
        {27, "behind the camera", {ball_at(0, 0, -1, 0.5f), ball_at(0, 0, -0.1f, 5)}, false},
        {28, "at the camera's centre", one(ball_at(0, 0, 0, 0.3f)), false},
        {30, "coordinates of 1e6", {ball_at(0, 0, 1e6f, 3e4f), moved(ball_at(0, 0, 2, 0.1f), 1e6f, 0, 0)}},
        {33, "far outside of the picture, and large", {ball_at(1.5f, 0, 2, 2), ball_at(50, 0, 1, 60)}},
        {34, "a needle along the line of sight, beside the picture", one(at(0.9f, 0.3f, 1, 0.01f, 0.01f, 5))},
        {36, "a twentieth of a pixel", one(ball_at(0.01f, 0.02f, 2, 2.6e-3f))},
        {37, "a radius of 3e9 pixels: it stays as it is, because products of its slopes overflow", one(ball_at(0, 0, 0.3f, 3e7f)), false},
        {43, "opacities next to 1 and next to 0", {ball_at(0, 0, 2, 0.1f, std::nextafter(1.0f, 0.0f)), ball_at(0.2f, 0, 2, 0.1f, 8e-40f)}},
        {44, "opaque black before opaque white", {black, white}},
        {45, "two layers of 0.99", layers(2, 0.99f)},
        {47, "a thousand layers below the cut-off", layers(1000, 0.0039f), false},
        {49, "many faint layers", layers(4000, 0.005f, 1e-5f)},
        {55, "a crowd of equal records", layers(3000, 0.5f, 0)},
        {56, "two of one depth", {ball_at(0.01f, 0, 2, 0.1f, 0.5f), ball_at(-0.01f, 0, 2, 0.1f, 0.5f)}},
    };
}

bool finite(float v)
{
    return std::isfinite(v);
}
/// A record of which every word is a number of its kind. `was`: before the steps. A log-scale of minus infinity is one (no extent).
bool valid(Gaussian const& g, Gaussian const& was)
{
    bool good = g.id == was.id && g.opacity >= 0 && g.opacity <= 1;
    for (int i = 0; i < 3; ++i) {
        good = good && finite(g.mean_world[i]) && finite(g.colour[i]) && g.colour[i] >= 0;
        good = good && (finite(g.log_scale[i]) || was.log_scale[i] == -inf);
    }
    for (float const q : g.rotation) good = good && finite(q);
    return good;
}

template <class Optimiser>
void refine_rows()
{
    auto const camera = support::lens(61, 43);
    support::Random random(3);
    mapping::Target target{61, 43, std::vector<splat::TargetPixel>(std::size_t{61} * 43)};
    for (auto& p : target.pixels) p = {{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)}, random.uniform(0, 3)};
    for (auto const& row : rows())
        for (auto const border : {splat::SlopeBorder::of_picture, splat::SlopeBorder::of_half_width})
            for (float const most : {0.99f, 1.0f}) {
                INFO("row ", row.row, ": ", row.what, ", alpha_max ", most);
                auto map = support::map_of(row.records);
                std::uint32_t id = 0;
                for (auto& g : map.gaussians) g.id = splat::GaussianId{++id};
                auto const before = map.gaussians;
                mapping::RefineOptions o;
                o.rules.alpha_max = most;
                o.rules.slope_border = border;
                o.view.loss = {1, 0.5f, 0.05f, 0, 4};
                mapping::Refiner<Optimiser> refiner(map, o);
                for (int i = 0; i < 6; ++i) {
                    auto const fit = refiner.step(camera, target, splat::map::usual_rates(2));
                    CHECK(std::isfinite(fit.loss));
                    CHECK(std::isfinite(fit.squares));
                }
                bool moved = false, all_valid = true;
                for (std::size_t i = 0; i < before.size(); ++i) {
                    auto const& g = refiner.map().gaussians[i];
                    all_valid = all_valid && valid(g, before[i]);
                    moved = moved || std::memcmp(&g, &before[i], sizeof g) != 0;
                }
                CHECK(all_valid);
                if (row.moves) CHECK(moved);
                auto const seen = refiner.render(camera);
                bool picture = true;
                for (float const v : seen.colour.rgb) picture = picture && finite(v);
                for (float const v : seen.depth.values) picture = picture && finite(v);
                CHECK(picture);
            }
}

} // namespace

TEST_CASE("refiner: the catalogue's records stay valid with each optimiser")
{
    refine_rows<splat::map::SecondMomentByKind>();
    refine_rows<splat::map::Adam>();
}
