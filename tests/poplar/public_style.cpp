// test: unoptimised test asan, without tsan
// Codelets with every kind of field run here with known answers: by hand through the registration, and through the stand-in's
// graph and engine. The stand-in is not Poplar. These tests show that the headers accept this style of code, and that the
// engine gives each codelet its data. They cannot show that popc accepts the same text, how an IPU lays out these fields,
// how its arithmetic rounds if instructions fuse (`half`, exp), or how much time anything takes.
#include "public_style_codelets.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <doctest/doctest.h>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <poplar/DeviceManager.hpp>
#include <poplar/Engine.hpp>
#include <poplar/Graph.hpp>
#include <poplar/Program.hpp>
#include <random>
#include <standin.hpp>
#include <standin_vertex.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

POPLAR_STANDIN_VERTEX(orchard::Scale<float>, in, out, factor);
POPLAR_STANDIN_VERTEX(orchard::Scale<int>, in, out, factor);
POPLAR_STANDIN_VERTEX(orchard::Scale<half>, in, out, factor);
POPLAR_STANDIN_VERTEX_NAMED("orchard::Scale<unsigned short>", orchard::Scale<unsigned short>, in, out, factor);
POPLAR_STANDIN_VERTEX(orchard::Pick, table, indices, picked, even, tableSize);
POPLAR_STANDIN_VERTEX(orchard::RowSums, rows, sums, total);
POPLAR_STANDIN_VERTEX(orchard::Deal, deck, hands, piles, players);
POPLAR_STANDIN_VERTEX(orchard::Largest, groups, weights, largest);
POPLAR_STANDIN_VERTEX(orchard::PairAxpy, x, y, partial, pairs, a);
POPLAR_STANDIN_VERTEX(orchard::PrefixSum, values, sums, arrived, perWorker);
POPLAR_STANDIN_VERTEX(orchard::Reverse, in, out);
using FillUnsigned = orchard::Fill<unsigned, false>;
using FillBool = orchard::Fill<bool, true>;
POPLAR_STANDIN_VERTEX_NAMED("orchard::Fill<unsigned int,false>", FillUnsigned, out, with);
POPLAR_STANDIN_VERTEX_NAMED("orchard::Fill<bool,true>", FillBool, out, with);
POPLAR_STANDIN_VERTEX(orchard::HalfDot, a, b, dot, exact, bias);
POPLAR_STANDIN_VERTEX(orchard::Above, in, threshold, strict, above, any);
POPLAR_STANDIN_VERTEX(orchard::Extent, in, low, high, calls);
POPLAR_STANDIN_VERTEX(orchard::Polynomial, x, y, coefficients, exponents);
POPLAR_STANDIN_VERTEX(orchard::Ripen, storage, count, by);
POPLAR_STANDIN_VERTEX(orchard::Sort, keys, zeros);
POPLAR_STANDIN_VERTEX(orchard::Widths, bytes, shorts, wide, sum, sign, twice);
POPLAR_STANDIN_VERTEX(orchard::Stripes, out, byWorker);

namespace {

using standin::Access;
using standin::Order;

/// A way to execute the workers of a MultiVertex.
struct Way {
    Order order;
    unsigned seed;
    bool threads;
};
std::vector<Way> const all_ways{{Order::ascending, 1, false}, {Order::descending, 1, false}, {Order::permuted, 1, false},
                                {Order::permuted, 2, false},  {Order::permuted, 3, false},   {Order::ascending, 1, true}};

/// The data of one call: its inputs, and after the call its outputs. Fields have the names that they have in the codelet.
class Call {
public:
    struct Piece {
        std::vector<std::byte> bytes;
        std::size_t elements;
    };
    struct Data {
        Access access;
        unsigned rank;
        std::vector<Piece> pieces;
        std::function<void(poplar::Graph&, poplar::VertexRef)> set_value; // set only if access is value
    };

    explicit Call(std::string vertex) : vertex_(std::move(vertex)) {}
    std::string const& vertex() const { return vertex_; }
    std::map<std::string, Data>& data() { return data_; }

