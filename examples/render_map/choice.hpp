#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/renderer.hpp>
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
};
Description describe(Choice const& choice);

/// A BasicRenderer whose setup and engine were chosen at run time.
class AnyRenderer {
public:
    virtual ~AnyRenderer() = default;
    virtual tilemesh::RenderedFrame render(tilemesh::splat::Camera const& camera) = 0;
    virtual tilemesh::splat::Model const& model() const = 0;
    virtual tilemesh::Extent2 grid() = 0; ///< tiles; of the last frame
    virtual tilemesh::Extent2 tile() = 0; ///< pixels; of the last frame
};

/// Throws `tilemesh::Error` for a map or limits that the setup has no room for.
std::unique_ptr<AnyRenderer> make_renderer(Choice const& choice, tilemesh::scene::Map const& map,
                                           tilemesh::RendererOptions options);

} // namespace render_map
