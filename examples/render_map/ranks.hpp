#pragma once
#include "choice.hpp"
#include <cstdint>
#include <memory>
#include <optional>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/map.hpp>

/// The processes of a run, `mpirun -n 4 render_map ...`. The first process reads the arguments and the map, and writes everything. The
/// others wait for its orders and render their share of the tiles. In a build without MPI there is one process (without_ranks.cpp).
namespace render_map::ranks {

/// Begins MPI. In the first process it returns nothing. In any other process it serves the first one until the end of the run, and returns
/// the exit status of the run.
std::optional<int> begin(int& argc, char**& argv);

/// Ends MPI in all processes, which then exit with this status. Returns the status.
int end(int status);

/// The processes of the run, and those of them that share this process's host.
std::uint32_t number() noexcept;
std::uint32_t on_this_host() noexcept;

/// Makes a renderer on all processes: `make_renderer` for the program of anchored tiles. Only with several processes.
std::unique_ptr<AnyRenderer> make(Choice const& choice, tilemesh::scene::Map needed, tilemesh::scene::Demand const& demand,
                                  tilemesh::RendererOptions const& options);

} // namespace render_map::ranks
