#include "machine.hpp"
#include <common/machine_of.hpp>

namespace {

struct Wide : frame::Lossless {
    static constexpr char const* name = "lossless, wide";
    using Machine = tilemesh::TestMachine<tilemesh::Mk2::sram_bytes, 100'000>;
};

} // namespace

std::unique_ptr<frame::Machine> frame::make_wide(tilemesh::scene::Map const& map, tilemesh::splat::Arithmetic arithmetic,
                                                 std::uint32_t threads, tilemesh::splat::Camera const& camera)
{
    auto const part = [](std::uint32_t size, std::uint32_t tiles) { return (size + tiles - 1) / tiles; };
    return std::make_unique<bench::MachineOf<Wide>>(
        map, arithmetic,
        tilemesh::RendererOptions{
            .threads = threads, .grid = {400, 250}, .tile = {part(camera.width, 40), part(camera.height, 36)}});
}
