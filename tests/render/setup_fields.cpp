// test: unoptimised test asan tsan
// The table of a setup's fields: every member has a row, a row reads what it writes, and a mistake is told.
#include "../standard.hpp"
#include <tilemesh/render/describe.hpp>
#include <tilemesh/render/renderer_fields.hpp>
#include <tilemesh/render/setup_fields.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using render::setup_fields;
using render::SetupField;
using render::Values;

namespace {
/// Every field's text.
std::vector<std::string> texts(Setup const& setup)
{
    std::vector<std::string> out;
    for (auto const& field : setup_fields) out.push_back(field.text(setup));
    return out;
}
std::string refusal(std::vector<render::SetupValue> const& values)
{
    return tests::error_of([&] { (void)with(lossless, values); });
}
/// The values at the borders of what a field takes: each word, or the least and the most.
std::vector<double> borders(Values const& values)
{
    std::vector<double> out;
    for (auto const& word : values.words) out.push_back(static_cast<double>(word.number));
    if (values.kind != Values::word) out.insert(out.end(), {values.least, values.most});
    return out;
}
/// The fields that do not read back what they wrote into a copy of this setup.
template <class Fields>
std::vector<std::string> unlike(Fields const& fields)
{
    std::vector<std::string> out;
    for (SetupField const& field : fields)
        for (auto const value : borders(field.values)) {
            auto setup = lossless;
            field.set(setup, value);
            auto const text = field.values.text(value);
            bool const same = field.name == "quality" && text == "default" ? true : field.get(setup) == static_cast<float>(value) || field.get(setup) == value;
            if (!same || field.values.read(text) != value || field.text(setup) != text) out.emplace_back(field.name);
        }
    return out;
}
/// The table of examples/README.md.
std::string field_table()
{
    std::string text = "| field | values | meaning |\n|---|---|---|\n";
    for (auto const& field : setup_fields) {
        auto const& v = field.values;
        std::string values, meaning(field.meaning);
        for (auto const& one : v.words) values.append(values.empty() ? "`" : ", `").append(one.word).append("`");
        if (v.words.empty()) values = v.takes().substr(std::string_view("it takes a ").size());
        for (auto const& [text_of_help, in_table] : {std::pair(": {}", ""), std::pair("{} ", ""), std::pair(" | ", ", ")})
            for (auto at = meaning.find(text_of_help); at != meaning.npos; at = meaning.find(text_of_help))
                meaning.replace(at, std::string_view(text_of_help).size(), in_table);
        text += "| `" + std::string(field.name) + (field.use == SetupField::everyone ? "` * | " : "` | ") + values + " | " + meaning + " |\n";
    }
    return text;
}
} // namespace

TEST_SUITE_BEGIN("render");

TEST_CASE("a field reads the number and the text that it wrote, up to its limits")
{
    CHECK(unlike(setup_fields) == std::vector<std::string>{});
    // A row that reads another member than it writes is found.
    SetupField const wrong[] = {{"beam-slots", render::detail::in_slots, "", [](Setup const& s) { return static_cast<double>(s.sizes.road); },
                                 [](Setup& s, double n) { s.sizes.beam = static_cast<std::uint32_t>(n); }}};
    CHECK(unlike(wrong).front() == "beam-slots");
    for (auto const& field : setup_fields) {
        CAPTURE(field.name);
        for (auto const text : {"", " ", "some", "-1", "1 ", "0x1"}) CHECK(!field.values.read(text));
        if (field.values.kind == Values::word) continue;
        CHECK(!field.values.read(render::Values{}.text(field.values.most + 1)));
        if (field.values.least > 0) CHECK(!field.values.read("0"));
        CHECK(field.values.read("0.5").has_value() == (field.values.kind == Values::number));
    }
}

TEST_CASE("every member of a setup has a row, and every row a member")
{
    // A byte of a setup that no row reaches is padding, or follows from the frame.
    std::vector<unsigned char> reached(sizeof(Setup));
    for (auto const& field : setup_fields)
        for (auto const value : borders(field.values)) {
            auto before = lossless, after = lossless;
            field.set(after, value);
            unsigned char a[sizeof(Setup)], b[sizeof(Setup)];
            std::memcpy(a, &before, sizeof a), std::memcpy(b, &after, sizeof b);
            for (std::size_t i = 0; i < sizeof a; ++i) reached[i] |= a[i] != b[i];
        }
    auto const is_reached = [&](auto const& member) {
        auto const at = reinterpret_cast<unsigned char const*>(&member) - reinterpret_cast<unsigned char const*>(&lossless);
        return std::any_of(reached.begin() + at, reached.begin() + at + static_cast<std::ptrdiff_t>(sizeof member), [](auto byte) { return byte != 0; });
    };
    auto const& [name, machine, program, sizes, holds, carried, reusable, ranks, routes, blooms, sh_degree, colour, depth, alpha, rules, fit, district, record,
                 pixel, parameters] = lossless;
    auto const& [storage, road, beam, waiting, pixels, lists_fit, one_memory, homes, blocks, columns, tiles] = sizes;
    auto const each = [&](auto const&... members) { return (is_reached(members) && ...); };
    auto const any = [&](auto const&... members) { return (is_reached(members) || ...); };
    CHECK(each(name, machine.tiles, machine.clock_khz, program, holds, carried, reusable, ranks, routes, blooms, sh_degree, colour, depth, alpha));
    CHECK(each(rules.alpha_min, rules.background[2], fit, district, storage, road, beam, waiting, pixels, lists_fit, one_memory, homes));
    CHECK(!any(columns, tiles, blocks, record, pixel, parameters)); // these follow from the grid and the frame, or are of a user's own types
    std::set<std::string_view> names;
    for (auto const& field : setup_fields) {
        CHECK_MESSAGE(names.insert(field.name).second, field.name);
        CHECK(!field.meaning.empty());
        CHECK(render::find_setup_field(field.name) == &field);
    }
}