    template <class T>
    void in(std::string const& field, std::vector<T> const& values)
    {
        data_[field] = {Access::input, 1, {piece(values)}, {}};
    }
    template <class T>
    void in(std::string const& field, T value)
    {
        data_[field] = {Access::input, 0, {piece(std::vector<T>{value})}, {}};
    }
    template <class T>
    void in(std::string const& field, std::vector<std::vector<T>> const& rows)
    {
        data_[field] = {Access::input, 2, pieces(rows), {}};
    }
    template <class T>
    void inout(std::string const& field, std::vector<T> const& values)
    {
        data_[field] = {Access::inout, 1, {piece(values)}, {}};
    }
    template <class T>
    void inout(std::string const& field, T value)
    {
        data_[field] = {Access::inout, 0, {piece(std::vector<T>{value})}, {}};
    }
    template <class T>
    void inout(std::string const& field, std::vector<std::vector<T>> const& rows)
    {
        data_[field] = {Access::inout, 2, pieces(rows), {}};
    }
    template <class T>
    void out(std::string const& field)
    {
        data_[field] = {Access::output, 0, {piece(std::vector<T>(1))}, {}};
    }
    template <class T>
    void out(std::string const& field, std::size_t n)
    {
        data_[field] = {Access::output, 1, {piece(std::vector<T>(n))}, {}};
    }
    template <class T>
    void out(std::string const& field, std::vector<std::size_t> const& sizes)
    {
        std::vector<std::vector<T>> rows;
        for (std::size_t n : sizes) rows.emplace_back(n);
        data_[field] = {Access::output, 2, pieces(rows), {}};
    }
    template <class T>
    void value(std::string const& field, T value)
    {
        data_[field] = {
            Access::value, 0, {piece(std::vector<T>{value})}, [=](poplar::Graph& graph, poplar::VertexRef vertex) {
                graph.setInitialValue(vertex[field], Plain<T>(value));
            }};
    }
    template <class T>
    void value(std::string const& field, std::vector<T> const& values)
    {
        data_[field] = {Access::value, 1, {piece(values)}, [=](poplar::Graph& graph, poplar::VertexRef vertex) {
                            graph.setInitialValue(vertex[field], std::vector<Plain<T>>(values.begin(), values.end()));
                        }};
    }
    template <class T>
    void value(std::string const& field, std::vector<std::vector<T>> const& rows)
    {
        data_[field] = {Access::value, 2, pieces(rows), [=](poplar::Graph& graph, poplar::VertexRef vertex) {
                            graph.setFieldSize(vertex[field], rows.size());
                            for (std::size_t i = 0; i < rows.size(); ++i) graph.setInitialValue(vertex[field][i], rows[i]);
                        }};
    }

    template <class T>
    std::vector<T> read(std::string const& field, std::size_t index = 0) const
    {
        Piece const& piece = data_.at(field).pieces.at(index);
        std::vector<T> values;
        for (std::size_t i = 0; i < piece.elements; ++i) {
            T value;
            std::memcpy(&value, piece.bytes.data() + i * sizeof value, sizeof value);
            values.push_back(value);
        }
        return values;
    }
    template <class T>
    T read_one(std::string const& field) const
    {
        return read<T>(field).at(0);
    }

private:
    /// The host has no halves: the host gives initial values as floats.
    template <class T>
    using Plain = std::conditional_t<std::is_same_v<T, half>, float, T>;

    template <class T>
    static Piece piece(std::vector<T> const& values)
    {
        Piece made{std::vector<std::byte>(values.size() * sizeof(T)), values.size()};
        for (std::size_t i = 0; i < values.size(); ++i) {
            T const value = values[i];
            std::memcpy(made.bytes.data() + i * sizeof value, &value, sizeof value);
        }
        return made;
    }
    template <class T>
    static std::vector<Piece> pieces(std::vector<std::vector<T>> const& rows)
    {
        std::vector<Piece> made;
        for (auto const& row : rows) made.push_back(piece(row));
        return made;
    }

    std::string vertex_;
    std::map<std::string, Data> data_;
};

/// Executes a call through the registration alone. Pieces lie between canaries. Outputs begin as poison. Inputs must not change.
struct ByHand {
    static constexpr std::uint64_t canary = 0x7fa0dead'7fa0deadu;

    static void run(Call& call, Way const& way) { returned(call, way); }

