#pragma once
#include "explain.hpp"
#include "options.hpp"
#include "shots.hpp"
#include <cstdint>
#include <string>
#include <tilemesh/report/run_report.hpp>
#include <vector>

namespace render_map {

/// Reads the file that --machine names, if it names one. Its grid becomes that of the run, unless --grid or --tile is given. Throws
/// `tilemesh::Error` for a file that is no machine, or that lacks a number that a run needs.
void load_machine(Options& options);

/// The machine that the options name. If they name no machine and no grid, and homes would take over: machine test for frames that have no room on mk2 with either
/// program. `notes` says so.
MachineKind machine_for(Options const& options, std::vector<Shot> const& shots, std::vector<std::string>& notes);

/// Tells the choice how many pixels a tile of the file's machine needs for the largest frame, and whether homes keep their sizes there with
/// `records` records of this degree. Notes what the file knows.
void fit_machine(Options& options, std::vector<Shot> const& shots, std::uint64_t records, std::uint32_t sh_degree, std::vector<std::string>& notes);

/// A note on the SRAM that the described run leaves free on the file's machine; empty if it is less than a tenth, or for another machine.
std::string free_sram(Options const& options, tilemesh::report::RunReport const& run);

/// Refuses frames that would fill the host's memory, and frames for which the default grid of the chosen machine has no framebuffers,
/// before a tile is built; and with --video, frames of different sizes. Throws `tilemesh::Error`, which says what to type instead.
void check_sizes(Options const& options, std::vector<Shot> const& shots);

/// Refuses --channel-slots and --storage-slots outside the range of this run's machine. The error explains the range and names options with
/// more room.
void check_slots(Options const& options, Needs const& needs);

/// Refuses --held, and with --program homes also --storage-slots and --channel-slots, outside the range of homes; and a machine on which homes
/// cannot divide one of the frames.
void check_homes(Options const& options, Needs const& needs, std::vector<Shot> const& shots);

/// An option that gives room for `slots` records on every tile, for example "--machine test (40,000 slots a tile)"; empty: there is none.
std::string roomier(Options const& options, Needs const& needs, std::uint64_t slots);

} // namespace render_map
