#pragma once
#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <tilemesh/any_renderer.hpp>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup_facts.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/homes/regions.hpp>
#include <utility>
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
    std::uint32_t sh_degree = 0;
    ColourFormat colour = ColourFormat::float32;
    bool depth = false, alpha = false;
    splat::Model model{};
};

/// The ledger of a tile: the lines of `SramLedger<splat::homes::Frame<P>>` for the policies by value, and their sum.
struct HomesLedger {
    std::vector<machine::Region> lines;
    std::uint64_t bytes = 0;

    HomesLedger(HomesChoice const& c, splat::homes::Sizes const& sizes)
    {
        using namespace splat;
        using P = homes::ValuePolicies<>;
        auto const list = [](std::uint64_t slots, std::uint64_t slot_bytes) { return 8 + slots * slot_bytes; };
        std::uint64_t const record = sizeof(Gaussian) + 12 * std::uint64_t{harmonics_per_channel(c.sh_degree)};
        std::uint64_t const pixel = (c.colour == ColourFormat::rgbx8 ? 4u : 12u) + (c.depth ? 4u : 0u) + (c.alpha ? 4u : 0u);
        std::uint64_t const parcel = sizeof(homes::Parcel<Splat>);
        add(homes::WindowNotices::name, "channel, 8 ends", 8 * list(sizes.columns, sizeof(homes::WindowNotice)));
        add(homes::Parcels<P>::name, "channel, 8 ends", 8 * list(sizes.parcels, parcel));
        add(homes::Home<P>::name, "state", list(sizes.homes, record));
        add(homes::Seen<P>::name, "state", list(sizes.homes, sizeof(Splat)));
        add(homes::Window::name, "state", sizeof(homes::Window));
        add(homes::Held<P>::name, "state", list(sizes.held, sizeof(Splat)));
        add(homes::Keys::name, "state", list(sizes.held, sizeof(SortKey)));
        add(homes::Order::name, "state", list(sizes.held, 4));
        add(homes::Cuts::name, "state", list(homes::most_cuts, 4));
        add(homes::NextCuts::name, "state", list(homes::most_cuts, 4));
        add(homes::Sample::name, "state", list(homes::most_samples, 4));
        add(homes::Blocks<false>::name, "state", list(sizes.tile_blocks, c.depth ? sizeof(homes::Blocks<true>::value_type) : sizeof(homes::Blocks<false>::value_type)));
        add(homes::Counts::name, "state", sizeof(homes::Counts));
        add(homes::Work::name, "state", sizeof(homes::Work));
        add(homes::Table::name, "state", list(sizes.tiles, sizeof(homes::WindowNotice)));
        add(homes::Sending::name, "state", sizeof(homes::Sending));
        add(homes::Offers::name, "state", list(sizes.homes, sizeof(homes::Offered)));
        add(homes::Waiting<P, 0>::name, "state", list(sizes.waiting, parcel));
        add(homes::Waiting<P, 1>::name, "state", list(sizes.waiting, parcel));
        add(homes::Framebuffer<FloatPixel>::name, "state", list(sizes.tile_pixels, pixel));
        add(homes::Parameters::name, "broadcast", sizeof(homes::Parameters));
        add("code and stacks", "reserve", c.machine.code_bytes);
    }

private:
    void add(char const* name, char const* what, std::uint64_t region_bytes)
    {
        lines.push_back({as_name(name), what, static_cast<std::uint32_t>(std::min<std::uint64_t>(region_bytes, 0xffffffffu)), true});
        bytes += region_bytes;
    }
};

/// The division of a frame among the tiles, and the slots of a tile.
struct HomesLayout {
    Grid grid;
    splat::homes::Fold fold;
    splat::homes::Sizes sizes;
    HomesLedger ledger;
};

inline Grid homes_grid(RendererOptions const& options) noexcept
{
    return options.grid.width != 0 && options.grid.height != 0 ? Grid{options.grid.width, options.grid.height} : Grid{40, 36};
}

/// A tile that holds fewer splats of a window than this needs many rounds. A map that leaves less room comes in chapters.
inline constexpr std::uint32_t least_held = 256;

