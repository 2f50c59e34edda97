#pragma once
#include <array>
#include <cstdint>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/name.hpp>
#include <tilemesh/machine/spec.hpp>

namespace tilemesh { inline namespace v0_2 {

namespace machine {
/// One line of a tile's SRAM ledger.
struct Region {
    Name name;
    char const* what;        ///< "state", "channel, 8 ends", "broadcast", "code and stacks"
    std::uint32_t bytes;
    bool budgeted;           ///< false: listed, but not counted in the budget (see `SramLedger`)
};
} // namespace machine

/// The sizes of a program without sizes: the types of all its lists name their capacities.
struct NoSizes {};
/// The setup of a program without sizes.
struct NoSetup {
    static constexpr NoSizes sizes{};
};

namespace detail {
template <class X, class = void>
inline constexpr bool has_slots = false;
template <class X>
inline constexpr bool has_slots<X, std::void_t<decltype(X::slots)>> = true;

template <class X, class = void>
inline constexpr bool is_budgeted = true;
template <class X>
inline constexpr bool is_budgeted<X, std::void_t<decltype(X::budgeted)>> = X::budgeted;
template <class X, class = void>
inline constexpr bool has_budget_flag = false;
template <class X>
inline constexpr bool has_budget_flag<X, std::void_t<decltype(X::budgeted_if)>> = true;

template <class C, class = void>
struct MemoryNamedBy {
    using type = C;
};
template <class C>
struct MemoryNamedBy<C, std::void_t<typename C::memory_of>> {
    using type = typename C::memory_of;
};
template <class C, class = void>
inline constexpr bool has_memory_flag = false;
template <class C>
inline constexpr bool has_memory_flag<C, std::void_t<decltype(C::memory_shared)>> = true;
template <class Sizes, class = void>
inline constexpr bool is_setup_value = false;
template <class Sizes>
inline constexpr bool is_setup_value<Sizes, std::void_t<decltype(std::declval<Sizes const&>().sizes)>> = true;
/// The value of the member that a region names, of the sizes or of a setup's sizes. It does not compile if the region names a member of
/// another type of sizes.
template <class Member, class Sizes>
constexpr auto named_size([[maybe_unused]] Sizes const& sizes, [[maybe_unused]] Member member) noexcept
{
    if constexpr (std::is_invocable_v<Member, Sizes const&>) {
        return sizes.*member;
    } else if constexpr (is_setup_value<Sizes>) {
        return named_size(sizes.sizes, member);
    } else {
        static_assert(std::is_invocable_v<Member, Sizes const&>,
                      "a region of this program names a member of sizes that were not given; name the setup that has them: Tile<Machine, "
                      "Program, Setup>, mesh_sizes<Program, Machine, Setup>()");
        return 0u;
    }
}
/// What a ledger says of a channel.
template <class C>
constexpr char const* channel_text() noexcept
{
    constexpr char const* texts[9] = {"",
                                      "",
                                      "channel, 2 ends",
                                      "channel, 3 ends",
                                      "channel, 4 ends",
                                      "channel, 5 ends",
                                      "channel, 6 ends",
                                      "channel, 7 ends",
                                      "channel, 8 ends"};
    return texts[ends_in<C> + ends_out<C>];
}
/// A number of bytes in 32 bits, for a table's column. 2^32 - 1 also stands for every larger number.
constexpr std::uint32_t column_bytes(std::uint64_t bytes) noexcept
{
    return bytes < 0xffffffffu ? static_cast<std::uint32_t>(bytes) : 0xffffffffu;
}

template <class X, class Sizes, class = void>
inline constexpr bool says_item_bytes = false;
template <class X, class Sizes>
inline constexpr bool says_item_bytes<X, Sizes, std::void_t<decltype(X::item_bytes(std::declval<Sizes const&>()))>> = true;
template <class X, class Sizes, class = void>
inline constexpr bool says_present = false;
template <class X, class Sizes>
inline constexpr bool says_present<X, Sizes, std::void_t<decltype(X::is_present(std::declval<Sizes const&>()))>> = true;

/// Do the bytes of state X count against the SRAM with these sizes?
template <class X, class Sizes>
constexpr bool counts_against_sram([[maybe_unused]] Sizes const& sizes) noexcept
{
    if constexpr (has_budget_flag<X>)
        return named_size(sizes, X::budgeted_if);
    else
        return is_budgeted<X>;
}
} // namespace detail

/// The bytes that an item of X, a list, or a message of X, a channel, takes on the machine: `wire_bytes` of its type, or a function of the
/// setup that X has as `static constexpr std::uint32_t item_bytes(Setup const&)`. So a host whose lists hold references has the ledger of
/// the machine, and one type of list serves setups with records of any size.
template <class X, class Sizes>
constexpr std::uint32_t item_bytes_of([[maybe_unused]] Sizes const& sizes) noexcept
{
    if constexpr (detail::says_item_bytes<X, Sizes>)
        return X::item_bytes(sizes);
    else
        return wire_bytes<typename X::value_type>;
}
/// Does a setup have region X? Yes, or what X says with `static constexpr bool is_present(Setup const&)`.
template <class X, class Sizes>
constexpr bool is_present([[maybe_unused]] Sizes const& sizes) noexcept
{
    if constexpr (detail::says_present<X, Sizes>)
        return X::is_present(sizes);
    else
        return true;
}
/// The sizes of a setup type: its member `sizes`, or the whole value that the layer of a program makes of the type.
template <class Setup, class = void>
inline constexpr auto sizes_of = Setup::sizes;

/// The channel in whose memory channel C may lie: its `memory_of`, or C itself.
template <class C>
using MemoryOf = typename detail::MemoryNamedBy<C>::type;

/// Does channel C lie in the memory of its `memory_of` with these sizes?
template <class C, class Sizes>
constexpr bool shares_memory([[maybe_unused]] Sizes const& sizes) noexcept
{
    if constexpr (std::is_same_v<MemoryOf<C>, C>)
        return false;
    else if constexpr (detail::has_memory_flag<C>)
        return detail::named_size(sizes, C::memory_shared);
    else
        return true;
}

/// The slots of list or channel X with these sizes: the capacity of its type, or the member that X names with `static constexpr auto slots
/// = &Sizes::member;`. A channel with neither gets its slots by `limit`: `dynamic_capacity`.
template <class X, class Sizes>
constexpr std::uint32_t capacity_of([[maybe_unused]] Sizes const& sizes) noexcept
{
    if constexpr (X::static_capacity != dynamic_capacity)
        return X::static_capacity;
    else if constexpr (detail::has_slots<X>)
        return detail::named_size(sizes, X::slots);
    else
        return dynamic_capacity;
}

/// The number of slots that X, a list or a channel, needs so that its program makes progress. X gives it with `static constexpr
/// std::uint32_t least_slots = 1;`. Without that member it is 0.
template <class X, class = void>
inline constexpr std::uint32_t least_slots_of = 0;
template <class X>
inline constexpr std::uint32_t least_slots_of<X, std::void_t<decltype(X::least_slots)>> = X::least_slots;
/// Does X have at least these slots under `sizes`?
template <class X, class Sizes>
constexpr bool has_least_slots([[maybe_unused]] Sizes const& sizes) noexcept
{
    if constexpr (least_slots_of<X> == 0)
        return true;
    else
        return capacity_of<X>(sizes) >= least_slots_of<X>;
}

/// The SRAM ledger of a program on one tile, derived from the program's kernels. Machine and sizes are values, so the same functions serve
/// compile-time constants and sizes that are known only at run time.
///
/// A state with `static constexpr bool budgeted = false;` is listed but not counted. This serves a published budget, such as the paper's,
/// that leaves out lists that the program needs. With `static constexpr auto budgeted_if = &Sizes::member;`, a flag of the sizes decides.
template <class Program, class = machine::Needs<Program>>
class SramLedger;

template <class Program, class... S, class... L, class... P>
class SramLedger<Program, RegionTypes<machine::Types<S...>, machine::Types<L...>, machine::Types<P...>>> {
public:
    using States = machine::Types<S...>;
    using Links = machine::Types<L...>;
    using Shareds = machine::Types<P...>;
    static_assert((detail::ReadBeforeSent<Program, L>::value && ...));

