#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <memory>
#include <poplar/Device.hpp>
#include <poplar/Engine.hpp>
#include <poplar/exceptions.hpp>
#include <string>
#include <tilemesh/engine/rectangle.hpp>
#include <tilemesh/engine/run.hpp>
#include <tilemesh/engine/store.hpp>
#include <tilemesh/engine/text.hpp>
#include <tilemesh/poplar/program_graph.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// Options of a PoplarMesh.
struct PoplarOptions {
    poplar::Device const* device = nullptr; ///< must be attached, and must outlive the mesh
    std::string codelets;                   ///< the output of popc for the program's codelet file, or that file itself
    std::string prefix;                     ///< prefix of the names of its vertices: PREFIX_KERNEL
    bool count_exchanges = true; ///< false, for a program without UntilQuiet: no reductions; StepCounters::exchanges stays 0
    bool digest = false;          ///< not available here: no host sees the words between supersteps
};

/// Runs a program on an IPU, through Poplar. It has the members of Mesh, and gives the same bits and counters. It runs the program's
/// kernels (poplar/codelet.hpp), never their `AllWorkers`, on the graph that the program's type describes (poplar/program_graph.hpp). So
/// `BasicRenderer<S, PoplarMesh>` is a renderer. Experimental until an SDK has compiled it.
///
/// The host keeps a mirror of each state. `state` fetches a region (of all tiles) if the device has changed it. A region that was taken
/// without const goes back before the next run. A reference or view from `state` is valid until the next run; take it again after a run. A
/// run itself moves broadcasts to the device, and the log back.
///
/// The first `run` builds the graph, which takes as long as Poplar needs. Limits, and the counts of the program's steps, cannot change after
/// that. The bounds of its Loops can: they go to the device before each run.
///
/// Errors: it throws Error for a device that is too small, for codelets that do not load or belong to another program, for a program for
/// which Poplar finds no room, for an observer, for digests, for an error that stops a run, and for a run in which a kernel sent over
/// unread mail. After the last two the mesh refuses to run again. Codelets are built with NDEBUG, so a broken contract in a kernel is not
/// reported.
template <class Program, class Machine = Mk2>
class PoplarMesh : public engine::TileStore<Program, false> {
    static_assert(is_machine<Machine>, "no machine (it has the members name, tiles, sram_bytes, code_bytes, workers and clock_khz, as "
                                       "Mk2 has); look for a misspelt one; a setup is not one: give its Machine");
    using Base = engine::TileStore<Program, false>;
    using Builder = on_poplar::ProgramGraph<Program, Machine>;
    using Log = on_poplar::TileLog<Program>;
    using RunLog = on_poplar::RunLog;

public:
    using typename Base::Links;
    using typename Base::Shareds;
    using typename Base::States;
    using Options = PoplarOptions;

    /// A mesh of `Machine`, for a program whose lists all have the capacity that their types name.
    PoplarMesh(Program program, Grid grid, Options options = {}) : PoplarMesh(program, grid, mesh_sizes<Program, Machine>(), std::move(options)) {}
    /// The constructor above, with a value of type `Machine`, so that the compiler deduces it:
    /// `PoplarMesh mesh{program, Grid{8, 8}, Traced<Mk2>{}, options}`.
    template <std::same_as<Machine> M>
    PoplarMesh(Program program, Grid grid, M, Options options = {}) : PoplarMesh(program, grid, std::move(options))
    {}
    /// A mesh with the machine and the slots of `sizes`.
    template <std::same_as<typename Base::Sizes> S>
    PoplarMesh(Program program, Grid grid, S const& sizes, Options options = {})
        : Base(program, grid, sizes), options_(std::move(options)), rectangle_{0, 0, grid.width, grid.height}
    {
        if (options_.device == nullptr) throw Error("a PoplarMesh without a device (it runs on an IPU); give it an attached poplar::Device");
        auto const& target = options_.device->getTarget();
        if (target.getNumTiles() < grid.size() || target.getBytesPerTile() < sizes.machine.sram_bytes ||
            target.getNumWorkerContexts() < sizes.machine.workers)
            throw Error(std::string("machine ") + sizes.machine.name + " on a device of " + std::to_string(target.getNumTiles()) + " tiles of " +
                        std::to_string(target.getBytesPerTile()) + " bytes and " + std::to_string(target.getNumWorkerContexts()) +
                        " workers (the grid has " + std::to_string(grid.size()) + " tiles, the machine " + std::to_string(sizes.machine.sram_bytes) +
                        " bytes and " + std::to_string(sizes.machine.workers) + " workers); choose a smaller grid or machine, or another device");
        if (options_.digest) throw Error("digests on a PoplarMesh (the host does not see the tiles' words between supersteps); ask a Mesh for them");
        dirty_.fill(true);
    }
    PoplarMesh(PoplarMesh const&) = delete;
    PoplarMesh& operator=(PoplarMesh const&) = delete;

