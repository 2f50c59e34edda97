#pragma once
#include <tilemesh/machine/channel.hpp>
#include <tilemesh/machine/superstep.hpp>
#include <type_traits>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

/// Parameters that every tile holds. The host sends them to all tiles once a run. Cost: sizeof(P) bytes a tile.
template <class P>
class Broadcast {
public:
    using parameters = P;
    static_assert(std::is_trivially_copyable_v<P> && alignof(P) <= 4 && sizeof(P) % 4 == 0,
                  "Broadcast<P>: P is copied to every tile, it must be trivially copyable and whole 32-bit words (of alignment 4: no "
                  "double, no 64-bit integer)");
    TILEMESH_KERNEL explicit Broadcast(P const* p) noexcept : p_(p) {}
    TILEMESH_KERNEL P const& operator*() const noexcept { return *p_; }
    TILEMESH_KERNEL P const* operator->() const noexcept { return p_; }

private:
    P const* p_;
};

/// A parameter of kernels that must know on which tile they run.
struct Here {
    TileId tile;
    Grid grid;
};

/// A parameter of kernels that all of a tile's workers run at once: worker `index` takes the items index, index + count, ... The workers
/// must write disjoint words. So such a kernel may neither send nor vote, and must not change the sizes of lists (CheckedMesh checks this).
///
/// Such a kernel may have a nested `AllWorkers`: an empty functor with the same parameters, called with {0, all workers}. It does the
/// shares of all of the tile's workers at once and must leave exactly the words that they would leave. An engine that runs a tile on one
/// host thread calls it instead (Mesh does). CheckedMesh runs the kernel for each worker, so comparing the two engines tests this promise.
///
/// If the kernel's state has words for a number of workers, the kernel gives that number: `static constexpr std::uint32_t most_workers =
/// 6;`. Then no mesh is built for a machine with more workers, or with none (engine/mesh_sizes.hpp).
struct Worker {
    std::uint32_t index = 0;
    std::uint32_t count = 1;
};

/// Replaces an argument that a kernel's policies leave out. It is empty and names no region.
struct Absent {};
/// A kernel's parameter that depends on its policies: `OnlyIf<P::counts, Tally&> tally` is `Tally&` if P counts, and `Absent` otherwise.
/// With `Absent` the tile has no Tally, and the ledger has no line for it. The kernel may use `tally` only under `if constexpr
/// (P::counts)`.
template <bool Present, class Argument>
using OnlyIf = std::conditional_t<Present, Argument, Absent>;

/// Is X a list (a Buffer)? A kernel then takes a view of its head and its slots.
template <class X, class = void>
inline constexpr bool is_list = false;
template <class X>
inline constexpr bool is_list<X, std::void_t<typename X::value_type, decltype(X::head_words)>> = true;
/// Does state X hold statistics of one pass? Its struct says so:
///   struct Passed { static constexpr bool per_pass = true; std::uint32_t looked, hops; };
/// Its words are 0 whenever a kernel begins that takes `Passed&`. The host, an observer and the kernel's `operations` read them after the
/// kernel; no kernel can read those of an earlier pass. So a change of them needs no vote, and no digest has them. The state takes its
/// bytes of SRAM as any other.
template <class X, class = void>
inline constexpr bool is_per_pass = false;
template <class X>
inline constexpr bool is_per_pass<X, std::void_t<decltype(X::per_pass)>> = X::per_pass;
/// Does a kernel take X by value? True for In<C>, Out<C>, Broadcast<P>, Here, Worker and Absent.
template <class X>
inline constexpr bool is_view = false;
template <class C>
inline constexpr bool is_view<In<C>> = true;
template <class C>
inline constexpr bool is_view<Out<C>> = true;
template <class P>
inline constexpr bool is_view<Broadcast<P>> = true;
template <>
inline constexpr bool is_view<Here> = true;
template <>
inline constexpr bool is_view<Worker> = true;
template <>
inline constexpr bool is_view<Absent> = true;

/// The states, channels and broadcasts of a kernel or a program: three lists `Types<...>` without repetition.
template <class S, class L, class P>
struct RegionTypes {
    using States = S;
    using Links = L;
    using Shareds = P;
};

