#pragma once
#include <cstring>
#include <poplar/Vertex.hpp>
#include <tilemesh/poplar/control_vertices.hpp>
#include <tilemesh/poplar/program_log.hpp>
#include <tilemesh/poplar/vertex_edges.hpp>

/// A superstep of a program as a Poplar vertex. Experimental until an SDK has compiled it.
///
/// This is kernel code, which popc compiles. A program has one codelet file:
/// ```
/// #include <tilemesh/poplar/codelet.hpp>
/// #include "heat.hpp"
/// TILEMESH_VERTEX(heat_Diffuse, tilemesh::Mk2, tilemesh::Repeat<Diffuse>, Diffuse)
/// ```
/// Use `TILEMESH_VERTEX(name, Machine, Program, Kernel)` for a kernel that one worker runs, and `TILEMESH_MULTI_VERTEX` for a kernel that
/// takes `Worker`. The graph looks for the name: its prefix, `_`, and `name_of<Kernel>()` with `_` for a space.
///
/// Every vertex has the same three lists, for any kernel, because fields may neither be structs nor depend on a template (hardware: records
/// are words). They are in the order of the kernel's parameters:
///   reads   the tiles that must run; states taken as `X const&`; of each channel of the kernel the four incoming ends (only their heads if
///           the kernel only sends on it); broadcasts
///   keeps   the tile's log; states taken as `X&`
///   sends   one word: the tile's vote and the channels on which it sent; on a Traced machine its sample; of each channel on which it
///           sends the four outgoing ends
/// Compile with -DNDEBUG: a tile cannot report a broken contract, and the code after one is safe.
///
/// The classes are written by macros instead of templates, because the documents do not say how popc names an instance with class-type
/// arguments.

namespace tilemesh { inline namespace v0_2 { namespace on_poplar {

/// The computation of a vertex of either kind.
template <class Machine, class Program, class Kernel>
class Codelet {
    using Traits = KernelTraits<Kernel>;
    using Arguments = typename Traits::Arguments;
    using Links = typename Traits::Links;
    using AllLinks = typename machine::Needs<Program>::Links;
    using Log = TileLog<Program>;
    static constexpr bool traced = is_traced<Machine>;
    static_assert(AllLinks::count <= 31, "a tile says in one word on which channels it sent (31 fit); use fewer channels");

    /// The source that run_kernel needs, made from the vertex's fields.
    template <class Vertex>
    struct Source {
        Vertex& vertex;
        Worker share;

        template <class X>
        TILEMESH_KERNEL machine::Place state() noexcept
        {
            if constexpr (Traits::template takes<X&>) {
                return place<X>(vertex.keeps[detail::keeps_at<Kernel, X&>(Arguments{})]);
            } else {
                return place<X>(vertex.reads[detail::reads_at<Kernel, X const&>(Arguments{})]);
            }
        }
        template <class C>
        TILEMESH_KERNEL machine::Place in(Direction d) noexcept
        {
            return list<typename C::Receiver>(vertex.reads[detail::reads_at<Kernel, In<C>>(Arguments{}) + before(C::receives_from, d)]);
        }
        template <class C>
        TILEMESH_KERNEL machine::Place out(Direction d) noexcept
        {
            return list<typename C::Sender>(vertex.sends[detail::sends_at<Kernel, C, traced>(Links{}) + before(C::sends_to, d)]);
        }
        template <class P>
        TILEMESH_KERNEL P const* shared() noexcept
        {
            return reinterpret_cast<P const*>(words(vertex.reads[detail::reads_at<Kernel, Broadcast<P>>(Arguments{})]));
        }
        TILEMESH_KERNEL Here here() noexcept { return {TileId::at(vertex.x, vertex.y), Grid{vertex.width, vertex.height}}; }
        TILEMESH_KERNEL Worker worker() noexcept { return share; }
    };

