#pragma once
#include <cstdint>
#include <tilemesh/splat/gaussian.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report::detail {

/// A record of any degree, for code that is compiled once. `harmonics` is null for degree 0.
struct EnclosedRecord {
    splat::Gaussian const* gaussian;
    float const* harmonics;
    std::uint32_t degree;
};

}}} // namespace tilemesh::report::detail
