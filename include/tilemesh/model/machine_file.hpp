#pragma once
#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/network.hpp>
#include <vector>

// Machines as files: each number with its source, as examples/machines/mk2.txt.
namespace tilemesh { inline namespace v0_2 {

/// A number of a machine, with where it is from.
struct MachineNumber {
    std::string name;
    std::optional<std::uint64_t> value; ///< nothing: nobody knows it
    std::uint64_t per;                  ///< of a rate: `value` bytes in so many cycles; otherwise 1
    std::string unit;
    std::string source;                 ///< kind_of_source tells its kind; of an unknown number, what was looked for
    friend bool operator==(MachineNumber const&, MachineNumber const&) = default;

    PriceKind kind() const noexcept { return kind_of_source(source); }
};

/// A machine as a value. Its numbers, in the order of a file:
///   tiles, columns, rows   tiles; a program that asks for no grid gets `columns` x `rows` of them
///   sram, code             bytes of a tile, and those of them that code and stacks take
///   workers, clock         of a tile; kHz
///   instruction            millicycles that an instruction of the counted kernels takes if all workers run
///   run, barrier, vote     cycles: to enter and leave a kernel; of a sync; of a vote
///   exchange_cost          capacity or live (ExchangeCost)
///   exchange_start         cycles of an exchange without its bytes
///   exchange               bytes a cycle that a tile receives
///   host_link              bytes a microsecond from the host
/// and the lines of a network (model/network_lines.hpp), if its exchange is not compiled.
struct MachineFile {
    std::string name;
    std::vector<MachineNumber> numbers;
    std::optional<Network> network{};
    friend bool operator==(MachineFile const&, MachineFile const&) = default;

    /// Throws `Error` for a name that no machine has.
    TILEMESH_HOST MachineNumber const& number(std::string_view of) const;
    /// The value of a number that a run needs. Throws `Error` if it is unknown.
    TILEMESH_HOST std::uint64_t need(std::string_view of) const;
    /// The names of the numbers that are unknown, in order.
    TILEMESH_HOST std::vector<std::string> unknown() const;
};

/// Changes a number of a machine. The text of a value is that of a file: "unknown", "4", "147/10" for a rate, "capacity". Throws `Error` for
/// a name that no machine has, a value that a file would not hold, and a source that is not one line.
TILEMESH_HOST void set_number(MachineFile& machine, std::string_view name, std::string_view value, std::string source);

/// Reads a machine: `#` comments, `machine NAME`, then every number, one a line: `name value unit source`, in any order. A value may be
/// `unknown`. Throws `Error`, one line that names `file_name`, for any other text, and for a grid of more tiles than the machine has.
TILEMESH_HOST MachineFile read_machine_file(std::istream& in, std::string const& file_name);
/// The text of a machine. read_machine_file reads it back as the same machine. Throws `Error` if a file cannot hold it.
TILEMESH_HOST std::string machine_file_text(MachineFile const& machine);

/// The machine for engines and ledgers. Its name points into `machine`, which must outlive it. Throws `Error` if tiles, sram, workers or
/// clock are unknown or exceed 32 bits. An unknown `code` counts 0 bytes.
TILEMESH_HOST MachineSize size_of(MachineFile const& machine);
/// `columns` x `rows`; nothing if one of them is unknown.
TILEMESH_HOST std::optional<Grid> grid_of(MachineFile const& machine);

/// The prices of a machine. Those of operations are the counted instructions of mk2(), times `instruction`; an operation of a single worker
/// also times workers. All others are the file's. A number that is unknown costs nothing, so that a time is one "at least"; the model's name
/// says which are left out. Throws `Error` if the clock is unknown, or a price out of range.
TILEMESH_HOST CostModel cost_model_of(MachineFile const& machine);

/// One sentence: how many numbers are of each kind, and which are guessed or unknown.
TILEMESH_HOST std::string machine_text(MachineFile const& machine);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/machine_file_code.hpp>
#endif