    /// Executes the call. Returns the result of each worker's compute().
    static std::array<bool, CTXT_WORKERS> returned(Call& call, Way const& way)
    {
        standin::VertexType const* const type = standin::find_vertex(call.vertex());
        REQUIRE_MESSAGE(type != nullptr, call.vertex());
        std::unique_ptr<void, void (*)(void*)> const vertex(type->make(), type->destroy);
        std::map<std::string, std::vector<std::vector<std::uint64_t>>> memory;
        REQUIRE(type->fields.size() == call.data().size());
        for (standin::Field const& field : type->fields) {
            Call::Data const& data = call.data().at(field.name);
            REQUIRE_MESSAGE(data.access == field.access, field.name);
            REQUIRE_MESSAGE(data.rank == field.rank, field.name);
            std::vector<standin::Edge> edges;
            for (Call::Piece const& piece : data.pieces) {
                REQUIRE(piece.bytes.size() == piece.elements * field.element_bytes);
                // Two words (16 bytes) come before the piece, so the piece keeps malloc's alignment of 16 bytes.
                std::vector<std::uint64_t> words(2 + (piece.bytes.size() + 7) / 8 + 1, canary);
                if (data.access != Access::output && !piece.bytes.empty())
                    std::memcpy(&words[2], piece.bytes.data(), piece.bytes.size());
                edges.push_back({&words[2], piece.elements});
                memory[field.name].push_back(std::move(words)); // a move keeps the address of the words
            }
            field.bind(vertex.get(), edges.data(), edges.size());
        }

        std::array<bool, CTXT_WORKERS> results{};
        std::vector<unsigned> workers(type->kind == standin::Kind::multi ? CTXT_WORKERS : 1);
        std::iota(workers.begin(), workers.end(), 0u);
        if (way.order == Order::descending) std::reverse(workers.begin(), workers.end());
        if (way.order == Order::permuted) std::shuffle(workers.begin(), workers.end(), std::mt19937(way.seed));
        std::vector<std::thread> threads;
        for (unsigned worker : workers) {
            auto const work = [&results, type, instance = vertex.get(), worker] {
                results[worker] = type->compute(instance, worker);
            };
            if (way.threads) threads.emplace_back(work);
            else work();
        }
        for (std::thread& thread : threads) thread.join();

        for (standin::Field const& field : type->fields) {
            Call::Data& data = call.data().at(field.name);
            for (std::size_t i = 0; i < data.pieces.size(); ++i) {
                auto const& words = memory[field.name][i];
                std::vector<std::byte>& bytes = data.pieces[i].bytes;
                auto const* const after = reinterpret_cast<std::byte const*>(&words[2]);
                CHECK_MESSAGE((words[0] == canary && words[1] == canary && words.back() == canary), field.name);
                if (data.access == Access::input || data.access == Access::value)
                    CHECK(std::equal(bytes.begin(), bytes.end(), after));
                else bytes.assign(after, after + bytes.size());
            }
        }
        return results;
    }
};

/// Executes a call through the stand-in's graph: one vertex on tile 1, its data on tiles 1 and 2, host streams for inputs and outputs.
struct ByGraph {
    static void run(Call& call, Way const& way)
    {
        struct Restored {
            standin::Settings before = standin::settings();
            ~Restored() { standin::settings() = before; }
        } const restored;
        standin::settings() = {};
        standin::settings().tiles = 3;
        standin::settings().workers = way.order;
        standin::settings().seed = way.seed;
        standin::settings().threads = way.threads;
        standin::settings().check_inputs = true;
        run(call);
    }

private:
    static void run(Call& call)
    {
        auto manager = poplar::DeviceManager::createDeviceManager();
        auto devices = manager.getDevices(poplar::TargetType::IPU, 1);
        REQUIRE(!devices.empty());
        REQUIRE(devices[0].attach());
        poplar::Graph graph(devices[0].getTarget());
        graph.addCodelets("public_style.gp");
        auto const set = graph.addComputeSet("call");
        auto const vertex = graph.addVertex(set, call.vertex());
        graph.setTileMapping(vertex, 1);
        poplar::program::Sequence to_device, from_device;
        std::map<std::string, std::vector<std::byte>*> streams;
        for (auto& entry : call.data()) {
            std::string const& name = entry.first;
            Call::Data& data = entry.second;
            if (data.access == Access::value) {
                data.set_value(graph, vertex);
                continue;
            }
            auto const* const type = standin::find_vertex(call.vertex());
            auto const field =
                std::find_if(type->fields.begin(), type->fields.end(), [&](auto const& f) { return f.name == name; });
            REQUIRE_MESSAGE(field != type->fields.end(), name);
            if (data.rank == 2) graph.setFieldSize(vertex[name], data.pieces.size());
            for (std::size_t i = 0; i < data.pieces.size(); ++i) {
                Call::Piece& piece = data.pieces[i];
                std::string const label = name + std::to_string(i);
                std::vector<std::size_t> shape;
                if (data.rank != 0) shape.push_back(piece.elements);
                auto const element = tensor_type(field->type);
                auto const tensor = graph.addVariable(element, shape, label);
                graph.setTileMapping(tensor, 1 + static_cast<unsigned>(i % 2));
                if (data.rank == 2) graph.connect(vertex[name][i], tensor);
                else graph.connect(vertex[name], tensor);
                if (data.access != Access::output && piece.elements != 0) {
                    auto const stream = graph.addHostToDeviceFIFO(label + " in", element, piece.elements);
                    to_device.add(poplar::program::Copy(stream, tensor));
                    streams[label + " in"] = &piece.bytes;
                }
                if (data.access != Access::input && piece.elements != 0) {
                    auto const stream = graph.addDeviceToHostFIFO(label + " out", element, piece.elements);
                    from_device.add(poplar::program::Copy(tensor, stream));
                    streams[label + " out"] = &piece.bytes;
                }
            }
        }
        poplar::Engine engine(graph, {poplar::program::Sequence({to_device, poplar::program::Execute(set), from_device})});
        engine.load(devices[0]);
        for (auto const& [handle, bytes] : streams) engine.connectStream(handle, bytes->data());
        engine.run(0);
        devices[0].detach();
    }

