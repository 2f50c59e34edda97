// The stand-in for the Poplar SDK, whose headers are in standin/: it refuses what a graph may not say, and executes the graph in the
// memory of its tiles. Words that nobody wrote are poison, and so is an Output before its vertex computes.
#include "standin/standin.hpp"
#include <algorithm>
#include <array>
#include <cstring>
#include <cxxabi.h>
#include <numeric>
#include <optional>
#include <random>
#include <thread>
#include <unordered_map>

#if defined(__SANITIZE_ADDRESS__)
#    define STANDIN_ASAN 1
#elif defined(__has_feature)
#    if __has_feature(address_sanitizer)
#        define STANDIN_ASAN 1
#    endif
#endif
#ifdef STANDIN_ASAN
#    include <sanitizer/asan_interface.h>
#endif

namespace standin {
namespace {
using poplar::poplar_error;
using poplar::Tensor;
using poplar::program::Program;

/// A NaN as a float, and large as a count.
constexpr std::uint32_t poison = 0x7fa0dead;
constexpr unsigned no_tile = ~0u;
constexpr std::size_t guard_words = 4; ///< beside each piece, and watched beside each edge

[[noreturn]] void fail(std::string const& text)
{
    throw poplar_error(text);
}
std::size_t product(std::vector<std::size_t> const& shape, std::size_t first = 0)
{
    return std::accumulate(shape.begin() + static_cast<std::ptrdiff_t>(first), shape.end(), std::size_t{1}, std::multiplies<>());
}
std::map<std::string, VertexType, std::less<>>& vertex_types()
{
    static std::map<std::string, VertexType, std::less<>> types;
    return types;
}
} // namespace

Settings& settings()
{
    static Settings all;
    return all;
}
unsigned tiles() { return settings().tiles; }
std::size_t tile_bytes() { return settings().tile_bytes; }

void enter(VertexType type, std::type_info const& info, std::size_t bytes)
{
    std::unique_ptr<char, void (*)(void*)> const name{abi::__cxa_demangle(info.name(), nullptr, nullptr, nullptr), std::free};
    type.name = name.get();
    if ((bytes + 7) / 8 * 8 != type.bytes) fail("vertex " + type.name + " has a field that the stand-in does not know");
    if (!vertex_types().emplace(type.name, type).second) fail("two vertices named " + type.name);
}

// --- what a graph says --------------------------------------------------------------------------------------------------------
struct Piece {
    std::size_t begin, end; ///< elements
    unsigned tile;
    std::size_t at = 0; ///< place in the engine's memory
};
struct Variable {
    std::string name;
    std::size_t elements;
    std::vector<Piece> pieces;
};
struct FieldData {
    std::vector<std::optional<std::vector<Interval>>> edges; ///< one, unless the field is a list
    bool sized;
    std::optional<unsigned> value{};
};
struct VertexData {
    VertexType const* type;
    unsigned tile = no_tile;
    std::vector<FieldData> fields;
    std::string name() const { return "vertex " + type->name + " on tile " + std::to_string(tile); }
};
struct SetData {
    std::string name;
    std::vector<std::unique_ptr<VertexData>> vertices;
};
struct GraphData {
    unsigned tiles;
    std::size_t tile_bytes;
    bool has_codelets = false;
    std::vector<Variable> variables;
    std::vector<SetData> sets;
    std::vector<std::string> streams;
};
struct Node {
    enum class Kind { sequence, execute, copy, to_device, from_device, repeat, while_true, condition };
    Kind kind;
    std::vector<std::shared_ptr<Node const>> children{};
    std::size_t set = 0, count = 0;
    std::string stream{};
    std::vector<Interval> from{}, to{};