namespace detail {
/// The regions that one parameter of a kernel adds to the tile.
struct NoRole {
    using State = void;
    using Link = void;
    using Shared = void;
    static constexpr bool reads = false, writes = false, clears = false;
};
template <class A>
struct Role : NoRole {
    static_assert(!sizeof(A*), "unknown kernel parameter (a kernel takes X& or X const& for a tile's own state, and by value "
                               "In<C>, Out<C>, Broadcast<P>, Here, Worker); change this parameter to one of them");
};
/// Becomes a value of any type; never called.
struct Anything {
    template <class T>
    operator T() const noexcept;
};
/// Has X, a named list, members beside its Buffer? Then it is an aggregate that takes a value after its Buffer. (Its size says nothing:
/// a member may lie in the Buffer's padding.)
template <class X, class = void>
inline constexpr bool has_own_members = false;
template <class X>
inline constexpr bool has_own_members<X, std::void_t<decltype(X{std::declval<typename X::list_type>(), Anything{}})>> = true;
template <class X>
struct Role<X&> : NoRole {
    static_assert(!is_view<std::remove_const_t<X>>,
                  "In<C>, Out<C>, Broadcast<P>, Here and Worker are views (a reference to one would outlive its superstep); "
                  "take them by value");
    static_assert(!is_channel<std::remove_const_t<X>>, "a channel is not state (its words are exchanged); take In<C> or Out<C> by value");
    static_assert(std::is_class_v<X>, "a tile's state is a struct of the program (its type names the region; two kernels that take float& "
                                      "would share one); write struct Heat { float kelvin; }; and take Heat&");
    static_assert(!has_own_members<std::remove_const_t<X>>, "a named buffer with members of its own (it is a view, and a tile keeps its items "
                                                        "alone); keep them in a struct beside it");
    static_assert(!std::is_class_v<X> || is_list<X> || (std::is_trivially_copyable_v<X> && alignof(X) <= 4 && sizeof(X) % 4 == 0),
                  "a tile's state is a Buffer or a trivially copyable struct of whole 32-bit words (it lives in SRAM and may "
                  "be copied as words, so its alignment is 4); keep a double or a 64-bit integer as two words");
    static_assert(!is_per_pass<X> || !std::is_const_v<X>, "a kernel reads per_pass statistics of another pass (an engine clears them "
                                                          "before each kernel that fills them); keep words that kernels read in another state");
    static_assert(!is_per_pass<X> || !is_list<X>, "per_pass statistics are a struct (an engine clears all of its words before a kernel); "
                                                  "count in words, or keep the Buffer as a state");
    using State = std::remove_const_t<X>;
    static constexpr bool clears = is_per_pass<X>;
};
template <class C>
struct Role<In<C>> : NoRole {
    using Link = C;
    static constexpr bool reads = true;
};
template <class C>
struct Role<Out<C>> : NoRole {
    using Link = C;
    static constexpr bool writes = true;
};
template <class P>
struct Role<Broadcast<P>> : NoRole {
    using Shared = P;
};
template <>
struct Role<Here> : NoRole {};
template <>
struct Role<Worker> : NoRole {};
template <>
struct Role<Absent> : NoRole {};

template <class F>
struct Signature { // no operator() that can be named
    static constexpr bool one_call = false, is_const = true, is_noexcept = true;
    using Arguments = machine::Types<>;
    using Result = void;
};
template <bool Const, bool Noexcept, class R, class... A>
struct SignatureIs {
    static constexpr bool one_call = true, is_const = Const, is_noexcept = Noexcept;
    using Arguments = machine::Types<A...>;
    using Result = R;
};
template <class K, class R, class... A>
struct Signature<R (K::*)(A...) const noexcept> : SignatureIs<true, true, R, A...> {};
template <class K, class R, class... A>
struct Signature<R (K::*)(A...) const> : SignatureIs<true, false, R, A...> {};
template <class K, class R, class... A>
struct Signature<R (K::*)(A...) noexcept> : SignatureIs<false, true, R, A...> {};
template <class K, class R, class... A>
struct Signature<R (K::*)(A...)> : SignatureIs<false, false, R, A...> {};

template <class K, class = void>
struct CallOf : Signature<void> {};
template <class K>
struct CallOf<K, std::void_t<decltype(&K::operator())>> : Signature<decltype(&K::operator())> {};

template <class L, class T>
using InsertReal =
    typename std::conditional_t<std::is_void_v<T>, std::common_type<L>, Insert<L, std::conditional_t<std::is_void_v<T>, int, T>>>::type;

template <class Acc, class Args>
struct Collect {
    using type = Acc;
};
template <class S, class L, class P, class A, class... As>
struct Collect<RegionTypes<S, L, P>, machine::Types<A, As...>>
    : Collect<RegionTypes<InsertReal<S, typename Role<A>::State>, InsertReal<L, typename Role<A>::Link>,
                   InsertReal<P, typename Role<A>::Shared>>,
              machine::Types<As...>> {};
} // namespace detail

