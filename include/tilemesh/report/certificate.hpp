#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/config.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// How the values of a picture were written: clamped to [0, 1], and rounded by at most `half_step`. By default, as they are.
struct Written {
    bool clamped = false;
    double half_step = 0; ///< 0.5 / 255 for 8 bits
};

/// Why a pixel is off, as far as one change of what the exact formula does explains it (causes.hpp).
struct PixelCause {
    /// "order", "cut", "stop", "missing", a rule such as "dilation 0" or "background", "rounding", "unknown"; "undecided": the interval itself is
    /// wide; "not finite". Empty: not looked for.
    std::string word;
    std::uint32_t id = 0, other_id = 0; ///< of the splat that it is about, and of the one that it changed places with; 0: none
    double left = 0;                    ///< levels by which the pixel is off beside it
};

/// How far a picture is from the exact formula's, at most: for each channel |picture - middle| + radius, in 255ths ("levels"). What a picture
/// lost when it was written (`Written`) is not counted.
struct Certificate {
    double largest = 0, p99 = 0, median = 0;  ///< levels
    std::uint64_t beyond = 0;                 ///< pixels that are off by more than .01 levels
    std::uint64_t in_wide = 0, undecided = 0; ///< pixels of the enclosure with a decision in 100 bits, and with an undecided one
    double widest = 0;                        ///< levels: the widest interval
    std::vector<std::uint64_t> not_enclosed;  ///< ids of records that no interval encloses: the certificate leaves them out
    /// The pixels that are farthest off, at most 10 and each by more than .01 levels.
    struct Pixel {
        std::uint32_t x, y;
        double levels;
        PixelCause cause;
    };
    std::vector<Pixel> worst;
    /// How many pixels have each cause's word, of those that were looked at, most first; of at most 1,000.
    std::vector<std::pair<std::string, std::uint64_t>> causes;

    /// Of a plane, in its own units.
    struct OfPlane {
        double largest = 0, p99 = 0, median = 0;
    };
    std::optional<OfPlane> depth, alpha; ///< if the planes were certified, too
};

}}} // namespace tilemesh::v0_2::report
