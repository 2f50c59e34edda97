#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <type_traits>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// The format in which the machine stores a pixel's colour.
enum class ColourFormat : std::uint32_t { float32, rgbx8, own };

/// The facts about a setup that a renderer needs, as a value. Renderers of setups with the same policies share their code.
struct SetupFacts {
    char const* name;
    MachineSize machine;
    splat::Sizes sizes;
    splat::PolicyWords policies;
    std::uint32_t sh_degree;    ///< of a record
    std::uint32_t record_bytes;
    ColourFormat colour;
    bool has_depth, has_alpha;
    bool routes, blooms;        ///< the optional steps of the frame
    splat::Rules rules;         ///< rules of the picture with which the setup begins
    std::uint64_t sram_bytes;   ///< bytes of a tile that count against the SRAM
    std::vector<machine::Region> ledger; ///< of a tile

    bool has_planes() const noexcept { return has_depth || has_alpha; }
};

/// The rules of the picture of a setup.
template <class S>
constexpr splat::Rules rules_of() noexcept
{
    splat::Rules m;
    m.footprint = S::footprint;
    m.alpha_max = S::alpha_max;
    m.transmittance_min = S::transmittance_min;
    m.arithmetic = S::arithmetic;
    return m;
}

namespace detail {
template <class S>
SetupFacts facts_with(splat::Sizes const& sizes)
{
    using Pixel = splat::ColourOf<typename S::Pixel>;
    using Ledger = SramLedger<splat::Frame<S>>;
    constexpr auto words = splat::frame_words<S>();
    constexpr auto machine = size_of_machine<typename S::Machine>();
    SetupFacts f{};
    f.name = S::name;
    f.machine = machine;
    f.sizes = sizes;
    f.policies = splat::policies_of<S>();
    f.sh_degree = S::Record::sh_degree;
    f.record_bytes = words.record;
    f.colour = std::is_same_v<Pixel, splat::FloatPixel>   ? ColourFormat::float32
               : std::is_same_v<Pixel, splat::Rgbx8Pixel> ? ColourFormat::rgbx8
                                                          : ColourFormat::own;
    f.has_depth = S::Pixel::has_depth;
    f.has_alpha = S::Pixel::has_alpha;
    f.routes = S::routes;
    f.blooms = S::blooms;
    f.rules = rules_of<S>();
    f.sram_bytes = Ledger::bytes(machine, sizes);
    auto const lines = Ledger::lines(machine, sizes);
    f.ledger.assign(lines.begin(), lines.end());
    return f;
}
inline constexpr char needs_fifos[] = "a setup that holds needs FIFOs (without one no credit is ever given and nothing moves); give "
                                      "Sizes::waiting room for at least one message";
/// The sizes of the steps that a setup leaves out, in a program that has all of them.
template <class P>
void leave_out_parts(SetupFacts const& facts, MeshSizes<splat::Frame<P>>& m)
{
    constexpr auto nothing = MeshSizes<splat::Frame<P>>::no_digest;
    auto const leave_out = [&]<class Channel, class... State>(machine::Tag<Channel>, machine::Types<State...>) {
        m.template link<Channel>().slots = 1; // a mesh refuses a channel without slots
        m.undigested_links[machine::index_in<Channel>(typename machine::Needs<splat::Frame<P>>::Links{})] = true;
        ((m.template undigested_of<State>() = nothing), ...);
    };
    using splat::Waiting;
    if (!facts.routes)
        leave_out(machine::Tag<splat::Road<P>>{}, machine::Types<splat::FlowControl, Waiting<P, 0>, Waiting<P, 1>>{});
    if (!facts.blooms) leave_out(machine::Tag<splat::Beam<P>>{}, machine::Types<splat::OwedCopies>{});
    if (!facts.routes && !facts.blooms) // tiles have an AnchorMark
        m.template undigested_of<splat::Marks<P>>() = (sizeof(splat::Mark) - sizeof(splat::AnchorMark)) / 4;
}
} // namespace detail