    static std::size_t id(poplar::ComputeSet const& set) { return set.id_; }
    static std::vector<Interval> predicate(Tensor const& t)
    {
        if (t.rank() != 0 || t.type_ != poplar::BOOL) fail("a predicate is no bool");
        return t.parts_;
    }
    static Node copy(Tensor const& from, Tensor const& to)
    {
        if (from.shape_ != to.shape_ || from.type_ != to.type_) fail("a Copy between tensors of different shapes or types");
        return {Kind::copy, {}, 0, 0, {}, from.parts_, to.parts_};
    }
    static Node copy(Tensor const& tensor, poplar::DataStream const& stream, bool to_device)
    {
        if (stream.to_device_ != to_device || stream.elements_ != tensor.numElements() || tensor.type_ != poplar::UNSIGNED_INT)
            fail("a Copy that does not fit stream " + stream.handle_);
        return {to_device ? Kind::to_device : Kind::from_device, {}, 0, 0, stream.handle_, tensor.parts_};
    }
};
namespace {
void append(std::vector<Interval>& list, Interval more)
{
    if (more.begin == more.end) return;
    if (!list.empty() && list.back().variable == more.variable && list.back().end == more.begin)
        list.back().end = more.end;
    else
        list.push_back(more);
}
/// Walks a list of intervals once.
struct Cursor {
    Interval const* at;
    std::size_t used = 0;
    void walk(std::size_t count, std::vector<Interval>* into)
    {
        while (count != 0) {
            auto const begin = at->begin + used, n = std::min(count, at->end - begin);
            if (into != nullptr) append(*into, {at->variable, begin, begin + n});
            used = begin + n == at->end ? 0 : used + n;
            if (used == 0) ++at;
            count -= n;
        }
    }
};
} // namespace
} // namespace standin

