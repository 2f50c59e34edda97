#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <tilemesh/scene/ply_output.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/logarithm.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

namespace detail {
/// Appends a number with its lowest byte first.
template <class Word, class Number>
void put_number(std::string& to, Number v)
{
    static_assert(sizeof(Word) == sizeof(Number));
    Word word;
    std::memcpy(&word, &v, sizeof v);
    for (std::size_t byte = 0; byte < sizeof v; ++byte) to.push_back(static_cast<char>(word >> 8 * byte & 0xffu));
}
/// The logarithm of the odds, as the reader's sigmoid inverts it.
inline float logit_of(float opacity) noexcept
{
    if (!(opacity > 1e-37f)) return -104.0f;
    return opacity < 1.0f ? splat::logarithm(opacity) - splat::logarithm(1.0f - opacity) : 18.0f;
}
} // namespace detail

TILEMESH_HOST std::string ply_bytes(Map const& map, splat::Coverage coverage)
{
    bool const moved = map.origin != std::array<double, 3>{};
    std::size_t const of_channel = splat::harmonics_per_channel(map.sh_degree);
    std::string out = "ply\nformat binary_little_endian 1.0\n";
    if (coverage == splat::Coverage::preserved) out += "comment antialiased 1\n";
    out += "element vertex " + std::to_string(map.gaussians.size()) + "\n";
    auto const property = [&](std::string const& name, char const* type = "float") { out += std::string("property ") + type + " " + name + "\n"; };
    for (char const* const name : {"x", "y", "z"}) property(name, moved ? "double" : "float");
    for (char const* const name : {"f_dc_0", "f_dc_1", "f_dc_2"}) property(name);
    for (std::size_t k = 0; k < 3 * of_channel; ++k) property("f_rest_" + std::to_string(k));
    for (char const* const name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) property(name);
    out += "end_header\n";
    out.reserve(out.size() + map.gaussians.size() * (4 * (14 + 3 * of_channel) + 12));
    auto const put = [&](float v) { detail::put_number<std::uint32_t>(out, v); };
    for (std::size_t row = 0; row < map.gaussians.size(); ++row) {
        auto const& g = map.gaussians[row];
        for (std::size_t i = 0; i < 3; ++i) {
            if (moved) detail::put_number<std::uint64_t>(out, double{g.mean_world[i]} + map.origin[i]);
            else put(g.mean_world[i]);
        }
        for (float const c : g.colour) put(static_cast<float>((double{c} - 0.5) / 0.28209479)); // as the reader has it
        for (std::size_t channel = 0; channel < 3; ++channel)
            for (std::size_t k = 0; k < of_channel; ++k) put(map.harmonics[row * 3 * of_channel + 3 * k + channel]);
        put(detail::logit_of(g.opacity));
        for (float const s : g.log_scale) put(s);
        for (float const q : g.rotation) put(q);
    }
    return out;
}

}}} // namespace tilemesh::scene
