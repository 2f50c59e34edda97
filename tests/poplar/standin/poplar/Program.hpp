#pragma once
#include "DataStream.hpp"
#include "Graph.hpp"
#include "Tensor.hpp"
#include "exceptions.hpp"
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// Part of a stand-in for the Poplar SDK: control programs.
namespace poplar::program {

/// A program, by value: a program that contains a sequence does not change when the sequence gets more steps later.
class Program {
public:
    enum class Kind { sequence, execute, copy, to_device, from_device, repeat, while_true, condition };
    struct Node {
        Kind kind;
        std::string name;
        std::vector<Program> children; ///< repeat: the body; while_true: the condition, the body; condition: both branches
        ComputeSet compute_set{};
        Tensor source{}, destination{}; ///< for while_true and condition, `source` is the predicate
        std::vector<DataStream> stream{};
        unsigned count = 0;
    };

    Program() : Program(Node{Kind::sequence, {}, {}}) {}
    Node const& node() const { return *node_; }

protected:
    explicit Program(Node node) : node_(std::make_shared<Node>(std::move(node))) {}
    /// This program's own node, which may be changed.
    Node& own()
    {
        if (node_.use_count() > 1) node_ = std::make_shared<Node>(*node_);
        return *node_;
    }

private:
    std::shared_ptr<Node> node_;
};

/// Programs one after the other.
class Sequence : public Program {
public:
    Sequence() = default;
    Sequence(std::initializer_list<Program> programs, std::string const& name = {})
        : Program(Node{Kind::sequence, name, programs})
    {}
    void add(Program const& program)
    {
        Program added = program; // before own(): a sequence may be added to itself
        own().children.push_back(std::move(added));
    }
};

/// Executes all vertices of a compute set at once.
class Execute : public Program {
public:
    explicit Execute(ComputeSet const& set, std::string const& name = {}) : Program(Node{Kind::execute, name, {}, set}) {}
};

/// Moves the elements of one tensor to another of equal shape and type, or between a stream and a tensor.
class Copy : public Program {
public:
    Copy(Tensor const& source, Tensor const& destination, bool = false, std::string const& name = {})
        : Program(Node{Kind::copy, name, {}, {}, source, destination})
    {
        if (source.shape() != destination.shape() || source.elementType() != destination.elementType() || !source.valid())
            throw control_program_error("A Copy has a source of " + source.elementType().toString() + " " +
                                        Tensor::shape_text(source.shape()) + " (its destination is " +
                                        destination.elementType().toString() + " " +
                                        Tensor::shape_text(destination.shape()) + "); give both one type and shape");
    }
    Copy(DataStream const& stream, Tensor const& destination, bool = false, std::string const& name = {})
        : Program(Node{Kind::to_device, name, {}, {}, {}, destination, {stream}})
    {
        require(stream, destination, true);
    }
    Copy(Tensor const& source, DataStream const& stream, bool = false, std::string const& name = {})
        : Program(Node{Kind::from_device, name, {}, {}, source, {}, {stream}})
    {
        require(stream, source, false);
    }

private:
    static void require(DataStream const& stream, Tensor const& tensor, bool to_device)
    {
        if (stream.to_device() != to_device)
            throw control_program_error("A Copy runs against stream " + stream.handle() + " (it goes " +
                                        (stream.to_device() ? "to" : "from") +
                                        " the device); use a stream of the other direction");
        if (tensor.elementType() != stream.elementType() || tensor.numElements() > stream.numElements())
            throw control_program_error("A Copy of " + std::to_string(tensor.numElements()) + " elements of " +
                                        tensor.elementType().toString() + " does not fit stream " + stream.handle() +
                                        " (it takes up to " + std::to_string(stream.numElements()) + " of " +
                                        stream.elementType().toString() + "); give the stream the tensor's type and size");
    }
};

/// Runs a program a fixed number of times.
class Repeat : public Program {
public:
    Repeat(unsigned count, Program const& body, std::string const& name = {})
        : Program(Node{Kind::repeat, name, {body}, {}, {}, {}, {}, count})
    {}
};

/// Runs `condition`. While the predicate, a scalar, is true after that, runs `body` and `condition` again.
class RepeatWhileTrue : public Program {
public:
    RepeatWhileTrue(Program const& condition, Tensor const& predicate, Program const& body, std::string const& name = {})
        : Program(Node{Kind::while_true, name, {condition, body}, {}, predicate})
    {
        if (predicate.rank() != 0 || predicate.elementType() != BOOL || !predicate.valid())
            throw control_program_error("A RepeatWhileTrue has a predicate of " + predicate.elementType().toString() + " " +
                                        Tensor::shape_text(predicate.shape()) + " (it wants bool {}); give it a scalar");
    }
};

/// Runs one of two programs: the first if the predicate, a scalar, is true.
class If : public Program {
public:
    If(Tensor const& predicate, Program const& where_true, Program const& where_false, std::string const& name = {})
        : Program(Node{Kind::condition, name, {where_true, where_false}, {}, predicate})
    {
        if (predicate.rank() != 0 || predicate.elementType() != BOOL || !predicate.valid())
            throw control_program_error("An If has a predicate of " + predicate.elementType().toString() + " " +
                                        Tensor::shape_text(predicate.shape()) + " (the stand-in wants bool {}); give it a scalar");
    }
};

} // namespace poplar::program