namespace poplar {
using standin::fail;
using standin::Node;

std::size_t Tensor::numElements() const { return standin::product(shape_); }
Tensor Tensor::slice(std::size_t begin, std::size_t end, unsigned dimension) const
{
    if (dimension >= rank() || begin > end || end > shape_[dimension]) fail("a slice outside its tensor");
    auto const inner = standin::product(shape_, dimension + 1);
    Tensor part;
    part.type_ = type_;
    part.shape_ = shape_;
    part.shape_[dimension] = end - begin;
    standin::Cursor cursor{parts_.data()};
    for (auto outer = standin::product(shape_) / std::max<std::size_t>(1, inner * shape_[dimension]); outer > 0; --outer) {
        cursor.walk(begin * inner, nullptr);
        cursor.walk((end - begin) * inner, &part.parts_);
        cursor.walk((shape_[dimension] - end) * inner, nullptr);
    }
    return part;
}
Tensor Tensor::operator[](std::size_t i) const
{
    auto part = slice(i, i + 1);
    part.shape_.erase(part.shape_.begin());
    return part;
}
Tensor Tensor::reshape(std::vector<std::size_t> const& shape) const
{
    if (standin::product(shape) != numElements()) fail("a shape of another number of elements");
    Tensor other = *this;
    other.shape_ = shape;
    return other;
}
Tensor Tensor::broadcast(unsigned times, unsigned dimension) const { return concat(std::vector<Tensor>(times, *this), dimension); }
Tensor concat(std::vector<Tensor> const& tensors, unsigned dimension)
{
    if (tensors.empty() || dimension >= tensors[0].rank()) fail("nothing to join");
    Tensor all = tensors[0];
    all.shape_[dimension] = 0;
    all.parts_.clear();
    std::vector<standin::Cursor> cursors;
    for (auto const& t : tensors) {
        auto shape = t.shape_;
        if (t.rank() == all.rank()) shape[dimension] = tensors[0].shape_[dimension];
        if (shape != tensors[0].shape_ || t.type_ != all.type_) fail("tensors of different shapes or types cannot be joined");
        all.shape_[dimension] += t.shape_[dimension];
        cursors.push_back({t.parts_.data()});
    }
    std::size_t const outer = dimension == 0 ? 1 : all.numElements() / standin::product(all.shape_, dimension);
    for (std::size_t i = 0; i < outer; ++i)
        for (std::size_t k = 0; k < tensors.size(); ++k) cursors[k].walk(standin::product(tensors[k].shape_, dimension), &all.parts_);
    return all;
}

FieldRef FieldRef::operator[](std::size_t i) const
{
    FieldRef edge = *this;
    edge.index_ = i;
    edge.indexed_ = true;
    return edge;
}
FieldRef VertexRef::operator[](char const* name) const
{
    auto const& fields = vertex_->type->fields;
    FieldRef field;
    field.vertex_ = vertex_;
    for (field.field_ = 0; field.field_ < fields.size(); ++field.field_)
        if (fields[field.field_].name == name) return field;
    fail("vertex " + vertex_->type->name + " has no field " + name);
}

Graph::Graph(Target const& target) : data_(std::make_shared<standin::GraphData>())
{
    data_->tiles = target.getNumTiles();
    data_->tile_bytes = target.getBytesPerTile();
}
void Graph::addCodelets(std::string const& path)
{
    if (path.empty()) fail("no codelets (the path is empty)");
    data_->has_codelets = true;
}
Tensor Graph::addVariable(Type type, std::vector<std::size_t> const& shape, std::string const& name)
{
    Tensor t;
    t.type_ = type;
    t.shape_ = shape;
    standin::append(t.parts_, {static_cast<unsigned>(data_->variables.size()), 0, t.numElements()});
    data_->variables.push_back({name, t.numElements(), {}});
    return t;
}
void Graph::setTileMapping(Tensor const& tensor, unsigned tile)
{
    if (tile >= data_->tiles) fail("there is no tile " + std::to_string(tile));
    for (auto const& part : tensor.parts_) data_->variables[part.variable].pieces.push_back({part.begin, part.end, tile});
}
void Graph::setTileMapping(VertexRef const& vertex, unsigned tile)
{
    if (tile >= data_->tiles) fail("there is no tile " + std::to_string(tile));
    vertex.vertex_->tile = tile;
}
ComputeSet Graph::addComputeSet(std::string const& name)
{
    ComputeSet set;
    set.id_ = data_->sets.size();
    data_->sets.push_back({name, {}});
    return set;
}
VertexRef Graph::addVertex(ComputeSet const& set, std::string const& name)
{
    auto const found = standin::vertex_types().find(name);
    if (!data_->has_codelets || found == standin::vertex_types().end()) fail("there is no codelet " + name);
    auto vertex = std::make_unique<standin::VertexData>();
    vertex->type = &found->second;
    for (auto const& f : found->second.fields) vertex->fields.push_back({std::vector<std::optional<std::vector<standin::Interval>>>(f.rank < 2), f.rank < 2});
    VertexRef ref;
    ref.vertex_ = vertex.get();
    data_->sets[set.id_].vertices.push_back(std::move(vertex));
    return ref;
}
void Graph::setFieldSize(FieldRef const& field, std::size_t size)
{
    if (field.vertex_->type->fields[field.field_].rank != 2 || field.indexed_) fail("only a list has a size");
    field.vertex_->fields[field.field_].edges.resize(size);
    field.vertex_->fields[field.field_].sized = true;
}
void Graph::connect(FieldRef const& field, Tensor const& tensor)
{
    auto const& f = field.vertex_->type->fields[field.field_];
    auto& edges = field.vertex_->fields[field.field_].edges;
    if (f.access == standin::Access::value || field.indexed_ != (f.rank == 2) || tensor.rank() != (f.rank == 0 ? 0 : 1) ||
        (tensor.type_ == BOOL) != (f.rank == 0) || field.index_ >= edges.size() || edges[field.index_])
        fail("field " + f.name + " of vertex " + field.vertex_->type->name + " does not take this tensor");
    edges[field.index_] = tensor.parts_;
}
void Graph::setInitialValue(FieldRef const& field, unsigned value)
{
    if (field.vertex_->type->fields[field.field_].access != standin::Access::value) fail("only a plain member has a value");
    field.vertex_->fields[field.field_].value = value;
}
DataStream Graph::addHostToDeviceFIFO(std::string const& handle, Type, std::size_t elements)
{
    if (std::find(data_->streams.begin(), data_->streams.end(), handle) != data_->streams.end()) fail("two streams " + handle);
    data_->streams.push_back(handle);
    return {handle, elements, true};
}
DataStream Graph::addDeviceToHostFIFO(std::string const& handle, Type type, std::size_t elements)
{
    auto stream = addHostToDeviceFIFO(handle, type, elements);
    stream.to_device_ = false;
    return stream;
}

namespace program {
Program::Program(Node node) : node_(std::make_shared<Node>(std::move(node))) {}
Sequence::Sequence() : Program(Node{Node::Kind::sequence}) {}
void Sequence::add(Program const& program)
{
    auto added = program.node(); // first: a sequence may be added to itself
    if (node_.use_count() > 1) node_ = std::make_shared<Node>(*node_);
    node_->children.push_back(std::move(added));
}
Execute::Execute(ComputeSet const& set) : Program(Node{Node::Kind::execute, {}, Node::id(set)}) {}
Copy::Copy(Tensor const& source, Tensor const& destination) : Program(Node::copy(source, destination)) {}
Copy::Copy(DataStream const& stream, Tensor const& destination) : Program(Node::copy(destination, stream, true)) {}
Copy::Copy(Tensor const& source, DataStream const& stream) : Program(Node::copy(source, stream, false)) {}
Repeat::Repeat(unsigned count, Program const& body) : Program(Node{Node::Kind::repeat, {body.node()}, 0, count}) {}
RepeatWhileTrue::RepeatWhileTrue(Program const& condition, Tensor const& predicate, Program const& body)
    : Program(Node{Node::Kind::while_true, {condition.node(), body.node()}, 0, 0, {}, Node::predicate(predicate)})
{
}
If::If(Tensor const& predicate, Program const& where_true, Program const& where_false)
    : Program(Node{Node::Kind::condition, {where_true.node(), where_false.node()}, 0, 0, {}, Node::predicate(predicate)})
{
}
} // namespace program
} // namespace poplar

