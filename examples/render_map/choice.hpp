#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <tilemesh/any_renderer.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup_choice.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/map.hpp>

namespace render_map {

enum class Preset : std::uint32_t { lossless, paper, prototype };
enum class MachineKind : std::uint32_t { mk2, test };
enum class EngineKind : std::uint32_t { threads, sequential };
enum class SaturationKind : std::uint32_t { hold, drop };
enum class CopiesKind : std::uint32_t { world, screen };
enum class PixelKind : std::uint32_t { float32, rgbx8 };

/// What a user chose of a machine. An empty member takes the preset's value. Every combination runs if it fits.
struct Choice {
    Preset preset = Preset::lossless;
    MachineKind machine = MachineKind::mk2;
    EngineKind engine = EngineKind::threads;
    std::optional<SaturationKind> saturation{};
    std::optional<CopiesKind> copies{};
    std::optional<PixelKind> pixels{};
    bool depth = false, alpha = false;
    bool trace = false; ///< run on a machine that keeps a trace
    bool fit = true;    ///< false: keep all of the preset, whatever the scene needs

    bool planes() const noexcept { return depth || alpha; }
};

/// The setup of a choice for records of a degree. If it does not fit, `tilemesh::render::facts_of` throws.
tilemesh::render::SetupChoice setup_of(Choice const& choice, std::uint32_t sh_degree);

/// The setup that a demand leaves of a choice: without routing or bloom where the choice leaves that open and the scene needs neither.
tilemesh::render::SetupChoice setup_for(Choice const& choice, tilemesh::scene::Demand const& demand);

using tilemesh::AnyRenderer;

/// The renderer of `setup_for`. With `trace`, it is an `Instruments` too. Throws `tilemesh::Error` for a choice or a map that the machine
/// has no room for. The caller has checked the limits in the options (`check_slots`).
std::unique_ptr<AnyRenderer> make_renderer(Choice const& choice, tilemesh::scene::Map const& map,
                                           tilemesh::scene::Demand const& demand, tilemesh::RendererOptions options);

} // namespace render_map
