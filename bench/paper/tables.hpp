#pragma once
#include "rows.hpp"
#include <optional>
#include <string>
#include <utility>

/// One function a table or figure of the paper's results: it appends its rows, and writes its picture where there is a folder
/// for it. A table that needs a map which is not there appends rows without ours.
namespace paper {

/// A row without ours.
inline Row skipped(char const* table, std::string row, char const* quantity, std::optional<double> paper, char const* kind,
                   std::string const& why)
{
    return {table, std::move(row), quantity, paper, {}, kind, "skipped: " + why};
}

/// Bytes of each scene, the share of one that a tile's buffer holds, slots of channels and storage, and our presets' ledgers.
void memory(Context const&, Rows&);
/// Modelled frames a second of our kernels against the number of Gaussians.
void fps(Context const&, Rows&);
/// Power times time: the paper's own arithmetic, and modelled times with the paper's power.
void power(Context const&, Rows&);
/// Gaussians whose anchor tile changes between two frames of six motions on Sloth.
void churn(Context const&, Rows&);
/// Gaussians a tile in near, middle and far views.
void load(Context const&, Rows&);
/// Supersteps until all records and copies are where they belong: after a cold start, and after the camera moved back.
void convergence(Context const&, Rows&);
/// Bytes between host and machine, and their share of the time.
void host_io(Context const&, Rows&);
/// Pictures of a dense scene with full channels, whose holes are those of the list of what was dropped; beside each the
/// complete one, and a plan: tiles of the list in grey, pixels that differ in white.
void saturation(Context const&, Rows&);
/// Frames until a Gaussian whose anchor moved is on its tile.
void latency(Context const&, Rows&);

} // namespace paper
