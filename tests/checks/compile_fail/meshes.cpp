// Mistakes that a mesh refuses, or an engine for other machines.
#include <tilemesh/engine/contract.hpp>
#include <tilemesh/engine/mesh.hpp>
using namespace tilemesh;

struct Cell {
    float heat;
};
struct Counting {
    enum Kind : unsigned { heated };
    static constexpr char const* names[] = {"heated"};
};

// CASE bare_kernel_of_mesh
// EXPECT: not a program .*wrap the kernel in one of them
struct Step {
    void operator()(Cell&) const noexcept {}
};
void run() { Mesh{Step{}, Grid{2, 2}}.run(); }

// CASE all_workers_with_other_parameters
// EXPECT: a kernel's AllWorkers takes other parameters than the kernel
struct Step {
    void operator()(Cell&, Worker) const noexcept {}
    struct AllWorkers {
        void operator()(Cell&, Here, Worker) const noexcept {}
    };
};
void run() { Mesh<Superstep<Step>>{{}, {2, 2}}.run(); }

// CASE all_workers_without_worker
// EXPECT: only a kernel that takes Worker may have AllWorkers
struct Step {
    void operator()(Cell&) const noexcept {}
    struct AllWorkers {
        void operator()(Cell&) const noexcept {}
    };
};
void run() { Mesh<Superstep<Step>>{{}, {2, 2}}.run(); }

// CASE channel_with_members
// EXPECT: a named channel with members of its own
struct Wire : Channel<float, 4> {
    float sum;
};
struct Step {
    void operator()(In<Wire>, Out<Wire> out) const noexcept { out.to_all(0); }
};
void run() { Mesh{Superstep<Step>{}, Grid{2, 2}}.run(); }

// CASE mesh_on_misspelt_machine
// EXPECT: no machine .it has the members name, tiles, sram_bytes, code_bytes, workers and clock_khz, as Mk2 has.; look for a misspelt one
struct Step {
    void operator()(Cell&) const noexcept {}
};
struct Mine {
    static constexpr char const* name = "mine";
    static constexpr std::uint32_t tiles = 256, workers = 4, clock_khz = 500'000, sram_bytes = 32 * 1024, code_byte = 8 * 1024;
};
void run() { Mesh{Superstep<Step>{}, Grid{2, 2}, Traced<Mine>{}}.run(); }

// CASE mesh_on_setup
// EXPECT: no machine .*a setup is not one: give its Machine
#include <tilemesh/splat/setup_types.hpp>
struct Step {
    void operator()(Cell&) const noexcept {}
};
void run() { Mesh{Superstep<Step>{}, Grid{2, 2}, splat::Lossless{}}.run(); }

// CASE model_of_no_machine
// EXPECT: no machine .it has the members name, tiles, sram_bytes, code_bytes, workers and clock_khz, as Mk2 has.; look for a misspelt one
#include <tilemesh/model/assumed_parameters.hpp>
struct Mine {
    static constexpr char const* names = "mine";
    static constexpr std::uint32_t tiles = 256, workers = 4, clock_khz = 500'000, sram_bytes = 32 * 1024, code_bytes = 8 * 1024;
};
auto model() { return assumed_model<Mine>(4, 100); }

// CASE operations_not_static
// EXPECT: a kernel's operations is .static Operations
struct Step {
    void operator()(Cell&) const noexcept {}
    Operations<Counting> operations(Cell const&) const noexcept { return {}; }
};
void run() { Mesh{Superstep<Step>{}, Grid{2, 2}}.run(); } // not Traced

// CASE operations_of_other_state
// EXPECT: a kernel's operations takes what the kernel does not
struct Other {
    float heat;
};
struct Step {
    void operator()(Cell&) const noexcept {}
    static Operations<Counting> operations(Other const&) noexcept { return {}; }
};
void run() { Mesh{Superstep<Step>{}, Grid{2, 2}}.run(); } // not Traced

// CASE operations_overloaded
// EXPECT: a kernel's operations is one function .it is overloaded, a template or private
struct Step {
    void operator()(Cell&) const noexcept {}
    static Operations<Counting> operations() noexcept { return {}; }
    static Operations<Counting> operations(Cell const&) noexcept { return {}; }
};
void run() { Mesh{Superstep<Step>{}, Grid{2, 2}}.run(); } // not Traced

// CASE kernels_of_one_name
// EXPECT: two kernels of a program with one name
#include <tilemesh/poplar/program_graph.hpp>
template <std::uint32_t N>
struct Add {
    void operator()(Cell& cell) const noexcept { cell.heat += N; }
};
template class on_poplar::ProgramGraph<Sequence<Superstep<Add<1>>, Superstep<Add<100>>>, Mk2>;

// CASE sizes_of_no_setup
// EXPECT: a region of this program names a member of sizes that were not given; name the setup that has them
struct Slots {
    std::uint32_t pile = 0;
};
struct Pile : Buffer<std::uint32_t> {
    static constexpr auto slots = &Slots::pile;
};
struct Step {
    void operator()(Pile&) const noexcept {}
};
void run() { Mesh<Superstep<Step>>{{}, {2, 2}}.run(); }

// CASE sizes_over
// EXPECT: the program does not fit in a tile's SRAM
// EXPECT: SramBudget<.*TestMachine<1024.*, Pile, 1012U?, 20U?>
// 1,024 bytes: 8 words of state, and a pile of 251 words and its head. The setup's slots are a constant: nobody has to run it.
struct Slots {
    std::uint32_t pile = 0;
};
struct Eight {
    float part[8];
};
struct Pile : Buffer<float> {
    static constexpr auto slots = &Slots::pile;
};
struct Step {
    void operator()(Eight&, Pile&) const noexcept {}
};
template <std::uint32_t N>
struct Setup {
    static constexpr Slots sizes{N};
};
auto full() { return mesh_sizes<Superstep<Step>, TestMachine<1024>, Setup<246>>(); } // fits exactly
auto over() { return mesh_sizes<Superstep<Step>, TestMachine<1024>, Setup<251>>(); }
