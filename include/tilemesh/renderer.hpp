#pragma once
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/render/frame_renderer.hpp>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <type_traits>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

/// Renders a map on a mesh of tiles, frame after frame. It loads the map's records onto the tiles once, then runs the frame program for
/// each camera. Records and copies stay on their tiles between frames. So a small step of the camera moves few records, and a static view
/// moves none.
///
/// `S` is a setup (splat/setup.hpp): machine, policies, sizes. `Engine` is Mesh, CheckedMesh, or PoplarMesh (poplar/poplar_mesh.hpp), which
/// runs the program on an IPU. With `splat::Referenced<S>` the host moves references instead of records, and projects each record once per
/// view: pictures and reports are those of S, in a fraction of the time. Its digests are those of the references, so they differ from the
/// digests of values. All setups by reference share the code of one renderer, with these exceptions: setups with planes, setups without
/// routing or bloom, and setups with their own routing or blending.
///
/// Errors: it throws Error if the frame, the grid or the map does not fit the machine, or if a limit is out of range. A record that finds
/// no room while a frame runs is not an error: the frame's report lists it by id and cause. With `Hold`, a record whose anchor tile is full
/// goes back to the host, which puts it onto the mesh again for the next view. With `Drop` the record is lost, as on the paper's machine.
/// If an unplaced record left copies on other tiles, the host recalls them and the frame is composited again, so that the picture shows a
/// record whole or not at all. After an exception (also std::bad_alloc), the next frame builds a new mesh and loads the map.
template <class S = splat::Lossless, template <class, class> class Engine = Mesh>
class BasicRenderer
    : public render::FrameRenderer<splat::PoliciesOf<S>, Engine,
                                   std::conditional_t<is_traced<typename S::Machine>, Traced<AnyMachine>, AnyMachine>> {
public:
    /// The renderer that all setups with these policies share.
    using Core = render::FrameRenderer<splat::PoliciesOf<S>, Engine,
                                       std::conditional_t<is_traced<typename S::Machine>, Traced<AnyMachine>, AnyMachine>>;
    using Setup = S;
    using Value = typename splat::ValueOf<S>::type;
    using Machine = typename S::Machine;
    using Layout = Tile<Machine, splat::Frame<Value>, Value>; ///< a tile of the machine that S simulates
    using typename Core::EngineOptions;

    /// `engine`: the engine's other options. The renderer sets its threads and digest from `options`.
    explicit BasicRenderer(scene::Map const& map, RendererOptions options = {}, EngineOptions engine = {})
        : Core(map, render::facts_of<Value>(options), options, std::move(engine))
    {
    }
};

/// The default: `lossless` on Mk2, on host threads, by reference.
using Renderer = BasicRenderer<splat::Referenced<splat::Lossless>>;

namespace render {
/// The policies of all setups by reference that route and bloom, use the library's blending and have no planes. They serve every preset on
/// every machine, with records of any degree. The second set serves setups with a depth plane, an alpha plane, or both.
using HostPolicies = splat::PoliciesOf<splat::Referenced<splat::Lossless>>;
using HostPoliciesWithPlanes =
    splat::PoliciesOf<splat::Referenced<splat::WithPixel<splat::Lossless, splat::WithAlpha<splat::WithDepth<splat::FloatPixel>>>>>;
} // namespace render

#if defined(TILEMESH_COMPILED)
extern template class render::FrameRenderer<render::HostPolicies, Mesh, AnyMachine>;
extern template class render::FrameRenderer<render::HostPolicies, Mesh, Traced<AnyMachine>>;
extern template class render::FrameRenderer<render::HostPoliciesWithPlanes, Mesh, AnyMachine>;
#endif

}} // namespace tilemesh