// --- execution ------------------------------------------------------------------------------------------------------------------
namespace standin {
namespace {
/// Words in the memory of one tile.
struct Run {
    unsigned tile;
    std::size_t at, words;
};
using Moves = std::vector<std::pair<Run, Run>>; ///< from, to; of equal length
struct Edge {
    Access access;
    Run run;
    std::uint64_t beside = 0, contents = 0; ///< digests before the vertex computes
};
struct Span { ///< poplar::Vector
    void* data;
    unsigned size;
};
struct BoundVertex {
    VertexData const* said;
    std::vector<Edge> edges{};
    std::vector<Span> spans{};
    std::unique_ptr<std::uint64_t[]> object{};
};
struct BoundSet {
    std::vector<BoundVertex> vertices{};
    Moves gathers{};
};

struct Use {
    Interval part;
    bool writes;
};
/// Refuses two uses of a word of which one writes.
void refuse_conflicts(std::vector<Use>& uses, std::string const& of, std::vector<Variable> const& variables)
{
    std::sort(uses.begin(), uses.end(), [](Use const& a, Use const& b) {
        return std::pair(a.part.variable, a.part.begin) < std::pair(b.part.variable, b.part.begin);
    });
    std::size_t read = 0, written = 0; // the ends of earlier uses
    unsigned variable = ~0u;
    for (auto const& [part, writes] : uses) {
        if (part.variable != variable) read = written = 0;
        variable = part.variable;
        if (part.begin < written || (writes && part.begin < read))
            fail(of + " touches a word of variable " + variables[variable].name + " twice, and writes it");
        auto& end = writes ? written : read;
        end = std::max(end, part.end);
    }
}

void close([[maybe_unused]] std::uint32_t* at, [[maybe_unused]] std::size_t words)
{
#ifdef STANDIN_ASAN
    __asan_poison_memory_region(at, words * 4);
#endif
}
void open([[maybe_unused]] std::uint32_t* at, [[maybe_unused]] std::size_t words)
{
#ifdef STANDIN_ASAN
    __asan_unpoison_memory_region(at, words * 4);
#endif
}
} // namespace

class Executable {
public:
    Executable(std::shared_ptr<GraphData const> graph, std::vector<Program> const& programs) : graph_(std::move(graph)), bytes_(graph_->tiles)
    {
        for (auto const& p : programs) programs_.push_back(p.node());
        for (auto const& v : graph_->variables) variables_.push_back(place(v));
        for (auto const& s : graph_->sets) sets_.push_back(bind(s));
        for (unsigned t = 0; t < graph_->tiles; ++t)
            if (auto const sum = bytes_[t].total(); sum > graph_->tile_bytes)
                fail("tile " + std::to_string(t) + " holds " + std::to_string(sum) + " bytes, " + std::to_string(sum - graph_->tile_bytes) +
                     " more than its " + std::to_string(graph_->tile_bytes));
        for (auto const& p : programs_) resolve(*p);
        memory_.reset(new std::uint32_t[next_]);
        std::fill_n(memory_.get(), next_, poison);
        for (auto& s : sets_)
            for (auto& v : s.vertices) make(v);
    }
    Executable(Executable const&) = delete;
    Executable& operator=(Executable const&) = delete;
    ~Executable() { open(memory_.get(), next_); }

