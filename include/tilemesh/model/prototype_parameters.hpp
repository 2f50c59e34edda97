#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/model/cost_parameters.hpp>

namespace tilemesh { inline namespace v0_2 {

/// The authors' prototype on Mk2. Apply it to a trace of a program that counts the prototype's work: it looks at every slot of every
/// buffer, routes records on one worker, and moves them one hop a frame (bench/paper has this program). The prices of a slot, an arrival, a
/// projection, a comparison and a Gaussian-pixel pair are fitted: with them the program takes the times of the paper's stage table
/// ("Per-stage execution time by scene") on the map Salad. No other map took part in the fit. The times are milliseconds of that table at
/// the paper's clock. The prototype's code seems to convert cycles at 1.85 GHz. If so, the true times of all stages except blending are
/// 1.40 times as long.
///
/// Do not use it for the kernels of this library, which look at live slots only: use `mk2()` for them.
TILEMESH_HOST CostModel mk2_prototype();

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#    include <tilemesh/model/detail/prototype_parameters_code.hpp>
#endif
