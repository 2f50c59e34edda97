#pragma once
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/rules.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// A map as the bytes of a PLY file that this library and viewers of 3DGS maps read: binary, little-endian, floats. The columns are x y
/// z, f_dc_0..2, f_rest_* if the map has harmonics, opacity, scale_0..2, rot_0..3. If a reader moved the map's origin, it is added again,
/// and x y z are doubles.
///
/// With `preserved`, a comment says that the map is to be shown with anti-aliasing ("antialiased 1", which `read_ply` notes).
///
/// Read again, the map has the same means, log-scales and harmonics; colours, opacities and rotations differ by rounding alone. An
/// opacity of 0 or 1 has the logit -104 or 18, which is read as the same opacity. Equal maps give equal bytes with every compiler that
/// fuses multiply_add alike.
TILEMESH_HOST std::string ply_bytes(Map const& map, splat::Coverage coverage = splat::Coverage::of_record);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/ply_output_code.hpp>
#endif
