#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <tilemesh/engine/checker.hpp>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/engine/text.hpp>
#include <tilemesh/error.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace engine {

namespace detail {
/// The list of this end is dead now.
TILEMESH_HOST void poison(machine::Place const& end, std::uint32_t item_words) noexcept
{
    std::fill(end.items, end.items + std::size_t{end.head[0]} * item_words, poison_word);
    end.head[0] = end.head[1] = 0;
}
} // namespace detail

TILEMESH_HOST Checker::Checker(StoreView const& store)
    : in(store.link_count), out(store.link_count), state_peak_(store.state_count), link_peak_(store.link_count), most_(store.state_count)
{
    for (std::uint32_t l = 0; l < store.link_count; ++l) make_end(store, l);
    for (auto& busy : busy_) busy.assign(store.grid.size(), 0);
}
TILEMESH_HOST void Checker::make_end(StoreView const& store, std::uint32_t link)
{
    auto const item_words = store.links[link].item_words;
    Ends made[2];
    for (auto& e : made) {
        e.capacity = store.link_capacities[link];
        e.stride = std::size_t{e.capacity} * item_words + 2 * guard_words_around;
        auto const n = std::size_t{store.grid.size()} * 4;
        e.heads.assign(n, {0, 0, 0, guard_word});
        e.items = Arena(n * e.stride + item_words); // room for one item after the last end
        bool const fill = n * e.stride <= (std::size_t{64} << 18);
        for (std::size_t s = 0; s < n; ++s) {
            auto* const items = e.items.data() + s * e.stride;
            for (std::size_t g = 0; g < guard_words_around; ++g) items[g] = items[e.stride - 1 - g] = guard_word;
            if (fill) std::fill(items + guard_words_around, items + e.stride - guard_words_around, poison_word);
        }
    }
    in[link] = std::move(made[0]);
    out[link] = std::move(made[1]);
}
TILEMESH_HOST bool Checker::unread(std::uint32_t link, std::uint32_t tile)
{
    for (std::uint32_t side = 0; side < 4; ++side)
        if (auto const& head = in[link].heads[4 * std::size_t{tile} + side]; (head[0] | head[1]) != 0) return true;
    return false;
}
TILEMESH_HOST void Checker::limit_link(StoreView const& store, std::uint32_t link, std::uint32_t items)
{
    bool mail = false;
    for (std::uint32_t t = 0; t < store.grid.size(); ++t) mail = mail || unread(link, t);
    auto const before = store.link_capacities[link];
    store.limit_link(link, items, mail);
    try {
        make_end(store, link);
    } catch (...) { // out of memory: the channel keeps its old capacity
        store.link_capacities[link] = before;
        throw;
    }
}
TILEMESH_HOST void Checker::begin()
{
    std::fill(state_peak_.begin(), state_peak_.end(), 0u);
    std::fill(link_peak_.begin(), link_peak_.end(), 0u);
    for (auto& b : busy_) std::fill(b.begin(), b.end(), std::uint8_t{0});
    last_kernel_ = nullptr;
    would_run_.clear();
}
TILEMESH_HOST bool Checker::any_busy() const noexcept
{
    auto const& busy = busy_[parity_];
    return std::find(busy.begin(), busy.end(), 1) != busy.end();
}
TILEMESH_HOST std::uint64_t Checker::digest(StoreView const& store)
{
    std::uint64_t digest = 0;
    for (std::uint32_t t = 0; t < store.grid.size(); ++t) {
        std::uint64_t h = 0;
        for (std::uint32_t l = 0; l < store.link_count; ++l)
            if (!store.undigested_links[l])
                for (std::uint32_t side = 0; side < 4; ++side) h = store.mix_mail(h, l, in[l].at(4 * t + side));
        digest += mix(h, store.digest_states(t));
    }
    return digest;
}

/// One superstep: what it reads of the store and of the program, and its checks.
struct Checker::Step {
    using Kind = ArgumentFacts::Kind;
    Checker& checker;
    StoreView const& store;
    RunState const& state;
    Steps const& steps;
    KernelFacts const& facts;

    [[noreturn]] void fail(std::uint32_t tile, std::string const& what) const { throw state.failed(store.grid, tile, what); }

