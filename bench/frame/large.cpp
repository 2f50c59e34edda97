#include "machine.hpp"
#include <common/machine_of.hpp>

namespace {

struct Large : frame::Lossless {
    static constexpr char const* name = "lossless, large";
    using Machine = tilemesh::TestMachine<64u << 20>;
    /// Of the 250,000 records of the object capture that this is for, with their copies.
    static constexpr std::uint32_t storage_slots = 20'000;
};

} // namespace

std::unique_ptr<frame::Machine> frame::make_large(tilemesh::scene::Map const& map, tilemesh::splat::Arithmetic arithmetic,
                                                  std::uint32_t threads)
{
    return std::make_unique<bench::MachineOf<Large>>(map, arithmetic, tilemesh::RendererOptions{.threads = threads});
}
