#pragma once
#include <poplar/Vertex.hpp>
#include <tilemesh/poplar/program_log.hpp>

/// The vertices that contain no kernel: they gather votes, count passes, and decide about loops, steps and conditions. Kernel code;
/// experimental until an SDK has compiled it. They are not in a version namespace: the graph finds them by name, and the documents do not
/// say how popc names a vertex in an inline namespace. A codelet file serves one graph, so two versions do not meet.
namespace tilemesh::vertices {
using on_poplar::RunLog, on_poplar::said_busy;

/// Sets all its words to 0: the log before a run, or the heads of mail that was read.
class Clear : public ::poplar::Vertex {
public:
    ::poplar::Vector<::poplar::Output<::poplar::Vector<unsigned>>> words;
    bool compute()
    {
        for (unsigned i = 0; i < words.size(); ++i)
            for (unsigned k = 0; k < words[i].size(); ++k) words[i][k] = 0;
        return true;
    }
};

/// Gathers the votes of a row's tiles: the bitwise or of their words.
class GatherVotes : public ::poplar::Vertex {
public:
    ::poplar::Input<::poplar::Vector<unsigned>> said;
    ::poplar::Output<::poplar::Vector<unsigned>> any;
    bool compute()
    {
        unsigned all = 0;
        for (unsigned i = 0; i < said.size(); ++i) all |= said[i];
        any[0] = all;
        return true;
    }
};

/// Ends a pass: writes the votes of all rows into the run's log, and decides whether there is another pass.
class CountPass : public ::poplar::Vertex {
public:
    ::poplar::Input<::poplar::Vector<unsigned>> said;
    ::poplar::InOut<::poplar::Vector<unsigned>> log; ///< RunLog
    ::poplar::Output<bool> again;
    unsigned log_at;  ///< beginning of the step's words: RunLog::step
    unsigned touched; ///< channels that this pass exchanged, or read and emptied
    unsigned reads;   ///< channels whose mail makes another pass; without mail and without a vote there is none
    bool compute()
    {
        unsigned all = 0;
        for (unsigned i = 0; i < said.size(); ++i) all |= said[i];
        unsigned const sent = all >> 1;
        log[RunLog::mail] = (log[RunLog::mail] & ~touched) | sent;
        log[RunLog::busy] = all & said_busy;
        log[RunLog::left] -= 1;
        log[log_at] += 1;
        log[log_at + 1] += sent != 0 ? 1u : 0u;
        again = log[RunLog::left] != 0 && (log[RunLog::busy] | (log[RunLog::mail] & reads)) != 0;
        return true;
    }
};

/// Begins a Loop.
class BeginLoop : public ::poplar::Vertex {
public:
    ::poplar::InOut<::poplar::Vector<unsigned>> log; ///< RunLog
    ::poplar::Input<::poplar::Vector<unsigned>> at_most; ///< one word, which the host sends before each run
    unsigned log_at;                                 ///< beginning of the loop's words: RunLog::loop
    bool compute()
    {
        log[log_at] = at_most[0];
        return true;
    }
};

/// Decides before each round of a Loop whether there is another round.
class TestLoop : public ::poplar::Vertex {
public:
    ::poplar::InOut<::poplar::Vector<unsigned>> log; ///< RunLog
    ::poplar::Output<bool> again;
    unsigned log_at;
    bool compute()
    {
        bool const more = log[log_at] != 0 && log[RunLog::busy] != 0;
        log[log_at] -= more ? 1u : 0u;
        log[log_at + 1] += more ? 1u : 0u;
        again = more;
        return true;
    }
};

/// The condition of an If: tests whether the word of the broadcast is 0.
class TestFlag : public ::poplar::Vertex {
public:
    ::poplar::Input<::poplar::Vector<unsigned>> word;
    ::poplar::Output<bool> again;
    bool compute()
    {
        again = word[0] != 0;
        return true;
    }
};

/// Begins an UntilQuiet: decides whether there is a first pass.
class BeginStep : public ::poplar::Vertex {
public:
    ::poplar::InOut<::poplar::Vector<unsigned>> log; ///< RunLog
    ::poplar::Output<bool> again;
    unsigned at_most;
    unsigned reads;
    bool compute()
    {
        log[RunLog::left] = at_most;
        again = at_most != 0 && (log[RunLog::busy] | (log[RunLog::mail] & reads)) != 0;
        return true;
    }
};

} // namespace tilemesh::vertices
