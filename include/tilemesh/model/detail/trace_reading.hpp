#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/operations.hpp>
#include <vector>

// Parts of model/ that users do not need. The namespace is not tilemesh::model::detail, because after `using namespace tilemesh` a
// namespace `model` would clash with every user's function of that name.
namespace tilemesh { inline namespace v0_2 { namespace model_detail {

/// The names of the operations that the kernel of a step counts. Empty for a step without names, in a trace made by hand.
TILEMESH_HOST std::vector<std::string> const& operations_of_step(Trace const& trace, std::size_t step) noexcept;

/// Throws `Error` if the trace names a step or a tile that does not exist, or more operations of a kernel than a kernel can count.
TILEMESH_HOST void check_trace(Trace const& trace, Grid grid);

/// The operations of all steps, each name once, in the order in which the steps name them, and the columns of each step's operations.
struct OperationColumns {
    std::vector<std::string> names;
    std::vector<std::array<std::uint32_t, most_operation_kinds>> of_step;
    TILEMESH_HOST explicit OperationColumns(Trace const& trace);
};

TILEMESH_HOST std::uint64_t all_sent(TileSample const& t) noexcept;

}}} // namespace tilemesh::model_detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/trace_reading_code.hpp>
#endif
