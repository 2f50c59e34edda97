// test: unoptimised test asan tsan
#include "folder.hpp"
#include <tilemesh/report/plot.hpp>

namespace {

using tests::count;
using tilemesh::Error;
using tilemesh::report::Plot;
using tilemesh::report::PlotLine;
using tilemesh::report::PlotScale;
using tilemesh::report::PlotSeries;
using tilemesh::report::svg;
using Points = std::vector<std::pair<double, double>>;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Is every element closed, in order, and every quote and entity complete? Then any XML parser reads the document.
bool well_formed(std::string const& text)
{
    std::vector<std::string> open;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '&') {
            auto const entity = text.substr(i, text.find(';', i) - i);
            if (entity != "&lt" && entity != "&gt" && entity != "&amp" && entity != "&quot") return false;
        }
        if (text[i] == '>') return false;
        if (text[i] != '<') continue;
        auto end = i;
        for (bool quoted = false; ++end < text.size();) {
            if (text[end] == '"') quoted = !quoted;
            if (quoted && text[end] == '<') return false;
            if (!quoted && text[end] == '>') break;
        }
        if (end == text.size()) return false;
        auto const tag = text.substr(i + 1, end - i - 1);
        auto const name = tag.substr(0, tag.find_first_of(" /", 1));
        if (tag[0] == '/') {
            if (open.empty() || "/" + open.back() != tag) return false;
            open.pop_back();
        } else if (tag.back() != '/') {
            open.push_back(name);
        }
        i = end;
    }
    return open.empty();
}

/// The picture of a plot; it must be well formed.
std::string drawn(Plot const& plot)
{
    auto text = svg(plot);
    CHECK(well_formed(text));
    return text;
}
/// All numbers after `before` in the text.
std::vector<double> numbers_after(std::string const& text, std::string const& before)
{
    std::vector<double> out;
    for (auto at = text.find(before); at != std::string::npos; at = text.find(before, at + 1))
        out.push_back(std::strtod(text.c_str() + at + before.size(), nullptr));
    return out;
}
/// The path of the only series.
std::string path_of(std::string const& text)
{
    auto const begin = text.find("<path d=\"", text.find("<g clip-path")) + 9;
    return text.substr(begin, text.find('"', begin) - begin);
}

Plot plot_of(Points points, PlotScale x = PlotScale::linear, PlotScale y = PlotScale::linear)
{
    Plot plot;
    plot.title = "title";
    plot.x = {.label = "across", .scale = x};
    plot.y = {.label = "up", .scale = y};
    plot.series.push_back({.name = "one", .points = std::move(points)});
    return plot;
}

} // namespace

TEST_SUITE_BEGIN("report");

TEST_CASE("a linear plot lays values evenly, up is more")
{
    auto const text = drawn(plot_of({{0, 0}, {5, 10}, {10, 40}}));
    auto const x = numbers_after(text, "cx=\""), y = numbers_after(text, "cy=\"");
    REQUIRE(x.size() == 3);
    CHECK(x[1] - x[0] == doctest::Approx(x[2] - x[1]).epsilon(0.001));
    CHECK(x[0] < x[1]);
    CHECK(y[0] - y[2] == doctest::Approx(4 * (y[0] - y[1])).epsilon(0.002));
    CHECK(y[1] < y[0]);
    for (char const* word : {">title<", ">across<", ">up<", ">one<", ">0<", ">10<", ">40<"})
        CHECK_MESSAGE(text.find(word) != std::string::npos, word);
}

TEST_CASE("with equal units a square is a square, and one point is drawn")
{
    auto plot = plot_of({{0, 0}, {0, 3}, {3, 3}});
    plot.equal_units = true;
    auto const text = drawn(plot);
    auto const x = numbers_after(text, "cx=\""), y = numbers_after(text, "cy=\"");
    REQUIRE(x.size() == 3);
    CHECK(x[2] - x[1] == doctest::Approx(y[0] - y[1]).epsilon(0.002));
    CHECK(y[0] - y[1] > 200); // the higher side fills the area
    plot.series[0].points = {{1e6, -3}};
    drawn(plot);
}

