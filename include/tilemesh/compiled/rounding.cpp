// A part of tilemesh::compiled: which rounding it was built with (config.hpp).
#include <tilemesh/config.hpp>

namespace tilemesh { inline namespace v0_2 { namespace detail {
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
char const the_compiled_library_fuses_multiply_add = 1;
#else
char const the_compiled_library_does_not_fuse_multiply_add = 1;
#endif
}}} // namespace tilemesh::detail
