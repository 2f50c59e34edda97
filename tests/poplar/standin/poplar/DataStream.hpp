#pragma once
#include "Type.hpp"
#include <cstddef>
#include <string>
#include <utility>

/// Part of a stand-in for the Poplar SDK: a named stream between host and device.
namespace poplar {

class Graph;

class DataStream {
public:
    std::string const& handle() const { return handle_; }
    std::size_t numElements() const { return elements_; }
    Type elementType() const { return type_; }

    /// Does the stream go from the host to the device?
    bool to_device() const { return to_device_; }

private:
    friend class Graph;
    DataStream(std::string handle, Type type, std::size_t elements, bool to_device)
        : handle_(std::move(handle)), type_(type), elements_(elements), to_device_(to_device)
    {}
    std::string handle_;
    Type type_;
    std::size_t elements_;
    bool to_device_;
};

} // namespace poplar