    // --- one tile -------------------------------------------------------------------------------------------------------
    Vote run(std::uint32_t tile) const
    {
        for (auto const& a : facts.arguments)
            if (a.kind == Kind::list && a.changes) {
                auto& most = checker.most_[a.number];
                if (most.empty()) most.assign(store.grid.size(), 0);
                most[tile] = std::max(most[tile], store.place(a.number, tile).head[0]);
            }
        auto const sizes = list_sizes(tile);
        detail::tilemesh_broken_contracts = &checker.broken_;
        Vote vote = Vote::quiet;
        if (facts.multi_worker) { // runs the last worker first, because the order of workers must not matter
            auto const workers = store.machine->workers;
            for (std::uint32_t w = workers; w-- > 0;) vote = steps.run[state.step()](steps.mesh, tile, {w, workers});
        } else {
            vote = steps.run[state.step()](steps.mesh, tile, {0, 1});
        }
        detail::tilemesh_broken_contracts = nullptr; // an observer is not a kernel
        if (checker.broken_.count != 0) fail(tile, std::exchange(checker.broken_, {}).first);
        if (!store.guards_hold(tile))
            fail(tile, "a kernel wrote outside a region of its tile, or a size above its capacity (its guard words are gone); "
                       "use try_push and check indices");
        for (auto const& use : facts.links) check_end(use.link, tile);
        if (facts.multi_worker && list_sizes(tile) != sizes)
            fail(tile, "a kernel that takes Worker changed the size of a list (one word, which all workers read); give it its size in a "
                       "superstep of one worker");
        return vote;
    }
    std::uint64_t list_sizes(std::uint32_t tile) const
    {
        std::uint64_t h = 0;
        for (auto const& a : facts.arguments) h = mix(h, a.kind == Kind::list && a.changes ? store.place(a.number, tile).head[0] : 0);
        return h;
    }
    void check_end(std::uint32_t link, std::uint32_t tile) const
    {
        for (std::uint32_t side = 0; side < 4; ++side)
            for (auto* ends : {&checker.in[link], &checker.out[link]}) {
                auto const p = ends->at(4 * tile + side);
                auto const words = std::size_t{p.capacity} * store.links[link].item_words;
                bool ok = p.head[3] == guard_word && p.head[0] <= p.capacity;
                for (std::uint32_t g = 0; g < guard_words_around; ++g)
                    ok = ok && p.items[words + g] == guard_word && (p.items - guard_words_around)[g] == guard_word;
                if (!ok)
                    fail(tile, "a kernel wrote outside channel " + text(store.links[link].name) +
                                   " (its guard words are gone, or its size is above its capacity); use try_push");
            }
    }

