#pragma once
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/step_costs.hpp>
#include <tilemesh/report/stacked_bars.hpp>
#include <vector>

/// Diagrams of the modelled time of a run of any program, as SVG.
namespace tilemesh { inline namespace v0_2 {

/// The modelled time by step: a bar for each step of the program, in milliseconds, as SVG.
TILEMESH_HOST std::string steps_svg(CostModel const& model, std::vector<StepCost> const& steps);

/// The steps over modelled time: one span each time a step ran, with the step's name. If there are more than 40 spans, each round of an
/// outermost Loop becomes one span, with its number. If these are more than 40 too, or one, or cannot be told apart (loop_rounds), rounds
/// that follow each other become one span, whose name names the steps.
TILEMESH_HOST std::vector<report::BarSpan> step_spans(Trace const& trace, CostModel const& model, RunCost const& cost);

/// The run over modelled time as SVG: the number of busy tiles, and the step that runs. An area is tile time. Supersteps too thin to be
/// seen share a bar with their neighbours, so that there are about 400 bars. Cost: one pass over the trace; no memory per tile.
TILEMESH_HOST std::string supersteps_svg(Trace const& trace, CostModel const& model, RunCost const& cost, Grid grid);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/trace_diagrams_code.hpp>
#endif