    /// Limits this buffer to `items` items, or this channel to `items` slots, on every tile. The limit may be at most the slots with which
    /// the mesh was built. For a channel that gets its slots only by `limit`, it may be at most the slots that fit the SRAM.
    template <class X>
    void limit(std::uint32_t items)
    {
        if (engine_) throw Error("a limit on a PoplarMesh that has run (its graph is built); set limits before the first run");
        if constexpr (is_channel<X>) {
            this->view().limit_link(Base::template index_of_link<X>, items, false);
            incoming_[Base::template index_of_link<X>] = {};
        } else {
            this->view().limit_state(Base::template index_of_state<X>, items);
        }
    }

    /// Tile t's state X: a reference to a struct, or a view of a Buffer. Call it only between runs.
    template <class X>
    decltype(auto) state(TileId t)
    {
        fetch<X>();
        dirty_[Base::template index_of_state<X>] = true;
        return Base::template state<X>(t);
    }
    template <class X>
    decltype(auto) state(TileId t) const
    {
        const_cast<PoplarMesh*>(this)->template fetch<X>();
        return std::as_const(static_cast<Base const&>(*this)).template state<X>(t);
    }
    /// See Mesh.
    template <class X>
    auto states()
    {
        fetch<X>();
        dirty_[Base::template index_of_state<X>] = true;
        return Base::template states<X>();
    }
    template <class X>
    auto states() const
    {
        const_cast<PoplarMesh*>(this)->template fetch<X>();
        return static_cast<Base const&>(*this).template states<X>();
    }
    /// The messages that tile t will read on channel C from side d when a kernel next takes In<C>. Call it only between runs.
    template <class C>
    typename C::Receiver incoming(TileId t, Direction d)
    {
        auto& mirror = incoming_[Base::template index_of_link<C>];
        auto const words = C::Receiver::words(this->template link_capacity<C>());
        auto const side = std::size_t{this->grid_.size()} * words;
        if (!contains(C::receives_from, d)) return C::Receiver::none();
        if (mirror.data() == nullptr) mirror = engine::Arena(ends_in<C> * side);
        if (auto& stale = incoming_stale_[Base::template index_of_link<C>]; stale && engine_) {
            execute(first_incoming + Base::template index_of_link<C>);
            std::memcpy(mirror.data(), staging_.data(), ends_in<C> * side * 4);
            stale = false;
        }
        auto* const p = mirror.data() + before(C::receives_from, d) * side + std::size_t{this->grid_.index_of(t)} * words;
        return typename C::Receiver{machine::Place{p, p + C::Receiver::head_words, this->template link_capacity<C>()}};
    }

    /// See Mesh.
    void run_within(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1)
    {
        auto const r = engine::checked_rectangle(this->grid_, {x0, y0, x1, y1});
        rectangle_ = {r.x0, r.y0, r.x1, r.y1};
    }
    void observe(Observer observer)
    {
        if (observer)
            throw Error("an observer of a PoplarMesh (the host sees nothing between supersteps); observe a Mesh, which takes the same "
                        "ones");
    }
    /// Calls f(0, 1): the host has one thread here.
    template <class F>
    void on_threads(F const& f)
    {
        f(0u, 1u);
    }

    /// The trace of the last run, superstep by superstep, equal to that of a Mesh. Only on a Traced machine, which streams 56 bytes per
    /// tile to the host after each superstep.
    Trace const& trace() const noexcept
    {
        static_assert(Builder::traced, "a mesh without a trace (its machine is not Traced); build it for Traced<Machine>");
        return trace_;
    }

    /// Builds and loads the graph, unless it is already loaded. Throws Error.
    void prepare()
    {
        if (engine_) return;
        this->view().require_capacities();
        try {
            build();
        } catch (...) {
            engine_.reset();
            throw;
        }
    }