/// The layout of a frame of `size` pixels for a map of `records` records. Throws Error if the frame or the grid is too large, or if
/// the slots do not fit into a tile's SRAM. Records without a home come in chapters.
inline HomesLayout layout_homes(HomesChoice const& c, RendererOptions const& options, Extent2 size, std::uint64_t records)
{
    if (size.width == 0 || size.height == 0 || size.width > 65535 || size.height > 65535)
        throw Error("a frame of " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                    " pixels (each side is 1 to 65,535); choose another size");
    auto const grid = homes_grid(options);
    if (std::uint64_t{grid.width} * grid.height > c.machine.tiles)
        throw Error("a grid of " + std::to_string(grid.width) + " x " + std::to_string(grid.height) + " tiles (" + c.machine.name + " has " +
                    std::to_string(c.machine.tiles) + "); choose a smaller grid or another machine");
    auto const fold = splat::homes::make_fold(size.width, size.height, grid, options.fold);
    auto sizes = c.sizes;
    sizes.columns = fold.x.tiles;
    sizes.tiles = fold.x.tiles * fold.y.tiles;
    sizes.tile_blocks = fold.tile_blocks();
    sizes.tile_pixels = sizes.tile_blocks * splat::block_width * splat::block_height;
    if (c.fit) {
        // Homes for all records, and as many held splats as the rest of the SRAM has room for. If that leaves too few, the map comes in
        // chapters: tiles hold the most, and homes take the rest.
        auto const room_for = [&](std::uint32_t splat::homes::Sizes::*list) { // slots of this list beside all others
            auto some = sizes;
            some.*list = 0;
            std::uint64_t const used = HomesLedger(c, some).bytes, most = c.machine.sram_bytes;
            some.*list = 1;
            return used < most ? (most - used) / (HomesLedger(c, some).bytes - used) : 0;
        };
        auto const slots = [](std::uint64_t n) { return static_cast<std::uint32_t>(std::min<std::uint64_t>(n, 0x7fffffffu)); };
        std::uint32_t const most_held = sizes.held;
        sizes.homes = slots(std::max<std::uint64_t>((records + grid.size() - 1) / grid.size(), 1));
        sizes.held = slots(std::min<std::uint64_t>(most_held, room_for(&splat::homes::Sizes::held)));
        if (sizes.held < std::min(options.held_slots != 0 ? options.held_slots : least_held, most_held)) {
            sizes.held = most_held;
            sizes.homes = std::max(slots(room_for(&splat::homes::Sizes::homes)), 1u);
        }
    }
    HomesLedger ledger(c, sizes);
    if (ledger.bytes > c.machine.sram_bytes) throw does_not_fit(c.machine, ledger.lines, ledger.bytes);
    if (options.held_slots > sizes.held)
        throw Error("a limit of " + std::to_string(options.held_slots) + " held splats (a tile has room for " + std::to_string(sizes.held) +
                    "); choose 1 to " + std::to_string(sizes.held));
    return {grid, fold, sizes, std::move(ledger)};
}

/// The facts of a choice. `routing` and `beam` are the slots of the one channel that the program has.
inline SetupFacts facts_of(HomesChoice const& c, splat::homes::Sizes const& sizes, HomesLedger const& ledger)
{
    SetupFacts f{};
    f.name = c.name;
    f.machine = c.machine;
    f.rules = {1, 1, 0, sizeof(splat::homes::Parcel<splat::Splat>), sizeof(splat::homes::Parcel<splat::Splat>)};
    f.sizes.storage = sizes.held;
    f.sizes.road = f.sizes.beam = sizes.parcels;
    f.sizes.waiting = sizes.waiting;
    f.sizes.tile_pixels = sizes.tile_pixels;
    f.sh_degree = c.sh_degree;
    f.record_bytes = static_cast<std::uint32_t>(sizeof(splat::Gaussian)) + 12 * splat::harmonics_per_channel(c.sh_degree);
    f.colour = c.colour;
    f.has_depth = c.depth;
    f.has_alpha = c.alpha;
    f.model = c.model;
    f.sram_bytes = ledger.bytes;
    f.ledger = ledger.lines;
    return f;
}

/// Makes a HomesRenderer on host threads, by reference, with host pixels of this type: FloatPixel, or HomesPlanes for a choice with a depth
/// or an alpha plane. The compiled library has the code for both.
template <class Pixel = splat::FloatPixel>
std::unique_ptr<AnyRenderer> make_homes_renderer(scene::Map const& map, HomesChoice const& choice, RendererOptions const& options);
using HomesPlanes = splat::WithAlpha<splat::WithDepth<splat::FloatPixel>>;

}}} // namespace tilemesh::render

#if defined(TILEMESH_COMPILED)
namespace tilemesh { inline namespace v0_2 { namespace render {
extern template std::unique_ptr<AnyRenderer> make_homes_renderer<splat::FloatPixel>(scene::Map const&, HomesChoice const&, RendererOptions const&);
extern template std::unique_ptr<AnyRenderer> make_homes_renderer<HomesPlanes>(scene::Map const&, HomesChoice const&, RendererOptions const&);
}}} // namespace tilemesh::render
#else
#include <tilemesh/render/detail/homes_choice_code.hpp>
#endif