    static poplar::Type tensor_type(std::string const& name)
    {
        static std::map<std::string, poplar::Type> const types{{"bool", poplar::BOOL},
                                                               {"char", poplar::CHAR},
                                                               {"signed char", poplar::SIGNED_CHAR},
                                                               {"unsigned char", poplar::UNSIGNED_CHAR},
                                                               {"short", poplar::SHORT},
                                                               {"unsigned short", poplar::UNSIGNED_SHORT},
                                                               {"int", poplar::INT},
                                                               {"unsigned", poplar::UNSIGNED_INT},
                                                               {"long long", poplar::LONGLONG},
                                                               {"unsigned long long", poplar::UNSIGNED_LONGLONG},
                                                               {"half", poplar::HALF},
                                                               {"float", poplar::FLOAT}};
        return types.at(name);
    }
};

/// Executes one call in every way: `fill` gives it data, `check` looks at the results.
template <class Host, class Fill, class Check>
void in_all_ways(std::string const& vertex, Fill const& fill, Check const& check, std::vector<Way> const& ways = all_ways)
{
    for (Way const& way : ways) {
        CAPTURE(way.seed);
        CAPTURE(way.threads);
        Call call(vertex);
        fill(call);
        Host::run(call, way);
        check(call);
    }
}

template <class T>
using Values = std::vector<T>;

} // namespace

TEST_CASE_TEMPLATE("a template has instances for several element types", Host, ByHand, ByGraph)
{
    in_all_ways<Host>(
        "orchard::Scale<float>",
        [](Call& c) {
            c.in("in", Values<float>{1.0f, -2.5f, 0.0f});
            c.out<float>("out", 3);
            c.value("factor", 2.0f);
        },
        [](Call& c) {
            CHECK(c.read<float>("out") == Values<float>{2.0f, -5.0f, 0.0f});
        });
    in_all_ways<Host>(
        "orchard::Scale<int>",
        [](Call& c) {
            c.in("in", Values<int>{7});
            c.out<int>("out", 1);
            c.value("factor", -3);
        },
        [](Call& c) { CHECK(c.read<int>("out") == Values<int>{-21}); });
    in_all_ways<Host>(
        "orchard::Scale<unsigned short>",
        [](Call& c) {
            c.in("in", Values<unsigned short>{40000, 3});
            c.out<unsigned short>("out", 2);
            c.value<unsigned short>("factor", 2);
        },
        [](Call& c) {
            CHECK(c.read<unsigned short>("out") == Values<unsigned short>{80000 - 65536, 6});
        });
    in_all_ways<Host>(
        "orchard::Scale<half>",
        [](Call& c) {
            c.in("in", Values<half>{half(2049.0f), half(0.5f)}); // no half is 2,049: it becomes 2,048
            c.out<half>("out", 2);
            c.value("factor", half(1.5f));
        },
        [](Call& c) {
            CHECK(c.read<half>("out")[0] == 3072.0f);
            CHECK(c.read<half>("out")[1] == 0.75f);
        });
}

TEST_CASE_TEMPLATE("bare pointers come with a count, short spans know theirs", Host, ByHand, ByGraph)
{
    in_all_ways<Host>(
        "orchard::Pick",
        [](Call& c) {
            c.in("table", Values<float>{0.5f, 1.5f, 2.5f});
            c.in("indices", Values<unsigned short>{2, 0, 3, 1});
            c.out<float>("picked", 4);
            c.out<signed char>("even", 4);
            c.value("tableSize", 3u);
        },
        [](Call& c) {
            CHECK(c.read<float>("picked") == Values<float>{2.5f, 0.5f, -1.0f, 1.5f});
            CHECK(c.read<signed char>("even") == Values<signed char>{1, 1, -1, -1});
        });
}

