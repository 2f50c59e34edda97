#include "reference.hpp"
#include <tilemesh/scene/records.hpp>

tilemesh::report::Image render_map::reference_of(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera,
                                                 tilemesh::splat::Rules const& rules, tilemesh::report::Cuts cuts, unsigned threads)
{
    return tilemesh::scene::visit_records(map, [&](auto const& records) {
        return tilemesh::report::render_double(records, camera, rules, cuts, threads);
    });
}