    /// Runs the whole program once. The milliseconds of steps stay 0, because the host does not see when a step ends.
    RunCounters run()
    {
        if (broken_) throw Error("a mesh that stopped on an error cannot run again (its state is half a superstep); build a new one");
        prepare();
        send(States{});
        std::memcpy(rectangle_words_.data(), &rectangle_, sizeof rectangle_);
        copy_broadcasts(Shareds{});
        LoopBounds bounds{bounds_};
        walk(this->program_, bounds);
        stale_.fill(true);
        incoming_stale_.fill(true);
        samples_.clear();
        broken_ = true;
        execute(run_program);
        auto counters = account();
        if constexpr (Builder::traced) make_trace(counters);
        broken_ = false;
        return counters;
    }

    /// The graph and the engine, for tests and tools; call `prepare` first.
    poplar::Graph const& graph() const noexcept { return *graph_; }
    poplar::Engine const& engine() const noexcept { return *engine_; }

private:
    // The engine's programs, in order.
    static constexpr unsigned start_program = 0, run_program = 1, first_send = 2, first_fetch = first_send + States::count,
                              first_incoming = first_fetch + States::count;

    /// Runs one of the engine's programs.
    void execute(unsigned program)
    {
        try {
            engine_->run(program);
        } catch (poplar::poplar_error const& e) {
            broken_ = true;
            throw Error(std::string("a run that Poplar stopped (") + e.what() + "); look at the device, and build a new mesh");
        }
    }
    /// Builds the graph and the engine in two steps, because an error can have two causes.
    void build()
    {
        std::vector<poplar::program::Program> programs;
        try {
            programs = describe();
        } catch (poplar::poplar_error const& e) {
            throw Error(std::string("a graph that Poplar refuses (") + e.what() + "); check the codelets \"" + options_.codelets +
                        "\" and their prefix \"" + options_.prefix + "\"");
        }
        try {
            engine_ = std::make_unique<poplar::Engine>(*graph_, programs);
            engine_->load(*options_.device);
            for (auto const& [name, words] : streams_) engine_->connectStream(name, words);
            if constexpr (Builder::traced)
                engine_->connectStreamToCallback(Builder::samples_handle, [this](void* data) {
                    auto const at = samples_.size();
                    samples_.resize(at + this->grid_.size());
                    std::memcpy(samples_.data() + at, data, this->grid_.size() * sizeof(on_poplar::PassSample));
                });
            engine_->run(start_program);
        } catch (poplar::poplar_error const& e) {
            throw Error(std::string("a program that Poplar cannot load (") + e.what() +
                        "); see its ledger (poplar/ledger.hpp), and give it fewer slots where it lacks room");
        }
    }
    std::vector<poplar::program::Program> describe()
    {
        streams_.clear();
        graph_ = std::make_unique<poplar::Graph>(options_.device->getTarget());
        graph_->addCodelets(options_.codelets);
        typename Builder::Slots slots;
        slots.states = this->capacity_;
        slots.links = this->link_capacity_;
        Builder builder(*graph_, this->grid_, options_.prefix, this->sizes_, slots, options_.count_exchanges);

        std::vector<poplar::program::Program> programs;
        programs.push_back(builder.start());
        poplar::program::Sequence run;
        rectangle_words_.resize(sizeof(on_poplar::RunRectangle) / 4);
        receive(run, "who runs", builder.rectangle(), rectangle_words_);
        receive_broadcasts(run, builder, Shareds{});
        if constexpr (StepTraits<Program>::loops != 0) {
            bounds_.resize(StepTraits<Program>::loops);
            auto const stream = graph_->addHostToDeviceFIFO(handle("to bounds of loops"), poplar::UNSIGNED_INT, bounds_.size());
            streams_.emplace_back(handle("to bounds of loops"), bounds_.data());
            run.add(poplar::program::Copy(stream, builder.bounds()));
        }
        built_ = this->program_;
        run.add(builder.run(built_));
        log_.resize(std::size_t{this->grid_.size()} * Log::words);
        run_log_.resize(RunLog::words<Program>);
        deliver(run, "log", builder.log(), log_.data());
        deliver(run, "run log", builder.run_log(), run_log_.data());
        programs.push_back(run);

        staging_ = engine::Arena(std::max(most_state_words(States{}), most_link_words(Links{})) * this->grid_.size());
        add_sends(programs, builder, States{});
        add_fetches(programs, builder, States{});
        add_incoming(programs, builder, Links{});
        return programs;
    }
    /// The handles of streams must differ; the names of regions need not.
    std::string handle(std::string const& name) const { return "stream " + std::to_string(streams_.size()) + ": " + name; }
    /// Sends the host's words to tile 0, and from there to all tiles. Each tile holds its own copy.
    void receive(poplar::program::Sequence& to, std::string const& name, poplar::Tensor const& tensor, std::vector<std::uint32_t>& words)
    {
        auto const stream = graph_->addHostToDeviceFIFO(handle("to " + name), poplar::UNSIGNED_INT, words.size());
        streams_.emplace_back(handle("to " + name), words.data());
        to.add(poplar::program::Copy(stream, tensor[0]));
        auto const others = this->grid_.size() - 1;
        if (others > 0) to.add(poplar::program::Copy(tensor.slice(0, 1).broadcast(others, 0), tensor.slice(1, this->grid_.size())));
    }
    void deliver(poplar::program::Sequence& to, std::string const& name, poplar::Tensor const& tensor, std::uint32_t* words)
    {
        auto const stream = graph_->addDeviceToHostFIFO(handle("from " + name), poplar::UNSIGNED_INT, tensor.numElements());
        streams_.emplace_back(handle("from " + name), words);
        to.add(poplar::program::Copy(tensor.flatten(), stream));
    }
    template <class... P>
    void receive_broadcasts(poplar::program::Sequence& to, Builder& builder, machine::Types<P...>)
    {
        [[maybe_unused]] auto const one = [&](auto tag) {
            using X = typename decltype(tag)::type;
            auto& words = broadcast_words_[machine::index_in<X>(Shareds{})];
            words.resize(sizeof(X) / 4);
            receive(to, engine::text(name_of<X>()), builder.template broadcast<X>(), words);
        };
        (one(machine::Tag<P>{}), ...);
    }
    template <class... P>
    void copy_broadcasts(machine::Types<P...>)
    {
        (std::memcpy(broadcast_words_[machine::index_in<P>(Shareds{})].data(), &this->template broadcast<P>(), sizeof(P)), ...);
    }
    /// The bounds of Loops may change between runs; the counts of other parts are in the graph.
    struct LoopBounds {
        std::vector<std::uint32_t>& of_loop;
        template <class Step>
        void step(Step const&, std::uint32_t)
        {}
        template <class Part, class Body>
        void loop(Part const& part, LoopAt at, Body const& body)
        {
            of_loop[at.index] = part.at_most;
            body();
        }
        template <class Part, class Body>
        void condition(Part const&, Body const& body)
        {
            body();
        }
    };
    template <class... X>
    std::size_t most_state_words(machine::Types<X...>) const noexcept
    {
        std::size_t most = 1;
        ((most = std::max<std::size_t>(most, this->template words<X>())), ...);
        return most;
    }
    template <class... C>
    std::size_t most_link_words(machine::Types<C...>) const noexcept
    {
        std::size_t most = 1;
        ((most = std::max<std::size_t>(most, std::size_t{4} * C::Receiver::words(this->template link_capacity<C>()))), ...);
        return most;
    }
    template <class... X>
    void add_sends(std::vector<poplar::program::Program>& programs, Builder& builder, machine::Types<X...>)
    {
        [[maybe_unused]] auto const one = [&](auto tag) {
            using S = typename decltype(tag)::type;
            auto const name = handle("to " + engine::text(name_of<S>()));
            auto const& tensor = builder.template state<S>();
            auto const stream = graph_->addHostToDeviceFIFO(name, poplar::UNSIGNED_INT, tensor.numElements());
            streams_.emplace_back(name, staging_.data());
            programs.push_back(poplar::program::Copy(stream, tensor.flatten()));
        };
        (one(machine::Tag<X>{}), ...);
    }
    template <class... X>
    void add_fetches(std::vector<poplar::program::Program>& programs, Builder& builder, machine::Types<X...>)
    {
        [[maybe_unused]] auto const one = [&](auto tag) {
            using S = typename decltype(tag)::type;
            poplar::program::Sequence q;
            deliver(q, engine::text(name_of<S>()), builder.template state<S>(), staging_.data());
            programs.push_back(q);
        };
        (one(machine::Tag<X>{}), ...);
    }
    template <class... C>
    void add_incoming(std::vector<poplar::program::Program>& programs, Builder& builder, machine::Types<C...>)
    {
        [[maybe_unused]] auto const one = [&](auto tag) {
            using L = typename decltype(tag)::type;
            std::vector<poplar::Tensor> sides;
            for (Direction d : news)
                if (contains(L::receives_from, d)) sides.push_back(builder.template incoming<L>(d).flatten());
            poplar::program::Sequence q;
            deliver(q, engine::text(name_of<L>()) + " (mail)", poplar::concat(sides), staging_.data());
            programs.push_back(q);
        };
        (one(machine::Tag<C>{}), ...);
    }

