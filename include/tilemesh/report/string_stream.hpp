#pragma once
#include <ios>
#include <sstream>
#include <tilemesh/config.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// A stream into a string. Out of memory, it throws `std::bad_alloc` (libc++: `std::ios_base::failure`). A plain std::ostringstream would
/// silently cut the text short.
class StringStream : public std::ostringstream {
public:
    StringStream() { exceptions(std::ios::badbit); }
};

}}} // namespace tilemesh::report
