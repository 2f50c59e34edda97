#pragma once
#include <cstdint>
#include <tuple>

namespace tilemesh {

/// What a tile says at the end of compute: busy while running it again without mail would change a word of it. Sending
/// needs no vote: mail wakes its receiver.
enum class Vote : std::uint32_t { quiet = 0, busy = 1 };

/// A program is a value whose type names its kernels; only knobs are members. One superstep is a kernel on every tile that
/// runs, an exchange over the channels it touches, and a barrier.
///
/// Who runs. `Superstep` and `Repeat` run every tile. `UntilQuiet` runs the tiles that voted busy in the superstep before,
/// whatever its kernel was, and those with mail on a channel that this kernel reads; it tests before its first pass, so that
/// nothing to do costs no superstep. Mail outlives a step until a kernel reads it; each message is read once.
template <class Kernel>
struct Superstep {};

/// The kernel on every tile, Times times.
template <std::uint32_t Times, class Kernel>
struct Repeat {};

/// The kernel until all tiles are quiet and none has mail for it, but at most `at_most` times: with a bound, what is under
/// way stays in its channels and goes on in the next run. The paper moves one hop a frame.
template <class Kernel>
struct UntilQuiet {
    std::uint32_t at_most = 0xffffffffu;
};

/// One step after the other; nests.
template <class... Steps>
struct Sequence {
    std::tuple<Steps...> steps;
};

} // namespace tilemesh
