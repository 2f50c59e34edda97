#include "settings.hpp"
#include <string>
#include <tilemesh/splat/quality.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <utility>

namespace error_vs_time {

namespace {

/// A number after which settings are named, and its name.
struct Level {
    char const* name;
    float value;
};
constexpr Level alphas[] = {{"1/8160", 1.0f / 8160}, {"1/2040", 1.0f / 2040}, {"1/1020", 1.0f / 1020}, {"1/510", 1.0f / 510},
                            {"1/380", 1.0f / 380},   {"1/320", 1.0f / 320},   {"1/280", 1.0f / 280},   {"1/255", 1.0f / 255},
                            {"1/220", 1.0f / 220},   {"1/190", 1.0f / 190},   {"1/128", 1.0f / 128},   {"1/64", 1.0f / 64}};
constexpr Level stops[] = {{"0", 0}, {"1e-4", 1e-4f}, {"1e-3", 1e-3f}, {"2e-3", 2e-3f}, {"3e-3", 3e-3f},
                           {"5e-3", 5e-3f}, {"1e-2", 1e-2f}, {"3e-2", 3e-2f}};
constexpr Level sigmas[] = {{"2", 2}, {"2.5", 2.5f}, {"3", 3}, {"3.33", 3.33f}, {"4", 4}, {"5", 5}, {"6", 6}, {"7", 7}};

splat::Rules default_rules()
{
    splat::Rules m;
    m.footprint = splat::Lossless::footprint;
    m.alpha_max = splat::Lossless::alpha_max;
    m.arithmetic = splat::Lossless::arithmetic;
    m.transmittance_min = splat::Lossless::transmittance_min;
    return m;
}
/// Removes the cut at alpha. The faint terms are then evaluated pair by pair, with any arithmetic (splat::detail::faintest_cut).
void cut_no_alpha(Setting& s)
{
    s.rules.alpha_min = no_alpha_cut;
    s.rules.arithmetic = splat::Arithmetic::precise;
}
Setting make(std::string name, std::string knob)
{
    return {std::move(name), std::move(knob), default_rules(), {}, {}};
}
bool same(splat::Rules const& a, splat::Rules const& b)
{
    return a.alpha_min == b.alpha_min && a.transmittance_min == b.transmittance_min;
}

void add_named(std::vector<Setting>& all)
{
    all.push_back(make("default", "named"));
    for (auto const q : {splat::Quality::evaluation, splat::Quality::viewing, splat::Quality::on_sensor}) {
        all.push_back(make(splat::name(q), "named"));
        all.back().rules = splat::with_quality(default_rules(), q);
    }
}
void add_alpha_and_stop(std::vector<Setting>& all)
{
    auto const named = all; // the first ones
    for (auto const& a : alphas)
        for (auto const& s : stops) {
            auto one = make(std::string("alpha ") + a.name + " stop " + s.name, "alpha and stop");
            one.rules.alpha_min = a.value;
            one.rules.transmittance_min = s.value;
            bool there = false;
            for (auto const& n : named) there = there || same(n.rules, one.rules);
            if (!there) all.push_back(std::move(one));
        }
}
void add_sigma(std::vector<Setting>& all)
{
    for (bool const alpha_too : {false, true})
        for (auto const& k : sigmas) {
            if (alpha_too && k.value > 3.4f) break; // for an opacity of 1 the box of alpha 1/255 ends at 3.33
            all.push_back(make(std::string("sigma ") + k.name + (alpha_too ? "" : " alpha 0"), "sigma"));
            all.back().knobs.sigmas = k.value;
            if (!alpha_too) cut_no_alpha(all.back());
        }
    all.push_back(make("alpha 0", "sigma"));
    cut_no_alpha(all.back());
    all.push_back(make("no cut", "sigma"));
    cut_no_alpha(all.back());
    all.back().rules.transmittance_min = 0;
    all.push_back(make("3-sigma square", "sigma"));
    all.back().rules.footprint = splat::Footprint::three_sigma_square;
}
void add_rules(std::vector<Setting>& all)
{
    for (auto const& s : stops) {
        if (s.value < 1e-4f) continue;
        all.push_back(make(std::string("clamp 0.99 stop ") + s.name, "clamp"));
        all.back().rules.alpha_max = 0.99f;
        all.back().rules.transmittance_min = s.value;
    }
    for (auto const& s : stops) {
        if (s.value < 1e-4f) continue;
        all.push_back(make(std::string("crossing dropped clamp 0.99 stop ") + s.name, "crossing"));
        all.back().knobs.crossing = Crossing::drop;
        all.back().rules.alpha_max = 0.99f;
        all.back().rules.transmittance_min = s.value;
    }
    all.push_back(make("crossing dropped", "crossing")); // without the clamp, an opaque term always crosses the limit
    all.back().knobs.crossing = Crossing::drop;
    // Kerbl et al. 2023: 3-sigma square, 1/255, 0.99, 1e-4, and the crossing term is dropped.
    all.push_back(make("3DGS", "crossing"));
    all.back().knobs.crossing = Crossing::drop;
    all.back().rules.footprint = splat::Footprint::three_sigma_square;
    all.back().rules.alpha_max = 0.99f;
    all.back().rules.transmittance_min = 1e-4f;
    all.back().rules.arithmetic = splat::Arithmetic::precise;
    // The same rules on the rasteriser's own tiles: `render_map --quality training`.
    all.push_back(make(splat::name(splat::Quality::training), "crossing"));
    all.back().knobs.crossing = Crossing::drop;
    all.back().rules = splat::with_quality(default_rules(), splat::Quality::training);
}
void add_numbers(std::vector<Setting>& all)
{
    all.push_back(make("precise", "arithmetic"));
    all.back().rules.arithmetic = splat::Arithmetic::precise;
    for (std::uint32_t const degree : {4u, 3u}) {
        all.push_back(make("degree " + std::to_string(degree), "arithmetic"));
        all.back().knobs.degree = degree;
    }
    for (auto const shape : {Shape::half_factor, Shape::half_conic}) {
        all.push_back(make(shape == Shape::half_factor ? "half factor" : "half conic", "shape"));
        all.back().knobs.shape = shape;
    }
    for (std::uint32_t const bits : {24u, 20u, 18u, 16u, 14u, 12u}) {
        all.push_back(make(std::to_string(bits) + "-bit keys", "sort key"));
        all.back().knobs.key_bits = bits;
    }
}
void add_limits(std::vector<Setting>& all, bool few)
{
    for (bool const drop : {false, true})
        for (std::uint32_t const slots : {200u, 100u, 50u, 20u, 10u, 5u, 2u}) {
            if ((!drop && slots == 200) || (few && (slots > 20 || slots < 5))) continue;
            all.push_back(make(std::string(drop ? "drop " : "hold ") + std::to_string(slots) + " slots", "channels"));
            all.back().limits.drop = drop;
            all.back().limits.channel_slots = slots;
        }
    for (std::uint32_t const hops : {1u, 2u, 4u, 8u, 16u, 32u}) {
        if (few && hops > 8) continue;
        all.push_back(make(std::to_string(hops) + (hops == 1 ? " hop" : " hops"), "hops"));
        all.back().limits.hops = hops;
    }
    for (std::uint32_t const slots : {2000u, 1000u, 700u, 500u, 300u, 200u, 10u}) {
        if (few && slots != 300) continue;
        all.push_back(make("storage " + std::to_string(slots), "storage"));
        all.back().limits.storage_slots = slots;
    }
    auto const homes = [&](std::string const& name, std::uint32_t held, std::uint32_t slots) {
        all.push_back(make("homes" + name, "program"));
        all.back().limits.homes = true;
        all.back().limits.storage_slots = held;
        all.back().limits.channel_slots = slots;
    };
    homes("", 0, 200);
    for (std::uint32_t const held : {1000u, 300u, 100u})
        if (!few || held == 300) homes(" " + std::to_string(held) + " held", held, 200);
    for (std::uint32_t const slots : {20u, 2u})
        if (!few || slots == 20) homes(" " + std::to_string(slots) + " slots", 0, slots);
}

} // namespace

std::vector<Setting> settings()
{
    std::vector<Setting> all;
    add_named(all);
    add_alpha_and_stop(all);
    add_sigma(all);
    add_rules(all);
    add_numbers(all);
    add_limits(all, false);
    return all;
}
std::vector<Setting> settings_of_sequences()
{
    std::vector<Setting> all;
    add_named(all);
    for (auto const& s : settings())
        if (s.name == "3DGS" || s.name == "half conic" || s.name == "16-bit keys" || s.name == "alpha 1/64 stop 1e-3") all.push_back(s);
    add_limits(all, true);
    return all;
}

report::CutOffs cut_offs_of(Setting const& s)
{
    auto cuts = report::cut_offs(s.rules);
    cuts.sigmas = s.knobs.sigmas;
    cuts.blends_crossing = s.knobs.crossing == Crossing::blend;
    return cuts;
}

} // namespace error_vs_time