    /// An edge as words, from which views are made. A view of a const parameter has no member that writes.
    template <class Edge>
    TILEMESH_KERNEL static std::uint32_t* words(Edge& edge) noexcept
    {
        return const_cast<std::uint32_t*>(reinterpret_cast<std::uint32_t const*>(edge.begin()));
    }
    template <class List, class Edge>
    TILEMESH_KERNEL static machine::Place list(Edge& edge) noexcept
    {
        auto* const w = words(edge);
        return {w, w + List::head_words, (static_cast<std::uint32_t>(edge.size()) - List::head_words) / List::item_words};
    }
    template <class X, class Edge>
    TILEMESH_KERNEL static machine::Place place(Edge& edge) noexcept
    {
        if constexpr (is_list<X>) return list<X>(edge);
        else return {nullptr, words(edge), 1};
    }

    /// Does the tile have unread mail for the kernel, or on a channel on which the kernel sends?
    template <class C, class Vertex>
    TILEMESH_KERNEL static bool unread(Vertex& vertex) noexcept
    {
        constexpr auto at = Traits::template reads<C> ? detail::reads_at<Kernel, In<C>>(Arguments{}) : detail::reads_at<Kernel, Out<C>>(Arguments{});
        std::uint32_t any = 0;
        for (std::uint32_t i = 0; i < ends_in<C>; ++i) {
            auto const* const head = words(vertex.reads[at + i]);
            any |= head[0] | head[1];
        }
        return any != 0;
    }
    template <class Vertex, class... C>
    TILEMESH_KERNEL static bool has_mail([[maybe_unused]] Vertex& vertex, machine::Types<C...>) noexcept
    {
        return (false || ... || (Traits::template reads<C> && unread<C>(vertex)));
    }
    template <class Vertex, class... C>
    TILEMESH_KERNEL static bool overwrites([[maybe_unused]] Vertex& vertex, machine::Types<C...>) noexcept
    {
        return (false || ... || (!Traits::template reads<C> && unread<C>(vertex)));
    }

    /// Empties the outgoing ends, because they may hold any words.
    template <class C, class Vertex>
    TILEMESH_KERNEL static void empty_one([[maybe_unused]] Vertex& vertex) noexcept
    {
        if constexpr (Traits::template writes<C>)
            for (std::uint32_t i = 0; i < ends_out<C>; ++i) {
                auto* const head = words(vertex.sends[detail::sends_at<Kernel, C, traced>(Links{}) + i]);
                head[0] = head[1] = 0;
            }
    }
    template <class Vertex, class... C>
    TILEMESH_KERNEL static void empty([[maybe_unused]] Vertex& vertex, machine::Types<C...>) noexcept
    {
        (empty_one<C>(vertex), ...);
    }

