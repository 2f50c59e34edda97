#include "machine_of.hpp"

std::unique_ptr<channel_capacity::Machine> channel_capacity::make_hold(scene::Map const& map, Machine::Options options)
{
    return std::make_unique<MachineOf<Held>>(map, options);
}
