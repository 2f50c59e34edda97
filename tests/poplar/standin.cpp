// test: unoptimised test asan, without tsan
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <doctest/doctest.h>
#include <functional>
#include <map>
#include <memory>
#include <poplar/DeviceManager.hpp>
#include <poplar/Engine.hpp>
#include <poplar/Graph.hpp>
#include <poplar/Program.hpp>
#include <random>
#include <standin.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

// The stand-in judges the codelets, so these tests check its checks: each with a case that it must refuse and a case that it must accept.

#if defined(__SANITIZE_THREAD__)
#    define TILEMESH_TEST_TSAN 1
#elif defined(__has_feature)
#    if __has_feature(thread_sanitizer)
#        define TILEMESH_TEST_TSAN 1
#    endif
#endif

/// A vertex with one list of each access. Each test sets its compute function.
class StandinAny : public poplar::Vertex {
public:
    poplar::Vector<poplar::Input<poplar::Vector<unsigned>>> reads;
    poplar::Vector<poplar::InOut<poplar::Vector<unsigned>>> keeps;
    poplar::Vector<poplar::Output<poplar::Vector<unsigned>>> sends;
    unsigned id;
    bool compute();
};
POPLAR_STANDIN_VERTEX(StandinAny, reads, keeps, sends, id);

/// A vertex for six workers. Each test sets its compute function.
class StandinTeam : public poplar::MultiVertex {
public:
    poplar::InOut<poplar::Vector<unsigned>> words;
    bool compute(unsigned worker);
};
POPLAR_STANDIN_VERTEX(StandinTeam, words);

/// Counts up to a bound.
class StandinCount : public poplar::Vertex {
public:
    poplar::InOut<unsigned> count;
    poplar::Input<unsigned> bound;
    poplar::Output<bool> below;
    unsigned step;
    bool compute()
    {
        count = count + step;
        below = count <= bound;
        return true;
    }
};
POPLAR_STANDIN_VERTEX(StandinCount, count, bound, below, step);

/// Sums a vector that begins at a multiple of eight bytes. It has plain members of other types.
class StandinAligned : public poplar::Vertex {
public:
    poplar::Input<poplar::Vector<unsigned, poplar::VectorLayout::SPAN, 8>> words;
    poplar::Output<unsigned> sum;
    float scale;
    bool negate;
    poplar::Vector<int> table;
    bool compute()
    {
        int s = 0;
        for (unsigned w : words) s += static_cast<int>(static_cast<float>(w) * scale);
        for (int t : table) s += t;
        sum = static_cast<unsigned>(negate ? -s : s);
        return reinterpret_cast<std::uintptr_t>(words.data()) % 8 == 0;
    }
};
POPLAR_STANDIN_VERTEX(StandinAligned, words, sum, scale, negate, table);

namespace {

std::function<void(StandinAny&)> any_compute;
std::function<void(StandinTeam&, unsigned)> team_compute;

using poplar::Tensor;
using poplar::UNSIGNED_INT;
using poplar::program::Copy;
using poplar::program::Execute;
using poplar::program::Program;
using poplar::program::If;
using poplar::program::Repeat;
using poplar::program::RepeatWhileTrue;
using poplar::program::Sequence;
using standin::Settings;
using Words = std::vector<unsigned>;

constexpr unsigned poison = standin::poison_word;

/// Writes to memory that a vertex may not touch. AddressSanitizer does not see the write.
__attribute__((no_sanitize("address"), noinline)) void poke(void* at, unsigned char value)
{
    *static_cast<unsigned char volatile*>(at) = value;
}

/// The text of the error of type E that `action` throws; empty if it throws none.
template <class E, class Action>
std::string refusal(Action const& action)
{
    try {
        action();
    } catch (E const& error) {
        return error.what();
    }
    return {};
}
bool says(std::string const& text, char const* part)
{
    bool const one_line = text.find('\n') == std::string::npos && text.find(" (") != std::string::npos &&
                          text.find("); ") != std::string::npos;
    bool const there = text.find(part) != std::string::npos;
    if (!one_line || !there) MESSAGE(text);
    return one_line && there;
}

/// A small machine with a graph. Streams give words to tensors and take words from them.
struct Rig {
    explicit Rig(Settings const& wanted = {.tiles = 4, .tile_bytes = 65536}) : settings(wanted)
    {
        auto devices = poplar::DeviceManager::createDeviceManager().getDevices(poplar::TargetType::IPU, 1);
        device = std::move(devices.at(0));
        device.attach();
        graph = std::make_unique<poplar::Graph>(device.getTarget());
        graph->addCodelets("codelets.gp");
    }

    /// A variable of words on one tile.
    Tensor words(std::string const& name, std::size_t n, unsigned tile)
    {
        Tensor const t = graph->addVariable(UNSIGNED_INT, {n}, name);
        graph->setTileMapping(t, tile);
        return t;
    }
    Tensor scalar(poplar::Type type, std::string const& name, unsigned tile)
    {
        Tensor const t = graph->addVariable(type, {}, name);
        graph->setTileMapping(t, tile);
        return t;
    }
    /// A variable whose row i is on tile i.
    Tensor rows(std::string const& name, std::size_t n, std::size_t row)
    {
        Tensor const t = graph->addVariable(UNSIGNED_INT, {n, row}, name);
        for (unsigned i = 0; i < n; ++i) graph->setTileMapping(t[i], i);
        return t;
    }

    poplar::VertexRef any(poplar::ComputeSet const& set, unsigned tile, std::vector<Tensor> const& reads,
                          std::vector<Tensor> const& keeps, std::vector<Tensor> const& sends, unsigned id = 0)
    {
        auto const v = graph->addVertex(set, "StandinAny");
        graph->connect(v["reads"], reads);
        graph->connect(v["keeps"], keeps);
        graph->connect(v["sends"], sends);
        graph->setInitialValue(v["id"], id);
        graph->setTileMapping(v, tile);
        return v;
    }

    /// A program that writes words to a tensor.
    Program give(Tensor const& t, Words const& words)
    {
        buffers.push_back(std::make_unique<Words>(words));
        auto const name = "give " + std::to_string(buffers.size());
        return Copy(graph->addHostToDeviceFIFO(name, UNSIGNED_INT, t.numElements()), t, false, name);
    }
    /// A program that fetches a tensor's words. After its run, `taken` has the words.
    Program take(Tensor const& t)
    {
        buffers.push_back(std::make_unique<Words>(t.numElements()));
        auto const name = "take " + std::to_string(buffers.size());
        return Copy(t, graph->addDeviceToHostFIFO(name, t.elementType(), t.numElements()), false, name);
    }
    Words const& taken(std::size_t i = 0) const { return *buffers.at(buffers.size() - 1 - i); }

    poplar::Engine build(std::vector<Program> const& programs) const
    {
        poplar::Engine engine(*graph, programs);
        for (std::size_t i = 0; i < buffers.size(); ++i)
            for (char const* way : {"give ", "take "}) try {
                    engine.connectStream(way + std::to_string(i + 1), buffers[i]->data());
                } catch (poplar::stream_connection_error const&) {
                    // the stream has the other direction
                }
        engine.load(device);
        return engine;
    }
    poplar::Engine run(Program const& program) const
    {
        poplar::Engine engine = build({program});
        engine.run(0);
        return engine;
    }

    standin::With settings;
    poplar::Device device;
    std::unique_ptr<poplar::Graph> graph;
    std::vector<std::unique_ptr<Words>> buffers; ///< buffer i - 1 is that of stream "give i" or "take i"
};

/// The words of a view of a {3, 4} variable. The variable holds 0 to 11 and lies on the tiles in uneven pieces.
Words view(std::function<Tensor(Tensor const&)> const& of)
{
    Rig rig;
    Tensor const t = rig.graph->addVariable(UNSIGNED_INT, {3, 4}, "t");
    rig.graph->setTileMapping(t, 0);
    rig.graph->setTileMapping(t.flatten().slice(3, 6), 2);
    rig.graph->setTileMapping(t.flatten().slice(7, 8), 1);
    Words counted(12);
    for (unsigned i = 0; i < 12; ++i) counted[i] = i;
    Program const give = rig.give(t, counted);
    Program const take = rig.take(of(t));
    rig.run(Sequence({give, take}));
    return rig.taken();
}

} // namespace

