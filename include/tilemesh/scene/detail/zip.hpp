#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
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
    Zip(ByteView bytes, Codecs const& codecs, std::string const& file) : bytes_(bytes), codecs_(codecs), file_(file)
    {
        constexpr std::size_t end_bytes = 22, longest_comment = 65535;
        if (bytes.size() < end_bytes) refuse("it ends inside its directory");
        std::size_t const first = bytes.size() > end_bytes + longest_comment ? bytes.size() - end_bytes - longest_comment : 0;
        std::size_t at = bytes.size() - end_bytes + 1;
        do {
            if (at == first) refuse("it has no directory");
            --at;
        } while (word(at) != 0x06054b50u || at + end_bytes + half(at + 20) != bytes.size());
        if (half(at + 4) != 0 || half(at + 6) != 0 || half(at + 8) != half(at + 10)) refuse("it has several parts");
        entries_ = half(at + 10);
        directory_ = word(at + 16);
        directory_end_ = directory_ + word(at + 12);
        if (entries_ == 0xffff || directory_ == 0xffffffffu) refuse("it is a ZIP64 archive");
        if (directory_end_ > at) refuse("its directory is not inside the file");
    }

    /// The content of the first entry of this name. Throws `Error` if there is none, or if it is damaged.
    Bytes read(std::string const& name) const
    {
        std::uint64_t at = directory_;
        for (std::uint32_t i = 0; i < entries_; ++i) {
            if (directory_end_ - at < 46 || word(at) != 0x02014b50u) refuse("its directory is damaged");
            std::uint64_t const name_bytes = half(at + 28), skipped = name_bytes + half(at + 30) + half(at + 32);
            if (directory_end_ - at - 46 < skipped) refuse("its directory is damaged");
            std::string_view const found(reinterpret_cast<char const*>(bytes_.data()) + at + 46, static_cast<std::size_t>(name_bytes));
            if (found == name) return extract(at, name);
            at += 46 + skipped;
        }
        throw Error(file_ + " has no " + in_quotes(name) +
                    " (an SOG map has meta.json and the pictures that it names); name an SOG map, or unpack the archive");
    }

private:
    [[noreturn]] void refuse(std::string const& why) const
    {
        throw Error(file_ + " cannot be read as a ZIP archive (" + why + "); copy or export the map again");
    }
    std::uint32_t half(std::uint64_t at) const { return number_at<std::uint16_t>(bytes_.data() + at); }
    std::uint32_t word(std::uint64_t at) const { return number_at<std::uint32_t>(bytes_.data() + at); }

    /// `at`: of the entry in the directory.
    Bytes extract(std::uint64_t at, std::string const& name) const
    {
        auto const refuse_entry = [&](char const* why) { refuse("its entry " + in_quotes(name) + ' ' + why); };
        std::uint32_t const flags = half(at + 8), method = half(at + 10), checksum = word(at + 16);
        std::uint64_t const packed = word(at + 20), size = word(at + 24), local = word(at + 42);
        if ((flags & 1u) != 0) refuse_entry("is encrypted");
        if (method != 0 && method != 8) refuse_entry("is compressed by another method than deflate");
        // The directory counts, not the local header: with a data descriptor that has no sizes.
        if (local > directory_ || directory_ - local < 30 || word(local) != 0x04034b50u) refuse_entry("has no header");
        std::uint64_t const from = local + 30 + half(local + 26) + half(local + 28);
        if (from > directory_ || directory_ - from < packed) refuse_entry("is cut off");
        // JSON and pictures do not compress further than this, a ZIP bomb does.
        if (size > 65536 + 32 * packed) refuse_entry("promises more bytes than it can hold");
        if (method == 0 && size != packed) refuse_entry("is stored and has two sizes");
        ByteView const in = bytes_.subspan(static_cast<std::size_t>(from), static_cast<std::size_t>(packed));
        Bytes out;
        if (method == 0) {
            out.assign(in.begin(), in.end());
        } else {
            out.resize(static_cast<std::size_t>(size));
            auto const result = codecs_.deflate(in, out);
            if (result.damaged || !result.ended || result.bytes != size) refuse_entry("is damaged");
        }
        if (codecs_.crc32(out) != checksum) refuse_entry("is damaged (its checksum differs)");
        return out;
    }

    ByteView bytes_;
    Codecs const& codecs_;
    std::string const& file_;
    std::uint32_t entries_ = 0;
    std::uint64_t directory_ = 0, directory_end_ = 0;
};

}}} // namespace tilemesh::v0_2::scene::detail
