#pragma once
#include "../detail/graph_data.hpp"
#include "DataStream.hpp"
#include "Target.hpp"
#include "Tensor.hpp"
#include "exceptions.hpp"
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

/// Part of a stand-in for the Poplar SDK: the graph of variables, compute sets and vertices.
namespace poplar {

class Graph;
class Engine;

/// A set of vertices that compute at once: a superstep.
class ComputeSet {
public:
    ComputeSet() = default;
    unsigned getId() const { return id_; }

private:
    friend class Graph;
    explicit ComputeSet(unsigned id) : id_(id) {}
    unsigned id_ = ~0u;
};

/// A field of a vertex, or one vector of a field that is a list.
class FieldRef {
public:
    /// Vector `i` of a list.
    FieldRef operator[](std::size_t i) const { return {*vertex_, field_, i, true}; }

private:
    friend class Graph;
    friend class VertexRef;
    FieldRef(standin::detail::Vertex& vertex, unsigned field, std::size_t index, bool indexed)
        : vertex_(&vertex), field_(field), index_(index), indexed_(indexed)
    {}
    standin::Field const& field() const { return vertex_->type->fields[field_]; }
    std::string name() const
    {
        return standin::detail::vertex_name(*vertex_) + ", field " +
               (indexed_ ? standin::detail::field_name(field(), index_) : field().name);
    }
    standin::detail::Vertex* vertex_;
    unsigned field_;
    std::size_t index_;
    bool indexed_;
};

class VertexRef {
public:
    VertexRef() = default;

    /// The field of that name. Throws if the codelet has none.
    FieldRef operator[](std::string_view name) const
    {
        auto const& fields = vertex_->type->fields;
        for (unsigned f = 0; f < fields.size(); ++f)
            if (fields[f].name == name) return {*vertex_, f, 0, false};
        throw unknown_field("Vertex " + vertex_->type->name + " has no field " + std::string(name) +
                            " (its codelet declares none of that name); name one that it has");
    }

private:
    friend class Graph;
    explicit VertexRef(standin::detail::Vertex& vertex) : vertex_(&vertex) {}
    standin::detail::Vertex* vertex_ = nullptr;
};

/// Variables, constants, vertices and streams of one program. Move only. Its tensors, references and engines stay valid during the
/// lifetime of the graph or of an engine built from it.
class Graph {
public:
    explicit Graph(Target const& target) : target_(target), data_(std::make_shared<standin::detail::GraphData>())
    {
        data_->tiles = target.getNumTiles();
        data_->tile_bytes = target.getBytesPerTile();
    }
    Graph(Graph&&) = default;
    Graph& operator=(Graph&&) = default;

    Target const& getTarget() const { return target_; }

    /// Makes codelets known. In this stand-in these are the linked codelets, for any path.
    void addCodelets(std::string const& path, std::string const& = {})
    {
        if (path.empty()) throw graph_object_load_error("No codelets were loaded (the path is empty); give a codelet file");
        data_->has_codelets = true;
    }

    Tensor addVariable(Type type, std::vector<std::size_t> const& shape, std::string const& name = {})
    {
        return add(type, shape, name, false, {});
    }

    /// A constant tensor of the values at `values`, in row-major order.
    template <class T>
    Tensor addConstant(Type type, std::vector<std::size_t> const& shape, T const* values, std::string const& name = {})
    {
        Tensor const empty(data_.get(), type, shape);
        return add(type, shape, name, true, bytes_of(type, values, empty.numElements()));
    }
    /// A constant tensor. All its elements are `value`.
    template <class T, std::enable_if_t<std::is_arithmetic_v<T>, int> = 0>
    Tensor addConstant(Type type, std::vector<std::size_t> const& shape, T value, std::string const& name = {})
    {
        Tensor const empty(data_.get(), type, shape);
        auto const one = bytes_of(type, &value, 1);
        std::vector<unsigned char> all(empty.numElements() * one.size());
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = one[i % one.size()];
        return add(type, shape, name, true, std::move(all));
    }

