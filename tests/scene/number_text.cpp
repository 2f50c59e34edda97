// test: unoptimised test asan tsan
#include "../standard.hpp"
#include <cerrno>
#include <charconv>
#include <clocale>
#include <system_error>
#include <tilemesh/number_text.hpp>

using namespace tilemesh;

TEST_SUITE_BEGIN("number_text");

namespace {

/// The answer of a reader to a text: where it ended, its error, the value (7 before).
template <class T>
struct Answer {
    std::ptrdiff_t length;
    std::errc error;
    T value;
    bool operator==(Answer const& other) const
    {
        bool const same = std::isnan(value) ? std::isnan(other.value) : value == other.value;
        return length == other.length && error == other.error && same && std::signbit(value) == std::signbit(other.value);
    }
};
template <class T>
std::string text_of(Answer<T> const& a)
{
    return std::to_string(a.length) + " characters, error " + std::to_string(static_cast<int>(a.error)) + ", " + std::to_string(a.value);
}
template <class T, class Read>
Answer<T> answer(std::string_view text, Read const& read)
{
    T value = 7;
    auto const [end, error] = read(text.data(), text.data() + text.size(), value);
    return {end - text.data(), error, value};
}
template <class T>
Answer<T> by_fallback(std::string_view text)
{
    return answer<T>(text, [](auto first, auto last, T& value) { return detail::read_floating(first, last, value); });
}
template <class T>
Answer<T> by_any(std::string_view text)
{
    return answer<T>(text, [](auto first, auto last, T& value) { return read_number(first, last, value); });
}

constexpr std::errc good{}, none = std::errc::invalid_argument, beyond = std::errc::result_out_of_range;

/// Texts on which readers may differ; compared where the standard library has a reader.
[[maybe_unused]] std::vector<std::string> cases()
{
    std::string const zeros(1000, '0');
    std::string const half_way = "9007199254740993"; // 2^53 + 1: between two doubles, the lower one is even
    return {"0", "-0", "1", "-12.5e-1", "12.5E+1 ", ".5", "5.", "5.e1", "1,5", "1.2.3", "1'000", "1e", "1e+", "1e-x", "0x10", "1p3", "", "-", ".",
            "-.e1", "e1", "+1", "--1", " 1", "\n1", "in", "na", "inf", "-Inf", "INFINITY", "infinite", "nan", "-NaN", "nan(", "nan(_a1)2", "nan(a b)",
            "1.7976931348623157e308", "1e308", "1e309", "-1e309", "1e99999999999999999999", "0e99999999999999999999", "1e-99999999999999999999",
            "4.9e-324", "2.5e-324", "2.4e-324", "2.2250738585072011e-308",
            // Long texts: more digits than a double, and the point half-way to the next double, have.
            "1" + zeros + "e-1000", "0." + zeros + "1e1001", zeros + "1.5" + zeros, half_way, half_way + "." + zeros, half_way + "." + zeros + "1",
            half_way + zeros + "1e-1001", std::string(400, '9')};
}

TEST_CASE("numbers, words and texts that are neither are read in both ways")
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    std::pair<char const*, Answer<double>> const answers[] = {
        {"-12.5e-1", {8, good, -1.25}}, {"1.2.3", {3, good, 1.2}}, {"1e+", {1, good, 1.0}}, {"0x10", {1, good, 0.0}}, {"-.e1", {0, none, 7.0}},
        {"+1", {0, none, 7.0}}, {" 1", {0, none, 7.0}}, {"-Inf", {4, good, -infinity}}, {"infinite", {3, good, infinity}},
        {"nan(_a1)2", {8, good, std::nan("")}}, {"-1e309", {6, beyond, 7.0}}, {"2.4e-324", {8, beyond, 7.0}}};
    for (auto const& each : answers) {
        std::string const text = each.first;
        auto const& expected = each.second;
        CAPTURE(text);
        CHECK_MESSAGE(by_fallback<double>(text) == expected, text_of(by_fallback<double>(text)));
        CHECK_MESSAGE(by_any<double>(text) == expected, text_of(by_any<double>(text)));
    }
}

