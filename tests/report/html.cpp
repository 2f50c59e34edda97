// test: unoptimised test asan
#include "folder.hpp"
#include "html_elements.hpp"
#include <tilemesh/report/html.hpp>
#include <tilemesh/report/plot.hpp>
#include <tilemesh/report/stacked_bars.hpp>

namespace {

using tilemesh::Error;
using namespace tilemesh::report;
using tests::count, tests::has;

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
    for (auto const& [plain, text] :
         {std::pair("", ""), {"f", "Zg=="}, {"fo", "Zm8="}, {"foo", "Zm9v"}, {"foob", "Zm9vYg=="}, {"fooba", "Zm9vYmE="}, {"foobar", "Zm9vYmFy"}})
        CHECK(base64(plain) == text);
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
    report.section(evil).subsection(evil).paragraph(evil).key_values(pairs).table({evil}, rows).lead(evil).figures(pairs);
    report.gallery({}, std::vector<HtmlCard>{{evil, evil, "png", evil, {evil}}});
    report.folded_section(evil, HtmlFold::open, [&] { report.folded_subsection(evil, HtmlFold::closed, [&] { report.paragraph(evil); }); });
    auto const text = report.str();
    CHECK_FALSE(has(text, "<script"));
    CHECK(count(text, html_text(evil)) == 19); // twice the title
    CHECK(elements_close(text));
}

TEST_CASE("a report is one page without a script, and asks no network for anything")
{
    HtmlReport report("map desk");
    std::vector<std::vector<std::string>> const rows = {{"route", "12"}, {"bloom", "3"}};
    report.section("Frame 0").paragraph("text").table({"step", "cycles"}, rows);
    report.svg(svg(diagram())).svg(svg(two_bars(BarLayout::rows))).svg(svg(diagram()));
    report.gallery({}, std::vector<HtmlCard>{{"Load", "most 5", "foobar", "a map", {"0", "5"}}});
    auto const text = report.str();
    CHECK(text == report.str());
    CHECK(text.starts_with("<!DOCTYPE html>\n"));
    CHECK(elements_close(text));
    for (auto const* part : {"://", "<script", "href", "@import"}) CHECK_FALSE(has(text, part));
    CHECK(count(text, "url(") == 2); // the clips of the two plots, in the page
    CHECK(has(text, "default-src 'none'; img-src data:;"));
    CHECK(has(text, "<img alt=\"a map\" class=\"map\" style=\"width: 100.000%; height: 100.000%\" src=\"data:image/png;base64,Zm9vYmFy\">"));
    CHECK(has(text, "<tr><td>route</td><td>12</td></tr>"));
    CHECK(report.bytes() < text.size());

    // Two diagrams with the same id in them: each uses its own clip.
    for (auto const* id : {" id=\"area-1\"", "url(#area-1)", " id=\"area-3\"", "url(#area-3)"}) CHECK(count(text, id) == 1);
}

TEST_CASE("columns of numbers stand right, columns of words left")
{
    std::vector<std::vector<std::string>> const rows = {
        {"route", "1,234", "12.5 %", "", "-3", "capacity", "1"}, {"2", "0", "0.0 %", "outside", "3.2e-05", "12", "(3, 4)"}, {"bloom", "7", "", "", "", "13", "(1, 2)"}};
    HtmlReport report("t");
    report.table({"a", "b", "c", "d", "e", "f", "g"}, rows);
    CHECK(has(report.str(), "<table class=\"l1 l4 l7\">")); // f has more numbers than words
    for (auto const* column : {"l1", "l4", "l7", "l16", "w2", "w16"}) CHECK(has(report.str(), std::string(".") + column + " tr > :nth-child(" + (column + 1) + ")"));
    HtmlReport empty("t");
    empty.table({"a"}, {});
    CHECK(has(empty.str(), "<table class=\"\">"));
    CHECK(elements_close(empty.str()));
}

