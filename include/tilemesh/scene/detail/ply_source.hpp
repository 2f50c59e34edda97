#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <istream>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// Words of a header, quoted for a message.
inline std::string in_quotes(std::string_view text)
{
    return std::string(1, '"').append(shown(text, 40)).append(1, '"');
}

/// The bytes of a stream from its current position to its end. They are read once and in order; at most 1 MiB of them is in memory. Throws
/// `Error` if the stream has no known size or ends before it; the message begins with `file`.
class ByteSource {
public:
    static constexpr std::size_t capacity = std::size_t{1} << 20;

    ByteSource(std::istream& stream, std::string file) : stream_(stream), file_(std::move(file))
    {
        auto const first = stream_.tellg();
        stream_.seekg(0, std::ios::end);
        auto const last = stream_.tellg();
        stream_.seekg(first);
        if (!stream_ || first < 0 || last < first) throw Error(file_ + " cannot be read (its size is not known); copy it to a regular file");
        size_ = static_cast<std::uint64_t>(last - first);
        buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(size_, capacity)));
    }

    std::uint64_t size() const { return size_; }
    std::uint64_t left() const { return size_ - fetched_ + (end_ - begin_); }

    /// The next `n` bytes, valid until the next call; n is at most `capacity`. If fewer bytes are left, it returns null and takes none.
    unsigned char const* take(std::size_t n)
    {
        if (end_ - begin_ < n && !fetch(n)) return nullptr;
        begin_ += n;
        return buffer_.data() + begin_ - n;
    }
    /// Takes the next byte; `peek` does not take it. Both return -1 at the end.
    int get() { return begin_ < end_ || fetch(1) ? buffer_[begin_++] : -1; }
    int peek() { return begin_ < end_ || fetch(1) ? buffer_[begin_] : -1; }

    /// Are the next bytes equal to `text`? Takes none.
    bool begins_with(std::string_view text)
    {
        return (end_ - begin_ >= text.size() || fetch(text.size())) && std::memcmp(buffer_.data() + begin_, text.data(), text.size()) == 0;
    }
    /// Skips `n` bytes. If fewer bytes are left, it returns false and skips none.
    bool skip(std::uint64_t n)
    {
        if (n > left()) return false;
        std::uint64_t const here = std::min<std::uint64_t>(n, end_ - begin_);
        begin_ += static_cast<std::size_t>(here);
        if (here == n) return true;
        stream_.seekg(static_cast<std::streamoff>(n - here), std::ios::cur);
        fetched_ += n - here;
        return true;
    }

private:
    /// Fills the buffer until `n` bytes are contiguous; false if fewer are left.
    bool fetch(std::size_t n)
    {
        if (n > left()) return false;
        std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_), buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
        end_ -= begin_;
        begin_ = 0;
        auto const more = static_cast<std::size_t>(std::min<std::uint64_t>(buffer_.size() - end_, size_ - fetched_));
        stream_.read(reinterpret_cast<char*>(buffer_.data() + end_), static_cast<std::streamsize>(more));
        if (!stream_)
            throw Error(file_ + " cannot be read to its end (from byte " + std::to_string(fetched_) +
                        " on: it changed, or the disk failed); copy the file and try again");
        end_ += more;
        fetched_ += more;
        return true;
    }

    std::istream& stream_;
    std::string file_;
    std::uint64_t size_ = 0;
    std::uint64_t fetched_ = 0;         ///< bytes that were read or skipped
    std::vector<unsigned char> buffer_; ///< [begin_, end_) is read and not yet taken
    std::size_t begin_ = 0, end_ = 0;
};

}}} // namespace tilemesh::v0_2::scene::detail