TEST_CASE("a float is rounded once, not by way of a double")
{
    // Above the half-way point between 1 and the next float, by less than a double can hold.
    std::string const text = "1.000000059604644775390626";
    CHECK(by_fallback<float>(text).value == std::nextafter(1.0f, 2.0f));
    CHECK(by_any<float>(text).value == std::nextafter(1.0f, 2.0f));
    CHECK(by_fallback<float>("3.5e38") == Answer<float>{6, beyond, 7.0f});
    CHECK(by_fallback<float>("1e-46") == Answer<float>{5, beyond, 7.0f});
    CHECK(by_fallback<float>("1e-45") == Answer<float>{5, good, std::numeric_limits<float>::denorm_min()});
}

TEST_CASE("integers are read as by std::from_chars")
{
    CHECK(by_any<std::uint32_t>("4294967295").value == 4294967295u);
    CHECK(by_any<std::uint32_t>("4294967296").error == beyond);
    CHECK(by_any<int>("-3.5").length == 2);
}

TEST_CASE("no byte after the end is read, and errno stays")
{
    std::string_view const digits = "123456";
    double value = 0;
    errno = 5;
    CHECK(detail::read_floating(digits.data(), digits.data() + 3, value).ptr == digits.data() + 3);
    CHECK(value == 123.0);
    CHECK(by_fallback<double>("1e999").error == beyond);
    CHECK(errno == 5);
    for (std::string_view const whole : {"infinity", "nan(x)", "-1.5e-10"})
        for (std::size_t n = 0; n <= whole.size(); ++n) { // of a copy that ends there: sanitizers see a byte too many
            std::vector<char> const text(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n));
            auto const got = detail::read_floating(text.data(), text.data() + n, value);
            CHECK(got.ptr - text.data() <= static_cast<std::ptrdiff_t>(n));
        }
}

TEST_CASE("a locale with a decimal comma changes no number that is read; what is written has a point, and fits or is not written")
{
    auto const check = [] {
        CHECK(by_fallback<double>("1.5") == Answer<double>{3, good, 1.5});
        CHECK(by_fallback<double>("1,5") == Answer<double>{1, good, 1.0});
        std::array<char, 4> room{'x', 'x', 'x', 'x'};
        CHECK(detail::write_shortest(room.data(), room.data() + 3, 1.25).ec == std::errc::value_too_large);
        CHECK(detail::write_as_printf(room.data(), room.data() + 3, "%.*f", 2, 1.25).ec == std::errc::value_too_large);
        CHECK(detail::write_shortest(room.data(), room.data() + 4, 1.25).ec == good);
        CHECK(std::string(room.data(), 4) == "1.25");
        room.fill('x');
        CHECK(detail::write_as_printf(room.data(), room.data() + 4, "%.*f", 2, 1.25).ec == good);
        CHECK(std::string(room.data(), 4) == "1.25");
    };
    check();
    std::string const before = std::setlocale(LC_NUMERIC, nullptr);
    bool found = false;
    for (auto const* name : {"de_DE.UTF-8", "de_DE", "fr_FR.UTF-8", "fr_FR", "nl_NL.UTF-8", "ps_AF.UTF-8"}) {
        if (std::setlocale(LC_NUMERIC, name) == nullptr) continue;
        found = true;
        check();
    }
    if (!found) MESSAGE("skipped: the system has no locale with a decimal comma");
    std::setlocale(LC_NUMERIC, before.c_str());
}

/// A double of any bits.
double any_double(std::mt19937_64& random)
{
    return std::bit_cast<double>(std::uint64_t{random()});
}

/// Calls f(text) for many doubles of any size, in the formats of different writers.
template <class F>
void for_written_numbers(F const& f)
{
    std::mt19937_64 random(1);
    for (int i = 0; i < 20000; ++i) {
        double value = any_double(random);
        if (!std::isfinite(value)) continue;
        int exponent = 0;
        if (i % 2 == 0) value = std::ldexp(std::frexp(value, &exponent), i % 100 - 50); // half of them as in maps and poses
        std::array<char, 1200> text{};
        auto const last = text.data() + text.size();
        auto const put = [&](std::to_chars_result const& written) {
            f(std::string_view(text.data(), static_cast<std::size_t>(written.ptr - text.data())), value);
        };
        put(std::to_chars(text.data(), last, value));
        put(std::to_chars(text.data(), last, value, std::chars_format::scientific, 16));
        if (i % 10 != 0) continue;
        put(std::to_chars(text.data(), last, value, std::chars_format::scientific, 40));
        put(std::to_chars(text.data(), last, value, std::chars_format::fixed, 800));
    }
}

