#pragma once
#include <array>
#include <cstdint>
#include <istream>
#include <ostream>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/model/cost_model.hpp>

// Sets of a cost model's numbers: one for the library's kernels on Mk2, and a text format, so that a set can be changed and applied to a
// trace again.
namespace tilemesh { inline namespace v0_2 {

namespace model_detail {
inline constexpr std::array<std::string_view, 2> exchange_cost_names = {"capacity", "live"};
} // namespace model_detail

/// The name under which a model prices a byte that the host sends to the chip.
inline constexpr std::string_view host_byte = "host_byte";

/// Sets one number of a model with its source: the field and its entry in `parameters`. Names, in this order: clock, exchange_cost (0:
/// capacity, 1: live), the operations that the model prices, run, exchange, exchange_byte, sync, vote. Throws `Error` for any other name
/// (set_price prices another operation), a value out of range, and a source that is not one line of text.
TILEMESH_HOST void set_parameter(CostModel& model, std::string_view name, std::uint64_t value, std::string source);

/// Sets an operation's price and the price's source. The operation may have any name by which kernels count (machine/operations.hpp). A
/// model lists operations in the order in which they were first priced. Throws `Error` as set_parameter does, for a name that is not one
/// word of at most 64 printable ASCII characters, and for the name of another parameter.
TILEMESH_HOST void set_price(CostModel& model, std::string_view operation, std::uint64_t millicycles, std::string source);

/// The work of the kernels of splat/ for one operation, counted in their code; mk2() converts it to cycles. Instructions are counted by
/// hand, to about 10 %, in the code that Clang 16 generates with -O2 for RV32IMF. Like a worker, that is a scalar machine of 32-bit words,
/// on which a record is copied word by word. The arithmetic of a projection is exact: tests/model/cost_parameters.cpp counts it.
struct KernelWork {
    /// One projection with an opacity box: additions and multiplications (a fused operation counts two); divisions and square roots;
    /// compares, selects, conversions and integer operations.
    static constexpr std::uint32_t projection_flops = 289, projection_roots = 12, projection_others = 122;
    /// The depth key of a projection (splat/depth_key.hpp). It is not in the price of a projection: all published prices and figures are those
    /// of a depth in one float.
    static constexpr std::uint32_t depth_key_flops = 59, depth_key_others = 39;
    /// `reach`, which finds the tiles that the record touches: it compares five rectangles.
    static constexpr std::uint32_t reach = 146;
    /// One slot in `find`: load, compare, set, add. The loop is unrolled 16 times.
    static constexpr std::uint32_t slot = 4;
    /// A 64-byte record leaves its tile, passes others and settles; each hop counts two. This is the mean for 4 hops; it is 141 for one hop
    /// and 33 for many hops.
    static constexpr std::uint32_t leaves = 175, passes = 66, settles = 107, hops = 4;
    static constexpr std::uint32_t routed = (leaves + (hops - 1) * passes + settles) / (2 * hops);
    /// A 60-byte copy arrives like a record that settles, plus 15 instructions of bloom's loop. Before, it was sent: `reach`, tree, record,
    /// mark.
    static constexpr std::uint32_t copy_arrives = settles + 15, copy_leaves = reach + 112;
    static constexpr std::uint32_t copied = (copy_arrives + copy_leaves) / 2;
    /// A level of heap sort: compare the larger of two keys with a third key, and move 3 words.
    static constexpr std::uint32_t comparison = 30;
    /// Fast blending in cells, in tenths of a flop (splat/blending_cells.hpp; a fused multiplication is two): a quarter of a column's exponents
    /// and two powers, 10; the recurrence, 1; weight and cuts, 4; three colours, 6. bench/ uses the same number for its roofline. In forward
    /// mode, tracking has blocks of its own (splat/pose/).
    static constexpr std::uint32_t tenth_flops_a_pair = 210, tenth_flops_a_tracked_pair = 184;
    /// RGBX8: 81 instructions to clamp, round and pack, 4 stores to begin, 4 loads, 4 for the loop.
    static constexpr std::uint32_t pixel = 93;
    /// Tracking (splat/pose/). Flops and selects of a pair in forward mode, besides those of blending; flops that its depth adds; flops,
    /// roots and others of a splat's six motions. All are exact, as those of a projection.
    static constexpr std::uint32_t moving_flops = 117, moving_others = 7, moving_depth_flops = 18;
    static constexpr std::uint32_t motion_flops = 392, motion_roots = 7, motion_others = 104;
    /// A row of six unknowns. Adding: 68 flops, 2 roots and 26 others, which are exact, and a quarter of 28 roundings for a cell of four
    /// rows. Making it from derivatives: 26 flops, and 31 compares, selects, loads and stores. From gradients: 46 flops, a root, 51 others.
    static constexpr std::uint32_t adding_flops = 68, adding_roots = 2, adding_others = 26, rounding_flops = 14, rounding_others = 28;
    static constexpr std::uint32_t row_flops = 26, row_others = 31, gradient_flops = 46, gradient_roots = 1, gradient_others = 51;
    /// A pixel and its target: 11 flops, 14 others.
    static constexpr std::uint32_t mean_flops = 11, mean_others = 14;
};

namespace model_detail {
/// The tile cycles of one worker's instruction, in thousandths: six workers take turns. A worker that runs alone waits for its turn.
inline constexpr std::uint64_t one_worker = 6000, six_workers = 1000;
/// The flops of naive scalar C++ in 100 issue slots: 0.68 per tile cycle with six workers, where each cycle is one slot.
inline constexpr std::uint64_t flops_in_100_slots = 68;
/// The issue slots of a division or square root: 10 slots for two of them (poplibs).
inline constexpr std::uint64_t slots_a_root = 5;

constexpr std::uint64_t projection_slots() noexcept
{
    return (100 * KernelWork::projection_flops + flops_in_100_slots / 2) / flops_in_100_slots +
           slots_a_root * KernelWork::projection_roots + KernelWork::projection_others + KernelWork::reach;
}
/// 1,000 (milli) * flops / 10 * 100 slots / 68, rounded to the nearest integer.
constexpr std::uint64_t millicycles_of(std::uint64_t tenth_flops) noexcept
{
    return (tenth_flops * (six_workers / 10) * 100 + flops_in_100_slots / 2) / flops_in_100_slots;
}
constexpr std::uint64_t pair_millicycles() noexcept
{
    return millicycles_of(KernelWork::tenth_flops_a_pair);
}
/// Issue slots of so many flops, roots and others, to the nearest.
constexpr std::uint64_t slots_of(std::uint64_t flops, std::uint64_t roots, std::uint64_t others) noexcept
{
    return (100 * flops + flops_in_100_slots / 2) / flops_in_100_slots + slots_a_root * roots + others;
}

/// Bytes a microsecond that the host sends to the chip: half of PCIe Gen4's 64 GB/s both ways.
inline constexpr std::uint64_t host_link_bytes_a_us = 32'000;

/// A superstep's two syncs and its fixed exchange share 300 cycles (jit-dynamic-lookup); a sync takes at most half of them.
inline constexpr std::uint64_t exchange_with_two_syncs = 300, most_a_sync = exchange_with_two_syncs / 2;
/// The cost to enter and leave a vertex: 11 cycles of the supervisor, and 9 (poplibs).
inline constexpr std::uint64_t vertex_cycles = 11 + 9;
inline constexpr std::uint64_t bytes_a_cycle = 4;
/// Votes of 40 x 36 tiles: first the rows, then their results. Each takes a superstep with one word per tile, which one worker reads in 4
/// instructions per word. Then the run's log takes 25.
constexpr std::uint64_t vote_cycles(std::uint64_t columns, std::uint64_t rows) noexcept
{
    std::uint64_t const words = columns + rows;
    return 2 * (exchange_with_two_syncs + vertex_cycles) + words * 4 / bytes_a_cycle + (words * 4 + 25) * one_worker / 1000;
}
} // namespace model_detail

/// The library's kernels on Graphcore's Mk2. All numbers are from documents and counted code; nothing is fitted. A source begins with
/// "document", "arithmetic" (computed from documents and our code) or "guess" (no document has the number).
///
/// All kernels except composite run on one worker, which issues in every sixth cycle; composite runs on six. The model ignores dual issue,
/// vectors of two floats, and the test of a loop that runs until quiet.
TILEMESH_HOST CostModel mk2();

/// The milliseconds in which the host link carries so many bytes to the chip. The price of a byte is that of the operation `host_byte`
/// (set_price changes it); a model without it has a link that takes no time.
TILEMESH_HOST double host_link_milliseconds(CostModel const& model, std::uint64_t bytes);

/// Writes a model as text: `#` comments, `model NAME`, then one parameter a line, `name value unit source`; a network has lines of its own
/// (model/network_lines.hpp). read_cost_model reads it back as the same model. Throws `Error` if the text could not hold the model: a parameter has
/// no unit or source, or a value or unit other than the model's own (set_parameter keeps them equal).
TILEMESH_HOST void write_cost_model(std::ostream& out, CostModel const& model);

/// Reads the text of write_cost_model: all parameters, and a network or none, in any order, each once; `#` begins a comment line. A line in
/// millicycles under any other name is an operation's price; model_cost refuses a program whose operation has no price. Throws `Error`, one line that
/// names `file_name` and the line, for any other text.
TILEMESH_HOST CostModel read_cost_model(std::istream& in, std::string const& file_name);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/cost_parameters_code.hpp>
#endif
