#include "machine.hpp"
#include "../shared/model_input.hpp"
#include "choice.hpp"
#include <algorithm>
#include <memory>
#include <tilemesh/model/machine_file.hpp>
#include <tilemesh/render/homes_layout.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/table.hpp>
#include <utility>

namespace render_map {

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
    for (auto const& shot : shots) {
        auto const tiling = tilemesh::tiling_for(options.renderer, shot.camera.width, shot.camera.height);
        auto const pixels = std::uint64_t{tiling.tile_width} * tiling.tile_height;
        options.choice.tile_pixels = std::max(options.choice.tile_pixels, static_cast<std::uint32_t>(std::min<std::uint64_t>(pixels, 0xfffffffeu)));
    }
    if (!options.channel_slots) {
        auto kept = options.choice;
        kept.keeps_homes = true;
        auto const homes = homes_of(kept, sh_degree);
        tilemesh::Extent2 last{};
        options.choice.keeps_homes = std::all_of(shots.begin(), shots.end(), [&](Shot const& shot) { // many shots have one size
            tilemesh::Extent2 const size{shot.camera.width, shot.camera.height};
            auto const before = std::exchange(last, size);
            return (size.width == before.width && size.height == before.height) || tilemesh::render::keeps_sizes(homes, options.renderer, size, records);
        });
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
    using tilemesh::report::thousands;
    return thousands(free) + " of a tile's " + thousands(run.machine.sram_bytes) + " bytes stay free: preset " + run.preset + " has no more than " +
           thousands(run.machine.storage_slots) + " slots of storage";
}

} // namespace render_map