bool StandinAny::compute()
{
    any_compute(*this);
    return true;
}
bool StandinTeam::compute(unsigned worker)
{
    team_compute(*this, worker);
    return true;
}

TEST_CASE("views of a tensor show its elements in row-major order")
{
    using poplar::concat;
    using Shape = std::vector<std::size_t>;
    CHECK(view([](Tensor const& t) { return t; }) == Words{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
    CHECK(view([](Tensor const& t) { return t[2]; }) == Words{8, 9, 10, 11});
    CHECK(view([](Tensor const& t) { return t[1][2]; }) == Words{6});
    CHECK(view([](Tensor const& t) { return t.slice(1, 3); }) == Words{4, 5, 6, 7, 8, 9, 10, 11});
    CHECK(view([](Tensor const& t) { return t.slice(1, 3, 1); }) == Words{1, 2, 5, 6, 9, 10});
    CHECK(view([](Tensor const& t) { return t.slice(1, 3, 1).slice(2, 3); }) == Words{9, 10});
    CHECK(view([](Tensor const& t) { return t.slice(2, 2); }).empty());
    CHECK(view([](Tensor const& t) { return t.reshape({2, 3, 2})[1][2]; }) == Words{10, 11});
    CHECK(view([](Tensor const& t) { return t.reshape({2, 3, 2}).slice(1, 2, 1); }) == Words{2, 3, 8, 9});
    CHECK(view([](Tensor const& t) { return t[0].slice(0, 2).broadcast(3, 0); }) == Words{0, 1, 0, 1, 0, 1});
    CHECK(view([](Tensor const& t) { return t.slice(0, 2, 1).broadcast(2, 1); }) ==
          Words{0, 1, 0, 1, 4, 5, 4, 5, 8, 9, 8, 9});
    CHECK(view([](Tensor const& t) { return t[0].broadcast(0, 0); }).empty());
    CHECK(view([](Tensor const& t) { return concat(t[2], t[0]); }) == Words{8, 9, 10, 11, 0, 1, 2, 3});
    CHECK(view([](Tensor const& t) { return concat(t.slice(3, 4, 1), t.slice(0, 1, 1), 1); }) == Words{3, 0, 7, 4, 11, 8});
    CHECK(view([](Tensor const& t) {
              return concat({t.slice(1, 2), t.slice(0, 0), t.slice(0, 1)});
          }) == Words{4, 5, 6, 7, 0, 1, 2, 3});

    Rig rig;
    Tensor const t = rig.graph->addVariable(UNSIGNED_INT, {3, 4}, "t");
    CHECK(t.slice(1, 3, 1).shape() == Shape{3, 2});
    CHECK(t[1].shape() == Shape{4});
    CHECK(t[1][1].shape().empty());
    CHECK(t[1][1].rank() == 0);
    CHECK(t[1][1].numElements() == 1);
    CHECK(t.flatten().shape() == Shape{12});
    CHECK(t.broadcast(2, 1).shape() == Shape{3, 8});
    CHECK(concat(t, t).shape() == Shape{6, 4});
    CHECK(concat(t, t, 1).shape() == Shape{3, 8});
    CHECK(t.elementType() == UNSIGNED_INT);

    using poplar::tensor_creation_error;
    CHECK(says(refusal<tensor_creation_error>([&] { t.slice(2, 4); }), "[2, 4)"));
    CHECK(says(refusal<tensor_creation_error>([&] { t.slice(2, 1); }), "[2, 1)"));
    CHECK(says(refusal<tensor_creation_error>([&] { t.slice(0, 1, 2); }), "dimension 2"));
    CHECK(says(refusal<tensor_creation_error>([&] { t[3]; }), "element 3"));
    CHECK(says(refusal<tensor_creation_error>([&] { t[0][0][0]; }), "element 0"));
    CHECK(says(refusal<tensor_creation_error>([&] { t.reshape({11}); }), "{11}"));
    CHECK(says(refusal<tensor_creation_error>([&] { concat(t, t[0]); }), "{4}"));
    CHECK(says(refusal<tensor_creation_error>([&] { concat(t, t.slice(0, 3, 1)); }), "cannot be joined"));
    CHECK(says(refusal<tensor_creation_error>([&] { concat(t, rig.graph->addVariable(poplar::FLOAT, {3, 4})); }), "float"));
    CHECK(says(refusal<tensor_creation_error>([&] { concat(std::vector<Tensor>{}); }), "empty"));
}

TEST_CASE("a row of a large variable is one interval, and neighbours that are joined become one")
{
    Rig rig;
    Tensor const t = rig.graph->addVariable(UNSIGNED_INT, {1440, 48000}, "t");
    CHECK(t[1439].parts() ==
          std::vector<standin::detail::Interval>{{0, std::size_t{1439} * 48000, std::size_t{1440} * 48000}});
    CHECK(poplar::concat(t[7], t[8]).parts().size() == 1);
    CHECK(poplar::concat(t[8], t[7]).parts().size() == 2);
    CHECK(t.slice(0, 1, 1).parts().size() == 1440);
}

TEST_CASE("a tile mapping is the last one that was given to each element")
{
    std::mt19937 random(5);
    for (unsigned round = 0; round < 200; ++round) {
        standin::detail::Variable variable{"v", UNSIGNED_INT, 20, {}};
        std::array<unsigned, 20> expected;
        expected.fill(standin::detail::no_tile);
        for (unsigned i = 0; i < 8; ++i) {
            std::size_t const a = random() % 21, b = random() % 21;
            auto const tile = static_cast<unsigned>(random() % 3);
            variable.map(std::min(a, b), std::max(a, b), tile);
            std::fill(expected.begin() + static_cast<int>(std::min(a, b)),
                      expected.begin() + static_cast<int>(std::max(a, b)), tile);
            std::array<unsigned, 20> found;
            found.fill(standin::detail::no_tile);
            std::size_t end = 0;
            unsigned last = standin::detail::no_tile;
            for (auto const& m : variable.mapping) {
                REQUIRE(m.begin < m.end);
                REQUIRE((m.begin > end || (m.begin == end && m.tile != last))); // the mapping is ascending and merged
                std::fill(found.begin() + static_cast<int>(m.begin), found.begin() + static_cast<int>(m.end), m.tile);
                end = m.end;
                last = m.tile;
            }
            REQUIRE(found == expected);
        }
    }
}

TEST_CASE("two uses of one element of which one writes are found exactly where there are such")
{
    std::mt19937 random(6);
    unsigned conflicts = 0;
    for (unsigned round = 0; round < 5000; ++round) {
        std::vector<standin::detail::Use> uses;
        std::size_t const n = random() % 6;
        for (std::size_t i = 0; i < n; ++i) {
            std::size_t const begin = random() % 30;
            uses.push_back({{static_cast<unsigned>(random() % 2), begin, begin + 1 + random() % 6}, random() % 3 == 0, i});
        }
        bool expected = false;
        for (auto const& a : uses)
            for (auto const& b : uses)
                expected |= a.who != b.who && (a.writes || b.writes) && a.part.variable == b.part.variable &&
                            a.part.begin < b.part.end && b.part.begin < a.part.end;
        auto const found = standin::detail::conflict(uses);
        REQUIRE(found.has_value() == expected);
        if (found) {
            ++conflicts;
            REQUIRE((found->first.writes || found->second.writes));
            REQUIRE(found->first.part.begin < found->second.part.end);
            REQUIRE(found->second.part.begin < found->first.part.end);
        }
    }
    CHECK(conflicts > 500);
    CHECK(conflicts < 4500);
}

TEST_CASE("values become elements of their type, or are refused where they do not fit")
{
    using standin::detail::half_bits;
    CHECK(half_bits(0.0f) == 0x0000);
    CHECK(half_bits(-0.0f) == 0x8000);
    CHECK(half_bits(1.0f) == 0x3c00);
    CHECK(half_bits(-2.5f) == 0xc100);
    CHECK(half_bits(65504.0f) == 0x7bff);
    CHECK(half_bits(65519.0f) == 0x7bff);
    CHECK(half_bits(65520.0f) == 0x7c00);           // a tie rounds to the even one: infinity
    CHECK(half_bits(1.0f + 1.0f / 2048) == 0x3c00); // ties to even
    CHECK(half_bits(1.0f + 3.0f / 2048) == 0x3c02);
    CHECK(half_bits(0x1p-14f) == 0x0400);
    CHECK(half_bits(0x1p-24f) == 0x0001);
    CHECK(half_bits(0x1p-25f) == 0x0000);
    CHECK(half_bits(0x1.8p-25f) == 0x0001);
    CHECK(half_bits(0x1.ffep-15f) == 0x0400); // rounds up to the least normal half

    unsigned char bytes[4];
    standin::detail::store_element(poplar::SHORT, -2, bytes);
    CHECK(bytes[0] == 0xfe);
    CHECK(bytes[1] == 0xff);
    standin::detail::store_element(poplar::FLOAT, 3, bytes);
    float f;
    std::memcpy(&f, bytes, 4);
    CHECK(f == 3.0f);
    CHECK(says(refusal<poplar::type_error>([&] { standin::detail::store_element(UNSIGNED_INT, -1, bytes); }), "-1"));
    CHECK(says(refusal<poplar::type_error>([&] { standin::detail::store_element(poplar::UNSIGNED_CHAR, 256, bytes); }),
               "256"));
    CHECK(refusal<poplar::type_error>([&] { standin::detail::store_element(poplar::UNSIGNED_CHAR, 255, bytes); }).empty());
    CHECK(says(refusal<poplar::type_error>([&] { standin::detail::type_named("Record"); }), "Record"));
}

TEST_CASE("a Copy moves what it names and nothing else, and its moves from tile to tile can be asked for")
{
    Rig rig;
    Tensor const from = rig.rows("from", 3, 4), to = rig.rows("to", 3, 4);
    // The last two words of row i go to row i - 1, as on a channel to a neighbour.
    Copy const shift(from.slice(1, 3).slice(2, 4, 1), to.slice(0, 2).slice(0, 2, 1), false, "shift");
    Copy const local(from[2], to[2]);
    Copy const itself(from[0], from[0]);
    auto const clear = rig.give(to, Words(12, 9)), fill = rig.give(from, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
    auto const take = rig.take(to), take_from = rig.take(from);
    auto const engine = rig.run(Sequence({clear, fill, shift, local, itself, take, take_from}));
    CHECK(rig.taken(1) == Words{6, 7, 9, 9, 10, 11, 9, 9, 8, 9, 10, 11});
    CHECK(rig.taken(0) == Words{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});

    using standin::Move;
    CHECK(standin::moves(engine, shift) == std::vector<Move>{{1, 0, 2}, {2, 1, 2}});
    CHECK(standin::moves(engine, local) == std::vector<Move>{{2, 2, 4}});
    CHECK(standin::moves(engine, itself).empty());
    auto const all = standin::exchanges(engine);
    REQUIRE(all.size() == 3);
    CHECK(all[0].name == "shift");
    CHECK(all[0].kind == standin::Exchange::Kind::copy);
    CHECK(all[0].moves == standin::moves(engine, shift));
    CHECK(all[1].name == "from -> to");
    Copy const unknown(from[2], to[2]);
    CHECK(says(refusal<poplar::control_program_error>([&] { standin::moves(engine, unknown); }), "no moves"));
    CHECK(says(refusal<poplar::control_program_error>([&] { standin::moves(engine, take); }), "no moves"));

    auto const counts = standin::last_run(engine);
    CHECK(counts.copies == 3);
    CHECK(counts.host_copies == 4);
    CHECK(counts.executes == 0);
    CHECK(counts.by_name.at("shift") == 1);
}

TEST_CASE("a Copy is refused where its operands differ or are not of the engine's graph")
{
    Rig rig, other;
    Tensor const a = rig.words("a", 8, 0), b = rig.words("b", 8, 1), strange = other.words("strange", 8, 0);
    using poplar::control_program_error;
    CHECK(says(refusal<control_program_error>([&] { Copy(a, b.slice(0, 7)); }), "{7}"));
    CHECK(says(refusal<control_program_error>([&] { Copy(a, b.reshape({2, 4})); }), "{2, 4}"));
    CHECK(says(refusal<control_program_error>([&] { Copy(a, rig.graph->addVariable(poplar::FLOAT, {8})); }), "float"));
    Rig whole;
    Tensor const t = whole.words("t", 8, 0);
    CHECK(says(refusal<control_program_error>([&] { whole.build({Copy(strange, t)}); }), "another graph"));
    CHECK(says(refusal<control_program_error>([&] { whole.build({Copy(t, strange)}); }), "another graph"));
}

TEST_CASE("a Copy that reads or writes an element twice is refused when the engine is built")
{
    Rig rig;
    Tensor const a = rig.words("a", 8, 0), b = rig.words("b", 8, 1);
    Tensor const constant = rig.graph->addConstant<unsigned>(UNSIGNED_INT, {8}, 5u, "five");
    rig.graph->setTileMapping(constant, 0);
    auto const built = [&](Program const& p) { return refusal<poplar::control_program_error>([&] { rig.build({p}); }); };
    CHECK(says(built(Copy(a.slice(0, 5), a.slice(4, 8).broadcast(2, 0).slice(0, 5))), "twice"));
    CHECK(says(built(Copy(a.slice(0, 5), a.slice(3, 8))), "element 3 of variable a twice"));
    CHECK(built(Copy(a.slice(0, 4), a.slice(4, 8))).empty());
    CHECK(says(built(Copy(a.slice(0, 4), b.slice(0, 2).broadcast(2, 0))), "its destination has it twice"));
    CHECK(built(Copy(b.slice(0, 2).broadcast(2, 0), a.slice(0, 4))).empty());
    CHECK(says(built(Copy(a, constant)), "five"));
    CHECK(built(Copy(constant, a)).empty());
}

TEST_CASE("constants hold their values, wherever they lie")
{
    Rig rig;
    unsigned const values[] = {3, 1, 4, 1, 5};
    Tensor const five = rig.graph->addConstant<unsigned>(UNSIGNED_INT, {5}, values, "five");
    Tensor const same = rig.graph->addConstant(poplar::UNSIGNED_INT, {3}, 7, "same");
    Tensor const flag = rig.graph->addConstant(poplar::BOOL, {4}, true, "flag");
    rig.graph->setTileMapping(five.slice(0, 2), 3);
    rig.graph->setTileMapping(five.slice(2, 5), 1);
    rig.graph->setTileMapping(same, 0);
    rig.graph->setTileMapping(flag, 0);
    auto const take = rig.take(poplar::concat(same, five)), take_flag = rig.take(flag);
    auto const engine = rig.run(Sequence({take, take_flag}));
    CHECK(rig.taken(1) == Words{7, 7, 7, 3, 1, 4, 1, 5});
    CHECK(rig.taken(0)[0] == 0x01010101u);
    CHECK(standin::tile_bytes(engine, 1).variables == std::map<std::string, std::size_t>{{"five", 12}});
}

TEST_CASE(
    "Repeat runs its body as often as it says, also 0 times, and sequences hold what was added before they were copied")
{
    for (unsigned const n : {0u, 1u, 5u}) {
        Rig rig;
        Tensor const count = rig.words("count", 1, 2);
        auto const set = rig.graph->addComputeSet("count");
        rig.any(set, 2, {}, {count}, {});
        any_compute = [](StandinAny& v) { ++v.keeps[0][0]; };
        Sequence twice;
        twice.add(Execute(set));
        twice.add(Execute(set));
        Repeat const body(n, twice);
        twice.add(Execute(set)); // `body` keeps its own copy of the old sequence
        auto const zero = rig.give(count, {100}), take = rig.take(count);
        auto const engine = rig.run(Sequence({zero, body, Repeat(2, Repeat(3, Execute(set))), take}));
        CHECK(rig.taken() == Words{100 + 2 * n + 6});
        CHECK(standin::last_run(engine).executes == 2 * n + 6);
        CHECK(standin::last_run(engine).vertices == 2 * n + 6);
        CHECK(standin::last_run(engine).by_name.at("count") == 2 * n + 6);
    }
}

TEST_CASE("RepeatWhileTrue runs its condition, and its body while that leaves true")
{
    for (unsigned const bound : {0u, 1u, 4u}) {
        Rig rig;
        Tensor const count = rig.scalar(UNSIGNED_INT, "count", 1), limit = rig.scalar(UNSIGNED_INT, "bound", 1);
        Tensor const go = rig.scalar(poplar::BOOL, "go", 1), passes = rig.words("passes", 1, 0);
        auto const condition = rig.graph->addComputeSet("condition"), body = rig.graph->addComputeSet("body");
        auto const v = rig.graph->addVertex(condition, "StandinCount");
        rig.graph->connect(v["count"], count);
        rig.graph->connect(v["bound"], limit);
        rig.graph->connect(v["below"], go);
        rig.graph->setInitialValue(v["step"], 1u);
        rig.graph->setPerfEstimate(v, 20);
        rig.graph->setTileMapping(v, 1);
        rig.any(body, 0, {}, {passes}, {});
        any_compute = [](StandinAny& w) { ++w.keeps[0][0]; };
        auto const start =
            Sequence({rig.give(count.reshape({1}), {0}), rig.give(limit.reshape({1}), {bound}), rig.give(passes, {0})});
        auto const take = rig.take(poplar::concat(passes, count.reshape({1})));
        auto engine = rig.run(Sequence({start, RepeatWhileTrue(Execute(condition), go, Execute(body)), take}));
        CHECK(rig.taken() == Words{bound, bound + 1});
        CHECK(standin::last_run(engine).by_name["condition"] == bound + 1);
        CHECK(standin::last_run(engine).by_name["body"] == bound);

        standin::settings().while_limit = bound;
        CHECK_NOTHROW(engine.run(0));
        if (bound > 0) {
            standin::settings().while_limit = bound - 1;
            CHECK(says(refusal<poplar::application_runtime_error>([&] { engine.run(0); }), "did not end"));
        }
    }
    Rig rig;
    Tensor const go = rig.scalar(poplar::BOOL, "go", 1);
    CHECK(says(refusal<poplar::application_runtime_error>([&] { rig.run(RepeatWhileTrue(Sequence(), go, Sequence())); }),
               "no bool"));
    using poplar::control_program_error;
    CHECK(says(refusal<control_program_error>([&] { RepeatWhileTrue(Sequence(), go.reshape({1}), Sequence()); }), "{1}"));
    CHECK(says(refusal<control_program_error>(
                   [&] { RepeatWhileTrue(Sequence(), rig.scalar(UNSIGNED_INT, "n", 0), Sequence()); }),
               "unsigned"));
}

TEST_CASE("If runs one of two programs, as its predicate says")
{
    for (unsigned const bound : {0u, 5u}) {
        Rig rig;
        Tensor const count = rig.scalar(UNSIGNED_INT, "count", 1), limit = rig.scalar(UNSIGNED_INT, "bound", 1);
        Tensor const go = rig.scalar(poplar::BOOL, "go", 1), runs = rig.words("runs", 1, 0);
        auto const condition = rig.graph->addComputeSet("condition"), one = rig.graph->addComputeSet("one"), other = rig.graph->addComputeSet("other");
        auto const v = rig.graph->addVertex(condition, "StandinCount");
        rig.graph->connect(v["count"], count);
        rig.graph->connect(v["bound"], limit);
        rig.graph->connect(v["below"], go);
        rig.graph->setInitialValue(v["step"], 1u);
        rig.graph->setPerfEstimate(v, 20);
        rig.graph->setTileMapping(v, 1);
        rig.any(one, 0, {}, {runs}, {});
        rig.any(other, 0, {}, {runs}, {});
        any_compute = [](StandinAny& w) { ++w.keeps[0][0]; };
        auto const start =
            Sequence({rig.give(count.reshape({1}), {0}), rig.give(limit.reshape({1}), {bound}), rig.give(runs, {0}), Execute(condition)});
        auto engine = rig.run(Sequence({start, If(go, Execute(one), Sequence({Execute(other), Execute(other)})), rig.take(runs)}));
        CHECK(rig.taken() == Words{bound == 0 ? 2u : 1u});
        CHECK(standin::last_run(engine).by_name["one"] == (bound == 0 ? 0u : 1u));
    }
    Rig rig;
    Tensor const go = rig.scalar(poplar::BOOL, "go", 1);
    CHECK(says(refusal<poplar::application_runtime_error>([&] { rig.run(If(go, Sequence(), Sequence())); }), "An If has a predicate that is no bool"));
    CHECK(says(refusal<poplar::control_program_error>([&] { If(go.reshape({1}), Sequence(), Sequence()); }), "{1}"));
}

TEST_CASE("a stream reads or writes the same host memory each time, or walks round a buffer")
{
    Rig rig;
    Tensor const t = rig.rows("t", 2, 2);
    auto const in = rig.graph->addHostToDeviceFIFO("in", UNSIGNED_INT, 4),
               out = rig.graph->addDeviceToHostFIFO("out", UNSIGNED_INT, 4);
    poplar::Engine engine(*rig.graph, {Sequence({Copy(in, t), Copy(t, out)}), Copy(in, t[1]), Copy(t[1], out)});
    CHECK(says(refusal<poplar::poplar_error>([&] { engine.run(0); }), "call load first"));
    engine.load(rig.device);
    CHECK(says(refusal<poplar::stream_connection_error>([&] { engine.run(0); }), "Stream in goes nowhere"));
    CHECK(says(refusal<poplar::stream_connection_error>([&] { engine.connectStream("inn", nullptr); }), "inn"));
    Words source{1, 2, 3, 4, 5, 6, 7, 8}, sink(4);
    engine.connectStream("in", source.data());
    engine.connectStream("out", sink.data());
    engine.run(0);
    CHECK(sink == Words{1, 2, 3, 4});
    source[0] = 9;
    engine.run(0);
    CHECK(sink == Words{9, 2, 3, 4});
    engine.connectStream("in", source.data(), source.data() + 8);
    engine.run(0);
    engine.run(0);
    CHECK(sink == Words{5, 6, 7, 8});
    engine.run(0);
    CHECK(sink == Words{9, 2, 3, 4});
    sink.assign(4, 0);
    engine.connectStream("in", source.data() + 6);
    engine.run(1); // half of the words of the stream
    engine.run(2);
    CHECK(sink == Words{7, 8, 0, 0});
    CHECK(says(refusal<poplar::control_program_error>([&] { engine.run(3); }), "no program 3"));

    using poplar::control_program_error;
    CHECK(says(refusal<control_program_error>([&] { Copy(t, in); }), "against stream in"));
    CHECK(says(refusal<control_program_error>([&] { Copy(out, t); }), "against stream out"));
    CHECK(says(refusal<control_program_error>([&] { Copy(in, t.broadcast(2, 0)); }), "up to 4"));
    CHECK(
        says(refusal<control_program_error>([&] { Copy(in, rig.graph->addVariable(poplar::INT, {4})); }), "unsigned int"));
    CHECK(says(refusal<poplar::stream_connection_error>([&] { rig.graph->addHostToDeviceFIFO("out", UNSIGNED_INT, 4); }),
               "two streams out"));
}

TEST_CASE("devices are those asked for, an engine runs on an attached one of its size")
{
    Rig rig;
    auto const manager = poplar::DeviceManager::createDeviceManager();
    CHECK(manager.getDevices(poplar::TargetType::IPU, 2).empty());
    CHECK(manager.getDevices(poplar::TargetType::CPU, 1).empty());
    CHECK(rig.device.getTarget().getNumTiles() == 4);
    CHECK(rig.device.getTarget().getBytesPerTile() == 65536);
    CHECK(rig.device.getTarget().getNumWorkerContexts() == 6);
    CHECK(Settings{}.tiles == 1472);
    CHECK(Settings{}.tile_bytes == 624 * 1024);
    poplar::Engine engine(*rig.graph, Sequence());
    CHECK_FALSE(rig.device.attach());
    rig.device.detach();
    CHECK(says(refusal<poplar::poplar_error>([&] { engine.load(rig.device); }), "not attached"));
    CHECK(rig.device.attach());
    CHECK_NOTHROW(engine.load(rig.device));
    standin::settings().tiles = 5;
    poplar::Device const larger;
    larger.attach();
    CHECK(says(refusal<poplar::poplar_error>([&] { engine.load(larger); }), "5 tiles"));
}

TEST_CASE("a vertex sees the tensors connected to its lists, in their order, and its plain members")
{
    Rig rig;
    Tensor const t = rig.rows("t", 2, 6), out = rig.words("out", 4, 1);
    auto const set = rig.graph->addComputeSet("set");
    auto const v = rig.graph->addVertex(set, "StandinAny");
    rig.graph->setFieldSize(v["reads"], 3);
    rig.graph->connect(v["reads"][2], t[1].slice(0, 1)); // a list may be connected in any order
    rig.graph->connect(v["reads"][0], t[1].slice(4, 6));
    rig.graph->connect(v["reads"][1], t[1].slice(3, 3)); // an edge of no elements
    rig.graph->setFieldSize(v["keeps"], 0);
    rig.graph->connect(v["sends"], out.reshape({2, 2})); // the rows of a matrix become a list
    rig.graph->setInitialValue(v["id"], 77u);
    rig.graph->setTileMapping(v, 1);
    any_compute = [](StandinAny& self) {
        REQUIRE(self.reads.size() == 3);
        CHECK(self.reads[0].size() == 2);
        CHECK(self.reads[1].size() == 0);
        CHECK(self.reads[2].size() == 1);
        CHECK(self.keeps.size() == 0);
        REQUIRE(self.sends.size() == 2);
        REQUIRE(self.sends[1].size() == 2);
        self.sends[0][0] = self.reads[0][0];
        self.sends[0][1] = self.reads[0][1];
        self.sends[1][0] = self.reads[2][0];
        self.sends[1][1] = self.id;
    };
    auto const give = rig.give(t, {0, 1, 2, 3, 4, 5, 10, 11, 12, 13, 14, 15}), take = rig.take(out);
    auto const engine = rig.run(Sequence({give, Execute(set), take}));
    CHECK(rig.taken() == Words{14, 15, 10, 77});
    CHECK(standin::exchanges(engine).empty());
    // Three lists of 8 bytes each, 3 + 0 + 2 inner vectors of 8 bytes each, and one word.
    CHECK(standin::tile_bytes(engine, 1).vertex_state == 3 * 8 + 5 * 8 + 4);
    CHECK(standin::tile_bytes(engine, 0).vertex_state == 0);
    CHECK(standin::tile_bytes(engine, 1).temporaries == 0);
}

TEST_CASE(
    "an edge that is not aligned as its field wants is used through a temporary; members and tables take their values")
{
    Rig rig;
    Tensor const words = rig.words("words", 8, 0), sum = rig.scalar(UNSIGNED_INT, "sum", 0);
    auto const take = rig.take(sum.reshape({1}));
    auto const give = rig.give(words, {1, 2, 3, 4, 5, 6, 7, 8});
    for (unsigned const first : {0u, 1u, 2u}) {
        auto const set = rig.graph->addComputeSet("set");
        auto const v = rig.graph->addVertex(set, "StandinAligned");
        rig.graph->connect(v["words"], words.slice(first, first + 3));
        rig.graph->connect(v["sum"], sum);
        rig.graph->setInitialValue(v["scale"], 2);
        rig.graph->setInitialValue(v["negate"], first == 1);
        rig.graph->setInitialValue(v["table"], std::vector<int>{100, -10});
        rig.graph->setTileMapping(v, 0);
        auto const engine = rig.run(Sequence({give, Execute(set), take}));
        unsigned const expected = 2 * (3 * first + 6) + 90;
        CHECK(rig.taken(1) == Words{first == 1 ? 0u - expected : expected});
        CHECK(standin::tile_bytes(engine, 0).temporaries ==
              (first == 0 ? 0u : 12u)); // the temporary of set 1, which later engines have too
    }
}

TEST_CASE("remote and scattered edges are gathered before and scattered after a compute set, and this is reported")
{
    Rig rig;
    Tensor const t = rig.rows("t", 3, 4), kept = rig.rows("kept", 3, 2), out = rig.rows("out", 3, 2);
    auto const set = rig.graph->addComputeSet("reduce");
    // Column 1 of all tiles as one vector, remote InOut and Output vectors, and one local edge.
    auto const v = rig.any(set, 1, {t.slice(1, 2, 1).flatten(), t[0].broadcast(2, 0), t[1]}, {kept[2], kept[1]},
                           {out.slice(0, 1, 1).flatten()});
    static_cast<void>(v);
    any_compute = [](StandinAny& self) {
        CHECK(Words(self.reads[0].begin(), self.reads[0].end()) == Words{1, 11, 21});
        CHECK(Words(self.reads[1].begin(), self.reads[1].end()) == Words{0, 1, 2, 3, 0, 1, 2, 3});
        CHECK(Words(self.reads[2].begin(), self.reads[2].end()) == Words{10, 11, 12, 13});
        CHECK(self.keeps[0][1] == 7);
        self.keeps[0][0] = 99;
        self.keeps[1][1] = 98;
        CHECK(self.sends[0][0] == poison);
        for (unsigned i = 0; i < 3; ++i) self.sends[0][i] = 50 + i;
    };
    auto const start = Sequence({rig.give(t, {0, 1, 2, 3, 10, 11, 12, 13, 20, 21, 22, 23}), rig.give(kept, Words(6, 7)),
                                 rig.give(out, Words(6, 8))});
    auto const take = rig.take(kept), take_out = rig.take(out);
    auto const engine = rig.run(Sequence({start, Execute(set), take, take_out}));
    CHECK(rig.taken(1) == Words{7, 7, 7, 98, 99, 7});
    CHECK(rig.taken(0) == Words{50, 8, 51, 8, 52, 8});

    auto const all = standin::exchanges(engine);
    using standin::Move;
    REQUIRE(all.size() == 2);
    CHECK(all[0].kind == standin::Exchange::Kind::gather);
    CHECK(all[0].name == "reduce");
    CHECK(all[0].moves == std::vector<Move>{{0, 1, 1 + 8}, {1, 1, 1}, {2, 1, 1 + 2}});
    CHECK(all[1].kind == standin::Exchange::Kind::scatter);
    CHECK(all[1].moves == std::vector<Move>{{1, 0, 1}, {1, 1, 1}, {1, 2, 2 + 1}});
    auto const bytes = standin::tile_bytes(engine, 1);
    CHECK(bytes.temporaries == 4 * (3 + 8 + 2 + 3));
    CHECK(bytes.variables == std::map<std::string, std::size_t>{{"t", 16}, {"kept", 8}, {"out", 8}});
    CHECK(bytes.total() == 64 + 32 + bytes.vertex_state);
    CHECK(standin::tile_bytes(engine, 0).temporaries == 0);
}

TEST_CASE("what a graph leaves out is refused when its engine is built, by name")
{
    auto const built = [](Rig const& rig) { return refusal<poplar::poplar_error>([&] { rig.build({Sequence()}); }); };
    {
        Rig rig;
        Tensor const t = rig.graph->addVariable(UNSIGNED_INT, {8}, "half_mapped");
        CHECK(says(built(rig), "Element 0 of variable half_mapped is on no tile"));
        rig.graph->setTileMapping(t.slice(0, 3), 0);
        rig.graph->setTileMapping(t.slice(4, 8), 0);
        CHECK(says(built(rig), "Element 3"));
        rig.graph->setTileMapping(t[3], 1);
        CHECK(built(rig).empty());
        CHECK(says(refusal<poplar::invalid_tile_mapping>([&] { rig.graph->setTileMapping(t, 4); }), "no tile 4"));
        CHECK_NOTHROW(rig.graph->setTileMapping(t, 3));
        rig.graph->addConstant(UNSIGNED_INT, {1}, 4, "loose");
        CHECK(says(built(rig), "loose"));
    }
    Rig rig;
    Tensor const a = rig.words("a", 4, 0);
    auto const set = rig.graph->addComputeSet("set");
    auto const v = rig.graph->addVertex(set, "StandinAny");
    CHECK(says(built(rig), "Vertex StandinAny of compute set set is on no tile"));
    rig.graph->setTileMapping(v, 3);
    CHECK(says(built(rig), "Vertex StandinAny on tile 3, field reads has no size"));
    CHECK(says(refusal<poplar::no_size_specified>([&] { rig.graph->connect(v["reads"][0], a); }), "reads[0]"));
    rig.graph->setFieldSize(v["reads"], 2);
    rig.graph->setFieldSize(v["keeps"], 0);
    rig.graph->setFieldSize(v["sends"], 0);
    rig.graph->connect(v["reads"][1], a);
    CHECK(says(built(rig), "field reads[0] is unconnected"));
    rig.graph->connect(v["reads"][0], a);
    CHECK(says(built(rig), "field id has no value"));
    rig.graph->setInitialValue(v["id"], 1u);
    CHECK(built(rig).empty());
    CHECK(says(refusal<poplar::graph_connection_error>([&] { rig.graph->connect(v["reads"][2], a); }), "reads[2]"));
    rig.graph->connect(v["reads"][1], a);
    CHECK(says(built(rig), "reads[1] is connected twice"));
}

TEST_CASE("what does not fit a field is refused when it is connected")
{
    Rig rig;
    Tensor const a = rig.words("a", 4, 0), one = rig.scalar(UNSIGNED_INT, "one", 0),
                 f = rig.graph->addVariable(poplar::FLOAT, {4});
    auto const set = rig.graph->addComputeSet("set");
    auto const any = rig.graph->addVertex(set, "StandinAny"), count = rig.graph->addVertex(set, "StandinCount");
    auto const team = rig.graph->addVertex(set, "StandinTeam");
    rig.graph->setFieldSize(any["reads"], 1);
    using poplar::graph_connection_error;
    CHECK(says(refusal<poplar::unknown_vertex_type>([&] { rig.graph->addVertex(set, "StandinNone"); }), "StandinNone"));
    CHECK(says(refusal<poplar::unknown_field>([&] { count["counts"]; }), "counts"));
    CHECK(says(refusal<graph_connection_error>([&] { rig.graph->connect(count["count"], a); }), "{4}"));
    CHECK(says(refusal<graph_connection_error>([&] { rig.graph->connect(count["count"], a.slice(0, 1)); }), "{1}"));
    CHECK(says(refusal<poplar::type_error>([&] { rig.graph->connect(count["below"], one); }), "holds bool"));
    CHECK(says(refusal<poplar::type_error>([&] { rig.graph->connect(team["words"], f); }), "float"));
    CHECK(says(refusal<graph_connection_error>([&] { rig.graph->connect(team["words"], a.reshape({2, 2})); }), "{2, 2}"));
    CHECK(says(refusal<graph_connection_error>([&] { rig.graph->connect(team["words"][0], a); }), "words"));
    CHECK(says(refusal<graph_connection_error>([&] { rig.graph->connect(any["reads"], a); }), "rank 2"));
    CHECK(says(refusal<graph_connection_error>([&] { rig.graph->connect(any["id"], one); }), "plain member"));
    CHECK(says(refusal<graph_connection_error>([&] { rig.graph->setInitialValue(count["count"], 1u); }), "edge"));
    CHECK(says(refusal<poplar::type_error>([&] { rig.graph->setInitialValue(count["step"], -1); }), "-1"));
    CHECK(says(refusal<graph_connection_error>([&] { rig.graph->setFieldSize(team["words"], 1); }), "no list"));
    Rig other;
    CHECK(says(refusal<graph_connection_error>([&] { rig.graph->connect(team["words"], other.words("w", 4, 0)); }),
               "not of this graph"));
    CHECK(says(refusal<graph_connection_error>([&] { rig.graph->setTileMapping(Tensor(), 0); }), "not of this graph"));

    CHECK(says(refusal<poplar::graph_object_load_error>([&] { rig.graph->addCodelets(""); }), "path is empty"));
    poplar::Graph bare(rig.device.getTarget());
    auto const bare_set = bare.addComputeSet("set");
    CHECK(says(refusal<poplar::unknown_vertex_type>([&] { bare.addVertex(bare_set, "StandinAny"); }), "addCodelets"));
}

TEST_CASE("a compute set in which one element is written and touched again is refused")
{
    enum Way { reads, keeps, sends };
    auto const built = [](Way a, Way b, std::size_t second, bool one_vertex, bool one_set = true) {
        Rig rig;
        Tensor const t = rig.words("shared", 8, 0);
        auto const set = rig.graph->addComputeSet("set"), later = rig.graph->addComputeSet("later");
        std::vector<Tensor> lists[2][3];
        lists[0][a].push_back(t.slice(0, 4));
        lists[one_vertex ? 0 : 1][b].push_back(t.slice(second, second + 4));
        rig.any(set, 1, lists[0][reads], lists[0][keeps], lists[0][sends]);
        rig.any(one_set ? set : later, 2, lists[1][reads], lists[1][keeps], lists[1][sends]);
        return refusal<poplar::graph_program_compilation_error>([&] { rig.build({Sequence()}); });
    };
    for (bool const one_vertex : {false, true}) {
        CHECK(built(reads, reads, 3, one_vertex).empty());
        for (Way const b : {keeps, sends})
            for (Way const a : {reads, keeps, sends}) {
                CHECK(says(built(a, b, 3, one_vertex), "element 3 of variable shared twice"));
                CHECK(says(built(b, a, 3, one_vertex), "StandinAny on tile 1"));
                CHECK(built(a, b, 4, one_vertex).empty());
            }
    }
    CHECK(built(sends, sends, 0, false, false).empty());

    Rig rig;
    Tensor const t = rig.words("t", 4, 0), constant = rig.graph->addConstant(UNSIGNED_INT, {4}, 1, "one");
    rig.graph->setTileMapping(constant, 0);
    rig.any(rig.graph->addComputeSet("fine"), 0, {t.broadcast(2, 0), constant}, {}, {});
    CHECK_NOTHROW(rig.build({Sequence()}));
    rig.any(rig.graph->addComputeSet("repeats"), 0, {}, {}, {t.broadcast(2, 0)});
    CHECK(says(refusal<poplar::graph_program_compilation_error>([&] { rig.build({Sequence()}); }), "Compute set repeats"));
    Rig writes;
    Tensor const fixed = writes.graph->addConstant(UNSIGNED_INT, {4}, 1, "fixed");
    writes.graph->setTileMapping(fixed, 0);
    writes.any(writes.graph->addComputeSet("set"), 0, {}, {fixed}, {});
    CHECK(says(refusal<poplar::graph_connection_error>([&] { writes.build({Sequence()}); }), "constant fixed"));
}

TEST_CASE("two vertices of a compute set that write parts of one word are refused, though their elements differ")
{
    auto const built = [](bool one_variable, unsigned second_tile, bool one_set) {
        Rig rig;
        Tensor const flags = rig.graph->addVariable(poplar::BOOL, {2}, "flags");
        rig.graph->setTileMapping(flags[0], 1);
        rig.graph->setTileMapping(flags[1], second_tile);
        Tensor const other = rig.scalar(poplar::BOOL, "other", second_tile), bound = rig.scalar(UNSIGNED_INT, "bound", 1);
        auto const first = rig.graph->addComputeSet("first"), later = rig.graph->addComputeSet("later");
        for (unsigned i = 0; i < 2; ++i) {
            auto const v = rig.graph->addVertex(i == 0 || one_set ? first : later, "StandinCount");
            rig.graph->connect(v["count"], rig.scalar(UNSIGNED_INT, "count", i));
            rig.graph->connect(v["bound"], bound);
            rig.graph->connect(v["below"], i == 0 || one_variable ? flags[i] : other);
            rig.graph->setInitialValue(v["step"], 1u);
            rig.graph->setTileMapping(v, i == 0 ? 1 : second_tile);
        }
        return refusal<poplar::graph_program_compilation_error>([&] { rig.build({Sequence()}); });
    };
    CHECK(says(built(true, 1, true),
               "Compute set first writes parts of one word by two vertices (Vertex StandinCount on tile 1"));
    CHECK(built(true, 1, false).empty());
    CHECK(built(true, 2, true).empty());
    CHECK(built(false, 1, true).empty());
}

TEST_CASE("a tile may be full, and a word more is refused with its tile and bytes")
{
    // Tile 1 holds a variable, a bool that takes one word, a vertex with 3 lists, 2 inner vectors and one word, a temporary, and code.
    constexpr std::size_t state = 3 * 8 + 2 * 8 + 4, temporary = 3 * 4, code = 100, full = 4096;
    constexpr std::size_t words = (full - 4 - state - temporary - code) / 4;
    for (std::size_t const more : {0u, 1u}) {
        Rig rig({.tiles = 2, .tile_bytes = full, .code_bytes = code});
        Tensor const t = rig.words("t", words + more, 1), remote = rig.words("remote", 3, 0);
        rig.scalar(poplar::BOOL, "flag", 1);
        rig.any(rig.graph->addComputeSet("set"), 1, {t, remote}, {}, {});
        if (more == 0) {
            auto const engine = rig.build({Sequence()});
            CHECK(standin::tile_bytes(engine, 1).total() == full);
            CHECK(standin::tile_bytes(engine, 1).code == code);
            CHECK(says(refusal<poplar::invalid_tile_mapping>([&] { standin::tile_bytes(engine, 2); }), "no tile 2"));
            CHECK(standin::tile_bytes(engine, 1).variables.at("flag") == 4);
        } else {
            auto const text = refusal<poplar::graph_memory_allocation_error>([&] { rig.build({Sequence()}); });
            CHECK(says(text, "Tile 1 holds 4100 bytes, 4 more than its 4096"));
        }
    }
}

TEST_CASE("what nobody wrote is poison: fresh variables, Outputs before compute, everything after a load")
{
    Rig rig;
    Tensor const t = rig.rows("t", 2, 4), fresh = rig.words("fresh", 3, 2);
    auto const set = rig.graph->addComputeSet("set");
    rig.any(set, 0, {t[1]}, {t[0].slice(0, 2)}, {t[0].slice(2, 4)});
    std::vector<Words> seen;
    any_compute = [&](StandinAny& self) {
        seen.push_back({self.reads[0][0], self.keeps[0][0], self.sends[0][0], self.sends[0][1]});
        self.sends[0][0] = 5; // sends[0][1] stays unwritten
    };
    auto const give = rig.give(t, Words(8, 1)), take = rig.take(poplar::concat(t.flatten(), fresh));
    auto engine = rig.build({Sequence({give, Execute(set), Execute(set), take}), take});
    auto other = rig.build({take});
    engine.run(0);
    CHECK(seen == std::vector<Words>{{1, 1, poison, poison}, {1, 1, poison, poison}});
    CHECK(rig.taken() == Words{1, 1, 5, poison, 1, 1, 1, 1, poison, poison, poison});
    other.run(0); // each engine has its own memory
    CHECK(rig.taken() == Words(11, poison));
    engine.run(1);
    CHECK(rig.taken()[0] == 1);
    engine.load(rig.device);
    engine.run(1);
    CHECK(rig.taken() == Words(11, poison));
}

TEST_CASE("a write beside an edge is reported with its vertex, tile and field")
{
    // The vertex's edge is [first, last) of ten words of a variable. The vertex writes the byte at offset `byte` from the edge's start.
    auto const run = [](std::size_t first, std::size_t last, int byte, std::vector<std::size_t> const& more = {}) {
        Rig rig;
        rig.words("before", 5, 1);
        Tensor const t = rig.words("t", 10, 1);
        rig.words("after", 5, 1);
        auto const set = rig.graph->addComputeSet("set");
        std::vector<Tensor> keeps{t.slice(first, last)};
        for (std::size_t const m : more) keeps.push_back(t.slice(m, m + 1));
        rig.any(set, 1, {}, keeps, {});
        any_compute = [byte](StandinAny& self) {
            unsigned char* const at = reinterpret_cast<unsigned char*>(self.keeps[0].data()) + byte;
            poke(at, 0x33);
        };
        auto const give = rig.give(t, Words(10, 7));
        return refusal<poplar::application_runtime_error>([&] { rig.run(Sequence({give, Execute(set)})); });
    };
    char const* const past = "Vertex StandinAny on tile 1 wrote past the end of its field keeps[0] of 10 elements";
    CHECK(run(0, 10, 0).empty());
    CHECK(run(0, 10, 39).empty());
    CHECK(says(run(0, 10, 40), past));
    CHECK(says(run(0, 10, 55), past));
    CHECK(says(run(0, 10, -1), "before the start of its field keeps[0]"));
    CHECK(says(run(0, 10, -16), "before the start"));
    // An edge in the middle of the variable: its neighbours are words of the same variable.
    CHECK(says(run(3, 6, 12), "past the end of its field keeps[0] of 3 elements"));
    CHECK(says(run(3, 6, -4), "before the start"));
    CHECK(says(run(8, 10, 8), "past the end"));
    // The neighbouring word is another edge, which the vertex may write.
    CHECK(run(3, 6, 12, {6}).empty());
    CHECK(says(run(3, 6, 16, {6}), "past the end"));
    CHECK(run(3, 6, -4, {2}).empty());
    // An edge of no elements.
    CHECK(says(run(3, 3, 0), "keeps[0] of 0 elements"));
}

TEST_CASE("a red zone that is copied on itself shows: canaries differ from poison and from each other")
{
    Rig rig;
    Tensor const a = rig.words("a", 8, 1), b = rig.words("b", 8, 1);
    auto const set = rig.graph->addComputeSet("set");
    rig.any(set, 1, {a}, {b}, {});
    any_compute = [](StandinAny& self) {
        auto const* const from = reinterpret_cast<unsigned char const*>(self.reads[0].data());
        auto* const to = reinterpret_cast<unsigned char*>(self.keeps[0].data());
        standin::detail::raw_copy(to, from, 36); // one word too many
    };
    auto const give = rig.give(a, Words(8, 7));
    CHECK(says(refusal<poplar::application_runtime_error>([&] {
                   rig.run(Sequence({give, Execute(set)}));
               }),
               "past the end of its field keeps[0]"));
    for (std::size_t i = 0; i < 4096; ++i) {
        std::array<unsigned char, 4> word, next;
        for (std::size_t k = 0; k < 4; ++k) {
            word[k] = standin::detail::canary(i + k);
            next[k] = standin::detail::canary(i + 4 + k);
        }
        unsigned value;
        std::memcpy(&value, word.data(), 4);
        REQUIRE(value != poison);
        REQUIRE(word != next);
    }
}

TEST_CASE("an Input that changed is reported where that is asked for, and only then")
{
    for (bool const check : {false, true})
        for (bool const last : {false, true}) {
            Rig rig({.check_inputs = check, .tiles = 4, .tile_bytes = 65536});
            Tensor const t = rig.words("t", 5, 1);
            auto const set = rig.graph->addComputeSet("set");
            rig.any(set, 1, {t}, {}, {});
            any_compute = [last](StandinAny& self) { const_cast<unsigned&>(self.reads[0][last ? 4 : 0]) ^= 0x80000000u; };
            auto const give = rig.give(t, Words(5, 7));
            auto const text = refusal<poplar::application_runtime_error>([&] { rig.run(Sequence({give, Execute(set)})); });
            if (check) CHECK(says(text, "Vertex StandinAny on tile 1 changed its Input reads[0]"));
            else CHECK(text.empty());
            any_compute = [](StandinAny&) {};
            CHECK_NOTHROW(rig.run(Sequence({give, Execute(set)})));
        }
}

TEST_CASE("workers and vertices run in the order that is set, permutations by their seed")
{
    Settings settings{.tiles = 16, .tile_bytes = 65536};
    auto const orders = [&settings](unsigned runs) {
        Rig rig(settings);
        auto const set = rig.graph->addComputeSet("vertices"), team = rig.graph->addComputeSet("team");
        for (unsigned i = 0; i < 16; ++i) rig.any(set, i, {}, {}, {}, i);
        auto const v = rig.graph->addVertex(team, "StandinTeam");
        rig.graph->connect(v["words"], rig.words("t", 1, 0));
        rig.graph->setTileMapping(v, 0);
        Words vertices, workers;
        any_compute = [&](StandinAny& self) { vertices.push_back(self.id); };
        team_compute = [&](StandinTeam&, unsigned worker) { workers.push_back(worker); };
        auto engine = rig.build({Sequence({Execute(set), Execute(team), Execute(team)})});
        for (unsigned i = 0; i < runs; ++i) engine.run(0);
        return std::pair(vertices, workers);
    };
    Words up(16), down(16);
    for (unsigned i = 0; i < 16; ++i) up[i] = down[15 - i] = i;
    CHECK(orders(1) == std::pair(up, Words{0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5}));
    settings.vertices = settings.workers = standin::Order::descending;
    CHECK(orders(1) == std::pair(down, Words{5, 4, 3, 2, 1, 0, 5, 4, 3, 2, 1, 0}));
    settings.vertices = settings.workers = standin::Order::permuted;
    auto const first = orders(1), twice = orders(2);
    Words vertices = first.first, workers = first.second;
    CHECK(vertices != up);
    std::sort(vertices.begin(), vertices.end());
    CHECK(vertices == up);
    std::sort(workers.begin(), workers.end());
    CHECK(workers == Words{0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5});
    CHECK(orders(1) == first);
    CHECK(Words(twice.first.begin() + 16, twice.first.end()) == first.first); // each run of an engine has the same order
    settings.seed = 2;
    CHECK(orders(1).first != first.first);
}

TEST_CASE("on threads the six workers run at once: a barrier between them opens")
{
    Rig rig({.threads = true, .tiles = 4, .tile_bytes = 65536});
    Tensor const t = rig.rows("t", 2, 6);
    auto const set = rig.graph->addComputeSet("team");
    for (unsigned i = 0; i < 2; ++i) {
        auto const v = rig.graph->addVertex(set, "StandinTeam");
        rig.graph->connect(v["words"], t[i]);
        rig.graph->setTileMapping(v, i);
    }
    std::atomic<unsigned> arrived{0}, vertex{0};
    team_compute = [&](StandinTeam& self, unsigned worker) {
        self.words[worker] += worker;
        unsigned const before = arrived.fetch_add(1), all = (before / 6 + 1) * 6;
        while (arrived.load() < all) std::this_thread::yield();
        unsigned const next = self.words[(worker + 1) % 6]; // another worker wrote this word before the barrier
        arrived.fetch_add(1);
        while (arrived.load() < all + 6) std::this_thread::yield();
        self.words[worker] = 10 * next;
        if (worker == 0) ++vertex;
    };
    auto const give = rig.give(t, Words(12, 1)), take = rig.take(t);
    auto engine = rig.run(Sequence({give, Execute(set), take}));
    CHECK(vertex == 2);
    CHECK(rig.taken() == Words{20, 30, 40, 50, 60, 10, 20, 30, 40, 50, 60, 10});
    // run() throws the exception of the lowest worker that threw one. The threads still work afterwards.
    team_compute = [](StandinTeam&, unsigned worker) {
        if (worker >= 3) throw std::runtime_error("worker " + std::to_string(worker));
    };
    CHECK(refusal<std::runtime_error>([&] { engine.run(0); }) == "worker 3");
    team_compute = [](StandinTeam& self, unsigned worker) { self.words[worker] = worker; };
    engine.run(0);
    CHECK(rig.taken() == Words{0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5});
}

#if !defined(TILEMESH_STANDIN_ASAN) && !defined(TILEMESH_TEST_TSAN)
TEST_CASE("with pages closed, a vertex that touches another tile's memory ends in an exception that names both")
{
    for (bool const threads : {false, true})
        for (auto const isolation : {standin::Isolation::none, standin::Isolation::pages}) {
            Rig rig({.threads = threads, .isolation = isolation, .tiles = 4, .tile_bytes = 65536});
            Tensor const t = rig.rows("t", 3, 6);
            auto const set = rig.graph->addComputeSet("set"), team = rig.graph->addComputeSet("team");
            for (unsigned i = 0; i < 3; ++i) {
                rig.any(set, i, {}, {t[i]}, {}, i);
                auto const v = rig.graph->addVertex(team, "StandinTeam");
                rig.graph->connect(v["words"], t[i]);
                rig.graph->setTileMapping(v, i);
            }
            unsigned* words[3] = {};
            any_compute = [&](StandinAny& self) {
                words[self.id] = self.keeps[0].data();
                self.keeps[0][0] = self.id;
            };
            auto const give = rig.give(t, Words(18, 1)), take = rig.take(t);
            auto engine = rig.build({give, Execute(set), Execute(team), take});
            engine.run(0);
            engine.run(1);
            any_compute = [&](StandinAny& self) {
                if (self.id == 2) self.keeps[0][1] = *const_cast<unsigned volatile*>(words[1]); // a read is enough
            };
            auto const run = [&](unsigned i) {
                return refusal<poplar::application_runtime_error>([&, i] { engine.run(i); });
            };
            team_compute = [&](StandinTeam& self, unsigned worker) {
                self.words[worker] = worker;
                if (self.words.data() == words[0] && worker == 4) *const_cast<unsigned volatile*>(words[2]) = 8;
            };
            if (isolation == standin::Isolation::none) {
                CHECK(run(1).empty());
                CHECK(run(2).empty());
            } else {
                CHECK(says(run(1), "Vertex StandinAny on tile 2 touched memory of tile 1"));
                CHECK(says(run(2), "Vertex StandinTeam on tile 0 touched memory of tile 2"));
                any_compute = [&](StandinAny&) { *static_cast<unsigned volatile*>(nullptr) = 1; };
                CHECK(says(run(1), "touched memory of no tile"));
                any_compute = [&](StandinAny&) { throw std::runtime_error("thrown"); };
                CHECK(refusal<std::runtime_error>([&] { engine.run(1); }) == "thrown");
                // The engine still runs afterwards, and the stand-in reaches all memory.
                any_compute = [&](StandinAny& self) { self.keeps[0][5] = 70 + self.id; };
                CHECK(run(1).empty());
                engine.run(3);
                CHECK(rig.taken() == Words{0, 1, 2, 3, 4, 70, 1, 1, 1, 1, 1, 71, 2, 1, 1, 1, 1, 72});
            }
        }
}
#endif

#ifdef TILEMESH_STANDIN_ASAN
TEST_CASE("AddressSanitizer lets a vertex touch its own edges and nothing beside them")
{
    Rig rig;
    Tensor const t = rig.rows("t", 2, 12), beside = rig.words("beside", 4, 0), flag = rig.scalar(poplar::BOOL, "flag", 0);
    auto const set = rig.graph->addComputeSet("set");
    rig.any(set, 0, {t[0].slice(2, 5)}, {t[0].slice(8, 12)}, {}, 0);
    rig.any(set, 1, {}, {t[1]}, {}, 1);
    unsigned* first = nullptr;
    bool ran = false;
    any_compute = [&](StandinAny& self) {
        auto const closed = [](void const* at) { return __asan_address_is_poisoned(at) != 0; };
        if (self.id == 0) {
            unsigned const* const reads = self.reads[0].data();
            unsigned* const keeps = first = self.keeps[0].data();
            CHECK_FALSE(closed(reads));
            CHECK_FALSE(closed(reads + 2));
            CHECK(closed(reads - 1));
            CHECK(closed(reads + 3)); // words of the variable outside the edge
            CHECK(closed(keeps - 1));
            CHECK_FALSE(closed(keeps));
            CHECK_FALSE(closed(reinterpret_cast<char*>(keeps + 4) - 1));
            CHECK(closed(keeps + 4));
        } else {
            ran = true;
            CHECK(closed(first)); // memory of the other tile
            CHECK(closed(self.keeps[0].data() - 1));
            CHECK_FALSE(closed(self.keeps[0].data()));
            CHECK_FALSE(closed(self.keeps[0].data() + 11));
            CHECK(closed(self.keeps[0].data() + 12));
        }
    };
    auto const give = rig.give(t, Words(24, 1));
    auto const engine = rig.run(Sequence({give, Execute(set)}));
    CHECK(ran);
    CHECK(__asan_address_is_poisoned(first) != 0); // the edge is closed after compute too
}

TEST_CASE("AddressSanitizer lets nothing through after an edge that began in the middle of eight bytes")
{
    Rig rig;
    Tensor const t = rig.words("t", 12, 0);
    auto const odd = rig.graph->addComputeSet("odd"), even = rig.graph->addComputeSet("even");
    rig.any(odd, 0, {}, {t.slice(3, 6)}, {}, 0);
    rig.any(even, 0, {}, {t.slice(0, 2), t.slice(8, 12)}, {}, 1);
    unsigned* words = nullptr;
    any_compute = [&](StandinAny& self) {
        auto const closed = [&](unsigned i) { return __asan_address_is_poisoned(words + i) != 0; };
        if (self.id == 0) {
            words = self.keeps[0].data() - 3;
            for (unsigned const i : {3u, 4u, 5u}) CHECK_FALSE(closed(i));
            for (unsigned const i : {1u, 6u, 7u}) CHECK(closed(i));
        } else {
            for (unsigned const i : {0u, 1u, 8u, 11u}) CHECK_FALSE(closed(i));
            for (unsigned const i : {2u, 3u, 4u, 5u, 6u, 7u}) CHECK(closed(i));
        }
    };
    auto const give = rig.give(t, Words(12, 1));
    rig.run(Sequence({give, Execute(odd), Execute(even)}));
    CHECK(words != nullptr);
}
#endif