TEST_CASE("a column with sentences has room for them; a narrow table that ends with one is told from the others")
{
    auto const classes = [](std::vector<std::string> const& row) {
        HtmlReport report("t");
        report.table(std::vector<std::string>(row.size(), "head"), std::vector<std::vector<std::string>>{row, std::vector<std::string>(row.size(), "a")});
        auto const text = report.str();
        auto const from = text.find("<table class=\"") + 14;
        return text.substr(from, text.find('"', from) - from);
    };
    std::string const sentence(33, 'x'), words(32, 'x');
    CHECK(classes({"a", words}) == "l1 l2");
    CHECK(classes({"a", sentence}) == "l1 l2 w2 prose");
    CHECK(classes({"a", sentence, "b"}) == "l1 l2 w2 l3");
    CHECK(classes({sentence}) == "l1"); // it stays in sight, so it must not take all of a narrow window
    CHECK(classes({"a", "b", "c", sentence}) == "l1 l2 l3 l4 w4 prose");
    CHECK(classes({"a", "b", "c", "d", sentence}) == "l1 l2 l3 l4 l5 w5");
}

TEST_CASE("a gallery shows all pictures in one frame, maps with a scale, and a mark in each")
{
    HtmlFrame frame{100, 50, 120, 50};
    frame.mark = {40, 10, 20, 5};
    std::vector<HtmlCard> const cards = {{"The picture", "large", "BMxx", "a picture"}, {"Load", "of tiles", "PNG", "a map", {"0", "1", "2 records"}},
                                         {"Another", "picture", "PNG", "small"}};
    HtmlReport report("t");
    report.gallery(frame, cards);
    auto const text = report.str();
    CHECK(elements_close(text));
    CHECK(count(text, "style=\"aspect-ratio: 100.000 / 50.000\"") == 3);
    CHECK(count(text, "<i style=\"left: 40.000%; top: 20.000%; width: 20.000%; height: 10.000%\"></i>") == 3);
    CHECK(count(text, "<figure class=\"large\">") == 1);
    CHECK(has(text, "<figure class=\"large\"><div class=\"frame\" style=\"aspect-ratio: 100.000 / 50.000\"><img alt=\"a picture\" "
                    "src=\"data:image/bmp;base64," + base64("BMxx")));
    CHECK(count(text, "style=\"width: 120.000%; height: 100.000%\"") == 1); // the map reaches over the right edge
    CHECK(count(text, "<div class=\"scale\">") == 1);
    CHECK(has(text, "<span>0</span><span>1</span><span>2 records</span>"));
    // The scale has the colours of heat maps.
    CHECK(has(text, "linear-gradient(to right, rgb(68 1 84), rgb(71 45 123), "));
    CHECK(has(text, ", rgb(253 231 37))"));
    HtmlReport none("t");
    none.gallery({}, {});
    CHECK(elements_close(none.str()));
    CHECK_FALSE(has(none.str(), "<i "));
}

TEST_CASE("a part that is folded away is closed or open at first, and holds what is added in it")
{
    HtmlReport report("t");
    report.folded_section("Closed", HtmlFold::closed, [&] { report.paragraph("inside"); }).paragraph("outside");
    report.folded_subsection("Open", HtmlFold::open, [&] {});
    auto const text = report.str();
    CHECK(elements_close(text));
    CHECK(has(text, "<details><summary><h2>Closed</h2></summary>\n<p>inside</p>\n</details>\n<p>outside</p>"));
    CHECK(has(text, "<details open><summary><h3>Open</h3></summary>\n</details>"));
}

TEST_CASE("a diagram that is none, or that could run or load something, and a row that is too short are refused")
{
    HtmlReport report("t");
    CHECK(has(tests::error_of([&] { report.svg("<p>"); }), "does not begin with <svg"));
    CHECK(has(tests::error_of([&] { report.svg(""); }), "does not begin with <svg"));
    for (std::string const element : {"script", "image", "use", "foreignObject", "a ", "style"})
        CHECK(has(tests::error_of([&] { report.svg("<svg><" + element + "></svg>"); }), "it has an element " + element));
    std::vector<std::vector<std::string>> const rows = {{"one"}};
    CHECK(has(tests::error_of([&] { report.table({"a", "b"}, rows); }), "1 cells and 2 columns"));
}

