#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/render/host_form.hpp>
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
    splat::FrameRules rules;
    std::uint32_t sh_degree;    ///< of a record
    std::uint32_t record_bytes;
    ColourFormat colour;
    bool has_depth, has_alpha;
    splat::Model model;         ///< rules of the picture with which the setup begins
    std::uint64_t sram_bytes;   ///< bytes of a tile that count against the SRAM
    std::vector<machine::Region> ledger; ///< of a tile
};

/// The rules of the picture of a setup.
template <class S>
constexpr splat::Model model_of() noexcept
{
    splat::Model m;
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
    f.rules = splat::rules_of<S>();
    f.sh_degree = S::Record::sh_degree;
    f.record_bytes = words.record;
    f.colour = std::is_same_v<Pixel, splat::FloatPixel>   ? ColourFormat::float32
               : std::is_same_v<Pixel, splat::Rgbx8Pixel> ? ColourFormat::rgbx8
                                                          : ColourFormat::own;
    f.has_depth = S::Pixel::has_depth;
    f.has_alpha = S::Pixel::has_alpha;
    f.model = model_of<S>();
    f.sram_bytes = Ledger::bytes(machine, sizes);
    auto const lines = Ledger::lines(machine, sizes);
    f.ledger.assign(lines.begin(), lines.end());
    return f;
}
inline constexpr char needs_fifos[] = "a setup that holds needs FIFOs (without one no credit is ever given and nothing moves); give "
                                      "Sizes::waiting room for at least one message";
} // namespace detail

/// The sizes of a mesh that runs the frame program of policies P. Slots and bytes are those of the machine, even if the host moves
/// references.
template <class P>
MeshSizes<splat::Frame<P>> mesh_sizes_of(SetupFacts const& facts)
{
    auto m = engine::plain_sizes<splat::Frame<P>>(facts.machine, facts.sizes, typename machine::Needs<splat::Frame<P>>::States{},
                                                          typename machine::Needs<splat::Frame<P>>::Links{});
    if constexpr (P::routes) m.template link<splat::Road<P>>().message_bytes = facts.rules.road_bytes;
    if constexpr (P::blooms) m.template link<splat::Beam<P>>().message_bytes = facts.rules.beam_bytes;
    m.sram_bytes = facts.sram_bytes;
    return m;
}

}}} // namespace tilemesh::render
