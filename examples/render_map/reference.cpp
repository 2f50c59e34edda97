#include "reference.hpp"
#include <cstdint>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/scene/records.hpp>
#include <type_traits>

tilemesh::report::Image render_map::reference_of(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera,
                                                 tilemesh::splat::Rules const& rules, tilemesh::report::Cuts cuts, unsigned threads)
{
    namespace report = tilemesh::report;
    auto const of_degree = [&]<std::uint32_t degree>(std::integral_constant<std::uint32_t, degree>) {
        using Record = tilemesh::splat::GaussianOfDegree<degree>;
        return report::render_double(tilemesh::scene::records<Record>(map), camera, rules, cuts, threads);
    };
    switch (map.sh_degree) {
    case 0:
        return report::render_double(map.gaussians, camera, rules, cuts, threads);
    case 1:
        return of_degree(std::integral_constant<std::uint32_t, 1>{});
    case 2:
        return of_degree(std::integral_constant<std::uint32_t, 2>{});
    default:
        return of_degree(std::integral_constant<std::uint32_t, 3>{});
    }
}