TEST_CASE("a logarithmic axis gives every factor the same length")
{
    auto const text = svg(plot_of({{1, 1}, {10, 1}, {100, 2}, {400, 2}}, PlotScale::logarithmic));
    auto const x = numbers_after(text, "cx=\"");
    REQUIRE(x.size() == 4);
    CHECK(x[1] - x[0] == doctest::Approx(x[2] - x[1]).epsilon(0.002));
    CHECK((x[3] - x[2]) / (x[1] - x[0]) == doctest::Approx(std::log10(4.0)).epsilon(0.002));
    for (char const* tick : {">1<", ">2<", ">5<", ">10<", ">20<", ">50<", ">100<", ">200<"})
        CHECK_MESSAGE(text.find(tick) != std::string::npos, tick);
    CHECK(text.find(">500<") == std::string::npos); // beyond the last value

    auto const wide = drawn(plot_of({{1e-3, 1e-12}, {1, 1}, {10, 1e9}}, PlotScale::logarithmic, PlotScale::logarithmic));
    CHECK(wide.find(">0.001<") != std::string::npos);
    CHECK(wide.find(">1e-12<") != std::string::npos); // beyond that a number of its zeros would stand on the label
    CHECK(wide.find(">0.0000") == std::string::npos);
    CHECK(count(wide, "<text") < 40); // no tick a decade over 21 of them times three
}

TEST_CASE("a short logarithmic axis can be read too: it has three ticks or more")
{
    auto const ticks = [](double low, double high) {
        auto const text = drawn(plot_of({{low, 1}, {high, 2}}, PlotScale::logarithmic));
        std::string out;
        for (auto const* tick : {"9", "10", "20", "30", "40", "50", "98", "99", "100", "101", "102", "103", "104", "110", "120", "130", "140"})
            if (text.find(std::string(">") + tick + "<") != std::string::npos) out += std::string(out.empty() ? "" : " ") + tick;
        return out;
    };
    CHECK(ticks(8.5, 45) == "9 10 20 30 40");        // 10 and 20 alone are two
    CHECK(ticks(8.5, 51) == "10 20 50");
    CHECK(ticks(97.5, 104.5) == "98 100 102 104");   // steps as on a linear axis
    CHECK(ticks(101, 145) == "110 120 130 140");
}

TEST_CASE("infinite values have their own line, above all others; NaN is a gap")
{
    auto const text = drawn(plot_of({{1, 30}, {2, infinite}, {3, 60}, {4, not_a_number}, {5, 40}, {6, -infinite}}));
    auto const y = numbers_after(text, "cy=\"");
    REQUIRE(y.size() == 4);
    CHECK(y[1] < y[2] - 10);
    CHECK(text.find(">inf<") != std::string::npos);
    auto const path = path_of(text);
    CHECK(count(path, "M") == 2); // before the gap, behind it
    CHECK(count(path, "L") == 2);
    CHECK(text.find("nan") == std::string::npos);
    CHECK(svg(plot_of({{1, 30}, {2, 60}})).find(">inf<") == std::string::npos);

    auto const nothing_finite = drawn(plot_of({{1, infinite}, {2, infinite}}));
    CHECK(numbers_after(nothing_finite, "cy=\"").size() == 2);
}

TEST_CASE("a step keeps its value until the next one begins")
{
    auto plot = plot_of({{0, 0}, {1, 10}, {2, 5}});
    CHECK(count(path_of(svg(plot)), "L") == 2);
    plot.series[0].line = PlotLine::step;
    auto const path = path_of(svg(plot));
    CHECK(count(path, "L") == 4);
    auto const y = numbers_after(svg(plot), "cy=\"");
    // The first L ends at the first value's height.
    auto const first = path.substr(path.find('L'));
    CHECK(std::strtod(first.c_str() + first.find(' '), nullptr) == doctest::Approx(y[0]));
}

TEST_CASE("ticks are round numbers, with the digits they need and no more")
{
    CHECK(svg(plot_of({{0, 0.1}, {1, 0.45}})).find(">0.3<") != std::string::npos);
    CHECK(svg(plot_of({{0, -3}, {1, 3}})).find(">-2<") != std::string::npos);
    CHECK(svg(plot_of({{0, -3}, {1, 3}})).find(">-0<") == std::string::npos);
    CHECK(svg(plot_of({{0, 0}, {1, 123456}})).find(">100000<") != std::string::npos);
    for (Points const& points : {Points{}, Points{{0, 0}}, Points{{7, 7}, {7, 7}}, Points{{-5, -5}}, Points{{0, not_a_number}},
                                 Points{{1, 1e300}, {2, -1e300}}, Points{{1, 1e-300}, {2, 2e-300}}, Points{{1, 1e15}, {2, 1e15 + 1}}}) {
        auto const text = drawn(plot_of(points));
        CHECK(text.find("nan") == std::string::npos);
        CHECK(text.find("\"inf") == std::string::npos);
        CHECK(count(text, "<text") < 40);
    }
}