TEST_CASE("stacked bars: rows are as long as their values, behind their names; along x they are as wide as they say")
{
    auto const named = svg(two_bars(BarLayout::rows));
    CHECK(named == svg(two_bars(BarLayout::rows)));
    CHECK(has(named, ">route</text>"));
    CHECK(has(named, ">exchange</text>"));
    auto bars = bars_of(named);
    REQUIRE(bars.size() == 3); // the fourth is 0 long
    CHECK(field(bars[0], 2) == doctest::Approx(3 * field(bars[1], 2)).epsilon(0.001));
    CHECK(field(bars[2], 2) == doctest::Approx(2 * field(bars[1], 2)).epsilon(0.001));
    CHECK(field(bars[1], 0) == doctest::Approx(field(bars[0], 0) + field(bars[0], 2)).epsilon(0.001)); // behind it
    CHECK(field(bars[0], 1) == field(bars[1], 1));
    CHECK(field(bars[2], 1) == field(bars[0], 1) + 26);
    auto chart = two_bars(BarLayout::rows);
    chart.title = "in sight";
    CHECK(has(svg(chart), "<text x=\"8.00\" y=\"20.00\" font-size=\"15\">in sight</text>"));
    chart.bars[1].note = "20 <ms>";
    CHECK(has(svg(chart), ">20 &lt;ms&gt;</text>"));
    auto const bar = chart.bars[0]; // a copy: assign wants no element of its own
    chart.bars.assign(100, bar);    // as high as its rows
    CHECK(has(svg(chart), "height=\"2694\""));
    chart.bars[0].name = std::string(100, 'a') + std::string(100, 'z');
    CHECK(has(svg(chart), ">aaaaaaaaaaaaaaaaaaaaaaaa...zzzzzzzzzzzzz</text>"));

    auto const along = svg(two_bars(BarLayout::along_x));
    CHECK_FALSE(has(along, ">route</text>"));
    bars = bars_of(along);
    REQUIRE(bars.size() == 3);
    CHECK(field(bars[0], 3) == doctest::Approx(3 * field(bars[1], 3)).epsilon(0.001));
    CHECK(field(bars[1], 1) + field(bars[1], 3) == doctest::Approx(field(bars[0], 1)).epsilon(0.001)); // on top of it
    CHECK(field(bars[2], 2) == doctest::Approx(3 * field(bars[0], 2)).epsilon(0.001));
    CHECK(field(bars[2], 0) == doctest::Approx(field(bars[0], 0) + field(bars[0], 2)).epsilon(0.001));
}

TEST_CASE("stacked bars: spans are bands over the area, and each name has a line to its band that crosses no other name")
{
    auto chart = two_bars(BarLayout::along_x);
    chart.spans = {{"first", 1}, {"", 1}, {"third", 2}};
    auto const text = svg(chart);
    CHECK(elements_close(text));
    CHECK(count(text, "height=\"6.00\" fill=\"#444444\"") == 2);
    CHECK(count(text, "height=\"6.00\" fill=\"#aaaaaa\"") == 1);
    for (auto const* name : {">first</text>", ">third</text>"}) CHECK(count(text, name) == 1);
    CHECK(count(text, "stroke=\"#666666\"") == 2);
    auto const plain = two_bars(BarLayout::along_x);
    CHECK(field(bars_of(text)[0], 3) == field(bars_of(svg(plain))[0], 3)); // the area stays as high
    chart.spans[0].width = -1;
    CHECK(has(tests::error_of([&] { svg(chart); }), "span \"first\" cannot be drawn"));

    // Five names close to each other, then one far away.
    using tilemesh::report::detail::SpanFlag;
    std::vector<SpanFlag> flags;
    for (int i = 0; i < 5; ++i) flags.push_back({"name", 100 + 5.0 * i, 5});
    flags.push_back({"far", 400, 50});
    stack_flags(flags, 8);
    REQUIRE(flags.size() == 6);
    for (std::size_t i = 0; i < 5; ++i) CHECK(flags[i].row == 4 - i);
    CHECK(flags[5].row == 0);
    flags[2].width_px = 1; // the thinnest goes first
    stack_flags(flags, 4);
    REQUIRE(flags.size() == 5);
    CHECK(flags[2].at_px == 115);
    CHECK(flags[0].row == 3);
    std::vector<SpanFlag> many;
    for (int i = 0; i < 1000; ++i) many.push_back({"name", 100 + 0.5 * i, 0.5});
    stack_flags(many, 8);
    for (std::size_t i = 0; i + 1 < many.size(); ++i)
        for (auto j = i + 1; j < many.size() && many[j].at_px < many[i].at_px + 6.5 * 4; ++j) CHECK(many[i].row > many[j].row);
    CHECK(many.size() > 50);

    // Names that are too long keep their beginning and their end, and no character is cut.
    using tilemesh::report::detail::shortened;
    CHECK(shortened("short", 8) == "short");
    CHECK(shortened("0123456789", 9) == "0123...89");
    for (std::size_t most = 8; most < 40; ++most) {
        std::string text_of;
        for (int i = 0; i < 20; ++i) text_of += "\xe2\x82\xac";
        auto const cut = shortened(text_of, most);
        CHECK(cut.size() <= most);
        CHECK((cut.size() - 3) % 3 == 0);
        CHECK(cut.starts_with("\xe2\x82\xac"));
    }
}

