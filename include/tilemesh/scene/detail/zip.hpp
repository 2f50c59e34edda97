#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/codecs.hpp>
#include <tilemesh/scene/detail/bytes.hpp>
#include <tilemesh/scene/detail/packed_input.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// A ZIP archive in memory (PKWARE's APPNOTE): entries that are stored or deflated, found in its central directory. An entry is decompressed
/// when it is asked for. ZIP64, encryption and archives of several parts are refused.
class Zip {
public:
    /// Throws `Error` for bytes without a whole central directory. Errors call the archive `file`. Keeps references to all three.
    TILEMESH_HOST Zip(ByteView bytes, Codecs const& codecs, std::string const& file);

    /// The content of the first entry of this name. Throws `Error` if there is none, or if it is damaged.
    TILEMESH_HOST Bytes read(std::string const& name) const;

private:
    [[noreturn]] TILEMESH_HOST void refuse(std::string const& why) const;
    std::uint32_t half(std::uint64_t at) const { return number_at<std::uint16_t>(bytes_.data() + at); }
    std::uint32_t word(std::uint64_t at) const { return number_at<std::uint32_t>(bytes_.data() + at); }

    /// `at`: of the entry in the directory.
    TILEMESH_HOST Bytes extract(std::uint64_t at, std::string const& name) const;

    ByteView bytes_;
    Codecs const& codecs_;
    std::string const& file_;
    std::uint32_t entries_ = 0;
    std::uint64_t directory_ = 0, directory_end_ = 0;
};

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/zip_code.hpp>
#endif
