#pragma once
#include <cstdint>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/types.hpp>
#include <tuple>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 {

/// The vote of a tile at the end of compute. Before a step that runs only a part of the tiles (UntilQuiet; after `run_within`, any step), a
/// tile must vote busy if running it again without mail would change a word of it. A vote that only ends a Loop may follow any rule. Sending
/// needs no vote, because mail wakes its receiver.
enum class Vote : std::uint32_t { quiet = 0, busy = 1 };

/// A program is a value whose type names its kernels; its only members are numbers such as the count of a Repeat. One superstep is a pass
/// (a kernel on every tile that must run), an exchange over the channels that the kernel touches, and a barrier.
///
/// The tiles that run: `Superstep` and `Repeat` run every tile. `UntilQuiet` runs the tiles that voted busy in the previous superstep, with
/// any kernel, and the tiles with mail on a channel that this kernel reads. It tests before its first pass, so it costs no superstep if
/// there is nothing to do. Mail stays until a kernel reads it; each message is read once.
template <class Kernel>
struct Superstep {};

/// Runs the kernel on every tile, `times` times: `Repeat<Diffuse>{1000}`.
template <class Kernel>
struct Repeat {
    std::uint32_t times = 1;
};

/// Runs the kernel until all tiles are quiet and none has mail for it, but at most `at_most` times. Messages that this bound leaves under
/// way stay in their channels and go on in the next run. With `at_most` 1, a run moves every message by one hop.
template <class Kernel>
struct UntilQuiet {
    std::uint32_t at_most = 0xffffffffu;
};

/// Runs its steps one after the other: `Sequence program{Superstep<Begin>{}, Repeat<Diffuse>{1000}};`. A step may be a Sequence.
template <class... Steps>
struct Sequence {
    std::tuple<Steps...> steps{};
    constexpr Sequence() = default;
    constexpr Sequence(Steps... step) : steps(step...) {}
};
template <>
struct Sequence<> {
    std::tuple<> steps{};
};

/// A Sequence whose counts are those of one grid, as that of `reduce_on`. A mesh with another grid throws `Error` when it is built.
template <class... Steps>
struct SequenceOn : Sequence<Steps...> {
    Grid grid{};
};

/// Repeats its steps, in order. It makes another round while a tile voted busy in the superstep before, but at most `at_most` rounds. Mail
/// alone makes no round. Like UntilQuiet, it tests before its first round. In
/// `Sequence<Superstep<Begin>, Loop<UntilQuiet<Spread>, Superstep<Judge>>{100}>`, Begin and Judge vote. With `at_most` 1 it is a condition
/// that tiles decide. Cost on a Poplar machine: every superstep of the program gathers votes, and each round has one more compute set.
/// A Loop may also be written with values: `Loop{100, UntilQuiet<Spread>{}, Repeat<Judge>{2}}`. Without the number, rounds have no bound.
template <class... Steps>
struct Loop {
    std::uint32_t at_most = 0xffffffffu;
    std::tuple<Steps...> steps{};
    constexpr Loop() = default;
    constexpr explicit Loop(std::uint32_t rounds) : at_most(rounds) {}
    constexpr Loop(std::uint32_t rounds, Steps... step) : at_most(rounds), steps(step...) {}
    constexpr Loop(Steps... step) : steps(step...) {}
};
template <>
struct Loop<> {};
template <class... Steps>
Loop(int, Steps...) -> Loop<Steps...>;
template <class... Steps>
Loop(std::uint32_t, Steps...) -> Loop<Steps...>;

/// Runs its steps, in order, if a word of a broadcast is not 0. Otherwise votes and mail stay as they are. Example:
/// `If<&Wanted::smoothing, Superstep<Smooth>>`. `Flag` points to a std::uint32_t member of the broadcast `Wanted`. Kernels need not take
/// that broadcast. The host decides, once per run. For a condition that tiles decide, use a `Loop` with `at_most` 1.
template <auto Flag, class... Steps>
struct If {
    std::tuple<Steps...> steps{};
    constexpr If() = default;
    constexpr If(Steps... step) : steps(step...) {}
};
template <auto Flag>
struct If<Flag> {
    std::tuple<> steps{};
};

/// A part that a program has only if `Present` is true: `StepIf<P::sorts, UntilQuiet<Sort<P>>>`.
template <bool Present, class Part>
using StepIf = std::conditional_t<Present, Part, Sequence<>>;

