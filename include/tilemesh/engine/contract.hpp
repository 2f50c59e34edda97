#pragma once
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <tilemesh/config.hpp>

namespace tilemesh::engine::detail {
/// The contracts that a kernel broke on a tile.
struct BrokenContracts {
    char const* first = nullptr; ///< its text; null while none is broken
    std::uint32_t count = 0;
};
/// Where those of the tile that this thread runs are noted; null outside a run.
inline thread_local BrokenContracts* broken_contracts = nullptr;
} // namespace tilemesh::engine::detail

/// The host's handler: inside a run it notes the first text and counts, and the engine reports them with tile and superstep after the
/// barrier; outside a run it prints the text and aborts. NDEBUG changes neither. Weak: a program may define its own.
extern "C" [[gnu::weak]] void tilemesh_contract_broken(char const* text) noexcept
{
    auto* const broken = tilemesh::engine::detail::broken_contracts;
    if (broken == nullptr) {
        std::fprintf(stderr, "tilemesh: %s\n", text);
        std::abort();
    }
    if (broken->count++ == 0) broken->first = text;
}
