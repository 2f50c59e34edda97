#pragma once
#include <cstdint>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/setup_facts.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/model.hpp>
#include <vector>

namespace tilemesh {

/// A BasicRenderer whose setup was chosen at run time. Code that only uses one includes this header, which holds no kernel of a frame.
class AnyRenderer {
public:
    virtual ~AnyRenderer() = default;
    virtual RenderedFrame render(splat::Camera const& camera) = 0;
    virtual splat::Model& model() = 0;
    /// Says what demand the map was cut to: from now on a view that the demand was not made for throws Error, and what was not
    /// loaded counts as parked.
    virtual void hold_to(scene::Demand const& demand) = 0;
    virtual Extent2 grid() = 0;                           ///< tiles; of the last frame, which there must be
    virtual Extent2 tile() = 0;                           ///< pixels; of the last frame

    virtual render::SetupFacts const& facts() const = 0;  ///< machine, sizes, ledger, bytes of a record
    virtual bool routes() const = 0;
    virtual bool blooms() const = 0;

    std::uint32_t sh_degree() const { return facts().sh_degree; } ///< of a record
    bool has_depth() const { return facts().has_depth; }          ///< planes beside the picture
    bool has_alpha() const { return facts().has_alpha; }
    std::uint32_t record_bytes() const { return facts().record_bytes; }
    std::uint32_t storage_slots() const { return facts().sizes.storage; }
    /// Of a channel that bloom or routing has; 0: none.
    std::uint32_t channel_slots() const { return blooms() ? facts().sizes.beam : routes() ? facts().sizes.road : 0; }
    std::vector<Region> const& ledger() const { return facts().ledger; }
};

} // namespace tilemesh
