#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/mesh_options.hpp>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/operations.hpp>
#include <type_traits>
#include <utility>

/// The port of a mesh: what a host does with a mesh between runs, without the engine's type. A renderer over a port is compiled without
/// kernels, and one renderer serves every engine. No call passes the port while a kernel runs.
namespace tilemesh { inline namespace v0_2 {

namespace engine {

/// A mesh of one program on some engine. States, channels and broadcasts have their numbers in `Needs<Program>`. Functions are those of
/// Mesh, with numbers instead of types.
template <class Program>
class Port {
public:
    virtual ~Port() = default;
    virtual RunCounters run() = 0;
    virtual machine::Place state_place(std::uint32_t state, std::uint32_t tile) noexcept = 0;
    virtual machine::Place incoming_place(std::uint32_t link, std::uint32_t tile, Direction side) noexcept = 0;
    virtual void* broadcast(std::uint32_t number) noexcept = 0;
    virtual Program& program() noexcept = 0;
    virtual void limit_state(std::uint32_t state, std::uint32_t items) = 0; ///< does nothing for a struct
    virtual void limit_link(std::uint32_t link, std::uint32_t items) = 0;
    virtual void run_within(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1) = 0;
    virtual void observe(Observer observer) = 0;
    /// Calls f(self, thread, threads) on each thread.
    virtual void on_threads(void (*f)(void const* self, std::uint32_t thread, std::uint32_t threads), void const* self) = 0;
    virtual Trace const& trace() const = 0;
};

/// Mesh `M` behind the port of its program.
template <class M>
class PortOver;
template <template <class, class> class M, class Program, class Machine>
class PortOver<M<Program, Machine>> final : public Port<Program> {
    using Needs = machine::Needs<Program>;

public:
    template <class Options>
    PortOver(Program const& program, Grid grid, MeshSizes<Program> const& sizes, Options const& options) : mesh_(program, grid, sizes, options)
    {
    }
    RunCounters run() override { return mesh_.run(); }
    machine::Place state_place(std::uint32_t state, std::uint32_t tile) noexcept override { return mesh_.view().place(state, tile); }
    machine::Place incoming_place(std::uint32_t link, std::uint32_t tile, Direction side) noexcept override
    {
        return mesh_.incoming_place(link, tile, side);
    }
    void* broadcast(std::uint32_t number) noexcept override
    {
        void* parameters = nullptr;
        pick(typename Needs::Shareds{}, number, [&]<class P>(machine::Tag<P>) { parameters = &mesh_.template broadcast<P>(); });
        return parameters;
    }
    Program& program() noexcept override { return mesh_.program(); }
    void limit_state(std::uint32_t state, std::uint32_t items) override
    {
        if (mesh_.view().states[state].list) mesh_.view().limit_state(state, items);
    }
    void limit_link(std::uint32_t link, std::uint32_t items) override { mesh_.limit_link(link, items); }
    void run_within(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1) override { mesh_.run_within(x0, y0, x1, y1); }
    void observe(Observer observer) override { mesh_.observe(std::move(observer)); }
    void on_threads(void (*f)(void const*, std::uint32_t, std::uint32_t), void const* self) override
    {
        mesh_.on_threads([&](std::uint32_t thread, std::uint32_t threads) { f(self, thread, threads); });
    }
    Trace const& trace() const override { return mesh_.trace(); }

private:
    template <class... X, class F>
    static void pick(machine::Types<X...>, [[maybe_unused]] std::uint32_t number, [[maybe_unused]] F const& f)
    {
        [[maybe_unused]] std::uint32_t i = 0;
        ((i++ == number ? f(machine::Tag<X>{}) : void()), ...);
    }

