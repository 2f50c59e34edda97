#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <poplar/DataStream.hpp>
#include <poplar/Graph.hpp>
#include <poplar/Program.hpp>
#include <string>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/poplar/codelet.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace on_poplar {

namespace detail {
constexpr bool same_text(machine::Name a, machine::Name b) noexcept
{
    if (a.size != b.size) return false;
    for (std::uint32_t i = 0; i < a.size; ++i)
        if (a.text[i] != b.text[i]) return false;
    return true;
}
template <class K, class... Others>
constexpr bool name_is_its_own() noexcept
{
    return (true && ... && (std::is_same_v<K, Others> || !same_text(name_of<K>(), name_of<Others>())));
}
template <class... Step>
constexpr bool kernels_have_names_of_their_own(machine::Types<Step...>) noexcept
{
    return (true && ... && name_is_its_own<KernelOf<Step>, KernelOf<Step>...>());
}
} // namespace detail

/// A program as a Poplar graph: its variables, vertices, exchanges and control flow, which follow from the program's type. Experimental
/// until an SDK has compiled it.
///
/// Variables. One for each state, {tiles, words}, with row i on tile i; a list is its head and its items. Eight for each channel, one per
/// end (`memory_of` channels lie in those of their host). One for each broadcast. Their bytes are the lines of `Tile<Machine, Program>`'s
/// ledger; `on_poplar::ledger` (poplar/ledger.hpp) lists the additional bytes.
///
/// Exchange. After a kernel that sends on a channel, each outgoing end is copied whole to the incoming end that it faces, including credits
/// (notes), in one Copy per superstep. Nothing else moves between tiles except broadcasts, and votes if the program needs them. If a
/// channel was only read, the heads of its incoming ends are cleared.
///
/// Control. `Repeat` and `If` are Poplar's. `UntilQuiet` is RepeatWhileTrue on a word that two reductions compute from the tiles' words:
/// first by rows, then on tile 0. `Loop` is RepeatWhileTrue on the same word, after its last superstep. The graph looks for codelets called
/// PREFIX_KERNEL: the kernel's name with `_` for a space.
///
/// Grids: up to 65,535 x 65,535, within the target's tiles. Tile (x, y) is Poplar's tile y * width + x.
template <class Program, class Machine>
class ProgramGraph {
public:
    using States = typename machine::Needs<Program>::States;
    using Links = typename machine::Needs<Program>::Links;
    using Shareds = typename machine::Needs<Program>::Shareds;
    using Steps = StepsOf<Program>;
    using Log = TileLog<Program>;
    using Sequence = ::poplar::program::Sequence;
    using Tensor = ::poplar::Tensor;
    static_assert(detail::kernels_have_names_of_their_own(Steps{}),
                  "two kernels of a program with one name (a codelet is found by it; arguments of templates are not part of it); give each "
                  "a static constexpr char const* name");

    /// The slots of each list and channel that are connected and exchanged, in the order of the layout: at most the slots of the layout.
    struct Slots {
        std::array<std::uint32_t, States::count + 1> states{};
        std::array<std::uint32_t, Links::count + 1> links{};
    };

    /// Adds the variables. The graph must already have the codelets. `count`: account for every pass, even if the program needs no votes;
    /// this costs two small compute sets per superstep. Throws the exceptions of Poplar.
    ProgramGraph(::poplar::Graph& graph, Grid grid, std::string prefix, MeshSizes<Program> const& sizes, Slots const& slots, bool count)
        : graph_(graph), grid_(grid), prefix_(std::move(prefix)), sizes_(sizes), slots_(slots), counts_(count || needs_votes(Steps{}))
    {
        rectangle_ = per_tile("who runs", sizeof(RunRectangle) / 4);
        log_ = per_tile("log", Log::words);
        said_ = per_tile("said", 1);
        rows_said_ = variable("rows said", {grid.height, 1});
        for (std::uint32_t y = 0; y < grid.height; ++y) graph.setTileMapping(rows_said_[y], y * grid.width);
        run_log_ = variable("run log", {RunLog::words<Program>});
        graph.setTileMapping(run_log_, 0);
        if constexpr (StepTraits<Program>::loops != 0) {
            bounds_ = variable("bounds of loops", {StepTraits<Program>::loops});
            graph.setTileMapping(bounds_, 0);
        }
        again_ = graph.addVariable(::poplar::BOOL, std::vector<std::size_t>{}, "again");
        graph.setTileMapping(again_, 0);
        if constexpr (traced) {
            sample_ = per_tile(PassSample::name, sizeof(PassSample) / 4);
            samples_ = graph.addDeviceToHostFIFO(samples_handle, ::poplar::UNSIGNED_INT, sample_.numElements());
        }
        add_states(States{});
        add_links(Links{});
        add_shareds(Shareds{});
    }
    static constexpr bool traced = is_traced<Machine>;
    /// The stream that brings the PassSample of all tiles to the host after each pass; only on a Traced machine.
    static constexpr char const* samples_handle = "samples";

