#pragma once
#include "../compare_reports.hpp"
#include "../splat/support.hpp"
#include "on_ranks.hpp"

namespace mpi_test {

/// A frame over ranks is that of one process: every rank has its report, and rank 0 alone has its picture and planes.
inline void check_same_frame(RenderedFrame const& frame, RenderedFrame const& wanted)
{
    auto const same_words = [](std::vector<float> const& a, std::vector<float> const& b) {
        return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
    };
    CHECK(report::first_difference(frame.report, wanted.report) == "");
    if (rank() != 0) {
        CHECK(frame.image.width == 0);
        CHECK(frame.depth.values.empty());
        return;
    }
    CHECK(support::differing_pixels(frame.image, wanted.image) == 0);
    CHECK(same_words(frame.depth.values, wanted.depth.values));
    CHECK(same_words(frame.alpha.values, wanted.alpha.values));
}

} // namespace mpi_test
