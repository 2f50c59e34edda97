// test: unoptimised test asan, without tsan
#include "../splat/support.hpp"
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/scene/lens.hpp>
#include <tilemesh/splat/homes/regions.hpp>
#include <tilemesh/splat/operations.hpp>
#include <tilemesh/splat/pose/operations.hpp>
#include <tilemesh/splat/projection.hpp>

// The numbers of cost models: their sources, and their text form.
using namespace tilemesh;

namespace {
std::string written(CostModel const& m)
{
    std::ostringstream out;
    write_cost_model(out, m);
    return out.str();
}
CostModel read(std::string const& text)
{
    std::istringstream in(text);
    return read_cost_model(in, "set.txt");
}
std::string refusal(std::string const& text)
{
    return tests::error_of([&] { read(text); });
}
/// mk2() as a file, with the first `from` replaced by `to`.
std::string changed(std::string const& from, std::string const& to)
{
    auto text = written(mk2());
    auto const at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}
/// mk2() as a file, with another line in place of a parameter's.
std::string with_line(std::string const& name, std::string const& line)
{
    auto text = written(mk2());
    auto const at = text.find('\n' + name + ' ') + 1;
    REQUIRE(at != 0);
    return text.replace(at, text.find('\n', at) - at, line);
}
constexpr char const* parameters[] = {"clock", "exchange_cost", "slot",      "projection", "routed",      "copied",        "comparison",    "pair",
                                      "pixel", "left",          "passed",    "settled",    "moving_pair", "moving_depth",  "splat_motions", "row",
                                      "mean",  "gradient",      "host_byte", "run",        "exchange",    "exchange_byte", "sync",          "vote"};
constexpr std::uint32_t most_count = 0xffffffffu;

/// A run of one superstep of one tile that has the largest count of every kind.
Trace most_of_all(std::size_t supersteps)
{
    Trace trace;
    trace.kernels = {"everything"};
    trace.operations = {{"a", "b", "c", "d", "e", "f", "g", "h"}};
    TileSample tile{0, {}, {most_count, most_count, most_count, most_count}};
    for (auto& n : tile.operations.count) n = most_count;
    trace.supersteps.assign(supersteps, {0, true, most_count, true, {tile}});
    return trace;
}
} // namespace

TEST_CASE("cost parameters: mk2 has every number, with unit and source")
{
    auto const m = mk2();
    REQUIRE(m.parameters.size() == std::size(parameters));
    for (std::size_t i = 0; i < std::size(parameters); ++i) {
        auto const& p = m.parameters[i];
        CAPTURE(p.name);
        CHECK(p.name == parameters[i]);
        CHECK(!p.unit.empty());
        auto const kind = p.source.substr(0, p.source.find(':'));
        CHECK((kind == "document" || kind == "arithmetic" || kind == "guess"));
    }
    CHECK(m.parameters[0].value == m.clock_khz);
    std::size_t const frame = std::size(splat::Operation::names);
    // Every operation that splatting counts has a price.
    for (auto const* name : splat::Operation::names) CHECK(price_of(m, name) != 0);
    for (auto const* name : splat::homes::Operation::names) CHECK(price_of(m, name) != 0);
    for (auto const* name : splat::pose::Operation::names) CHECK(price_of(m, name) != 0);
    for (std::size_t i = 0; i < m.prices.size(); ++i) {
        if (i < frame) CHECK(m.prices[i].operation == splat::Operation::names[i]);
        CHECK(m.parameters[2 + i].name == m.prices[i].operation);
        CHECK(m.parameters[2 + i].value == m.prices[i].millicycles);
    }
    // A number that no document has is marked as a guess.
    CHECK(m.parameters[22].source.starts_with("guess"));
    CHECK(m.parameters[23].source.starts_with("guess"));
}