    /// {tiles, words} of a state: all words that the layout has for it.
    template <class X>
    Tensor const& state() const
    {
        return states_[machine::index_in<X>(States{})];
    }
    /// {tiles, words} of the ends on which tiles receive from side d, one of C::receives_from.
    template <class C>
    Tensor incoming(Direction d) const
    {
        return cut<C>(in_[memory<C>()][index(d)]);
    }
    /// {tiles, words} of a broadcast.
    template <class P>
    Tensor const& broadcast() const
    {
        return shareds_[machine::index_in<P>(Shareds{})];
    }
    Tensor const& rectangle() const noexcept { return rectangle_; }
    Tensor const& log() const noexcept { return log_; }
    Tensor const& run_log() const noexcept { return run_log_; }
    /// The most rounds of each Loop, on tile 0. Only for a program with Loops.
    Tensor const& bounds() const noexcept { return bounds_; }

    /// Runs once, before any other program, because device memory may hold any words.
    Sequence start()
    {
        std::vector<Tensor> heads{run_log_, log_, said_};
        clear_links(heads, Links{});
        Sequence all;
        all.add(clear("start", heads));
        return all;
    }
    /// One run of the program. Mail, states and broadcasts are as the last run or the host left them.
    Sequence run(Program const& program)
    {
        Sequence all;
        // Votes and counts begin at zero; unread mail stays.
        all.add(clear("begin run", {log_, run_log_.slice(RunLog::mail + 1, RunLog::words<Program>)}));
        Interpreter interpreter{*this, &all};
        walk(program, interpreter);
        return all;
    }

private:
    template <class... Step>
    static constexpr bool needs_votes(machine::Types<Step...>) noexcept
    {
        return ((StepTraits<Program>::loops != 0) || ... || !StepTraits<Step>::everywhere);
    }

