#pragma once
#include <cstdint>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>

namespace tilemesh { inline namespace v0_2 {

/// A renderer whose setup is chosen at run time. This header contains no kernel of the frame program, so code that only uses such a
/// renderer compiles quickly.
class AnyRenderer {
public:
    virtual ~AnyRenderer() = default;
    virtual RenderedFrame render(splat::Camera const& camera) = 0;
    virtual splat::Rules& rules() = 0;
    /// Names the demand to which the map was reduced. From now on `render` throws Error for a view that the demand does not cover, and it
    /// counts the records that were not loaded as parked.
    virtual void hold_to(scene::Demand const& demand) = 0;
    virtual scene::Map const& map() const = 0;            ///< the records that the renderer has; perhaps in another order
    virtual Extent2 grid() = 0;                           ///< tiles of the last frame; call `render` first
    virtual Extent2 tile() = 0;                           ///< pixels of a tile in the last frame; call `render` first

    virtual render::Setup const& setup() const = 0;       ///< with the sizes of the last frame

    /// The slots of one bloom channel. Without bloom: of one routing channel. Without both: 0.
    std::uint32_t channel_slots() const
    {
        auto const& s = setup();
        return s.program == splat::Program::homes ? s.sizes.road : s.blooms ? s.sizes.beam : s.routes ? s.sizes.road : 0;
    }
};

}} // namespace tilemesh
