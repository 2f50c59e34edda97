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

/// What a user chose of a machine. An empty member is as the preset has it. Every combination runs, unless it does not fit.
struct Choice {
    Preset preset = Preset::lossless;
    MachineKind machine = MachineKind::mk2;
    EngineKind engine = EngineKind::threads;
    std::optional<SaturationKind> saturation{};
    std::optional<CopiesKind> copies{};
    std::optional<PixelKind> pixels{};
    bool depth = false, alpha = false;
    bool trace = false; ///< on a machine that keeps one
    bool fit = true;    ///< false: all that the preset has, whatever the scene needs

    bool planes() const noexcept { return depth || alpha; }
};

/// The setup of a choice for records of a degree. It may not fit: `tilemesh::render::facts_of` says so.
tilemesh::render::SetupChoice setup_of(Choice const& choice, std::uint32_t sh_degree);

using tilemesh::AnyRenderer;

/// The renderer of a choice (of one with `trace`, it is an `Instruments` too), as small as the demand allows where the choice leaves that
/// open. Throws `tilemesh::Error` for a choice, a map or limits that the machine has no room for.
std::unique_ptr<AnyRenderer> make_renderer(Choice const& choice, tilemesh::scene::Map const& map,
                                           tilemesh::scene::Demand const& demand, tilemesh::RendererOptions options);

} // namespace render_map
