#pragma once
#include <cstdint>
#include <tilemesh/machine/types.hpp>
#include <tuple>
#include <type_traits>

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

/// The kernel on every tile, `times` times: `Repeat<Diffuse>{1000}`.
template <class Kernel>
struct Repeat {
    std::uint32_t times = 1;
};

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

/// What a part of a program is: a step (one kernel) or made of other parts. This and `walk` are all that takes programs apart.
///   is_step      one kernel: `Kernel`, `everywhere` (on every tile, or only on those that must run), `most(step)` (its passes at most)
///   Steps        the steps in it, in order: what `StepCounters`, traces and logs are numbered by
template <class Part>
struct StepTraits {
    static_assert(!sizeof(Part*), "not a program (its parts are Superstep<K>, Repeat<K>, UntilQuiet<K>, Sequence<...>); wrap "
                                  "the kernel in one of them");
};

namespace detail {
template <class Step, class K, bool Everywhere>
struct OneKernel {
    static constexpr bool is_step = true;
    static constexpr bool everywhere = Everywhere;
    using Kernel = K;
    using Steps = Types<Step>;
};
template <class... Parts>
struct SeveralParts {
    static constexpr bool is_step = false;
    using Steps = typename Concat<typename StepTraits<Parts>::Steps...>::type;
};
} // namespace detail

template <class K>
struct StepTraits<Superstep<K>> : detail::OneKernel<Superstep<K>, K, true> {
    static constexpr std::uint32_t most(Superstep<K> const&) noexcept { return 1; }
};
template <class K>
struct StepTraits<Repeat<K>> : detail::OneKernel<Repeat<K>, K, true> {
    static constexpr std::uint32_t most(Repeat<K> const& step) noexcept { return step.times; }
};
template <class K>
struct StepTraits<UntilQuiet<K>> : detail::OneKernel<UntilQuiet<K>, K, false> {
    static constexpr std::uint32_t most(UntilQuiet<K> const& step) noexcept { return step.at_most; }
};
template <class... Parts>
struct StepTraits<Sequence<Parts...>> : detail::SeveralParts<Parts...> {};

/// The steps of a program in order, Sequences taken apart.
template <class Program>
using StepsOf = typename StepTraits<Program>::Steps;
/// The kernel of a step.
template <class Step>
using KernelOf = typename StepTraits<Step>::Kernel;

/// Interprets a program: calls `interpreter.step(step, i)` for each step in the order in which they run; i is its place in
/// `StepsOf<Program>`, `first` the place of the first.
template <class Program, class Interpreter>
constexpr void walk(Program const& program, Interpreter& interpreter, std::uint32_t first = 0)
{
    if constexpr (StepTraits<Program>::is_step) {
        interpreter.step(program, first);
    } else {
        [[maybe_unused]] auto const one = [&](auto const& part) {
            walk(part, interpreter, first);
            first += StepsOf<std::decay_t<decltype(part)>>::count;
        };
        std::apply([&](auto const&... part) { (one(part), ...); }, program.steps);
    }
}

namespace detail {
template <class F>
struct EachOnce {
    F const& f;
    template <class Step>
    constexpr void step(Step const& step, std::uint32_t i)
    {
        f(step, i);
    }
};
} // namespace detail

/// Calls f(step, i) once for each step of a program.
template <class Program, class F>
constexpr void for_each_step(Program const& program, F const& f)
{
    detail::EachOnce<F> each{f};
    walk(program, each);
}

inline constexpr std::uint32_t no_step = 0xffffffffu;

namespace detail {
template <class Kernel, class... Step>
constexpr std::uint32_t find_step(std::uint32_t nth, Types<Step...>) noexcept
{
    std::uint32_t i = 0, seen = 0, found = no_step;
    ((found = std::is_same_v<Kernel, KernelOf<Step>> && seen++ == nth ? i : found, ++i), ...);
    return found;
}
template <std::uint32_t Index, std::uint32_t At, class Part>
constexpr auto& step_at(Part& part) noexcept
{
    if constexpr (StepTraits<std::remove_const_t<Part>>::is_step) {
        return part;
    } else {
        constexpr auto n = StepsOf<std::tuple_element_t<At, decltype(part.steps)>>::count;
        if constexpr (Index < n)
            return step_at<Index, 0>(std::get<At>(part.steps));
        else
            return step_at<Index - n, At + 1>(part);
    }
}
} // namespace detail

/// The place of kernel K among the steps of a program, of its Nth step where it has several; `no_step` for one that is not there.
template <class Program, class Kernel, std::uint32_t Nth = 0>
constexpr std::uint32_t step_of() noexcept
{
    return detail::find_step<Kernel>(Nth, StepsOf<Program>{});
}
/// That step: `get_step<Diffuse>(heat).times = 1000`.
template <class Kernel, std::uint32_t Nth = 0, class Program>
constexpr auto& get_step(Program& program) noexcept
{
    constexpr auto i = step_of<std::remove_const_t<Program>, Kernel, Nth>();
    static_assert(i != no_step, "the program has no such step (no step, or fewer than asked for, of this kernel); name a kernel that it runs");
    return detail::step_at<i, 0>(program);
}

} // namespace tilemesh
