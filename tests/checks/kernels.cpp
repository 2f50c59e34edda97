// Kernel code as a codelet compiler takes it: every header of machine/ and splat/, and each kernel of the frame called on words that
// somebody else owns. kernels.sh compiles this as C++17 and C++20 and looks at what the object needs.
#include <tilemesh/machine/buffer.hpp>
#include <tilemesh/machine/channel.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/name.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/machine/superstep.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/splat/bloom.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/compositing.hpp>
#include <tilemesh/splat/depth_sort.hpp>
#include <tilemesh/splat/exponential.hpp>
#include <tilemesh/splat/footprint.hpp>
#include <tilemesh/splat/frame_program.hpp>
#include <tilemesh/splat/frame_start.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/model.hpp>
#include <tilemesh/splat/policies.hpp>
#include <tilemesh/splat/projection.hpp>
#include <tilemesh/splat/regions.hpp>
#include <tilemesh/splat/routing.hpp>
#include <tilemesh/splat/setup.hpp>
#include <tilemesh/splat/view.hpp>
#include <tilemesh/splat/with_pixel.hpp>

namespace {
using namespace tilemesh;

/// A tile's memory: its states as one piece, and the eight ends of each channel.
struct Sram {
    std::uint32_t* states;
    std::uint32_t* links[2];
    splat::FrameParameters const* frame;
    Here here;
    Worker worker;
};

template <class Setup>
struct Source {
    using Layout = Tile<typename Setup::Machine, splat::Frame<Setup>>;
    Sram const& sram;

    template <class X>
    Place state() const noexcept
    {
        auto* const words = sram.states + Layout::template offset<X>();
        if constexpr (detail::is_list<X>)
            return {words, words + X::head_words, X::static_capacity};
        else
            return {nullptr, words, 1};
    }
    template <class C>
    Place end(std::uint32_t number) const noexcept
    {
        auto* const words = sram.links[detail::index_in<C>(typename Layout::Links{})] + number * C::Receiver::words(C::static_capacity);
        return {words, words + C::Receiver::head_words, C::static_capacity};
    }
    template <class C>
    Place in(Direction d) const noexcept
    {
        return end<C>(index(d));
    }
    template <class C>
    Place out(Direction d) const noexcept
    {
        return end<C>(4 + index(d));
    }
    template <class P>
    P const* shared() const noexcept
    {
        return sram.frame;
    }
    Here here() const noexcept { return sram.here; }
    Worker worker() const noexcept { return sram.worker; }
};

template <class Setup, template <class...> class Kernel>
std::uint32_t run(Sram const& sram) noexcept
{
    Source<Setup> source{sram};
    return static_cast<std::uint32_t>(run_kernel<Kernel<Setup>>(source));
}

/// The paper's drops with the records that the receiver need not project, and the other way round.
struct Screen : splat::Lossless {
    using Copies = splat::ScreenCopies;
    using Addressing = splat::Recomputed;
    using Pixel = splat::Rgbx8Pixel;
    static constexpr bool one_channel_memory = true;
};
using Planes = splat::WithPixel<splat::Lossless, splat::WithAlpha<splat::WithDepth<splat::FloatPixel>>>;
} // namespace

#define KERNELS(prefix, Setup)                                                                                                 \
    extern "C" std::uint32_t prefix##_project(Sram const& s) noexcept { return run<Setup, splat::Project>(s); }                \
    extern "C" std::uint32_t prefix##_route(Sram const& s) noexcept { return run<Setup, splat::Route>(s); }                    \
    extern "C" std::uint32_t prefix##_bloom(Sram const& s) noexcept { return run<Setup, splat::Bloom>(s); }                    \
    extern "C" std::uint32_t prefix##_depth_sort(Sram const& s) noexcept { return run<Setup, splat::DepthSort>(s); }           \
    extern "C" std::uint32_t prefix##_composite(Sram const& s) noexcept { return run<Setup, splat::Composite>(s); }

KERNELS(lossless, splat::Lossless)
KERNELS(paper, splat::Paper)
KERNELS(prototype, splat::Prototype)
KERNELS(screen, Screen)
KERNELS(planes, Planes)
