#pragma once
#include "choice.hpp"
#include "options.hpp"
#include "shots.hpp"
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/map.hpp>
#include <vector>

/// The processes of a run, `mpirun -n 4 render_map ...`. The first process reads the arguments, and writes everything. Each process reads its
/// part of the map. The others wait for the first one's orders and render their share of the tiles. In a build without MPI there is one
/// process (without_ranks.cpp).
namespace render_map::ranks {

/// Begins MPI. In the first process it returns nothing. In any other process it serves the first one until the end of the run, and returns
/// the exit status of the run.
std::optional<int> begin(int& argc, char**& argv);

/// Ends MPI in all processes, which then exit with this status. Returns the status.
int end(int status);

/// The processes of the run, and those of them that share this process's host.
std::uint32_t number() noexcept;
std::uint32_t on_this_host() noexcept;

/// What the first of several processes asks of all. It calls these functions, and the others do their part. What fails in any of them is an
/// Error here.
class Parts {
public:
    /// Loads the map of the options into all processes, with --turn. Each reads its share of the rows of one PLY file. Of several files, or of
    /// another format, this process reads all rows with `load_all` and sends the others their shares. Returns the map without its rows: the
    /// name, the degree, the notes and the number of rejected rows.
    virtual tilemesh::scene::Map load(Options const& options, std::function<tilemesh::scene::Map()> const& load_all) = 0;

    /// The Gaussians of the whole map, and its shape. `shape_of` sends 24 bytes for each Gaussian to this process, once it is asked.
    virtual std::uint64_t gaussians() = 0;
    virtual MapShape shape_of(std::string name) = 0;

    /// Cuts the harmonics of all parts (scene::at_degree).
    virtual void at_degree(std::uint32_t degree) = 0;

    /// scene::demand_of the whole map. `visible` is of this process's part.
    virtual tilemesh::scene::Demand demand_of(std::vector<tilemesh::splat::Camera> const& path, tilemesh::splat::Rules const& rules,
                                              tilemesh::RendererOptions const& options) = 0;

    /// Makes a renderer on all processes for a demand: that of homes, or for any other program that of anchored tiles. The demand is that of the
    /// last `demand_of`, or that one with all rows visible.
    virtual std::unique_ptr<tilemesh::render::Core> make(tilemesh::report::Program program, Choice const& choice,
                                                         tilemesh::scene::Demand const& demand, tilemesh::RendererOptions const& options) = 0;

protected:
    ~Parts() = default;
};
/// Throws `tilemesh::Error` in a build without MPI.
Parts& parts();

} // namespace render_map::ranks
