#pragma once
#include <cstddef>
#include <cstdint>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/types.hpp>
#include <tilemesh/splat/view.hpp>
#include <utility>
#include <vector>

/// The words of a renderer with an engine that runs on several processes (mpi/mpi_mesh.hpp). Such an engine has one part of the tiles in
/// each process, and every process runs the same renderer. On any other engine a process has all tiles, and these functions do nothing
/// else. So the renderer does not know MPI.
namespace tilemesh { inline namespace v0_2 { namespace render {

/// Does each process have only a part of the mesh's tiles? It is true for a `GroupOf` these processes, too.
template <class M>
inline constexpr bool over_ranks = requires(M const& mesh) { mesh.ranks(); };

namespace detail {
/// The one process of an engine that is not over ranks.
struct OneProcess {
    template <class Options>
    explicit OneProcess(Options const&)
    {
    }
};
template <class M>
struct GroupOf {
    using Type = OneProcess;
};
template <class M>
    requires over_ranks<M>
struct GroupOf<M> {
    using Type = typename M::Group;
};
} // namespace detail
/// The processes of an engine before there is a mesh. Every process makes one with the engine's options. The functions below take it in the
/// place of a mesh, except those that ask for a tile.
template <class M>
using GroupOf = typename detail::GroupOf<M>::Type;

/// Is tile t one of this process?
template <class M>
bool owns([[maybe_unused]] M const& mesh, [[maybe_unused]] TileId t) noexcept
{
    if constexpr (over_ranks<M>)
        return mesh.owns(t);
    else
        return true;
}
/// Is this the process that gets pictures and lists?
template <class M>
bool is_first(M const& mesh) noexcept
{
    if constexpr (over_ranks<M>)
        return mesh.rank() == 0;
    else
        return true;
}
/// The number of processes that have the mesh's tiles, this one's number, and that of the process that has tile t.
template <class M>
std::uint32_t processes([[maybe_unused]] M const& mesh) noexcept
{
    if constexpr (over_ranks<M>)
        return mesh.ranks();
    else
        return 1;
}
template <class M>
std::uint32_t this_process([[maybe_unused]] M const& mesh) noexcept
{
    if constexpr (over_ranks<M>)
        return mesh.rank();
    else
        return 0;
}
template <class M>
std::uint32_t process_of([[maybe_unused]] M const& mesh, [[maybe_unused]] TileId t) noexcept
{
    if constexpr (over_ranks<M>)
        return mesh.bands().rank_of(t.y());
    else
        return 0;
}
/// Runs f, which does not communicate. An exception in one process is an Error in all of them.
template <class M, class F>
void together([[maybe_unused]] M& mesh, F const& f)
{
    if constexpr (over_ranks<M>)
        mesh.together(f);
    else
        f();
}
/// Each process in turn, in the order of its tiles, calls word = f(word) with the result of the process before. Returns the last result.
template <class M, class F>
std::uint64_t in_turn([[maybe_unused]] M& mesh, std::uint64_t word, F const& f)
{
    if constexpr (over_ranks<M>)
        return mesh.in_turn(word, f);
    else
        return f(word);
}
/// Throws Error for a part of a map on an engine of one process.
[[noreturn]] inline void refuse_part()
{
    throw Error("a part of a map on an engine of one process (the other parts would be missing); load the whole map");
}
/// Throws Error in every process if their frames have different digests.
template <class M>
void require_same_frames([[maybe_unused]] M& mesh, [[maybe_unused]] std::uint64_t digest)
{
    if constexpr (over_ranks<M>)
        if (!mesh.same(digest))
            throw Error("ranks with different frames (the map, the camera, the model or the options of a rank differ from those of another); "
                        "give the same to every rank");
}
/// A digest of a view, mixed into another digest.
inline std::uint64_t digest_of_view(std::uint64_t digest, splat::View const& view) noexcept
{
    static_assert(sizeof view % 4 == 0 && alignof(splat::View) == 4);
    std::uint32_t words[sizeof view / 4];
    __builtin_memcpy(words, &view, sizeof view);
    return engine::mix_words(digest, words, sizeof view / 4);
}
/// Adds up n words over the processes. `least`, `most`: the minima or maxima of words below 2^63.
template <class M>
void sum([[maybe_unused]] M& mesh, [[maybe_unused]] std::uint64_t* words, [[maybe_unused]] std::size_t n)
{
    if constexpr (over_ranks<M>) mesh.sum(words, n);
}
template <class M>
void least([[maybe_unused]] M& mesh, [[maybe_unused]] std::uint64_t* words, [[maybe_unused]] std::size_t n)
{
    if constexpr (over_ranks<M>) mesh.least(words, n);
}
template <class M>
void most([[maybe_unused]] M& mesh, [[maybe_unused]] std::uint64_t* words, [[maybe_unused]] std::size_t n)
{
    if constexpr (over_ranks<M>) mesh.most(words, n);
}
/// Is this true in any process?
template <class M>
bool in_any(M& mesh, bool here)
{
    std::uint64_t processes = here ? 1 : 0;
    sum(mesh, &processes, 1);
    return processes != 0;
}
/// The first process gets the items of all, in the order of the processes; the others then have none.
template <class M, class T>
void join([[maybe_unused]] M& mesh, [[maybe_unused]] std::vector<T>& items)
{
    if constexpr (over_ranks<M>) mesh.join(items);
}
/// Sends `counts[p]` items to process p, one process after another. Returns the items that this process gets, in the order of the processes
/// that sent them; `counts[p]` is then the number of those from process p.
template <class M, class T>
std::vector<T> deal([[maybe_unused]] M& mesh, std::vector<T> items, [[maybe_unused]] std::vector<std::uint64_t>& counts)
{
    if constexpr (over_ranks<M>)
        return mesh.deal(std::move(items), counts);
    else
        return items;
}
/// Every process gets the items of the first.
template <class M, class T>
void share([[maybe_unused]] M& mesh, [[maybe_unused]] std::vector<T>& items)
{
    if constexpr (over_ranks<M>) mesh.share(items);
}
/// Copies the states X of all tiles to the first process.
template <class X, class M>
void gather([[maybe_unused]] M& mesh)
{
    if constexpr (over_ranks<M>) mesh.template gather<X>();
}
/// The trace of all tiles, in the first process, from each process's trace of its own tiles.
template <class M>
Trace gather_trace([[maybe_unused]] M& mesh, Trace const& mine)
{
    if constexpr (over_ranks<M>)
        return mesh.gather_trace(mine);
    else
        return mine;
}

}}} // namespace tilemesh::render