TEST_CASE("bars: none, zeros, and what cannot be drawn")
{
    for (auto const layout : {BarLayout::rows, BarLayout::along_x}) {
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
        return tests::error_of([&] { (void)svg(chart); });
    };
    CHECK(has(refused([](auto& c) { c.bars[1].values.pop_back(); }), "bar \"blend\" cannot be drawn"));
    CHECK(has(refused([](auto& c) { c.bars[1].values[0] = -1; }), "bar \"blend\" cannot be drawn"));
    CHECK(has(refused([](auto& c) { c.bars[0].width = -1; }), "bar \"route\" cannot be drawn"));
    CHECK(has(refused([](auto& c) { c.bars[0].values[0] = std::numeric_limits<double>::quiet_NaN(); }), "bar \"route\" cannot"));
    CHECK(has(refused([](auto& c) { c.bars[0].values = {1e308, 1e308}; }), "bar \"route\" cannot"));
    CHECK(has(refused([](auto& c) { c.width = 319; }), "319 x 320"));
    CHECK(has(refused([](auto& c) { c.y_high = 0; }), "the y axis cannot be drawn"));
    CHECK(has(refused([](auto& c) { c.y_high = std::numeric_limits<double>::infinity(); }), "the y axis cannot be drawn"));
    CHECK(refused([](auto&) {}).empty());

    auto chart = two_bars(BarLayout::rows);
    auto const shorter = field(bars_of(svg(chart))[0], 2);
    chart.y_high = 80; // the first bar is 40 long, which the axis otherwise ends at
    CHECK(field(bars_of(svg(chart))[0], 2) == doctest::Approx(shorter / 2).epsilon(0.001));

    // What is beyond the end of the axis is cut off there: 36 pixels from the top, under the title, or at the right end of the axis.
    for (auto const layout : {BarLayout::rows, BarLayout::along_x}) {
        chart.layout = layout;
        bool const rows = layout == BarLayout::rows;
        int const place = rows ? 0 : 1, length = rows ? 2 : 3; // of a rectangle's fields
        chart.y_high = 40;
        auto const whole = bars_of(svg(chart)); // the first bar reaches the end
        double const end = rows ? field(whole[1], 0) + field(whole[1], 2) : 36, axis = field(whole[0], length) + field(whole[1], length);
        chart.y_high = 35; // in the first bar's last part
        auto bars = bars_of(svg(chart));
        REQUIRE(bars.size() == 3);
        CHECK((rows ? field(bars[1], 0) + field(bars[1], 2) : field(bars[1], 1)) == doctest::Approx(end).epsilon(0.001));
        CHECK(field(bars[1], length) * 6 == doctest::Approx(field(bars[0], length)).epsilon(0.001));
        for (double const high : {30.0, 25.0}) { // where the last part begins, and before
            chart.y_high = high;
            bars = bars_of(svg(chart));
            REQUIRE(bars.size() == 2);
            CHECK(field(bars[0], place) == field(rows ? whole[0] : whole[1], place));
            CHECK(field(bars[0], length) == doctest::Approx(axis).epsilon(0.001));
        }
    }
}
