#pragma once
#include "everywhere.hpp"

/// A program on channels of all three edges, and the words that each tile must read, computed by a loop without a mesh.
namespace engine_test::on_edges {

template <Edge E>
struct Lane : Channel<std::uint32_t, 3, E> {
    static constexpr char const* name = E == Edge::reflect ? "reflecting" : E == Edge::drop ? "dropping" : "wrapping";
};
template <Edge E>
struct Heard {
    static constexpr char const* name = E == Edge::reflect ? "heard reflecting" : E == Edge::drop ? "heard dropping" : "heard wrapping";
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
template <Edge E>
struct Call {
    static constexpr char const* name = E == Edge::reflect ? "call_reflecting" : E == Edge::drop ? "call_dropping" : "call_wrapping";
    Vote operator()(Here here, Heard<E>& heard, In<Lane<E>> in, Out<Lane<E>> out) const noexcept
    {
        for (auto d : news) {
            for (std::uint32_t word : in[d]) heard.words[index(d)] = 31 * heard.words[index(d)] + word;
            heard.notes[index(d)] += in[d].note();
        }
        if (heard.sends == 0) return Vote::quiet;
        --heard.sends;
        for (auto d : news) {
            auto const parcel = parcel_of(here.grid.index_of(here.tile), d, heard.sends);
            for (std::uint32_t i = 0; i < parcel.size; ++i) out[d].push(parcel.words[i]);
            if (parcel.note != 0) out[d].set_note(parcel.note);
        }
        return heard.sends == 0 ? Vote::quiet : Vote::busy;
    }
};
template <Edge E>
using CallAll = Sequence<Superstep<Call<E>>, UntilQuiet<Call<E>>>;
using Edges = Sequence<CallAll<Edge::reflect>, CallAll<Edge::drop>, CallAll<Edge::wrap>>;

inline constexpr Grid edge_grids[] = {{1, 1}, {1, 4}, {5, 1}, {2, 2}, {5, 3}};
inline constexpr std::uint32_t calls = 3;

template <class M>
void load_edges(M& mesh)
{
    for (auto [tile, heard] : mesh.template states<Heard<Edge::reflect>>()) heard.sends = calls;
    for (auto [tile, heard] : mesh.template states<Heard<Edge::drop>>()) heard.sends = calls;
    for (auto [tile, heard] : mesh.template states<Heard<Edge::wrap>>()) heard.sends = calls;
}

/// The words and notes that all tiles must read on channels with one kind of edge, and the numbers of messages.
struct Expected {
    std::vector<std::array<std::uint32_t, 8>> heard; ///< for each tile: words of the four sides, notes of the four sides
    std::uint64_t messages = 0, dropped = 0;
};
inline Expected expected_of(Grid grid, Edge edge)
{
    Expected e;
    e.heard.resize(grid.size());
    int const width = static_cast<int>(grid.width), height = static_cast<int>(grid.height);
    for (std::uint32_t left = calls; left-- > 0;)
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (std::uint32_t d = 0; d < 4; ++d) { // north, east, west, south
                    int const dx[] = {0, 1, -1, 0}, dy[] = {-1, 0, 0, 1};
                    int tx = x + dx[d], ty = y + dy[d];
                    std::uint32_t side = 3 - d;
                    auto const parcel = parcel_of(static_cast<std::uint32_t>(y * width + x), news[d], left);
                    if (tx < 0 || tx == width || ty < 0 || ty == height) {
                        if (edge == Edge::drop) {
                            e.dropped += parcel.size;
                            continue;
                        }
                        if (edge == Edge::reflect) {
                            tx = x, ty = y, side = d;
                        } else {
                            tx = (tx + width) % width, ty = (ty + height) % height;
                        }
                    }
                    auto& heard = e.heard[static_cast<std::size_t>(ty * width + tx)];
                    for (std::uint32_t i = 0; i < parcel.size; ++i) heard[side] = 31 * heard[side] + parcel.words[i];
                    heard[4 + side] += parcel.note;
                    e.messages += parcel.size;
                }
    return e;
}
template <Edge E, class M>
void check_heard(M& mesh)
{
    auto const expected = expected_of(mesh.grid(), E);
    for (auto [tile, heard] : mesh.template states<Heard<E>>()) {
        auto const& want = expected.heard[mesh.grid().index_of(tile)];
        tilemesh::TileId const at = tile; // Clang 14 does not capture a structured binding
        CAPTURE(at.x());
        CAPTURE(at.y());
        CHECK(std::equal(heard.words, heard.words + 4, want.begin()));
        CHECK(std::equal(heard.notes, heard.notes + 4, want.begin() + 4));
    }
}
template <class M>
void check_all_heard(M& mesh)
{
    check_heard<Edge::reflect>(mesh);
    check_heard<Edge::drop>(mesh);
    check_heard<Edge::wrap>(mesh);
}

} // namespace engine_test::on_edges
