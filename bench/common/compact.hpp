#pragma once
#include <cmath>
#include <cstdint>
#include <tilemesh/splat/gaussian.hpp>
#include <type_traits>

/// Records of 32 and of 16 bytes, for storage and messages: half the bytes of `Gaussian`, or a quarter. A tile computes with floats after
/// unpacking. `try_pack` refuses what it cannot represent; all else is rounded, as far as each member says. It is a lossy form. No
/// setup of the library stores it; those of packed_record.hpp do.
TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// What all records of 16 bytes share: the cube in which the means lie, and the range of the scales. `CompactBox::of` makes it for a map.
struct CompactBox {
    float origin[3], mean_step;         ///< world units
    float least_log_scale, scale_step;  ///< natural logarithms

    static constexpr std::uint32_t mean_levels = (1u << 15) - 1, scale_levels = (1u << 6) - 1;
    /// The box of n records; a box of one point and one scale for none.
    template <class Record>
    static CompactBox of(Record const* records, std::uint32_t n) noexcept
    {
        CompactBox box{{0, 0, 0}, 1, 0, 1};
        float high[3] = {0, 0, 0}, largest = 0;
        for (std::uint32_t i = 0; i < n; ++i)
            for (std::uint32_t k = 0; k < 3; ++k) {
                float const m = records[i].mean_world[k], s = records[i].log_scale[k];
                if (i == 0 || m < box.origin[k]) box.origin[k] = m;
                if (i == 0 || m > high[k]) high[k] = m;
                bool const first = i == 0 && k == 0;
                if (first || s < box.least_log_scale) box.least_log_scale = s;
                if (first || s > largest) largest = s;
            }
        float side = 0;
        for (std::uint32_t k = 0; k < 3; ++k) side = high[k] - box.origin[k] > side ? high[k] - box.origin[k] : side;
        if (side > 0) box.mean_step = side / static_cast<float>(mean_levels);
        // A Gaussian of e^-12 world units is a point on every picture.
        if (box.least_log_scale < -12 && largest > -12) box.least_log_scale = -12;
        if (largest > box.least_log_scale) box.scale_step = (largest - box.least_log_scale) / static_cast<float>(scale_levels);
        return box;
    }
};

/// 32 bytes: the mean is exact; the colour has three halves (up to 65,504), the opacity 16 bits, the rotation 32 (its three smaller
/// components, 10 bits each), the scales 11, 11 and 10 bits of e^-12 to e^8. Smaller scales become e^-12.
struct Compact32 {
    static constexpr std::uint32_t sh_degree = 0;
    GaussianId id;
    std::uint32_t words[7];
};
/// 16 bytes: the mean has 15 bits an axis of the box's cube, the id 24, the colour 7 bits a channel (of its root, up to 4), the opacity 7,
/// the rotation 13, the scales 6 bits each of the box's range.
struct Compact16 {
    static constexpr std::uint32_t sh_degree = 0;
    GaussianId id : 24;
    std::uint8_t first; ///< the low bits of the mean
    std::uint32_t words[3];
};
static_assert(sizeof(Compact32) == 32 && sizeof(Compact16) == 16 && std::is_trivially_copyable_v<Compact32>);