TEST_CASE_TEMPLATE("lists of vectors: read, written, of unequal and no length", Host, ByHand, ByGraph)
{
    in_all_ways<Host>(
        "orchard::RowSums",
        [](Call& c) {
            c.in("rows", Values<Values<int>>{{1, 2, 3}, {-10}, {100, 200}});
            c.out<int>("sums", 3);
            c.inout("total", 1000);
        },
        [](Call& c) {
            CHECK(c.read<int>("sums") == Values<int>{6, -10, 300});
            CHECK(c.read_one<int>("total") == 1296);
        });
    in_all_ways<Host>(
        "orchard::Deal",
        [](Call& c) {
            c.in("deck", Values<unsigned>{1, 2, 3, 4, 5});
            c.out<unsigned>("hands", Values<std::size_t>{3, 2});
            c.inout("piles", Values<Values<unsigned>>{{10, 99}, {20, 98, 99}});
            c.value<unsigned char>("players", 2);
        },
        [](Call& c) {
            CHECK(c.read<unsigned>("hands", 0) == Values<unsigned>{1, 3, 5});
            CHECK(c.read<unsigned>("hands", 1) == Values<unsigned>{2, 4});
            CHECK(c.read<unsigned>("piles", 0) == Values<unsigned>{19, 3});
            CHECK(c.read<unsigned>("piles", 1) == Values<unsigned>{26, 98, 2});
        });
    in_all_ways<Host>(
        "orchard::Largest",
        [](Call& c) {
            c.in("groups", Values<Values<int>>{{3, 9, -4}, {-7}});
            c.inout("weights", Values<Values<float>>{{8.0f}, {1.0f, 2.0f, 4.0f}});
            c.out<int>("largest", 2);
        },
        [](Call& c) {
            CHECK(c.read<int>("largest") == Values<int>{9, -7});
            CHECK(c.read<float>("weights", 0) == Values<float>{4.0f});
            CHECK(c.read<float>("weights", 1) == Values<float>{0.5f, 1.0f, 2.0f});
        });
}

TEST_CASE_TEMPLATE("workers share out pairs of floats, in any order", Host, ByHand, ByGraph)
{
    constexpr unsigned pairs = 15; // not a multiple of 6: three workers have one more pair
    in_all_ways<Host>(
        "orchard::PairAxpy",
        [](Call& c) {
            Values<float> x, y;
            for (unsigned i = 0; i < 2 * pairs; ++i) {
                x.push_back(static_cast<float>(i));
                y.push_back(100.0f);
            }
            c.in("x", x);
            c.inout("y", y);
            c.out<float>("partial", 12);
            c.value<unsigned short>("pairs", pairs);
            c.value("a", 0.5f);
        },
        [](Call& c) {
            auto const y = c.read<float>("y");
            for (unsigned i = 0; i < 2 * pairs; ++i) CHECK(y[i] == 100.0f + 0.5f * static_cast<float>(i));
            auto const partial = c.read<float>("partial");
            CHECK(partial[0] == 3 * 100.0f + 0.5f * (0 + 12 + 24));
            CHECK(partial[11] == 2 * 100.0f + 0.5f * (11 + 23));
            CHECK(std::accumulate(partial.begin(), partial.end(), 0.0f) == 3000.0f + 0.5f * 435.0f);
        });
}

TEST_CASE_TEMPLATE("workers that wait for each other need all of them at once", Host, ByHand, ByGraph)
{
#if defined(__SANITIZE_THREAD__)
    return; // a spin on plain words is a race, both for the language and for TSan
#elif defined(__has_feature)
#    if __has_feature(thread_sanitizer)
    return;
#    endif
#endif
    for (unsigned n : {0u, 1u, 6u, 29u, 30u}) {
        in_all_ways<Host>(
            "orchard::PrefixSum",
            [=](Call& c) {
                c.inout("values", Values<unsigned>(n, 2));
                c.inout("sums", Values<unsigned>(6, 77));
                c.inout("arrived", Values<unsigned>(6, 0));
                c.value("perWorker", (n + 5) / 6);
            },
            [=](Call& c) {
                auto const values = c.read<unsigned>("values");
                for (unsigned i = 0; i < n; ++i) CHECK(values[i] == 2 * (i + 1));
                CHECK(c.read<unsigned>("arrived") == Values<unsigned>(6, 1));
            },
            {all_ways.back()});
    }
}

TEST_CASE_TEMPLATE("supervisor vertices", Host, ByHand, ByGraph)
{
    in_all_ways<Host>(
        "orchard::Reverse",
        [](Call& c) {
            c.in("in", Values<unsigned>{1, 2, 3});
            c.out<unsigned>("out", 3);
        },
        [](Call& c) {
            CHECK(c.read<unsigned>("out") == Values<unsigned>{3, 2, 1});
        });
    in_all_ways<Host>(
        "orchard::Fill<unsigned int,false>",
        [](Call& c) {
            c.out<unsigned>("out", 5);
            c.value("with", 0xffffffffu);
        },
        [](Call& c) { CHECK(c.read<unsigned>("out") == Values<unsigned>(5, 0xffffffffu)); });
    in_all_ways<Host>(
        "orchard::Fill<bool,true>",
        [](Call& c) {
            c.out<bool>("out", 3);
            c.value("with", true);
        },
        [](Call& c) { CHECK(c.read<bool>("out") == Values<bool>(3, true)); });
}

