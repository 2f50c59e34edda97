#include "machine.hpp"
#include <common/machine_of.hpp>

namespace {

/// `lossless` with more slots and pixels a tile: capacity is address space, and costs no memory until it is used.
struct Scaled : tilemesh::splat::Lossless {
    static constexpr char const* name = "lossless, scaled";
    using Machine = tilemesh::TestMachine<64u << 20>;
    static constexpr std::uint32_t storage_slots = 40'000; ///< Sloth on 10 x 9 tiles, a million Gaussians on 1,440
    static constexpr std::uint32_t tile_pixels =
        128 * 80; ///< 1280 x 720 on 10 x 9 tiles; 3840 x 2160 on 40 x 36 has 96 x 60
};

} // namespace

std::unique_ptr<bench::Machine> scaling::make_machine(tilemesh::scene::Map const& map,
                                                      tilemesh::RendererOptions const& options)
{
    return std::make_unique<bench::MachineOf<Scaled>>(map, Scaled::arithmetic, options);
}
