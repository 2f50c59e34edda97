#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/machine/name.hpp>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// What a kernel did on a tile that need not run: the first word that it changed, or a message or vote. CheckedMesh looks for it.
struct QuietChange {
    enum class Kind : std::uint32_t { nothing, vote, message, size, word, item };
    Kind kind = Kind::nothing;
    machine::Name region{};          ///< of the state or channel
    std::uint32_t word = 0;          ///< in the struct, or in the item
    std::uint32_t item = 0;          ///< of a list
    std::uint32_t before = 0, after = 0;

    explicit operator bool() const noexcept { return kind != Kind::nothing; }
    /// The error's text. `outside`: the tile lies outside the rectangle of run_within.
    std::string text(bool outside) const;
};

}}} // namespace tilemesh::engine

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/engine/detail/quiet_change_code.hpp>
#endif
