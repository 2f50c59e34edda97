#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <istream>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// Words of a header, quoted for a message.
TILEMESH_HOST std::string in_quotes(std::string_view text);

/// The bytes of a stream from its current position to its end. They are read once and in order; at most 1 MiB of them is in memory. Throws
/// `Error` if the stream has no known size or ends before it; the message begins with `file`.
class ByteSource {
public:
    static constexpr std::size_t capacity = std::size_t{1} << 20;

    TILEMESH_HOST ByteSource(std::istream& stream, std::string file);

    std::uint64_t size() const { return size_; }
    std::uint64_t left() const { return size_ - fetched_ + (end_ - begin_); }

    /// The next `n` bytes, valid until the next call; n is at most `capacity`. If fewer bytes are left, it returns null and takes none.
    TILEMESH_HOST unsigned char const* take(std::size_t n);
    /// Takes the next byte; `peek` does not take it. Both return -1 at the end.
    int get() { return begin_ < end_ || fetch(1) ? buffer_[begin_++] : -1; }
    int peek() { return begin_ < end_ || fetch(1) ? buffer_[begin_] : -1; }

    /// Are the next bytes equal to `text`? Takes none.
    TILEMESH_HOST bool begins_with(std::string_view text);
    /// Skips `n` bytes. If fewer bytes are left, it returns false and skips none.
    TILEMESH_HOST bool skip(std::uint64_t n);

private:
    /// Fills the buffer until `n` bytes are contiguous; false if fewer are left.
    TILEMESH_HOST bool fetch(std::size_t n);

    std::istream& stream_;
    std::string file_;
    std::uint64_t size_ = 0;
    std::uint64_t fetched_ = 0;         ///< bytes that were read or skipped
    std::vector<unsigned char> buffer_; ///< [begin_, end_) is read and not yet taken
    std::size_t begin_ = 0, end_ = 0;
};

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/ply_source_code.hpp>
#endif
