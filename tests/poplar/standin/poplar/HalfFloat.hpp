// A stand-in for the header of the same name in the Poplar SDK: IEEE half precision in software, because not all host
// compilers have such a type. On an IPU `half` is a built-in type, and its arithmetic may round in another way if several
// operations fuse.
#pragma once
#include <cstdint>
#include <type_traits>

namespace standin {

/// The bits of the half nearest to a float, ties to even. Overflow gives infinity. A NaN gives a quiet NaN.
constexpr std::uint16_t half_bits(float value)
{
    std::uint32_t const word = __builtin_bit_cast(std::uint32_t, value);
    std::uint32_t const sign = (word >> 16) & 0x8000u;
    std::uint32_t const magnitude = word & 0x7fffffffu;
    if (magnitude > 0x7f800000u) return static_cast<std::uint16_t>(sign | 0x7e00u);
    if (magnitude >= 0x47800000u) return static_cast<std::uint16_t>(sign | 0x7c00u); // 65,536 and above
    if (magnitude < 0x33000000u) return static_cast<std::uint16_t>(sign);            // below half of the least half, 2^-25
    // A normal half drops 13 bits of the fraction. A subnormal half (below 2^-14) drops one more bit for each power of two.
    std::uint32_t const exponent = magnitude >> 23;
    bool const normal = exponent >= 113;
    std::uint32_t const kept = normal ? magnitude - (112u << 23) : (magnitude & 0x7fffffu) | 0x800000u;
    std::uint32_t const drop = normal ? 13 : 126 - exponent;
    std::uint32_t const rest = kept & ((1u << drop) - 1);
    std::uint32_t const tie = 1u << (drop - 1);
    std::uint32_t bits = kept >> drop;
    if (rest > tie || (rest == tie && (bits & 1u))) ++bits; // a carry correctly moves into the exponent, up to infinity
    return static_cast<std::uint16_t>(sign | bits);
}

/// The float with exactly the value of a half.
constexpr float half_value(std::uint16_t bits)
{
    std::uint32_t const sign = static_cast<std::uint32_t>(bits & 0x8000u) << 16;
    std::uint32_t const magnitude = bits & 0x7fffu;
    if (magnitude >= 0x7c00u) return __builtin_bit_cast(float, sign | 0x7f800000u | (magnitude & 0x3ffu) << 13);
    if (magnitude >= 0x0400u) return __builtin_bit_cast(float, sign | ((magnitude << 13) + (112u << 23)));
    float const small = static_cast<float>(magnitude) * 0x1p-24f; // a subnormal half is a multiple of the least half
    return sign ? -small : small;
}

} // namespace standin

/// A 16-bit float. Operations on two halves, or on a half and an integer, give a half, rounded once. Operations with a float
/// give a float.
class half {
public:
    half() = default;
    template <class T, class = std::enable_if_t<std::is_arithmetic_v<T>>>
    constexpr half(T value) : bits_(standin::half_bits(static_cast<float>(value)))
    {}
    constexpr operator float() const { return standin::half_value(bits_); }

    template <class T>
    constexpr half& operator+=(T b)
    {
        return *this = half(static_cast<float>(*this) + static_cast<float>(b));
    }
    template <class T>
    constexpr half& operator-=(T b)
    {
        return *this = half(static_cast<float>(*this) - static_cast<float>(b));
    }
    template <class T>
    constexpr half& operator*=(T b)
    {
        return *this = half(static_cast<float>(*this) * static_cast<float>(b));
    }
    template <class T>
    constexpr half& operator/=(T b)
    {
        return *this = half(static_cast<float>(*this) / static_cast<float>(b));
    }
    constexpr half operator-() const { return half(-static_cast<float>(*this)); }

private:
    std::uint16_t bits_;
};
static_assert(sizeof(half) == 2 && std::is_trivial_v<half>);

namespace standin {
/// Two operands whose result is a half: at least one half, and no float.
template <class A, class B>
using IfHalf = std::enable_if_t<(std::is_same_v<A, half> && (std::is_same_v<B, half> || std::is_integral_v<B>)) ||
                                    (std::is_integral_v<A> && std::is_same_v<B, half>),
                                half>;
} // namespace standin

template <class A, class B>
constexpr standin::IfHalf<A, B> operator+(A a, B b)
{
    return half(static_cast<float>(a) + static_cast<float>(b));
}
template <class A, class B>
constexpr standin::IfHalf<A, B> operator-(A a, B b)
{
    return half(static_cast<float>(a) - static_cast<float>(b));
}
template <class A, class B>
constexpr standin::IfHalf<A, B> operator*(A a, B b)
{
    return half(static_cast<float>(a) * static_cast<float>(b));
}
template <class A, class B>
constexpr standin::IfHalf<A, B> operator/(A a, B b)
{
    return half(static_cast<float>(a) / static_cast<float>(b));
}

/// Literals such as `0.5_h`.
constexpr half operator""_h(long double value)
{
    return half(static_cast<float>(value));
}
