#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/homes_choice.hpp>
#include <tilemesh/render/setup_choice.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace render {

TILEMESH_HOST HomesLedger::HomesLedger(HomesChoice const& c, splat::homes::Sizes const& sizes)
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
    add(homes::Blocks<homes::NarrowBlock>::name, "state",
        list(sizes.tile_blocks, c.depth ? sizeof(homes::WideBlock) : sizeof(homes::NarrowBlock)));
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
TILEMESH_HOST void HomesLedger::add(char const* name, char const* what, std::uint64_t region_bytes)
{
    lines.push_back({as_name(name), what, static_cast<std::uint32_t>(std::min<std::uint64_t>(region_bytes, 0xffffffffu)), true});
    bytes += region_bytes;
}

TILEMESH_HOST HomesLayout layout_homes(HomesChoice const& c, RendererOptions const& options, Extent2 size, std::uint64_t records)
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
    auto const fold = splat::homes::make_fold(size.width, size.height, grid, options.fold);
    auto sizes = c.sizes;
    auto const shift = splat::homes::district_shift(c.district);
    sizes.columns = splat::homes::districts(fold.x.tiles, shift);
    sizes.tiles = sizes.columns * splat::homes::districts(fold.y.tiles, shift);
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
    return {grid, fold, sizes, std::move(ledger), c.district};
}

TILEMESH_HOST RendererOptions within(HomesChoice const& choice, RendererOptions options) noexcept
{
    options.channel_slots = std::min(options.channel_slots, choice.sizes.parcels);
    options.waiting_slots = std::min(options.waiting_slots, choice.sizes.waiting);
    options.storage_slots = std::min(options.storage_slots, choice.sizes.held);
    return options;
}
TILEMESH_HOST void check_limits(HomesChoice const& choice, RendererOptions const& options)
{
    auto const check = [](std::uint32_t asked, std::uint32_t most, char const* what) {
        if (asked > most)
            throw Error("a limit of " + std::to_string(asked) + " " + what + " (homes have at most " + std::to_string(most) + "); choose 1 to " +
                        std::to_string(most) + ", or 0 for no limit");
    };
    check(options.channel_slots, choice.sizes.parcels, "parcels in a channel");
    check(options.waiting_slots, choice.sizes.waiting, "parcels that wait");
    check(options.held_slots, choice.sizes.held, "held splats");
    check(options.held_slots != 0 ? 0 : options.storage_slots, choice.sizes.held, "held splats");
}

TILEMESH_HOST HomesChoice fill_storage(HomesChoice c, Grid grid, Extent2 tile)
{
    RendererOptions options;
    options.grid = {grid.width, grid.height};
    auto const side = [](std::uint32_t tiles, std::uint32_t pixels) { // a product that is too large stays too large
        return static_cast<std::uint32_t>(std::min<std::uint64_t>(std::uint64_t{tiles} * pixels, 0xffffffffu));
    };
    c.fit = false;
    c.sizes.homes = 1;
    auto const one = layout_homes(c, options, {side(grid.width, tile.width), side(grid.height, tile.height)}, 1);
    c.district = one.district;
    auto two = one.sizes;
    two.homes = 2;
    auto const slot = HomesLedger(c, two).bytes - one.ledger.bytes;
    c.sizes.homes = static_cast<std::uint32_t>(std::min<std::uint64_t>(1 + (c.machine.sram_bytes - one.ledger.bytes) / slot, 0x7fffffffu));
    return c;
}

TILEMESH_HOST HomesChoice on_machine(HomesChoice c, MachineSize const& machine, std::uint32_t channel_slots)
{
    for (auto* slots : {&c.sizes.parcels, &c.sizes.waiting})
        *slots = channel_slots == 0 ? detail::shrunk(*slots, c.machine, machine) : std::min(*slots, channel_slots);
    c.machine = machine;
    return c;
}

TILEMESH_HOST bool keeps_sizes(HomesChoice const& c, RendererOptions options, Extent2 size, std::uint64_t records)
try {
    options.held_slots = 0;
    auto const layout = layout_homes(c, options, size, records);
    return layout.sizes.held >= c.sizes.held && std::uint64_t{layout.sizes.homes} * layout.grid.size() >= records;
} catch (Error const&) {
    return false;
}

TILEMESH_HOST void take_districts(HomesChoice& choice, std::uint32_t side)
{
    if (choice.district == 0) choice.district = side;
    if (choice.district == side) return;
    auto const by = [](std::uint32_t n) { return std::to_string(n) + " x " + std::to_string(n); };
    throw Error("a choice with districts of " + by(choice.district) + " tiles (the renderer's policies have " + by(side) +
                "); give both the same");
}

TILEMESH_HOST SetupFacts facts_of(HomesChoice const& c, splat::homes::Sizes const& sizes, HomesLedger const& ledger)
{
    SetupFacts f{};
    f.name = c.name;
    f.machine = c.machine;
    f.policies = {1, 1, 0, sizeof(splat::homes::Parcel<splat::Splat>), sizeof(splat::homes::Parcel<splat::Splat>)};
    f.sizes.storage = sizes.held;
    f.sizes.road = f.sizes.beam = sizes.parcels;
    f.sizes.waiting = sizes.waiting;
    f.sizes.tile_pixels = sizes.tile_pixels;
    f.sh_degree = c.sh_degree;
    f.record_bytes = static_cast<std::uint32_t>(sizeof(splat::Gaussian)) + 12 * splat::harmonics_per_channel(c.sh_degree);
    f.colour = c.colour;
    f.routes = f.blooms = true;
    f.has_depth = c.depth;
    f.has_alpha = c.alpha;
    f.rules = c.rules;
    f.sram_bytes = ledger.bytes;
    f.ledger = ledger.lines;
    return f;
}

}}} // namespace tilemesh::render