    // --- a tile that need not run ---------------------------------------------------------------------------------------
    /// Runs the kernel on a tile that need not run, and puts back each word. Throws Error if a word that counts is not what it was, or if
    /// the kernel sent or voted busy.
    void require_quiet(std::uint32_t tile, bool outside) const
    {
        if (auto const change = change_of(tile)) fail(tile, change.text(outside));
    }
    /// Runs the kernel on a tile that need not run, and returns the first change that it makes. Then restores the states that the kernel
    /// takes without const, and forgets what it sent.
    QuietChange change_of(std::uint32_t tile) const
    {
        auto& before = checker.before_;
        before.clear();
        for (auto const& a : facts.arguments)
            if (a.changes) {
                auto const p = store.place(a.number, tile);
                if (a.kind == Kind::list) before.push_back(p.head[0]);
                before.insert(before.end(), p.items, p.items + store.live_words(a.number, p));
            }
        QuietChange change;
        if (run(tile) == Vote::busy) change.kind = QuietChange::Kind::vote;
        std::uint32_t const* saved = before.data();
        for (auto const& a : facts.arguments) {
            if (a.changes) saved = put_back(change, saved, tile, a);
            if (a.kind != Kind::out) continue;
            for (std::uint32_t side = 0; side < 4; ++side) {
                auto const p = checker.out[a.number].at(4 * tile + side);
                if ((p.head[0] | p.head[1]) == 0) continue;
                if (!change) change = {QuietChange::Kind::message, store.links[a.number].name, 0, 0, 0, 0};
                detail::poison(p, store.links[a.number].item_words);
            }
        }
        return change;
    }
    /// Puts back a tile's state. Returns the saved words behind it. `change`: the first word that is not what it was.
    std::uint32_t const* put_back(QuietChange& change, std::uint32_t const* saved, std::uint32_t tile, ArgumentFacts const& a) const
    {
        bool const list = a.kind == Kind::list;
        auto const name = store.states[a.number].name;
        auto const p = store.place(a.number, tile);
        std::uint32_t const left_out = store.undigested[a.number];
        bool const counts = left_out != no_digest && !change;
        std::size_t const item = list ? store.item_words(a.number) : store.states[a.number].words;
        if (list) {
            auto const size = *saved++;
            if (counts && p.head[0] != size) change = {QuietChange::Kind::size, name, 0, 0, size, p.head[0]};
            p.head[0] = size;
        }
        auto const words = store.live_words(a.number, p);
        for (std::size_t i = 0; i < words; ++i) {
            if (p.items[i] == saved[i]) continue;
            auto const word = static_cast<std::uint32_t>(i % item);
            if (counts && !change && word < item - left_out)
                change = {list ? QuietChange::Kind::item : QuietChange::Kind::word, name, word, static_cast<std::uint32_t>(i / item), saved[i],
                          p.items[i]};
            p.items[i] = saved[i];
        }
        return saved + words;
    }

    // --- the exchange ---------------------------------------------------------------------------------------------------
    void measure(Passed& passed, std::uint32_t tile) const
    {
        for (auto const& a : facts.arguments) {
            if (a.kind == Kind::list && a.changes) {
                auto const p = store.place(a.number, tile);
                auto& peak = checker.state_peak_[a.number];
                peak = std::max(peak, p.head[0]);
                // The items from the present size to the previous size are dead.
                auto& most = checker.most_[a.number];
                std::size_t const item = store.item_words(a.number);
                if (most[tile] > p.head[0]) std::fill(p.items + p.head[0] * item, p.items + most[tile] * item, poison_word);
                most[tile] = p.head[0];
            }
            if (a.kind != Kind::out) continue;
            for (Direction d : news) {
                auto const n = checker.out[a.number].at(4 * tile + index(d)).head[0];
                if (reader_of(store.links[a.number].edge, store.grid, store.grid.tile(tile), d).delivered) {
                    passed.messages += n;
                    passed.live_bytes += std::uint64_t{n} * store.link_sizes[a.number].message_bytes;
                }
                auto& peak = checker.link_peak_[a.number];
                peak = std::max(peak, n);
            }
        }
    }
    /// Poisons the mail that was read, then copies the messages that were sent.
    bool exchange(LinkUse const& use) const
    {
        auto const& link = store.links[use.link];
        auto const slots = 4 * store.grid.size();
        if (use.reads)
            for (std::uint32_t s = 0; s < slots; ++s) detail::poison(checker.in[use.link].at(s), link.item_words);
        bool sent = false;
        for (std::uint32_t s = 0; s < slots; ++s) {
            auto const from = checker.out[use.link].at(s);
            if ((from.head[0] | from.head[1]) == 0) continue;
            auto const reader = reader_of(link.edge, store.grid, store.grid.tile(s / 4), news[s % 4]);
            if (reader.delivered) {
                sent = true;
                auto const to = checker.in[use.link].at(4 * store.grid.index_of(reader.tile) + index(reader.side));
                std::memcpy(to.items, from.items, std::size_t{from.head[0]} * link.item_words * 4);
                to.head[0] = from.head[0];
                to.head[1] = from.head[1];
            }
            detail::poison(from, link.item_words);
        }
        return sent;
    }
    void check_shared_memory() const
    {
        for (std::uint32_t l = 0; l < store.link_count; ++l) {
            auto const host = store.links[l].memory;
            if (host == l || !store.shares_memory[l]) continue;
            for (std::uint32_t t = 0; t < store.grid.size(); ++t)
                if (checker.unread(l, t) && checker.unread(host, t))
                    fail(t, "channels " + text(store.links[l].name) + " and " + text(store.links[host].name) +
                                " both carry mail (memory_of says that they share their words); give each its own memory");
        }
    }
};

