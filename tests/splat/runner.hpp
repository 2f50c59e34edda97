#pragma once
#include "support.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/fit_renderer.hpp>

// Renderers behind plain functions. Only the files in shared/ instantiate them, each once for all tests.
namespace support {

/// A renderer of any setup and engine, with access to its tiles for tests.
class Runner {
public:
    virtual ~Runner() = default;

    virtual void render_into(splat::Camera const& camera, RenderedFrame& frame) = 0;
    RenderedFrame render(splat::Camera const& camera)
    {
        RenderedFrame frame;
        render_into(camera, frame);
        return frame;
    }
    virtual splat::Rules& rules() = 0;
    virtual splat::Tiling const& tiling() = 0;
    virtual Grid grid() = 0;                     ///< of the last frame; requires one
    virtual render::Setup const& facts() = 0;
    virtual void observe(Observer observer) = 0;

    /// The marks of the records on a tile, in the order of their slots.
    virtual std::vector<splat::Mark> marks(TileId tile) = 0;
    /// Every id that the mesh owns, sorted; see `support::owned_ids`.
    virtual std::vector<std::uint32_t> owned_ids() = 0;
    /// Counters, marks and the order of every tile, as words.
    virtual std::vector<std::uint64_t> on_tiles() = 0;

    /// The tiles whose records differ from brute force; see `wrong_tiles_of`.
    std::uint32_t wrong_tiles(std::vector<splat::Gaussian> const& gaussians, splat::View const& view)
    {
        return wrong_tiles_of(grid(), [&](TileId tile) { return marks(tile); }, gaussians, view, tiling());
    }
    /// The records that a frame's report lists as missing.
    Missing missing(report::FrameReport const& r) { return Missing(r, tiling(), grid()); }
};

/// A renderer of setup S. It links only for the setups that a file in shared/ names.
template <class S, template <class, class> class Engine = PortMesh>
std::unique_ptr<Runner> make_runner(scene::Map const& map, RendererOptions const& options = {});

/// `fit_renderer<Setups...>`, with the same condition.
template <class... Setups>
std::unique_ptr<AnyRenderer> fit_shared(scene::Map const& map, scene::Demand const& demand, RendererOptions const& options = {});

// --- setups of several tests -------------------------------------------------------------------------------------------------

using splat::Referenced;
/// The setup of most tests: hold, carried, world copies, float pixels, by value.
using Whole = Room<>;

struct ScreenBase : splat::Lossless {
    using Copies = splat::ScreenCopies;
};
struct RecomputedBase : splat::Lossless {
    using Addressing = splat::Recomputed;
};
struct DropBase : splat::Lossless {
    using Saturation = splat::Drop;
};
using Screens = Room<ScreenBase>;
using Dropping = Room<splat::Paper>;
using Shaded = splat::Fitted<Whole, 3>;
using Planes = splat::WithPixel<Whole, splat::WithAlpha<splat::WithDepth<splat::FloatPixel>>>;
struct LargestHoldBase : splat::Lossless {
    using Saturation = splat::LargestFirst<splat::Hold>;
};
struct LargestDropBase : splat::Lossless {
    using Saturation = splat::LargestFirst<splat::Drop>;
};
using LargestHold = Room<LargestHoldBase>;
using LargestDrop = Room<LargestDropBase>;
/// The policies of Whole, with small sizes.
struct FixedSizes : Whole {
    static constexpr splat::Sizes sizes = sized<Whole>(3, 120, 2);
};

// Without a part.
using NoRouting = splat::Fitted<Whole, 0, false, true>;
using NoBloom = splat::WithPixel<splat::Fitted<Whole, 0, true, false>, splat::WithAlpha<splat::WithDepth<splat::FloatPixel>>>;
using Minimal = splat::Fitted<Whole, 0, false, false>;

// Together with those above: every pair of hold or drop, world or screen, carried or recomputed, floats or bytes, planes or none, harmonics
// or none.
struct DropScreens : Room<DropBase> {
    using Copies = splat::ScreenCopies;
    using Addressing = splat::Recomputed;
    using Pixel = splat::WithAlpha<splat::FloatPixel>;
    using Record = splat::ShadedGaussian<3>;
};
struct BytesAndPlanes : Room<RecomputedBase> {
    using Pixel = splat::WithAlpha<splat::WithDepth<splat::Rgbx8Pixel>>;
};
struct ShadedScreens : Screens {
    using Pixel = splat::WithDepth<splat::Rgbx8Pixel>;
    using Record = splat::ShadedGaussian<3>;
};

} // namespace support