namespace detail {
/// The nearest half, as its bits; ties to even. A larger number becomes the largest half. Requires a number that is not NaN.
inline std::uint32_t half_bits(float v) noexcept
{
    std::uint32_t const bits = __builtin_bit_cast(std::uint32_t, v), sign = bits >> 16 & 0x8000u, magnitude = bits & 0x7fffffffu;
    if (magnitude >= 0x477fe000u) return sign | 0x7bffu; // 65,504
    if (magnitude < 0x38800000u) {                       // below 2^-14: a multiple of 2^-24
        float const scaled = std::fabs(v) * 16777216.0f;
        auto n = static_cast<std::uint32_t>(scaled);
        float const rest = scaled - static_cast<float>(n);
        n += rest > 0.5f || (rest == 0.5f && (n & 1u) != 0) ? 1 : 0;
        return sign | n;
    }
    std::uint32_t const rounded = magnitude + 0xfffu + (magnitude >> 13 & 1u);
    return sign | ((rounded - 0x38000000u) >> 13);
}
inline float half_value(std::uint32_t bits) noexcept
{
    std::uint32_t const sign = (bits & 0x8000u) << 16, exponent = bits >> 10 & 31u, fraction = bits & 0x3ffu;
    if (exponent == 0) {
        float const v = static_cast<float>(fraction) / 16777216.0f;
        return sign != 0 ? -v : v;
    }
    return __builtin_bit_cast(float, sign | ((exponent + 112u) << 23) | fraction << 13);
}
/// The nearest of the levels 0 to `levels` for v from 0 to 1; beyond that, the last one.
inline std::uint32_t level_of(float v, std::uint32_t levels) noexcept
{
    if (!(v > 0)) return 0;
    return v < 1 ? static_cast<std::uint32_t>(v * static_cast<float>(levels) + 0.5f) : levels;
}
inline float of_level(std::uint32_t level, std::uint32_t levels) noexcept { return static_cast<float>(level) / static_cast<float>(levels); }

/// Numbers of a few bits, one after the other in words.
template <std::uint32_t Words>
class Bits {
public:
    explicit Bits(std::uint32_t (&words)[Words]) noexcept : words_(&words) {}
    void put(std::uint32_t value, std::uint32_t bits) noexcept
    {
        std::uint32_t const at = at_ % 32, word = at_ / 32;
        (*words_)[word] |= value << at;
        if (at + bits > 32) (*words_)[word + 1] |= value >> (32 - at);
        at_ += bits;
    }
    std::uint32_t get(std::uint32_t bits) noexcept
    {
        std::uint32_t const at = at_ % 32, word = at_ / 32;
        std::uint32_t value = (*words_)[word] >> at;
        if (at + bits > 32) value |= (*words_)[word + 1] << (32 - at);
        at_ += bits;
        return bits == 32 ? value : value & ((1u << bits) - 1);
    }

private:
    std::uint32_t (*words_)[Words];
    std::uint32_t at_ = 0;
};

inline bool is_finite(float v) noexcept { return (__builtin_bit_cast(std::uint32_t, v) & 0x7f800000u) != 0x7f800000u; }
/// Are all numbers of the record finite, and has its quaternion a length whose square is one?
inline bool can_pack(Gaussian const& g) noexcept
{
    bool all = is_finite(g.opacity);
    for (float v : g.mean_world) all = all && is_finite(v);
    for (float v : g.colour) all = all && is_finite(v);
    for (float v : g.log_scale) all = all && is_finite(v);
    float length2 = 0;
    for (float v : g.rotation) length2 += v * v;
    return all && is_finite(length2) && length2 > 1e-30f;
}
/// The components of a quaternion besides component `left_out`, times `scale`, with their bits each.
template <std::uint32_t Words>
void put_others(Bits<Words>& bits, float const (&rotation)[4], std::uint32_t const (&each)[3], std::uint32_t left_out, float scale) noexcept
{
    bits.put(left_out, 2);
    for (std::uint32_t i = 0, k = 0; i < 4; ++i) // -1 / sqrt(2) to 1 / sqrt(2), with a level at 0
        if (i != left_out) {
            std::uint32_t const levels = (1u << each[k]) - 2;
            bits.put(level_of(rotation[i] * scale * 0.70710678f + 0.5f, levels), each[k]);
            ++k;
        }
}
/// The three smaller components of a unit quaternion, with their bits each, and which one is the largest.
template <std::uint32_t Words>
void put_rotation(Bits<Words>& bits, float const (&rotation)[4], std::uint32_t const (&each)[3]) noexcept
{
    float length2 = 0;
    std::uint32_t largest = 0;
    for (std::uint32_t i = 0; i < 4; ++i) {
        length2 += rotation[i] * rotation[i];
        if (std::fabs(rotation[i]) > std::fabs(rotation[largest])) largest = i;
    }
    put_others(bits, rotation, each, largest, (rotation[largest] < 0 ? -1.0f : 1.0f) / std::sqrt(length2));
}
template <std::uint32_t Words>
void get_rotation(Bits<Words>& bits, float (&rotation)[4], std::uint32_t const (&each)[3]) noexcept
{
    std::uint32_t const largest = bits.get(2);
    float rest = 1;
    for (std::uint32_t i = 0, k = 0; i < 4; ++i)
        if (i != largest) {
            std::uint32_t const levels = (1u << each[k]) - 2;
            rotation[i] = (of_level(bits.get(each[k]), levels) - 0.5f) * 1.41421356f;
            rest -= rotation[i] * rotation[i];
            ++k;
        }
    rotation[largest] = std::sqrt(rest > 0 ? rest : 0.0f);
}
/// The bits of 32 bytes, and those of 16.
struct HalfLayout {
    static constexpr std::uint32_t rotation[3] = {10, 10, 10}, scale[3] = {11, 11, 10};
    static constexpr float lowest_scale = -12, highest_scale = 8;
};
struct QuarterLayout {
    static constexpr std::uint32_t rotation[3] = {4, 4, 3};
};
} // namespace detail

