#pragma once
#include <cstdint>
#include <istream>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <vector>

// The energy of a run: power x time, as the paper measures it, or events with so many femtojoules each. Supply the energies,
// each with its source; energy_range.hpp has published ones as a range.
namespace tilemesh { inline namespace v0_2 {

/// The joules of a machine that draws `watts` while `cycles` pass on the model's clock. Throws `Error` for a clock of 0 kHz, and for watts
/// that are negative or not a finite number.
TILEMESH_HOST double joules_of_power(CostModel const& model, std::uint64_t cycles, double watts);

/// The events that have an energy: the operations of kernels, by name, and the three below. A kernel of several workers counts the slowest
/// worker's share times the number of workers, because this takes its time; so Composite's pairs are more than those evaluated.
///   sent_byte      a byte of a message or its head over one hop, if the exchange is paid as `live`
///   capacity_byte  a byte that compile-time copies move, live or not, if the exchange is paid as `capacity`
///   tile_cycle     a cycle of a tile, busy or idle: leakage and the clock's energy
inline constexpr char const *sent_byte_event = "sent_byte", *capacity_byte_event = "capacity_byte", *tile_cycle_event = "tile_cycle";

/// The largest energy of an event, in femtojoules: 4 microjoules (1,000 femtojoules are a picojoule). Its product with half of a 64-bit
/// count fits into 64 bits.
inline constexpr std::uint64_t most_femtojoules = 4'000'000'000;

/// The energy of each event. No energy is set at first, and there are no defaults; call set_energy.
struct EnergyModel {
    std::string name;
    std::vector<ModelParameter> events; ///< each event once, in the order in which they were first set
    friend bool operator==(EnergyModel const&, EnergyModel const&) = default;
};

namespace model_detail {
TILEMESH_HOST ModelParameter const* find_energy(EnergyModel const& model, std::string_view event) noexcept;
/// An exact sum of femtojoules, in 128 bits.
struct Femtojoules {
    std::uint64_t high = 0, low = 0;
    TILEMESH_HOST void add(std::uint64_t n) noexcept;
    TILEMESH_HOST void add(std::uint64_t count, std::uint64_t each) noexcept; // each < 2^32
    TILEMESH_HOST double joules() const noexcept;
};
} // namespace model_detail

/// Sets the energy of one event: an operation, by the name with which kernels count it, or one of the three above. Throws `Error` for a
/// name that is not one word of at most 64 printable ASCII characters, for a value above `most_femtojoules`, and for a source that is not
/// one line of text.
TILEMESH_HOST void set_energy(EnergyModel& model, std::string_view event, std::uint64_t femtojoules, std::string source);

/// The number of occurrences of an event in a run, and the energy of all of them.
struct EnergyEvent {
    std::string name;
    std::uint64_t count = 0; ///< exact
    double joules = 0;
};
/// The energy of a run: joules of each kind of event, of each step of the program, and of each tile.
struct Energy {
    std::vector<EnergyEvent> events; ///< operations, in the order in which the steps name them, then the three others
    std::vector<double> joules_of_step, joules_of_tile;
    double joules = 0;
    /// The event of this name; an event with count 0 if there is none.
    TILEMESH_HOST EnergyEvent of(std::string_view event) const;
};

/// Applies an energy model to a run. Events are counted exactly and added up in integers; a sum becomes joules once, at the end. Bytes that
/// compile-time copies move are charged to the tile that sends them. Every tile is charged tile_cycle for all modelled cycles of the run.
///
/// Throws `Error` for an event that occurs and has no energy, for an energy above `most_femtojoules` (possible if it was not set by
/// set_energy), for a trace of another grid, for a trace that model_cost refuses, and for counts that exceed 64 bits. Cost: linear in the
/// trace.
TILEMESH_HOST Energy energy_of(EnergyModel const& energy, CostModel const& model, Trace const& trace, Grid grid);

/// Reads a model from text: `#` comments, `energy NAME`, then one event a line, `name value unit source`, in any order, each at
/// most once. Throws `Error`, one line that names `file_name` and the line, for any other text.
TILEMESH_HOST EnergyModel read_energy_model(std::istream& in, std::string const& file_name);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/energy_code.hpp>
#endif
