#include "reference.hpp"
#include <cmath>
#include <cstddef>
#include <tilemesh/report/exact_rays.hpp>
#include <tilemesh/scene/records.hpp>

namespace report = tilemesh::report;

report::Image render_map::reference_of(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera, tilemesh::splat::Rules const& rules,
                                       report::Cuts cuts, unsigned threads, bool exact_rays)
{
    return tilemesh::scene::visit_records(map, [&](auto const& records) {
        if (!exact_rays) return report::render_double(records, camera, rules, cuts, threads);
        auto used = rules;
        if (cuts == report::Cuts::none) used.alpha_min = used.transmittance_min = 0, used.alpha_max = 1;
        auto picture = report::render_exact_rays(records, camera, used, threads);
        for (std::size_t i = 0; i < picture.rgb.size(); ++i) // pixels without a ray
            if (std::isnan(picture.rgb[i])) picture.rgb[i] = rules.background[i % 3];
        return picture;
    });
}
