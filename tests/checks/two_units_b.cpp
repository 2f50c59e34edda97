#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/tilemesh.hpp>

tilemesh::report::Image other_unit_renders(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera)
{
    tilemesh::BasicRenderer<tilemesh::splat::Lossless, tilemesh::CheckedMesh> renderer(map);
    return renderer.render(camera).image;
}
