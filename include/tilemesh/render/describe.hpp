#pragma once
#include <tilemesh/config.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/run_report.hpp>
#include <tilemesh/splat/rules.hpp>
#include <tilemesh/splat/setup.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// Fills what a report says of the setup that runs: machine, ledger and slots, preset, program, quality, policies, cut-offs, background, and
/// the value of every field. `rules`: those of the renderer, which options have changed.
TILEMESH_HOST void describe(report::RunReport& run, splat::Setup setup, splat::Rules const& rules, RendererOptions const& options);

}}} // namespace tilemesh::render

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/render/detail/describe_code.hpp>
#endif