TEST_CASE("cost parameters: mk2's numbers by hand")
{
    auto const m = mk2();
    CHECK(m.name == "mk2");
    CHECK(m.clock_khz == 1'325'000);
    CHECK(m.exchange_cost == ExchangeCost::capacity);
    for (auto const& each : std::map<std::string, std::uint64_t>{{"slot", 4 * 6000},         // 4 instructions in every 6th cycle
                                                                 {"projection", 753 * 6000}, // 425 + 60 + 122 + 146
                                                                 {"routed", 60 * 6000},      // (175 + 3 * 66 + 107) / 8
                                                                 {"copied", 190 * 6000},     // (122 + 258) / 2
                                                                 {"comparison", 30 * 6000},
                                                                 {"pair", 30'882}, // 21 / 0.68 = 30.8824
                                                                 {"pixel", 93'000},
                                                                 {"left", 175 * 6000},
                                                                 {"passed", 66 * 6000},
                                                                 {"settled", 107 * 6000},
                                                                 {"moving_pair", 206'118},   // (18.4 + 117) / 0.68 + 7 = 206.118
                                                                 {"moving_depth", 26'471},   // 18 / 0.68
                                                                 {"splat_motions", 715'000}, // 576 + 35 + 104
                                                                 {"row", 254'000},           // 159 + 10 + 85
                                                                 {"mean", 30 * 6000},        // 16 + 14
                                                                 {"gradient", 308 * 6000},   // 188 + 15 + 105
                                                                 {"host_byte", 42}})         // 1.325 GHz over 32 GB/s is 0.0414
        CHECK_MESSAGE(price_of(m, each.first) == each.second, each.first);
    CHECK(host_link_milliseconds(m, 32'000'000'000) == doctest::Approx(1000).epsilon(0.02));
    CHECK(host_link_milliseconds(m, 0) == 0);
    CHECK(host_link_milliseconds(CostModel{}, 1'000'000) == 0);
    CHECK(m.run_cycles == 20);
    CHECK(m.exchange_cycles + m.sync_cycles == 300);
    CHECK(m.sync_cycles == 150);
    CHECK(m.vote_cycles == 2 * 320 + 76 + (4 * 76 + 25) * 6);
    // Four channels of 24 KB arrive in the 24,000 cycles that are 18 us.
    CHECK(model_detail::per_thousand(4 * 24'000, m.exchange_millicycles_a_byte) == 24'000);
    CHECK(milliseconds(m, 24'000) == doctest::Approx(0.0181).epsilon(0.01));
}

namespace {
/// Counts what a projection does: an arithmetic as splat/number.hpp describes it, of one float.
struct Counting {
    static inline std::uint32_t flops, roots, others;
    struct Real {
        float v = 0;
        Real() = default;
        Real(float value) : v(value) {} // NOLINT: a number of the host is one of the kernel
        friend Real operator+(Real a, Real b) { return flop(a.v + b.v); }
        friend Real operator-(Real a, Real b) { return flop(a.v - b.v); }
        friend Real operator*(Real a, Real b) { return flop(a.v * b.v); }
        friend Real operator/(Real a, Real b) { return root(a.v / b.v); }
        friend Real operator-(Real a) { return flop(-a.v); }
        friend bool operator<(Real a, Real b) { return other(a.v < b.v); }
        friend bool operator>(Real a, Real b) { return other(a.v > b.v); }
        friend bool operator<=(Real a, Real b) { return other(a.v <= b.v); }
        friend bool operator>=(Real a, Real b) { return other(a.v >= b.v); }
    };
    struct Word {
        std::int32_t v = 0;
        Word() = default;
        Word(std::int32_t value) : v(value) {} // NOLINT
        friend Word operator+(Word a, Word b) { return other(Word{a.v + b.v}); }
        friend Word operator-(Word a, Word b) { return other(Word{a.v - b.v}); }
        friend Word operator&(Word a, Word b) { return other(Word{a.v & b.v}); }
        friend Word operator|(Word a, Word b) { return other(Word{a.v | b.v}); }
        friend Word operator^(Word a, Word b) { return other(Word{a.v ^ b.v}); }
        friend Word operator>>(Word a, int by) { return other(Word{a.v >> by}); }
        friend Word operator<<(Word a, int by) { return other(Word{a.v << by}); }
        friend bool operator<(Word a, Word b) { return other(a.v < b.v); }
        friend bool operator>(Word a, Word b) { return other(a.v > b.v); }
        friend bool operator!=(Word a, Word b) { return other(a.v != b.v); }
    };
    using Mask = bool;
    static constexpr std::uint32_t lanes = 2; // one float may return early or take a rare branch; lanes go on

    static Real flop(float v)
    {
        ++flops;
        return {v};
    }
    static Real root(float v)
    {
        ++roots;
        return {v};
    }
    template <class X>
    static X other(X x)
    {
        ++others;
        return x;
    }
    static Real all(float v) { return {v}; }
    template <class... Masks>
    static Mask every(Masks... m)
    {
        return (... & m);
    }
    static Mask negation(Mask m) { return !m; }
    static bool any(Mask m) { return m; }
    static Real select(Mask m, Real yes, Real no) { return other(m ? yes : no); }
    static Word keep(Mask m, Word v) { return other(m ? v : Word{0}); }
    static Word bits(Real v) { return other(Word{__builtin_bit_cast(std::int32_t, v.v)}); }
    static Real floats(Word v) { return other(Real{__builtin_bit_cast(float, v.v)}); }
    static Real magnitude(Real v) { return other(Real{std::fabs(v.v)}); }
    static Word truncate(Real v) { return other(Word{static_cast<std::int32_t>(v.v)}); }
    static Real real(Word v) { return other(Real{static_cast<float>(v.v)}); }
    static Real multiply_add(Real a, Real b, Real c)
    {
        ++flops;
        return flop(std::fma(a.v, b.v, c.v));
    }
    static Real square_root(Real v) { return root(std::sqrt(v.v)); }
    /// Its own steps (exponential.hpp): 9 fused, 3 others; 2 compares, 2 selects, a shift and an addition of words.
    static Real exponential(Real v)
    {
        flops += 2 * 9 + 3;
        others += 6;
        return {splat::exponential(v.v)};
    }
};
} // namespace

TEST_CASE("cost parameters: a projection does what mk2 counts")
{
    auto camera = support::flat_camera(1280, 720);
    camera.cx = 640, camera.cy = 360;
    auto const view = splat::make_view(camera, splat::Rules{});
    auto const tiling = splat::make_tiling(1280, 720, 32, 20);
    splat::Gaussian const g{{0.1f, 0.2f, 3}, {0.5f, 0.5f, 0.5f}, 0.8f, {1, 0.1f, 0.2f, 0.3f}, {-4, -4, -5}, splat::GaussianId{}};
    splat::detail::GaussianWords<Counting> const words{{0.1f, 0.2f, 3.0f}, {0.5f, 0.5f, 0.5f}, 0.8f, {1.0f, 0.1f, 0.2f, 0.3f}, {-4.0f, -4.0f, -5.0f}};
    splat::detail::SplatWords<Counting> s{};
    Counting::flops = Counting::roots = Counting::others = 0;
    auto const outcome = splat::detail::project_words<Counting>(words, view, tiling, s);
    REQUIRE(outcome.visible);
    CHECK(static_cast<std::uint32_t>(s.anchor.v) == splat::project(g, view, tiling).anchor.packed);
    CHECK(Counting::flops == KernelWork::projection_flops + KernelWork::depth_key_flops);
    CHECK(Counting::roots == KernelWork::projection_roots);
    CHECK(Counting::others == KernelWork::projection_others + KernelWork::depth_key_others);
}

TEST_CASE("cost parameters: through a lens, and by a rolling shutter, a projection counts as many sixteenths more as it does more")
{
    auto const tiling = splat::make_tiling(1280, 720, 32, 20);
    splat::detail::GaussianWords<Counting> const words{{0.1f, 0.2f, 3.0f}, {0.5f, 0.5f, 0.5f}, 0.8f, {1.0f, 0.1f, 0.2f, 0.3f}, {-4.0f, -4.0f, -5.0f}};
    auto const slots = [&](splat::Camera const& camera) {
        splat::detail::SplatWords<Counting> s{};
        Counting::flops = Counting::roots = Counting::others = 0;
        REQUIRE(splat::detail::project_words<Counting>(words, splat::make_view(camera, {}), tiling, s).visible);
        return Counting::flops / 0.68 + 5 * Counting::roots + Counting::others + KernelWork::reach;
    };
    auto camera = support::flat_camera(1280, 720);
    camera.cx = 640, camera.cy = 360;
    double const pinhole = slots(camera);
    for (bool const rolls : {false, true})
        for (char const* const text : {"pinhole", "opencv,-0.2,0.05,0.001,-0.001,0.01,0.1,0.1,0.1", "fisheye,0.01,0.01,0.01,0.01", "fov,0.9"}) {
            CAPTURE(text);
            CAPTURE(rolls);
            camera.lens = scene::lens_of_text(text);
            if (rolls) camera.shutter = {{0.01f, 0.02f, 0.01f}, {0.01f, 0.01f, 0.01f}, 0};
            double const counted = splat::projections_through(splat::make_view(camera, {}).camera, 16) - 16.0;
            double const more = 16 * (slots(camera) / pinhole - 1);
            CHECK(std::fabs(more - counted) < 0.5);
        }
    CHECK(splat::projections_through(camera, 0) == 0);
}

TEST_CASE("cost parameters: forward mode and its sums do what mk2 counts")
{
    using Real = Counting::Real;
    using Work = KernelWork;
    auto const counted = [](std::uint32_t flops, std::uint32_t roots, std::uint32_t others) {
        CHECK(Counting::flops == flops);
        CHECK(Counting::roots == roots);
        CHECK(Counting::others == others);
        Counting::flops = Counting::roots = Counting::others = 0;
    };
    Counting::flops = Counting::roots = Counting::others = 0;
    splat::pose::MovingPixel<Counting> pixel{};
    splat::pose::MovingPaint<Counting> const paint{};
    auto const motion = [](auto) { return splat::pose::PowerMotion<Counting>{}; };
    constexpr std::uint32_t blending = 8; // w, three colours, the transmittance: those are among the 18.4 of a pair
    splat::pose::blend_moving_pair<false, Counting>(pixel, Real{0.5f}, true, true, Real{1}, Real{1}, paint, motion, splat::pose::AllMotions{});
    counted(blending + Work::moving_flops, 0, Work::moving_others);
    splat::pose::blend_moving_pair<true, Counting>(pixel, Real{0.5f}, true, true, Real{1}, Real{1}, paint, motion, splat::pose::AllMotions{});
    counted(blending + Work::moving_flops + Work::moving_depth_flops, 0, Work::moving_others);

    auto const view = splat::make_view(support::flat_camera(1280, 720), splat::Rules{});
    splat::pose::detail::MotionBasis<Counting> const basis({{1}, {1}, {1}, {-0.5f}, {0.1f}, {-0.5f}, {0.1f}, {0.1f}}, view);
    using splat::pose::Column;
    auto const all = [&]<Column... Columns>(std::integer_sequence<Column, Columns...>)
    {
        (splat::pose::power_motion<Columns>(basis), ...);
    };
    all(std::integer_sequence<Column, Column::rho_x, Column::rho_y, Column::rho_z, Column::phi_x, Column::phi_y, Column::phi_z>{});
    counted(Work::motion_flops, Work::motion_roots, Work::motion_others);

    splat::pose::detail::LaneRows<Counting, 6> rows;
    Real const j[6] = {};
    rows.add(j, Real{0.1f}, 0.1f, 1, true);
    counted(Work::adding_flops, Work::adding_roots, Work::adding_others);
    for (std::uint32_t i = 0; i < 28; ++i) (void)splat::pose::detail::rounded<Counting>(Real{1}, 2.0f);
    counted(4 * Work::rounding_flops, 0, 4 * Work::rounding_others - 28); // and 28 additions of words
}

TEST_CASE("cost parameters: a model that is written and read back is equal, and is written equally")
{
    auto const m = mk2();
    auto const text = written(m);
    CHECK(read(text) == m);
    CHECK(written(read(text)) == text);

    auto other = m;
    other.name = "a machine of 2 words";
    set_parameter(other, "exchange_cost", 1, "fitted to Salad");
    CHECK(other.exchange_cost == ExchangeCost::live);
    // The bounds, and sources that look like something else.
    set_parameter(other, "clock", 1, "#1");
    set_parameter(other, "pair", most_millicycles, "a  b, (c); 7 kHz");
    set_parameter(other, "sync", most_cycles, std::string(2048, 'x'));
    set_parameter(other, "vote", 0, "M\xc3\xbcller 1984");
    CHECK(read(written(other)) == other);
    CHECK(read(written(other)) != m);

    // The stream's number format does not matter.
    std::ostringstream hex;
    hex << std::hex << std::showbase;
    hex.width(40);
    write_cost_model(hex, m);
    CHECK(hex.str() == text);
}

TEST_CASE("cost parameters: any order, comments, empty lines, blanks, line ends")
{
    std::string text = "\n# a comment\n  model \t mk2 \r\n";
    auto const m = mk2();
    for (std::size_t i = m.parameters.size(); i-- > 0;) {
        auto const& p = m.parameters[i];
        auto const value = p.name == "exchange_cost" ? "capacity" : std::to_string(p.value);
        text += "\t" + p.name + "   " + value + "\t" + p.unit + "  " + p.source + (i == 0 ? "" : " \r\n#\r\n");
    }
    auto reversed = m; // operations are listed in the order of the file
    std::reverse(reversed.prices.begin(), reversed.prices.end());
    std::reverse(reversed.parameters.begin() + 2, reversed.parameters.begin() + 19);
    CHECK(read(text) == reversed);
    CHECK(read(with_line("sync", "sync 007 cycles x")).sync_cycles == 7);
    CHECK(read(with_line("sync", "sync 7 cycles a\tb")).parameters[22].source == "a b");
}

TEST_CASE("cost parameters: every refusal names the file and the line")
{
    auto const begins = [](std::string const& text, std::string const& begin) {
        auto const said = refusal(text);
        CAPTURE(said);
        CHECK(said.starts_with("set.txt line " + begin));
        CHECK(said.find('\n') == std::string::npos);
        CHECK(said.find(" (") != std::string::npos);
        CHECK(said.find("); ") != std::string::npos);
    };
    // Lines: 1 comment, 2 model, 3 clock, 4 exchange_cost, 5 slot, ..., 26 vote.
    begins("", "0 ends the file (it holds no cost model)");
    begins("# only this\n", "1 ends the file (it holds no cost model)");
    begins("clock 1 kHz x\n", "1 begins no cost model");
    begins("model\n", "1 names no model");
    begins("model " + std::string(2049, 'm') + "\n", "1 names no model");
    begins(changed("clock", "model b\nclock"), "3 names a second model");
    begins(with_line("sync", "synch 1 cycles x"), "25 has an unknown parameter (\"synch\")");
    begins(changed("slot", "clock 1 kHz x\nslot"), "5 repeats a parameter (clock is in line 3)");
    for (auto const* name : parameters)
        if (model_detail::find_price(mk2(), name) == nullptr)
            begins(with_line(name, ""), "26 ends the file (parameter " + std::string(name) + " is missing)");
    begins("model m", "1 ends the file (parameter clock is missing)");
    for (auto const* word : {"-1", "+1", "1.5", "1e6", "0x10", "many", "1,000", "capacity", "99999999999999999999x"})
        begins(with_line("slot", std::string("slot ") + word + " millicycles x"), "5 has no whole number (slot is \"" + std::string(word) + "\")");
    std::string most = written(mk2()); // it has 17 operations
    for (int i = 0; i < 16384 - 17; ++i) most += "operation_" + std::to_string(i) + " 1 millicycles x\n";
    CHECK(read(most).prices.size() == 16384);
    begins(most + "last 1 millicycles x\n", "16394 has one operation more than 16384 (\"last\")");
    begins(with_line("slot", "slot"), "5 has an unknown parameter (\"slot\")");
    begins(with_line("slot", "slot 1 cycles x"), "5 has an unknown parameter (\"slot\"); use clock, exchange_cost, run, exchange, "
                                                 "exchange_byte, sync, vote, or the name of an operation and the unit millicycles");
    begins(with_line("slot", "slot 100000001 millicycles x"), "5 is out of range (slot is 100000001); write a value from 0 to 100000000");
    begins(with_line("slot", "slot 18446744073709551616 millicycles x"), "5 is out of range");
    begins(with_line("clock", "clock 0 kHz x"), "3 is out of range");
    begins(with_line("clock", "clock 1000000001 kHz x"), "3 is out of range");
    begins(with_line("sync", "sync 1000000000001 cycles x"), "25 is out of range");
    begins(with_line("exchange_cost", "exchange_cost any_to_any kind x"), "4 has no kind of exchange (exchange_cost is \"any_to_any\")");
    begins(with_line("exchange_cost", "exchange_cost 0 kind x"), "4 has no kind of exchange");
    begins(with_line("exchange_cost", "exchange_cost"), "4 has no kind of exchange");
    begins(with_line("sync", "sync 1"), "25 has no unit (sync is in cycles)");
    begins(with_line("sync", "sync 1 ms x"), "25 has another unit (sync is in cycles, not in \"ms\")");
    begins(with_line("sync", "sync 1 cycles"), "25 has no source");
    begins(with_line("sync", "sync 1 cycles \t "), "25 has no source");
    begins(with_line("sync", "sync 1 cycles " + std::string(2049, 'x')), "25 has too long a source");
    begins(with_line("sync", std::string("sync 1 cycles a\1b")), "25 cannot be read (it holds a control character)");
    begins(with_line("sync", std::string("sync 1 cycles a\0b", 17)), "25 cannot be read");
    begins(with_line("sync", std::string("\x1b[1m\xff", 5) + " 1 cycles x"), "25 cannot be read");
    begins(with_line("sync", "s\xff 1 cycles x"), "25 has an unknown parameter (\"s?\")");
    begins(with_line("sync", std::string(300, 's') + " 1 cycles x"), "25 has an unknown parameter (\"" + std::string(200, 's') + "...\")");

    // Lines of 4,096 bytes, and one more.
    CHECK(read(with_line("sync", "sync 1 cycles x\n#" + std::string(4095, '.'))).sync_cycles == 1);
    begins(with_line("sync", "sync 1 cycles x\n#" + std::string(4096, '.')), "26 is too long (more than 4096 bytes)");
    begins("#" + std::string(4096, '.'), "1 is too long");

    // A file name that would break the line.
    std::istringstream empty;
    CHECK_THROWS_WITH_AS(read_cost_model(empty, "a\nb"), doctest::Contains("a?b line 0"), Error);
}

TEST_CASE("cost parameters: values that cannot be written or set are refused")
{
    std::ostringstream out;
    auto const not_written = [&](char const* why, auto const& change) {
        auto m = mk2();
        change(m);
        CHECK_THROWS_WITH_AS(write_cost_model(out, m), doctest::Contains(why), Error);
    };
    not_written("its name is not one line", [](CostModel& m) { m = {}; });
    not_written("parameter clock has no source", [](CostModel& m) { m = {}, m.name = "bare"; });
    not_written("parameter sync is 1, and its source is of 150 cycles", [](CostModel& m) { m.sync_cycles = 1; });
    not_written("parameter exchange_cost is 1", [](CostModel& m) { m.exchange_cost = ExchangeCost::live; });
    not_written("projection", [](CostModel& m) { m.parameters[3].unit = "cycles"; });
    not_written("parameter clock is 1325000", [](CostModel& m) { m.parameters.push_back(m.parameters[0]); });
    not_written("25 parameters of 24", [](CostModel& m) { m.parameters.push_back({"warp", 1, "c", "fiction"}); }); // an entry without a price
    not_written("parameter vote has no source", [](CostModel& m) { m.parameters.pop_back(); });
    auto m = mk2();
    for (auto const* source : {"", " x", "x ", "a\nb", "a\tb"}) {
        not_written("parameter clock has no source", [&](CostModel& model) { model.parameters[0].source = source; });
        CHECK_THROWS_WITH_AS(set_parameter(m, "clock", 1, source), doctest::Contains("has no source that a file can hold"), Error);
    }
    CHECK(out.str().empty());

    CHECK_THROWS_WITH_AS(set_parameter(m, "warp", 1, "x"), doctest::Contains("no parameter \"warp\" (it has clock, exchange_cost, slot,"), Error);
    for (auto const& [name, value] :
         {std::pair("clock", std::uint64_t{0}), {"exchange_cost", 2}, {"run", most_cycles + 1}, {"pixel", most_millicycles + 1}})
        CHECK_THROWS_AS(set_parameter(m, name, value, "x"), Error);
    CHECK(m == mk2()); // a refused number changes nothing
    // The order of setting does not matter: the list has one order.
    CostModel again;
    again.name = m.name;
    again.prices = m.prices;
    for (std::size_t i = m.parameters.size(); i-- > 0;) set_parameter(again, m.parameters[i].name, m.parameters[i].value, m.parameters[i].source);
    CHECK(again == m);
}

TEST_CASE("cost model: the largest counts and numbers do not wrap, larger numbers are refused")
{
    CostModel m;
    for (auto const* name : {"a", "b", "c", "d", "e", "f", "g", "h"}) m.prices.push_back({name, most_millicycles});
    m.exchange_millicycles_a_byte = most_millicycles;
    m.run_cycles = m.exchange_cycles = m.sync_cycles = m.vote_cycles = most_cycles;
    auto const compute = most_cycles + std::uint64_t{most_operation_kinds} * most_count * (most_millicycles / 1000);
    auto const exchange = most_cycles + std::uint64_t{4} * most_count * (most_millicycles / 1000);
    for (auto kind : {ExchangeCost::capacity, ExchangeCost::live}) {
        m.exchange_cost = kind;
        auto const cost = model_cost(m, most_of_all(1), Grid{1, 1}); // a tile's messages come back to it, on all sides
        CHECK(cost.supersteps[0].compute == compute);
        CHECK(cost.supersteps[0].exchange == exchange);
        CHECK(cost.cycles == compute + exchange + 2 * most_cycles);
        CHECK(cost.busy[0][0] == compute);
    }
    // As many supersteps as 64 bits hold, and one more.
    auto const most = ~std::uint64_t{0} / (compute + exchange + 2 * most_cycles);
    CHECK(model_cost(m, most_of_all(most), Grid{1, 1}).cycles == most * (compute + exchange + 2 * most_cycles));
    CHECK_THROWS_WITH_AS(model_cost(m, most_of_all(most + 1), Grid{1, 1}), doctest::Contains("its cycles pass 64 bits"), Error);

    for (std::uint32_t i = 0; i < most_operation_kinds + 5; ++i) {
        auto wrong = m;
        std::uint64_t* const fixed[] = {&wrong.exchange_millicycles_a_byte, &wrong.run_cycles, &wrong.exchange_cycles, &wrong.sync_cycles,
                                        &wrong.vote_cycles};
        ++(i < most_operation_kinds ? wrong.prices[i].millicycles : *fixed[i - most_operation_kinds]);
        CHECK_THROWS_WITH_AS(model_cost(wrong, Trace{}, Grid{1, 1}), doctest::Contains("exceed 1"), Error);
    }
    CHECK(model_cost(m, Trace{}, Grid{1, 1}).cycles == 0);
}
