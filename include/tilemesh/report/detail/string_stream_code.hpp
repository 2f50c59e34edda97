#pragma once
#include <cstddef>
#include <ios>
#include <ostream>
#include <streambuf>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/report/string_stream.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST StringStream::StringStream()
    : std::ostream(nullptr)
{
    rdbuf(&buffer_);
    exceptions(std::ios::badbit);
}

}}} // namespace tilemesh::report