TEST_CASE("with by names is with by a function, in the order of the table")
{
    auto const narrow = with(paper, [](Setup& s) {
        s.sizes.road = s.sizes.beam = 8;
        s.holds = true;
        s.sizes.waiting = 200;
        s.reusable = false;
        s.rules.alpha_min = 0.25f;
        s.depth = true;
    });
    CHECK(texts(with(lossless, {{"alpha_min", 0.25f}, {"depth", true}, {"copies", "screen"}, {"channel-slots", 8}, {"saturation", "hold"}, {"preset", "paper"}})) ==
          texts(narrow));
    CHECK(texts(with(lossless, {{"copies", "screen"}, {"copies", "world"}})) == texts(lossless));
    CHECK(texts(with(lossless, {{"program", "homes"}})) == texts(as_homes(lossless)));
    CHECK(texts(with(lossless, {{"quality", "training"}, {"footprint", "opacity_box"}}))[render::setup_field("stop")] == "before_crossing");
    CHECK(with(lossless, {{"machine", "test"}}).sizes.storage == 40'000);
    CHECK(with(lossless, {{"tiles", 1'000'000}}).machine.tiles == 1'000'000);
}

TEST_CASE("a mistake names the nearest field, or what a field takes")
{
    CHECK(refusal({{"chanel-slots", 3}}) == "there is no field \"chanel-slots\" (a setup does not have it); write \"channel-slots\"");
    CHECK(refusal({{"colour-of-the-sky", 3}}) == "there is no field \"colour-of-the-sky\" (a setup does not have it); choose one of render::setup_fields");
    CHECK(refusal({{"saturation", "keep"}}) == "the field saturation cannot be \"keep\" (there are hold or drop); choose one of these");
    CHECK(refusal({{"sh-degree", 4}}) == "the field sh-degree cannot be \"4\" (it takes a whole number from 0 to 3); choose such a number");
    CHECK(refusal({{"channel-slots", -1}}) == "the field channel-slots cannot be \"-1\" (it takes a whole number, 0 or more, in slots); choose such a number");
    CHECK(refusal({{"storage_slots", 1}, {"alpha", true}}).empty());
}

TEST_CASE("examples/README.md has the table of the fields")
{
    std::ifstream readme(std::filesystem::path(__FILE__).parent_path() / "../../examples/README.md");
    std::string const text(std::istreambuf_iterator<char>(readme), {});
    CHECK_MESSAGE(text.find(field_table()) != text.npos, field_table());
}

TEST_CASE("a report has every field of the setup that ran, with the rules of the renderer")
{
    report::RunReport run;
    RendererOptions options;
    options.channel_slots = 7;
    auto rules = paper.rules;
    rules.footprint = Footprint::three_sigma_tiles;
    render::describe(run, with(paper, [](Setup& s) { s.ranks = true; }), rules, options);
    CHECK(run.preset == "paper");
    CHECK(run.machine.channel_slots == 7);
    CHECK(run.machine.storage_slots == 3200);
    CHECK(run.policies.saturation == "drop, largest first");
    CHECK(run.policies.footprint == "three_sigma_tiles");
    CHECK(run.policies.addressing == "recomputed");
    std::size_t fields = 0;
    for (auto const& field : setup_fields) fields += field.use != SetupField::several;
    CHECK(run.setup.size() == fields);
}

TEST_CASE("fields of RendererOptions: each row reads back what it wrote, and its default is a word of it")
{
    for (auto const& field : render::renderer_fields) {
        CAPTURE(field.name);
        CHECK(std::any_of(field.values.words.begin(), field.values.words.end(), [&](auto const& one) { return one.word == field.text({}); }));
        for (auto const value : borders(field.values)) {
            RendererOptions options;
            field.set(options, value);
            CHECK(field.get(options) == value);
            CHECK(field.values.read(field.text(options)) == value);
            CHECK((options == RendererOptions{}) == (value == field.get({})));
        }
    }
    for (auto const name : render::only_homes)
        CHECK(std::any_of(std::begin(render::renderer_fields), std::end(render::renderer_fields),
                          [name](auto const& field) { return field.name == name; }));
}

TEST_CASE("what only the anchored program has is named, with the reason")
{
    auto const name = [](splat::Setup const& setup, RendererOptions const& options) {
        return std::string(render::only_anchored(setup, options).field);
    };
    CHECK(name(lossless, {}).empty());
    CHECK(name(splat::with(lossless, {{"saturation", "drop"}}), {}) == "saturation");
    CHECK(name(splat::with(lossless, {{"copies", "screen"}}), {}) == "copies");
    CHECK(name(splat::with(lossless, {{"priority", "largest"}}), {}) == "priority");
    RendererOptions options;
    options.sizes.emplace();
    CHECK(name(lossless, options) == "sizes");
    options.tile = {0, 5};
    CHECK(name(lossless, options) == "tile");
    options.hops = 1;
    CHECK(name(lossless, options) == "hops");
    CHECK(render::only_anchored(lossless, options).why == "homes have no routing to end; rounds end a frame of homes");
}

TEST_SUITE_END();