    M<Program, Machine> mesh_;
};

} // namespace engine

/// Makes a mesh behind a port. The machine can keep traces; `options.trace` says whether this mesh does.
template <class Program>
using MakePort = std::unique_ptr<engine::Port<Program>>(Program const&, Grid, MeshSizes<Program> const&, MeshOptions const&);
/// A Mesh behind a port. The definition is in engine/mesh.hpp.
template <class Program>
std::unique_ptr<engine::Port<Program>> make_threads_port(Program const& program, Grid grid, MeshSizes<Program> const& sizes,
                                                         MeshOptions const& options);
/// A CheckedMesh behind a port. The definition is in engine/checked_mesh.hpp.
template <class Program>
std::unique_ptr<engine::Port<Program>> make_checked_port(Program const& program, Grid grid, MeshSizes<Program> const& sizes,
                                                         MeshOptions const& options);

/// Options of a PortMesh. It keeps a trace only if `trace` is set, because its machine is always Traced.
template <class Program>
struct PortOptions : MeshOptions {
    PortOptions() { trace = false; }
    MakePort<Program>* make = make_threads_port<Program>; ///< makes the engine
};

/// A mesh behind a port: its engine is a value (`PortOptions::make`). It has the members of Mesh that hosts call between runs, with the same
/// meaning, cost and errors. A reader of states makes no virtual call for each tile: the mesh asks once where they are.
template <class Program, class Machine = Traced<AnyMachine>>
class PortMesh {
    static_assert(std::is_same_v<Machine, Traced<AnyMachine>>, "a machine other than Traced<AnyMachine> (a port has its machine as a value, "
                                                               "and its options say whether it keeps a trace); name that one");
    using Shareds = typename machine::Needs<Program>::Shareds;

public:
    using States = typename machine::Needs<Program>::States;
    using Links = typename machine::Needs<Program>::Links;
    using Options = PortOptions<Program>;
    using Sizes = MeshSizes<Program>;

    PortMesh(Program const& program, Grid grid, Sizes const& sizes, Options const& options)
        : grid_(grid), machine_(sizes.machine), port_(options.make(program, grid, sizes, options))
    {
        for (std::uint32_t i = 0; i < States::count; ++i) find(i);
        for (std::uint32_t i = 0; i < Shareds::count; ++i) shared_[i] = port_->broadcast(i);
    }

    Grid grid() const noexcept { return grid_; }
    MachineSize const& machine() const noexcept { return machine_; }
    Program& program() noexcept { return port_->program(); }
    template <class X>
    decltype(auto) state(TileId t) noexcept
    {
        auto const place = place_of<X>(t);
        if constexpr (is_list<X>)
            return X{place};
        else
            return static_cast<X&>(*reinterpret_cast<X*>(place.items));
    }
    template <class X>
    decltype(auto) state(TileId t) const noexcept
    {
        auto const place = place_of<X>(t);
        if constexpr (is_list<X>) {
            X const view{place};
            return view;
        } else {
            return static_cast<X const&>(*reinterpret_cast<X const*>(place.items));
        }
    }
    template <class P>
    P& broadcast() noexcept
    {
        return *static_cast<P*>(shared_[machine::index_in<P>(Shareds{})]);
    }
    template <class C>
    typename C::Receiver incoming(TileId t, Direction d) noexcept
    {
        return typename C::Receiver{port_->incoming_place(machine::index_in<C>(Links{}), grid_.index_of(t), d)};
    }
    template <class X>
    void limit(std::uint32_t items)
    {
        if constexpr (is_channel<X>) {
            port_->limit_link(machine::index_in<X>(Links{}), items);
        } else {
            constexpr auto i = machine::index_in<X>(States{});
            port_->limit_state(i, items);
            find(i);
        }
    }
    void run_within(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1) { port_->run_within(x0, y0, x1, y1); }
    void observe(Observer observer) { port_->observe(std::move(observer)); }
    template <class F>
    void on_threads(F const& f)
    {
        port_->on_threads([](void const* self, std::uint32_t thread, std::uint32_t threads) { (*static_cast<F const*>(self))(thread, threads); }, &f);
    }
    Trace const& trace() const { return port_->trace(); }
    RunCounters run() { return port_->run(); }

private:
    /// The places of a state: those of tile 0, and the words from a tile to the next.
    struct Region {
        std::uint32_t *heads, *items;
        std::ptrdiff_t head_stride, item_stride;
        std::uint32_t capacity;
    };
    void find(std::uint32_t state) noexcept
    {
        auto const first = port_->state_place(state, 0), second = port_->state_place(state, grid_.size() > 1 ? 1 : 0);
        regions_[state] = {first.head, first.items, first.head != nullptr ? second.head - first.head : 0, second.items - first.items,
                           first.capacity};
    }
    template <class X>
    machine::Place place_of(TileId t) const noexcept
    {
        static_assert(machine::contains<X, States>, "no kernel of this program keeps this state");
        Region const& r = regions_[machine::index_in<X>(States{})];
        auto const i = static_cast<std::ptrdiff_t>(grid_.index_of(t));
        return {is_list<X> ? r.heads + i * r.head_stride : nullptr, r.items + i * r.item_stride, r.capacity};
    }

    Grid grid_;
    MachineSize machine_;
    std::unique_ptr<engine::Port<Program>> port_;
    std::array<Region, States::count + 1> regions_{};
    std::array<void*, Shareds::count + 1> shared_{};
};

}} // namespace tilemesh
