#pragma once
#include <cstdio>
#include <cstdlib>
#include <tilemesh/config.hpp>

namespace tilemesh::engine::detail {
/// Where a broken contract of the tile that this thread runs is noted; null outside a run.
inline thread_local char const** broken_contract = nullptr;
} // namespace tilemesh::engine::detail

/// The host's handler: inside a run it notes the first text, and the engine reports it with tile and superstep after the
/// barrier; outside a run it prints the text and aborts. Weak: a program may define its own.
extern "C" [[gnu::weak]] void tilemesh_contract_broken(char const* text) noexcept
{
    using tilemesh::engine::detail::broken_contract;
    if (broken_contract == nullptr) {
        std::fprintf(stderr, "tilemesh: %s\n", text);
        std::abort();
    }
    if (*broken_contract == nullptr) *broken_contract = text;
}