    /// Maps elements to a tile and replaces their older mapping.
    void setTileMapping(Tensor const& tensor, unsigned tile)
    {
        require_tile(tile);
        require_own(tensor);
        for (auto const& part : tensor.parts()) data_->variables[part.variable].map(part.begin, part.end, tile);
    }
    void setTileMapping(VertexRef const& vertex, unsigned tile)
    {
        require_tile(tile);
        vertex.vertex_->tile = tile;
    }

    ComputeSet addComputeSet(std::string const& name = {})
    {
        data_->compute_sets.push_back({name, {}});
        return ComputeSet(static_cast<unsigned>(data_->compute_sets.size() - 1));
    }

    /// A vertex of the codelet of that name. Throws if no such codelet is linked.
    VertexRef addVertex(ComputeSet const& set, std::string const& name)
    {
        if (!data_->has_codelets)
            throw unknown_vertex_type("There is no codelet " + name +
                                      " (the graph has no codelets yet); call addCodelets first");
        standin::VertexType const* const type = standin::find_vertex(name);
        if (type == nullptr)
            throw unknown_vertex_type("There is no codelet " + name +
                                      " (none of that name was loaded); name one that is in the codelet file");
        auto& vertices = data_->compute_sets.at(set.getId()).vertices;
        vertices.emplace_back();
        vertices.back().type = type;
        vertices.back().list_sizes.assign(type->fields.size(), standin::detail::no_size);
        return VertexRef(vertices.back());
    }

    /// Sets the number of vectors of a list.
    void setFieldSize(FieldRef const& field, std::size_t size)
    {
        if (field.field().rank != 2 || field.indexed_)
            throw graph_connection_error(field.name() +
                                         " takes no size (it is no list of vectors); connect a tensor to it");
        field.vertex_->list_sizes[field.field_] = size;
    }

    /// Connects a tensor to a field: a scalar to one element, a vector to a vector, rows of a matrix to a list.
    void connect(FieldRef const& field, Tensor const& tensor)
    {
        standin::Field const& f = field.field();
        require_own(tensor);
        if (f.access == standin::Access::value)
            throw graph_connection_error(field.name() + " takes no tensor (it is a plain member); call setInitialValue");
        if (f.rank == 2 && !field.indexed_ && tensor.rank() == 2) {
            std::size_t const rows = tensor.dim(0);
            setFieldSize(field, rows);
            for (std::size_t i = 0; i < rows; ++i) connect(field[i], tensor[i]);
            return;
        }
        unsigned const rank = f.rank - (field.indexed_ ? 1u : 0u);
        if ((f.rank != 2 && field.indexed_) || tensor.rank() != rank || rank > 1)
            throw graph_connection_error(field.name() + " does not take a tensor of shape " +
                                         Tensor::shape_text(tensor.shape()) + " (it has rank " + std::to_string(f.rank) +
                                         (field.indexed_ ? " and is indexed" : "") + "); connect a tensor of its rank");
        require_index(field);
        if (standin::detail::type_named(f.type) != tensor.elementType())
            throw type_error(field.name() + " holds " + f.type + " (the tensor holds " + tensor.elementType().toString() +
                             "); connect a tensor of its type");
        field.vertex_->connections.push_back({field.field_, field.index_, tensor.parts()});
    }

    /// Connects one tensor to each vector of a list.
    void connect(FieldRef const& field, std::vector<Tensor> const& tensors)
    {
        setFieldSize(field, tensors.size());
        for (std::size_t i = 0; i < tensors.size(); ++i) connect(field[i], tensors[i]);
    }

    /// Sets the value of a plain member.
    template <class T, std::enable_if_t<std::is_arithmetic_v<T>, int> = 0>
    void setInitialValue(FieldRef const& field, T value)
    {
        require_value(field, 0);
        set_value(field, &value, 1);
    }
    /// Sets the values of a table that the vertex keeps.
    template <class T>
    void setInitialValue(FieldRef const& field, std::vector<T> const& values)
    {
        require_value(field, 1);
        set_value(field, values.data(), values.size());
    }

