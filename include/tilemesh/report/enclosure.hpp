#pragma once
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/report/detail/enclosed_record.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/rules.hpp>
#include <type_traits>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// A picture that encloses the one of the exact formula: each channel of a pixel is within `radius` of `middle`, in exact real arithmetic.
///
/// The exact formula is that of `render_double` with the rules' cut-offs (`Cuts::same`): the numbers of the records, the camera and the rules
/// are float32 and exact by definition, and nothing is rounded after them. Splats are in the order of exact depths, then of ids. What a file's
/// reader did before (sigmoid, colour of degree 0) is outside. As in the kernels, a record whose numbers are not finite or that has a colour above
/// 1e6 is not drawn, and an opacity above 1 is 1.
///
/// How it is proved:
/// 1. **Projection** in balls of binary128 (detail/ball.hpp) encloses each splat of the formula. Depths and the near plane are compared as exact
///    sums of products of floats, so no order is undecided.
/// 2. **A splat in double** has a bound rho, so that at each pixel that it may light |a - a~| <= rho a~ for the exact alpha a and the computed
///    a~ (`round_splat`).
/// 3. **Blending in double with a bound.** Let C(a) = sum T_i a_i c_i + T B0, T_i = prod_{j<i} (1 - a_j), with a_i = 0 for a term that is cut or
///    behind the stop. C is affine in each a_i. Replace the computed a~_i by the exact a_i, one after the other from the last to the first:
///    each step changes C by exactly T~_i (a_i - a~_i) (c_i - B), where B is the exact colour of all that is behind, a mean of the colours
///    behind and the background. With M >= |c_i - B|: |C(a) - C(a~)| <= M sum T~_i |a_i - a~_i|. No higher order is left out. So the error is
///    a fourth colour, which is blended with the same weights. Roundings of w = a T, T - w and C + w c add 4 u M a term (u = 2^-53).
/// 4. **Decisions.** Where |a~ - alpha_min| <= rho a~, the term may be there or not: that costs T a. T is itself such a sum with colours 0 and
///    background 1, so |T - T~| <= S; where T~ is within S of the limit, the stop may come here or later: that costs T M.
/// 5. **Pixels with a doubtful decision** are blended again in balls. There, what is still undecided encloses both outcomes.
///
/// The tests compare it with a textbook formula in binary128 that shares no code (tests/report/enclosure.cpp).
struct Enclosure {
    /// How a pixel's decisions (cuts, footprints, the stop) were made.
    enum class Decided : std::uint8_t {
        in_double, ///< all of them are certain in double
        in_quad,   ///< some needed 113 bits
        undecided  ///< both outcomes of one are enclosed
    };
    std::uint32_t width = 0, height = 0;
    std::vector<double> middle, radius; ///< 3 * width * height, row by row from the top left, linear RGB
    std::vector<Decided> decided;       ///< width * height
    std::uint64_t splats = 0;           ///< that may light a pixel
    /// The numbers of records that no ball encloses: a scale beyond e^100 or below e^-100, a covariance that may be singular.
    /// The enclosure is that of the other records; with one of these it says nothing about the picture of all.
    std::vector<std::size_t> not_enclosed;

    std::uint64_t count(Decided how) const noexcept;
    /// The width of the widest interval, 0 for no pixel.
    double widest() const noexcept;
};

/// How the values of a picture were written: clamped to [0, 1], and rounded by at most `half_step`. By default, as they are.
struct Written {
    bool clamped = false;
    double half_step = 0; ///< 0.5 / 255 for 8 bits
};
/// How far a picture is from the exact formula's, at most: for each channel |picture - middle| + radius, in 255ths ("levels"). What a picture
/// lost when it was written (`Written`) is not counted.
struct Certificate {
    double largest = 0, p99 = 0, median = 0; ///< levels
    std::uint64_t beyond = 0;                ///< pixels that are off by more than .01 levels
    /// The pixels that are farthest off, at most 10 and each by more than .01 levels.
    struct Pixel {
        std::uint32_t x, y;
        double levels;
    };
    std::vector<Pixel> worst;
};

namespace detail {
TILEMESH_HOST Enclosure enclose(std::span<EnclosedRecord const> records, splat::Camera const& camera, splat::Rules const& rules, unsigned threads);
} // namespace detail

/// Encloses the picture of the records of any degree. Ids must be unique. Equal for any number of threads.
///
/// Throws `Error` for rules with an alpha_min below 1e-30, because every record then lights every pixel; and on a host without numbers of 113 bits.
///
/// Cost: 25 us a record that is in front of the camera, and about twice as long as blending in double. Memory: 500 bytes a splat, 50 bytes a pixel.
template <class Records = std::span<splat::Gaussian const>>
Enclosure enclose(Records const& gaussians, splat::Camera const& camera, splat::Rules const& rules, unsigned threads = 1)
{
    std::vector<detail::EnclosedRecord> records;
    records.reserve(std::size(gaussians));
    for (auto const& g : gaussians) {
        using Record = std::remove_cvref_t<decltype(g)>;
        if constexpr (Record::sh_degree > 0) records.push_back({&g, g.harmonics, Record::sh_degree});
        else records.push_back({&g, nullptr, 0});
    }
    return detail::enclose(records, camera, rules, threads);
}

/// Certifies a picture of the same size, with finite values or not: one that is not finite is infinitely far. Throws `Error` for another size.
TILEMESH_HOST Certificate certify(Enclosure const& enclosure, Image const& picture, Written const& written = {});

/// "every channel within 0.0918/255 of the exact formula (p99 0.00033, median 6.8e-06; 12 pixels beyond 0.01; 3 pixels decided in 113 bits)". Numbers
/// are rounded up. If there are records that are not enclosed, or pixels that are undecided, it says so.
TILEMESH_HOST std::string text_of(Certificate const& certificate, Enclosure const& enclosure);

}}} // namespace tilemesh::v0_2::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/enclosure_code.hpp>
#endif
