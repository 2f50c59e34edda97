#pragma once
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
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

/// Writes a finite number as std::snprintf with `form` ("%.*f" or "%.*g") and `digits` does in the C locale. The locale of the program
/// changes nothing: whatever stands between the digits before and after the point is replaced by a point. Fails with `value_too_large` if
/// the text has more than 1,100 characters or does not fit.
inline std::to_chars_result write_as_printf(char* first, char* last, char const* form, int digits, double value) noexcept
{
    std::array<char, 1200> text{}; // a double has at most 309 digits before the point
    auto const written = std::snprintf(text.data(), text.size(), form, digits, value);
    std::size_t size = 0;
    bool between = false;
    for (int i = 0; i < written && written < static_cast<int>(text.size()); ++i) {
        char const c = text[static_cast<std::size_t>(i)];
        if (is_digit(c) || c == '-' || c == '+' || c == 'e') {
            between = false;
            text[size++] = c;
        } else if (!between) { // a decimal point of any locale, which may have several bytes
            between = true;
            text[size++] = '.';
        }
    }
    if (size == 0 || size > static_cast<std::size_t>(last - first)) return {last, std::errc::value_too_large};
    std::memcpy(first, text.data(), size);
    return {first + size, std::errc{}};
}

/// std::to_chars(first, last, value), implemented with std::snprintf: the shortest text from which `read_floating` reads the same double.
/// Of the form with an exponent and the form without, it takes the shorter one, and without an exponent if both have one length.
inline std::to_chars_result write_shortest(char* first, char* last, double value) noexcept
{
    std::array<char, 64> text{};
    auto const put = [&](char const* from, std::size_t size) -> std::to_chars_result {
        if (size > static_cast<std::size_t>(last - first)) return {last, std::errc::value_too_large};
        std::memcpy(first, from, size);
        return {first + size, std::errc{}};
    };
    if (!std::isfinite(value)) {
        char const* const word = std::isnan(value) ? (std::signbit(value) ? "-nan" : "nan") : value < 0 ? "-inf" : "inf";
        return put(word, std::strlen(word));
    }
    // The digits and the exponent of the first digit: "-1.2345e+06" without its sign and its point. The last digit of the shortest text is not
    // 0, unless it is the only one.
    bool const negative = std::signbit(value);
    std::array<char, 24> digits{};
    std::size_t count = 0;
    int exponent = 0;
    for (int precision = 0; precision < 17; ++precision) {
        auto const size = std::snprintf(text.data(), text.size(), "%.*e", precision, std::fabs(value));
        char const* const end = text.data() + size;
        char const* const e = std::find(static_cast<char const*>(text.data()), end, 'e');
        count = 0;
        for (char const* c = text.data(); c != e; ++c)
            if (is_digit(*c)) digits[count++] = *c;
        exponent = 0;
        for (char const* c = e + 2; c != end; ++c) exponent = exponent * 10 + (*c - '0');
        if (e[1] == '-') exponent = -exponent;
        std::array<char, 48> plain{}; // digits and an exponent, which `read_floating` reads in any locale
        std::memcpy(plain.data(), digits.data(), count);
        plain[count] = 'e';
        auto const plain_end = std::to_chars(plain.data() + count + 1, plain.data() + plain.size(), exponent - precision).ptr;
        double read = 0;
        read_floating(plain.data(), plain_end, read);
        if (read == std::fabs(value)) break;
    }

    auto const magnitude = static_cast<std::size_t>(exponent < 0 ? -exponent : exponent);
    std::size_t const with_exponent = count + (count > 1 ? 1u : 0u) + 2 + (magnitude >= 100 ? 3u : 2u);
    std::size_t const plainly = exponent < 0                  ? magnitude + 1 + count
                                : magnitude + 1 >= count ? magnitude + 1
                                                         : count + 1;
    std::size_t size = 0;
    if (negative) text[size++] = '-';
    if (plainly > with_exponent) {
        text[size++] = digits[0];
        if (count > 1) text[size++] = '.';
        for (std::size_t i = 1; i < count; ++i) text[size++] = digits[i];
        text[size++] = 'e';
        text[size++] = exponent < 0 ? '-' : '+';
        if (magnitude < 10) text[size++] = '0';
        size = static_cast<std::size_t>(std::to_chars(text.data() + size, text.data() + text.size(), magnitude).ptr - text.data());
        return put(text.data(), size);
    }
    if (exponent >= 0 && magnitude + 1 >= count) return write_as_printf(first, last, "%.*f", 0, value); // an integer, with all its digits
    if (exponent < 0) {
        text[size++] = '0';
        text[size++] = '.';
        for (std::size_t i = 1; i < magnitude; ++i) text[size++] = '0';
    }
    for (std::size_t i = 0; i < count; ++i) {
        text[size++] = digits[i];
        if (exponent >= 0 && i == magnitude) text[size++] = '.';
    }
    return put(text.data(), size);
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

/// All of `text` as a number, as `read_number` reads it; nothing if it is no number, or out of the range of T.
template <class T>
std::optional<T> number_of(std::string_view text) noexcept
{
    T value{};
    auto const [end, error] = read_number(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size() ? std::optional<T>(value) : std::nullopt;
}

/// std::to_chars(first, last, value): the shortest text that reads back as this number. It also works with a standard library whose
/// std::to_chars takes integers only.
inline std::to_chars_result write_number(char* first, char* last, double value) noexcept
{
#if defined(__cpp_lib_to_chars) && __cpp_lib_to_chars >= 201611L
    return std::to_chars(first, last, value);
#else
    return detail::write_shortest(first, last, value);
#endif
}
/// std::to_chars(first, last, value, std::chars_format::fixed, digits) for a finite number: with `digits` digits after the point.
inline std::to_chars_result write_fixed(char* first, char* last, double value, int digits) noexcept
{
#if defined(__cpp_lib_to_chars) && __cpp_lib_to_chars >= 201611L
    return std::to_chars(first, last, value, std::chars_format::fixed, digits);
#else
    return detail::write_as_printf(first, last, "%.*f", digits, value);
#endif
}
/// std::to_chars(first, last, value, std::chars_format::general, digits) for a finite number: with `digits` significant digits.
inline std::to_chars_result write_general(char* first, char* last, double value, int digits) noexcept
{
#if defined(__cpp_lib_to_chars) && __cpp_lib_to_chars >= 201611L
    return std::to_chars(first, last, value, std::chars_format::general, digits);
#else
    return detail::write_as_printf(first, last, "%.*g", digits, value);
#endif
}

namespace detail {
/// The text that `write(begin, end)` writes for a finite number; "inf", "-inf" or "NaN" for any other.
template <class Write>
std::string text_of_number(double value, Write const& write)
{
    if (!std::isfinite(value)) return std::isnan(value) ? "NaN" : value > 0 ? "inf" : "-inf";
    std::array<char, 400> text{}; // a double has at most 309 digits before the point
    return {text.data(), write(text.data(), text.data() + text.size()).ptr};
}
} // namespace detail

/// The text of a number, independent of the locale: the shortest that reads back as this number; with `digits` digits after the
/// point, at most 80; with at most `digits` significant digits. A number that is not finite is "inf", "-inf" or "NaN".
inline std::string number_text(double value)
{
    return detail::text_of_number(value, [&](char* first, char* last) { return write_number(first, last, value); });
}
inline std::string decimals(double value, int digits)
{
    return detail::text_of_number(value, [&](char* first, char* last) { return write_fixed(first, last, value, digits); });
}
inline std::string significant(double value, int digits)
{
    return detail::text_of_number(value, [&](char* first, char* last) { return write_general(first, last, value, digits); });
}

}} // namespace tilemesh
