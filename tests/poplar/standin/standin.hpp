// Part of the stand-in for the Poplar SDK: its settings for tests, its reports, and the registration of vertices.
#pragma once
#include "host.hpp"
#include <cstddef>
#include <cstdint>
#include <map>
#include <poplar/Vertex.hpp>
#include <string>
#include <type_traits>
#include <typeinfo>
#include <vector>

namespace standin {

/// An order of things that have none on the machine.
enum class Order { ascending, descending, permuted };

struct Settings {
    Order workers = Order::ascending;  ///< of the six workers of a MultiVertex, one after the other
    Order vertices = Order::ascending; ///< of the vertices of a compute set
    bool threads = false;              ///< the six workers of a MultiVertex run at once
    bool check_inputs = false;         ///< an Input that changed while its vertex computed is an error
    unsigned tiles = 1472;             ///< of a device, as on a Mk2 chip
    std::size_t tile_bytes = 638976;   ///< of a device's tile: 624 KiB
    std::size_t code_bytes = 0;        ///< of code, stacks and exchange sequences on each tile
    std::uint64_t while_limit = 1'000'000; ///< most passes of one RepeatWhileTrue; the machine would hang
};
Settings& settings();

/// Restores the settings of now at its end.
class Restore {
public:
    Restore() = default;
    Restore(Restore const&) = delete;
    Restore& operator=(Restore const&) = delete;
    ~Restore() { settings() = before_; }

private:
    Settings before_ = settings();
};

/// The contents of a tile in bytes.
struct TileBytes {
    std::map<std::string, std::size_t> variables; ///< equal names are added
    std::size_t temporaries = 0;                  ///< of edges that are not one piece on their vertex's tile
    std::size_t vertex_state = 0;                 ///< pointers, sizes and plain members
    std::size_t total() const;                    ///< with Settings::code_bytes
};
TileBytes tile_bytes(poplar::Engine const& engine, unsigned tile);

/// Words that move at once: by a Copy, or before a compute set that reads edges which are not one piece on their vertex's tile (gather).
struct Exchange {
    enum class Kind { copy, gather };
    Kind kind;
    std::string name; ///< "source -> destination", by variables, or the name of the compute set
    std::map<std::pair<unsigned, unsigned>, std::size_t> words; ///< from tile, to tile
};
std::vector<Exchange> exchanges(poplar::Engine const& engine);

/// The Copies with a stream in all runs of an engine.
std::size_t host_copies(poplar::Engine const& engine);

// --- vertices ---------------------------------------------------------------------------------------------------------------
enum class Access { value, input, inout, output };
struct Field {
    std::string name;
    Access access; ///< value: a plain member
    unsigned rank; ///< 0: one element, 1: a vector, 2: a list of vectors
    std::size_t offset;
};
struct VertexType {
    std::string name;
    std::size_t bytes;
    bool multi;
    bool (*compute)(void* vertex, unsigned worker);
    std::vector<Field> fields;
};
/// Makes a vertex known under its class's name. `bytes`: of all fields, which must fill the class.
void enter(VertexType type, std::type_info const& info, std::size_t bytes);

template <class T>
struct FieldOf;
template <>
struct FieldOf<unsigned> {
    static constexpr Access access = Access::value;
    static constexpr unsigned rank = 0;
};
template <>
struct FieldOf<poplar::Output<bool>> {
    static constexpr Access access = Access::output;
    static constexpr unsigned rank = 0;
};
template <template <class> class Edge>
struct FieldOf<Edge<poplar::Vector<unsigned>>> {
    static constexpr Access access = std::is_same_v<Edge<int>, poplar::Input<int>>   ? Access::input
                                     : std::is_same_v<Edge<int>, poplar::InOut<int>> ? Access::inout
                                                                                     : Access::output;
    static constexpr unsigned rank = 1;
};
template <class Edge>
struct FieldOf<poplar::Vector<Edge>> : FieldOf<Edge> {
    static constexpr unsigned rank = 2;
};

template <class V>
void enter_one()
{
    alignas(V) static char object[sizeof(V)]{};
    VertexType type{{}, sizeof(V), std::is_base_of_v<poplar::MultiVertex, V>, nullptr, {}};
    type.compute = [](void* vertex, [[maybe_unused]] unsigned worker) {
        if constexpr (std::is_base_of_v<poplar::MultiVertex, V>)
            return static_cast<V*>(vertex)->compute(worker);
        else
            return static_cast<V*>(vertex)->compute();
    };
    std::size_t bytes = 0;
    [[maybe_unused]] auto const add = [&](char const* name, auto& field) {
        using F = FieldOf<std::remove_reference_t<decltype(field)>>;
        type.fields.push_back({name, F::access, F::rank, static_cast<std::size_t>(reinterpret_cast<char*>(&field) - object)});
        bytes += sizeof field;
    };
    V& v = reinterpret_cast<V&>(object);
#define STANDIN_FIELD(name)                                                                                                    \
    if constexpr (requires { v.name; }) add(#name, v.name)
    STANDIN_FIELD(reads);
    STANDIN_FIELD(keeps);
    STANDIN_FIELD(sends);
    STANDIN_FIELD(x);
    STANDIN_FIELD(y);
    STANDIN_FIELD(width);
    STANDIN_FIELD(height);
    STANDIN_FIELD(step);
    STANDIN_FIELD(log_at);
    STANDIN_FIELD(task);
    STANDIN_FIELD(program);
    STANDIN_FIELD(words);
    STANDIN_FIELD(said);
    STANDIN_FIELD(any);
    STANDIN_FIELD(log);
    STANDIN_FIELD(again);
    STANDIN_FIELD(at_most);
    STANDIN_FIELD(touched);
    STANDIN_FIELD(word);
#undef STANDIN_FIELD
    enter(std::move(type), typeid(V), bytes);
}

/// Makes vertices known to addVertex: `standin::Vertices<heat_Diffuse> const entered;`
template <class... V>
struct Vertices {
    Vertices() { (enter_one<V>(), ...); }
};

} // namespace standin