    // --- states between runs ----------------------------------------------------------------------------------------------
    /// Calls f(words on the device, words in the store) for each tile, with live words only.
    template <class X, class F>
    void for_each_tile(F const& f)
    {
        for (std::uint32_t i = 0; i < this->grid_.size(); ++i)
            f(staging_.data() + std::size_t{i} * this->template words<X>(), this->template state_place<X>(i));
    }
    template <class X>
    void send_one()
    {
        auto& dirty = dirty_[Base::template index_of_state<X>];
        if (!dirty) return;
        for_each_tile<X>([](std::uint32_t* words, machine::Place const& place) {
            if constexpr (is_list<X>) {
                std::memcpy(words, place.head, X::head_words * 4);
                std::memcpy(words + X::head_words, place.items, std::size_t{place.head[0]} * X::item_words * 4);
            } else {
                std::memcpy(words, place.items, sizeof(X));
            }
        });
        execute(first_send + Base::template index_of_state<X>);
        dirty = false;
    }
    template <class... X>
    void send(machine::Types<X...>)
    {
        (send_one<X>(), ...);
    }
    template <class X>
    void fetch()
    {
        constexpr auto i = Base::template index_of_state<X>;
        if (!stale_[i]) return;
        execute(first_fetch + i);
        for_each_tile<X>([](std::uint32_t const* words, machine::Place const& place) {
            if constexpr (is_list<X>) {
                std::memcpy(place.head, words, X::head_words * 4);
                std::memcpy(place.items, words + X::head_words, std::size_t{place.head[0]} * X::item_words * 4);
            } else {
                std::memcpy(place.items, words, sizeof(X));
            }
        });
        stale_[i] = false;
    }