/// The sizes of a mesh that runs the frame program of policies P. Slots and bytes are those of the machine, even if the host moves
/// references.
template <class P>
MeshSizes<splat::Frame<P>> mesh_sizes_of(SetupFacts const& facts)
{
    auto m = engine::plain_sizes<splat::Frame<P>>(facts.machine, facts.sizes, typename machine::Needs<splat::Frame<P>>::States{},
                                                          typename machine::Needs<splat::Frame<P>>::Links{});
    if constexpr (P::routes) m.template link<splat::Road<P>>().message_bytes = facts.policies.road_bytes;
    if constexpr (P::blooms) m.template link<splat::Beam<P>>().message_bytes = facts.policies.beam_bytes;
    m.sram_bytes = facts.sram_bytes;
    if constexpr (machine::has_form_word<typename P::Parameters>) m.wide = facts.has_planes();
    if constexpr (splat::has_parts_words<typename P::Parameters>) detail::leave_out_parts<P>(facts, m);
    return m;
}

/// Limits the lists of a mesh of the frame program to the slots that the options name.
template <class P, class M>
void limit_lists(M& mesh, SetupFacts const& facts, RendererOptions const& options)
{
    if (options.channel_slots != 0) {
        if constexpr (P::routes)
            if (facts.routes) mesh.template limit<splat::Road<P>>(options.channel_slots);
        if constexpr (P::blooms)
            if (facts.blooms) mesh.template limit<splat::Beam<P>>(options.channel_slots);
    }
    if constexpr (P::routes && P::Saturation::may_hold)
        if (options.waiting_slots != 0 && facts.policies.holds != 0 && facts.routes) {
            mesh.template limit<splat::Waiting<P, 0>>(options.waiting_slots);
            mesh.template limit<splat::Waiting<P, 1>>(options.waiting_slots);
        }
    if (options.storage_slots != 0) mesh.template limit<splat::Storage<P>>(options.storage_slots);
}

/// Writes the words of a setup into the parameters of a frame that draws.
template <class Parameters>
void write_words(SetupFacts const& facts, Parameters& frame)
{
    if constexpr (splat::has_policies<Parameters>) frame.policies = facts.policies;
    if constexpr (machine::has_form_word<Parameters>) frame.wide = facts.has_planes() ? 1 : 0;
    if constexpr (splat::has_parts_words<Parameters>) {
        frame.routes = facts.routes ? 1 : 0;
        frame.blooms = facts.blooms ? 1 : 0;
        frame.draws = 1;
    }
}

/// Throws Error if a renderer of policies P cannot serve a setup: its pixels lack a plane, it has other steps, or (by value) its records or
/// rules differ.
template <class P>
void check_facts(SetupFacts const& facts)
{
    bool serves = (P::Pixel::has_depth || !facts.has_depth) && (P::Pixel::has_alpha || !facts.has_alpha);
    if constexpr (!splat::has_parts_words<typename P::Parameters>) serves = serves && facts.routes == P::routes && facts.blooms == P::blooms;
    if constexpr (splat::has_policies<typename P::Parameters>) {
        if constexpr (!std::is_same_v<typename P::Record, splat::Reference>) serves = serves && facts.sh_degree <= P::Record::sh_degree;
    } else {
        serves = serves && facts.sh_degree == P::Record::sh_degree && (facts.policies.holds != 0) == P::Saturation::holds &&
                 (facts.policies.ranks != 0) == splat::may_rank<typename P::Saturation> &&
                 (facts.policies.carried != 0) == P::Addressing::carried && (facts.policies.reusable != 0) == P::Copies::reusable;
    }
    if (!serves)
        throw Error(std::string("setup ") + facts.name + " on a renderer of other policies (its pixels lack a plane, its steps differ, or by value its records " +
                    "or rules do); choose the renderer with the setup's policies");
}

/// Throws Error for a bound of hops where routing and bloom take turns in one set of channels.
inline void check_hops(SetupFacts const& facts, std::uint32_t hops)
{
    if (facts.sizes.one_channel_memory && hops != 0)
        throw Error(std::string("setup ") + facts.name + " with bounded hops (its routing and bloom take turns in one set of " +
                    "channels, which a bound would leave full); choose a setup with channels of their own");
}

/// Throws Error for a prefetch where moving records early could change a picture.
inline void check_prefetch(SetupFacts const& facts, std::uint32_t hops)
{
    auto const refuse = [](std::string const& what, char const* why) {
        throw Error("prefetch with " + what + " (" + why + "); render without it, or choose `lossless`");
    };
    auto const setup = std::string("setup ") + facts.name;
    if (facts.policies.holds == 0) refuse(setup, "it drops records that find no room, also those that move early");
    if (!facts.routes) refuse(setup, "it does not route: the host places its records in each view");
    if (hops != 0) refuse("bounded hops", "a frame that is cut depends on where its records were before");
}

}}} // namespace tilemesh::render
