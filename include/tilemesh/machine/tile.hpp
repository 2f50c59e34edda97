#pragma once
#include <array>
#include <cstdint>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/name.hpp>
#include <tilemesh/machine/spec.hpp>

namespace tilemesh {

/// One line of a tile's SRAM ledger.
struct Region {
    Name name;
    char const* what;        ///< "state", "channel, 8 ends", "broadcast", "code and stacks"
    std::uint32_t bytes;
    bool budgeted;           ///< false: kept, but outside the budget this machine's program claims (see `Tile`)
};

namespace detail {
/// Instantiated only when a program does not fit: its arguments say what to do about it.
template <class Machine, class LargestRegion, std::uint32_t LargestRegionBytes, std::uint32_t BytesOver>
struct SramBudget {
    static_assert(BytesOver == 0, "the program does not fit in a tile's SRAM (SramBudget<Machine, LargestRegion, its bytes, "
                                  "BytesOver> in this message names the region and the bytes over); give it fewer slots");
    static constexpr bool holds = true;
};
template <class X, class = void>
inline constexpr bool is_budgeted = true;
template <class X>
inline constexpr bool is_budgeted<X, std::void_t<decltype(X::budgeted)>> = X::budgeted;

template <class C, class = void>
struct MemoryOf {
    using type = C;
};
template <class C>
struct MemoryOf<C, std::void_t<typename C::memory_of>> {
    using type = typename C::memory_of;
};
template <class T>
struct Tag {
    using type = T;
};
} // namespace detail

/// Layout and SRAM ledger of a program on one tile of a machine, derived from its kernels; nobody writes it by hand.
///
/// What does not fit is a compile-time error that names the largest region and the bytes over. A state with
/// `static constexpr bool budgeted = false;` is listed but not counted: for a published budget that leaves out what the
/// program really needs (the paper's). A dynamic channel counts as its heads; the engine checks it when it is sized.
template <class Machine, class Program, class = Needs<Program>>
class Tile;

template <class Machine, class Program, class... S, class... L, class... P>
class Tile<Machine, Program, detail::Sets<Types<S...>, Types<L...>, Types<P...>>> {
public:
    using States = Types<S...>;
    using Links = Types<L...>;
    using Shareds = Types<P...>;
    static_assert((detail::ReadBeforeSent<Program, L>::value && ...));

    /// Words of state X as one piece of SRAM: a list's head and items, or the struct.
    template <class X>
    static constexpr std::uint32_t words() noexcept
    {
        if constexpr (detail::is_list<X>) {
            static_assert(X::static_capacity != dynamic_capacity,
                          "a state's capacity is part of the layout; give the Buffer a number (Limited for sweeps)");
            return X::words(X::static_capacity);
        } else {
            return sizeof(X) / 4;
        }
    }
    /// Where X begins among a tile's state words, when they are one tensor.
    template <class X>
    static constexpr std::uint32_t offset() noexcept
    {
        static_assert(detail::contains<X, States>, "no kernel of this program keeps this state");
        std::uint32_t at = 0;
        bool found = false;
        ((found = found || std::is_same_v<X, S>, at += found ? 0 : words<S>()), ...);
        return at;
    }
    static constexpr std::uint32_t state_words = (0u + ... + words<S>());

    /// SRAM of channel C on one tile: four ends in, four out.
    template <class C>
    static constexpr std::uint32_t channel_bytes(std::uint32_t capacity = C::static_capacity) noexcept
    {
        return 8 * C::end_bytes(capacity == dynamic_capacity ? 0 : capacity);
    }
    /// The same without what lies in another channel's memory.
    template <class C>
    static constexpr std::uint32_t own_channel_bytes(std::uint32_t capacity = C::static_capacity) noexcept
    {
        using Host = typename detail::MemoryOf<C>::type;
        auto const mine = channel_bytes<C>(capacity);
        if constexpr (std::is_same_v<Host, C>) {
            return mine;
        } else {
            static_assert(detail::contains<Host, Links>, "memory_of names a channel that this program does not use");
            static_assert(std::is_same_v<typename detail::MemoryOf<Host>::type, Host>,
                          "memory_of names a channel that itself lies in another's memory; name that one");
            // What the host and the guests before this one leave over.
            std::uint32_t before = channel_bytes<Host>();
            bool found = false;
            ((found = found || std::is_same_v<L, C>,
              before = !found && std::is_same_v<typename detail::MemoryOf<L>::type, Host> && channel_bytes<L>() > before ? channel_bytes<L>()
                                                                                                                       : before),
             ...);
            return mine > before ? mine - before : 0;
        }
    }