    void run(unsigned program)
    {
        if (!loaded) fail("the engine is on no device");
        random_.seed(1);
        execute(*programs_.at(program));
    }
    std::function<void(void*)>& stream(std::string const& handle)
    {
        if (std::find(graph_->streams.begin(), graph_->streams.end(), handle) == graph_->streams.end()) fail("there is no stream " + handle);
        return callbacks_[handle];
    }
    void connect(std::string const& handle, void* memory)
    {
        stream(handle);
        memories_[handle] = memory;
    }
    TileBytes const& bytes(unsigned tile) const { return bytes_[tile]; }
    std::vector<Exchange> exchanges() const
    {
        std::vector<Exchange> all;
        auto const add = [&](Exchange::Kind kind, std::string const& name, Moves const& moves) {
            Exchange e{kind, name, {}};
            for (auto const& [from, to] : moves) e.words[{from.tile, to.tile}] += from.words;
            if (!moves.empty()) all.push_back(e);
        };
        for (auto const* copy : copies_) add(Exchange::Kind::copy, variable_of(copy->from) + " -> " + variable_of(copy->to), moves_.at(copy));
        for (std::size_t s = 0; s < sets_.size(); ++s) add(Exchange::Kind::gather, graph_->sets[s].name, sets_[s].gathers);
        return all;
    }
    bool loaded = false;
    std::size_t host_copies = 0;

private:
    std::size_t take(std::size_t words) { return std::exchange(next_, (next_ + words + guard_words + 7) / 8 * 8); }
    Variable place(Variable v)
    {
        std::sort(v.pieces.begin(), v.pieces.end(), [](Piece const& a, Piece const& b) { return a.begin < b.begin; });
        std::size_t end = 0;
        for (auto& p : v.pieces) {
            if (p.begin != std::exchange(end, p.end)) fail("an element of variable " + v.name + " is on no tile, or on two");
            p.at = take(p.end - p.begin);
            bytes_[p.tile].variables[v.name] += 4 * (p.end - p.begin);
        }
        if (end != v.elements) fail("an element of variable " + v.name + " is on no tile");
        return v;
    }
    std::string variable_of(std::vector<Interval> const& parts) const { return parts.empty() ? "nothing" : variables_[parts[0].variable].name; }
    std::vector<Run> runs(std::vector<Interval> const& parts) const
    {
        std::vector<Run> all;
        for (auto part : parts) {
            auto const& pieces = variables_[part.variable].pieces;
            auto p = std::upper_bound(pieces.begin(), pieces.end(), part.begin, [](std::size_t at, Piece const& q) { return at < q.end; });
            for (; part.begin < part.end; ++p) {
                auto const n = std::min(part.end, p->end) - part.begin;
                all.push_back({p->tile, p->at + (part.begin - p->begin), n});
                part.begin += n;
            }
        }
        return all;
    }
    BoundSet bind(SetData const& set)
    {
        BoundSet bound;
        std::vector<Use> uses;
        for (auto const& vertex : set.vertices) {
            if (vertex->tile == no_tile) fail("a " + vertex->name() + ", which is none");
            auto& v = bound.vertices.emplace_back(BoundVertex{vertex.get()});
            auto& state = bytes_[vertex->tile].vertex_state;
            for (std::size_t f = 0; f < vertex->fields.size(); ++f) {
                auto const& field = vertex->type->fields[f];
                auto const& data = vertex->fields[f];
                if (!data.sized || (field.access == Access::value && !data.value))
                    fail("field " + field.name + " of " + vertex->name() + " has no size, or no value");
                state += field.rank == 0 ? 4 : field.rank == 1 ? 8 : 8 * (1 + data.edges.size());
                if (field.access == Access::value) continue;
                for (auto const& parts : data.edges) {
                    if (!parts) fail("field " + field.name + " of " + vertex->name() + " is not connected");
                    for (auto const& part : *parts) uses.push_back({part, field.access != Access::input});
                    v.edges.push_back({field.access, edge_of(bound, vertex->tile, field.access, runs(*parts))});
                }
            }
        }
        refuse_conflicts(uses, "compute set " + set.name, graph_->variables);
        return bound;
    }
    /// An edge in place, or else its copy on the vertex's tile. (Poplar would also copy an edge that the vertex writes.)
    Run edge_of(BoundSet& set, unsigned tile, Access access, std::vector<Run> const& all)
    {
        if (all.size() == 1 && all[0].tile == tile) return all[0];
        if (access != Access::input && !all.empty()) fail("an edge that a vertex writes is not one piece on its tile " + std::to_string(tile));
        Run edge{tile, 0, 0};
        for (auto const& run : all) edge.words += run.words;
        edge.at = take(edge.words);
        bytes_[tile].temporaries += 4 * edge.words;
        auto at = edge.at;
        for (auto const& run : all) {
            set.gathers.push_back({run, {tile, at, run.words}});
            at += run.words;
        }
        return edge;
    }
    void resolve(Node const& node)
    {
        for (auto const& child : node.children) resolve(*child);
        if (moves_.contains(&node)) return;
        auto from = runs(node.from), to = runs(node.to);
        auto& moves = moves_[&node];
        if (node.kind != Node::Kind::copy) { // of a stream, or a predicate
            for (auto const& run : from) moves.emplace_back(run, run);
            return;
        }
        copies_.push_back(&node);
        std::vector<Use> uses;
        for (auto const& part : node.from) uses.push_back({part, false});
        for (auto const& part : node.to) uses.push_back({part, true});
        refuse_conflicts(uses, "a Copy to " + variable_of(node.to), graph_->variables);
        for (auto f = from.begin(), t = to.begin(); f != from.end();) {
            auto const n = std::min(f->words, t->words);
            moves.push_back({{f->tile, f->at, n}, {t->tile, t->at, n}});
            f->at += n, t->at += n, f->words -= n, t->words -= n;
            if (f->words == 0) ++f;
            if (t->words == 0) ++t;
        }
    }
    /// A vertex's memory: zeros, plain members, and pointers to its edges.
    void make(BoundVertex& v)
    {
        v.object = std::make_unique<std::uint64_t[]>(v.said->type->bytes / 8 + 1);
        for (auto const& e : v.edges) v.spans.push_back({memory_.get() + e.run.at, static_cast<unsigned>(e.run.words)});
        auto* span = v.spans.data();
        for (std::size_t f = 0; f < v.said->fields.size(); ++f) {
            auto const& field = v.said->type->fields[f];
            auto const& data = v.said->fields[f];
            auto* const at = reinterpret_cast<char*>(v.object.get()) + field.offset;
            Span const list{span, static_cast<unsigned>(data.edges.size())};
            if (field.access == Access::value)
                std::memcpy(at, &*data.value, 4);
            else if (field.rank == 0)
                std::memcpy(at, &span->data, sizeof span->data);
            else
                std::memcpy(at, field.rank == 1 ? span : &list, sizeof list);
            if (field.access != Access::value) span += list.size;
        }
    }

