// test: unoptimised test asan
#include <cstddef>
#include <doctest/doctest.h>
#include <limits>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/report/html.hpp>
#include <tilemesh/report/plot.hpp>
#include <tilemesh/report/stacked_bars.hpp>
#include <utility>
#include <vector>

namespace {

using tilemesh::Error;
using namespace tilemesh::report;

std::size_t count(std::string const& text, std::string const& what)
{
    std::size_t n = 0;
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) ++n;
    return n;
}
bool has(std::string const& text, std::string const& what)
{
    return text.find(what) != std::string::npos;
}

/// Is every element of a page closed, in order, except the elements that HTML never closes?
bool well_formed(std::string const& text)
{
    std::vector<std::string> open;
    for (auto at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
        if (text.compare(at, 2, "<!") == 0) continue;
        auto const end = text.find('>', at);
        if (end == std::string::npos) return false;
        bool const closes = text[at + 1] == '/';
        auto const from = at + (closes ? 2 : 1);
        auto const name = text.substr(from, text.find_first_of(" />", from) - from);
        if (name == "meta" || name == "img" || text[end - 1] == '/') continue;
        if (!closes) {
            open.push_back(name);
        } else {
            if (open.empty() || open.back() != name) return false;
            open.pop_back();
        }
    }
    return open.empty();
}

std::string message(auto&& call)
{
    try {
        call();
    } catch (Error const& error) {
        return error.what();
    }
    return "nothing thrown";
}

Plot diagram()
{
    Plot plot;
    plot.title = "a < b";
    plot.series = {{"s", {{0, 1}, {1, 2}}}};
    return plot;
}
StackedBars two_bars(BarLayout layout)
{
    StackedBars chart;
    chart.parts = {{"compute", 4}, {"exchange", 1}};
    chart.bars = {{"route", {30, 10}, 1}, {"blend", {0, 20}, 3}};
    chart.layout = layout;
    return chart;
}
/// The rectangles of the bars, without those of background and legend, as "x y width height".
std::vector<std::string> bars_of(std::string const& text)
{
    std::vector<std::string> out;
    for (auto at = text.find("<rect x="); at != std::string::npos; at = text.find("<rect x=", at + 1)) {
        std::string rect;
        for (std::string const name : {" x=\"", " y=\"", " width=\"", " height=\""}) {
            auto const from = text.find(name, at) + name.size();
            rect += text.substr(from, text.find('"', from) - from) + ' ';
        }
        if (has(rect, "12 12 ")) continue; // the legend's are whole numbers
        out.push_back(rect);
    }
    return out;
}
double field(std::string const& rect, int which)
{
    std::size_t at = 0;
    for (int i = 0; i < which; ++i) at = rect.find(' ', at) + 1;
    return std::stod(rect.substr(at));
}

} // namespace

TEST_CASE("base 64 as RFC 4648 has it in section 10, and all digits")
{
    CHECK(base64("") == "");
    CHECK(base64("f") == "Zg==");
    CHECK(base64("fo") == "Zm8=");
    CHECK(base64("foo") == "Zm9v");
    CHECK(base64("foob") == "Zm9vYg==");
    CHECK(base64("fooba") == "Zm9vYmE=");
    CHECK(base64("foobar") == "Zm9vYmFy");
    CHECK(base64(std::string("\0\xff\xfe", 3)) == "AP/+");
    std::string const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes; // of which each six bits are the next digit
    for (unsigned i = 0; i < 64; i += 4) {
        unsigned const word = i << 18 | (i + 1) << 12 | (i + 2) << 6 | (i + 3);
        for (unsigned const shift : {16u, 8u, 0u}) bytes += static_cast<char>(static_cast<unsigned char>(word >> shift));
    }
    CHECK(base64(bytes) == digits);
}

TEST_CASE("what means something to HTML is escaped, wherever a text stands")
{
    CHECK(html_text("a<b>c&d\"e'f") == "a&lt;b&gt;c&amp;d&quot;e&#39;f");
    CHECK(html_text(std::string("a\0b\x1b[31m\x7f\r\n", 11)) == "a b [31m  \n");
    CHECK(html_text("\xc3\xa9 \xff") == "\xc3\xa9 \xff");

    std::string const evil = "</td><script>alert('\"&')</script>";
    std::vector<std::pair<std::string, std::string>> const pairs = {{evil, evil}};
    std::vector<std::vector<std::string>> const rows = {{evil}};
    HtmlReport report(evil);
    report.section(evil).subsection(evil).paragraph(evil).key_values(pairs).table({evil}, rows).picture("png", evil, evil);
    auto const text = report.str();
    CHECK_FALSE(has(text, "<script"));
    CHECK(count(text, html_text(evil)) == 11); // twice the title
    CHECK(well_formed(text));
}

TEST_CASE("a report is one page without a script, and asks no network for anything")
{
    HtmlReport report("map desk");
    std::vector<std::vector<std::string>> const rows = {{"route", "12"}, {"bloom", "3"}};
    report.section("Frame 0").paragraph("text").table({"step", "cycles"}, rows);
    report.svg(svg(diagram())).svg(svg(two_bars(BarLayout::named))).svg(svg(diagram()));
    report.picture("foobar", "a map", "most 5", HtmlPicture::small);
    auto const text = report.str();
    CHECK(text == report.str());
    CHECK(text.starts_with("<!DOCTYPE html>\n"));
    CHECK(well_formed(text));
    CHECK_FALSE(has(text, "://"));
    CHECK_FALSE(has(text, "<script"));
    CHECK_FALSE(has(text, "href"));
    CHECK_FALSE(has(text, "@import"));
    CHECK(count(text, "url(") == 2); // the clips of the two plots, in the page
    CHECK(has(text, "default-src 'none'; img-src data:;"));
    CHECK(has(text, "<img alt=\"a map\" src=\"data:image/png;base64,Zm9vYmFy\">"));
    CHECK(has(text, "<tr><td>route</td><td>12</td></tr>"));
    CHECK(report.bytes() < text.size());

    // Two diagrams with the same id in them: each uses its own clip.
    for (auto const* id : {" id=\"area-1\"", "url(#area-1)", " id=\"area-3\"", "url(#area-3)"}) CHECK(count(text, id) == 1);
}

