#pragma once
#include <memory>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/engine/port.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/render/frame_renderer.hpp>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <type_traits>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

namespace render {
/// The policies that serve all setups by reference with the library's routing, blending and colours: every preset on every machine, with
/// records of any degree, with or without planes, routing and bloom.
using HostPolicies = splat::PoliciesOf<splat::HostSetup<splat::Lossless>>;
/// The renderer that serves these setups, on any engine of one process (PortMesh), with or without a trace. It is the one renderer of the
/// anchored program in the compiled library.
using HostRenderer = FrameRenderer<HostPolicies, PortMesh, Traced<AnyMachine>>;
} // namespace render

namespace detail {
/// The renderer of setup S on an engine.
template <class S, template <class, class> class Engine>
struct CoreOf {
    using type = render::FrameRenderer<splat::PoliciesOf<S>, Engine,
                                       std::conditional_t<is_traced<typename S::Machine>, Traced<AnyMachine>, AnyMachine>>;
};
/// A setup with policies of its own has no port: it renders on threads.
template <class S>
struct CoreOf<S, PortMesh> : CoreOf<S, Mesh> {};
template <class S>
    requires splat::is_served_by_words<S>
struct CoreOf<S, PortMesh> {
    using type = render::HostRenderer;
};
} // namespace detail

/// Renders a map on a mesh of tiles, frame after frame. It loads the map's records onto the tiles once, then runs the frame program for
/// each camera. Records and copies stay on their tiles between frames. So a small step of the camera moves few records, and a static view
/// moves none.
///
/// `S` is a setup (splat/setup_types.hpp): machine, policies, sizes. `Engine` is Mesh, CheckedMesh, PortMesh (engine/port.hpp), by value also
/// MpiMesh (mpi/mpi_mesh.hpp), or PoplarMesh (poplar/poplar_mesh.hpp), which runs the program on an IPU. With `splat::Referenced<S>` the
/// host moves references instead of records, and projects each record once per view: pictures and reports are those of S, in a fraction of
/// the time. Its digests are those of the references, so they differ from the digests of values.
///
/// With the compiled library (TILEMESH_COMPILED), the default engine is PortMesh: all setups by reference share the library's renderer
/// (render::HostRenderer), except setups with their own routing or blending, and a program compiles no kernel. With headers alone the
/// default is Mesh: a renderer is compiled for its setup, without what the setup leaves out. Setups by reference share that renderer's code,
/// except setups with planes, without routing or bloom, or with their own routing or blending. Results are equal.
///
/// Errors: it throws Error if the frame, the grid or the map does not fit the machine, if the map has a higher degree of harmonics than the
/// setup's records (scene::at_degree drops the rest), if two records have one id, or if a limit is out of range. A record that finds
/// no room while a frame runs is not an error: the frame's report lists it by id and cause. With `Hold`, a record whose anchor tile is full
/// goes back to the host, which puts it onto the mesh again for the next view. With `Drop` the record is lost, as on the paper's machine.
/// If an unplaced record left copies on other tiles, the host recalls them and the frame is composited again, so that the picture shows a
/// record whole or not at all. After an exception (also std::bad_alloc), the next frame builds a new mesh and loads the map.
#if defined(TILEMESH_COMPILED)
template <class S = splat::Lossless, template <class, class> class Engine = PortMesh>
#else
template <class S = splat::Lossless, template <class, class> class Engine = Mesh>
#endif
class BasicRenderer : public detail::CoreOf<S, Engine>::type {
public:
    /// The renderer that all setups with these policies share.
    using Core = typename detail::CoreOf<S, Engine>::type;
    using Setup = S;
    using Value = typename splat::ValueOf<S>::type;
    using Machine = typename S::Machine;
    using Layout = Tile<Machine, splat::Frame<Value>, Value>; ///< a tile of the machine that S simulates
    using typename Core::EngineOptions;

    /// `engine`: the engine's other options. The renderer sets its threads and digest from `options`.
    explicit BasicRenderer(scene::Map map, RendererOptions options = {}, EngineOptions engine = {})
        : Core(std::move(map), render::setup_for<Value>(options), options, for_machine(std::move(engine)))
    {
    }

private:
    static EngineOptions for_machine(EngineOptions engine)
    {
        if constexpr (std::is_same_v<Core, render::HostRenderer>) engine.trace = engine.trace || is_traced<Machine>;
        return engine;
    }
};

/// The default: `lossless` on Mk2, on host threads, by reference.
using Renderer = BasicRenderer<splat::Referenced<splat::Lossless>>;

#if defined(TILEMESH_COMPILED)
extern template class render::FrameRenderer<render::HostPolicies, PortMesh, Traced<AnyMachine>>;
extern template render::Prefetched
render::FrameRenderer<render::HostPolicies, PortMesh, Traced<AnyMachine>>::prefetch<render::HostPolicies>(splat::Camera const&);
extern template std::unique_ptr<engine::Port<render::HostRenderer::Program>>
make_threads_port(render::HostRenderer::Program const&, Grid, MeshSizes<render::HostRenderer::Program> const&, MeshOptions const&);
extern template std::unique_ptr<engine::Port<render::HostRenderer::Program>>
make_checked_port(render::HostRenderer::Program const&, Grid, MeshSizes<render::HostRenderer::Program> const&, MeshOptions const&);
#endif

}} // namespace tilemesh