TEST_CASE_TEMPLATE("halves round at each step, floats beside them do not", Host, ByHand, ByGraph)
{
    in_all_ways<Host>(
        "orchard::HalfDot",
        [](Call& c) {
            c.in("a", Values<half>{2048, 1, 1, 0.0625f, 1, 1, 1, 0.0625f});
            c.in("b", Values<half>{1, 1, 1, 1, 1, 1, 1, 1});
            c.out<half>("dot");
            c.out<float>("exact");
            c.value("bias", half(0.25f));
        },
        [](Call& c) {
            // Lane 0: 2,048 + 1 is halfway between the halves 2,048 and 2,050, and rounds to the even one, 2,048. Lane 1
            // makes it 2,050. Lanes 2 and 3 add 2.125, of which rounding keeps 2. The bias is less than half a step.
            CHECK(c.read_one<half>("dot") == 2052.0f);
            CHECK(c.read_one<float>("exact") == 2053.125f);
        });
}

TEST_CASE_TEMPLATE("truth values and scalars as edges", Host, ByHand, ByGraph)
{
    for (bool strict : {false, true}) {
        in_all_ways<Host>(
            "orchard::Above",
            [=](Call& c) {
                c.in("in", Values<float>{1.0f, 2.0f, 1.5f});
                c.in("threshold", 2.0f);
                c.in("strict", strict);
                c.out<bool>("above", 3);
                c.out<bool>("any");
            },
            [=](Call& c) {
                CHECK(c.read<bool>("above") == Values<bool>{false, !strict, false});
                CHECK(c.read_one<bool>("any") == !strict);
            });
    }
    in_all_ways<Host>(
        "orchard::Extent",
        [](Call& c) {
            c.in("in", Values<float>{3.0f, -1.0f, 8.0f});
            c.out<float>("low");
            c.out<float>("high");
            c.inout("calls", 41u);
        },
        [](Call& c) {
            CHECK(c.read_one<float>("low") == -1.0f);
            CHECK(c.read_one<float>("high") == 8.0f);
            CHECK(c.read_one<unsigned>("calls") == 42);
        });
}

TEST_CASE_TEMPLATE("tables that belong to the vertex", Host, ByHand, ByGraph)
{
    in_all_ways<Host>(
        "orchard::Polynomial",
        [](Call& c) {
            c.in("x", Values<float>{2.0f, -1.0f});
            c.out<float>("y", 2);
            c.value("coefficients", Values<half>{half(0.5f), half(3.0f), half(1.0f)});
            c.value("exponents", Values<Values<unsigned short>>{{0}, {1}, {3}});
        },
        [](Call& c) {
            CHECK(c.read<float>("y") == Values<float>{0.5f - 6.0f + 8.0f, 0.5f + 3.0f - 1.0f});
        });
}

TEST_CASE_TEMPLATE("bytes that are cast to a struct", Host, ByHand, ByGraph)
{
    std::array<orchard::Seed, 2> const seeds{{{7, 0.25f}, {8, 0.75f}}};
    Values<char> bytes(sizeof seeds);
    std::memcpy(bytes.data(), seeds.data(), sizeof seeds);
    in_all_ways<Host>(
        "orchard::Ripen",
        [&](Call& c) {
            c.inout("storage", bytes);
            c.value("count", 2);
            c.value("by", 0.5f);
        },
        [](Call& c) {
            std::array<orchard::Seed, 2> after{};
            std::memcpy(after.data(), c.read<char>("storage").data(), sizeof after);
            CHECK(after[0].id == 7);
            CHECK(after[0].ripeness == 0.75f);
            CHECK(after[1].id == 0);
            CHECK(after[1].ripeness == 1.25f);
        });
}

TEST_CASE_TEMPLATE("vectors are passed to functions", Host, ByHand, ByGraph)
{
    in_all_ways<Host>(
        "orchard::Sort",
        [](Call& c) {
            c.inout("keys", Values<unsigned>{5, 0, 3, 0, 1});
            c.out<unsigned>("zeros");
        },
        [](Call& c) {
            CHECK(c.read<unsigned>("keys") == Values<unsigned>{0, 0, 1, 3, 5});
            CHECK(c.read_one<unsigned>("zeros") == 2);
        });
}

