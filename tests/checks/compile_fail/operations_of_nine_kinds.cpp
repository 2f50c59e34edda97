// EXPECT: a kernel counts too many kinds of operations .*most_operation_kinds
#include <tilemesh/machine/operations.hpp>

struct Nine {
    enum Kind : std::uint32_t { a, b, c, d, e, f, g, h, i };
    static constexpr char const* names[] = {"a", "b", "c", "d", "e", "f", "g", "h", "i"};
};
tilemesh::Operations<Nine> counted;
