#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/fit_renderer.hpp>
#include <vector>

namespace render_map {

enum class Preset : std::uint32_t { lossless, paper, prototype };
enum class MachineKind : std::uint32_t { mk2, test };
enum class EngineKind : std::uint32_t { threads, sequential };
enum class SaturationKind : std::uint32_t { hold, drop };
enum class CopiesKind : std::uint32_t { world, screen };
enum class PixelKind : std::uint32_t { float32, rgbx8 };

/// Which compiled setup to run. What is empty is as the preset has it.
struct Choice {
    Preset preset = Preset::lossless;
    MachineKind machine = MachineKind::mk2;
    EngineKind engine = EngineKind::threads;
    std::optional<SaturationKind> saturation{};
    std::optional<CopiesKind> copies{};
    std::optional<PixelKind> pixels{};
    bool depth = false, alpha = false; ///< with the preset's own policies, on host threads; parse_options refuses the rest

    bool trace = false;                ///< on a machine that keeps one: the same restrictions, and mk2, degree 0 and no planes
    bool fit = true;                   ///< false: all that the preset has, whatever the scene needs

    bool planes() const noexcept { return depth || alpha; }
};

/// What a choice means: names for the report, the ledger of a tile, and the capacities that the user's limits may not exceed.
struct Description {
    std::string preset, machine;
    std::string routing, addressing, saturation, copies, pixels;
    std::uint32_t sram_bytes = 0;
    std::vector<tilemesh::Region> ledger;
    std::uint32_t storage_slots = 0, channel_slots = 0;
    tilemesh::splat::Footprint footprint{};
    tilemesh::splat::Arithmetic arithmetic{};
};
Description describe(Choice const& choice);

using tilemesh::AnyRenderer;

/// The renderer of a choice (of one with `trace`, it is an `Instruments` too), as small as the demand allows where the choice leaves that open. Throws `tilemesh::Error` for a
/// map or limits that the setup has no room for, and for harmonics with a choice that is not compiled for them.
std::unique_ptr<AnyRenderer> make_renderer(Choice const& choice, tilemesh::scene::Map const& map,
                                           tilemesh::scene::Demand const& demand, tilemesh::RendererOptions options);

} // namespace render_map
