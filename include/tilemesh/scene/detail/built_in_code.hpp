#pragma once
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/detail/brush.hpp>
#include <tilemesh/scene/detail/desk.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

TILEMESH_HOST Map built_in_map()
{
    Map map;
    map.name = "built_in";
    detail::paint_desk_scene(map);
    return map;
}

TILEMESH_HOST splat::Camera built_in_camera(Size size)
{
    return make_camera(look_at(detail::desk_eye, {0.0, -0.215, 0.10}), lens_from_field_of_view(60.0, size));
}

}}} // namespace tilemesh::scene
