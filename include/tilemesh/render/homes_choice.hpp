#pragma once
#include <cstdint>
#include <memory>
#include <tilemesh/any_renderer.hpp>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup_facts.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/homes/regions.hpp>
#include <type_traits>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// A machine and its rules for the program of homes.
struct HomesChoice {
    char const* name = "homes";
    MachineSize machine = size_of_machine<Mk2>();
    /// Slots of a tile. `columns`, `tiles`, `tile_blocks` and `tile_pixels` follow from the grid and the frame. With 120 slots a channel end
    /// and 2,800 splats a window, four modelled views take the least time or nearly so (bench/any_map).
    splat::homes::Sizes sizes{950, 2800, 120, 120};
    /// `homes` are as many as the map needs, if the SRAM has room for them, and `held` shrinks to what they leave, at least to `least_held`.
    bool fit = false;
    /// Tiles along a side of a district (splat/homes/regions.hpp): a power of 2. A home keeps a window of each district, so larger ones need
    /// less SRAM, but bring splats that a tile does not want yet. 0: the smallest with which a tile's lists fit.
    std::uint32_t district = 1;
    std::uint32_t sh_degree = 0;
    ColourFormat colour = ColourFormat::float32;
    bool depth = false, alpha = false;
    splat::Rules rules{};
};

/// The ledger of a tile: the lines of `SramLedger<splat::homes::Frame<P>>` for the policies by value, and their sum.
struct HomesLedger {
    std::vector<machine::Region> lines;
    std::uint64_t bytes = 0;

    HomesLedger(HomesChoice const& c, splat::homes::Sizes const& sizes);

private:
    void add(char const* name, char const* what, std::uint64_t region_bytes);
};

/// The division of a frame among the tiles, and the slots of a tile.
struct HomesLayout {
    Grid grid;
    splat::homes::Fold fold;
    splat::homes::Sizes sizes;
    HomesLedger ledger;
    std::uint32_t district; ///< above 0
};

inline Grid homes_grid(RendererOptions const& options) noexcept
{
    return options.grid.width != 0 && options.grid.height != 0 ? Grid{options.grid.width, options.grid.height} : Grid{40, 36};
}

/// The options of an anchored renderer for the renderer of homes that takes over from it: limits above the slots of homes limit nothing.
TILEMESH_HOST RendererOptions within(HomesChoice const& choice, RendererOptions options) noexcept;
/// Throws Error for limits above the slots that the choice has.
TILEMESH_HOST void check_limits(HomesChoice const& choice, RendererOptions const& options);

/// A tile that holds fewer splats of a window than this needs many rounds. A map that leaves less room comes in chapters.
inline constexpr std::uint32_t least_held = 256;

/// The layout of a frame of `size` pixels for a map of `records` records. Throws Error if the frame or the grid is too large, if a district
/// is no power of 2, or if the slots do not fit into a tile's SRAM. Records without a home come in chapters.
TILEMESH_HOST HomesLayout layout_homes(HomesChoice const& c, RendererOptions const& options, Extent2 size, std::uint64_t records);

/// Returns the choice with as many homes as the rest of its machine's SRAM has room for, for frames of `grid` tiles of `tile` pixels: one
/// more does not fit. All other sizes stay, and `fit` is off. Throws Error as `layout_homes`, and if the SRAM has room for no home.
TILEMESH_HOST HomesChoice fill_storage(HomesChoice c, Grid grid, Extent2 tile);

/// Returns the choice on another machine: parcels and FIFOs shrink as the SRAM without the code does (`channel_slots`: they have so many
/// slots, at most the choice's). With `fit`, the layout divides the rest among homes and held splats.
TILEMESH_HOST HomesChoice on_machine(HomesChoice c, MachineSize const& machine, std::uint32_t channel_slots = 0);

/// Do the choice's sizes fit on its machine, for frames of `size` pixels of a map of `records` records: a home for each, and no fewer held
/// splats? Then a preset that comes from another machine can keep them, without `on_machine`.
TILEMESH_HOST bool keeps_sizes(HomesChoice const& c, RendererOptions options, Extent2 size, std::uint64_t records);

/// Gives a choice of any district those of a renderer by value, with `side` tiles along a side. Throws Error for a choice of others.
TILEMESH_HOST void take_districts(HomesChoice& choice, std::uint32_t side);

/// The facts of a choice. `routing` and `beam` are the slots of the one channel that the program has.
TILEMESH_HOST SetupFacts facts_of(HomesChoice const& c, splat::homes::Sizes const& sizes, HomesLedger const& ledger);

/// Throws Error if a choice's records or pixels are not those of the policies. `Wider`: tiles may store more than the ledger counts.
template <class P, bool Wider>
void check_choice(HomesChoice const& c)
{
    using Pixel = typename P::Pixel;
    bool const rgbx8 = std::is_same_v<splat::ColourOf<Pixel>, splat::Rgbx8Pixel>;
    bool fits = Pixel::has_depth >= c.depth && Pixel::has_alpha >= c.alpha && (c.colour == ColourFormat::rgbx8) >= rgbx8;
    if constexpr (Wider)
        fits = fits && c.sh_degree <= P::Record::sh_degree;
    else if constexpr (!std::is_same_v<typename P::Record, splat::Reference>)
        fits = c.sh_degree == P::Record::sh_degree && c.depth == Pixel::has_depth && c.alpha == Pixel::has_alpha &&
               (c.colour == ColourFormat::rgbx8) == rgbx8;
    if (!fits)
        throw Error("a choice of records or pixels that the renderer's policies do not store (degree, colour format, depth or alpha "
                    "differ); give both the same");
}

/// Makes a HomesRenderer on host threads, by reference, with host pixels of this type: FloatPixel, or HomesPlanes for a choice with a depth
/// or an alpha plane. The compiled library has one renderer that serves both.
template <class Pixel = splat::FloatPixel>
std::unique_ptr<AnyRenderer> make_homes_renderer(scene::Map map, HomesChoice const& choice, RendererOptions const& options);
using HomesPlanes = splat::WithAlpha<splat::WithDepth<splat::FloatPixel>>;

}}} // namespace tilemesh::render

#if defined(TILEMESH_COMPILED)
namespace tilemesh { inline namespace v0_2 { namespace render {
template <>
std::unique_ptr<AnyRenderer> make_homes_renderer<splat::FloatPixel>(scene::Map, HomesChoice const&, RendererOptions const&);
template <>
std::unique_ptr<AnyRenderer> make_homes_renderer<HomesPlanes>(scene::Map, HomesChoice const&, RendererOptions const&);
}}} // namespace tilemesh::render
#else
#include <tilemesh/render/detail/homes_layout_code.hpp>
#include <tilemesh/render/detail/homes_choice_code.hpp>
#endif
