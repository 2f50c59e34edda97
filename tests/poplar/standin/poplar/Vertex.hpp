// A stand-in for the header of the same name in the Poplar SDK, written from public documents and from its use in public
// codelets. With it, codelets compile and execute on a host. It is never installed, and a test that passes here proves nothing
// about an IPU. It cannot show how popc lays out and compresses pointers, what popc refuses, or how much time anything takes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <poplar/HalfFloat.hpp>
#include <poplar/QuarterFloat.hpp>
#include <poplar/TileConstants.hpp>
#include <type_traits>

// Codelets test these macros: `__POPC__` says that this is codelet code. `__IPU__` stays undefined, because it guards assembly.
#ifndef __POPC__
#    define __POPC__ 1
#endif
#if !defined(__clang__) && !defined(__builtin_assume)
#    define __builtin_assume(condition) static_cast<void>(0)
#endif

// popc knows [[poplar::constraint(...)]] and target("supervisor"). Host compilers would warn about each of them.
#if defined(__clang__)
#    pragma clang diagnostic ignored "-Wunknown-attributes"
#    pragma clang diagnostic ignored "-Wignored-attributes"
#elif defined(__GNUC__)
#    pragma GCC diagnostic ignored_attributes "poplar::"
#endif

namespace standin {
/// Sets the pointers and sizes of edges (standin_vertex.hpp), as Poplar's loader does on an IPU.
struct Binding;
} // namespace standin

namespace poplar {

/// How a vertex holds a vector edge: with its size (SPAN; SHORT_SPAN up to 2,047 elements), or as a bare pointer, which may
/// be compressed. Only the kinds with a size have size(), end() and iteration.
enum class VectorLayout { NOT_VECTOR, SPAN, SHORT_SPAN, ONE_PTR, SCALED_PTR32, SCALED_PTR64, SCALED_PTR128, COMPACT_PTR };

/// How a vertex holds a list of vectors: a base, and an offset and a size for each vector.
enum class VectorListLayout {
    NOT_VECTOR,
    ONE_PTR,
    SCALED_PTR32,
    SCALED_PTR64,
    SCALED_PTR128,
    DELTAN,
    DELTANELEMENTS,
    COMPACT_DELTAN
};

/// A piece of tile memory. Inside Input, Output or InOut it is the value of an edge. If its elements are edges, it is a list.
/// Otherwise it is a constant table in the vertex, which Graph::setInitialValue fills. A const vector has const elements.
/// Preconditions: the index is below the size; the memory is aligned to MinAlign bytes. Indexing is not checked here: the
/// engine poisons the memory around an edge instead.
template <class T, VectorLayout L = VectorLayout::SPAN, unsigned MinAlign = alignof(T), bool Interleaved = false>
class Vector {
public:
    using value_type = std::remove_const_t<T>;

    template <class Index>
    T& operator[](Index i)
    {
        return data_[i];
    }
    template <class Index>
    T const& operator[](Index i) const
    {
        return data_[i];
    }
    T& operator*() { return *data_; }
    T const& operator*() const { return *data_; }
    T* data() { return data_; }
    T const* data() const { return data_; }
    T* begin() { return data_; }
    T const* begin() const { return data_; }
    T* end() { return data_ + size(); }
    T const* end() const { return data_ + size(); }
    T const* cbegin() const { return data_; }
    T const* cend() const { return data_ + size(); }
    T& front() { return *data_; }
    T const& front() const { return *data_; }
    T& back() { return data_[size() - 1]; }
    T const& back() const { return data_[size() - 1]; }
    bool empty() const { return size() == 0; }
    /// Number of elements, 32 bits wide as on the tile.
    unsigned size() const
    {
        static_assert(L == VectorLayout::SPAN || L == VectorLayout::SHORT_SPAN,
                      "this layout keeps no size; carry the count in a member");
        return size_;
    }

private:
    friend struct standin::Binding;
    T* data_;
    unsigned size_;
};

/// A list of vectors of one element type, held as one field.
template <class T, VectorListLayout L = VectorListLayout::DELTANELEMENTS, unsigned MinAlign = alignof(T),
          bool Interleaved = false>
class VectorList {
public:
    using value_type = Vector<T, VectorLayout::SPAN, MinAlign, Interleaved>;