    /// Does the exchange move the messages that this tile sends towards d?
    template <class C, class Vertex>
    TILEMESH_KERNEL static bool delivers([[maybe_unused]] Vertex& vertex, [[maybe_unused]] Direction d) noexcept
    {
        if constexpr (C::edge == Edge::drop) return Grid{vertex.width, vertex.height}.has_neighbour(TileId::at(vertex.x, vertex.y), d);
        else return true;
    }
    /// Counts the messages of one channel. Returns whether any message or note was sent.
    template <class C, class Vertex>
    TILEMESH_KERNEL static std::uint32_t sent([[maybe_unused]] Vertex& vertex, [[maybe_unused]] std::uint32_t* log) noexcept
    {
        if constexpr (Traits::template writes<C>) {
            std::uint32_t messages = 0, notes = 0, peak = log[Log::template link_peak<C>()];
            for (std::uint32_t i = 0; i < ends_out<C>; ++i) {
                auto const* const head = words(vertex.sends[detail::sends_at<Kernel, C, traced>(Links{}) + i]);
                peak = head[0] > peak ? head[0] : peak;
                if (!delivers<C>(vertex, side_of(C::sends_to, i))) continue;
                messages += head[0];
                notes |= head[1];
            }
            log[vertex.log_at + 1 + machine::index_in<C>(Links{})] += messages;
            log[Log::template link_peak<C>()] = peak;
            return (messages | notes) != 0 ? said_mail(machine::index_in<C>(AllLinks{})) : 0;
        } else {
            return 0;
        }
    }
    template <class Vertex, class... C>
    TILEMESH_KERNEL static std::uint32_t all_sent([[maybe_unused]] Vertex& vertex, [[maybe_unused]] std::uint32_t* log, machine::Types<C...>) noexcept
    {
        return (0u | ... | sent<C>(vertex, log));
    }
    template <class A, class Vertex>
    TILEMESH_KERNEL static void peak_of([[maybe_unused]] Vertex& vertex, [[maybe_unused]] std::uint32_t* log) noexcept
    {
        using X = std::remove_reference_t<A>;
        if constexpr (std::is_reference_v<A> && !std::is_const_v<X> && is_list<X>) {
            auto const size = words(vertex.keeps[detail::keeps_at<Kernel, X&>(Arguments{})])[0];
            auto& peak = log[Log::template state_peak<X>()];
            peak = size > peak ? size : peak;
        }
    }
    template <class Vertex, class... A>
    TILEMESH_KERNEL static void peaks([[maybe_unused]] Vertex& vertex, [[maybe_unused]] std::uint32_t* log, machine::Types<A...>) noexcept
    {
        (peak_of<A>(vertex, log), ...);
    }

    /// Must the tile run? The rule is that of the engines, and the tile's own words decide.
    template <class Vertex>
    TILEMESH_KERNEL static bool has_to_run(Vertex& vertex, std::uint32_t const* log) noexcept
    {
        auto const* const rectangle = reinterpret_cast<RunRectangle const*>(words(vertex.reads[0]));
        return (vertex.task == static_cast<unsigned>(Task::always) && rectangle->contains(vertex.x, vertex.y)) || log[Log::vote] != 0 ||
               has_mail(vertex, Links{});
    }

    /// Records the work of the pass, before the exchange.
    template <class Vertex>
    static void sample(Vertex& vertex, bool ran) noexcept
    {
        PassSample s{vertex.step, ran ? 1u : 0u, {}, {0, 0, 0, 0}};
        if (ran) {
            Source<Vertex> source{vertex, {0, Machine::workers}};
            s.operations = operations_of<Kernel>(source);
            sent_bytes(vertex, s, Links{});
        }
        std::memcpy(words(vertex.sends[1]), &s, sizeof s);
    }
    template <class Vertex, class... C>
    TILEMESH_KERNEL static void sent_bytes([[maybe_unused]] Vertex& vertex, [[maybe_unused]] PassSample& s, machine::Types<C...>) noexcept
    {
        (sent_bytes_of<C>(vertex, s), ...);
    }
    template <class C, class Vertex>
    TILEMESH_KERNEL static void sent_bytes_of([[maybe_unused]] Vertex& vertex, [[maybe_unused]] PassSample& s) noexcept
    {
        if constexpr (Traits::template writes<C>)
            for (std::uint32_t i = 0; i < ends_out<C>; ++i) {
                auto const d = side_of(C::sends_to, i);
                auto const* const head = words(vertex.sends[detail::sends_at<Kernel, C, traced>(Links{}) + i]);
                if (delivers<C>(vertex, d) && (head[0] | head[1]) != 0) s.sent_bytes[index(d)] += C::end_bytes(head[0]);
            }
    }

