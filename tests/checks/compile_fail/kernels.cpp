// Mistakes in kernels, states, channels and programs.
#include <tilemesh/machine/tile.hpp>
using namespace tilemesh;

struct Cell {
    float heat;
};
struct Wire : Channel<Cell, 4> {};
/// The bytes of a program of these kernels.
template <class... Kernels>
constexpr auto bytes_of = Tile<Mk2, Sequence<Superstep<Kernels>...>>::bytes;

// CASE control
// COMPILES
struct Pile : Buffer<Cell, 8> {};
struct Rate {
    float rate;
};
struct Exchange { // what the others are near misses of
    Vote operator()(Cell& cell, Pile& pile, In<Wire> in, Out<Wire> out, Broadcast<Rate> p, Here) const noexcept
    {
        cell.heat *= p->rate;
        for (Direction d : news)
            if (!in[d].empty() && out[d].try_push(cell)) pile.truncate(0);
        return Vote::quiet;
    }
};
struct Work {
    void operator()(Cell const&, Pile&, Worker) const noexcept {}
};
static_assert(Tile<Mk2, Sequence<Superstep<Exchange>, Repeat<Exchange>, UntilQuiet<Exchange>, Superstep<Work>>>::bytes > 0);

// CASE kernel_not_const
// EXPECT: const noexcept \(a kernel has no state of its own\); add const
struct Step {
    void operator()(Cell& cell) noexcept { cell.heat = 0; }
};
static_assert(bytes_of<Step> > 0);

// CASE kernel_not_noexcept
// EXPECT: const noexcept \(tiles have no exceptions\); add noexcept
struct Step {
    void operator()(Cell& cell) const { cell.heat = 0; }
};
static_assert(bytes_of<Step> > 0);

