#pragma once
#include <tilemesh/splat/pose/motion.hpp>
#include <tilemesh/splat/project_all.hpp>

TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat::pose {

namespace detail {
/// The two words of as many Gaussians at once as the set has lanes; all must exist. Returns the stiff ones as bits: their words have no
/// meaning.
struct TermsLanes {
    template <class Set>
    TILEMESH_KERNEL static std::uint32_t run(Gaussian const* records, View const& view, TileSize const& tile, Terms* out) noexcept
    {
        using namespace splat::detail;
        constexpr std::uint32_t N = Set::most_lanes;
        using A = FloatLanes<N>;
        auto const* const from = reinterpret_cast<unsigned char const*>(records);
        auto const w0 = load_columns<N>(from, sizeof(Gaussian)), w4 = load_columns<N>(from + 4 * 4, sizeof(Gaussian));
        auto const w8 = load_columns<N>(from + 4 * 8, sizeof(Gaussian)), w11 = load_columns<N>(from + 4 * 11, sizeof(Gaussian));
        GaussianWords<A> const g{{w0.a, w0.b, w0.c}, {w0.d, w4.a, w4.b}, w4.c, {w4.d, w8.a, w8.b, w8.c}, {w11.a, w11.b, w11.c}};
        SplatWords<A> s;
        PoseWords<A> pose;
        pose.along_depth = pose.across_depth = Floats<N>{};
        auto const [visible, stiff] = project_words<A, AnyLens>(g, view, tile, s, pose);
        float along[N], across[N];
        store(along, A::select(visible, pose.along_depth, Floats<N>{}));
        store(across, A::select(visible, pose.across_depth, Floats<N>{}));
        std::int32_t rare[N];
        store(rare, Words<N>(stiff));
        std::uint32_t bits = 0;
        for (std::uint32_t i = 0; i < N; ++i) {
            out[i] = {along[i], across[i]};
            bits |= (rare[i] != 0 ? 1u : 0u) << i;
        }
        return bits;
    }
};
} // namespace detail

/// The two words of n Gaussians: `out[i]` is `terms_of(records[i], view, tile)`, bit for bit. It computes several at once.
template <std::uint32_t Lanes = splat::detail::lanes_in_use>
void terms_of_all(Gaussian const* records, std::uint32_t n, View const& view, TileSize const& tile, Terms* out) noexcept
{
    using Set = splat::detail::SetOf<Lanes>;
    Set const set{};
    std::uint32_t const lanes = set.lanes();
    if constexpr (Set::most_lanes >= 4) {
        for (std::uint32_t i = 0; n >= lanes && i < n; i += lanes) { // the last step takes the last `lanes` records, some of them a second time
            std::uint32_t const first = i < n - lanes ? i : n - lanes;
            std::uint32_t const stiff = set.template call<detail::TermsLanes>(records + first, view, tile, out + first);
            for (std::uint32_t k = 0; stiff >> k != 0; ++k)
                if ((stiff >> k & 1u) != 0) out[first + k] = terms_of(records[first + k], view, tile);
        }
        if (n >= lanes) return;
    }
    for (std::uint32_t i = 0; i < n; ++i) out[i] = terms_of(records[i], view, tile);
}

}}} // namespace tilemesh::splat::pose
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
