#include "reference.hpp"
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tilemesh/report/enclosure.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/scene/records.hpp>
#include <type_traits>

namespace {

/// Calls f with the records of the map, of its degree.
template <class F>
auto with_records(tilemesh::scene::Map const& map, F const& f)
{
    auto const of_degree = [&]<std::uint32_t degree>(std::integral_constant<std::uint32_t, degree>) {
        return f(tilemesh::scene::records<tilemesh::splat::GaussianOfDegree<degree>>(map));
    };
    switch (map.sh_degree) {
    case 0:
        return f(map.gaussians);
    case 1:
        return of_degree(std::integral_constant<std::uint32_t, 1>{});
    case 2:
        return of_degree(std::integral_constant<std::uint32_t, 2>{});
    default:
        return of_degree(std::integral_constant<std::uint32_t, 3>{});
    }
}

} // namespace

tilemesh::report::Image render_map::reference_of(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera,
                                                 tilemesh::splat::Rules const& rules, tilemesh::report::Cuts cuts, unsigned threads)
{
    return with_records(map, [&](auto const& records) { return tilemesh::report::render_double(records, camera, rules, cuts, threads); });
}

tilemesh::report::Enclosure render_map::enclosure_of(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera,
                                                     tilemesh::splat::Rules const& rules, unsigned threads)
{
    return with_records(map, [&](auto const& records) { return tilemesh::report::enclose(records, camera, rules, threads); });
}

tilemesh::report::Image render_map::bound_of(tilemesh::report::Enclosure const& enclosure, bool upper)
{
    tilemesh::report::Image out{enclosure.width, enclosure.height};
    float const outward = upper ? std::numeric_limits<float>::infinity() : -std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < out.rgb.size(); ++i) // the sum and its conversion are off by less than a float
        out.rgb[i] = std::nextafter(static_cast<float>(enclosure.middle[i] + (upper ? enclosure.radius[i] : -enclosure.radius[i])), outward);
    return out;
}
