#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 { namespace render {

namespace detail {
/// The sizes of the steps that a setup leaves out, in a program that has all of them.
template <class P>
void leave_out_parts(Setup const& setup, MeshSizes<splat::Frame<P>>& m)
{
    constexpr auto nothing = MeshSizes<splat::Frame<P>>::no_digest;
    auto const leave_out = [&]<class Channel, class... State>(machine::Tag<Channel>, machine::Types<State...>) {
        m.template link<Channel>().slots = 1; // a mesh refuses a channel without slots
        m.undigested_links[machine::index_in<Channel>(typename machine::Needs<splat::Frame<P>>::Links{})] = true;
        ((m.template undigested_of<State>() = nothing), ...);
    };
    using splat::Waiting;
    if (!setup.routes)
        leave_out(machine::Tag<splat::Road<P>>{}, machine::Types<splat::FlowControl, Waiting<P, 0>, Waiting<P, 1>>{});
    if (!setup.blooms) leave_out(machine::Tag<splat::Beam<P>>{}, machine::Types<splat::OwedCopies>{});
    if (!setup.routes && !setup.blooms) // tiles have an AnchorMark
        m.template undigested_of<splat::Marks<P>>() = (sizeof(splat::Mark) - sizeof(splat::AnchorMark)) / 4;
}
} // namespace detail

/// The sizes of a mesh that runs the frame program of policies P. Slots and bytes are those of the machine, even if the host moves
/// references.
template <class P>
MeshSizes<splat::Frame<P>> mesh_sizes_of(Setup const& setup)
{
    auto m = engine::plain_sizes<splat::Frame<P>>(setup.machine, setup, typename machine::Needs<splat::Frame<P>>::States{},
                                                          typename machine::Needs<splat::Frame<P>>::Links{});
    if constexpr (std::is_same_v<typename P::Record, splat::Reference>) m.sram_bytes = sram_bytes_of(setup);
    if constexpr (machine::has_form_word<typename P::Parameters>) m.wide = setup.has_planes();
    if constexpr (splat::has_parts_words<typename P::Parameters>) detail::leave_out_parts<P>(setup, m);
    return m;
}

/// Limits the lists of a mesh of the frame program to the slots that the options name.
template <class P, class M>
void limit_lists(M& mesh, Setup const& setup, RendererOptions const& options)
{
    if (options.channel_slots != 0) {
        if constexpr (P::routes)
            if (setup.routes) mesh.template limit<splat::Road<P>>(options.channel_slots);
        if constexpr (P::blooms)
            if (setup.blooms) mesh.template limit<splat::Beam<P>>(options.channel_slots);
    }
    if constexpr (P::routes && P::Saturation::may_hold)
        if (options.waiting_slots != 0 && setup.holds && setup.routes) {
            mesh.template limit<splat::Waiting<P, 0>>(options.waiting_slots);
            mesh.template limit<splat::Waiting<P, 1>>(options.waiting_slots);
        }
    if (options.storage_slots != 0) mesh.template limit<splat::Storage<P>>(options.storage_slots);
}

/// Writes the words of a setup into the parameters of a frame that draws.
template <class Parameters>
void write_words(Setup const& setup, Parameters& frame)
{
    if constexpr (splat::has_policies<Parameters>) frame.policies = splat::policy_words(setup);
    if constexpr (machine::has_form_word<Parameters>) frame.wide = setup.has_planes() ? 1 : 0;
    if constexpr (splat::has_parts_words<Parameters>) {
        frame.routes = setup.routes ? 1 : 0;
        frame.blooms = setup.blooms ? 1 : 0;
        frame.draws = 1;
    }
}

/// Throws Error if a renderer of policies P cannot serve a setup: its pixels lack a plane, it has other steps, or (by value) its records or
/// rules differ.
template <class P>
void check_policies(Setup const& setup)
{
    bool serves = (P::Pixel::has_depth || !setup.depth) && (P::Pixel::has_alpha || !setup.alpha);
    if constexpr (!splat::has_parts_words<typename P::Parameters>) serves = serves && setup.routes == P::routes && setup.blooms == P::blooms;
    if constexpr (splat::has_policies<typename P::Parameters>) {
        if constexpr (!std::is_same_v<typename P::Record, splat::Reference>) serves = serves && setup.sh_degree <= P::Record::sh_degree;
    } else {
        serves = serves && setup.sh_degree == P::Record::sh_degree && setup.holds == P::Saturation::holds &&
                 setup.ranks == splat::may_rank<typename P::Saturation> &&
                 setup.carried == P::Addressing::carried && setup.reusable == P::Copies::reusable;
    }
    if (!serves)
        throw Error(std::string("setup ") + setup.name + " on a renderer of other policies (its pixels lack a plane, its steps differ, or by " +
                    "value its records " +
                    "or rules do); choose the renderer with the setup's policies");
}

/// Throws Error for a bound of hops where routing and bloom take turns in one set of channels.
inline void check_hops(Setup const& setup, std::uint32_t hops)
{
    if (setup.sizes.one_channel_memory && hops != 0)
        throw Error(std::string("setup ") + setup.name + " with bounded hops (its routing and bloom take turns in one set of " +
                    "channels, which a bound would leave full); choose a setup with channels of their own");
}

/// Throws Error for a prefetch where moving records early could change a picture.
inline void check_prefetch(Setup const& setup, std::uint32_t hops)
{
    auto const refuse = [](std::string const& what, char const* why) {
        throw Error("prefetch with " + what + " (" + why + "); render without it, or choose `lossless`");
    };
    auto const name = std::string("setup ") + setup.name;
    if (!setup.holds) refuse(name, "it drops records that find no room, also those that move early");
    if (!setup.routes) refuse(name, "it does not route: the host places its records in each view");
    if (hops != 0) refuse("bounded hops", "a frame that is cut depends on where its records were before");
}

}}} // namespace tilemesh::render
