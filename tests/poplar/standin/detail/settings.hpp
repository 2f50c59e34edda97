#pragma once
#include <cstddef>
#include <cstdint>

namespace standin {

/// The stand-in's order of things that have no fixed order on the machine.
enum class Order { ascending, descending, permuted };

/// How the stand-in keeps a vertex from the memory of other tiles in a build without AddressSanitizer.
enum class Isolation { none, pages };

/// Settings of the stand-in. It reads `tiles` and `tile_bytes` when a device is requested, `code_bytes` when an Engine is built,
/// and the others each time a program runs.
struct Settings {
    Order workers = Order::ascending;  ///< the six workers of a MultiVertex run one after the other, in this order
    Order vertices = Order::ascending; ///< the order of the vertices of a compute set
    unsigned seed = 1;                 ///< seed of the permutations; they change from set to set, and are equal in each run of a program
    bool threads = false;              ///< true: the six workers of a MultiVertex run at once, each on its own thread
    Isolation isolation = Isolation::none;
    bool check_inputs = false;       ///< an Input edge that changed while its vertex computed is an error
    unsigned tiles = 1472;           ///< tiles of a Mk2 chip
    std::size_t tile_bytes = 638976; ///< 624 KiB, as on a Mk2 chip
    std::size_t code_bytes = 0;      ///< bytes that code, stacks and exchange sequences take on each tile
    std::uint64_t while_limit =
        1'000'000; ///< most passes of one RepeatWhileTrue; one more is an error, and the machine would hang
};

/// The settings of this process.
inline Settings& settings()
{
    static Settings all;
    return all;
}

/// Fills unwritten memory, and Output edges before compute. It is a NaN as a float, and large as a count.
inline constexpr std::uint32_t poison_word = 0x7fa0deadu;

} // namespace standin