TEST_CASE_TEMPLATE("integers of all widths", Host, ByHand, ByGraph)
{
    in_all_ways<Host>(
        "orchard::Widths",
        [](Call& c) {
            c.in("bytes", Values<unsigned char>{255, 1});
            c.in("shorts", Values<short>{-300, 100});
            c.out<unsigned long long>("wide", 2);
            c.inout("sum", 5ll);
            c.value<signed char>("sign", -1);
            c.value("twice", true);
        },
        [](Call& c) {
            CHECK(c.read<unsigned long long>("wide") == Values<unsigned long long>{0xff00000000u, 0x100000000u});
            CHECK(c.read_one<long long>("sum") == 405);
        });
}

TEST_CASE_TEMPLATE("each worker writes its own words, and one may have none", Host, ByHand, ByGraph)
{
    in_all_ways<Host>(
        "orchard::Stripes",
        [](Call& c) {
            c.out<unsigned>("out", 8);
            c.out<unsigned>("byWorker", 6);
        },
        [](Call& c) {
            CHECK(c.read<unsigned>("out") == Values<unsigned>{10, 21, 32, 43, 54, 65, 16, 27});
            CHECK(c.read<unsigned>("byWorker") == Values<unsigned>{2, 2, 1, 1, 1, 1});
        });
}

TEST_CASE("what compute() returns is kept; a void one returns true")
{
    for (Way const& way : all_ways) {
        Call stripes("orchard::Stripes");
        stripes.out<unsigned>("out", 4);
        stripes.out<unsigned>("byWorker", 6);
        CHECK(ByHand::returned(stripes, way) == std::array<bool, 6>{true, true, true, true, false, false});
    }
    Call scale("orchard::Scale<int>");
    scale.in("in", Values<int>{});
    scale.out<int>("out", 0);
    scale.value("factor", 1);
    CHECK(ByHand::returned(scale, all_ways[0])[0]);
    Call above("orchard::Above");
    above.in("in", Values<float>{0.0f});
    above.in("threshold", 1.0f);
    above.in("strict", true);
    above.out<bool>("above", 1);
    above.out<bool>("any");
    CHECK_FALSE(ByHand::returned(above, all_ways[0])[0]);
}

TEST_CASE("fields are registered with the sizes of the documents")
{
    struct Row {
        char const* vertex;
        char const* field;
        Access access;
        unsigned rank;
        char const* type;
        unsigned element_bytes, align, state_bytes, inner_state_bytes;
    };
    // A span is a pointer and a size: two words. A short span, a bare pointer, a scalar edge and a plain member take one word each.
    Row const rows[] = {{"orchard::Pick", "table", Access::input, 1, "float", 4, 4, 4, 0},
                        {"orchard::Pick", "indices", Access::input, 1, "unsigned short", 2, 2, 4, 0},
                        {"orchard::Pick", "even", Access::output, 1, "signed char", 1, 4, 4, 0},
                        {"orchard::Pick", "tableSize", Access::value, 0, "unsigned", 4, 4, 4, 0},
                        {"orchard::RowSums", "rows", Access::input, 2, "int", 4, 4, 8, 8},
                        {"orchard::RowSums", "total", Access::inout, 0, "int", 4, 4, 4, 0},
                        {"orchard::Deal", "hands", Access::output, 2, "unsigned", 4, 4, 4, 4},
                        {"orchard::Deal", "piles", Access::inout, 2, "unsigned", 4, 8, 8, 8},
                        {"orchard::Deal", "players", Access::value, 0, "unsigned char", 1, 1, 4, 0},
                        {"orchard::Largest", "weights", Access::inout, 2, "float", 4, 8, 8, 4},
                        {"orchard::PairAxpy", "y", Access::inout, 1, "float", 4, 8, 4, 0},
                        {"orchard::HalfDot", "dot", Access::output, 0, "half", 2, 2, 4, 0},
                        {"orchard::Above", "above", Access::output, 1, "bool", 1, 1, 8, 0},
                        {"orchard::Polynomial", "coefficients", Access::value, 1, "half", 2, 2, 8, 0},
                        {"orchard::Polynomial", "exponents", Access::value, 2, "unsigned short", 2, 2, 8, 4},
                        {"orchard::Widths", "sum", Access::inout, 0, "long long", 8, 8, 4, 0}};
    for (Row const& row : rows) {
        CAPTURE(row.vertex);
        CAPTURE(row.field);
        auto const* const type = standin::find_vertex(row.vertex);
        REQUIRE(type != nullptr);
        auto const field =
            std::find_if(type->fields.begin(), type->fields.end(), [&](auto const& f) { return f.name == row.field; });
        REQUIRE(field != type->fields.end());
        CHECK(field->access == row.access);
        CHECK(field->rank == row.rank);
        CHECK(field->type == row.type);
        CHECK(field->element_bytes == row.element_bytes);
        CHECK(field->align == row.align);
        CHECK(field->state_bytes == row.state_bytes);
        CHECK(field->inner_state_bytes == row.inner_state_bytes);
    }
    CHECK(standin::find_vertex("orchard::Stripes")->kind == standin::Kind::multi);
    CHECK(standin::find_vertex("orchard::Reverse")->kind == standin::Kind::supervisor);
    CHECK(standin::find_vertex("orchard::Fill<unsigned int,false>")->kind == standin::Kind::worker);
    CHECK(standin::find_vertex("orchard::Fill<bool,true>")->kind == standin::Kind::supervisor);
    CHECK(standin::find_vertex("orchard::Nothing") == nullptr);
}