    /// The words of state X as one piece of SRAM: a list's head and items, or the struct.
    template <class X, class Sizes>
    static constexpr std::uint64_t words([[maybe_unused]] Sizes const& sizes) noexcept
    {
        if constexpr (is_list<X>) {
            static_assert(X::static_capacity != dynamic_capacity || detail::has_slots<X>,
                          "a state's capacity is part of the layout; give the Buffer a number, or name its slots (static constexpr auto slots "
                          "= &Sizes::member)");
            return X::words(0) + std::uint64_t{capacity_of<X>(sizes)} * item_bytes_of<X>(sizes) / 4;
        } else {
            return sizeof(X) / 4;
        }
    }
    /// The SRAM of channel C on one tile: of all its ends, in and out. A channel without slots yet counts only its heads.
    template <class C, class Sizes>
    static constexpr std::uint64_t channel_bytes(Sizes const& sizes) noexcept
    {
        auto const slots = capacity_of<C>(sizes);
        return (ends_in<C> + ends_out<C>) *
               (C::end_bytes(0) + (slots == dynamic_capacity ? 0u : std::uint64_t{slots} * item_bytes_of<C>(sizes)));
    }
    /// The SRAM that channel C takes in addition to the channels whose memory it shares. A channel with its own memory takes all of it.
    template <class C, class Sizes>
    static constexpr std::uint64_t own_channel_bytes(Sizes const& sizes) noexcept
    {
        using Host = MemoryOf<C>;
        auto const mine = channel_bytes<C>(sizes);
        if constexpr (std::is_same_v<Host, C>) {
            return mine;
        } else {
            static_assert(machine::contains<Host, Links>, "memory_of names a channel that this program does not use");
            static_assert(std::is_same_v<MemoryOf<Host>, Host>,
                          "memory_of names a channel that itself lies in another's memory; name that one");
            static_assert(C::sends_to == Host::sends_to && C::receives_from == Host::receives_from,
                          "memory_of names a channel with other sides or another edge (the ends of the two share memory, side by side); give "
                          "both the same");
            if (!shares_memory<C>(sizes) || !is_present<Host>(sizes)) return mine;
            // The bytes beyond the host channel and the guests before this one.
            std::uint64_t before = channel_bytes<Host>(sizes);
            bool found = false;
            ((found = found || std::is_same_v<L, C>,
              before = !found && std::is_same_v<MemoryOf<L>, Host> && shares_memory<L>(sizes) && channel_bytes<L>(sizes) > before
                           ? channel_bytes<L>(sizes)
                           : before),
             ...);
            return mine > before ? mine - before : 0;
        }
    }