// CASE kernel_overloaded
// EXPECT: exactly one operator\(\), neither overloaded nor a template
struct Step {
    void operator()(Cell& cell) const noexcept { cell.heat = 0; }
    void operator()(Cell const&, Here) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE kernel_template
// EXPECT: exactly one operator\(\), neither overloaded nor a template
struct Step {
    void operator()(auto& cell) const noexcept { cell.heat = 0; }
};
static_assert(bytes_of<Step> > 0);

// CASE kernel_with_members
// EXPECT: a kernel must be an empty class .*Broadcast<P>
struct Step {
    float rate = 1;
    void operator()(Cell& cell) const noexcept { cell.heat *= rate; }
};
static_assert(bytes_of<Step> > 0);

// CASE returns_int
// EXPECT: a kernel returns nothing or a Vote
struct Step {
    int operator()(Cell&) const noexcept { return 0; }
};
static_assert(bytes_of<Step> > 0);

// CASE worker_sends
// EXPECT: a kernel that takes Worker may neither send nor vote
struct Step {
    void operator()(In<Wire>, Out<Wire>, Worker) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE worker_votes
// EXPECT: a kernel that takes Worker may neither send nor vote
struct Step {
    Vote operator()(Cell&, Worker) const noexcept { return Vote::quiet; }
};
static_assert(bytes_of<Step> > 0);

// CASE state_by_value
// EXPECT: unknown kernel parameter .*change this parameter to one of them
struct Step {
    void operator()(Cell) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE state_of_six_bytes
// EXPECT: a tile.s state is a Buffer or a trivially copyable struct of whole 32-bit words
struct Six {
    std::uint16_t part[3];
};
struct Step {
    void operator()(Six&) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE state_with_double
// EXPECT: a tile.s state is a Buffer or a trivially copyable struct of whole 32-bit words .*; keep a double or a 64-bit integer as two words
struct Eight {
    double heat;
};
struct Step {
    void operator()(Eight&) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE float_as_state
// EXPECT: a tile's state is a struct of the program
struct Step {
    void operator()(float& heat) const noexcept { heat = 0; }
};
static_assert(bytes_of<Step> > 0);

// CASE dynamic_state
// EXPECT: a state.s capacity is part of the layout; give the Buffer a number
struct Pile : Buffer<Cell> {};
struct Step {
    void operator()(Pile&) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE buffer_with_members
// EXPECT: a named buffer with members of its own
struct Pile : Buffer<float, 4> {
    float sum;
};
struct Step {
    void operator()(Pile&) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE channel_as_state
// EXPECT: a channel is not state .*take In<C> or Out<C> by value
struct Step {
    void operator()(Wire&) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE per_pass_of_workers
// EXPECT: a kernel that takes Worker may not fill per_pass statistics .*count in a superstep of one worker
struct Passed {
    static constexpr bool per_pass = true;
    std::uint32_t hops;
};
struct Step {
    void operator()(Passed&, Worker) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE per_pass_read
// EXPECT: a kernel reads per_pass statistics of another pass .*keep words that kernels read in another state
struct Passed {
    static constexpr bool per_pass = true;
    std::uint32_t hops;
};
struct Step {
    void operator()(Passed const&) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE broadcast_of_six_bytes
// EXPECT: Broadcast<P>: P is copied to every tile
struct Rate {
    std::uint16_t part[3];
};
struct Step {
    void operator()(Broadcast<Rate>) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE in_by_reference
// EXPECT: are views .*take them by value
struct Step {
    void operator()(In<Wire>&, Out<Wire>) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE in_of_no_channel
// EXPECT: In<C>: C is not a channel
struct Step {
    void operator()(In<Cell>) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE message_of_six_bytes
// EXPECT: an item is copied by the exchange fabric: .*whole 32-bit words
struct Message {
    std::uint16_t part[3];
};
struct Road : Channel<Message, 4> {};
struct Step {
    void operator()(In<Road>, Out<Road>) const noexcept {}
};
static_assert(bytes_of<Step> > 0);

// CASE wire_bytes_of_six
// EXPECT: wire_bytes is what the machine moves for a message
struct Handle {
    static constexpr std::uint32_t wire_bytes = 6;
    std::uint32_t row;
};
struct Road : Channel<Handle, 4> {};
static_assert(Road::static_capacity == 4);

// CASE side_not_there
// EXPECT: a message to a side that the channel does not have
struct Row : Channel<float, 1, Edge::wrap, Sides::west> {};
struct Step {
    void operator()(In<Row>, Out<Row> out) const noexcept { out.to<Direction::east>().push(1.0f); }
};
static_assert(bytes_of<Step> > 0);

// CASE side_not_read
// EXPECT: a channel that receives nothing from this side
struct Row : Channel<float, 1, Edge::wrap, Sides::west> {};
struct Step {
    void operator()(In<Row> in, Out<Row>) const noexcept { (void)in.from<Direction::west>().size(); }
};
static_assert(bytes_of<Step> > 0);

// CASE memory_of_a_guest
// EXPECT: memory_of names a channel that itself lies in another's memory
struct Guest : Channel<Cell, 4> {
    using memory_of = Wire;
};
struct GuestOfGuest : Channel<Cell, 4> {
    using memory_of = Guest;
};
template <class C>
struct Touch {
    void operator()(In<C>, Out<C>) const noexcept {}
};
static_assert(bytes_of<Touch<Wire>, Touch<Guest>, Touch<GuestOfGuest>> > 0);

// CASE memory_of_other_sides
// EXPECT: memory_of names a channel with other sides or another edge
struct Host : Channel<float, 4, Edge::wrap, Sides::west> {};
struct Guest : Channel<float, 4, Edge::wrap, Sides::north> {
    using memory_of = Host;
};
template <class C>
struct Touch {
    void operator()(In<C>, Out<C>) const noexcept {}
};
static_assert(bytes_of<Touch<Host>, Touch<Guest>> > 0);

// CASE repeated_sender
// EXPECT: only sends on channel C while C still holds unread mail
struct Send {
    void operator()(Out<Wire>) const noexcept {}
};
struct Read {
    void operator()(In<Wire>) const noexcept {}
};
static_assert(Tile<Mk2, Sequence<Repeat<Send>, Superstep<Read>>>::bytes > 0);

// CASE sender_after_sender
// EXPECT: only sends on channel C while C still holds unread mail
struct Send {
    void operator()(Out<Wire>) const noexcept {}
};
struct SendAgain {
    void operator()(Out<Wire>) const noexcept {}
};
struct Read {
    void operator()(In<Wire>) const noexcept {}
};
static_assert(bytes_of<Send, SendAgain, Read> > 0);

// CASE bare_kernel
// EXPECT: not a program .*wrap the kernel in one of them
struct Step {
    void operator()(Cell&) const noexcept {}
};
static_assert(Tile<Mk2, Sequence<Superstep<Step>, Step>>::bytes > 0);

// CASE if_without_flag
// EXPECT: the flag of an If is a pointer to a std::uint32_t member of a broadcast .*give it If<&Parameters::flag, \.\.\.>
struct Nothing {
    void operator()() const noexcept {}
};
static_assert(StepTraits<If<&Cell::heat, Superstep<Nothing>>>::Steps::count == 1);

// CASE loop_without_step
// EXPECT: a Loop without a step .*give it one
static_assert(StepTraits<Loop<Sequence<>>>::loops == 1);

// CASE loop_not_there
// EXPECT: the program has no Loop around this step .*use get_step
struct Nothing {
    void operator()() const noexcept {}
};
void more(Sequence<Superstep<Nothing>>& program) { get_loop<Nothing>(program).at_most = 2; }

// CASE step_not_there
// EXPECT: the program has no such step .*name a kernel that it runs
struct Nothing {
    void operator()() const noexcept {}
};
struct Other {
    void operator()() const noexcept {}
};
void more(Sequence<Superstep<Nothing>>& program) { (void)get_step<Other>(program); }

// CASE machine_misspelt
// EXPECT: no machine .it has the members name, tiles, sram_bytes, code_bytes, workers and clock_khz, as Mk2 has.; look for a misspelt one
struct Step {
    void operator()(Cell&) const noexcept {}
};
struct Mine {
    static constexpr char const* name = "mine";
    static constexpr std::uint32_t tiles = 256, worker = 4, clock_khz = 500'000, sram_bytes = 32 * 1024, code_bytes = 8 * 1024;
};
constexpr auto bytes = bytes_needed<Mine, Superstep<Step>>;

// CASE sram_over
// EXPECT: the program does not fit in a tile's SRAM
// EXPECT: SramBudget<.*TestMachine<1024.*, Pile, 1008U?, 12U?>
// 1,024 bytes: 7 words of state, and a pile of 250 words and its head. Twelve bytes too many, and the pile is the largest.
struct Seven {
    float part[7];
};
struct Pile : Buffer<float, 250> {};
struct Step {
    void operator()(Seven&, Pile&) const noexcept {}
};
static_assert(Tile<TestMachine<1036>, Superstep<Step>>::bytes == 1036); // fits exactly
static_assert(Tile<TestMachine<1024>, Superstep<Step>>::bytes == 1036);

// CASE operations_of_nine_kinds
// EXPECT: a kernel counts too many kinds of operations .*most_operation_kinds
#include <tilemesh/machine/operations.hpp>
struct Nine {
    enum Kind : std::uint32_t { a, b, c, d, e, f, g, h, i };
    static constexpr char const* names[] = {"a", "b", "c", "d", "e", "f", "g", "h", "i"};
};
Operations<Nine> counted;

// CASE operations_without_names
// EXPECT: a set of operations has no names .*static constexpr char const\* names
#include <tilemesh/machine/operations.hpp>
enum class Sorting : unsigned { compare, swap };
struct Step {
    void operator()(Cell&) const noexcept {}
    static Operations<Sorting> operations(Cell const&) noexcept { return {}; }
};
static_assert(operation_names<Step>().size == 2);
Operations<Sorting> counted;
