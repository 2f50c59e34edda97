#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <istream>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

TILEMESH_HOST std::string in_quotes(std::string_view text)
{
    return std::string(1, '"').append(shown(text, 40)).append(1, '"');
}

TILEMESH_HOST ByteSource::ByteSource(std::istream& stream, std::string file)
    : stream_(stream), file_(std::move(file))
{
    auto const first = stream_.tellg();
    stream_.seekg(0, std::ios::end);
    auto const last = stream_.tellg();
    stream_.seekg(first);
    if (!stream_ || first < 0 || last < first)
        throw Error(file_ + " cannot be read (its size is not known); copy it to a regular file");
    size_ = static_cast<std::uint64_t>(last - first);
    buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(size_, capacity)));
}

TILEMESH_HOST auto ByteSource::take(std::size_t n) -> unsigned char const*
{
    if (end_ - begin_ < n && !fetch(n)) return nullptr;
    begin_ += n;
    return buffer_.data() + begin_ - n;
}

TILEMESH_HOST bool ByteSource::begins_with(std::string_view text)
{
    return (end_ - begin_ >= text.size() || fetch(text.size())) &&
           std::memcmp(buffer_.data() + begin_, text.data(), text.size()) == 0;
}

TILEMESH_HOST bool ByteSource::skip(std::uint64_t n)
{
    if (n > left()) return false;
    std::uint64_t const here = std::min<std::uint64_t>(n, end_ - begin_);
    begin_ += static_cast<std::size_t>(here);
    if (here == n) return true;
    stream_.seekg(static_cast<std::streamoff>(n - here), std::ios::cur);
    fetched_ += n - here;
    return true;
}

TILEMESH_HOST bool ByteSource::fetch(std::size_t n)
{
    if (n > left()) return false;
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
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

}}} // namespace tilemesh::scene