TEST_CASE("a number that was written is read back, to the bit")
{
    int wrong = 0; // 800 decimals have 476 digits of the least double, which is more than the 17 that tell it
    for_written_numbers([&](std::string_view text, double value) { wrong += by_fallback<double>(text).value != value ? 1 : 0; });
    CHECK(wrong == 0);
}

#if defined(__cpp_lib_to_chars) && __cpp_lib_to_chars >= 201611L
/// The number of texts for which std::from_chars answers differently. The first of them is shown.
template <class T>
int differences(std::vector<std::string> const& texts)
{
    int different = 0;
    for (auto const& text : texts) {
        auto const theirs = answer<T>(text, [](auto first, auto last, T& value) { return std::from_chars(first, last, value); });
        auto const ours = by_fallback<T>(text);
        if (theirs == ours) continue;
        if (different++ == 0) MESSAGE("\"" << text << "\": " << text_of(ours) << "; std::from_chars: " << text_of(theirs));
    }
    return different;
}

TEST_CASE("numbers are written as by std::to_chars")
{
    std::mt19937_64 random(3);
    std::vector<double> values = {0.0, -0.0, 1.0, 0.1, 1e5, 123456.0, 1e-5, 1e-4, 0.00012, 1e16, 1e22, 1e23, 0x1p70, 5e-324, 1e100, 1e-100,
                                  std::numeric_limits<double>::max(), std::numeric_limits<double>::min(), 9007199254740993.0};
    for (int i = 0; i < 20000; ++i) {
        double const value = any_double(random);
        auto const bits = std::bit_cast<std::uint64_t>(value);
        if (std::isfinite(value)) values.push_back(value);
        values.push_back(static_cast<double>(static_cast<float>(bits >> 40) / 1024.0f));
        values.push_back(static_cast<double>(bits % 1'000'000) / 1000.0);
        values.push_back(static_cast<double>(bits >> (i % 60)));
    }
    int different = 0;
    std::array<char, 1200> ours{}, theirs{};
    auto const check = [&](std::to_chars_result const& a, std::to_chars_result const& b) {
        std::string const x(ours.data(), a.ptr), y(theirs.data(), b.ptr);
        if (x != y && different++ == 0) MESSAGE("\"" << x << "\"; std::to_chars: \"" << y << "\"");
    };
    auto* const first = ours.data();
    auto* const last = ours.data() + ours.size();
    for (double const value : values) {
        check(detail::write_shortest(first, last, value), std::to_chars(theirs.data(), theirs.data() + theirs.size(), value));
        for (int const digits : {0, 1, 4}) {
            check(detail::write_as_printf(first, last, "%.*f", digits, value),
                  std::to_chars(theirs.data(), theirs.data() + theirs.size(), value, std::chars_format::fixed, digits));
            check(detail::write_as_printf(first, last, "%.*g", digits + 2, value),
                  std::to_chars(theirs.data(), theirs.data() + theirs.size(), value, std::chars_format::general, digits + 2));
        }
    }
    CHECK(different == 0);
}

TEST_CASE("std::from_chars reads the same in texts of any kind")
{
    std::mt19937_64 random(2);
    std::vector<std::string> texts;
    for_written_numbers([&](std::string_view text, double) { texts.emplace_back(text); });
    for (auto const& text : cases()) texts.push_back(text);
    // Texts that are almost numbers: characters of numbers in any order, and numbers with one changed character.
    std::string_view const letters = "0123456789012345678901234567890....eeE+--infatyINFATY()_x, ";
    auto const letter = [&] { return letters[random() % letters.size()]; };
    for (int i = 0; i < 50000; ++i) {
        std::string text(random() % 12, ' ');
        for (auto& c : text) c = letter();
        texts.push_back(text);
    }
    for (std::size_t i = 0; i < 20000; ++i) {
        auto text = texts[i * 2];
        text[random() % text.size()] = letter();
        texts.push_back(text);
    }
    CHECK(texts.size() > 100'000);
    CHECK(differences<double>(texts) == 0);
    CHECK(differences<float>(texts) == 0);
}
#endif

} // namespace

TEST_SUITE_END();