TEST_CASE("an edge that does not fit its field is refused")
{
    auto const* const type = standin::find_vertex("orchard::Pick");
    std::unique_ptr<void, void (*)(void*)> const vertex(type->make(), type->destroy);
    auto const bind = [&](unsigned field, void* data, std::size_t elements, std::size_t n) {
        std::vector<standin::Edge> const edges(2, {data, elements});
        type->fields[field].bind(vertex.get(), edges.data(), n);
    };
    alignas(16) unsigned char bytes[4096]{};
    CHECK_NOTHROW(bind(0, bytes, 4, 1));
    CHECK_THROWS_AS(bind(0, bytes + 2, 4, 1), std::invalid_argument); // floats at an odd halfword
    CHECK_NOTHROW(bind(0, bytes + 2, 0, 1));                          // an edge of no elements may be at any address
    CHECK_THROWS_AS(bind(0, bytes, 4, 2), std::invalid_argument);     // two edges for a vector
    CHECK_THROWS_AS(bind(0, bytes, 4, 0), std::invalid_argument);
    CHECK_NOTHROW(bind(1, bytes, 2047, 1)); // the largest count of 11 bits
    CHECK_THROWS_AS(bind(1, bytes, 2048, 1), std::invalid_argument);
    CHECK_THROWS_AS(bind(4, bytes, 2, 1), std::invalid_argument); // two values for one member
}

TEST_CASE("a half is the nearest of its kind")
{
    CHECK(sizeof(half) == 2);
    CHECK(alignof(half4) == 8);
    // Every half becomes a float and the same half again.
    for (std::uint32_t bits = 0; bits < 0x10000; ++bits) {
        auto const b = static_cast<std::uint16_t>(bits);
        float const value = standin::half_value(b);
        if ((b & 0x7fffu) > 0x7c00u) {
            CHECK(std::isnan(value));
            CHECK((standin::half_bits(value) & 0x7fffu) > 0x7c00u);
        } else if (standin::half_bits(value) != b) {
            FAIL_CHECK("half of " << bits);
        }
    }
    // A float between two neighbouring halves: below the middle it becomes the lower half, above it the upper half, at it the even half.
    for (std::uint32_t bits = 0; bits < 0x7bff; ++bits) {
        auto const low = static_cast<std::uint16_t>(bits), high = static_cast<std::uint16_t>(bits + 1);
        float const middle =
            0.5f * (standin::half_value(low) + standin::half_value(high)); // exact: the middle has one bit more than a half
        if (standin::half_bits(std::nextafterf(middle, 0.0f)) != low) FAIL_CHECK("below the middle after " << bits);
        if (standin::half_bits(std::nextafterf(middle, 1e30f)) != high) FAIL_CHECK("above the middle after " << bits);
        if (standin::half_bits(middle) != (bits % 2 == 0 ? low : high)) FAIL_CHECK("the middle after " << bits);
        if (standin::half_bits(-middle) != (0x8000u | (bits % 2 == 0 ? low : high)))
            FAIL_CHECK("minus the middle after " << bits);
    }
    CHECK(standin::half_bits(65519.99f) == 0x7bffu); // the last float that rounds down to 65,504
    CHECK(standin::half_bits(65520.0f) == 0x7c00u);
    CHECK(standin::half_bits(INFINITY) == 0x7c00u);
    CHECK(standin::half_bits(-1e30f) == 0xfc00u);
    CHECK(standin::half_bits(1e-30f) == 0);
    // A half with a half or an integer gives a half. A half with a float gives a float.
    static_assert(std::is_same_v<decltype(half(1) + half(1)), half>);
    static_assert(std::is_same_v<decltype(half(1) * 2), half>);
    static_assert(std::is_same_v<decltype(half(1) * 2.0f), float>);
    static_assert(half(0.5f) + 0.25_h == 0.75f);
}
