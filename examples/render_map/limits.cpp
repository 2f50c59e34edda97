#include "limits.hpp"
#include "../shared/model_input.hpp"
#include "../shared/text.hpp"
#include "choice.hpp"
#include <algorithm>
#include <initializer_list>
#include <memory>
#include <optional>
#include <tilemesh/error.hpp>
#include <tilemesh/model/machine_file.hpp>
#include <tilemesh/render/homes_layout.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <utility>

namespace render_map {

namespace {

namespace splat = tilemesh::splat;
using tilemesh::Error;
using tilemesh::Extent2;
using tilemesh::report::thousands;

std::string by(std::uint64_t width, std::uint64_t height)
{
    return std::to_string(width) + " x " + std::to_string(height);
}

/// "--size 1280x720"
std::string words(char const* option, Extent2 value)
{
    return std::string(option).append(" ") + std::to_string(value.width) + "x" + std::to_string(value.height);
}

/// The sizes of the shots. Many shots have one size; it is there once.
std::vector<Extent2> sizes_of(std::vector<Shot> const& shots)
{
    std::vector<Extent2> sizes;
    for (auto const& shot : shots)
        if (sizes.empty() || sizes.back().width != shot.camera.width || sizes.back().height != shot.camera.height)
            sizes.push_back({shot.camera.width, shot.camera.height});
    return sizes;
}

std::uint32_t parts(std::uint32_t size, std::uint32_t tile)
{
    return (size + tile - 1) / tile;
}

// --- the host's memory -------------------------------------------------------------------------

/// The bytes of a frame per pixel: framebuffers and picture take 12 each, and 4 more for each plane; of several frames, one picture is
/// written while the next is rendered. Then, one after the other, come the PNG encoder (3 of bytes, 3 filtered, 6 of a buffer that doubles,
/// 3 of its result), a PFM (12), a frame of the video (3), the reference (error_measures.hpp: 12 and 40), or the enclosure (middle and radius 52, 32
/// more with planes, a certificate 32, its causes 72). A bound adds a mesh's framebuffers and picture of 16 each, and 4 to sort.
std::uint64_t bytes_a_pixel(Options const& options, std::size_t frames)
{
    std::uint64_t const planes = (options.choice.depth ? 4u : 0u) + (options.choice.alpha ? 4u : 0u);
    bool const waits = options.reference || options.certify || options.bound || options.trace || frames == 1;
    return (waits ? 2 : 3) * (12 + planes) + (options.certify ? (planes != 0 ? 188 : 156) : options.reference ? 52 : 15) + (options.bound ? 36 : 0);
}

/// The limits for a frame: the memory of a small host. A tile in use takes some pages, about 18 KB, so 2^18 tiles take 5 GB.
constexpr std::uint64_t most_bytes = std::uint64_t{4} << 30, most_tiles = 1u << 18;

std::string gibibytes(std::uint64_t bytes)
{
    auto const tenths = (bytes * 10 + (1u << 29)) >> 30;
    return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " GiB";
}

void check_memory(Options const& options, Extent2 frame, std::size_t frames)
{
    auto const bytes = bytes_a_pixel(options, frames) * frame.width * frame.height;
    if (bytes > most_bytes)
        throw Error("a frame of " + by(frame.width, frame.height) + " pixels is too large (" +
                    (options.certify     ? "picture, framebuffers and the enclosure of the exact formula need "
                     : options.reference ? "picture, framebuffers and the reference in double need "
                                         : "picture, framebuffers and the PNG encoder need ") +
                    gibibytes(bytes) + ", and render_map takes at most " + gibibytes(most_bytes) +
                    "); choose a smaller --size" + (options.certify ? " or leave out --certify" : options.reference ? " or leave out --reference" : ""));

    auto const grid = options.renderer.grid, tile = options.renderer.tile;
    auto tiles = std::uint64_t{grid.width} * grid.height;
    if (grid.width == 0 && tile.width != 0)
        tiles = std::uint64_t{parts(frame.width, tile.width)} * parts(frame.height, tile.height);
    if (tiles > most_tiles)
        throw Error("a grid of " + thousands(tiles) + " tiles is too large (this program simulates at most " +
                    thousands(most_tiles) + "); choose larger tiles or a smaller --grid");
}

// --- framebuffers ------------------------------------------------------------------------------

constexpr Extent2 default_grid{40, 36};

/// The pixels of a tile if the frame is spread over the default grid.
Extent2 default_tile(Extent2 frame)
{
    return {parts(frame.width, default_grid.width), parts(frame.height, default_grid.height)};
}

/// The tile with the shortest border with which machine mk2 can hold the frame; 0 x 0 if there is none.
Extent2 tile_that_fits(Extent2 frame, std::uint32_t tile_pixels)
{
    Extent2 best;
    for (std::uint32_t width = 1; width <= std::min(frame.width, tile_pixels); ++width) {
        auto const height = std::min(frame.height, tile_pixels / width);
        auto const tiles = std::uint64_t{parts(frame.width, width)} * parts(frame.height, height);
        if (tiles <= tilemesh::Mk2::tiles && (best.width == 0 || width + height < best.width + best.height))
            best = {width, height};
    }
    return best;
}

/// Have the tiles of homes room for the pixels of a frame?
bool homes_have_room(Options const& options, Extent2 frame)
try {
    auto unlimited = options.renderer;
    unlimited.held_slots = 0;
    tilemesh::render::layout_homes(homes_of(options.choice, 0), unlimited, frame, 1);
    return true;
} catch (Error const&) {
    return false;
}

void check_framebuffers(Options const& options, Extent2 frame)
{
    static_assert(splat::Lossless::sizes.tile_pixels == splat::Paper::sizes.tile_pixels &&
                      splat::Lossless::sizes.tile_pixels == splat::Prototype::sizes.tile_pixels,
                  "one number for the presets");
    constexpr auto tile_pixels = splat::Lossless::sizes.tile_pixels;
    auto const fits = [](Extent2 size) {
        auto const tile = default_tile(size);
        return std::uint64_t{tile.width} * tile.height <= tile_pixels;
    };
    bool const decided = options.renderer.grid.width != 0 || options.renderer.tile.width != 0;
    if (options.choice.machine != MachineKind::mk2 || decided || fits(frame)) return;

    // The largest frame of this shape: the longer side loses one pixel at a time, and the other side follows.
    auto smaller = frame;
    auto const shrink = [](std::uint32_t& longer, std::uint32_t& shorter, std::uint64_t of_longer,
                           std::uint64_t of_shorter) {
        --longer;
        shorter = static_cast<std::uint32_t>((longer * of_shorter + of_longer - 1) / of_longer);
    };
    while (!fits(smaller)) {
        if (frame.width >= frame.height) shrink(smaller.width, smaller.height, frame.width, frame.height);
        else shrink(smaller.height, smaller.width, frame.height, frame.width);
    }
    auto const other = tile_that_fits(frame, tile_pixels);
    auto const tile = default_tile(frame);
    throw Error("a frame of " + by(frame.width, frame.height) + " pixels does not fit on machine mk2 (" +
                by(default_grid.width, default_grid.height) + " tiles would have " + by(tile.width, tile.height) +
                " pixels each, and the framebuffer of a tile has " + std::to_string(tile_pixels) + "); write " +
                (other.width != 0 ? words("--tile", other) + ", " : "") + words("--size", smaller) +
                (options.renderer.program == tilemesh::report::Program::anchored && homes_have_room(options, frame) ? ", --program homes" : "") +
                " or --machine test");
}

// --- slots -------------------------------------------------------------------------------------

using tilemesh::render::Setup;

bool fits(Setup const& setup)
{
    return tilemesh::render::sram_bytes_of(setup) <= setup.machine.sram_bytes;
}

/// The slots of the smallest channel end that a setup has.
std::uint32_t channel_slots_of(Setup const& setup)
{
    return setup.routes && setup.blooms ? std::min(setup.sizes.road, setup.sizes.beam) : setup.blooms ? setup.sizes.beam : setup.sizes.road;
}

/// Another choice, and the words to type for it.
struct Other {
    std::string words;
    Setup setup;
};
/// The setups that one more option would give: one of these presets, the test machine, or records without harmonics.
std::vector<Other> others(Options const& options, Needs const& needs, std::initializer_list<char const*> presets)
{
    std::vector<Other> list;
    auto const add = [&](std::string words, Choice const& choice, tilemesh::scene::Demand const& demand) {
        auto const setup = setup_for(choice, demand);
        if (fits(setup)) list.push_back({std::move(words), setup});
    };
    for (auto const* preset : presets)
        if (options.choice.preset() != preset) add(std::string("--preset ") + preset, options.choice.with_preset(preset), needs.used);
    auto choice = options.choice;
    choice.machine = MachineKind::test;
    if (options.choice.machine != MachineKind::test) add("--machine test", choice, needs.used);
    if (needs.used.sh_degree != 0) {
        auto demand = needs.used;
        demand.sh_degree = 0;
        add("--sh-degree 0", options.choice, demand);
    }
    return list;
}

} // namespace

void load_machine(Options& options)
{
    if (!options.machine) return;
    auto file = std::make_shared<tilemesh::MachineFile const>(
        shared::load_model(*options.machine, tilemesh::read_machine_file, "machine", "name mk2, test, or a file as examples/machines/bow.txt"));
    options.choice.file = size_of(*file);
    options.choice.channel_slots = options.channel_slots.value_or(0);
    auto const grid = grid_of(*file);
    if (options.renderer.grid.width == 0 && options.renderer.tile.width == 0 && grid) options.renderer.grid = {grid->width, grid->height};
    options.machine_file = std::move(file);
}

void fit_machine(Options& options, std::vector<Shot> const& shots, std::uint64_t records, std::uint32_t sh_degree, std::vector<std::string>& notes)
{
    if (!options.machine_file) return;
    auto const sizes = sizes_of(shots);
    for (auto const& size : sizes) {
        auto const tiling = tilemesh::tiling_for(options.renderer, size.width, size.height);
        auto const pixels = std::uint64_t{tiling.tile_width} * tiling.tile_height;
        options.choice.tile_pixels = std::max(options.choice.tile_pixels, static_cast<std::uint32_t>(std::min<std::uint64_t>(pixels, 0xfffffffeu)));
    }
    if (!options.channel_slots) {
        auto kept = options.choice;
        kept.keeps_homes = true;
        auto const homes = homes_of(kept, sh_degree);
        options.choice.keeps_homes = std::all_of(
            sizes.begin(), sizes.end(), [&](Extent2 size) { return tilemesh::render::keeps_sizes(homes, options.renderer, size, records); });
    }
    notes.push_back(machine_text(*options.machine_file));
}

std::string free_sram(Options const& options, tilemesh::report::RunReport const& run)
{
    std::uint64_t used = 0;
    for (auto const& region : run.machine.ledger) used += region.budgeted ? region.bytes : 0;
    if (!options.machine_file || used > run.machine.sram_bytes) return {};
    auto const free = run.machine.sram_bytes - used;
    if (free < run.machine.sram_bytes / 10) return {};
    return thousands(free) + " of a tile's " + thousands(run.machine.sram_bytes) + " bytes stay free: preset " + run.preset + " has no more than " +
           thousands(run.machine.storage_slots) + " slots of storage";
}

void check_homes(Options const& options, Needs const& needs, std::vector<Shot> const& shots)
{
    bool const homes = options.renderer.program == tilemesh::report::Program::homes;
    if (!homes && options.renderer.held_slots == 0) return;
    auto const choice = homes_of(options.choice, needs.used.sh_degree);
    auto unlimited = options.renderer;
    unlimited.held_slots = 0;
    std::uint32_t held = choice.sizes.storage;
    for (auto const& size : sizes_of(shots))
        held = std::min(held, tilemesh::render::layout_homes(choice, unlimited, size, needs.seen.gaussians - needs.used.culled).setup.sizes.storage);
    auto const check = [&](char const* option, std::optional<std::uint32_t> asked, std::uint32_t most, char const* what) {
        if (asked && (*asked == 0 || *asked > most))
            throw Error(std::string(option) + " cannot be " + std::to_string(*asked) + " (homes on machine " + choice.machine.name + " have 1 to " +
                        thousands(most) + " slots " + what + " for this map and frame); choose 1 to " + std::to_string(most));
    };
    if (options.renderer.held_slots != 0) check("--held", options.renderer.held_slots, held, "a tile");
    if (!homes) return;
    check("--storage-slots", options.storage_slots, held, "a tile");
    check("--channel-slots", options.channel_slots, choice.sizes.road, "a channel");
}

void check_slots(Options const& options, Needs const& needs)
{
    if (options.renderer.program == tilemesh::report::Program::homes) return; // check_homes
    auto const setup = setup_for(options.choice, needs.used);
    auto const slot = splat::slot_bytes(setup);
    auto const check = [&](std::string const& option, std::optional<std::uint32_t> asked, auto const& slots_of, std::string const& what,
                           std::uint64_t bytes) {
        auto const most = slots_of(setup);
        if (!asked || (*asked >= 1 && *asked <= most)) return;
        auto why = std::string("preset ") + setup.name + " on machine " + setup.machine.name + " has 1 to " + thousands(most) + " slots " + what +
                   " for records of degree " + std::to_string(setup.sh_degree) + ", in " + thousands(bytes) + " of a tile's " +
                   thousands(setup.machine.sram_bytes) + " bytes";
        auto const fitted = slots_of(setup_for(options.choice, needs.seen));
        if (needs.kept_because == option && fitted > most)
            why += "; without this option the machine is cut to what the scene needs and has " + thousands(fitted);
        auto remedy = "choose 1 to " + std::to_string(most);
        std::string separator = ", or what has room for " + thousands(*asked) + ": ";
        for (auto const& other : others(options, needs, {"lossless", "paper", "prototype"})) {
            if (*asked == 0 || slots_of(other.setup) < *asked) continue;
            remedy += separator + other.words;
            separator = " or ";
        }
        throw Error(option + " cannot be " + std::to_string(*asked) + " (" + why + "); " + remedy);
    };
    auto const& sizes = setup.sizes;
    check(
        "--storage-slots", options.storage_slots, [](Setup const& s) { return s.sizes.storage; },
        "of " + std::to_string(slot) + " bytes a tile", std::uint64_t{sizes.storage} * slot);
    // A channel has two ends on each of a tile's four sides.
    auto const road = setup.routes ? std::uint64_t{8} * sizes.road * splat::road_bytes(setup) : 0;
    auto const beam = setup.blooms ? std::uint64_t{8} * sizes.beam * splat::beam_bytes(setup) : 0;
    check("--channel-slots", options.channel_slots, channel_slots_of, "a channel", sizes.one_channel_memory ? std::max(road, beam) : road + beam);
}

std::string roomier(Options const& options, Needs const& needs, std::uint64_t slots)
{
    std::string text;
    auto const add = [&](std::string const& words, std::uint64_t has) {
        if (has >= slots) text += (text.empty() ? "" : ", or ") + words + " (" + thousands(has) + " slots a tile)";
    };
    auto const without = options.storage_slots ? " without --storage-slots" : "";
    // Of the presets only `lossless`: the others drop what finds a channel full.
    if (options.storage_slots) add("no --storage-slots", setup_for(options.choice, needs.used).sizes.storage);
    for (auto const& other : others(options, needs, {"lossless"})) add(other.words + without, other.setup.sizes.storage);
    return text;
}

MachineKind machine_for(Options const& options, std::vector<Shot> const& shots, std::vector<std::string>& notes)
{
    auto const machine = options.choice.machine;
    if (options.machine_named || options.choice.stays_anchored || options.renderer.grid.width != 0) return machine;
    auto const sizes = sizes_of(shots);
    auto const no_room = std::find_if(sizes.begin(), sizes.end(), [&](Extent2 size) { return !homes_have_room(options, size); });
    if (no_room == sizes.end()) return machine;
    notes.push_back("machine test (64 MiB a tile): a frame of " + by(no_room->width, no_room->height) + " pixels has no room on mk2");
    return MachineKind::test;
}

void check_sizes(Options const& options, std::vector<Shot> const& shots)
{
    auto const& first = shots.front();
    for (auto const& shot : shots) {
        auto const name = [](Shot const& s) { return shared::one_line(s.name, 100) + " has " + by(s.camera.width, s.camera.height); };
        if (options.video && (shot.camera.width != first.camera.width || shot.camera.height != first.camera.height))
            throw Error("--video needs frames of one size (" + name(first) + " pixels, " + name(shot) + "); " +
                        (options.photos ? "leave out --photos" : "add --size") + ", or name one camera with --camera");
        Extent2 const frame{shot.camera.width, shot.camera.height};
        check_memory(options, frame, shots.size());
        bool const homes = options.renderer.program == tilemesh::report::Program::homes;
        if (!homes && (options.choice.stays_anchored || !homes_have_room(options, frame))) check_framebuffers(options, frame);
        if (homes && options.renderer.grid.width == 0 && !homes_have_room(options, frame))
            throw Error("a frame of " + by(frame.width, frame.height) + " pixels does not fit on machine " + homes_of(options.choice, 0).machine.name +
                        " (the tiles of homes have no room for its pixels); choose a smaller --size or --machine test");
    }
}

} // namespace render_map
