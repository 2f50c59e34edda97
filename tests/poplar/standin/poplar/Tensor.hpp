#pragma once
#include "../detail/graph_data.hpp"
#include "Type.hpp"
#include "exceptions.hpp"
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

/// Part of a stand-in for the Poplar SDK: tensors.
namespace poplar {

class Tensor;
Tensor concat(std::vector<Tensor> const& tensors, unsigned dimension = 0);

/// A view of elements of a graph's variables: their shape, and the elements in row-major order. Slicing, reshaping and joining move
/// no data. Cost: one short list of intervals. A slice along dimension 0 of one whole variable is one interval.
class Tensor {
public:
    Tensor() = default;

    Type elementType() const { return type_; }
    std::vector<std::size_t> shape() const { return shape_; }
    std::size_t dim(unsigned i) const { return shape_.at(i); }
    unsigned rank() const { return static_cast<unsigned>(shape_.size()); }
    std::size_t numElements() const { return product(shape_, 0, shape_.size()); }
    bool valid() const { return graph_ != nullptr; }

    /// Elements [begin, end) along a dimension. Throws if the tensor does not have them.
    Tensor slice(std::size_t begin, std::size_t end, unsigned dimension = 0) const
    {
        if (dimension >= rank() || begin > end || end > shape_[dimension])
            fail("has no slice [" + std::to_string(begin) + ", " + std::to_string(end) + ") along dimension " +
                     std::to_string(dimension),
                 "slice within the shape");
        std::size_t const outer = product(shape_, 0, dimension), inner = product(shape_, dimension + 1, shape_.size());
        Tensor result(graph_, type_, shape_);
        result.shape_[dimension] = end - begin;
        Cursor cursor(parts_);
        for (std::size_t i = 0; i < outer; ++i) {
            cursor.skip(begin * inner);
            cursor.take((end - begin) * inner, result.parts_);
            cursor.skip((shape_[dimension] - end) * inner);
        }
        return result;
    }

    /// Element `i` along dimension 0, as a tensor without that dimension.
    Tensor operator[](std::size_t i) const
    {
        if (rank() == 0 || i >= shape_[0])
            fail("has no element " + std::to_string(i) + " along dimension 0", "index within the shape");
        Tensor result = slice(i, i + 1);
        result.shape_.erase(result.shape_.begin());
        return result;
    }

    /// The same elements in another shape. The shape must have the same number of elements.
    Tensor reshape(std::vector<std::size_t> const& shape) const
    {
        if (product(shape, 0, shape.size()) != numElements())
            fail("cannot be reshaped to " + shape_text(shape), "give a shape of as many elements");
        Tensor result = *this;
        result.shape_ = shape;
        return result;
    }
    Tensor flatten() const { return reshape({numElements()}); }

    /// `times` copies of this tensor along a dimension.
    Tensor broadcast(unsigned times, unsigned dimension) const
    {
        if (dimension >= rank())
            fail("has no dimension " + std::to_string(dimension) + " to be broadcast along", "reshape it first");
        if (times == 0) return slice(0, 0, dimension);
        return concat(std::vector<Tensor>(times, *this), dimension);
    }

    // For the rest of the stand-in.
    using GraphData = standin::detail::GraphData;
    using Interval = standin::detail::Interval;
    Tensor(GraphData const* graph, Type type, std::vector<std::size_t> shape)
        : graph_(graph), type_(type), shape_(std::move(shape))
    {}
    Tensor(GraphData const* graph, Type type, std::vector<std::size_t> shape, unsigned variable)
        : Tensor(graph, type, std::move(shape))
    {
        standin::detail::append(parts_, {variable, 0, numElements()});
    }
    GraphData const* graph() const { return graph_; }
    std::vector<Interval> const& parts() const { return parts_; }

    static std::string shape_text(std::vector<std::size_t> const& shape)
    {
        std::string text = "{";
        for (std::size_t i = 0; i < shape.size(); ++i) text += (i ? ", " : "") + std::to_string(shape[i]);
        return text + "}";
    }

private:
    friend Tensor concat(std::vector<Tensor> const& tensors, unsigned dimension);

    /// Walks a list of intervals once, front to back.
    class Cursor {
    public:
        explicit Cursor(std::vector<Interval> const& parts) : at_(parts.data()), end_(parts.data() + parts.size()) {}
        void skip(std::size_t count)
        {
            while (count != 0 && at_ != end_) count -= advance(count);
        }
        void take(std::size_t count, std::vector<Interval>& into)
        {
            while (count != 0 && at_ != end_) {
                std::size_t const first = at_->begin + used_;
                unsigned const variable = at_->variable;
                std::size_t const n = advance(count);
                standin::detail::append(into, {variable, first, first + n});
                count -= n;
            }
        }

    private:
        std::size_t advance(std::size_t count)
        {
            std::size_t const left = at_->end - at_->begin - used_, n = count < left ? count : left;
            used_ += n;
            if (n == left) {
                ++at_;
                used_ = 0;
            }
            return n;
        }
        Interval const* at_;
        Interval const* end_;
        std::size_t used_ = 0;
    };

    static std::size_t product(std::vector<std::size_t> const& shape, std::size_t first, std::size_t last)
    {
        std::size_t n = 1;
        for (std::size_t i = first; i < last; ++i) n *= shape[i];
        return n;
    }
    [[noreturn]] void fail(std::string const& what, char const* remedy) const
    {
        throw tensor_creation_error("A tensor " + what + " (its shape is " + shape_text(shape_) + "); " + remedy);
    }

    GraphData const* graph_ = nullptr;
    Type type_;
    std::vector<std::size_t> shape_{0};
    std::vector<Interval> parts_;
};

/// Tensors joined along a dimension. All other dimensions and the types must be equal.
inline Tensor concat(std::vector<Tensor> const& tensors, unsigned dimension)
{
    if (tensors.empty()) throw tensor_creation_error("Nothing to join (the list of tensors is empty); give one or more");
    Tensor const& first = tensors.front();
    if (dimension >= first.rank())
        first.fail("has no dimension " + std::to_string(dimension) + " to be joined along", "reshape it first");
    Tensor result(first.graph_, first.type_, first.shape_);
    result.shape_[dimension] = 0;
    std::vector<Tensor::Cursor> cursors;
    cursors.reserve(tensors.size());
    for (Tensor const& t : tensors) {
        auto other = t.shape_;
        if (t.rank() == first.rank()) other[dimension] = first.shape_[dimension];
        if (other != first.shape_ || t.type_ != first.type_ || t.graph_ != first.graph_)
            t.fail("of " + t.type_.toString() + " cannot be joined to one of " + first.type_.toString() + " and shape " +
                       Tensor::shape_text(first.shape_) + " along dimension " + std::to_string(dimension),
                   "join tensors of one graph and type that differ in this dimension alone");
        result.shape_[dimension] += t.shape_[dimension];
        cursors.emplace_back(t.parts_);
    }
    std::size_t const outer = Tensor::product(first.shape_, 0, dimension);
    for (std::size_t i = 0; i < outer; ++i)
        for (std::size_t k = 0; k < tensors.size(); ++k) {
            auto const& shape = tensors[k].shape_;
            cursors[k].take(Tensor::product(shape, dimension, shape.size()), result.parts_);
        }
    return result;
}

inline Tensor concat(Tensor const& a, Tensor const& b, unsigned dimension = 0)
{
    return concat(std::vector<Tensor>{a, b}, dimension);
}

} // namespace poplar