/// The facts in a kernel's parameter list. Every mistake in it gives one sentence here.
template <class K>
struct KernelTraits : detail::CallOf<K> {
    using Call = detail::CallOf<K>;
    using typename Call::Arguments;
    using typename Call::Result;
    static_assert(Call::one_call, "a kernel has exactly one operator(), neither overloaded nor a template (its parameter "
                                  "list is its declaration); make policies template parameters of the kernel's class");
    static_assert(Call::is_const, "a kernel's operator() must be const noexcept (a kernel has no state of its own); add const");
    static_assert(Call::is_noexcept, "a kernel's operator() must be const noexcept (tiles have no exceptions); add noexcept");
    static_assert(std::is_empty_v<K>, "a kernel must be an empty class (members would not reach the tiles); take constants as "
                                      "Broadcast<P> or as template parameters");
    static_assert(std::is_void_v<Result> || std::is_same_v<Result, Vote>,
                  "a kernel returns nothing or a Vote; keep other results in the tile's state");
    template <class A>
    static constexpr bool takes = machine::contains<A, Arguments>;
    template <class... A>
    static constexpr bool any_writes(machine::Types<A...>) noexcept
    {
        return (detail::Role<A>::writes || ...);
    }
    template <class... A>
    static constexpr bool any_clears(machine::Types<A...>) noexcept
    {
        return (detail::Role<A>::clears || ...);
    }
    static constexpr bool multi_worker = takes<Worker>;
    static_assert(!multi_worker || !any_clears(Arguments{}),
                  "a kernel that takes Worker may not fill per_pass statistics (each worker would clear them); count in a superstep of one "
                  "worker");
    static constexpr bool sends = any_writes(Arguments{});
    static_assert(!multi_worker || (std::is_void_v<Result> && !sends),
                  "a kernel that takes Worker may neither send nor vote (six workers would race); do that in a superstep of "
                  "its own");
    using Needs = typename detail::Collect<RegionTypes<machine::Types<>, machine::Types<>, machine::Types<>>, Arguments>::type;
    /// The channels this kernel reads or writes, in the order of its parameters.
    using Links = typename Needs::Links;
    template <class C>
    static constexpr bool reads = takes<In<C>>;
    template <class C>
    static constexpr bool writes = takes<Out<C>>;
};

/// The functor that does the shares of all of a tile's workers at once: K's nested `AllWorkers` if it exists, otherwise K.
template <class K, class = void>
struct AllWorkersOf {
    using type = K;
    static constexpr bool exists = false;
};
template <class K>
struct AllWorkersOf<K, std::void_t<typename K::AllWorkers>> {
    using type = typename K::AllWorkers;
    static constexpr bool exists = true;
    static_assert(KernelTraits<K>::multi_worker, "only a kernel that takes Worker may have AllWorkers (it does the shares of all workers); "
                                                 "take Worker or remove it");
    static_assert(std::is_same_v<typename KernelTraits<K>::Arguments, typename KernelTraits<type>::Arguments>,
                  "a kernel's AllWorkers takes other parameters than the kernel (it is called in its place); give it the same list");
};

template <class Kernel, class Argument>
inline constexpr bool takes = KernelTraits<Kernel>::template takes<Argument>;

namespace detail {
template <class Acc, class Steps>
struct CollectAll {
    using type = Acc;
};
template <class Acc, class Step, class... Steps>
struct CollectAll<Acc, machine::Types<Step, Steps...>>
    : CollectAll<typename Collect<Acc, typename KernelTraits<KernelOf<Step>>::Arguments>::type, machine::Types<Steps...>> {};

/// Tracks, step by step, whether C holds unread mail. Sets `clash` if a kernel sends over unread mail.
template <class C>
struct Mail {
    bool unread = false;
    bool clash = false;
    template <class Step>
    constexpr void step(Step const&, std::uint32_t) noexcept
    {
        using T = KernelTraits<KernelOf<Step>>;
        constexpr bool repeated = !std::is_same_v<Step, Superstep<KernelOf<Step>>>; // the number of repetitions is a value
        if constexpr (T::template writes<C> && !T::template reads<C>) {
            clash = clash || unread || repeated;
            unread = true;
        } else if constexpr (T::template reads<C>) { // a bound may leave mail unread; the engine watches this
            unread = T::template writes<C> && StepTraits<Step>::everywhere;
        }
    }
    template <class Part, class Body>
    constexpr void loop(Part const&, LoopAt, Body const& body) // no round, one, or several
    {
        bool const before = unread;
        body();
        body();
        unread = unread || before;
    }
    template <class Part, class Body>
    constexpr void condition(Part const&, Body const& body)
    {
        bool const before = unread;
        body();
        unread = unread || before;
    }
};
template <class Acc, class... P>
constexpr auto collect_flags(machine::Types<P...>) noexcept
{
    return typename Collect<Acc, machine::Types<Broadcast<P>...>>::type{};
}
template <class Program>
using CollectSteps = typename CollectAll<RegionTypes<machine::Types<>, machine::Types<>, machine::Types<>>, StepsOf<Program>>::type;

template <class Program, class C>
constexpr bool sends_over_unread_mail() noexcept
{
    Mail<C> mail;
    walk(Program{}, mail);
    walk(Program{}, mail); // programs run again and again
    return mail.clash;
}
template <class Program, class C>
struct ReadBeforeSent {
    static_assert(!sends_over_unread_mail<Program, C>(),
                  "a kernel of this program only sends on channel C while C still holds unread mail (the exchange would "
                  "overwrite it); let that kernel take In<C>, or read C in a step before it");
    static constexpr bool value = true;
};
} // namespace detail

namespace machine {
/// The states, channels and broadcasts of a program as `RegionTypes<Types<...>, Types<...>, Types<...>>`: first those that its kernels
/// name, in that order, then the broadcasts of its conditions.
template <class Program>
using Needs = decltype(detail::collect_flags<detail::CollectSteps<Program>>(typename StepTraits<Program>::Flags{}));
} // namespace machine

}} // namespace tilemesh
