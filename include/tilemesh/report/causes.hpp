#pragma once
#include <functional>
#include <iterator>
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/report/certificate.hpp>
#include <tilemesh/report/enclosure.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/rules.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

namespace detail {
/// Another way to render the scene, and how it is called.
struct OtherRules {
    std::string word;
    std::function<Image()> render; ///< in double
};
TILEMESH_HOST std::vector<std::pair<std::string, splat::Rules>> other_rules(splat::Rules const& rules);
TILEMESH_HOST void explain(Certificate& certificate, Enclosure const& enclosure, Image const& picture, Written const& written,
                           std::vector<OtherRules> const& others, unsigned threads);
} // namespace detail

/// Adds to a certificate why pixels are off: to the worst ones, and in `causes` to at most 1,000 of all that are off by more than .01 levels.
///
/// A pixel is blended again in double, with one change. The change that leaves at most a tenth of the pixel's error (or .002 levels) names the cause:
/// - "order": a splat changes places with the next one, or with one further on, of a depth within 1 %; up to 24 such changes in turn;
/// - "cut": a splat whose alpha is within 1 % of alpha_min, or that is at the border of its footprint, is there or not;
/// - "stop": the pixel goes on, or stops, at a transmittance within 1 % of the limit;
/// - "missing": a splat is left out; it leaves at most a twentieth, and none of the causes above leaves only a fiftieth;
/// - "rounding": none of them, and the pixel is off by no more than half a float16's last bit for each of its terms, and a level;
/// - "undecided": the picture is inside, but the interval is wide; "not finite"; "unknown".
///
/// If more than half of these pixels are not by order, cut or stop, and more than .5 % of the picture is off, then the whole picture is
/// rendered with other rules, each by itself: another background, no dilation, a dilation of .1 or .3, coverage preserved or not, other
/// limits, the footprints, harmonics left out. If one leaves at most a tenth of the error of at least half of all pixels that are off, it is
/// the cause of those.
///
/// It is a most likely cause, no proof: the certificate is the proof. Cost: at most some ms a pixel; other rules cost one `render_double`
/// each.
template <class Records = std::span<splat::Gaussian const>>
void explain(Certificate& certificate, Enclosure const& enclosure, Records const& gaussians, splat::Camera const& camera, splat::Rules const& rules,
             Image const& picture, Written const& written = {}, unsigned threads = 1)
{
    std::vector<detail::OtherRules> others;
    for (auto const& [word, other] : detail::other_rules(rules))
        others.push_back(
            {word, [&gaussians, &camera, rules_of = other, threads] { return render_double(gaussians, camera, rules_of, Cuts::same, threads); }});
    if constexpr (std::remove_cvref_t<decltype(*std::begin(gaussians))>::sh_degree > 0)
        others.push_back({"harmonics", [&] {
                              std::vector<splat::Gaussian> flat(std::begin(gaussians), std::end(gaussians));
                              for (auto& g : flat)
                                  for (float& c : g.colour) c = c > 0 ? c : 0.0f; // as scene::at_degree
                              return render_double(flat, camera, rules, Cuts::same, threads);
                          }});
    detail::explain(certificate, enclosure, picture, written, others, threads);
}

}}} // namespace tilemesh::v0_2::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/causes_code.hpp>
#endif
