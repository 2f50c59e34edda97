// test: unoptimised test asan tsan
// The checked engine catches kernels that break the rules. Each kernel here breaks one rule. None of them runs on Mesh.
//
// One race cannot be detected and has no test: workers of one tile that write the same value to the same word in any order.
#include "everywhere.hpp"
#include "programs.hpp"

using namespace engine_test;
using engine::poison_word;

namespace {

struct Four : Buffer<std::uint32_t, 4> {};
struct UpToFour : Buffer<std::uint32_t, 4> {};
struct Big { // too large for a place beside the heads
    std::uint32_t word[40];
};
struct Wide {
    std::uint32_t id;
    float data[14];
};
struct Wides : Buffer<Wide, 3> {};
struct Wire : Channel<std::uint32_t, 2> {};
struct Hose : Channel<Wide, 2> {};
struct Out3 {
    std::uint32_t word[3];
};

/// The tile on which a kernel breaks its rule.
constexpr TileId culprit = TileId::at(1, 2);

template <class Kernel, class Load>
std::string caught(Load const& load)
{
    CheckedMesh<Superstep<Kernel>> mesh{{}, {3, 4}};
    load(mesh);
    auto const text = error_of([&] { mesh.run(); });
    if (!text.empty()) CHECK(has(error_of([&] { mesh.run(); }), "cannot run again"));
    return text;
}
template <class Kernel>
std::string caught()
{
    return caught<Kernel>([](auto&) {});
}
void check_place(std::string const& text, char const* kernel)
{
    CHECK(has(text, std::string("[tile (1, 2), superstep 0 (") + kernel + ")]"));
}

/// Does something with a list or state of one tile.
template <class X, auto Do, TileId Where = culprit>
struct On {
    static constexpr char const* name = "on";
    void operator()(X& x, Here here) const noexcept
    {
        if (here.tile == Where) Do(x);
    }
};
template <std::uint32_t Size>
using SetSize = On<Four, [](Four& four) { four.truncate(Size); }>;
template <std::uint32_t Index> // through operator[] of a list with 4 items
using WriteItem = On<Four, [](Four& four) { four.resize(4), four[Index] = 5; }>;
template <class List, std::uint32_t Items, TileId Where = culprit>
using Push = On<List,
                [](List& list) {
                    for (std::uint32_t i = 0; i < Items; ++i) list.unchecked_push({});
                },
                Where>;
using WriteBefore = On<Four, [](Four& four) { *(four.begin() - 1) = 5; }>;
using WriteLastWide = On<Wides, [](Wides& wides) { wides[2].data[13] = 5; }>;
using WritePastWide = On<Wides, [](Wides& wides) { wides[3].id = 5; }>;
template <class Struct, std::uint32_t Words>
using WritePastStruct = On<Struct, [](Struct& x) {
    auto* const words = x.word;
    __builtin_memset(words + Words - 1, 1, 8);
}>;

} // namespace

TEST_CASE("a write outside a region is caught, with tile, superstep and kernel; one inside is not")
{
    char const* const outside = "a kernel wrote outside a region of its tile";
    CHECK(caught<WriteItem<3>>().empty());
    CHECK(caught<WriteLastWide>().empty());
    for (auto const& text : {caught<WriteItem<4>>(), caught<WriteItem<5>>(), caught<WriteBefore>(), caught<WritePastWide>(),
                             caught<WritePastStruct<Out3, 3>>(), caught<WritePastStruct<Big, 40>>()}) {
        CHECK(has(text, outside));
        CHECK(has(text, "; use try_push and check indices"));
        check_place(text, "on");
    }
    // The whole item lies past the last region of the arena.
    CHECK(has(caught<Push<Wides, 4, TileId::at(2, 3)>>(), "[tile (2, 3), superstep 0 (on)]"));
}

TEST_CASE("a size above the capacity is caught, at n + 1 and not at n")
{
    CHECK(caught<SetSize<4>>().empty());
    check_place(caught<SetSize<5>>(), "on");
    check_place(caught<SetSize<0xffffffffu>>(), "on");
    check_place(caught<Push<Four, 5>>(), "on");
    auto const limited = [](std::uint32_t limit) { return caught<Push<UpToFour, 3>>([&](auto& mesh) { mesh.template limit<UpToFour>(limit); }); };
    CHECK(limited(4).empty());
    CHECK(limited(3).empty());
    check_place(limited(2), "on"); // the third item is within the region and above the limit
}

