#include "machine_of.hpp"

std::unique_ptr<error_vs_time::Machine> error_vs_time::make_hold(scene::Map const& map, Setting const& setting, std::uint32_t threads)
{
    return std::make_unique<MachineOf<splat::Hold>>(map, setting, threads);
}
