#pragma once
#include <common/scenes.hpp>
#include <cstdint>
#include <filesystem>

/// A sequence of exact rays through a lens, mapped from nothing.
struct SequenceRow {
    std::uint32_t frames = 0, lost = 0;
    double ate = 0, psnr = 0; ///< world units, the camera centres pose by pose; of the map's pictures against exact rays, dB
};
/// `scene.camera`: the first pose, with its lens; the poses are those of fr1_xyz, relative to the first. Pictures have depth.
SequenceRow map_sequence(bench::Scene const& scene, std::filesystem::path const& data, std::uint32_t frames, std::uint32_t threads);