    // --- variables ----------------------------------------------------------------------------------------------------
    Tensor variable(std::string const& name, std::vector<std::size_t> shape) { return graph_.addVariable(::poplar::UNSIGNED_INT, shape, name); }
    Tensor per_tile(std::string const& name, std::uint32_t words)
    {
        auto const t = variable(name, {grid_.size(), words});
        for (std::uint32_t i = 0; i < grid_.size(); ++i) graph_.setTileMapping(t[i], i);
        return t;
    }
    template <class X>
    static std::string text()
    {
        return std::string(name_of<X>().text, name_of<X>().size);
    }
    template <class... X>
    void add_states(machine::Types<X...>)
    {
        ((states_[machine::index_in<X>(States{})] = per_tile(text<X>(), laid_out_words_of<X>())), ...);
    }
    template <class X>
    std::uint32_t laid_out_words_of() const noexcept
    {
        if constexpr (is_list<X>) return X::words(sizes_.slots[machine::index_in<X>(States{})]);
        else return sizeof(X) / 4;
    }
    template <class... P>
    void add_shareds(machine::Types<P...>)
    {
        ((shareds_[machine::index_in<P>(Shareds{})] = per_tile(text<P>(), sizeof(P) / 4)), ...);
    }
    /// The channel whose variables hold C.
    template <class C>
    std::uint32_t memory() const noexcept
    {
        constexpr auto own = machine::index_in<C>(Links{});
        return sizes_.shares_memory[own] ? machine::index_in<MemoryOf<C>>(Links{}) : own;
    }
    template <class C>
    bool has_memory_of_its_own() const noexcept
    {
        return memory<C>() == machine::index_in<C>(Links{});
    }
    /// The channel whose variables may hold C, depending on the sizes.
    template <class C>
    static constexpr std::uint32_t possible_memory() noexcept
    {
        return machine::index_in<MemoryOf<C>>(Links{});
    }
    template <class C>
    std::uint32_t link_words() const noexcept
    {
        static_assert(wire_bytes<typename C::value_type> == sizeof(typename C::value_type),
                      "a channel whose messages are handles of the host (wire_bytes is not their size): a tile has no host memory; build "
                      "the program that moves values");
        return C::Receiver::words(slots_.links[machine::index_in<C>(Links{})]);
    }
    template <class C>
    std::uint32_t laid_out_words() const noexcept
    {
        auto const slots = sizes_.links[machine::index_in<C>(Links{})].slots;
        return slots == dynamic_capacity ? link_words<C>() : C::Receiver::words(slots);
    }
    template <class... C>
    void add_links(machine::Types<C...>)
    {
        [[maybe_unused]] std::array<std::uint32_t, Links::count + 1> words{};
        ((words[memory<C>()] = std::max(words[memory<C>()], laid_out_words<C>())), ...);
        (add_link<C>(words[memory<C>()]), ...);
    }
    template <class C>
    void add_link(std::uint32_t words)
    {
        if (has_memory_of_its_own<C>())
            for (Direction d : news) {
                static constexpr char const* side[4] = {" north", " east", " west", " south"};
                if (contains(C::receives_from, d)) in_[memory<C>()][index(d)] = per_tile(text<C>() + " from" + side[index(d)], words);
                if (contains(C::sends_to, d)) out_[memory<C>()][index(d)] = per_tile(text<C>() + " to" + side[index(d)], words);
            }
    }
    /// The words of an end of C.
    template <class C>
    Tensor cut(Tensor const& end) const
    {
        return end.slice(0, link_words<C>(), 1);
    }
    template <class... C>
    void clear_links(std::vector<Tensor>& heads, machine::Types<C...>) const
    {
        ((has_memory_of_its_own<C>() ? clear_link<C>(heads) : void()), ...);
    }
    template <class C>
    void clear_link(std::vector<Tensor>& heads) const
    {
        for (Direction d : news)
            if (contains(C::receives_from, d)) heads.push_back(in_[memory<C>()][index(d)].slice(0, C::Receiver::head_words, 1));
    }

    // --- vertices -----------------------------------------------------------------------------------------------------
    /// Clears words of every tile ({tiles, words} each), or of tile 0 (one dimension).
    ::poplar::program::Execute clear(std::string const& name, std::vector<Tensor> const& what)
    {
        auto const set = graph_.addComputeSet(name);
        for (std::uint32_t i = 0; i < grid_.size(); ++i) {
            auto const v = graph_.addVertex(set, "tilemesh::vertices::Clear");
            std::vector<Tensor> edges;
            for (auto const& t : what)
                if (t.rank() == 2) edges.push_back(t[i]);
                else if (i == 0) edges.push_back(t);
            connect_list(v, "words", edges);
            graph_.setTileMapping(v, i);
        }
        return ::poplar::program::Execute(set);
    }

    /// Runs one vertex, on tile 0, with these tensors and values in its fields.
    ::poplar::program::Execute on_tile_0(std::string const& name, std::string const& vertex,
                                         std::vector<std::pair<char const*, Tensor>> const& tensors,
                                         std::vector<std::pair<char const*, std::uint32_t>> const& values)
    {
        auto const set = graph_.addComputeSet(name);
        auto const v = graph_.addVertex(set, "tilemesh::vertices::" + vertex);
        for (auto const& [field, tensor] : tensors) graph_.connect(v[field], tensor);
        for (auto const& [field, value] : values) graph_.setInitialValue(v[field], value);
        graph_.setTileMapping(v, 0);
        return ::poplar::program::Execute(set);
    }

