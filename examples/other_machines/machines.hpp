#pragma once
#include <cstdint>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <tilemesh/splat/setup.hpp>

// Two machines that are not IPUs, and the slots that a frame gets on each.

struct Multiprocessors {                                  // a GPU's (NVIDIA H100 SXM), as if they had channels between neighbours
    static constexpr char const* name = "132 multiprocessors";
    static constexpr std::uint32_t tiles = 132;
    static constexpr std::uint32_t sram_bytes = 256 * 1024; // L1 and shared memory
    static constexpr std::uint32_t code_bytes = 0;          // instructions and stacks are elsewhere
    static constexpr std::uint32_t workers = 4;             // warp schedulers
    static constexpr std::uint32_t clock_khz = 1'700'000;
};
struct Wafer {                                            // a Cerebras WSE-2: 850,000 cores of 48 KB (Lie, IEEE Micro, 2023)
    static constexpr char const* name = "a wafer";
    static constexpr std::uint32_t tiles = 1000 * 850;
    static constexpr std::uint32_t sram_bytes = 48 * 1024;
    static constexpr std::uint32_t code_bytes = 8 * 1024;
    static constexpr std::uint32_t workers = 1;
    static constexpr std::uint32_t clock_khz = 1'100'000;
};

struct OnMultiprocessors : tilemesh::splat::Lossless {
    static constexpr char const* name = Multiprocessors::name;
    using Machine = tilemesh::Traced<Multiprocessors>;
    static constexpr tilemesh::splat::Sizes sizes{.storage = 1400, .road = 40, .beam = 40, .waiting = 40, .tile_pixels = 54 * 33};
};
struct OnWafer : tilemesh::splat::Lossless {
    static constexpr char const* name = Wafer::name;
    using Machine = tilemesh::Traced<Wafer>;
    static constexpr tilemesh::splat::Sizes sizes{.storage = 211, .road = 8, .beam = 8, .waiting = 8, .tile_pixels = 2 * 2};
};