    void execute(Node const& node)
    {
        using Kind = Node::Kind;
        switch (node.kind) {
        case Kind::sequence:
            for (auto const& child : node.children) execute(*child);
            break;
        case Kind::execute: compute(sets_[node.set], graph_->sets[node.set].name); break;
        case Kind::copy: move(moves_.at(&node)); break;
        case Kind::repeat:
            for (std::size_t i = 0; i < node.count; ++i) execute(*node.children[0]);
            break;
        case Kind::while_true:
            for (std::uint64_t pass = 0; execute(*node.children[0]), predicate(node); ++pass) {
                if (pass >= settings().while_limit) fail("a RepeatWhileTrue did not end");
                execute(*node.children[1]);
            }
            break;
        case Kind::condition: execute(*node.children[predicate(node) ? 0 : 1]); break;
        case Kind::to_device:
        case Kind::from_device: transfer(node); break;
        }
    }
    bool predicate(Node const& node) const
    {
        unsigned char value;
        std::memcpy(&value, memory_.get() + moves_.at(&node)[0].first.at, 1);
        if (value > 1) fail("a predicate that nobody wrote");
        return value == 1;
    }
    void move(Moves const& moves)
    {
        for (auto const& [from, to] : moves) std::memcpy(memory_.get() + to.at, memory_.get() + from.at, from.words * 4);
    }
    void transfer(Node const& node)
    {
        auto const& callback = callbacks_[node.stream];
        auto* words = static_cast<std::uint32_t*>(memories_[node.stream]);
        std::vector<std::uint32_t> buffer;
        if (callback) {
            for (auto const& part : node.from) buffer.resize(buffer.size() + (part.end - part.begin));
            words = buffer.data();
        }
        if (words == nullptr) fail("nothing is connected to stream " + node.stream);
        for (auto const& [run, same] : moves_.at(&node)) {
            auto* const tile = memory_.get() + run.at;
            std::memcpy(node.kind == Node::Kind::to_device ? tile : words, node.kind == Node::Kind::to_device ? words : tile, run.words * 4);
            words += run.words;
        }
        if (callback) callback(buffer.data());
        ++host_copies;
    }

