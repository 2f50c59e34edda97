#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/splat/rules.hpp>
#include <tilemesh/splat/quality.hpp>
#include <tilemesh/splat/setup.hpp>
#include <tilemesh/splat/view.hpp>

namespace tilemesh { inline namespace v0_2 {

namespace render {
/// An engine of this process: host threads (Mesh), or one thread that checks every rule of the machine (CheckedMesh).
enum class EngineKind : std::uint32_t { threads, checked };
} // namespace render

/// Options of a Renderer. 0 means: the setup's value.
struct RendererOptions {
    std::uint32_t threads = 1;
    Extent2 grid{};                          ///< tiles; 0: it follows from frame and tile, or is 40 x 36
    Extent2 tile{};                          ///< pixels; 0: the frame is spread evenly over the grid
    std::uint32_t hops = 0;                  ///< a limit for the exchanges of routing, and for those of bloom, per frame; 0: until quiet
    std::uint32_t channel_slots = 0;         ///< a limit, at most the setup's
    std::uint32_t waiting_slots = 0;         ///< a limit for each of routing's FIFOs, at most the setup's
    std::uint32_t storage_slots = 0;         ///< a limit, at most the setup's
    std::optional<splat::Footprint> footprint{};
    std::optional<splat::Arithmetic> arithmetic{};
    std::optional<splat::Coverage> coverage{}; ///< `preserved` for maps that were trained with anti-aliasing
    std::optional<splat::Quality> quality{};  ///< `rules()` begins with the rules of this quality instead of the setup's
    std::optional<std::array<float, 3>> background{}; ///< linear RGB, 0 to 1, behind every picture; black if it is not given
    bool digest = false;
    /// A limit for the passes of routing, and for those of bloom, in a run. A frame that needs more passes throws Error
    /// (MeshOptions::most_passes). 0: the limit in the engine's own options. Engines without such a limit (PoplarMesh) ignore it.
    std::uint32_t most_passes = 0;
    report::Program program = report::Program::anchored; ///< of a setup that does not name another one
    render::EngineKind engine = render::EngineKind::threads;
    bool trace = false; ///< keep a trace of the last frame
    /// Only for the program of homes: a limit for its rounds; 0: until the picture is complete. `fold`: the frame is folded over the grid.
    std::uint32_t rounds = 0;
    bool fold = true;
    std::uint32_t held_slots = 0;            ///< only for homes: a limit for the splats that a tile holds; 0: `storage_slots`
    /// Sizes that replace the setup's. The renderer throws Error if they do not fit into a tile's SRAM.
    std::optional<splat::Sizes> sizes{};
    /// A tile whose splats and view did not change keeps its pixels (render/kept_pixels.hpp). false: every tile composites in every frame.
    /// Pictures, counters, digests and traces do not depend on it. Renderers by value and engines other than Mesh and CheckedMesh ignore
    /// it and composite.
    bool keep_pixels = true;
    /// Only on an engine over several processes (MpiMesh). Above 0: the map that the renderer gets is this process's part of a map of so many
    /// rows. Parts follow one another in the order of the processes, and may be empty. Results are those of the whole map. The constructor
    /// checks this process's part only. 0: every process gives the whole map, and the renderer keeps an equal share of it.
    std::uint32_t rows_of_all_parts = 0;

    friend bool operator==(RendererOptions const&, RendererOptions const&) = default;
};

/// The rules with which a renderer begins: the setup's, changed by the options. A footprint that the options name replaces that of
/// their quality.
inline splat::Rules with_options(splat::Rules rules, RendererOptions const& options) noexcept
{
    if (options.quality) rules = splat::with_quality(rules, *options.quality);
    if (options.footprint) rules.footprint = *options.footprint;
    if (options.arithmetic) rules.arithmetic = *options.arithmetic;
    if (options.coverage) rules.coverage = *options.coverage;
    for (std::size_t c = 0; options.background && c < 3; ++c) rules.background[c] = (*options.background)[c];
    return rules;
}

/// The division of a frame into tiles: by `tile` if it is given, otherwise evenly over `grid`, or over 40 x 36 tiles if both are zero.
inline splat::Tiling tiling_for(RendererOptions const& options, std::uint32_t width, std::uint32_t height) noexcept
{
    return render::tiling_for({options.grid, options.tile}, width, height);
}

}} // namespace tilemesh
