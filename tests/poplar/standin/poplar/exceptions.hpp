#pragma once
#include <stdexcept>
#include <string>

/// Part of a stand-in for the Poplar SDK: what its host calls throw. Every type is a `poplar_error`.
namespace poplar {

struct poplar_error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Codelets could not be loaded: an empty path.
struct graph_object_load_error : poplar_error {
    using poplar_error::poplar_error;
};
/// No codelet of that name is linked, or none was added to the graph.
struct unknown_vertex_type : poplar_error {
    using poplar_error::poplar_error;
};
/// The codelet has no field of that name.
struct unknown_field : poplar_error {
    using poplar_error::poplar_error;
};
/// A field and what is connected to it do not agree, or nothing is connected.
struct graph_connection_error : poplar_error {
    using poplar_error::poplar_error;
};
/// A variable or vertex is on no tile, or on one that the target lacks.
struct invalid_tile_mapping : poplar_error {
    using poplar_error::poplar_error;
};
/// Element types differ, or a value does not fit its type.
struct type_error : poplar_error {
    using poplar_error::poplar_error;
};
/// A list field was indexed before its size was set.
struct no_size_specified : poplar_error {
    using poplar_error::poplar_error;
};
/// A shape or an index that the tensor does not have.
struct tensor_creation_error : poplar_error {
    using poplar_error::poplar_error;
};
/// A program that cannot run: operands that overlap or differ in shape, a program that does not exist.
struct control_program_error : poplar_error {
    using poplar_error::poplar_error;
};
/// Two vertices of one compute set touch the same element and one writes it.
struct graph_program_compilation_error : poplar_error {
    using poplar_error::poplar_error;
};
/// A tile holds more than its memory.
struct graph_memory_allocation_error : poplar_error {
    using poplar_error::poplar_error;
};
/// A stream that does not exist, or that nothing was connected to.
struct stream_connection_error : poplar_error {
    using poplar_error::poplar_error;
};
/// A vertex broke a rule while it computed.
struct application_runtime_error : poplar_error {
    using poplar_error::poplar_error;
};

} // namespace poplar
