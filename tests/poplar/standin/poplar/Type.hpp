#pragma once
#include "exceptions.hpp"
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>

/// Part of a stand-in for the Poplar SDK: element types.
namespace poplar {

/// The type of a tensor's elements.
class Type {
public:
    enum class Code : unsigned char { boolean, i8, u8, i16, u16, i32, u32, i64, u64, f8, f16, f32 };

    constexpr Type() noexcept = default;
    constexpr Type(Code code) noexcept : code_(code) {}
    constexpr Code code() const noexcept { return code_; }

    /// The name of the type in the C++ of a codelet.
    std::string toString() const
    {
        static constexpr char const* names[] = {"bool",         "signed char",    "unsigned char",
                                                "short",        "unsigned short", "int",
                                                "unsigned int", "long long",      "unsigned long long",
                                                "quarter",      "half",           "float"};
        return names[static_cast<unsigned>(code_)];
    }

    friend constexpr bool operator==(Type a, Type b) noexcept { return a.code_ == b.code_; }
    friend constexpr bool operator!=(Type a, Type b) noexcept { return a.code_ != b.code_; }

private:
    Code code_ = Code::u32;
};

inline constexpr Type BOOL{Type::Code::boolean};
inline constexpr Type SIGNED_CHAR{Type::Code::i8};
inline constexpr Type CHAR{Type::Code::i8};
inline constexpr Type UNSIGNED_CHAR{Type::Code::u8};
inline constexpr Type SHORT{Type::Code::i16};
inline constexpr Type UNSIGNED_SHORT{Type::Code::u16};
inline constexpr Type INT{Type::Code::i32};
inline constexpr Type UNSIGNED_INT{Type::Code::u32};
inline constexpr Type LONGLONG{Type::Code::i64};
inline constexpr Type UNSIGNED_LONGLONG{Type::Code::u64};
inline constexpr Type QUARTER{Type::Code::f8};
inline constexpr Type HALF{Type::Code::f16};
inline constexpr Type FLOAT{Type::Code::f32};

} // namespace poplar

namespace standin::detail {

constexpr std::size_t element_bytes(poplar::Type type) noexcept
{
    constexpr std::size_t bytes[] = {1, 1, 1, 2, 2, 4, 4, 8, 8, 1, 2, 4};
    return bytes[static_cast<unsigned>(type.code())];
}

/// The type of a codelet's field with the type name `name`. Throws if tensors have no such type.
inline poplar::Type type_named(std::string_view name)
{
    using Code = poplar::Type::Code;
    struct Name {
        std::string_view name;
        Code code;
    };
    static constexpr Name names[] = {{"bool", Code::boolean},
                                     {"char", Code::i8},
                                     {"signed char", Code::i8},
                                     {"unsigned char", Code::u8},
                                     {"short", Code::i16},
                                     {"unsigned short", Code::u16},
                                     {"int", Code::i32},
                                     {"unsigned", Code::u32},
                                     {"unsigned int", Code::u32},
                                     {"long long", Code::i64},
                                     {"unsigned long long", Code::u64},
                                     {"quarter", Code::f8},
                                     {"half", Code::f16},
                                     {"float", Code::f32}};
    for (Name const& n : names)
        if (n.name == name) return n.code;
    throw poplar::type_error("No tensor has elements of type " + std::string(name) +
                             " (a field has); use one of Poplar's types");
}

/// The bits of the half nearest to a float, ties to even. Overflow gives infinity.
inline std::uint16_t half_bits(float value) noexcept
{
    std::uint32_t bits;
    std::memcpy(&bits, &value, 4);
    auto const sign = static_cast<std::uint16_t>(bits >> 16 & 0x8000u);
    std::uint32_t const magnitude = bits & 0x7fffffffu;
    auto const signed_half = [sign](std::uint32_t half) { return static_cast<std::uint16_t>(sign | half); };
    if (magnitude > 0x7f800000u) return signed_half(0x7e00u);  // NaN
    if (magnitude >= 0x477ff000u) return signed_half(0x7c00u); // rounds beyond 65504
    std::uint32_t const exponent = magnitude >> 23;
    if (exponent < 102) return signed_half(0); // below half of the least half, 2^-25
    std::uint32_t const fraction = (magnitude & 0x7fffffu) | 0x800000u;
    bool const normal = exponent >= 113;
    std::uint32_t const drop = normal ? 13u : 126u - exponent;
    std::uint32_t half = (normal ? (exponent - 113) << 10 : 0u) + (fraction >> drop);
    std::uint32_t const rest = fraction & ((1u << drop) - 1), middle = 1u << (drop - 1);
    half += rest > middle || (rest == middle && (half & 1u)) ? 1u : 0u;
    return signed_half(half);
}

/// Writes `value` to `at` as an element of `type`. Throws if an integer does not fit.
template <class T>
void store_element(poplar::Type type, T value, unsigned char* at)
{
    static_assert(std::is_arithmetic_v<T>);
    auto const put = [&](auto as) {
        using To = decltype(as);
        auto const converted = static_cast<To>(value);
        if constexpr (std::is_integral_v<To> && std::is_integral_v<T>) {
            if (static_cast<T>(converted) != value || (converted < To{}) != (value < T{}))
                throw poplar::type_error("The value " + std::to_string(value) + " is no " + type.toString() +
                                         " (it does not fit); give one that does");
        }
        std::memcpy(at, &converted, sizeof converted);
    };
    using Code = poplar::Type::Code;
    switch (type.code()) {
    case Code::boolean:
        put(bool{});
        break;
    case Code::i8:
        put(std::int8_t{});
        break;
    case Code::u8:
        put(std::uint8_t{});
        break;
    case Code::i16:
        put(std::int16_t{});
        break;
    case Code::u16:
        put(std::uint16_t{});
        break;
    case Code::i32:
        put(std::int32_t{});
        break;
    case Code::u32:
        put(std::uint32_t{});
        break;
    case Code::i64:
        put(std::int64_t{});
        break;
    case Code::u64:
        put(std::uint64_t{});
        break;
    case Code::f32:
        put(float{});
        break;
    case Code::f8:
        throw poplar::type_error(
            "A quarter has no value of its own (its scale is apart from it); write its bytes from the device");
    case Code::f16: {
        std::uint16_t const bits = half_bits(static_cast<float>(value));
        std::memcpy(at, &bits, 2);
        break;
    }
    }
}

} // namespace standin::detail