    /// Takes an estimate of a vertex's cycles and operations, and ignores it: the stand-in has no clock.
    void setPerfEstimate(VertexRef const&, std::uint64_t, std::uint64_t = 0) {}

    DataStream addHostToDeviceFIFO(std::string const& handle, Type type, std::size_t elements)
    {
        return add_stream(handle, type, elements, true);
    }
    DataStream addDeviceToHostFIFO(std::string const& handle, Type type, std::size_t elements)
    {
        return add_stream(handle, type, elements, false);
    }

private:
    friend class Engine;

    Tensor add(Type type, std::vector<std::size_t> const& shape, std::string const& name, bool constant,
               std::vector<unsigned char> contents)
    {
        Tensor tensor(data_.get(), type, shape, static_cast<unsigned>(data_->variables.size()));
        standin::detail::Variable variable{name, type, tensor.numElements(), {}};
        variable.constant = constant;
        variable.contents = std::move(contents);
        data_->variables.push_back(std::move(variable));
        return tensor;
    }
    template <class T>
    static std::vector<unsigned char> bytes_of(Type type, T const* values, std::size_t count)
    {
        std::size_t const bytes = standin::detail::element_bytes(type);
        std::vector<unsigned char> all(count * bytes);
        for (std::size_t i = 0; i < count; ++i) standin::detail::store_element(type, values[i], all.data() + i * bytes);
        return all;
    }
    DataStream add_stream(std::string const& handle, Type type, std::size_t elements, bool to_device)
    {
        if (std::find(data_->streams.begin(), data_->streams.end(), handle) != data_->streams.end())
            throw stream_connection_error("There are two streams " + handle + " (handles name streams); give each its own");
        data_->streams.push_back(handle);
        return DataStream(handle, type, elements, to_device);
    }
    void require_tile(unsigned tile) const
    {
        if (tile >= data_->tiles)
            throw invalid_tile_mapping("There is no tile " + std::to_string(tile) + " (the target has " +
                                       std::to_string(data_->tiles) + "); name one that it has");
    }
    void require_own(Tensor const& tensor) const
    {
        if (tensor.graph() != data_.get())
            throw graph_connection_error(
                "A tensor is not of this graph (it was made by another, or by none); use one that this graph made");
    }
    static void require_index(FieldRef const& field)
    {
        if (field.field().rank != 2) return;
        std::size_t const size = field.vertex_->list_sizes[field.field_];
        if (size == standin::detail::no_size)
            throw no_size_specified(field.name() + " cannot be set (its list has no size yet); call setFieldSize first");
        if (field.index_ >= size)
            throw graph_connection_error(field.name() + " does not exist (its list has size " + std::to_string(size) +
                                         "); index within it");
    }
    static void require_value(FieldRef const& field, unsigned rank)
    {
        standin::Field const& f = field.field();
        if (f.access != standin::Access::value)
            throw graph_connection_error(field.name() + " takes no value (it is an edge); connect a tensor to it");
        if (f.rank != rank + (field.indexed_ ? 1u : 0u))
            throw graph_connection_error(field.name() + " takes no value of rank " + std::to_string(rank) +
                                         " (it has rank " + std::to_string(f.rank) + "); give one of its rank");
        require_index(field);
    }
    template <class T>
    static void set_value(FieldRef const& field, T const* values, std::size_t count)
    {
        auto bytes = bytes_of(standin::detail::type_named(field.field().type), values, count);
        for (auto& v : field.vertex_->values)
            if (v.field == field.field_ && v.index == field.index_) {
                v.elements = count;
                v.bytes = std::move(bytes);
                return;
            }
        field.vertex_->values.push_back({field.field_, field.index_, count, std::move(bytes)});
    }

    Target target_;
    std::shared_ptr<standin::detail::GraphData> data_;
};

} // namespace poplar
