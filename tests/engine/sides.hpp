#pragma once
#include "everywhere.hpp"

/// Programs on channels of all three edges, of all four sides or of some, and the words that each tile must read, computed by a loop without
/// a mesh. `Full`: the same program on channels with all sides, of which its kernels use as few.
namespace engine_test::on_edges {

/// A name for each kind of edge, so that a program may have channels, states and kernels of all three.
constexpr char const* name_of_edge(Edge edge, char const* reflecting, char const* dropping, char const* wrapping)
{
    return edge == Edge::reflect ? reflecting : edge == Edge::drop ? dropping : wrapping;
}
template <Edge E, Sides S = Sides::all, bool Full = false>
struct Way : Channel<std::uint32_t, 3, E, Full ? Sides::all : S> {
    static constexpr char const* name = name_of_edge(E, "reflecting", "dropping", "wrapping");
};
template <Edge E, Sides S = Sides::all>
struct Kept {
    static constexpr char const* name = name_of_edge(E, "kept reflecting", "kept dropping", "kept wrapping");
    std::uint32_t words[4], notes[4], sends;
};
/// The words that a tile sends to a side when it has `left` more times to send: one to three words, and on two sides a note.
struct Parcel {
    std::uint32_t words[3], size, note;
};
constexpr Parcel parcel_of(std::uint32_t tile, Direction d, std::uint32_t left)
{
    auto const w = 1000 * left + 4 * tile + index(d);
    return {{w, 7 * w, 13 * w}, 1 + w % 3, index(d) % 2 == 0 ? w + 1 : 0};
}
/// Sends its parcels to the sides S, `sends` times.
template <Edge E, Sides S = Sides::all, bool Full = false>
struct Send {
    static constexpr char const* name = name_of_edge(E, "send_reflecting", "send_dropping", "send_wrapping");
    Vote operator()(Here here, Kept<E, S>& kept, In<Way<E, S, Full>> in, Out<Way<E, S, Full>> out) const noexcept
    {
        for (auto d : news) { // a side without an end is empty
            for (std::uint32_t word : in[d]) kept.words[index(d)] = 31 * kept.words[index(d)] + word;
            kept.notes[index(d)] += in[d].note();
        }
        if (kept.sends == 0) return Vote::quiet;
        --kept.sends;
        for (auto d : news) {
            if (!contains(S, d)) continue;
            auto const parcel = parcel_of(here.grid.index_of(here.tile), d, kept.sends);
            for (std::uint32_t i = 0; i < parcel.size; ++i) out[d].push(parcel.words[i]);
            if (parcel.note != 0) out[d].set_note(parcel.note);
        }
        return kept.sends == 0 ? Vote::quiet : Vote::busy;
    }
};
template <Edge E, Sides S = Sides::all, bool Full = false>
using Some = Sequence<Superstep<Send<E, S, Full>>, UntilQuiet<Send<E, S, Full>>>;
using Edges = Sequence<Some<Edge::reflect>, Some<Edge::drop>, Some<Edge::wrap>>;

inline constexpr Grid edge_grids[] = {{1, 1}, {1, 4}, {5, 1}, {2, 2}, {5, 3}};
inline constexpr std::uint32_t calls = 3;

template <Edge E, Sides S = Sides::all, class M>
void load_some(M& mesh)
{
    for (auto [tile, kept] : mesh.template states<Kept<E, S>>()) kept.sends = calls;
}
template <class M>
void load_edges(M& mesh)
{
    load_some<Edge::reflect>(mesh);
    load_some<Edge::drop>(mesh);
    load_some<Edge::wrap>(mesh);
}

/// The words and notes that all tiles must read on channels with one kind of edge, and the number of messages.
struct Expected {
    std::vector<std::array<std::uint32_t, 8>> heard; ///< for each tile: words of the four sides, notes of the four sides
    std::uint64_t messages = 0;
};
inline Expected expected_of(Grid grid, Edge edge, Sides sides = Sides::all)
{
    Expected e;
    e.heard.resize(grid.size());
    int const width = static_cast<int>(grid.width), height = static_cast<int>(grid.height);
    for (std::uint32_t left = calls; left-- > 0;)
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (std::uint32_t d = 0; d < 4; ++d) { // north, east, west, south
                    if ((static_cast<std::uint32_t>(sides) & 1u << d) == 0) continue;
                    int const dx[] = {0, 1, -1, 0}, dy[] = {-1, 0, 0, 1};
                    int tx = x + dx[d], ty = y + dy[d];
                    std::uint32_t side = 3 - d;
                    auto const parcel = parcel_of(static_cast<std::uint32_t>(y * width + x), news[d], left);
                    if (tx < 0 || tx == width || ty < 0 || ty == height) {
                        if (edge == Edge::drop) continue;
                        if (edge == Edge::reflect) tx = x, ty = y, side = d;
                        else tx = (tx + width) % width, ty = (ty + height) % height;
                    }
                    auto& heard = e.heard[static_cast<std::size_t>(ty * width + tx)];
                    for (std::uint32_t i = 0; i < parcel.size; ++i) heard[side] = 31 * heard[side] + parcel.words[i];
                    heard[4 + side] += parcel.note;
                    e.messages += parcel.size;
                }
    return e;
}
template <Edge E, Sides S = Sides::all, class M>
void check_kept(M& mesh)
{
    auto const expected = expected_of(mesh.grid(), E, S);
    for (auto [tile, kept] : mesh.template states<Kept<E, S>>()) {
        auto const& want = expected.heard[mesh.grid().index_of(tile)];
        tilemesh::TileId const at = tile; // Clang 14 does not capture a structured binding
        CAPTURE(at.x());
        CAPTURE(at.y());
        CHECK(std::equal(kept.words, kept.words + 4, want.begin()));
        CHECK(std::equal(kept.notes, kept.notes + 4, want.begin() + 4));
    }
}

/// Cannon's product of two n x n matrices on a torus of n x n tiles: the elements of A go west, those of B go north.
template <bool Full>
struct RowA : Channel<std::uint32_t, 1, Edge::wrap, Full ? Sides::all : Sides::west> {
    static constexpr char const* name = "row of A";
};
template <bool Full>
struct ColumnB : Channel<std::uint32_t, 1, Edge::wrap, Full ? Sides::all : Sides::north> {
    static constexpr char const* name = "column of B";
};
struct Element {
    static constexpr char const* name = "element";
    std::uint32_t a, b, c;
};
template <bool Full>
struct Multiply {
    static constexpr char const* name = "multiply";
    void operator()(Element& e, In<RowA<Full>> a, In<ColumnB<Full>> b, Out<RowA<Full>> west, Out<ColumnB<Full>> north) const noexcept
    {
        for (std::uint32_t v : a.template from<Direction::east>()) e.a = v;
        for (std::uint32_t v : b.template from<Direction::south>()) e.b = v;
        e.c += e.a * e.b;
        west.template to<Direction::west>().push(e.a);
        north.template to<Direction::north>().push(e.b);
    }
};
template <bool Full>
struct Forget { // the last elements arrive and are not needed
    static constexpr char const* name = "forget";
    void operator()(In<RowA<Full>>, In<ColumnB<Full>>) const noexcept {}
};
template <bool Full>
using Cannon = Sequence<Repeat<Multiply<Full>>, Superstep<Forget<Full>>>;
inline constexpr std::uint32_t cannon_side = 5;
template <bool Full>
Cannon<Full> cannon()
{
    return {Repeat<Multiply<Full>>{cannon_side}, {}};
}
inline std::uint32_t a_of(std::uint32_t row, std::uint32_t column) { return 17 * row + 3 * column + 1; }
inline std::uint32_t b_of(std::uint32_t row, std::uint32_t column) { return row * row + 5 * column + 2; }
/// Tile (x, y) begins with A(y, x + y) and B(x + y, x).
template <class M>
void load_cannon(M& mesh)
{
    for (auto [tile, element] : mesh.template states<Element>()) {
        auto const k = (tile.x() + tile.y()) % cannon_side;
        element = {a_of(tile.y(), k), b_of(k, tile.x()), 0};
    }
}
template <class M>
void check_cannon(M& mesh)
{
    for (auto [tile, element] : mesh.template states<Element>()) {
        std::uint32_t c = 0;
        for (std::uint32_t k = 0; k < cannon_side; ++k) c += a_of(tile.y(), k) * b_of(k, tile.x());
        CHECK(element.c == c);
    }
}

} // namespace engine_test::on_edges
