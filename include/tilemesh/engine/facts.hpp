#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/machine/either.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tuple>
#include <type_traits>

/// What host code must know of a program, as tables: states and channels have their numbers in `Needs<Program>`. An engine reads the tables
/// in functions that are compiled once; only what runs a kernel has types.
namespace tilemesh { inline namespace v0_2 { namespace engine {

/// Mixes the items of a list whose items stand for wholes (`has_whole_words`) into a digest, and the number of their words. `shareds`: the
/// tuple of the program's broadcasts.
using MixWhole = std::uint64_t (*)(std::uint64_t h, machine::Place const& list, void const* shareds) noexcept;

struct StateFacts {
    machine::Name name;
    std::uint32_t words;         ///< of a struct; 0: it is a list
    std::uint32_t item_words[2]; ///< of a list: of an item in the narrow and in the wide form
    std::uint32_t hot_offset;    ///< words: of a list's head, or of a small struct, in the tile's hot words (TileStore)
    bool list, small;            ///< small: a struct that lies among the hot words
    MixWhole mix;                ///< null: digests take the words of its items
};
struct LinkFacts {
    machine::Name name;
    Edge edge;
    Sides sends_to;
    std::uint32_t item_words;
    std::uint32_t ends;   ///< of a tile, incoming and outgoing
    std::uint32_t memory; ///< the number of the channel that its memory_of names; its own if it names none
    MixWhole mix;         ///< as in StateFacts
};
/// A parameter of a kernel, as far as it is a state or the ends of a channel.
struct ArgumentFacts {
    enum class Kind : std::uint8_t { other, state, list, in, out };
    Kind kind;
    bool changes;         ///< may the kernel write the state?
    std::uint32_t number; ///< of the state or channel
};
/// A channel of a kernel, in the order of `KernelTraits::Links`.
struct LinkUse {
    std::uint32_t link;
    bool reads, writes;
};
struct KernelFacts {
    machine::Name name;
    bool multi_worker;
    Edge edge;              ///< of the channels that it sends on; `reflect` if they differ
    std::span<ArgumentFacts const> arguments;
    std::span<LinkUse const> links;
};

struct StepFacts {
    KernelFacts const* kernel;
    bool everywhere; ///< Superstep or Repeat
    bool votes;      ///< do tiles vote on another superstep or round?
};
struct ProgramFacts {
    std::span<StepFacts const> steps;
    std::span<LoopAt const> loops;
};

// What an engine asks of a kernel's channels. `has_mail(link)`: does a channel carry mail that no kernel has read?
template <class HasMail>
bool mail_to_read(KernelFacts const& kernel, HasMail const& has_mail) noexcept
{
    for (auto const& use : kernel.links)
        if (use.reads && has_mail(use.link)) return true;
    return false;
}
template <class HasMail>
bool sends_over_unread(KernelFacts const& kernel, HasMail const& has_mail) noexcept
{
    for (auto const& use : kernel.links)
        if (use.writes && !use.reads && has_mail(use.link)) return true;
    return false;
}
template <class HasMail>
bool sent_anything(KernelFacts const& kernel, HasMail const& has_mail) noexcept
{
    for (auto const& use : kernel.links)
        if (use.writes && has_mail(use.link)) return true;
    return false;
}
inline constexpr char const* over_unread = "a kernel sends on a channel with unread mail (a bound cut the step that reads it); raise the bound, or "
                                           "let the sending kernel read the channel";

namespace detail {
template <class X>
inline constexpr bool lies_hot = !is_list<X> && sizeof(X) <= 64;
/// The number of hot words of X (TileStore): two for the head of a list, all words of a small struct, none for a large struct. In a guarded
/// store, it includes one guard word for each head or small struct.
template <class X, bool Guarded>
inline constexpr std::uint32_t hot_words = is_list<X> ? 2 + (Guarded ? 1 : 0) : lies_hot<X> ? sizeof(X) / 4 + (Guarded ? 1 : 0) : 0;

/// The first broadcast that is a B.
template <class B, class All>
B const& broadcast_like(All const&, machine::Types<>) noexcept
{
    static_assert(!sizeof(B*), "items whose WholeBy is no broadcast of this program (a digest of their wholes needs it); let a kernel take it");
}
template <class B, class First, class... P, class All>
B const& broadcast_like(All const& all, machine::Types<First, P...>) noexcept
{
    if constexpr (std::is_base_of_v<B, First>)
        return std::get<First>(all);
    else
        return broadcast_like<B>(all, machine::Types<P...>{});
}
template <class T, class... P>
std::uint64_t mix_wholes(std::uint64_t h, machine::Place const& list, void const* shareds) noexcept
{
    auto const& by = broadcast_like<typename T::WholeBy>(*static_cast<std::tuple<P...> const*>(shareds), machine::Types<P...>{});
    for (std::uint32_t i = 0; i < list.head[0]; ++i) {
        auto const whole = reinterpret_cast<T const*>(list.items)[i].whole(by);
        std::uint32_t words[sizeof whole / 4];
        __builtin_memcpy(words, &whole, sizeof whole);
        h = mix_words_on(h, words, sizeof whole / 4);
    }
    return mix(h, std::size_t{list.head[0]} * (sizeof(typename T::Whole) / 4));
}
template <class T, class... P>
constexpr MixWhole mix_of(machine::Types<P...>) noexcept
{
    if constexpr (has_whole_words<T>)
        return mix_wholes<T, P...>;
    else
        return nullptr;
}

template <class X, class Shareds>
constexpr StateFacts facts_of_state(std::uint32_t hot_offset) noexcept
{
    if constexpr (is_list<X>) {
        using T = typename X::value_type;
        return {name_of<X>(), 0, {machine::words_in_form<T>(false), machine::words_in_form<T>(true)}, hot_offset, true, false, mix_of<T>(Shareds{})};
    } else {
        return {name_of<X>(), sizeof(X) / 4, {}, hot_offset, false, lies_hot<X>, nullptr};
    }
}
template <std::uint32_t N>
struct StateTable {
    StateFacts at[N + 1];
    std::uint32_t hot_words;
};
template <bool Guarded, class Shareds, class... X>
constexpr StateTable<sizeof...(X)> state_table(machine::Types<X...>) noexcept
{
    [[maybe_unused]] std::uint32_t at = 0;
    [[maybe_unused]] auto const next = [&](std::uint32_t words) { return (at += words) - words; };
    return {{facts_of_state<X, Shareds>(next(hot_words<X, Guarded>))..., StateFacts{}}, (0u + ... + hot_words<X, Guarded>)};
}
template <class C, class Shareds, class Links>
constexpr LinkFacts facts_of_link() noexcept
{
    static_assert(machine::contains<MemoryOf<C>, Links>, "memory_of names a channel that this program does not use");
    return {name_of<C>(), C::edge, C::sends_to, C::Receiver::item_words, ends_in<C> + ends_out<C>,
            machine::index_in<MemoryOf<C>>(Links{}), mix_of<typename C::value_type>(Shareds{})};
}
template <std::uint32_t N>
struct LinkTable {
    LinkFacts at[N + 1];
};
template <class Shareds, class... C>
constexpr LinkTable<sizeof...(C)> link_table(machine::Types<C...> all) noexcept
{
    return {{facts_of_link<C, Shareds, decltype(all)>()..., LinkFacts{}}};
}

template <class A, class Needs>
struct ArgumentOf {
    static constexpr ArgumentFacts facts{ArgumentFacts::Kind::other, false, 0};
};
template <class X, class Needs>
struct ArgumentOf<X&, Needs> {
    static constexpr ArgumentFacts facts{is_list<std::remove_const_t<X>> ? ArgumentFacts::Kind::list : ArgumentFacts::Kind::state,
                                         !std::is_const_v<X>, machine::index_in<std::remove_const_t<X>>(typename Needs::States{})};
};
template <class C, class Needs>
struct ArgumentOf<In<C>, Needs> {
    static constexpr ArgumentFacts facts{ArgumentFacts::Kind::in, false, machine::index_in<C>(typename Needs::Links{})};
};
template <class C, class Needs>
struct ArgumentOf<Out<C>, Needs> {
    static constexpr ArgumentFacts facts{ArgumentFacts::Kind::out, false, machine::index_in<C>(typename Needs::Links{})};
};
template <std::uint32_t Arguments, std::uint32_t Links>
struct KernelTable {
    ArgumentFacts argument[Arguments + 1];
    LinkUse link[Links + 1];
    Edge edge;
};
template <class K, class Needs, class... A, class... C>
constexpr KernelTable<sizeof...(A), sizeof...(C)> kernel_table(machine::Types<A...>, machine::Types<C...>) noexcept
{
    KernelTable<sizeof...(A), sizeof...(C)> t{
        {ArgumentOf<A, Needs>::facts..., {}},
        {LinkUse{machine::index_in<C>(typename Needs::Links{}), KernelTraits<K>::template reads<C>, KernelTraits<K>::template writes<C>}..., {}},
        Edge::reflect};
    [[maybe_unused]] std::uint32_t sends = 0;
    [[maybe_unused]] bool differ = false;
    ((KernelTraits<K>::template writes<C> ? void((differ = differ || (sends++ != 0 && C::edge != t.edge), t.edge = C::edge)) : void()), ...);
    if (differ) t.edge = Edge::reflect;
    return t;
}
template <std::uint32_t N>
struct OperationsTable {
    OperationNames at[N + 1];
};
template <class... Step>
constexpr OperationsTable<sizeof...(Step)> operations_table(machine::Types<Step...>) noexcept
{
    return {{operation_names<KernelOf<Step>>()..., OperationNames{}}};
}
template <class K, class Needs>
inline constexpr auto kernel_table_of =
    kernel_table<K, Needs>(typename KernelTraits<K>::Arguments{}, typename KernelTraits<K>::Links{});
} // namespace detail

template <class Program, bool Guarded>
inline constexpr auto state_table =
    detail::state_table<Guarded, typename machine::Needs<Program>::Shareds>(typename machine::Needs<Program>::States{});
template <class Program>
inline constexpr auto link_table = detail::link_table<typename machine::Needs<Program>::Shareds>(typename machine::Needs<Program>::Links{});
/// By steps, the names of the operations that a kernel counts. Only a trace has them.
template <class Program>
inline constexpr auto operations_of_steps = detail::operations_table(StepsOf<Program>{});
template <class Program, class K>
inline constexpr KernelFacts kernel_facts{name_of<K>(),
                                          KernelTraits<K>::multi_worker,
                                          detail::kernel_table_of<K, machine::Needs<Program>>.edge,
                                          {detail::kernel_table_of<K, machine::Needs<Program>>.argument, KernelTraits<K>::Arguments::count},
                                          {detail::kernel_table_of<K, machine::Needs<Program>>.link, KernelTraits<K>::Links::count}};

namespace detail {
template <std::uint32_t Steps, std::uint32_t Loops>
struct ProgramTable {
    StepFacts step[Steps + 1];
    LoopAt loop[Loops + 1];
};
template <class Program, class... Step>
constexpr ProgramTable<sizeof...(Step), StepTraits<Program>::loops> program_table(machine::Types<Step...>) noexcept
{
    ProgramTable<sizeof...(Step), StepTraits<Program>::loops> t{
        {StepFacts{&kernel_facts<Program, KernelOf<Step>>, StepTraits<Step>::everywhere, false}..., StepFacts{}}, {}};
    for (std::uint32_t i = 0; i < sizeof...(Step); ++i) t.step[i].votes = votes_after<Program>(i);
    [[maybe_unused]] auto const all = tilemesh::loops_of<Program>();
    for (std::uint32_t l = 0; l < StepTraits<Program>::loops; ++l) t.loop[l] = all.found[l];
    return t;
}
template <class Program>
inline constexpr auto program_table_of = program_table<Program>(StepsOf<Program>{});
} // namespace detail

template <class Program>
inline constexpr ProgramFacts program_facts{{detail::program_table_of<Program>.step, StepsOf<Program>::count},
                                            {detail::program_table_of<Program>.loop, StepTraits<Program>::loops}};

}}} // namespace tilemesh::engine
