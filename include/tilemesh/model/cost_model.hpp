#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/model/chips.hpp>
#include <tilemesh/model/network.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// The bytes for which an exchange is paid.
enum class ExchangeCost : std::uint32_t {
    capacity,   ///< every slot of every channel on which the superstep sends, live or not: Poplar's compile-time copies
    live        ///< the bytes that were sent
};

/// How a number of a model is known, from the best kind to the weakest.
enum class PriceKind : std::uint8_t {
    documented, ///< a document of the machine has it
    measured,   ///< others measured it
    counted,    ///< arithmetic from such numbers and from instructions that were counted in our code
    fitted,     ///< it was chosen so that the model agrees with times
    guessed     ///< none of these, or it is not said
};
inline constexpr std::array<std::string_view, 5> price_kind_names = {"documented", "measured by others", "counted", "fitted", "guessed"};
/// The kind of a number with this source, by the source's first word: "document", "measured", "arithmetic" or "counted", "fitted". It is
/// `guessed` for any other word, and if "guess" occurs anywhere: a number is known as well as its weakest part.
TILEMESH_HOST PriceKind kind_of_source(std::string_view source) noexcept;

/// A number that a model needs, with where it is from.
struct ModelParameter {
    std::string name;
    std::uint64_t value;
    std::string unit;
    std::string source; ///< a document, or "fitted to ..."
    PriceKind kind = kind_of_source(source);
    friend bool operator==(ModelParameter const&, ModelParameter const&) = default;
};

/// The price of an operation: its name, as kernels count it (machine/operations.hpp), and its price in thousandths of a tile's cycle.
struct OperationPrice {
    std::string operation;
    std::uint64_t millicycles;
    friend bool operator==(OperationPrice const&, OperationPrice const&) = default;
};

/// The largest numbers of a model, so that sums are exact in 64 bits. Eight kinds of 2^32 - 1 operations at 100,000 cycles each are 3.4e18
/// millicycles, four ends of 2^32 - 1 bytes are 1.7e18, and 64 bits hold 1.8e19. 1e12 cycles take 17 minutes at 1 GHz.
inline constexpr std::uint64_t most_millicycles = 100'000'000, most_cycles = 1'000'000'000'000, most_clock_khz = 1'000'000'000;

/// The prices of a machine, in cycles. All numbers are integers, so modelled cycles are exact and equal on every host.
///
/// A superstep costs the slowest tile's compute, the exchange, a sync, and the vote if there is one:
///   compute   run + sum over operations of count * price / 1,000, rounded up; of the slowest tile. An operation that occurs must have a
///             price; for an operation that costs nothing, the price is 0
///   exchange  exchange + bytes that the busiest tile receives * exchange_byte / 1,000, rounded up; 0 if the superstep has no channel,
///             or (`live`) if nothing was sent. If bytes cross a border between chips, at least exchange + the border's cycles (Chips). With
///             a network: exchange + the time of the superstep's transfers on it (NetworkTime::drained; model/exchange.hpp)
///   sync      sync
///   vote      vote, in each pass of an UntilQuiet (also of that in a Reduce), and in each pass of the last step of a Loop
struct CostModel {
    std::string name;
    std::uint64_t clock_khz = 1'325'000;
    ExchangeCost exchange_cost = ExchangeCost::capacity;
    std::vector<OperationPrice> prices;                       ///< each operation once; set_price (cost_parameters.hpp)
    std::uint64_t run_cycles = 0;                             ///< to enter and leave a vertex
    std::uint64_t exchange_cycles = 0, sync_cycles = 0, vote_cycles = 0;
    std::uint64_t exchange_millicycles_a_byte = 0;
    Chips chips = {};                                         ///< the grid is one chip, or several; not part of a model's file
    std::optional<Network> network = {};                      ///< of a machine whose exchange is not compiled
    std::vector<ModelParameter> parameters;                        ///< where the numbers are from, for reports
    friend bool operator==(CostModel const&, CostModel const&) = default;
};

/// The modelled cycles of a superstep.
struct SuperstepCost {
    std::uint32_t step;
    std::uint64_t compute = 0, exchange = 0, sync = 0, vote = 0;
    std::uint32_t slowest = 0; ///< the tile
    std::uint64_t crossing = 0;       ///< of `exchange`: the cycles by which borders between chips prolong it
    std::uint64_t crossing_bytes = 0; ///< over the busiest border between chips, in one direction
    NetworkResource bound = {};       ///< of the exchange: its busiest resource; none: its fixed cycles are all
    std::uint64_t total() const noexcept { return compute + exchange + sync + vote; }
};

/// The modelled cycles of a run.
struct RunCost {
    std::vector<SuperstepCost> supersteps;
    std::vector<std::vector<std::uint64_t>> busy; ///< for each step of the program and each tile: the cycles that the tile computes
    std::uint64_t cycles = 0;
};

namespace model_detail {
constexpr std::uint64_t per_thousand(std::uint64_t count, std::uint64_t millicycles) noexcept
{
    return (count * millicycles + 999) / 1000;
}
/// Refuses numbers with which a superstep's sums could exceed 64 bits.
TILEMESH_HOST void expect_sums_fit(CostModel const& m);
TILEMESH_HOST OperationPrice const* find_price(CostModel const& m, std::string_view operation) noexcept;

/// A model's prices for the steps of a trace. It looks up each name once.
class StepPrices {
public:
    TILEMESH_HOST StepPrices(CostModel const& model, Trace const& trace);
    /// The cycles that a tile computes in this superstep. Throws `Error` for an operation that occurs and has no price.
    TILEMESH_HOST std::uint64_t compute_cycles(std::size_t superstep, OperationCounts const& o) const;

private:
    static constexpr std::uint64_t none = std::numeric_limits<std::uint64_t>::max();
    [[noreturn]] TILEMESH_HOST void refuse(std::size_t superstep, std::uint32_t kind) const;

    CostModel const& model_;
    Trace const& trace_;
    std::vector<std::array<std::uint64_t, most_operation_kinds>> millicycles_; ///< prices, by step
};

/// Prices exchanges on a model's network. Exchanges of whole channels are alike, so that each capacity is looked at once.
class NetworkPrices {
public:
    TILEMESH_HOST NetworkPrices(CostModel const& model, Grid grid);
    TILEMESH_HOST NetworkTime of(SuperstepSample const& superstep);

private:
    CostModel const& model_;
    Grid grid_;
    Network network_; ///< the model's; of a mesh of tiles alone, the part with the grid: no route leaves it
    std::vector<NetworkNode> nodes_;
    std::map<std::array<std::uint32_t, 4>, NetworkTime> of_capacity_; ///< by the bytes towards each side
};
} // namespace model_detail

/// The price of an operation, in millicycles. Throws `Error` if the model has no operation of this name.
TILEMESH_HOST std::uint64_t price_of(CostModel const& model, std::string_view operation);

/// Applies a model to a trace. The same trace can be used again with any model. Throws `Error` if a number of the model is above its limit,
/// for an operation that occurs and has no price, and if the run's cycles exceed 64 bits. Cost: linear in the trace.
TILEMESH_HOST RunCost model_cost(CostModel const& m, Trace const& trace, Grid grid);

TILEMESH_HOST double milliseconds(CostModel const& m, std::uint64_t cycles) noexcept;

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/cost_model_code.hpp>
#endif