namespace {

template <std::uint32_t Count, Direction Side>
struct OverSend {
    void operator()(Here here, In<Wire>, Out<Wire> out) const noexcept
    {
        if (here.tile == culprit)
            for (std::uint32_t i = 0; i < Count; ++i) out[Side].unchecked_push(i);
    }
};
template <std::uint32_t Index>
struct WriteInEnd {
    void operator()(Here here, In<Wire> in) const noexcept
    {
        if (here.tile == culprit) const_cast<std::uint32_t&>(in[Direction::south][Index]) = 1;
    }
};
struct OverSendWide {
    void operator()(Here here, In<Hose>, Out<Hose> out) const noexcept
    {
        if (here.tile == TileId::at(2, 3))
            for (std::uint32_t i = 0; i < 3; ++i) out[Direction::south].unchecked_push({});
    }
};

} // namespace

TEST_CASE("a message too many, and a write past a channel's end, are caught")
{
    CHECK(caught<OverSend<2, Direction::north>>().empty());
    for (auto const& text :
         {caught<OverSend<3, Direction::north>>(), caught<OverSend<3, Direction::south>>(), caught<OverSend<6, Direction::east>>()}) {
        CHECK(has(text, "a kernel wrote outside channel Wire"));
        CHECK(has(text, "; use try_push"));
        check_place(text, "OverSend");
    }
    CHECK(caught<WriteInEnd<1>>().empty());
    check_place(caught<WriteInEnd<2>>(), "WriteInEnd");
    CHECK(has(caught<OverSendWide>(), "a kernel wrote outside channel Hose"));
    CHECK(has(caught<OverSendWide>(), "[tile (2, 3), superstep 0 ("));
}

TEST_CASE("the options of a Mesh are options of a CheckedMesh, which has one thread")
{
    Repeat<Diffuse> const program{3};
    Mesh mesh{program, Grid{3, 4}, {.threads = 2, .digest = true, .most_passes = 5}};
    CheckedMesh checked{program, Grid{3, 4}, {.threads = 2, .digest = true, .most_passes = 5}};
    std::uint32_t calls = 0;
    checked.on_threads([&](std::uint32_t thread, std::uint32_t threads) { calls += thread == 0 && threads == 1 ? 1 : 100; });
    CHECK(calls == 1);
    check_same(checked.run(), mesh.run());
}

namespace {

struct Found {
    std::uint32_t word[4];
};
struct ReadStale { // reads all four slots, for any size
    void operator()(Four const& four, Found& found) const noexcept
    {
        for (std::uint32_t i = 0; i < 4; ++i) found.word[i] = four[i];
    }
};
struct FillThree {
    void operator()(Four& four) const noexcept
    {
        four.truncate(0);
        for (std::uint32_t i = 0; i < 3; ++i) four.push(70 + i);
    }
};
struct KeepOne {
    void operator()(Four& four) const noexcept { four.truncate(1); }
};
struct ReadOldMail {
    void operator()(In<Wire> in, Found& found) const noexcept
    {
        for (std::uint32_t i = 0; i < 4; ++i) found.word[i] = in[news[i]][0];
    }
};
struct SayNine {
    void operator()(Out<Wire> out, Found& found) const noexcept
    {
        for (Direction d : news) out[d].push(9);
        for (std::uint32_t i = 0; i < 4; ++i) found.word[i] = out[news[i]][1]; // the slot after the message
    }
};
struct Hear {
    void operator()(In<Wire>) const noexcept {}
};
std::vector<std::uint32_t> found(auto& mesh)
{
    auto const& f = mesh.template state<Found>(culprit);
    return {f.word, f.word + 4};
}
constexpr auto dead = poison_word;

} // namespace

