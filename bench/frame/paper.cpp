#include "machine.hpp"
#include <common/machine_of.hpp>

std::unique_ptr<frame::Machine> frame::make_paper(tilemesh::scene::Map const& map, tilemesh::splat::Arithmetic arithmetic,
                                                  std::uint32_t threads)
{
    return std::make_unique<bench::MachineOf<Lossless>>(map, arithmetic, tilemesh::RendererOptions{.threads = threads});
}