    static constexpr std::uint32_t region_count = sizeof...(S) + sizeof...(L) + sizeof...(P) + 1;
    /// The table for reports, in the order in which kernels name things; code and stacks last.
    static constexpr std::array<Region, region_count> ledger() noexcept
    {
        return {{Region{name_of<L>(), "channel, 8 ends", own_channel_bytes<L>(), true}...,
                 Region{name_of<S>(), "state", 4 * words<S>(), detail::is_budgeted<S>}...,
                 Region{name_of<P>(), "broadcast", static_cast<std::uint32_t>(sizeof(P)), true}...,
                 Region{{"code and stacks", 15}, "reserve", Machine::code_bytes, true}}};
    }
    /// Bytes that count against the SRAM.
    static constexpr std::uint64_t bytes = Machine::code_bytes + (std::uint64_t{0} + ... + own_channel_bytes<L>()) +
                                           (std::uint64_t{0} + ... + sizeof(P)) +
                                           (std::uint64_t{0} + ... + (detail::is_budgeted<S> ? 4 * words<S>() : 0));

private:
    template <class X>
    static constexpr std::uint32_t size_of() noexcept
    {
        if constexpr (detail::is_channel<X>)
            return own_channel_bytes<X>();
        else
            return detail::is_budgeted<X> ? 4 * words<X>() : 0;
    }
    template <class Best>
    static constexpr auto largest_of() noexcept
    {
        return detail::Tag<Best>{};
    }
    template <class Best, class Next, class... Rest>
    static constexpr auto largest_of() noexcept
    {
        if constexpr (size_of<Next>() > size_of<Best>())
            return largest_of<Next, Rest...>();
        else
            return largest_of<Best, Rest...>();
    }
    struct NothingKept {
        std::uint32_t word;
    };
    template <class... X>
    static constexpr auto pick(Types<X...>) noexcept
    {
        if constexpr (sizeof...(X) == 0)
            return detail::Tag<NothingKept>{};
        else
            return largest_of<X...>();
    }
    template <class X>
    static constexpr std::uint32_t bytes_or_zero() noexcept
    {
        if constexpr (std::is_same_v<X, NothingKept>)
            return 0;
        else
            return size_of<X>();
    }
    using Largest = typename decltype(pick(Types<S..., L...>{}))::type;
    static_assert(detail::SramBudget<Machine, Largest, bytes_or_zero<Largest>(),
                                     bytes <= Machine::sram_bytes
                                         ? 0u
                                         : static_cast<std::uint32_t>(bytes - Machine::sram_bytes)>::holds);
};

namespace detail {
template <class Machine>
struct WithRoom : Machine {
    static constexpr std::uint32_t sram_bytes = 0xffffffffu;
};
} // namespace detail

/// Bytes of a tile that a program takes on a machine, asked before the budget is: nothing is refused.
template <class Machine, class Program>
inline constexpr std::uint64_t bytes_needed = Tile<detail::WithRoom<Machine>, Program>::bytes;
/// Does it fit there? Where it does not, `Tile<Machine, Program>` is a compile-time error.
template <class Machine, class Program>
inline constexpr bool fits = bytes_needed<Machine, Program> <= Machine::sram_bytes;

namespace detail {
/// Makes argument A for one call from what an interpreter offers (`source`).
template <class A, class Source>
struct Bind;
template <class X, class Source>
struct Bind<X&, Source> {
    using Plain = std::remove_const_t<X>;
    struct View {
        Plain view;
        TILEMESH_KERNEL operator X&() noexcept { return view; }
    };
    TILEMESH_KERNEL static decltype(auto) make(Source& source) noexcept
    {
        Place const place = source.template state<Plain>();
        if constexpr (is_list<Plain>)
            return View{Plain{place}};
        else
            return static_cast<X&>(*reinterpret_cast<Plain*>(place.items));
    }
};
template <class C, class Source>
struct Bind<In<C>, Source> {
    using R = typename C::Receiver;
    TILEMESH_KERNEL static In<C> make(Source& s) noexcept
    {
        return {{R{s.template in<C>(news[0])}, R{s.template in<C>(news[1])}, R{s.template in<C>(news[2])},
                 R{s.template in<C>(news[3])}}};
    }
};
template <class C, class Source>
struct Bind<Out<C>, Source> {
    using W = typename C::Sender;
    TILEMESH_KERNEL static Out<C> make(Source& s) noexcept
    {
        return {{W{s.template out<C>(news[0])}, W{s.template out<C>(news[1])}, W{s.template out<C>(news[2])},
                 W{s.template out<C>(news[3])}}};
    }
};
template <class P, class Source>
struct Bind<Broadcast<P>, Source> {
    TILEMESH_KERNEL static Broadcast<P> make(Source& s) noexcept { return Broadcast<P>{s.template shared<P>()}; }
};
template <class Source>
struct Bind<Here, Source> {
    TILEMESH_KERNEL static Here make(Source& s) noexcept { return s.here(); }
};
template <class Source>
struct Bind<Worker, Source> {
    TILEMESH_KERNEL static Worker make(Source& s) noexcept { return s.worker(); }
};
template <class Source>
struct Bind<Absent, Source> {
    TILEMESH_KERNEL static Absent make(Source&) noexcept { return {}; }
};
template <class Kernel, class Source, class... A>
TILEMESH_KERNEL Vote call(Source& source, Types<A...>) noexcept
{
    if constexpr (std::is_void_v<typename KernelTraits<Kernel>::Result>) {
        Kernel{}(Bind<A, Source>::make(source)...);
        return Vote::quiet;
    } else {
        return Kernel{}(Bind<A, Source>::make(source)...);
    }
}
} // namespace detail

/// Runs a kernel on the tile that `source` describes. `Source` is all that an interpreter writes:
///   Place state<X>();  Place in<C>(Direction);  Place out<C>(Direction);  P const* shared<P>();  Here here();  Worker worker();
/// where a plain struct's Place has its words in `items`.
template <class Kernel, class Source>
TILEMESH_KERNEL Vote run_kernel(Source& source) noexcept
{
    return detail::call<Kernel>(source, typename KernelTraits<Kernel>::Arguments{});
}

} // namespace tilemesh