namespace detail {
/// Writes the bits of a record. `put(bits, each)` writes those of its rotation.
template <class Put>
void fill(Gaussian const& g, Compact32& to, Put const& put) noexcept
{
    to = {};
    to.id = g.id;
    Bits<7> bits(to.words);
    for (float v : g.mean_world) bits.put(__builtin_bit_cast(std::uint32_t, v), 32);
    for (float v : g.colour) bits.put(half_bits(v), 16);
    bits.put(level_of(g.opacity, 65535), 16);
    put(bits, HalfLayout::rotation);
    for (std::uint32_t k = 0; k < 3; ++k) {
        using Layout = HalfLayout;
        float const share = (g.log_scale[k] - Layout::lowest_scale) / (Layout::highest_scale - Layout::lowest_scale);
        bits.put(level_of(share, (1u << Layout::scale[k]) - 1), Layout::scale[k]);
    }
}
/// A mean's or a scale's share of the range of the box.
inline float share_of_mean(Gaussian const& g, CompactBox const& box, std::uint32_t k) noexcept
{
    return (g.mean_world[k] - box.origin[k]) / (box.mean_step * static_cast<float>(CompactBox::mean_levels));
}
inline float share_of_scale(Gaussian const& g, CompactBox const& box, std::uint32_t k) noexcept
{
    return (g.log_scale[k] - box.least_log_scale) / (box.scale_step * static_cast<float>(CompactBox::scale_levels));
}
template <class Put>
void fill(Gaussian const& g, CompactBox const& box, Compact16& to, Put const& put) noexcept
{
    std::uint32_t words[4] = {};
    Bits<4> bits(words);
    bits.put(static_cast<std::uint32_t>(g.id), 24);
    for (std::uint32_t k = 0; k < 3; ++k) bits.put(level_of(share_of_mean(g, box, k), CompactBox::mean_levels), 15);
    for (float v : g.colour) bits.put(v > 0 ? level_of(std::sqrt(v) * 0.5f, 127) : 0, 7);
    bits.put(level_of(g.opacity, 127), 7);
    for (std::uint32_t k = 0; k < 3; ++k) bits.put(level_of(share_of_scale(g, box, k), CompactBox::scale_levels), 6);
    put(bits, QuarterLayout::rotation);
    to.id = static_cast<GaussianId>(words[0] & 0xffffffu);
    to.first = static_cast<std::uint8_t>(words[0] >> 24);
    for (std::uint32_t i = 0; i < 3; ++i) to.words[i] = words[i + 1];
}
/// Of the four records that leave out another component of the rotation each, the one that unpacks to the bits of g.
template <class Fill, class Unpack>
bool try_all_rotations(Gaussian const& g, Fill const& fill_with, Unpack const& unpack) noexcept
{
    for (std::uint32_t left_out = 0; left_out < 4; ++left_out) {
        fill_with([&](auto& bits, auto const& each) noexcept { put_others(bits, g.rotation, each, left_out, 1.0f); });
        Gaussian const back = unpack();
        if (__builtin_memcmp(&back, &g, sizeof g) == 0) return true;
    }
    return false;
}
} // namespace detail