    template <class K, class A>
    void connect(std::vector<Tensor>& reads, std::vector<Tensor>& keeps, std::uint32_t tile, A*) const
    {
        using Traits = KernelTraits<K>;
        if constexpr (is_view<A>) {
            connect_end<K>(reads, tile, static_cast<A*>(nullptr));
        } else {
            using X = std::remove_const_t<A>;
            auto row = state<X>()[tile];
            if constexpr (is_list<X>) row = row.slice(0, X::words(slots_.states[machine::index_in<X>(States{})]));
            if constexpr (!std::is_const_v<A>) keeps.push_back(row);
            else if constexpr (!Traits::template takes<X&>) reads.push_back(row);
        }
    }
    template <class K, class C>
    void connect_end(std::vector<Tensor>& reads, std::uint32_t tile, In<C>*) const
    {
        for (Direction d : news)
            if (contains(C::receives_from, d)) reads.push_back(cut<C>(in_[memory<C>()][index(d)])[tile]);
    }
    template <class K, class C>
    void connect_end(std::vector<Tensor>& reads, std::uint32_t tile, Out<C>*) const
    {
        if constexpr (!KernelTraits<K>::template reads<C>)
            for (Direction d : news)
                if (contains(C::receives_from, d)) reads.push_back(in_[memory<C>()][index(d)][tile].slice(0, C::Receiver::head_words));
    }
    template <class K, class P>
    void connect_end(std::vector<Tensor>& reads, std::uint32_t tile, Broadcast<P>*) const
    {
        reads.push_back(broadcast<P>()[tile]);
    }
    template <class K, class A>
        requires(std::is_same_v<A, Here> || std::is_same_v<A, Worker> || std::is_same_v<A, Absent>)
    void connect_end(std::vector<Tensor>&, std::uint32_t, A*) const
    {}
    template <class K, class... A>
    void connect_all(std::vector<Tensor>& reads, std::vector<Tensor>& keeps, std::uint32_t tile, machine::Types<A...>) const
    {
        (connect<K>(reads, keeps, tile, static_cast<std::remove_reference_t<A>*>(nullptr)), ...);
    }
    template <class K, class... C>
    void connect_sends(std::vector<Tensor>& sends, std::uint32_t tile, machine::Types<C...>) const
    {
        [[maybe_unused]] auto const one = [&](auto tag) {
            using L = typename decltype(tag)::type;
            if constexpr (KernelTraits<K>::template writes<L>)
                for (Direction d : news)
                    if (contains(L::sends_to, d)) sends.push_back(cut<L>(out_[memory<L>()][index(d)])[tile]);
        };
        (one(machine::Tag<C>{}), ...);
    }
    void connect_list(::poplar::VertexRef const& v, char const* field, std::vector<Tensor> const& edges)
    {
        graph_.setFieldSize(v[field], edges.size());
        for (std::size_t i = 0; i < edges.size(); ++i) graph_.connect(v[field][i], edges[i]);
    }