    /// Writes a refusal into the log, whose first two words every program has, and sends nothing.
    template <class Vertex>
    static void refuse(Vertex& vertex) noexcept
    {
        words(vertex.keeps[0])[Log::broken] = Log::other_program;
        for (std::uint32_t i = 0; i < vertex.sends.size(); ++i)
            for (std::uint32_t k = 0; k < vertex.sends[i].size() && k < 2; ++k) vertex.sends[i][k] = 0;
    }

public:
    template <class Vertex>
    static bool compute(Vertex& vertex, std::uint32_t worker) noexcept
    {
        static_assert(Traits::multi_worker == std::is_base_of_v<::poplar::MultiVertex, Vertex>,
                      "a kernel that takes Worker is a TILEMESH_MULTI_VERTEX, any other a TILEMESH_VERTEX (workers of a Vertex would "
                      "not share its work); use the other macro");
        auto* const log = words(vertex.keeps[0]);
        if (vertex.program != program_mark<Machine, Program>) { // an old codelet file: the words have another meaning
            if (worker == 0) refuse(vertex);
            return true;
        }
        if constexpr (Traits::multi_worker && traced)
            if (vertex.task == static_cast<unsigned>(Task::sample)) {
                if (worker == 0) {
                    *vertex.sends[0].begin() = 0;
                    sample(vertex, log[Log::ran] != 0);
                }
                return true;
            }
        if constexpr (Traits::multi_worker) {
            // A tile that need not run may run: this changes nothing. So no worker has to wait for worker 0's decision. The sizes of lists
            // are equal before and after (see Worker), so worker 0 may read them.
            if (worker >= Machine::workers) return true;
            Source<Vertex> source{vertex, {worker, Machine::workers}};
            run_kernel<Kernel>(source);
            if (worker != 0) return true;
            bool const runs = has_to_run(vertex, log);
            if (runs) {
                ++log[vertex.log_at];
                peaks(vertex, log, Arguments{});
            }
            log[Log::ran] = runs ? 1 : 0;
            log[Log::vote] = 0;
            *vertex.sends[0].begin() = 0;
        } else {
            if (log[Log::broken] == 0 && overwrites(vertex, Links{})) log[Log::broken] = vertex.step + 1;
            empty(vertex, Links{});
            std::uint32_t said = 0;
            bool const runs = has_to_run(vertex, log);
            if (runs) {
                Source<Vertex> source{vertex, {0, 1}};
                said = run_kernel<Kernel>(source) == Vote::busy ? said_busy : 0;
                ++log[vertex.log_at];
                peaks(vertex, log, Arguments{});
                said |= all_sent(vertex, log, Links{});
            }
            if constexpr (traced) sample(vertex, runs);
            log[Log::ran] = runs ? 1 : 0;
            log[Log::vote] = said & said_busy;
            *vertex.sends[0].begin() = said;
        }
        return true;
    }
};

}}} // namespace tilemesh::on_poplar

#define TILEMESH_VERTEX(Name, ...)                                                                                             \
    class Name : public ::poplar::Vertex {                                                                                     \
    public:                                                                                                                    \
        ::poplar::Vector<::poplar::Input<::poplar::Vector<unsigned>>> reads;                                                   \
        ::poplar::Vector<::poplar::InOut<::poplar::Vector<unsigned>>> keeps;                                                   \
        ::poplar::Vector<::poplar::Output<::poplar::Vector<unsigned>>> sends;                                                  \
        unsigned x, y, width, height, step, log_at, task, program;                                                             \
        bool compute() { return ::tilemesh::on_poplar::Codelet<__VA_ARGS__>::compute(*this, 0); }                              \
    };
#define TILEMESH_MULTI_VERTEX(Name, ...)                                                                                       \
    class Name : public ::poplar::MultiVertex {                                                                                \
    public:                                                                                                                    \
        ::poplar::Vector<::poplar::Input<::poplar::Vector<unsigned>>> reads;                                                   \
        ::poplar::Vector<::poplar::InOut<::poplar::Vector<unsigned>>> keeps;                                                   \
        ::poplar::Vector<::poplar::Output<::poplar::Vector<unsigned>>> sends;                                                  \
        unsigned x, y, width, height, step, log_at, task, program;                                                             \
        bool compute(unsigned worker) { return ::tilemesh::on_poplar::Codelet<__VA_ARGS__>::compute(*this, worker); }          \
    };
