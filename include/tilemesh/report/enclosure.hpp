#pragma once
#include <cstdint>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/report/certificate.hpp>
#include <tilemesh/report/detail/enclosed_record.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/rules.hpp>
#include <type_traits>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

namespace detail {
struct EnclosedScene;
}

/// A picture that encloses the one of the exact formula: each channel of a pixel is within `radius` of `middle`, in exact real arithmetic.
///
/// The exact formula is that of `render_double` with the rules' cut-offs (`Cuts::same`): the numbers of the records, the camera and the rules
/// are float32 and exact by definition, and nothing is rounded after them. Splats are in the order of exact depths, then of ids. What a file's
/// reader did before (sigmoid, colour of degree 0) is outside. As in the kernels, a record whose numbers are not finite, that has a colour above
/// 1e6 or a quaternion of length 0 is not drawn, and an opacity above 1 is 1.
///
/// How it is proved:
/// 1. **Projection** in balls of more than 100 bits (detail/ball.hpp) encloses each splat of the formula. Depths and the near plane are
///    compared as exact sums of products of floats, so no order is undecided.
/// 2. **A splat in double** has a bound rho, so that at each pixel that it may light |a - a~| <= rho a~ for the exact alpha a and the computed
///    a~ (`round_splat`).
/// 3. **Blending in double with a bound.** Let C(a) = sum T_i a_i c_i + T B0, T_i = prod_{j<i} (1 - a_j), with a_i = 0 for a term that is cut or
///    behind the stop. C is affine in each a_i. Replace the computed a~_i by the exact a_i, one after the other from the last to the first:
///    each step changes C by exactly T~_i (a_i - a~_i) (c_i - B), where B is the exact colour of all that is behind, a mean of the colours
///    behind and the background. With M >= |c_i - B|: |C(a) - C(a~)| <= M sum T~_i |a_i - a~_i|. No higher order is left out. So the error is
///    a fourth colour, which is blended with the same weights. Roundings of w = a T, T - w and C + w c add 4 u M a term (u = 2^-53).
/// 4. **Decisions.** Where |a~ - alpha_min| <= rho a~, the term may be there or not: that costs T a. T is itself such a sum with colours 0 and
///    background 1, so |T - T~| <= S; where T~ is within S of the limit, the stop may come here or later: that costs T M.
/// 5. **Pixels with a doubtful decision**, or with a radius above 5e-9 levels, are blended again in balls. There, what is still undecided
///    encloses both outcomes.
///
/// The other cut-offs, `Cuts::none`: terms below an alpha of 1e-12 are left out, nothing else. Each of them changes a pixel by at most 1e-12
/// times the spread M of all colours, and a record has one term, so the radius takes 1e-12 M for each record.
///
/// Alpha is 1 - T. Depth is the mean of the terms' depths, sum(w z) / sum(w), 0 where there is none. w z is blended as a colour is.
///
/// The tests compare it with a textbook formula in binary128 that shares no code (tests/report/enclosure.cpp).
struct Enclosure {
    /// How a pixel's decisions (cuts, footprints, the stop) were made.
    enum class Decided : std::uint8_t {
        in_double, ///< all of them are certain in double
        in_wide,   ///< some needed 100 bits, or the numbers did
        undecided  ///< both outcomes of one are enclosed
    };
    std::uint32_t width = 0, height = 0;
    std::vector<double> middle, radius; ///< 3 * width * height, row by row from the top left, linear RGB
    struct OfPlane {
        std::vector<double> middle, radius; ///< width * height
    };
    OfPlane depth, alpha;               ///< if they were asked for
    std::vector<float> transmittance;   ///< width * height: of the middle
    std::vector<Decided> decided;       ///< width * height
    std::uint64_t splats = 0;           ///< that may light a pixel
    /// The ids of records that no ball encloses: a scale beyond e^100 or below e^-100, a covariance that may be singular.
    /// The enclosure is that of the other records; with one of these it says nothing about the picture of all.
    std::vector<std::uint64_t> not_enclosed;
    std::shared_ptr<detail::EnclosedScene const> scene; ///< what `explain` needs

    std::uint64_t count(Decided how) const noexcept;
    /// The width of the widest interval, 0 for no pixel.
    double widest() const noexcept;
};

struct EncloseOptions {
    unsigned threads = 1;
    Cuts cuts = Cuts::same;
    bool planes = false; ///< depth and alpha, too; `Cuts::same` only
};

namespace detail {
TILEMESH_HOST Enclosure enclose(std::span<EnclosedRecord const> records, splat::Camera const& camera, splat::Rules const& rules,
                                EncloseOptions const& options);

template <class Records>
std::vector<EnclosedRecord> enclosed_records(Records const& gaussians)
{
    std::vector<EnclosedRecord> records;
    records.reserve(std::size(gaussians));
    for (auto const& g : gaussians) {
        using Record = std::remove_cvref_t<decltype(g)>;
        if constexpr (Record::sh_degree > 0) records.push_back({&g, g.harmonics, Record::sh_degree});
        else records.push_back({&g, nullptr, 0});
    }
    return records;
}
} // namespace detail

/// Encloses the picture of the records of any degree. Ids must be unique. Equal for any number of threads.
///
/// Throws `Error` for rules with an alpha_min below 1e-30, because every record then lights every pixel; and on a host that
/// rounds doubles twice (x87).
///
/// Cost: some 6 us a record that is in front of the camera, and about twice as long as blending in double. Memory: 1,200 bytes a splat at
/// most, 54 bytes a pixel, 32 more with planes.
template <class Records = std::span<splat::Gaussian const>>
Enclosure enclose(Records const& gaussians, splat::Camera const& camera, splat::Rules const& rules, EncloseOptions const& options = {})
{
    return detail::enclose(detail::enclosed_records(gaussians), camera, rules, options);
}

/// Certifies a picture of the same size, with finite values or not: one that is not finite is infinitely far. Throws `Error` for another size.
TILEMESH_HOST Certificate certify(Enclosure const& enclosure, Image const& picture, Written const& written = {});
/// The same of a plane of depth or alpha.
TILEMESH_HOST Certificate::OfPlane certify(Enclosure::OfPlane const& enclosure, Plane const& plane);

/// "every channel within 0.0918/255 of the exact formula (p99 0.00033, median 6.8e-06; 12 pixels beyond 0.01; 3 decided in 100 bits, 0 undecided)".
/// Numbers are rounded up. Then records that are not enclosed, depth and alpha, and how many pixels have each cause, if there is such a thing.
TILEMESH_HOST std::string text_of(Certificate const& certificate);
/// "within 3.1e-07 (p99 ..., median ...)"
TILEMESH_HOST std::string text_of(Certificate::OfPlane const& certificate);

}}} // namespace tilemesh::v0_2::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/enclosure_code.hpp>
#endif
