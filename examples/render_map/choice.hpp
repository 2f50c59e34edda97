#pragma once
#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <tilemesh/render/homes_layout.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/render/setup_fields.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/map.hpp>
#include <vector>

namespace render_map {

enum class MachineKind : std::uint32_t { mk2, test, file };
enum class EngineKind : std::uint32_t { threads, sequential };

/// The user's choice of a machine. Every combination runs if it fits.
struct Choice {
    std::vector<tilemesh::render::SetupValue> fields; ///< the options that are fields of the setup, as given; others are those of the preset
    MachineKind machine = MachineKind::mk2;
    tilemesh::MachineSize file{};      ///< of MachineKind::file; Options::machine_file has its name. Without a name it is not read yet
    std::uint32_t tile_pixels = 0;     ///< of a file's machine: pixels of a tile in the largest frame
    std::uint32_t channel_slots = 0;   ///< of a file's machine: slots of a channel, if the user limits them
    bool keeps_homes = false;          ///< of a file's machine: the sizes of homes fit there with the whole map, so that they stay
    EngineKind engine = EngineKind::threads;
    bool depth = false, alpha = false;
    bool trace = false; ///< run on a machine that keeps a trace
    bool exact_rays = false; ///< in place of conics (exact_rays.hpp)
    bool stays_anchored = false; ///< the program of homes cannot take over: it is not asked for, or lacks an option
    bool fit = true;    ///< false: keep all parts of the preset, even if the scene does not need them

    bool planes() const noexcept { return depth || alpha; }
    bool names(std::string_view field) const
    {
        return std::any_of(fields.begin(), fields.end(), [&](auto const& f) { return f.name == field; });
    }
    std::string preset() const { return with(tilemesh::splat::lossless, fields).name; }
    Choice with_preset(std::string_view preset) const
    {
        auto other = *this;
        other.fields.emplace_back("preset", preset);
        return other;
    }
};

/// The setup of a choice for records of a degree. `tilemesh::render::check_setup` throws if it does not fit.
tilemesh::render::Setup setup_of(Choice const& choice, std::uint32_t sh_degree);

/// The setup of a choice, reduced by a demand: without routing or bloom if the choice allows it and the scene does not need them.
tilemesh::render::Setup setup_for(Choice const& choice, tilemesh::scene::Demand const& demand);

/// The choice for the program of homes: the preset's machine, pixels and rules of the picture, with homes for as many records as fit.
tilemesh::render::Setup homes_of(Choice const& choice, std::uint32_t sh_degree);

/// Makes the renderer of `setup_for`, of homes, or of both (`options.program`). Map and demand must outlive it. Over several processes it does
/// not look at `map`: each has its part (ranks.hpp). Throws `tilemesh::Error` if the machine has no room for the choice or the map. The
/// caller must have checked the limits in the options (`check_slots`).
std::unique_ptr<tilemesh::Renderer> make_renderer(Choice const& choice, tilemesh::scene::Map const& map,
                                                  tilemesh::scene::Demand const& demand, tilemesh::RendererOptions options);

} // namespace render_map