    static constexpr std::uint32_t region_count = sizeof...(S) + sizeof...(L) + sizeof...(P) + 1;
    /// The table for reports, in the order in which kernels name the regions. Code and stacks are last. A region that the setup does not have
    /// has no kind (`what` is null).
    template <class Sizes>
    static constexpr std::array<machine::Region, region_count> lines(MachineSize const& machine, Sizes const& sizes) noexcept
    {
        return {{line<L>(detail::channel_text<L>(), own_channel_bytes<L>(sizes), true, sizes)...,
                 line<S>("state", 4 * words<S>(sizes), detail::counts_against_sram<S>(sizes), sizes)...,
                 machine::Region{name_of<P>(), "broadcast", broadcast_bytes<P>(sizes), true}...,
                 machine::Region{{"code and stacks", 15}, "reserve", machine.code_bytes, true}}};
    }
    /// The bytes of SRAM that X, a state or a channel, takes.
    template <class X, class Sizes>
    static constexpr std::uint64_t counted_bytes(Sizes const& sizes) noexcept
    {
        if (!is_present<X>(sizes)) return 0;
        if constexpr (is_channel<X>)
            return own_channel_bytes<X>(sizes);
        else
            return detail::counts_against_sram<X>(sizes) ? 4 * words<X>(sizes) : 0;
    }
    /// The bytes that count against the SRAM.
    template <class Sizes>
    static constexpr std::uint64_t bytes(MachineSize const& machine, [[maybe_unused]] Sizes const& sizes) noexcept
    {
        return machine.code_bytes + (std::uint64_t{0} + ... + counted_bytes<L>(sizes)) + (std::uint64_t{0} + ... + broadcast_bytes<P>(sizes)) +
               (std::uint64_t{0} + ... + counted_bytes<S>(sizes));
    }

private:
    template <class X, class Sizes>
    static constexpr std::uint32_t broadcast_bytes([[maybe_unused]] Sizes const& sizes) noexcept
    {
        if constexpr (detail::says_item_bytes<X, Sizes>)
            return X::item_bytes(sizes);
        else
            return sizeof(X);
    }
    template <class X, class Sizes>
    static constexpr machine::Region line(char const* what, std::uint64_t bytes, bool budgeted, Sizes const& sizes) noexcept
    {
        if (is_present<X>(sizes)) return {name_of<X>(), what, detail::column_bytes(bytes), budgeted};
        return {name_of<X>(), nullptr, 0, false};
    }
};

namespace detail {
/// Instantiated only if a program does not fit. Its template arguments appear in the compiler's error and say what to do.
template <class Machine, class LargestRegion, std::uint32_t LargestRegionBytes, std::uint32_t BytesOver>
struct SramBudget {
    static_assert(BytesOver == 0, "the program does not fit in a tile's SRAM (SramBudget<Machine, LargestRegion, its bytes, "
                                  "BytesOver> in this message names the region and the bytes over); give it fewer slots");
    static constexpr bool holds = true;
};

/// The layout of a program under a setup with constant sizes. The program need not fit.
template <class Machine, class Program, class Setup>
class Layout : public SramLedger<Program> {
    using Base = SramLedger<Program>;

public:
    using typename Base::Links;
    using typename Base::States;
    static constexpr MachineSize machine = size_of_machine<Machine>();

