#pragma once
#include <tilemesh/machine/kernel.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 {

namespace detail {
/// Makes argument A of a kernel for one call. `source` is the interpreter's view of the tile.
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
        machine::Place const place = source.template state<Plain>();
        if constexpr (is_per_pass<X> && !std::is_const_v<X>) // `operations` takes it const, and reads what the kernel wrote
            *reinterpret_cast<Plain*>(place.items) = Plain{};
        if constexpr (is_list<Plain>)
            return View{Plain{place}};
        else
            return static_cast<X&>(*reinterpret_cast<Plain*>(place.items));
    }
};
template <class C, class Source>
struct Bind<In<C>, Source> {
    using R = typename C::Receiver;
    TILEMESH_KERNEL static In<C> make(Source& s) noexcept { return make(s, std::make_integer_sequence<std::uint32_t, ends_in<C>>{}); }
    template <std::uint32_t... I>
    TILEMESH_KERNEL static In<C> make(Source& s, std::integer_sequence<std::uint32_t, I...>) noexcept
    {
        return {{R{s.template in<C>(side_of(C::receives_from, I))}...}};
    }
};
template <class C, class Source>
struct Bind<Out<C>, Source> {
    using W = typename C::Sender;
    TILEMESH_KERNEL static Out<C> make(Source& s) noexcept { return make(s, std::make_integer_sequence<std::uint32_t, ends_out<C>>{}); }
    template <std::uint32_t... I>
    TILEMESH_KERNEL static Out<C> make(Source& s, std::integer_sequence<std::uint32_t, I...>) noexcept
    {
        return {{W{s.template out<C>(side_of(C::sends_to, I))}...}};
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
TILEMESH_KERNEL Vote call(Source& source, machine::Types<A...>) noexcept
{
    if constexpr (std::is_void_v<typename KernelTraits<Kernel>::Result>) {
        Kernel{}(Bind<A, Source>::make(source)...);
        return Vote::quiet;
    } else {
        return Kernel{}(Bind<A, Source>::make(source)...);
    }
}
} // namespace detail

/// Runs a kernel on the tile that `source` describes. An interpreter supplies the type of `source`, with these members:
///   Place state<X>();  Place in<C>(Direction);  Place out<C>(Direction);  P const* shared<P>();  Here here();  Worker worker();
/// The Place of a plain struct has the struct's words in `items`.
template <class Kernel, class Source>
TILEMESH_KERNEL Vote run_kernel(Source& source) noexcept
{
    return detail::call<Kernel>(source, typename KernelTraits<Kernel>::Arguments{});
}

}} // namespace tilemesh
