#pragma once
#include "rows.hpp"
#include <optional>
#include <string>
#include <utility>

/// One function for each table or figure of the paper's results. It appends its rows, and writes its picture if there is a folder for
/// pictures. If a map is missing, a table appends the paper's rows without ours.
namespace paper {

/// A row without our figure.
inline Row skipped(char const* table, std::string row, char const* quantity, std::optional<double> paper, char const* kind,
                   std::string const& why)
{
    return {table, std::move(row), quantity, paper, {}, kind, "skipped: " + why};
}

/// Bytes of each scene, the share of a scene that a tile's buffer holds, slots of channels and storage, and the ledgers of our presets.
void memory(Context const&, Rows&);
/// Modelled frames per second of the library's kernels against the number of Gaussians.
void fps(Context const&, Rows&);
/// Power times time: the paper's own arithmetic, and modelled times with the paper's power.
void power(Context const&, Rows&);
/// The number of Gaussians whose anchor tile changes between two frames, in six motions on Sloth.
void churn(Context const&, Rows&);
/// The number of Gaussians per tile in near, middle and far views.
void load(Context const&, Rows&);
/// Supersteps until all records and copies are on their tiles: after a cold start, and after the camera moved back.
void convergence(Context const&, Rows&);
/// Bytes between host and machine, and their share of the time.
void host_io(Context const&, Rows&);
/// Pictures of a dense scene with full channels; their holes are those of the list of dropped records. Beside each there is the complete
/// picture and a plan: tiles of the list in grey, pixels that differ in white.
void saturation(Context const&, Rows&);
/// The number of frames until a Gaussian whose anchor moved is on its tile.
void latency(Context const&, Rows&);

} // namespace paper
