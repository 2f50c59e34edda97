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
/// The anchored program that a Renderer runs: for these setups, on any engine of one process (PortMesh), with or without a trace.
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

/// The anchored program compiled for one setup type: what a Renderer cannot have, because its kernels are compiled once. These are policies of
/// your own, a program without what the setup leaves out, and engines that are types.
///
/// `S` is a setup (splat/setup_types.hpp): machine, policies, sizes. `Engine` is Mesh, CheckedMesh, PortMesh (engine/port.hpp), by value also
/// MpiMesh (mpi/mpi_mesh.hpp), or PoplarMesh (poplar/poplar_mesh.hpp), which runs the program on an IPU. With `splat::Referenced<S>` the
/// host moves references instead of records, as in a Renderer: pictures and reports are those of S, in a fraction of the time. Its digests
/// are those of the references, so they differ from the digests of values. Setups of the same policies share one `Core`. `Renderer` says
/// what a frame does and which errors there are.
template <class S = splat::Lossless, template <class, class> class Engine = Mesh>
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

#if defined(TILEMESH_COMPILED)
extern template class render::FrameRenderer<render::HostPolicies, PortMesh, Traced<AnyMachine>>;
extern template std::unique_ptr<engine::Port<render::HostRenderer::Program>>
make_threads_port(render::HostRenderer::Program const&, Grid, MeshSizes<render::HostRenderer::Program> const&, MeshOptions const&);
extern template std::unique_ptr<engine::Port<render::HostRenderer::Program>>
make_checked_port(render::HostRenderer::Program const&, Grid, MeshSizes<render::HostRenderer::Program> const&, MeshOptions const&);
#endif

}} // namespace tilemesh
