#pragma once
#include <tilemesh/report/string_stream.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST StringStream::StringStream() : std::ostream(nullptr)
{
    rdbuf(&buffer_);
    exceptions(std::ios::badbit);
}

}}} // namespace tilemesh::report
