#pragma once
#include <stdexcept>
#include <string>

/// Part of a stand-in for the Poplar SDK: the exceptions of its host calls. Every type is a `poplar_error`.
namespace poplar {

struct poplar_error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Codelets cannot be loaded: the path is empty.
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
/// A field and the tensor connected to it do not agree, or nothing is connected.
struct graph_connection_error : poplar_error {
    using poplar_error::poplar_error;
};
/// A variable or vertex is on no tile, or on a tile that the target does not have.
struct invalid_tile_mapping : poplar_error {
    using poplar_error::poplar_error;
};
/// Element types differ, or a value does not fit its type.
struct type_error : poplar_error {
    using poplar_error::poplar_error;
};
/// A list field is used before its size is set.
struct no_size_specified : poplar_error {
    using poplar_error::poplar_error;
};
/// A shape or an index that the tensor does not have.
struct tensor_creation_error : poplar_error {
    using poplar_error::poplar_error;
};
/// A program cannot run: its operands overlap or differ in shape, or the program does not exist.
struct control_program_error : poplar_error {
    using poplar_error::poplar_error;
};
/// Two vertices of one compute set use the same element, and at least one writes it.
struct graph_program_compilation_error : poplar_error {
    using poplar_error::poplar_error;
};
/// A tile holds more than its memory.
struct graph_memory_allocation_error : poplar_error {
    using poplar_error::poplar_error;
};
/// A stream does not exist, or nothing is connected to it.
struct stream_connection_error : poplar_error {
    using poplar_error::poplar_error;
};
/// A vertex breaks a rule while it computes.
struct application_runtime_error : poplar_error {
    using poplar_error::poplar_error;
};

} // namespace poplar
