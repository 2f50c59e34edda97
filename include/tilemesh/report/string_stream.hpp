#pragma once
#include <cstddef>
#include <ios>
#include <ostream>
#include <streambuf>
#include <string>
#include <tilemesh/config.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// A stream into a string. Out of memory, it throws `std::bad_alloc`. A plain std::ostringstream would silently cut the text short: the
/// buffer of libc++ swallows the exception.
class StringStream : public std::ostream {
public:
    StringStream() : std::ostream(nullptr)
    {
        rdbuf(&buffer_);
        exceptions(std::ios::badbit);
    }
    std::string const& str() const noexcept { return buffer_.text; }

private:
    struct Buffer : std::streambuf {
        std::string text;

    private:
        int_type overflow(int_type c) override
        {
            if (!traits_type::eq_int_type(c, traits_type::eof())) text.push_back(traits_type::to_char_type(c));
            return traits_type::not_eof(c);
        }
        std::streamsize xsputn(char const* begin, std::streamsize size) override
        {
            text.append(begin, static_cast<std::size_t>(size));
            return size;
        }
    };
    Buffer buffer_;
};

}}} // namespace tilemesh::report
