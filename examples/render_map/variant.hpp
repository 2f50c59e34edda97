#pragma once
#include "choice.hpp"
#include <cstdint>
#include <tilemesh/error.hpp>
#include <tilemesh/splat/policies.hpp>
#include <tilemesh/splat/setup.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <type_traits>

namespace render_map {

/// A setup with other policies on the same machine, with the same bytes for every region.
///
/// `Hold` needs FIFOs for what waits. A preset that drops has none, so it gets 200 messages a side, as `lossless` has; the
/// ledger lists them.
template <class Base, class SaturationPolicy, class CopiesPolicy, class PixelPolicy>
struct Variant : Base {
    using Saturation = SaturationPolicy;
    using Copies = CopiesPolicy;
    using Pixel = PixelPolicy;
    static constexpr std::uint32_t waiting_bytes =
        Saturation::holds && Base::waiting_bytes == 0
            ? static_cast<std::uint32_t>(200 * sizeof(tilemesh::splat::RoadMessage<Base>))
            : Base::waiting_bytes;
};

/// A build for the compiler's and the sanitizers' sake compiles an eighth of the setups.
#if defined(RENDER_MAP_OWN_POLICIES)
inline constexpr bool own_policies_only = true;
#else
inline constexpr bool own_policies_only = false;
#endif

template <class T>
struct Type {
    using type = T;
};

/// Calls `use` with the Type of Base and the planes of a choice that has some.
template <class Base, class Use>
auto with_planes(Choice const& choice, Use&& use)
{
    namespace splat = tilemesh::splat;
    using Pixel = typename Base::Pixel;
    using Both = splat::WithPixel<Base, splat::WithAlpha<splat::WithDepth<Pixel>>>;
    if constexpr (own_policies_only) {
        return use(Type<Both>{});
    } else {
        if (choice.depth && choice.alpha) return use(Type<Both>{});
        return choice.depth ? use(Type<splat::WithPixel<Base, splat::WithDepth<Pixel>>>{})
                            : use(Type<splat::WithPixel<Base, splat::WithAlpha<Pixel>>>{});
    }
}

/// Calls `use` with the Type of Base under the policies of a choice; the preset's own where it names none.
template <class Base, class Use>
auto with_policies(Choice const& choice, Use&& use)
{
    namespace splat = tilemesh::splat;
    using Saturation = typename Base::Saturation;
    using Copies = typename Base::Copies;
    using Pixel = typename Base::Pixel;
    auto const saturation = choice.saturation.value_or(Saturation::holds ? SaturationKind::hold : SaturationKind::drop);
    auto const copies = choice.copies.value_or(Copies::reusable ? CopiesKind::world : CopiesKind::screen);
    auto const pixels =
        choice.pixels.value_or(std::is_same_v<Pixel, splat::FloatPixel> ? PixelKind::float32 : PixelKind::rgbx8);

    if constexpr (own_policies_only) {
        if (saturation != (Saturation::holds ? SaturationKind::hold : SaturationKind::drop) ||
            copies != (Copies::reusable ? CopiesKind::world : CopiesKind::screen) ||
            pixels != (std::is_same_v<Pixel, splat::FloatPixel> ? PixelKind::float32 : PixelKind::rgbx8))
            throw tilemesh::Error(
                "--saturation, --copies or --pixels is not the preset's own (this build has no others: it was "
                "made with TILEMESH_RENDER_MAP_POLICIES=OFF); leave it out, or build with ON");
        return use(Type<Variant<Base, Saturation, Copies, Pixel>>{});
    } else {
        auto const pick_pixels = [&]<class S, class C>(Type<S>, Type<C>) {
            return pixels == PixelKind::float32 ? use(Type<Variant<Base, S, C, splat::FloatPixel>>{})
                                                : use(Type<Variant<Base, S, C, splat::Rgbx8Pixel>>{});
        };
        auto const pick_copies = [&]<class S>(Type<S> s) {
            return copies == CopiesKind::world ? pick_pixels(s, Type<splat::WorldCopies>{})
                                               : pick_pixels(s, Type<splat::ScreenCopies>{});
        };
        return saturation == SaturationKind::hold ? pick_copies(Type<splat::Hold>{}) : pick_copies(Type<splat::Drop>{});
    }
}

} // namespace render_map