    template <class Index>
    value_type& operator[](Index i)
    {
        return vectors_[i];
    }
    template <class Index>
    value_type const& operator[](Index i) const
    {
        return vectors_[i];
    }
    value_type* begin() { return vectors_; }
    value_type const* begin() const { return vectors_; }
    value_type* end() { return vectors_ + size(); }
    value_type const* end() const { return vectors_ + size(); }
    /// Number of vectors, 32 bits wide as on the tile.
    unsigned size() const
    {
        static_assert(L == VectorListLayout::DELTAN || L == VectorListLayout::DELTANELEMENTS ||
                          L == VectorListLayout::COMPACT_DELTAN,
                      "this layout keeps no size; carry the count in a member");
        return size_;
    }

private:
    friend struct standin::Binding;
    value_type* vectors_;
    unsigned size_;
};

/// An edge that a vertex may only read. The primary template has one element; the specialisations are vectors and lists.
template <class T>
class Input {
public:
    operator T const&() const { return *data_; }
    T const& operator*() const { return *data_; }
    T const* operator->() const { return data_; }
    T const* data() const { return data_; }

private:
    friend struct standin::Binding;
    T const* data_;
};

/// An edge of one element that a vertex reads and writes.
template <class T>
class InOut {
public:
    T& operator=(T const& value) { return *data_ = value; } // NOLINT: the element is assigned, not the edge
    template <class U>
    T& operator+=(U const& value)
    {
        return *data_ = static_cast<T>(*data_ + value);
    }
    template <class U>
    T& operator-=(U const& value)
    {
        return *data_ = static_cast<T>(*data_ - value);
    }
    template <class U>
    T& operator*=(U const& value)
    {
        return *data_ = static_cast<T>(*data_ * value);
    }
    template <class U>
    T& operator/=(U const& value)
    {
        return *data_ = static_cast<T>(*data_ / value);
    }
    template <class U>
    T& operator|=(U const& value)
    {
        return *data_ = static_cast<T>(*data_ | value);
    }
    template <class U>
    T& operator&=(U const& value)
    {
        return *data_ = static_cast<T>(*data_ & value);
    }
    operator T&() { return *data_; }
    operator T const&() const { return *data_; }
    T& operator*() { return *data_; }
    T const& operator*() const { return *data_; }
    T* operator->() { return data_; }
    T const* operator->() const { return data_; }
    T* data() { return data_; }
    T const* data() const { return data_; }

private:
    friend struct standin::Binding;
    T* data_;
};

/// An edge of one element that a vertex writes. Its value before the first write is undefined: the engine fills it with
/// poison.
template <class T>
class Output {
public:
    T& operator=(T const& value) { return *data_ = value; } // NOLINT: the element is assigned, not the edge
    operator T&() { return *data_; }
    T& operator*() { return *data_; }
    T* operator->() { return data_; }
    T* data() { return data_; }

private:
    friend struct standin::Binding;
    T* data_;
};

template <class T, VectorLayout L, unsigned A, bool I>
class Input<Vector<T, L, A, I>> : public Vector<T const, L, A, I> {};
template <class T, VectorLayout L, unsigned A, bool I>
class InOut<Vector<T, L, A, I>> : public Vector<T, L, A, I> {};
template <class T, VectorLayout L, unsigned A, bool I>
class Output<Vector<T, L, A, I>> : public Vector<T, L, A, I> {};

template <class T, VectorListLayout L, unsigned A, bool I>
class Input<VectorList<T, L, A, I>> : public VectorList<T const, L, A, I> {};
template <class T, VectorListLayout L, unsigned A, bool I>
class InOut<VectorList<T, L, A, I>> : public VectorList<T, L, A, I> {};
template <class T, VectorListLayout L, unsigned A, bool I>
class Output<VectorList<T, L, A, I>> : public VectorList<T, L, A, I> {};

/// A codelet that one worker executes. Derive from it, declare fields, and define `bool compute()` or `void compute()`.
class Vertex {};

/// A codelet that all workers of the tile execute at once: `bool compute(unsigned worker)`. There is no barrier between
/// them.
class MultiVertex {
public:
    static constexpr unsigned numWorkers() { return CTXT_WORKERS; }
};

/// A codelet of the supervisor context, which has no floating point.
class SupervisorVertex {};

/// SupervisorVertex if the condition is true, otherwise Vertex.
template <bool supervisor>
using SupervisorVertexIf = std::conditional_t<supervisor, SupervisorVertex, Vertex>;

} // namespace poplar