    template <class List>
    void arrange(List& list, Order order)
    {
        std::iota(list.begin(), list.end(), 0u);
        if (order == Order::descending) std::reverse(list.begin(), list.end());
        if (order == Order::permuted)
            for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[random_() % i]);
    }
    void compute(BoundSet& set, std::string const& name)
    {
        move(set.gathers);
        std::vector<unsigned> order(set.vertices.size());
        arrange(order, settings().vertices);
        close(memory_.get(), next_);
        for (auto const i : order) compute_one(set.vertices[i], name);
        open(memory_.get(), next_);
    }
    /// Computes a vertex. It may write its outputs, and nothing beside its edges changes. To AddressSanitizer its edges alone are open.
    void compute_one(BoundVertex& v, std::string const& set)
    {
        auto const each = [&](auto const& f) {
            for (auto& e : v.edges) f(e, memory_.get() + e.run.at);
        };
        bool const digests = settings().check_inputs;
        each([](Edge& e, std::uint32_t* at) { open(at - guard_words, e.run.words + 2 * guard_words); });
        each([](Edge& e, std::uint32_t* at) {
            if (e.access == Access::output) std::fill_n(at, e.run.words, poison);
        });
        each([&](Edge& e, std::uint32_t* at) {
            e.beside = beside(e, at);
            if (digests && e.access == Access::input) e.contents = digest(at, e.run.words);
        });
        each([](Edge& e, std::uint32_t* at) {
            close(at - guard_words, guard_words);
            close(at + e.run.words, guard_words);
        });
        each([](Edge& e, std::uint32_t* at) { open(at, e.run.words); });
        run_workers(v);
        each([](Edge& e, std::uint32_t* at) { open(at - guard_words, e.run.words + 2 * guard_words); });
        each([&](Edge& e, std::uint32_t* at) {
            if (e.beside != beside(e, at)) fail(v.said->name() + " wrote beside an edge (compute set " + set + ")");
            if (digests && e.access == Access::input && e.contents != digest(at, e.run.words)) fail(v.said->name() + " wrote an Input (compute set " + set + ")");
        });
        each([](Edge& e, std::uint32_t* at) { close(at - guard_words, e.run.words + 2 * guard_words); });
    }
    static std::uint64_t beside(Edge const& e, std::uint32_t const* at)
    {
        return digest(at - guard_words, guard_words) + 3 * digest(at + e.run.words, guard_words);
    }
    static std::uint64_t digest(std::uint32_t const* at, std::size_t words)
    {
        std::uint64_t sum = words;
        for (std::size_t i = 0; i < words; ++i) sum = (sum ^ at[i]) * 0x9e3779b97f4a7c15u; // odd: each word changes the sum
        return sum;
    }
    void run_workers(BoundVertex& v)
    {
        auto const& type = *v.said->type;
        if (!type.multi) {
            type.compute(v.object.get(), 0);
            return;
        }
        std::array<unsigned, 6> order;
        arrange(order, settings().workers);
        std::vector<std::thread> threads; // nothing orders one worker after another
        for (auto const w : order)
            if (settings().threads)
                threads.emplace_back(type.compute, v.object.get(), w);
            else
                type.compute(v.object.get(), w);
        for (auto& t : threads) t.join();
    }