TEST_CASE("what is dead is poison: slots never written, items beyond the size, mail that was read")
{
    using Words = std::vector<std::uint32_t>;
    auto const found_by = []<class... Steps>(Sequence<Steps...>, int runs, auto const& load) {
        CheckedMesh<Sequence<Steps...>> mesh{{}, Grid{3, 4}};
        load(mesh);
        for (int i = 0; i < runs; ++i) mesh.run();
        return found(mesh);
    };
    auto const none = [](auto&) {};
    Superstep<ReadStale> const read;
    Superstep<FillThree> const fill;
    Superstep<KeepOne> const keep;
    Superstep<SayNine> const say;
    Superstep<ReadOldMail> const old;
    CHECK(found_by(Sequence{read}, 1, none) == Words{dead, dead, dead, dead});
    CHECK(found_by(Sequence{fill, read}, 1, none) == Words{70, 71, 72, dead});
    for (int runs : {1, 2}) CHECK(found_by(Sequence{fill, keep, read}, runs, none) == Words{70, dead, dead, dead});
    // Items that the host loaded become poison like items that a kernel wrote.
    CHECK(found_by(Sequence{keep, read}, 1, [](auto& mesh) {
              for (std::uint32_t i = 0; i < 4; ++i) mesh.template state<Four>(culprit).push(i + 1);
          }) == Words{1, dead, dead, dead});
    CHECK(found_by(Sequence{say, old}, 1, none) == Words{9, 9, 9, 9});
    CHECK(found_by(Sequence{say, old, old}, 1, none) == Words{dead, dead, dead, dead});
    CHECK(found_by(Sequence{say, Superstep<Hear>{}}, 2, none) == Words{dead, dead, dead, dead}); // a slot of an outgoing end that no kernel wrote
    float nan;
    std::memcpy(&nan, &poison_word, 4);
    CHECK(nan != nan); // read as a float, poison is not a number
}

namespace {

template <std::uint32_t N>
struct Upper : Channel<std::uint32_t, N> {};
struct Lower : Channel<std::uint32_t, 1> {
    using memory_of = Upper<2>;
};
template <bool Both>
struct UseBoth {
    void operator()(Here here, In<Upper<2>>, In<Lower>, Out<Upper<2>> upper, Out<Lower> lower) const noexcept
    {
        if (here.tile == TileId::at(1, 1)) upper[Direction::south].push(1); // with Both, both channels carry mail to (1, 2)
        if (Both && here.tile == TileId::at(0, 2)) lower[Direction::east].push(1);
        if (!Both && here.tile == TileId::at(0, 1)) lower[Direction::west].push(1);
    }
};
struct SendUpper {
    void operator()(Out<Upper<2>> out) const noexcept { out[Direction::north].push(1); }
};
struct SendLower {
    void operator()(Out<Lower> out) const noexcept { out[Direction::north].set_note(1); }
};
struct ReadUpper {
    void operator()(In<Upper<2>>) const noexcept {}
};
struct ReadLower {
    void operator()(In<Lower>) const noexcept {}
};

} // namespace

TEST_CASE("two channels that share memory and both carry mail on a tile are caught")
{
    CHECK(caught<UseBoth<false>>().empty()); // the channels carry mail on different tiles
    auto const text = caught<UseBoth<true>>();
    CHECK(has(text, "channels Lower and Upper both carry mail"));
    CHECK(has(text, "; give each its own memory"));
    check_place(text, "UseBoth");

    CheckedMesh<Sequence<Superstep<SendUpper>, Superstep<ReadUpper>, Superstep<SendLower>, Superstep<ReadLower>>> good{{}, {3, 4}};
    CHECK(error_of([&] { good.run(); }).empty());
    CheckedMesh<Sequence<Superstep<SendUpper>, Superstep<SendLower>, Superstep<ReadUpper>, Superstep<ReadLower>>> bad{{}, {3, 4}};
    CHECK(has(error_of([&] { bad.run(); }), "[tile (0, 0), superstep 1 (SendLower)]"));
}

namespace {

struct Claims {
    std::uint32_t last;
};
struct LastWorkerSizes {
    void operator()(Four& four, Worker worker) const noexcept
    {
        if (worker.index + 1 == worker.count) four.resize(2);
    }
};
TEST_CASE("a kernel of all workers that changes the size of a list")
{
    CHECK(has(caught<LastWorkerSizes>(), "takes Worker changed the size of a list"));
    // A kernel that sets the size that the list already has is allowed.
    CHECK(caught<LastWorkerSizes>([](auto& mesh) {
              for (std::uint32_t i = 0; i < 12; ++i) mesh.template state<Four>(mesh.grid().tile(i)).resize(2);
          }).empty());
}

struct LastWorkerWins { // the workers race: the engines run them in opposite orders
    void operator()(Claims& claims, Worker worker) const noexcept { claims.last = worker.index; }
};

} // namespace

TEST_CASE("workers run in the opposite order of Mesh: a race between them shows as a difference")
{
    CheckedMesh<Superstep<LastWorkerWins>> checked{{}, {2, 1}, {.digest = true}};
    Mesh<Superstep<LastWorkerWins>> mesh{{}, {2, 1}, {.digest = true}};
    auto const a = checked.run(), b = mesh.run();
    CHECK(checked.state<Claims>(TileId::at(1, 0)).last == 0);
    CHECK(mesh.state<Claims>(TileId::at(1, 0)).last == 5);
    CHECK(a.digests != b.digests);
}
