#pragma once
#include "../standard.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/engine/mesh.hpp>

/// Runs one program on every engine and number of threads, and checks that all of them agree.
namespace engine_test {
using namespace tilemesh;

using tests::fast;

using tests::Random;

using WordList = std::vector<std::uint32_t>;

template <class T>
void add_words(WordList& words, T const& item)
{
    std::uint32_t w[sizeof(T) / 4];
    std::memcpy(w, &item, sizeof(T));
    words.insert(words.end(), std::begin(w), std::end(w));
}
template <class M, class X>
void add_state(M& mesh, TileId t, WordList& words, X*)
{
    if constexpr (is_list<X>) {
        auto const list = mesh.template state<X>(t);
        words.push_back(list.size());
        for (auto const& item : list) add_words(words, item);
    } else {
        add_words(words, mesh.template state<X>(t));
    }
}
template <class M, class C>
void add_mail(M& mesh, TileId t, WordList& words, C*)
{
    for (Direction d : news) {
        auto const end = mesh.template incoming<C>(t, d);
        words.push_back(end.size());
        words.push_back(end.note());
        for (auto const& item : end) add_words(words, item);
    }
}
template <class M, class... X, class... C>
WordList words_of(M& mesh, machine::Types<X...>, machine::Types<C...>)
{
    WordList words;
    for (std::uint32_t i = 0; i < mesh.grid().size(); ++i) {
        (add_state(mesh, mesh.grid().tile(i), words, static_cast<X*>(nullptr)), ...);
        (add_mail(mesh, mesh.grid().tile(i), words, static_cast<C*>(nullptr)), ...);
    }
    return words;
}
/// All live words of a machine: its states, and its unread mail.
template <class M>
WordList words_of(M& mesh)
{
    return words_of(mesh, typename M::States{}, typename M::Links{});
}

inline void check_same(RunCounters const& a, RunCounters const& b)
{
    REQUIRE(a.steps.size() == b.steps.size());
    for (std::size_t i = 0; i < a.steps.size(); ++i) {
        CAPTURE(i);
        CHECK(a.steps[i].kernel == b.steps[i].kernel);
        CHECK(a.steps[i].passes == b.steps[i].passes);
        CHECK(a.steps[i].exchanges == b.steps[i].exchanges);
        CHECK(a.steps[i].tile_runs == b.steps[i].tile_runs);
        CHECK(a.steps[i].messages == b.steps[i].messages);
        CHECK(a.steps[i].live_bytes == b.steps[i].live_bytes);
        CHECK(a.steps[i].capacity_bytes == b.steps[i].capacity_bytes);
    }
    REQUIRE(a.peaks.size() == b.peaks.size());
    for (std::size_t i = 0; i < a.peaks.size(); ++i) {
        CAPTURE(i);
        CHECK(a.peaks[i].region == b.peaks[i].region);
        CHECK(a.peaks[i].items == b.peaks[i].items);
        CHECK(a.peaks[i].capacity == b.peaks[i].capacity);
    }
    CHECK(a.loops == b.loops);
    CHECK(a.digests == b.digests);
}

inline std::uint64_t passes(RunCounters const& run)
{
    std::uint64_t n = 0;
    for (auto const& s : run.steps) n += s.passes;
    return n;
}

/// A CheckedMesh after its runs, and the counters of each run.
template <class Program, class Machine>
struct Played {
    std::unique_ptr<CheckedMesh<Program, Machine>> mesh;
    std::vector<RunCounters> runs;
    RunCounters const& last() const { return runs.back(); }
    StepCounters const& step(std::size_t i) const { return runs.back().steps.at(i); }
};

inline constexpr std::uint32_t thread_counts[] = {1, 2, 3, 8};

/// Loads and runs a program on CheckedMesh and on Mesh with 1, 2, 3 and 8 threads. All live words and counters must agree after
/// every run, and the digest after every superstep; the checked mesh is returned. `load` takes either engine.
template <class Program, class Machine = Mk2, class Load>
Played<Program, Machine> everywhere(Grid grid, Load const& load, int runs, Program program, MeshSizes<Program> const& sizes)
{
    Played<Program, Machine> played;
    std::vector<WordList> words;
    typename CheckedMesh<Program, Machine>::Options checked;
    checked.digest = true;
    played.mesh = std::make_unique<CheckedMesh<Program, Machine>>(program, grid, sizes, checked);
    load(*played.mesh);
    for (int r = 0; r < runs; ++r) {
        played.runs.push_back(played.mesh->run());
        words.push_back(words_of(*played.mesh));
        CHECK(played.last().digests.size() == passes(played.last()));
    }
    for (auto threads : thread_counts) {
        CAPTURE(threads);
        typename Mesh<Program, Machine>::Options options;
        options.threads = threads;
        options.digest = true;
        Mesh<Program, Machine> mesh{program, grid, sizes, options};
        load(mesh);
        for (std::size_t r = 0; r < played.runs.size(); ++r) {
            CAPTURE(r);
            check_same(played.runs[r], mesh.run());
            CHECK(words[r] == words_of(mesh));
        }
        // Digests and observers add barriers. So the program also runs without them, as users run it.
        options.digest = false;
        Mesh<Program, Machine> plain{program, grid, sizes, options};
        load(plain);
        for (std::size_t r = 0; r < played.runs.size(); ++r) {
            CAPTURE(r);
            auto counters = plain.run();
            CHECK(counters.digests.empty());
            counters.digests = played.runs[r].digests;
            check_same(played.runs[r], counters);
            CHECK(words[r] == words_of(plain));
        }
    }
    return played;
}

/// everywhere() with the slots that the program's types name.
template <class Program, class Machine = Mk2, class Load>
Played<Program, Machine> everywhere(Grid grid, Load const& load, int runs = 1, Program program = {})
{
    return everywhere<Program, Machine>(grid, load, runs, program, mesh_sizes<Program, Machine>());
}

/// Calls f(mesh) with a fresh mesh of each engine and number of threads.
template <class Program, class Machine = Mk2, class F>
void on_each(Grid grid, F const& f, Program program, MeshSizes<Program> const& sizes)
{
    {
        CAPTURE("checked");
        CheckedMesh<Program, Machine> mesh{program, grid, sizes};
        f(mesh);
    }
    for (auto threads : thread_counts) {
        CAPTURE(threads);
        typename Mesh<Program, Machine>::Options options;
        options.threads = threads;
        Mesh<Program, Machine> mesh{program, grid, sizes, options};
        f(mesh);
    }
}
template <class Program, class Machine = Mk2, class F>
void on_each(Grid grid, F const& f, Program program = {})
{
    on_each<Program, Machine>(grid, f, program, mesh_sizes<Program, Machine>());
}

/// The text of the Error that f throws; empty if f throws none.
using tests::error_of;
using tests::has;

} // namespace engine_test
