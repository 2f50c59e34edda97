#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/ply_header.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <tilemesh/scene/detail/text_input.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// Throws `Error` for a file that does not begin with "ply". It names other formats of 3DGS maps; it knows them by their first bytes, or by
/// the extension if a format has no such bytes. It takes no bytes from the source.
inline void require_ply(ByteSource& source, std::string const& file)
{
    if (source.begins_with("ply")) return;
    std::string extension = std::filesystem::path(file).extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');

    struct Kind {
        std::string_view magic, extension; ///< empty: any
        char const* is;
    };
    static constexpr Kind kinds[] = {
        {"\x1f\x8b", ".spz", "is an SPZ map (compressed by gzip)"},
        {"\x1f\x8b", "", "is compressed by gzip (as SPZ maps and .ply.gz files are)"},
        {"NGSP", "", "is an SPZ map (it begins with NGSP)"},
        {"PK\x03\x04", ".npz", "is a NumPy archive (arrays of a training, under names of its own)"},
        {"PK\x03\x04", ".usdz", "is a USD scene (a .usdz archive)"},
        {"PK\x03\x04", ".pt", "is a PyTorch checkpoint (the state of a training)"},
        {"PK\x03\x04", ".pth", "is a PyTorch checkpoint (the state of a training)"},
        {"PK\x03\x04", ".ckpt", "is a PyTorch checkpoint (the state of a training)"},
        {"PK\x03\x04", "", "is a ZIP archive (as SOG maps and checkpoints of a training are)"},
        {"glTF", "", "is a binary glTF scene (a .glb; splats are an extension of it)"},
        {"\x93NUMPY", "", "is a NumPy array (of a training)"},
        {"", ".splat", "is a .splat map (32 bytes a Gaussian without a header, rounded to 8 bits)"},
        {"", ".ksplat", "is a .ksplat map (of GaussianSplats3D, compressed)"},
        {"", ".spz", "is an SPZ map (compressed)"},
        {"", ".sog", "is an SOG map (compressed)"},
        {"", ".sogs", "is an SOG map (compressed)"},
        {"", ".rad", "is a RAD map (of Spark, in levels of detail)"},
        {"", ".lcc", "is an LCC map (of XGRIDS, in levels of detail, with data.bin beside it)"},
        {"", ".spx", "is an SPX map (of Reall3dViewer, compressed)"},
        {"", ".glb", "is a binary glTF scene (a .glb; splats are an extension of it)"},
        {"", ".gltf", "is a glTF scene (splats are an extension of it)"},
        {"", ".npz", "is a NumPy archive (arrays of a training, under names of its own)"},
        {"", ".pt", "is a PyTorch checkpoint (the state of a training)"},
        {"", ".pth", "is a PyTorch checkpoint (the state of a training)"},
        {"", ".ckpt", "is a PyTorch checkpoint (the state of a training)"},
        {"", ".json", "is a JSON file (an SOG map keeps its numbers in pictures beside it; cameras are no map)"},
    };
    if (source.size() == 0) throw Error(file + " is not a PLY file (it is empty); copy or export the map again");
    std::string begin;
    for (std::string_view const each : stand_ins)
        if (source.begins_with(each)) begin = each;
    refuse_stand_in(begin, file);
    for (auto const& kind : kinds)
        if (source.begins_with(kind.magic) && (kind.extension.empty() || kind.extension == extension))
            throw Error(file + ' ' + kind.is + "; export the map as uncompressed PLY, from the training or with SuperSplat or splat-transform");
    if (extension == ".zip") throw Error(file + " is a .zip file (maps are read from plain files); unpack it and name the PLY");
    throw Error(file + " is not a PLY file (it does not begin with \"ply\"); name a 3DGS map");
}

/// Returns the element that holds the Gaussians. Throws `Error` if there is none, and for PLY files with other content.
inline PlyElement const& require_vertex(PlyHeader const& header, std::string const& file)
{
    PlyElement const* vertex = nullptr;
    for (auto const& element : header.elements)
        if (element.name == "vertex") vertex = &element;
    if (!vertex) throw Error(file + " has no element vertex (a 3DGS map keeps its Gaussians there); name a 3DGS map");
    auto const has = [&](auto... names) { return (vertex->find(names) && ...); };
    if (has("x", "y", "z", "red", "green", "blue") && !has("f_dc_0") && !has("scale_0"))
        throw Error(file + " is a point cloud (x y z and red green blue, but no f_dc_0..2 and scale_0..2: the points that a "
                           "training starts from); name the trained map, point_cloud/iteration_N/point_cloud.ply");
    return *vertex;
}

}}} // namespace tilemesh::v0_2::scene::detail