    template <class... C>
    static constexpr bool in_memories_of_their_own(machine::Types<C...>) noexcept
    {
        [[maybe_unused]] std::uint32_t used = 0;
        bool apart = true;
        ((apart = apart && (used >> possible_memory<C>() & 1u) == 0, used |= 1u << possible_memory<C>()), ...);
        return apart;
    }
    /// Compute, exchange, and the clearing of read mail.
    template <class K>
    Sequence pass(Task task)
    {
        using Traits = KernelTraits<K>;
        static_assert(in_memories_of_their_own(typename Traits::Links{}),
                      "a kernel that takes two channels of one memory (memory_of: they would overwrite each other); give one of them "
                      "memory of its own, or the kernel one of them");
        Sequence all;
        all.add(compute<K>(task));
        if constexpr (traced) {
            if constexpr (Traits::multi_worker) all.add(compute<K>(Task::sample));
            all.add(::poplar::program::Copy(sample_.flatten(), *samples_));
        }
        std::vector<Tensor> from, to, read;
        exchange_all<K>(from, to, read, typename Traits::Links{});
        if (!from.empty()) all.add(::poplar::program::Copy(::poplar::concat(from), ::poplar::concat(to)));
        if (!read.empty()) all.add(clear("forget mail (step " + std::to_string(step_) + ")", read));
        return all;
    }
    template <class K>
    ::poplar::program::Execute compute(Task task)
    {
        using Traits = KernelTraits<K>;
        auto const set = graph_.addComputeSet(text<K>() + (task == Task::sample ? " sampled" : "") + " (step " + std::to_string(step_) + ")");
        auto vertex = prefix_ + "_" + text<K>();
        std::replace(vertex.begin(), vertex.end(), ' ', '_');
        for (std::uint32_t i = 0; i < grid_.size(); ++i) {
            auto const v = graph_.addVertex(set, vertex);
            std::vector<Tensor> reads{rectangle_[i]}, keeps{log_[i]}, sends{said_[i]};
            if constexpr (traced) sends.push_back(sample_[i]);
            connect_all<K>(reads, keeps, i, typename Traits::Arguments{});
            connect_sends<K>(sends, i, typename Traits::Links{});
            connect_list(v, "reads", reads);
            connect_list(v, "keeps", keeps);
            connect_list(v, "sends", sends);
            auto const tile = grid_.tile(i);
            graph_.setInitialValue(v["x"], tile.x());
            graph_.setInitialValue(v["y"], tile.y());
            graph_.setInitialValue(v["width"], grid_.width);
            graph_.setInitialValue(v["height"], grid_.height);
            graph_.setInitialValue(v["step"], step_);
            graph_.setInitialValue(v["log_at"], Log::step(step_));
            graph_.setInitialValue(v["task"], static_cast<unsigned>(task));
            graph_.setInitialValue(v["program"], program_mark_on<Program>(sizes_.machine.workers, traced));
            graph_.setTileMapping(v, i);
        }
        return ::poplar::program::Execute(set);
    }
    template <class K, class... C>
    void exchange_all(std::vector<Tensor>& from, std::vector<Tensor>& to, std::vector<Tensor>& read, machine::Types<C...>) const
    {
        [[maybe_unused]] auto const one = [&](auto tag) {
            using L = typename decltype(tag)::type;
            if constexpr (KernelTraits<K>::template writes<L>)
                for (Direction d : news) {
                    if (contains(L::sends_to, d)) exchange<L>(from, to, d);
                }
            else clear_link<L>(read);
        };
        (one(machine::Tag<C>{}), ...);
    }
    /// The messages that all tiles send towards d: a shift of the whole grid by one tile. At an edge they go as the channel's Edge says.
    template <class C>
    void exchange(std::vector<Tensor>& from, std::vector<Tensor>& to, Direction d) const
    {
        auto const whole = [&](Tensor const& t) { return cut<C>(t).reshape({grid_.height, grid_.width, link_words<C>()}); };
        auto const sent = whole(out_[memory<C>()][index(d)]);
        auto const arrives = whole(in_[memory<C>()][index(opposite(d))]);
        unsigned const axis = d == Direction::north || d == Direction::south ? 0 : 1;
        std::size_t const n = axis == 0 ? grid_.height : grid_.width;
        bool const down = d == Direction::south || d == Direction::east; // towards larger coordinates
        std::size_t const edge = down ? n - 1 : 0;
        auto const add = [&](Tensor const& source, Tensor const& target) {
            from.push_back(source.flatten());
            to.push_back(target.flatten());
        };
        if (n > 1) add(sent.slice(down ? 0 : 1, down ? n - 1 : n, axis), arrives.slice(down ? 1 : 0, down ? n : n - 1, axis));
        [[maybe_unused]] std::size_t const other = n - 1 - edge;
        if constexpr (C::edge == Edge::reflect) add(sent.slice(edge, edge + 1, axis), whole(in_[memory<C>()][index(d)]).slice(edge, edge + 1, axis));
        else if constexpr (C::edge == Edge::wrap) add(sent.slice(edge, edge + 1, axis), arrives.slice(other, other + 1, axis));
    }

    /// Writes the votes of all tiles into the run's log. `reads`: the channels whose mail causes another pass.
    template <class K>
    Sequence account(std::uint32_t reads)
    {
        Sequence all;
        auto const number = " (step " + std::to_string(step_) + ")";
        auto const rows = graph_.addComputeSet("votes of rows" + number);
        auto const words = said_.flatten();
        for (std::uint32_t y = 0; y < grid_.height; ++y) {
            auto const v = graph_.addVertex(rows, "tilemesh::vertices::GatherVotes");
            graph_.connect(v["said"], words.slice(y * grid_.width, (y + 1) * grid_.width));
            graph_.connect(v["any"], rows_said_[y]);
            graph_.setTileMapping(v, y * grid_.width);
        }
        all.add(::poplar::program::Execute(rows));
        all.add(on_tile_0("votes" + number, "CountPass", {{"said", rows_said_.flatten()}, {"log", run_log_}, {"again", again_}},
                          {{"log_at", RunLog::step(step_)},
                           {"touched", links_touched<Program>(typename KernelTraits<K>::Links{})},
                           {"reads", reads}}));
        return all;
    }
    template <class K>
    Sequence counted_pass()
    {
        Sequence all;
        all.add(pass<K>(Task::always));
        if (counts_) all.add(account<K>(0));
        return all;
    }

