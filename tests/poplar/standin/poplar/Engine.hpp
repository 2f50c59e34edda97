#pragma once
#include "../detail/executable.hpp"
#include "Device.hpp"
#include "Graph.hpp"
#include "Program.hpp"
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// Part of a stand-in for the Poplar SDK: it builds and executes a graph and its programs.
namespace poplar {

/// Move only. Each engine has its own tile memory. Several engines may be built from one graph.
class Engine {
public:
    /// Lays out and checks the graph and its programs. Throws a poplar_error if something is missing, in conflict or too large.
    Engine(Graph const& graph, std::vector<program::Program> const& programs)
        : executable_(std::make_unique<standin::detail::Executable>(graph.data_, programs)),
          tiles_(graph.getTarget().getNumTiles())
    {}
    Engine(Graph const& graph, program::Program const& program) : Engine(graph, std::vector<program::Program>{program}) {}

    /// Loads the engine onto a device. All variables are undefined afterwards.
    void load(Device const& device)
    {
        if (!device.isAttached())
            throw poplar_error("The engine was not loaded (the device is not attached); call attach first");
        if (device.getTarget().getNumTiles() != tiles_)
            throw poplar_error("The engine was not loaded (the device has " +
                               std::to_string(device.getTarget().getNumTiles()) + " tiles, the graph " +
                               std::to_string(tiles_) + "); build the graph for its target");
        if (loaded_) executable_->reset();
        loaded_ = true;
    }

    /// Connects host memory to a stream. Each transfer reads or writes from the start of the memory.
    void connectStream(std::string const& handle, void* memory) { executable_->connect(handle, memory, nullptr); }
    /// Connects host memory to a stream as a ring: each transfer continues after the previous one, and the end is followed by the start.
    void connectStream(std::string const& handle, void* begin, void* end) { executable_->connect(handle, begin, end); }

    /// Connects a function to a device-to-host stream. Each transfer calls it with the data.
    void connectStreamToCallback(std::string const& handle, std::function<void(void*)> callback)
    {
        executable_->connect(handle, std::move(callback));
    }

    /// Runs a program to its end.
    void run(unsigned program = 0, std::string const& = {})
    {
        if (!loaded_)
            throw poplar_error("Program " + std::to_string(program) +
                               " did not run (the engine is on no device); call load first");
        executable_->run(program);
    }

    /// For the queries in standin.hpp.
    standin::detail::Executable const& executable() const { return *executable_; }

private:
    std::unique_ptr<standin::detail::Executable> executable_;
    unsigned tiles_;
    bool loaded_ = false;
};

} // namespace poplar
