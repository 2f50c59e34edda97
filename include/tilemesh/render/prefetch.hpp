#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/setup_facts.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// What a prefetch did (FrameRenderer::prefetch). It lies between two frames, so no frame's report counts it. All 0 if the view is that of
/// the last frame.
struct Prefetched {
    std::uint64_t exchanges = 0, messages = 0;
    std::uint64_t exchanged_live_bytes = 0;
    std::uint64_t moved = 0; ///< records that left for another anchor tile
    double host_ms = 0;
};

/// Throws Error where moving records early could change a picture.
inline void check_prefetch(SetupFacts const& facts, std::uint32_t hops)
{
    auto const refuse = [](std::string const& what, char const* why) {
        throw Error("prefetch with " + what + " (" + why + "); render without it, or choose `lossless`");
    };
    auto const setup = std::string("setup ") + facts.name;
    if (facts.policies.holds == 0) refuse(setup, "it drops records that find no room, also those that move early");
    if (!facts.routes) refuse(setup, "it does not route: the host places its records in each view");
    if (hops != 0) refuse("bounded hops", "a frame that is cut depends on where its records were before");
}

}}} // namespace tilemesh::render
