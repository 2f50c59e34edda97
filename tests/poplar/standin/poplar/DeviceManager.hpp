#pragma once
#include "Device.hpp"
#include <cstddef>
#include <vector>

/// Part of a stand-in for the Poplar SDK: finds devices.
namespace poplar {

class DeviceManager {
public:
    static DeviceManager createDeviceManager() { return {}; }

    /// One device with the size in `standin::settings()`, if the caller asks for one IPU. No other kind exists.
    std::vector<Device> getDevices(TargetType type, unsigned ipus) const
    {
        std::vector<Device> found;
        if (type == TargetType::IPU && ipus == 1) found.emplace_back();
        return found;
    }
};

} // namespace poplar
