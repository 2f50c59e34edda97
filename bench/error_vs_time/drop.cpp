#include "machine_of.hpp"

std::unique_ptr<error_vs_time::Machine> error_vs_time::make_drop(scene::Map const& map, Setting const& setting, std::uint32_t threads)
{
    return std::make_unique<MachineOf<splat::Drop>>(map, setting, threads);
}
