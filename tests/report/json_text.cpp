// test: unoptimised test asan
#include "../standard.hpp"
#include <nlohmann/json.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/json_text.hpp>

// The writer of JSON, and the texts of numbers.
using namespace tilemesh;
using report::json_string;
using Json = nlohmann::ordered_json;

namespace {
std::string printed(std::string const& text)
{
    return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}
} // namespace

TEST_CASE("JSON text: a string has the bytes of nlohmann-json, whatever its bytes are")
{
    std::size_t different = 0;
    for (int a = 0; a < 256; ++a)
        for (int b = 0; b < 256; ++b) {
            std::string const pair{static_cast<char>(a), static_cast<char>(b)};
            different += json_string(pair) != printed(pair);
        }
    std::mt19937 random(1);
    constexpr unsigned char likely[] = {0x80, 0x8f, 0x90, 0x9f, 0xa0, 0xbf, 0xc1, 0xc2, 0xdf, 0xe0, 0xe1, 0xed, 0xef, 0xf0, 0xf1, 0xf4, 0xf5, 'a', '"', 7};
    for (int i = 0; i < 20'000; ++i) {
        std::string text;
        for (auto n = random() % 8; n != 0; --n) text += static_cast<char>(likely[random() % sizeof likely]);
        different += json_string(text) != printed(text);
    }
    CHECK(different == 0);
}

TEST_CASE("JSON text: objects and arrays, in lines and in one line")
{
    auto const write = [](report::JsonText& json) {
        json.object([&] {
            json.member("a", "b\"");
            json.member("n", nullptr);
            json.member("t", true);
            json.list("list", std::vector<int>{1, -2});
            json.key("none");
            json.array([] {});
            json.member("not finite", std::numeric_limits<double>::infinity());
            json.member("whole", 2.0);
            json.member_as_is("object", report::json_line([](auto& inner) { inner.member("x", 0.1), inner.member("y", 2u); }));
        });
    };
    report::JsonText lines(2), line(0), digits(1, [](double) { return std::string("7"); });
    write(lines), write(line), write(digits);
    CHECK(lines.text() == "{\n  \"a\": \"b\\\"\",\n  \"n\": null,\n  \"t\": true,\n  \"list\": [\n    1,\n    -2\n  ],\n  \"none\": [],\n"
                          "  \"not finite\": null,\n  \"whole\": 2,\n  \"object\": {\"x\": 0.1, \"y\": 2}\n}");
    CHECK(line.text() == "{\"a\": \"b\\\"\", \"n\": null, \"t\": true, \"list\": [1, -2], \"none\": [], \"not finite\": null, \"whole\": 2, "
                         "\"object\": {\"x\": 0.1, \"y\": 2}}");
    CHECK(Json::parse(digits.text())["whole"] == 7);
}

TEST_CASE("the texts of a number")
{
    CHECK(number_text(0.1) == "0.1");
    CHECK(number_text(-1e300) == "-1e+300");
    CHECK(decimals(2.5, 0) == "2");
    CHECK(decimals(-1.0625, 3) == "-1.062");
    CHECK(decimals(std::numeric_limits<double>::max(), 80).size() == 309 + 1 + 80);
    CHECK(significant(1234567.0, 3) == "1.23e+06");
    CHECK(significant(0.00392, 3) == "0.00392");
    for (double const sign : {1.0, -1.0}) CHECK(decimals(sign * std::numeric_limits<double>::infinity(), 2) == (sign > 0 ? "inf" : "-inf"));
    CHECK(number_text(std::nan("")) == "NaN");
}
