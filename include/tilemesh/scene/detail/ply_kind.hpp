#pragma once
#include <array>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/ply_header.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// Throws `Error` for a file that does not begin with "ply". It names other formats of 3DGS maps; it knows them by their first bytes, or by
/// the extension if a format has no such bytes. It takes no bytes from the source.
TILEMESH_HOST void require_ply(ByteSource& source, std::string const& file);

/// Returns the element that holds the Gaussians. Throws `Error` if there is none, and for PLY files with other content.
TILEMESH_HOST PlyElement const& require_vertex(PlyHeader const& header, std::string const& file);

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/ply_kind_code.hpp>
#endif