/// Packs a record. False, and no record, if one of its numbers is not finite, its quaternion has no length, or a scale is above e^8.
[[nodiscard]] inline bool try_pack(Gaussian const& g, Compact32& to) noexcept
{
    if (!detail::can_pack(g)) return false;
    for (float s : g.log_scale)
        if (s > detail::HalfLayout::highest_scale) return false;
    detail::fill(g, to, [&](auto& bits, auto const& each) noexcept { detail::put_rotation(bits, g.rotation, each); });
    return true;
}
inline Gaussian unpacked(Compact32 from) noexcept
{
    Gaussian g{};
    detail::Bits<7> bits(from.words);
    g.id = from.id;
    for (float& v : g.mean_world) v = __builtin_bit_cast(float, bits.get(32));
    for (float& v : g.colour) v = detail::half_value(bits.get(16));
    g.opacity = detail::of_level(bits.get(16), 65535);
    detail::get_rotation(bits, g.rotation, detail::HalfLayout::rotation);
    for (std::uint32_t k = 0; k < 3; ++k) {
        using Layout = detail::HalfLayout;
        float const share = detail::of_level(bits.get(Layout::scale[k]), (1u << Layout::scale[k]) - 1);
        g.log_scale[k] = Layout::lowest_scale + share * (Layout::highest_scale - Layout::lowest_scale);
    }
    return g;
}

/// Packs a record. False, and no record, if one of its numbers is not finite, its quaternion has no length, its id has more than 24
/// bits, or it is not in the box.
[[nodiscard]] inline bool try_pack(Gaussian const& g, CompactBox const& box, Compact16& to) noexcept
{
    if (!detail::can_pack(g) || static_cast<std::uint32_t>(g.id) >> 24 != 0) return false;
    for (std::uint32_t k = 0; k < 3; ++k) {
        float const mean = detail::share_of_mean(g, box, k);
        if (!(mean >= -1e-5f && mean <= 1.00001f && detail::share_of_scale(g, box, k) <= 1.00001f)) return false;
    }
    detail::fill(g, box, to, [&](auto& bits, auto const& each) noexcept { detail::put_rotation(bits, g.rotation, each); });
    return true;
}
inline Gaussian unpacked(Compact16 from, CompactBox const& box) noexcept
{
    Gaussian g{};
    std::uint32_t words[4] = {static_cast<std::uint32_t>(from.id) | std::uint32_t{from.first} << 24};
    for (std::uint32_t i = 0; i < 3; ++i) words[i + 1] = from.words[i];
    detail::Bits<4> bits(words);
    g.id = static_cast<GaussianId>(bits.get(24));
    for (std::uint32_t k = 0; k < 3; ++k) g.mean_world[k] = box.origin[k] + box.mean_step * static_cast<float>(bits.get(15));
    for (float& v : g.colour) {
        float const root = 2 * detail::of_level(bits.get(7), 127);
        v = root * root;
    }
    g.opacity = detail::of_level(bits.get(7), 127);
    for (float& v : g.log_scale) v = box.least_log_scale + box.scale_step * static_cast<float>(bits.get(6));
    detail::get_rotation(bits, g.rotation, detail::QuarterLayout::rotation);
    return g;
}

/// Packs a record that was unpacked, so that it unpacks to the same bits. `try_pack` does not promise this: rounding may make another
/// component of a rotation the largest. False if the record was never packed.
[[nodiscard]] inline bool try_pack_again(Gaussian const& g, Compact32& to) noexcept
{
    return detail::try_all_rotations(g, [&](auto const& put) noexcept { detail::fill(g, to, put); },
                                     [&]() noexcept { return unpacked(to); });
}
[[nodiscard]] inline bool try_pack_again(Gaussian const& g, CompactBox const& box, Compact16& to) noexcept
{
    return detail::try_all_rotations(g, [&](auto const& put) noexcept { detail::fill(g, box, to, put); },
                                     [&]() noexcept { return unpacked(to, box); });
}

}}} // namespace tilemesh::splat
TILEMESH_EXACT_END