TILEMESH_HOST Passed Checker::superstep(StoreView const& store, RunState& run, Steps const& steps)
{
    auto const& [kernel, everywhere, votes] = steps.program->steps[run.step()];
    auto const& facts = *kernel;
    Step const step{*this, store, run, steps, facts};
    auto const tiles = store.grid.size();
    auto& busy = busy_[parity_];
    std::vector<std::uint8_t> runs(tiles, 0);
    bool any = everywhere;
    for (std::uint32_t t = 0; t < tiles; ++t) {
        bool due = (everywhere && steps.rectangle->contains(store.grid.tile(t))) || busy[t] != 0;
        for (auto const& a : facts.arguments) due = due || (a.kind == ArgumentFacts::Kind::in && unread(a.number, t));
        runs[t] = due;
        any = any || due;
    }
    if (!any) { // if the tiles voted quiet in this kernel, one pass more must change nothing on any of them
        bool const look = steps.check_quiet_tiles && last_kernel_ == &facts;
        bool const first = steps.check_quiet_tiles && last_kernel_ == nullptr; // nobody has voted
        for (std::uint32_t t = 0; look && t < tiles; ++t) step.require_quiet(t, false);
        for (std::uint32_t t = 0; first && would_run_.empty() && t < tiles; ++t)
            if (step.change_of(t)) would_run_ = text(facts.name) + "> [tile " + text(store.grid.tile(t)) + "]";
        return {};
    }
    SuperstepSample* sample = nullptr;
    if (run.trace) {
        run.trace->supersteps.push_back({run.step(), votes, store.capacity_a_side(facts), false, {}, facts.edge, store.absent_a_side(facts)});
        sample = &run.trace->supersteps.back();
    }
    Passed passed;
    passed.ran = true;
    auto const mail = [&](std::uint32_t link) {
        for (std::uint32_t t = 0; t < tiles; ++t)
            if (unread(link, t)) return true;
        return false;
    };
    if (sends_over_unread(facts, mail)) step.fail(0, over_unread);
    for (std::uint32_t t = 0; t < tiles; ++t) {
        if (runs[t] == 0) {
            if (steps.check_quiet_tiles) step.require_quiet(t, everywhere);
            continue;
        }
        busy_[parity_ ^ 1u][t] = step.run(t) == Vote::busy;
        if (sample != nullptr) steps.sample[run.step()](steps.mesh, t, *sample);
        ++passed.tile_runs;
        step.measure(passed, t);
    }
    for (auto const& use : facts.links) passed.sent = step.exchange(use) || passed.sent;
    if (sample != nullptr) sample->sent = passed.sent;
    step.check_shared_memory();
    std::fill(busy.begin(), busy.end(), std::uint8_t{0});
    parity_ ^= 1u;
    last_kernel_ = &facts;
    return passed;
}
TILEMESH_HOST RunCounters Checker::run(StoreView const& store, RunState& run, Steps const& steps, RunState::Limits const& limits)
{
    struct Running {
        Checker& checker;
        StoreView const& store;
        RunState& run;
        Steps const& steps;
    } running{*this, store, run, steps};
    static constexpr auto of = [](void* engine) -> Running& { return *static_cast<Running*>(engine); };
    begin();
    auto counters = run.go_on({&running, [](void* e) { return of(e).checker.superstep(of(e).store, of(e).run, of(e).steps); },
                               [](void* e) { return of(e).checker.any_busy(); }, [](void* e) { return of(e).checker.digest(of(e).store); },
                               [](void* e) {
                                   auto const& checker = of(e).checker;
                                   return list_peaks(of(e).store, checker.state_peak_.data(), checker.link_peak_.data());
                               }},
                              store, limits);
    if (last_kernel_ == nullptr && !would_run_.empty())
        throw Error("a run in which no tile ran (UntilQuiet runs the tiles that voted busy, and nobody had voted; another run of the kernel would "
                    "change a word); begin with Superstep<" + would_run_);
    return counters;
}

}}} // namespace tilemesh::engine
