#pragma once
#include "../detail/settings.hpp"
#include <cstddef>

/// Part of a stand-in for the Poplar SDK: the facts about the machine that a graph needs.
namespace poplar {

enum class TargetType { IPU, IPU_MODEL, CPU };

class Target {
public:
    Target() = default;
    unsigned getNumTiles() const { return tiles_; }
    std::size_t getBytesPerTile() const { return bytes_; }
    unsigned getNumWorkerContexts() const { return 6; }
    TargetType getTargetType() const { return TargetType::IPU; }

private:
    unsigned tiles_ = standin::settings().tiles;
    std::size_t bytes_ = standin::settings().tile_bytes;
};

} // namespace poplar
