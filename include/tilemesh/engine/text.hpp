#pragma once
#include <string>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/name.hpp>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// A name or a tile as text, for errors and counters.
inline std::string text(machine::Name name)
{
    return std::string(name.text, name.size);
}
inline std::string text(TileId t)
{
    std::string s = "("; // piece by piece: GCC 12 sees an overlap in `"(" + std::to_string(...)` (its bug 105651)
    s += std::to_string(t.x());
    s += ", ";
    s += std::to_string(t.y());
    return s += ")";
}

}}} // namespace tilemesh::engine
