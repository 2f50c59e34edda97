// Credits: a row of tiles passes words to the east. A tile sends only what its neighbour's list has room for, so no list is ever full.
#include <cstdint>
#include <iostream>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/machine/buffer.hpp>
#include <tilemesh/machine/channel.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/superstep.hpp>
using tilemesh::Direction, tilemesh::Vote;
constexpr std::uint32_t line_slots = 4;
struct Line : tilemesh::Buffer<std::uint32_t, line_slots> {};
struct Pipe : tilemesh::Channel<std::uint32_t, line_slots, tilemesh::Edge::drop> {};
struct Flow { std::uint32_t left, sent, taken, taken_east, sum; }; // words to make; sent; taken from the own line, from that to the east
struct Pass {
    Vote operator()(tilemesh::Here here, Line& line, Flow& flow, tilemesh::In<Pipe> in, tilemesh::Out<Pipe> out) const noexcept
    {
        for (auto word : in[Direction::west]) line.push(word); // has room: the sender counted
        if (in[Direction::east].note() != 0) flow.taken_east = in[Direction::east].note();
        while (flow.left != 0 && line.try_push(flow.left)) --flow.left;
        bool const last = !here.grid.has_neighbour(here.tile, Direction::east);
        std::uint32_t gone = 0;
        for (; gone < line.size() && (last ? gone < 1 : flow.sent - flow.taken_east < line_slots); ++gone)
            if (last)
                flow.sum += line[gone]; // the end of the row takes one word in a pass
            else
                out[Direction::east].push(line[gone]), ++flow.sent;
        for (auto i = gone; i < line.size(); ++i) line[i - gone] = line[i];
        line.truncate(line.size() - gone);
        flow.taken += gone;
        if (gone != 0) out[Direction::west].set_note(flow.taken); // the credit; never 0, so it is seen
        return (last && !line.empty()) || (flow.left != 0 && line.room() != 0) ? Vote::busy : Vote::quiet;
    }
};
using Row = tilemesh::Sequence<tilemesh::Superstep<Pass>, tilemesh::UntilQuiet<Pass>>;
int main()
{
    tilemesh::Mesh mesh{Row{}, tilemesh::Grid{5, 1}};
    mesh.state<Flow>(tilemesh::TileId::at(0, 0)).left = 1000;
    auto const run = mesh.run();
    auto const sum = mesh.state<Flow>(tilemesh::TileId::at(4, 0)).sum;
    std::cout << "sum " << sum << " after " << run.steps[1].passes << " passes; at most " << run.peaks[0].items << " of "
              << run.peaks[0].capacity << " slots were full\n";
    return sum == 500500 ? 0 : 1;
}