TEST_CASE("a diagram that is none, or that could run or load something, and a row that is too short are refused")
{
    HtmlReport report("t");
    CHECK(has(message([&] { report.svg("<p>"); }), "does not begin with <svg"));
    CHECK(has(message([&] { report.svg(""); }), "does not begin with <svg"));
    for (std::string const element : {"script", "image", "use", "foreignObject", "a ", "style"})
        CHECK(has(message([&] { report.svg("<svg><" + element + "></svg>"); }), "it has an element " + element));
    std::vector<std::vector<std::string>> const rows = {{"one"}};
    CHECK(has(message([&] { report.table({"a", "b"}, rows); }), "1 cells and 2 columns"));
}

TEST_CASE("stacked bars stand one on the other, as high as their values and as wide as they say")
{
    auto const named = svg(two_bars(BarLayout::named));
    CHECK(named == svg(two_bars(BarLayout::named)));
    CHECK(has(named, ">route</text>"));
    CHECK(has(named, ">exchange</text>"));
    auto bars = bars_of(named);
    REQUIRE(bars.size() == 3); // the fourth is 0 high
    CHECK(field(bars[0], 3) == doctest::Approx(3 * field(bars[1], 3)).epsilon(0.001));
    CHECK(field(bars[2], 3) == doctest::Approx(2 * field(bars[1], 3)).epsilon(0.001));
    CHECK(field(bars[1], 1) + field(bars[1], 3) == doctest::Approx(field(bars[0], 1)).epsilon(0.001)); // on top of it
    CHECK(field(bars[0], 2) == field(bars[2], 2));

    auto const along = svg(two_bars(BarLayout::along_x));
    CHECK_FALSE(has(along, ">route</text>"));
    bars = bars_of(along);
    REQUIRE(bars.size() == 3);
    CHECK(field(bars[2], 2) == doctest::Approx(3 * field(bars[0], 2)).epsilon(0.001));
    CHECK(field(bars[2], 0) == doctest::Approx(field(bars[0], 0) + field(bars[0], 2)).epsilon(0.001));
}

TEST_CASE("bars: none, zeros, and what cannot be drawn")
{
    for (auto const layout : {BarLayout::named, BarLayout::along_x}) {
        StackedBars chart = two_bars(layout);
        chart.bars.clear();
        CHECK(bars_of(svg(chart)).empty());
        chart.bars = {{"zero", {0, 0}, 0}};
        CHECK(bars_of(svg(chart)).empty());
        CHECK_FALSE(has(svg(chart), "nan"));
    }
    auto const refused = [](auto const& change) {
        auto chart = two_bars(BarLayout::along_x);
        change(chart);
        return message([&] { (void)svg(chart); });
    };
    CHECK(has(refused([](auto& c) { c.bars[1].values.pop_back(); }), "bar \"blend\" cannot be drawn"));
    CHECK(has(refused([](auto& c) { c.bars[1].values[0] = -1; }), "bar \"blend\" cannot be drawn"));
    CHECK(has(refused([](auto& c) { c.bars[0].width = -1; }), "bar \"route\" cannot be drawn"));
    CHECK(has(refused([](auto& c) { c.bars[0].values[0] = std::numeric_limits<double>::quiet_NaN(); }),
              "bar \"route\" cannot"));
    CHECK(has(refused([](auto& c) { c.bars[0].values = {1e308, 1e308}; }), "bar \"route\" cannot"));
    CHECK(has(refused([](auto& c) { c.width = 319; }), "319 x 320"));
    CHECK(has(refused([](auto& c) { c.y_high = 0; }), "the y axis cannot be drawn"));
    CHECK(has(refused([](auto& c) { c.y_high = std::numeric_limits<double>::infinity(); }), "the y axis cannot be drawn"));
    CHECK(refused([](auto&) {}) == "nothing thrown");

    auto chart = two_bars(BarLayout::named);
    auto const lower = field(bars_of(svg(chart))[0], 3);
    chart.y_high = 80; // the first bar is 40 high, which the axis otherwise ends at
    CHECK(field(bars_of(svg(chart))[0], 3) == doctest::Approx(lower / 2).epsilon(0.001));

    // What is above the axis is cut off where it ends, 36 pixels from the top, under the title.
    for (auto const layout : {BarLayout::named, BarLayout::along_x}) {
        chart.layout = layout;
        chart.y_high = 35; // in the first bar's upper part
        auto bars = bars_of(svg(chart));
        REQUIRE(bars.size() == 3);
        CHECK(field(bars[1], 1) == 36);
        CHECK(field(bars[1], 1) + field(bars[1], 3) == doctest::Approx(field(bars[0], 1)));
        CHECK(field(bars[1], 3) * 6 == doctest::Approx(field(bars[0], 3)).epsilon(0.001));
        for (double const high : {30.0, 25.0}) { // where the upper part begins, and below
            chart.y_high = high;
            bars = bars_of(svg(chart));
            REQUIRE(bars.size() == 2);
            CHECK(field(bars[0], 1) == 36);
            CHECK(field(bars[0], 3) == chart.height - 52.0 - 36);
        }
    }
}