TEST_CASE("bounds cut what is outside, at the area's border")
{
    auto plot = plot_of({{1, 5}, {2, 50}, {3, 500}});
    plot.y.high = 100;
    plot.y.low = 0;
    auto const text = svg(plot);
    CHECK(text.find(">500<") == std::string::npos);
    CHECK(text.find(">100<") != std::string::npos);
    CHECK(text.find("clip-path=\"url(#area)\"") != std::string::npos);
    plot.y.high.reset();
    plot.y.low = 1000; // above all values
    drawn(plot);
}

TEST_CASE("names may hold what XML reserves")
{
    auto plot = plot_of({{0, 1}, {1, 2}});
    plot.title = "a < b & \"c\" > d\n\x01";
    plot.series[0].name = "<script>";
    auto const text = drawn(plot);
    CHECK(text.find("a &lt; b &amp; &quot;c&quot; &gt; d  <") != std::string::npos);
    CHECK(text.find("<script>") == std::string::npos);
}

TEST_CASE("series are told apart by colour and dashes, and listed in order")
{
    auto plot = plot_of({{0, 1}, {1, 2}});
    plot.series.push_back({.name = "two", .points = {{0, 2}}, .colour = 5, .dashed = true});
    plot.series.push_back({.name = "three", .points = {}, .colour = 13});
    auto const text = drawn(plot);
    CHECK(count(text, "stroke-dasharray") == 2);   // its line and its sample
    CHECK(count(text, "stroke=\"#d55e00\"") == 4); // and the rings of two; 13 is 5 again; three has no line, but a sample
    CHECK(text.find(">one<") < text.find(">two<"));
    CHECK(text.find(">two<") < text.find(">three<"));
}

TEST_CASE("dots alone are joined by nothing, in the area or in the legend")
{
    auto plot = plot_of({{0, 1}, {1, not_a_number}, {2, 3}, {3, infinite}});
    plot.series[0].colour = 5;
    auto const joined = svg(plot);
    plot.series[0].line = PlotLine::none;
    auto const text = drawn(plot);
    CHECK(count(text, "<path") == 0);
    // The same dots at the same places, and one more in the legend.
    CHECK(count(text, "<circle") == count(joined, "<circle") + 1);
    for (char const* of : {"cx=\"", "cy=\""}) {
        auto const before = numbers_after(joined, of);
        auto now = numbers_after(text, of);
        REQUIRE(now.size() == 4);
        now.pop_back();
        CHECK(now == before);
    }
    CHECK(numbers_after(text, "cx=\"").back() > numbers_after(text, "cx=\"")[2]); // right of the area
    CHECK(count(text, "fill=\"#d55e00\"") == 2);

    CHECK(count(text, "r=\"2.5\"") == 4);
    plot.series[0].dot_px = 4;
    CHECK(count(svg(plot), "r=\"4.0\"") == 4);

    plot.series[0].points.clear();
    drawn(plot);
    CHECK(count(svg(plot), "<circle") == 1); // the legend names what has no point
}

TEST_CASE("a faded series is drawn through as one, and so is its sample; others are not")
{
    auto plot = plot_of({{0, 1}, {1, 2}});
    CHECK(count(svg(plot), "opacity") == 0);
    plot.series.push_back({.name = "two", .points = {{0, 2}, {0, 2}, {1, 1}}, .line = PlotLine::none, .colour = 3, .faded = true});
    auto text = drawn(plot);
    CHECK(count(text, "opacity=\"0.6\"") == 2); // one group, so that dots over dots are no darker; and the sample
    CHECK(count(text, "opacity") == 2);
    plot.series[1].line = PlotLine::step;
    text = drawn(plot);
    CHECK(count(text, "opacity=\"0.6\"") == 2);
    plot.series[1].faded = false;
    CHECK(count(svg(plot), "opacity") == 0);
}

