#pragma once
#include <cstdint>
#include <memory>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {
struct RendererOptions;
}}

namespace bench {

/// A record on a tile.
struct Stored {
    tilemesh::splat::GaussianId id;
    std::uint32_t tile; ///< index
    bool home;          ///< the record itself, on its anchor tile; false: a copy, or a record that must leave
};

/// A mesh that renders frame after frame on the host by reference, as `tilemesh::Renderer` does. One renderer is compiled for all setups.
class Machine {
public:
    virtual ~Machine() = default;
    /// Wakes the mesh's threads, as in a sequence of frames.
    virtual void wake(tilemesh::splat::Camera const&) = 0;
    virtual void render(tilemesh::splat::Camera const&) = 0;
    /// The picture and the report of the last frame.
    virtual tilemesh::report::Image const& image() const = 0;
    virtual tilemesh::report::FrameReport const& report() const = 0;
    /// Sets another bound on the hops per frame, after the first frame; 0: until quiet. Only for machines that were made with a bound.
    virtual void limit_hops(std::uint32_t hops) = 0;
    virtual std::vector<Stored> stored() = 0;
    virtual tilemesh::splat::Rules const& rules() const = 0;
    /// The trace of the last frame; only of `make_traced_machine`.
    virtual tilemesh::Trace const& trace() const = 0;
};
/// Throws Error if the setup does not fit into its machine, or if the options do not fit the setup.
std::unique_ptr<Machine> make_machine(tilemesh::scene::Map const&, tilemesh::render::Setup const&, tilemesh::RendererOptions const&);
std::unique_ptr<Machine> make_traced_machine(tilemesh::scene::Map const&, tilemesh::render::Setup const&, tilemesh::RendererOptions const&);

/// The cost model `mk2()`, and what a trace takes by it.
tilemesh::CostModel const& mk2_model();
double modelled_ms(tilemesh::Trace const&, tilemesh::Grid);

} // namespace bench