/// Describes a part of a program: a step (one kernel), or a part made of others. Only StepTraits and `walk` take programs apart.
///   is_step      one kernel: `Kernel`, `everywhere` (on every tile, or only on those that must run), `most(step)` (its passes at most)
///   Steps        its steps, in order; `StepCounters`, traces and logs use their numbers
///   Flags        the broadcasts that its conditions read
///   loops        the number of its Loops, itself included
///   has_grid     is it a SequenceOn, or does it contain one?
template <class Part>
struct StepTraits {
    static_assert(!sizeof(Part*), "not a program (its parts are Superstep<K>, Repeat<K>, UntilQuiet<K>, Sequence<...>, Loop<...>, "
                                  "If<&P::flag, ...>); wrap the kernel in one of them");
};

namespace detail {
template <class Step, class K, bool Everywhere>
struct OneKernel {
    static constexpr bool is_step = true, is_loop = false, has_grid = false;
    static constexpr bool everywhere = Everywhere;
    static constexpr std::uint32_t loops = 0;
    using Kernel = K;
    using Steps = machine::Types<Step>;
    using Flags = machine::Types<>;
};
template <class... Parts>
struct SeveralParts {
    static constexpr bool is_step = false, is_loop = false, is_condition = false;
    static constexpr std::uint32_t loops = (0u + ... + StepTraits<Parts>::loops);
    static constexpr bool has_grid = (StepTraits<Parts>::has_grid || ...);
    using Steps = typename Concat<typename StepTraits<Parts>::Steps...>::type;
    using Flags = typename Concat<typename StepTraits<Parts>::Flags...>::type;
};
template <auto Flag>
struct FlagOf {
    static_assert(Flag != Flag, "the flag of an If is a pointer to a std::uint32_t member of a broadcast (a word that the host sets); give it "
                                "If<&Parameters::flag, ...>");
    using Parameters = void;
};
template <class P, std::uint32_t P::*Flag>
struct FlagOf<Flag> {
    using Parameters = P;
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
template <class... Parts>
struct StepTraits<SequenceOn<Parts...>> : detail::SeveralParts<Parts...> {
    static constexpr bool has_grid = true;
};
template <class... Parts>
struct StepTraits<Loop<Parts...>> : detail::SeveralParts<Parts...> {
    static constexpr bool is_loop = true;
    static constexpr std::uint32_t loops = 1 + detail::SeveralParts<Parts...>::loops;
    static_assert(detail::SeveralParts<Parts...>::Steps::count != 0, "a Loop without a step (nobody could end it by a vote); give it one");
};
template <auto Flag, class... Parts>
struct StepTraits<If<Flag, Parts...>> : detail::SeveralParts<Parts...> {
    static constexpr bool is_condition = true;
    using Parameters = typename detail::FlagOf<Flag>::Parameters;
    static constexpr std::uint32_t Parameters::*flag = Flag;
    using Flags = typename detail::Concat<machine::Types<Parameters>, typename detail::SeveralParts<Parts...>::Flags>::type;
};

/// The steps of a program, in order, without the parts around them.
template <class Program>
using StepsOf = typename StepTraits<Program>::Steps;
/// The kernel of a step.
template <class Step>
using KernelOf = typename StepTraits<Step>::Kernel;

/// The place of a Loop: its index among a program's Loops (an outer Loop comes before its inner ones), and the places of its steps.
struct LoopAt {
    std::uint32_t index = 0, first = 0, last = 0;
};

/// Interprets a program, part by part, in the order in which the parts run:
///   interpreter.step(step, i)                a step; i is its place in `StepsOf<Program>`
///   interpreter.loop(loop, LoopAt, body)     a Loop; body() interprets its parts once
///   interpreter.condition(part, body)        an If; its StepTraits have `Parameters` and `flag`
/// `first` and `loop` are the places that the first step and the first Loop of this part have in the whole program.
template <class Program, class Interpreter>
constexpr void walk(Program const& program, Interpreter& interpreter, std::uint32_t first = 0, std::uint32_t loop = 0)
{
    using Traits = StepTraits<Program>;
    if constexpr (Traits::is_step) {
        interpreter.step(program, first);
    } else {
        auto const body = [&] {
            [[maybe_unused]] auto step = first, inner = loop + (Traits::is_loop ? 1u : 0u);
            [[maybe_unused]] auto const one = [&](auto const& part) {
                using Part = std::decay_t<decltype(part)>;
                walk(part, interpreter, step, inner);
                step += StepsOf<Part>::count;
                inner += StepTraits<Part>::loops;
            };
            std::apply([&](auto const&... part) { (one(part), ...); }, program.steps);
        };
        if constexpr (Traits::is_loop)
            interpreter.loop(program, LoopAt{loop, first, first + Traits::Steps::count - 1}, body);
        else if constexpr (Traits::is_condition)
            interpreter.condition(program, body);
        else
            body();
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
    template <class Part, class Body>
    constexpr void loop(Part const&, LoopAt, Body const& body)
    {
        body();
    }
    template <class Part, class Body>
    constexpr void condition(Part const&, Body const& body)
    {
        body();
    }
};
template <std::uint32_t Count>
struct FindLoops {
    LoopAt found[Count + 1] = {};
    template <class Step>
    constexpr void step(Step const&, std::uint32_t) noexcept
    {
    }
    template <class Part, class Body>
    constexpr void loop(Part const&, LoopAt at, Body const& body)
    {
        found[at.index] = at;
        body();
    }
    template <class Part, class Body>
    constexpr void condition(Part const&, Body const& body)
    {
        body();
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
/// The Loops of a program: `loops_of<Program>().found[0]` to `[StepTraits<Program>::loops - 1]`.
template <class Program>
constexpr detail::FindLoops<StepTraits<Program>::loops> loops_of()
{
    detail::FindLoops<StepTraits<Program>::loops> loops;
    walk(Program{}, loops);
    return loops;
}
/// Does a superstep of this step end with a vote on another superstep or on another round of a Loop?
template <class Program>
constexpr bool votes_after(std::uint32_t step) noexcept
{
    bool votes = false;
    for_each_step(Program{}, [&](auto const& s, std::uint32_t i) {
        votes = votes || (i == step && !StepTraits<std::decay_t<decltype(s)>>::everywhere);
    });
    auto const loops = loops_of<Program>();
    for (std::uint32_t l = 0; l < StepTraits<Program>::loops; ++l) votes = votes || loops.found[l].last == step;
    return votes;
}

inline constexpr std::uint32_t no_step = 0xffffffffu;

namespace detail {
template <class Kernel, class... Step>
constexpr std::uint32_t find_step(std::uint32_t nth, machine::Types<Step...>) noexcept
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
struct NoLoop {};
/// The innermost Loop around step `Index` of `part`, from its part `At` on; `around` is the innermost one around `part`.
template <std::uint32_t Index, std::uint32_t At, class Part, class Around>
constexpr auto& loop_at(Part& part, Around& around) noexcept
{
    if constexpr (StepTraits<std::remove_const_t<Part>>::is_step) {
        return around;
    } else {
        using Inner = std::tuple_element_t<At, decltype(part.steps)>;
        constexpr auto n = StepsOf<Inner>::count;
        if constexpr (Index >= n)
            return loop_at<Index - n, At + 1>(part, around);
        else if constexpr (StepTraits<Inner>::is_loop)
            return loop_at<Index, 0>(std::get<At>(part.steps), std::get<At>(part.steps));
        else
            return loop_at<Index, 0>(std::get<At>(part.steps), around);
    }
}
template <std::uint32_t Index, class Program>
constexpr auto& loop_around(Program& program) noexcept
{
    if constexpr (StepTraits<std::remove_const_t<Program>>::is_loop) {
        return loop_at<Index, 0>(program, program);
    } else {
        constexpr NoLoop none;
        using Found = decltype(loop_at<Index, 0>(program, none));
        static_assert(!std::is_same_v<Found, NoLoop const&>, "the program has no Loop around this step (its passes are its own); use get_step");
        return loop_at<Index, 0>(program, none);
    }
}
} // namespace detail

/// The place of the Nth step (from 0) of kernel `Kernel` among a program's steps; `no_step` if the program has no such step.
template <class Program, class Kernel, std::uint32_t Nth = 0>
constexpr std::uint32_t step_of() noexcept
{
    return detail::find_step<Kernel>(Nth, StepsOf<Program>{});
}
/// The Nth step (from 0) of kernel `Kernel` in a program value: `get_step<Diffuse>(heat).times = 1000`.
template <class Kernel, std::uint32_t Nth = 0, class Program>
constexpr auto& get_step(Program& program) noexcept
{
    constexpr auto i = step_of<std::remove_const_t<Program>, Kernel, Nth>();
    static_assert(i != no_step, "the program has no such step (no step, or fewer than asked for, of this kernel); name a kernel that it runs");
    return detail::step_at<i, 0>(program);
}
/// The innermost Loop around the Nth step (from 0) of kernel `Kernel` in a program value: `get_loop<Smooth>(program).at_most = 50`.
template <class Kernel, std::uint32_t Nth = 0, class Program>
constexpr auto& get_loop(Program& program) noexcept
{
    constexpr auto i = step_of<std::remove_const_t<Program>, Kernel, Nth>();
    static_assert(i != no_step, "the program has no such step (no step, or fewer than asked for, of this kernel); name a kernel that it runs");
    return detail::loop_around<i>(program);
}

}} // namespace tilemesh