    std::shared_ptr<GraphData const> graph_;
    std::vector<std::shared_ptr<Node const>> programs_;
    std::vector<TileBytes> bytes_;
    std::vector<Variable> variables_; ///< with places
    std::vector<BoundSet> sets_;
    std::unordered_map<Node const*, Moves> moves_;
    std::vector<Node const*> copies_; ///< between tensors, in the order in which the programs reach them
    std::map<std::string, void*> memories_;
    std::map<std::string, std::function<void(void*)>> callbacks_;
    std::size_t next_ = 8;
    std::unique_ptr<std::uint32_t[]> memory_;
    std::mt19937 random_;
};

std::size_t TileBytes::total() const
{
    std::size_t sum = temporaries + vertex_state + settings().code_bytes;
    for (auto const& v : variables) sum += v.second;
    return sum;
}
TileBytes tile_bytes(poplar::Engine const& engine, unsigned tile) { return engine.executable().bytes(tile); }
std::vector<Exchange> exchanges(poplar::Engine const& engine) { return engine.executable().exchanges(); }
std::size_t host_copies(poplar::Engine const& engine) { return engine.executable().host_copies; }
} // namespace standin

namespace poplar {
Engine::Engine(Graph const& graph, std::vector<program::Program> const& programs)
    : executable_(std::make_shared<standin::Executable>(graph.data_, programs))
{
}
void Engine::load(Device const& device)
{
    if (!device.isAttached()) fail("the device is not attached");
    executable_->loaded = true;
}
void Engine::connectStream(std::string const& handle, void* memory) { executable_->connect(handle, memory); }
void Engine::connectStreamToCallback(std::string const& handle, std::function<void(void*)> callback)
{
    executable_->stream(handle) = std::move(callback);
}
void Engine::run(unsigned program) { executable_->run(program); }
} // namespace poplar
