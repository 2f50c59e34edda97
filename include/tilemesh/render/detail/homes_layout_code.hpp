#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/homes_layout.hpp>
#include <tilemesh/splat/homes/regions.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

TILEMESH_HOST HomesLayout layout_homes(Setup const& c, RendererOptions const& options, Extent2 size, std::uint64_t records)
{
    if (c.district == 0) { // the smallest that fits; if none does, the error is that of single tiles
        auto const layout = [&](std::uint32_t side) {
            auto one = c;
            one.district = side;
            return layout_homes(one, options, size, records);
        };
        try {
            return layout(1);
        } catch (Error const&) {
            auto const grid = homes_grid(options);
            for (std::uint32_t side = 2; side < 2 * std::max(grid.width, grid.height) && side <= 1u << 15; side *= 2) {
                try {
                    return layout(side);
                } catch (Error const&) {
                }
            }
            throw;
        }
    }
    if ((c.district & (c.district - 1)) != 0)
        throw Error("districts of " + std::to_string(c.district) + " x " + std::to_string(c.district) +
                    " tiles (a side is a power of 2); choose 1, 2, 4, ..., or 0 for the smallest that fits");
    check_size(size.width, size.height);
    check_cut({options.grid, options.tile});
    auto const grid = homes_grid(options);
    if (std::uint64_t{grid.width} * grid.height > c.machine.tiles)
        throw Error("a grid of " + std::to_string(grid.width) + " x " + std::to_string(grid.height) + " tiles (" + c.machine.name + " has " +
                    std::to_string(c.machine.tiles) + "); choose a smaller grid or another machine");
    HomesLayout layout{grid, splat::homes::make_fold(size.width, size.height, grid, options.fold), c};
    auto const& fold = layout.fold;
    auto& sizes = layout.setup.sizes;
    auto const shift = splat::homes::district_shift(c.district);
    sizes.columns = splat::homes::districts(fold.x.tiles, shift);
    sizes.tiles = sizes.columns * splat::homes::districts(fold.y.tiles, shift);
    sizes.tile_blocks = fold.tile_blocks();
    sizes.tile_pixels = sizes.tile_blocks * splat::block_width * splat::block_height;
    if (c.fit) {
        // Homes for all records, and as many held splats as the rest of the SRAM has room for. If that leaves too few, the map comes in
        // chapters: tiles hold the most, and homes take the rest.
        auto const room_for = [&](std::uint32_t splat::Sizes::*list) { // slots of this list beside all others
            auto some = layout.setup;
            some.sizes.*list = 0;
            std::uint64_t const used = sram_bytes_of(some), most = c.machine.sram_bytes;
            some.sizes.*list = 1;
            return used < most ? (most - used) / (sram_bytes_of(some) - used) : 0;
        };
        auto const slots = [](std::uint64_t n) { return static_cast<std::uint32_t>(std::min<std::uint64_t>(n, 0x7fffffffu)); };
        std::uint32_t const most_held = sizes.storage;
        sizes.homes = slots(std::max<std::uint64_t>((records + grid.size() - 1) / grid.size(), 1));
        sizes.storage = slots(std::min<std::uint64_t>(most_held, room_for(&splat::Sizes::storage)));
        if (sizes.storage < std::min(options.held_slots != 0 ? options.held_slots : least_held, most_held)) {
            sizes.storage = most_held;
            sizes.homes = std::max(slots(room_for(&splat::Sizes::homes)), 1u);
        }
    }
    auto const bytes = sram_bytes_of(layout.setup);
    if (bytes > c.machine.sram_bytes) throw does_not_fit(c.machine, ledger_of(layout.setup), bytes);
    if (options.held_slots > sizes.storage)
        throw Error("a limit of " + std::to_string(options.held_slots) + " held splats (a tile has room for " + std::to_string(sizes.storage) +
                    "); choose 1 to " + std::to_string(sizes.storage));
    return layout;
}

TILEMESH_HOST RendererOptions within(Setup const& choice, RendererOptions options) noexcept
{
    options.channel_slots = std::min(options.channel_slots, choice.sizes.road);
    options.waiting_slots = std::min(options.waiting_slots, choice.sizes.waiting);
    options.storage_slots = std::min(options.storage_slots, choice.sizes.storage);
    return options;
}
TILEMESH_HOST void check_limits(Setup const& choice, RendererOptions const& options)
{
    auto const check = [](std::uint32_t asked, std::uint32_t most, char const* what) {
        if (asked > most)
            throw Error("a limit of " + std::to_string(asked) + " " + what + " (homes have at most " + std::to_string(most) + "); choose 1 to " +
                        std::to_string(most) + ", or 0 for no limit");
    };
    check(options.channel_slots, choice.sizes.road, "parcels in a channel");
    check(options.waiting_slots, choice.sizes.waiting, "parcels that wait");
    check(options.held_slots, choice.sizes.storage, "held splats");
    check(options.held_slots != 0 ? 0 : options.storage_slots, choice.sizes.storage, "held splats");
}

TILEMESH_HOST bool keeps_sizes(Setup const& c, RendererOptions options, Extent2 size, std::uint64_t records)
try {
    options.held_slots = 0;
    auto const layout = layout_homes(c, options, size, records);
    return layout.setup.sizes.storage >= c.sizes.storage && std::uint64_t{layout.setup.sizes.homes} * layout.grid.size() >= records;
} catch (Error const&) {
    return false;
}

TILEMESH_HOST Setup detail::fill_homes(Setup setup, Grid grid, Extent2 tile)
{
    RendererOptions options;
    options.grid = {grid.width, grid.height};
    auto const side = [](std::uint32_t tiles, std::uint32_t pixels) { // a product that is too large stays too large
        return static_cast<std::uint32_t>(std::min<std::uint64_t>(std::uint64_t{tiles} * pixels, 0xffffffffu));
    };
    setup.fit = false;
    setup.sizes.homes = 1;
    auto const one = layout_homes(setup, options, {side(grid.width, tile.width), side(grid.height, tile.height)}, 1).setup;
    auto full = one;
    fill(full, &splat::Sizes::homes, sram_bytes_of(one));
    setup.district = one.district;
    setup.sizes.homes = full.sizes.homes;
    return setup;
}

TILEMESH_HOST void take_districts(Setup& choice, std::uint32_t side)
{
    if (choice.district == 0) choice.district = side;
    if (choice.district == side) return;
    auto const by = [](std::uint32_t n) { return std::to_string(n) + " x " + std::to_string(n); };
    throw Error("a choice with districts of " + by(choice.district) + " tiles (the renderer's policies have " + by(side) +
                "); give both the same");
}

}}} // namespace tilemesh::render