    // --- the program ----------------------------------------------------------------------------------------------------
    struct Interpreter {
        ProgramGraph& graph;
        Sequence* to;
        template <class Step>
        void step(Step const& step, std::uint32_t i)
        {
            graph.step_ = i;
            if constexpr (StepTraits<Step>::everywhere) graph.add_everywhere(step, *to);
            else graph.add_until_quiet(step, *to);
        }
        template <class Part, class Body>
        void loop(Part const&, LoopAt at, Body const& body)
        {
            auto const round = inside(body);
            to->add(graph.begin_loop(at));
            to->add(::poplar::program::RepeatWhileTrue(graph.test_loop(at), graph.again_, round));
        }
        template <class Part, class Body>
        void condition(Part const&, Body const& body)
        {
            auto const then = inside(body);
            to->add(graph.template test_flag<Part>());
            to->add(::poplar::program::If(graph.again_, then, Sequence()));
        }
        template <class Body>
        Sequence inside(Body const& body)
        {
            Sequence parts;
            auto* const before = std::exchange(to, &parts);
            body();
            to = before;
            return parts;
        }
    };
    ::poplar::program::Execute begin_loop(LoopAt at)
    {
        return on_tile_0("begin loop " + std::to_string(at.index), "BeginLoop",
                         {{"log", run_log_}, {"at_most", bounds_.slice(at.index, at.index + 1)}}, {{"log_at", RunLog::loop<Program>(at.index)}});
    }
    ::poplar::program::Execute test_loop(LoopAt at)
    {
        return on_tile_0("another round of loop " + std::to_string(at.index), "TestLoop", {{"log", run_log_}, {"again", again_}},
                         {{"log_at", RunLog::loop<Program>(at.index)}});
    }
    template <class Part>
    ::poplar::program::Execute test_flag()
    {
        using Parameters = typename StepTraits<Part>::Parameters;
        Parameters const p{};
        auto const at = static_cast<std::size_t>(reinterpret_cast<char const*>(&(p.*StepTraits<Part>::flag)) - reinterpret_cast<char const*>(&p)) / 4;
        return on_tile_0("if a word of " + text<Parameters>(), "TestFlag",
                         {{"word", broadcast<Parameters>()[0].slice(at, at + 1)}, {"again", again_}}, {});
    }
    template <class Step>
    void add_everywhere(Step const& step, Sequence& to)
    {
        auto const times = StepTraits<Step>::most(step);
        if (times == 0) return;
        auto const pass = counted_pass<KernelOf<Step>>();
        if (times == 1) to.add(pass);
        else to.add(::poplar::program::Repeat(times, pass));
    }
    template <class K>
    void add_until_quiet(UntilQuiet<K> const& step, Sequence& to)
    {
        auto const reads = links_read<Program, K>(typename KernelTraits<K>::Links{});
        to.add(on_tile_0("begin (step " + std::to_string(step_) + ")", "BeginStep", {{"log", run_log_}, {"again", again_}},
                         {{"at_most", step.at_most}, {"reads", reads}}));
        Sequence body;
        body.add(pass<K>(Task::if_needed));
        body.add(account<K>(reads));
        to.add(::poplar::program::RepeatWhileTrue(Sequence(), again_, body));
    }

    ::poplar::Graph& graph_;
    Grid grid_;
    std::string prefix_;
    MeshSizes<Program> sizes_;
    Slots slots_;
    bool counts_;
    std::uint32_t step_ = 0;
    Tensor rectangle_, log_, said_, rows_said_, run_log_, bounds_, again_, sample_;
    std::optional<::poplar::DataStream> samples_;
    std::array<Tensor, States::count + 1> states_;
    std::array<Tensor, Shareds::count + 1> shareds_;
    std::array<std::array<Tensor, 4>, Links::count + 1> in_, out_;
};

}}} // namespace tilemesh::on_poplar
