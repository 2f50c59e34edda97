#pragma once
#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace standin {

/// The words that one tile sends to another tile, or to itself (a local copy), in one exchange.
struct Move {
    unsigned from, to;
    std::size_t words; ///< of 32 bits, rounded up
    friend bool operator==(Move const& a, Move const& b) { return a.from == b.from && a.to == b.to && a.words == b.words; }
};

/// Data that move between tiles at once: a Copy of the program, or an exchange that Poplar adds around a compute set for edges that are
/// not one piece on their vertex's tile.
struct Exchange {
    enum class Kind { copy, gather, scatter };
    Kind kind;
    std::string name; ///< the name of the Copy (or "source -> destination", by variables) or of the compute set
    std::vector<Move> moves; ///< ascending by from, then to
};

/// The contents of a tile, in bytes as the machine stores them: each contiguous piece is rounded up to words of 4 bytes.
struct TileBytes {
    std::map<std::string, std::size_t> variables; ///< by name, with constants; equal names are added
    std::size_t temporaries = 0;                  ///< for edges that are not one piece on their vertex's tile
    std::size_t vertex_state = 0;                 ///< pointers, sizes and plain members of its vertices
    std::size_t code = 0;                         ///< Settings::code_bytes
    std::size_t total() const
    {
        std::size_t sum = temporaries + vertex_state + code;
        for (auto const& v : variables) sum += v.second;
        return sum;
    }
};

/// The counters of a run.
struct Counts {
    std::size_t executes = 0;                   ///< compute sets executed
    std::size_t vertices = 0;                   ///< vertices computed
    std::size_t copies = 0;                     ///< Copies between tensors
    std::size_t host_copies = 0;                ///< Copies with a stream
    std::map<std::string, std::size_t> by_name; ///< executions of compute sets, and of Copies of any kind
    void add(Counts const& other)
    {
        executes += other.executes;
        vertices += other.vertices;
        copies += other.copies;
        host_copies += other.host_copies;
        for (auto const& [name, n] : other.by_name)
            by_name[name] += n;
    }
};

} // namespace standin
