#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup_fields.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

namespace detail {
inline constexpr Word until_quiet[] = {{"quiet", 0}};
inline constexpr Word until_complete[] = {{"all", 0}, {"0", 0}};
inline constexpr Word no_limit[] = {{"none", 0}};
inline constexpr Word what_fits[] = {{"fits", 0}};
} // namespace detail

/// A field of `RendererOptions`: what one run may do, beside the machine and the policies of its setup. Each row is an option of render_map
/// and a setting of C and Python, without a line of theirs.
using RendererField = FieldOf<RendererOptions>;
inline constexpr RendererField renderer_fields[] = {
    {"hops", {Values::whole, 1, any_number - 1, "exchanges", detail::until_quiet}, "end routing, and bloom, of a frame after N exchanges",
     [](auto& o) -> auto& { return o.hops; }},
    {"most-passes", {Values::whole, 1, any_number, "passes", detail::no_limit}, "stop with an error if routing, or bloom, needs more than N passes",
     [](auto& o) -> auto& { return o.most_passes; }},
    {"held", {Values::whole, 1, any_number, "slots", detail::what_fits}, "homes: limit the splats that a tile holds; else storage-slots does",
     [](auto& o) -> auto& { return o.held_slots; }},
    {"rounds", {Values::whole, 1, any_number, "rounds", detail::until_complete}, "homes: end a frame after N rounds, complete or not",
     [](auto& o) -> auto& { return o.rounds; }},
    {"fold", {.words = detail::switches}, "homes: spread each part of the picture over the grid: {}", [](auto& o) -> auto& { return o.fold; }},
};

/// Fields that only the program of homes has.
inline constexpr std::string_view only_homes[] = {"rounds", "held", "fold"};

/// What a setup or options ask for that only the anchored program has: the field, its value if that matters, and why homes do not have it.
/// `field` is empty if there is no such thing.
struct OnlyAnchored {
    std::string_view field, value, why;
    constexpr explicit operator bool() const noexcept { return !field.empty(); }
    /// "saturation drop (homes drop nothing)"
    std::string text() const
    {
        return std::string(field).append(value.empty() ? "" : " ").append(value).append(" (").append(why).append(")");
    }
};
constexpr OnlyAnchored only_anchored(splat::Setup const& setup, RendererOptions const& options) noexcept
{
    if (!setup.holds) return {"saturation", "drop", "homes drop nothing"};
    if (!setup.reusable) return {"copies", "screen", "homes send no copies to keep"};
    if (setup.ranks) return {"priority", "largest", "homes lose nothing that a rank could save"};
    if (options.hops != 0) return {"hops", {}, "homes have no routing to end; rounds end a frame of homes"};
    if (options.tile.width != 0 || options.tile.height != 0) return {"tile", {}, "homes divide the frame into blocks of 16 x 5 pixels"};
    if (options.sizes) return {"sizes", {}, "homes have their own"};
    return {};
}

}}} // namespace tilemesh::render
