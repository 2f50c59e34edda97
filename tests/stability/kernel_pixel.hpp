#pragma once
#include <tilemesh/splat/blending.hpp>

namespace stability {

/// One pixel of the compositing kernel, blended layer by layer.
class KernelPixel {
public:
    explicit KernelPixel(tilemesh::splat::Rules const& rules) : rules_(rules), limits_(rules.alpha_min)
    {
        for (auto& row : block_.transmittance)
            for (float& t : row) t = 1;
        splat_.along = splat_.across = -1e-12f;
        splat_.columns = splat_.rows = 0u | 1u << 16;
    }
    void blend(float alpha, float grey = 1)
    {
        namespace detail = tilemesh::splat::detail;
        splat_.opacity = alpha;
        for (float& c : splat_.colour) c = grey;
        chunk_.take(0, splat_);
        std::uint32_t const first_row = 1u << detail::Hit::limits_at | 1u << detail::Hit::strips_at; // rows [0, 1), first strip
        std::uint32_t const hits[1] = {first_row};
        using Blend = detail::BlendBlock<detail::StopEachPixel>;
        detail::SetOf<detail::lanes_in_use>{}.template call<Blend>(block_, chunk_, &hits[0], 1u, place_, rules_, limits_);
    }
    float transmittance() const { return block_.transmittance[0][0]; }
    float colour() const { return block_.red[0][0]; }

private:
    tilemesh::splat::Rules rules_;
    tilemesh::splat::detail::RowLimits limits_;
    tilemesh::splat::detail::Block block_{};
    tilemesh::splat::detail::Chunk<16> chunk_{};
    tilemesh::splat::detail::BlockPlace place_{};
    tilemesh::splat::Splat splat_{};
};

} // namespace stability