    // --- counters ------------------------------------------------------------------------------------------------------------
    RunCounters account()
    {
        RunCounters run = engine::begin_counters(engine::program_facts<Program>);
        for (std::uint32_t l = 0; l < StepTraits<Program>::loops; ++l) run.loops[l].rounds = run_log_[RunLog::loop<Program>(l) + 1];
        StaticPasses passes{*this, {}};
        walk(built_, passes);
        for_each_step(built_, [&](auto const& step, std::uint32_t i) {
            run.steps[i].passes = std::max<std::uint64_t>(run_log_[RunLog::step(i)], passes.of_step[i]);
            account_step(run.steps[i], step, i, typename KernelTraits<KernelOf<std::decay_t<decltype(step)>>>::Links{});
        });
        for (std::uint32_t t = 0; t < this->grid_.size(); ++t)
            if (auto const broken = word(t, Log::broken); broken != 0) {
                if (broken == Log::other_program)
                    throw Error("codelets of another program than the graph's (\"" + options_.codelets + "\" was compiled from other kernels, "
                                "capacities or machine); compile them again from the same headers");
                throw Error("a kernel only sends on a channel with unread mail (a bound cut the step that reads it); raise the bound, or let "
                            "the sending kernel read the channel [tile " +
                            engine::text(this->grid_.tile(t)) + ", " + run.steps[broken - 1].kernel + "]");
            }
        run.peaks = peaks(States{}, Links{});
        return run;
    }
    template <class... X, class... C>
    std::vector<engine::Peak> peaks(machine::Types<X...>, machine::Types<C...>) const
    {
        std::uint32_t const states[] = {state_peak<X>()..., 0}, links[] = {peak(Log::template link_peak<C>())..., 0};
        return engine::list_peaks(this->view(), states, links);
    }
    template <class X>
    std::uint32_t state_peak() const noexcept
    {
        if constexpr (is_list<X>) return peak(Log::template state_peak<X>());
        else return 0;
    }
    std::uint32_t word(std::uint32_t tile, std::uint32_t at) const noexcept { return log_[std::size_t{tile} * Log::words + at]; }

