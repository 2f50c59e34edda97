#include "machine_of.hpp"

std::unique_ptr<channel_capacity::Machine> channel_capacity::make_drop(scene::Map const& map, Machine::Options options)
{
    return std::make_unique<MachineOf<Dropped>>(map, options);
}