    template <class X>
    static constexpr std::uint32_t words() noexcept
    {
        return static_cast<std::uint32_t>(Base::template words<X>(sizes_of<Setup>));
    }
    template <class C>
    static constexpr std::uint32_t channel_bytes() noexcept
    {
        return column_bytes(Base::template channel_bytes<C>(sizes_of<Setup>));
    }
    template <class C>
    static constexpr std::uint32_t own_channel_bytes() noexcept
    {
        return column_bytes(Base::template own_channel_bytes<C>(sizes_of<Setup>));
    }
    /// The word at which X begins if all states of a tile are one tensor.
    template <class X>
    static constexpr std::uint32_t offset() noexcept
    {
        static_assert(machine::contains<X, States>, "no kernel of this program keeps this state");
        return offset_in<X>(States{});
    }
    static constexpr auto ledger() noexcept { return Base::lines(machine, sizes_of<Setup>); }
    /// The bytes that count against the SRAM.
    static constexpr std::uint64_t bytes = Base::bytes(machine, sizes_of<Setup>);

private:
    template <class X, class... S>
    static constexpr std::uint32_t offset_in(machine::Types<S...>) noexcept
    {
        std::uint32_t at = 0;
        bool found = false;
        ((found = found || std::is_same_v<X, S>, at += found ? 0 : words<S>()), ...);
        return at;
    }
    template <class... S>
    static constexpr std::uint32_t all_words(machine::Types<S...>) noexcept
    {
        return (0u + ... + words<S>());
    }

public:
    static constexpr std::uint32_t state_words = all_words(States{});
};

/// The state or channel that takes the most SRAM, as a type.
template <class Layout>
class LargestRegion {
    struct NothingKept {};
    template <class X>
    static constexpr std::uint32_t size_of() noexcept
    {
        return column_bytes(Layout::template counted_bytes<X>(Layout::setup_sizes()));
    }
    template <class Best>
    static constexpr auto largest_of() noexcept
    {
        return machine::Tag<Best>{};
    }
    template <class Best, class Next, class... Rest>
    static constexpr auto largest_of() noexcept
    {
        if constexpr (size_of<Next>() > size_of<Best>())
            return largest_of<Next, Rest...>();
        else
            return largest_of<Best, Rest...>();
    }
    template <class... S, class... L>
    static constexpr auto pick(machine::Types<S...>, machine::Types<L...>) noexcept
    {
        if constexpr (sizeof...(S) + sizeof...(L) == 0)
            return machine::Tag<NothingKept>{};
        else
            return largest_of<S..., L...>();
    }

public:
    using type = typename decltype(pick(typename Layout::States{}, typename Layout::Links{}))::type;
    static constexpr std::uint32_t bytes() noexcept
    {
        if constexpr (std::is_same_v<type, NothingKept>)
            return 0;
        else
            return size_of<type>();
    }
};
} // namespace detail

/// The layout and the SRAM ledger of a program on one tile of a machine, with the sizes of a setup (`Setup::sizes`, a constant).
///
/// A program that does not fit is a compile-time error, which names the largest region and the bytes over. For sizes that are known only at
/// run time, `mesh_sizes` throws Error with the same sentence (engine/mesh_sizes.hpp).
template <class Machine, class Program, class Setup = NoSetup>
class Tile : public detail::Layout<Machine, Program, Setup> {
    using Base = detail::Layout<Machine, Program, Setup>;
    struct Sized : Base {
        static constexpr auto setup_sizes() noexcept { return sizes_of<Setup>; }
    };
    using Largest = detail::LargestRegion<Sized>;
    static_assert(detail::SramBudget<Machine, typename Largest::type, Largest::bytes(),
                                     Base::bytes <= Machine::sram_bytes
                                         ? 0u
                                         : detail::column_bytes(Base::bytes - Machine::sram_bytes)>::holds);
};

/// The bytes of SRAM that a program needs on a tile of a machine. The program need not fit.
template <class Machine, class Program, class Setup = NoSetup>
inline constexpr std::uint64_t bytes_needed = detail::Layout<Machine, Program, Setup>::bytes;
/// Does a program fit on a tile of a machine? If not, `Tile<Machine, Program, Setup>` does not compile.
template <class Machine, class Program, class Setup = NoSetup>
inline constexpr bool fits = bytes_needed<Machine, Program, Setup> <= Machine::sram_bytes;

}} // namespace tilemesh
