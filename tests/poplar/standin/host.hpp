// A stand-in for the host headers of the Poplar SDK, written from public documents: the calls of the library and of its example, and what
// these calls refuse. ../standin.cpp defines it. It is never installed. All elements take one word of 32 bits.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace standin {
struct Interval { ///< elements of a variable
    unsigned variable;
    std::size_t begin, end;
};
struct GraphData;
struct VertexData;
struct Node; // a program
class Executable;
unsigned tiles();
std::size_t tile_bytes();
} // namespace standin

namespace poplar {

struct poplar_error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

enum Type { BOOL, UNSIGNED_INT };
enum class TargetType { IPU };

class Target {
public:
    unsigned getNumTiles() const { return tiles_; }
    std::size_t getBytesPerTile() const { return bytes_; }
    unsigned getNumWorkerContexts() const { return 6; }

private:
    unsigned tiles_ = standin::tiles();
    std::size_t bytes_ = standin::tile_bytes();
};

/// Move only, as in the SDK.
class Device {
public:
    Device() = default;
    Device(Device&&) = default;
    Device& operator=(Device&&) = default;
    bool attach() const { return !std::exchange(attached_, true); }
    bool isAttached() const { return attached_; }
    Target const& getTarget() const { return target_; }

private:
    Target target_;
    mutable bool attached_ = false;
};

class DeviceManager {
public:
    static DeviceManager createDeviceManager() { return {}; }
    std::vector<Device> getDevices(TargetType, unsigned ipus) const { return std::vector<Device>(ipus); }
};

/// A view of elements of variables, in row-major order.
class Tensor {
public:
    std::size_t numElements() const;
    unsigned rank() const { return static_cast<unsigned>(shape_.size()); }
    Tensor slice(std::size_t begin, std::size_t end, unsigned dimension = 0) const;
    Tensor operator[](std::size_t i) const;
    Tensor reshape(std::vector<std::size_t> const& shape) const;
    Tensor flatten() const { return reshape({numElements()}); }
    Tensor broadcast(unsigned times, unsigned dimension) const;

private:
    friend class Graph;
    friend class standin::Executable;
    friend struct standin::Node;
    friend Tensor concat(std::vector<Tensor> const& tensors, unsigned dimension);
    Type type_ = UNSIGNED_INT;
    std::vector<std::size_t> shape_{0};
    std::vector<standin::Interval> parts_;
};
Tensor concat(std::vector<Tensor> const& tensors, unsigned dimension = 0);

struct DataStream {
    std::string handle_;
    std::size_t elements_;
    bool to_device_;
};

class ComputeSet {
    friend class Graph;
    friend struct standin::Node;
    std::size_t id_ = 0;
};

/// A field of a vertex, or one edge of a list.
class FieldRef {
public:
    FieldRef operator[](std::size_t i) const;

private:
    friend class Graph;
    friend class VertexRef;
    standin::VertexData* vertex_;
    std::size_t field_, index_ = 0;
    bool indexed_ = false;
};

class VertexRef {
public:
    FieldRef operator[](char const* name) const;

private:
    friend class Graph;
    standin::VertexData* vertex_ = nullptr;
};

class Graph {
public:
    explicit Graph(Target const& target);
    /// Makes the linked codelets known, for any path.
    void addCodelets(std::string const& path);
    Tensor addVariable(Type type, std::vector<std::size_t> const& shape, std::string const& name);
    void setTileMapping(Tensor const& tensor, unsigned tile);
    void setTileMapping(VertexRef const& vertex, unsigned tile);
    ComputeSet addComputeSet(std::string const& name);
    VertexRef addVertex(ComputeSet const& set, std::string const& name);
    void setFieldSize(FieldRef const& field, std::size_t size);
    void connect(FieldRef const& field, Tensor const& tensor);
    void setInitialValue(FieldRef const& field, unsigned value);
    DataStream addHostToDeviceFIFO(std::string const& handle, Type type, std::size_t elements);
    DataStream addDeviceToHostFIFO(std::string const& handle, Type type, std::size_t elements);

private:
    friend class Engine;
    std::shared_ptr<standin::GraphData> data_;
};

namespace program {
class Program {
public:
    explicit Program(standin::Node node);
    std::shared_ptr<standin::Node const> node() const { return node_; }

protected:
    std::shared_ptr<standin::Node> node_;
};
struct Sequence : Program {
    Sequence();
    void add(Program const& program);
};
struct Execute : Program {
    explicit Execute(ComputeSet const& set);
};
struct Copy : Program {
    Copy(Tensor const& source, Tensor const& destination);
    Copy(DataStream const& stream, Tensor const& destination);
    Copy(Tensor const& source, DataStream const& stream);
};
struct Repeat : Program {
    Repeat(unsigned count, Program const& body);
};
struct RepeatWhileTrue : Program {
    RepeatWhileTrue(Program const& condition, Tensor const& predicate, Program const& body);
};
struct If : Program {
    If(Tensor const& predicate, Program const& where_true, Program const& where_false);
};
} // namespace program

/// A graph and its programs in tile memory.
class Engine {
public:
    Engine(Graph const& graph, std::vector<program::Program> const& programs);
    void load(Device const& device);
    void connectStream(std::string const& handle, void* memory);
    void connectStreamToCallback(std::string const& handle, std::function<void(void*)> callback);
    void run(unsigned program);
    standin::Executable const& executable() const { return *executable_; }

private:
    std::shared_ptr<standin::Executable> executable_;
};

} // namespace poplar
