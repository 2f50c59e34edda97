#pragma once
#include "Target.hpp"
#include <utility>

/// Part of a stand-in for the Poplar SDK: a device, which holds one engine at a time.
namespace poplar {

/// Move only, as in the SDK.
class Device {
public:
    Device() = default;
    Device(Device&& other) noexcept : target_(other.target_), attached_(std::exchange(other.attached_, false)) {}
    Device& operator=(Device&& other) noexcept
    {
        target_ = other.target_;
        attached_ = std::exchange(other.attached_, false);
        return *this;
    }

    /// Attaches the device. Returns false if it is already attached.
    bool attach() const { return !std::exchange(attached_, true); }
    void detach() const { attached_ = false; }
    bool isAttached() const { return attached_; }
    Target const& getTarget() const { return target_; }

private:
    Target target_;
    mutable bool attached_ = false;
};

} // namespace poplar
