#pragma once
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <tilemesh/config.hpp>

namespace tilemesh { inline namespace v0_2 { namespace engine::detail {
/// The contracts that a kernel broke on a tile.
struct BrokenContracts {
    char const* first = nullptr; ///< the text of the first one; null if none is broken
    std::uint32_t count = 0;
};
/// Points to the broken contracts of the tile that this thread runs; null outside a run. As the handler it has C linkage, so a program
/// with two versions of the library has one of each, and they fit.
extern "C" {
inline thread_local BrokenContracts* tilemesh_broken_contracts = nullptr;
}
}}} // namespace tilemesh::engine::detail

/// The host's handler. Inside a run it keeps the first text and counts the calls; after the barrier the engine reports both with tile and
/// superstep. Outside a run it prints the text and aborts. NDEBUG changes nothing here. It is a weak symbol: a program may define its own
/// handler.
extern "C" [[gnu::weak]] void tilemesh_contract_broken(char const* text) noexcept
{
    auto* const broken = tilemesh::engine::detail::tilemesh_broken_contracts;
    if (broken == nullptr) {
        std::fprintf(stderr, "tilemesh: %s\n", text);
        std::abort();
    }
    if (broken->count++ == 0) broken->first = text;
}
