#pragma once
#include <cstddef>
#include <cstdint>

namespace standin {

/// An order in which things are taken that the machine takes in no particular order.
enum class Order { ascending, descending, permuted };

/// How a vertex is kept from the memory of other tiles where AddressSanitizer does not do it.
enum class Isolation { none, pages };

/// How the stand-in behaves. `tiles` and `tile_bytes` are read when a device is asked for, `code_bytes` when an Engine is built,
/// the others each time a program runs.
struct Settings {
    Order workers = Order::ascending;  ///< of the six workers of a MultiVertex, one after the other
    Order vertices = Order::ascending; ///< of the vertices of a compute set
    unsigned seed = 1;                 ///< of the permutations; a new one each time, the same in each run of a program
    bool threads = false;              ///< the six workers of a MultiVertex at once, on threads of their own
    Isolation isolation = Isolation::none;
    bool check_inputs = false;       ///< an Input edge that changed while its vertex computed is an error
    unsigned tiles = 1472;           ///< of a Mk2 chip (hardware.md, section 4)
    std::size_t tile_bytes = 638976; ///< 624 KiB (the same)
    std::size_t code_bytes = 0;      ///< taken from each tile by code, stacks and exchange sequences
    std::uint64_t while_limit =
        1'000'000; ///< passes of one RepeatWhileTrue; one more is an error, where the machine would hang
};

/// The settings of this process.
inline Settings& settings()
{
    static Settings all;
    return all;
}

/// Fills memory that nobody has written and Output edges before compute: a NaN as float, large as a count.
inline constexpr std::uint32_t poison_word = 0x7fa0deadu;

} // namespace standin
