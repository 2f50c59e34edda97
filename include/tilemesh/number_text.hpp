#pragma once
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string_view>
#include <system_error>
#include <tilemesh/config.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 {
namespace detail {

inline bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }

/// Does [first, last) begin with this word? `word` has lower-case letters; the text may have letters of either case.
inline bool begins_with(char const* first, char const* last, std::string_view word) noexcept
{
    return static_cast<std::size_t>(last - first) >= word.size() &&
           std::equal(word.begin(), word.end(), first, [](char w, char c) { return w == (c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
}

/// Returns the end of "inf", "infinity", "nan" or "nan(letters, digits and _)" at the beginning of [first, last), or `first` if there is no
/// such word.
inline char const* end_of_word(char const* first, char const* last) noexcept
{
    if (begins_with(first, last, "infinity")) return first + 8;
    if (begins_with(first, last, "inf")) return first + 3;
    if (!begins_with(first, last, "nan")) return first;
    auto const word = [](char c) { return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
    first += 3;
    if (first == last || *first != '(') return first;
    auto const end = std::find_if_not(first + 1, last, word);
    return end != last && *end == ')' ? end + 1 : first;
}

/// std::from_chars(first, last, value) for float and double with std::chars_format::general, implemented with std::strtof and std::strtod.
/// It accepts the same texts, and returns the same end and the same errors. If there is an error, `value` does not change.
///
/// The result does not depend on the locale: std::strtod gets digits and an exponent, without a decimal point. The result is correctly
/// rounded if the C library's strtod is (glibc, musl, macOS). It allocates nothing, for a text of any length.
template <class T>
std::from_chars_result read_floating(char const* const first, char const* const last, T& value) noexcept
{
    static_assert(std::is_same_v<T, float> || std::is_same_v<T, double>);
    bool const negative = first != last && *first == '-';
    auto at = first + (negative ? 1 : 0);
    if (auto const end = end_of_word(at, last); end != at) {
        bool const infinite = *at == 'i' || *at == 'I';
        auto const size = infinite ? std::numeric_limits<T>::infinity() : std::numeric_limits<T>::quiet_NaN();
        value = std::copysign(size, negative ? T{-1} : T{1});
        return {end, std::errc{}};
    }

    // A double, and the point half-way to the next double, have at most 768 significant digits. Of the later digits, it only matters
    // whether one is not 0: one more digit records that.
    constexpr std::size_t most_digits = 768;
    std::array<char, most_digits + 1 + 24> text{}; // 24: a sign, "e", the exponent and the end
    std::size_t size = 0, digits = 0;
    if (negative) text[size++] = '-';
    std::int64_t exponent = 0; // of the last digit in `text`
    bool any_digit = false, point = false, more = false;
    for (; at != last; ++at) {
        if (*at == '.' && !point) {
            point = true;
            continue;
        }
        if (!is_digit(*at)) break;
        any_digit = true;
        if (point) --exponent;
        if (digits == 0 && *at == '0') continue;
        if (digits < most_digits) {
            text[size++] = *at;
            ++digits;
        } else {
            ++exponent;
            more = more || *at != '0';
        }
    }
    if (!any_digit) return {first, std::errc::invalid_argument};

    if (at != last && (*at == 'e' || *at == 'E')) {
        auto digit = at + 1;
        bool const below_one = digit != last && *digit == '-';
        if (digit != last && (*digit == '-' || *digit == '+')) ++digit;
        if (digit != last && is_digit(*digit)) {
            std::int64_t written = 0;
            for (; digit != last && is_digit(*digit); ++digit)
                written = std::min(written * 10 + (*digit - '0'), std::int64_t{1'000'000'000'000'000});
            exponent += below_one ? -written : written;
            at = digit;
        }
    }
    if (digits == 0) {
        value = negative ? -T{} : T{};
        return {at, std::errc{}};
    }
    if (more) {
        text[size++] = '1';
        --exponent;
    }
    text[size++] = 'e';
    exponent = std::clamp<std::int64_t>(exponent, -99999, 99999); // far beyond every double, for any number of digits
    *std::to_chars(text.data() + size, text.data() + text.size() - 1, exponent).ptr = '\0';

    auto const caller_errno = errno;
    T const read = std::is_same_v<T, float> ? static_cast<T>(std::strtof(text.data(), nullptr))
                                            : static_cast<T>(std::strtod(text.data(), nullptr));
    errno = caller_errno;
    if (std::isinf(read) || read == T{}) return {at, std::errc::result_out_of_range};
    value = read;
    return {at, std::errc{}};
}

} // namespace detail

/// std::from_chars(first, last, value) for any integer type, float and double. It also works with a standard library whose std::from_chars
/// takes integers only (libc++ 16).
template <class T>
std::from_chars_result read_number(char const* first, char const* last, T& value) noexcept
{
#if defined(__cpp_lib_to_chars) && __cpp_lib_to_chars >= 201611L
    return std::from_chars(first, last, value);
#else
    if constexpr (std::is_floating_point_v<T>)
        return detail::read_floating(first, last, value);
    else
        return std::from_chars(first, last, value);
#endif
}

}} // namespace tilemesh
