#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/trace_files.hpp>
#include <tilemesh/model/trace_maps.hpp>
#include <tilemesh/model/trace_section.hpp>

namespace tilemesh { inline namespace v0_2 {

/// The timeline of write_chrome_trace with as many of the 64 busiest tiles as fit into `most_bytes`; `note` says how many. Empty if even
/// the machine's own track does not fit.
TILEMESH_HOST std::string timeline_below(std::size_t most_bytes, Trace const& trace, CostModel const& model, Grid grid, std::string& note);

/// Writes a run of any program as files into `folder`, and makes the folder if it does not exist. All file names begin with `name`:
///   .html            a page for a browser: one sentence about the bottleneck, the picture and maps, cycles by step and over time, the
///                    slowest tile of each step and its operations, ideal routing, energy, the models
///   .tiles.csv       the trace by superstep and tile; .supersteps.csv: by superstep
///   .trace.json      a timeline for ui.perfetto.dev
///   .model.txt       the cost model; .maps.csv: the maps' numbers; .energy.csv: joules of each tile
/// Returns the page's path. Equal arguments give equal bytes. The cost model must have a source for every number (set_parameter,
/// set_price).
///
/// Throws `Error` for a folder or file that cannot be written, for a map without a number for every tile, and in the cases in which
/// write_cost_model, model_cost and energy_of throw it. Cost: memory for the texts, twice.
TILEMESH_HOST std::filesystem::path write_trace_page(std::filesystem::path const& folder, std::string const& name, Trace const& trace,
                                                     CostModel const& model, Grid grid, TracePage const& page = {});

/// Writes the page and the files of a run without a cost model: tile runs and sent messages, but no times. The files are .html, .tiles.csv
/// (without cycles) and .maps.csv. `page.energy` is not used, because energy needs modelled cycles.
///
/// Throws `Error` for a folder or file that cannot be written, for a map without a number for every tile, and for a trace of another grid.
TILEMESH_HOST std::filesystem::path write_trace_page(std::filesystem::path const& folder, std::string const& name,
                                                     Trace const& trace, Grid grid, TracePage const& page = {});

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/trace_page_code.hpp>
#endif