TEST_CASE("where lines coincide their colours alternate, and the earlier dot is the larger one")
{
    auto plot = plot_of({{0, 1}, {1, 2}, {2, 3}});
    auto const alone = svg(plot);
    plot.series.push_back({.name = "two", .points = {{0, 1}, {1, 2}, {2, 1}}, .colour = 5});
    plot.series.push_back({.name = "three", .points = {{0, 1}, {1, 2}}, .colour = 3});
    auto const text = drawn(plot);
    // Of the piece that three share the first is drawn whole, the others on it in a third each.
    CHECK(count(text, "stroke-dasharray=\"7 14\" stroke-dashoffset=\"-7\"") == 1);
    CHECK(count(text, "stroke-dasharray=\"7 14\" stroke-dashoffset=\"-14\"") == 1);
    CHECK(count(text, "stroke-dasharray") == 2);
    CHECK(text.find("stroke=\"#d55e00\" stroke-width=\"1.8\" stroke-dasharray=\"7 14\" stroke-dashoffset=\"-7\"") != std::string::npos);
    CHECK(count(text, "r=\"5.5\"") == 2); // two dots of the first have two others on them
    CHECK(count(text, "r=\"4.0\"") == 2);
    CHECK(count(text, "r=\"2.5\"") == 4);
    CHECK(numbers_after(text, "cx=\"").size() == 8);
    // A dot on a dot without lines in common makes no dashes; dots alone share nothing.
    plot.series[1].points = {{0, 3}, {1, 2}, {2, 1}};
    plot.series.pop_back();
    CHECK(count(svg(plot), "stroke-dasharray") == 0);
    CHECK(count(svg(plot), "r=\"4.0\"") == 1);
    plot.series[1].line = PlotLine::none;
    CHECK(count(svg(plot), "r=\"4.0\"") == 0);
    // Steps: the level part of the first step is shared, the rest is not.
    plot = plot_of({{0, 1}, {1, 1}, {2, 3}});
    plot.series.push_back({.name = "two", .points = {{0, 1}, {1, 2}}, .line = PlotLine::step, .colour = 5});
    plot.series[0].line = PlotLine::step;
    CHECK(count(svg(plot), "stroke-dasharray=\"7 7\" stroke-dashoffset=\"-7\"") == 1);
    // One series alone is one path, and a line that it draws twice is no line of two.
    CHECK(count(alone, "<path") == 2); // and its sample
    CHECK(count(svg(plot_of({{0, 1}, {1, 2}, {0, 1}, {1, 2}})), "stroke-dasharray") == 0);
    // Values far outside the bounds stay numbers.
    plot = plot_of({{0, 1}, {1, 1e300}, {2, -1e300}});
    plot.y.low = 0;
    plot.y.high = 2;
    drawn(plot);
    for (double const at : numbers_after(svg(plot), "cy=\"")) CHECK(std::fabs(at) <= 1e6);
}

TEST_CASE("the dots of a dashed series are rings")
{
    auto plot = plot_of({{0, 1}, {1, 2}});
    CHECK(count(svg(plot), "<g fill=\"#000000\">") == 1);
    plot.series[0].dashed = true;
    CHECK(count(svg(plot), "<g fill=\"#ffffff\" stroke=\"#000000\">") == 1);
}

TEST_CASE("what cannot be drawn is refused")
{
    constexpr auto logarithmic = PlotScale::logarithmic;
    CHECK_THROWS_AS(svg(plot_of({{1, -1}, {2, 2}}, PlotScale::linear, logarithmic)), Error);
    for (Points const& points : {Points{{0, 1}, {1, 2}}, Points{{1.7e308, 1}}}) CHECK_THROWS_AS(svg(plot_of(points, logarithmic)), Error);
    for (Points const& points : {Points{{not_a_number, 1}}, Points{{infinite, 1}}, Points{{0, -1.7e308}, {1, 1.7e308}}})
        CHECK_THROWS_AS(svg(plot_of(points)), Error);
    auto plot = plot_of({{1, 1}, {2, 2}});
    plot.x.low = 3;
    for (double const high : {3.0, infinite}) {
        plot.x.high = high;
        CHECK_THROWS_AS(svg(plot), Error);
    }
    plot = plot_of({{0, 1}, {2, 2}}, logarithmic);
    plot.x.low = 1; // the range is good, the value is not
    CHECK_THROWS_AS(svg(plot), Error);
    plot = plot_of({{1, 1}});
    plot.width = 319;
    CHECK_THROWS_AS(svg(plot), Error);
    plot.width = 320;
    plot.height = 200;
    drawn(plot);
}

TEST_CASE("the file is the text, whole")
{
    tests::Folder const folder;
    auto const plot = plot_of({{0, 1}, {1, infinite}});
    tilemesh::report::write_svg(folder.path / "a.svg", plot);
    CHECK(tests::contents(folder.path / "a.svg") == svg(plot));
    CHECK_THROWS_AS(tilemesh::report::write_svg(folder.path / "no" / "folder.svg", plot), Error);
}

TEST_SUITE_END();