    /// The passes that a program makes for any votes of its tiles.
    struct StaticPasses {
        PoplarMesh& mesh;
        std::array<std::uint64_t, StepsOf<Program>::count + 1> of_step;
        template <class Step>
        void step(Step const& step, std::uint32_t i)
        {
            if constexpr (StepTraits<Step>::everywhere) of_step[i] = StepTraits<Step>::most(step);
        }
        template <class Part, class Body>
        void loop(Part const&, LoopAt, Body const&)
        {}
        template <class Part, class Body>
        void condition(Part const&, Body const& body)
        {
            using Traits = StepTraits<Part>;
            if (mesh.Base::template shared<typename Traits::Parameters>()->*Traits::flag != 0) body();
        }
    };
    template <class Step, class... C>
    void account_step(StepCounters& counters, Step const&, std::uint32_t i, machine::Types<C...>)
    {
        using K = KernelOf<Step>;
        auto const at = Log::step(i);
        counters.exchanges = run_log_[RunLog::step(i) + 1];
        for (std::uint32_t t = 0; t < this->grid_.size(); ++t) {
            counters.tile_runs += word(t, at);
            std::uint32_t link = 0;
            (count_messages<C>(counters, word(t, at + 1 + link++)), ...);
        }
        counters.capacity_bytes = counters.exchanges * this->view().capacity_bytes(engine::kernel_facts<Program, K>);
    }
    template <class C>
    void count_messages(StepCounters& counters, std::uint32_t n) const noexcept
    {
        counters.messages += n;
        counters.live_bytes += std::uint64_t{n} * this->template message_bytes<C>();
    }
    void make_trace(RunCounters const& counters)
    {
        trace_ = engine::begin_trace(engine::program_facts<Program>, engine::operations_of_steps<Program>.at);
        trace_.loops = counters.loops;
        auto const store = this->view();
        for (auto const* s = samples_.data(); s != samples_.data() + samples_.size();) {
            auto const& step = engine::program_facts<Program>.steps[s->step];
            SuperstepSample superstep{s->step, step.votes, store.capacity_a_side(*step.kernel), false, {}, step.kernel->edge,
                                      store.absent_a_side(*step.kernel)};
            for (std::uint32_t t = 0; t < this->grid_.size(); ++t, ++s) {
                if (s->ran == 0) continue;
                superstep.tiles.push_back({t, s->operations, {s->sent_bytes[0], s->sent_bytes[1], s->sent_bytes[2], s->sent_bytes[3]}});
                superstep.sent = superstep.sent || (s->sent_bytes[0] | s->sent_bytes[1] | s->sent_bytes[2] | s->sent_bytes[3]) != 0;
            }
            trace_.supersteps.push_back(std::move(superstep));
        }
    }
    std::uint32_t peak(std::uint32_t at) const noexcept
    {
        std::uint32_t most = 0;
        for (std::uint32_t t = 0; t < this->grid_.size(); ++t) most = std::max(most, word(t, at));
        return most;
    }
    Options options_;
    on_poplar::RunRectangle rectangle_;
    Program built_{};                                          ///< the program for which the graph was built
    std::unique_ptr<poplar::Graph> graph_;
    std::vector<std::uint32_t> rectangle_words_, log_, run_log_, bounds_;
    std::vector<on_poplar::PassSample> samples_;
    Trace trace_;
    std::array<std::vector<std::uint32_t>, Shareds::count + 1> broadcast_words_;
    std::vector<std::pair<std::string, std::uint32_t*>> streams_;
    engine::Arena staging_;                            ///< one region of all tiles, in transfers between host and device
    std::array<engine::Arena, Links::count + 1> incoming_;
    std::array<bool, States::count + 1> stale_{};              ///< has the device changed the state since the last fetch?
    std::array<bool, States::count + 1> dirty_{};              ///< may the host have changed the state?
    std::array<bool, Links::count + 1> incoming_stale_{};
    std::unique_ptr<poplar::Engine> engine_;                   ///< last: it uses the words of the other members
    bool broken_ = false;
};

template <class Program, class Machine>
    requires(!std::same_as<Machine, PoplarOptions>)
PoplarMesh(Program, Grid, Machine, PoplarOptions = {}) -> PoplarMesh<Program, Machine>;
template <class Program>
PoplarMesh(Program, Grid, MeshSizes<Program>, PoplarOptions = {}) -> PoplarMesh<Program, AnyMachine>;

}} // namespace tilemesh
