#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <string>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/engine/mesh_core.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace engine {

namespace detail {
TILEMESH_HOST std::uint32_t checked_threads(std::uint32_t threads)
{
    if (threads > 1024) throw Error(std::to_string(threads) + " threads (a mesh runs on at most 1,024); ask for fewer");
    return std::max(threads, 1u);
}
} // namespace detail

TILEMESH_HOST MeshCore::WorkerState::WorkerState(std::uint32_t tiles, std::uint32_t states, std::uint32_t links)
    : streams(4 * std::size_t{links}), busy(tiles), mail(links, detail::TileSet(tiles)), peaks(line + states + links + line)
{
}
TILEMESH_HOST void MeshCore::WorkerState::begin() noexcept
{
    busy.clear();
    std::fill(peaks.begin(), peaks.end(), 0u);
}

TILEMESH_HOST MeshCore::MeshCore(StoreView const& store, std::uint32_t threads)
    : banks_(store.link_count), rectangle_{0, 0, store.grid.width, store.grid.height}, active_(store.grid.size()),
      shares_(detail::checked_threads(threads)),
      workers_(detail::checked_threads(threads), WorkerState(store.grid.size(), store.state_count, store.link_count)),
      team_(detail::checked_threads(threads))
{
    make_slots(store);
    tiles_.resize(store.grid.size());
    for (std::uint32_t l = 0; l < store.link_count; ++l) make_bank(store, l);
}
TILEMESH_HOST MeshCore::~MeshCore() = default;

/// Fills the tables of places. Messages that an edge drops go to a place after those of all tiles. Each such side has its own place, and
/// nobody reads it.
TILEMESH_HOST void MeshCore::make_slots(StoreView const& store)
{
    auto const grid = store.grid;
    auto const make = [&](std::vector<std::uint32_t>& slots, Edge edge) {
        if (!slots.empty()) return;
        slots.reserve(4 * std::size_t{grid.size()});
        auto bin = 4 * grid.size();
        for (TileId const t : grid.tiles())
            for (Direction d : news)
                slots.push_back(grid.delivers(t, d, edge) ? 4 * grid.index_of(grid.neighbour(t, d, edge)) + index(grid.arrival(t, d, edge))
                                                          : bin++);
    };
    make(slots_, Edge::reflect);
    for (std::uint32_t l = 0; l < store.link_count; ++l) {
        auto const& c = store.links[l];
        if (c.edge == Edge::drop) make(dropping_, Edge::drop);
        if (c.edge == Edge::wrap) make(wrapping_, Edge::wrap);
    }
}
TILEMESH_HOST void MeshCore::make_bank(StoreView const& store, std::uint32_t link)
{
    auto& b = banks_[link];
    auto const& c = store.links[link];
    auto const bins = c.edge == Edge::drop ? 2 * (std::size_t{store.grid.width} + store.grid.height) : 0;
    auto const n = std::size_t{store.grid.size()} * 4;
    auto const capacity = store.link_capacities[link];
    auto const most = store.gets_slots_by_limit(link) ? capacity : store.link_sizes[link].slots;
    auto const stride = ((std::size_t{most} * c.item_words + 15u) & ~std::size_t{15}) | 16u;
    for (auto& heads : b.heads)
        if (heads.data() == nullptr) heads = Arena((n + bins) * Ends::head_words);
    if (stride != b.stride) {
        // A thread's first piece is an eighth of its tiles, and channels are seldom full: a quarter of its tiles' memory holds all pieces. One
        // thread takes all tiles at once: it needs a stretch only for supersteps of a few tiles.
        auto const threads = std::size_t{workers_.size()}, parts = threads == 1 ? 16 : 4 * threads;
        auto const stretch_words = (store.grid.size() + parts - 1) / parts * stride;
        auto const words = std::uint64_t{n} * stride + std::uint64_t{4} * threads * stretch_words;
        Arena items[2] = {Arena(words), Arena(words)};
        for (int i : {0, 1}) b.items[i] = std::move(items[i]);
        b.of_tiles = n * stride;
        b.stretch_words = stretch_words;
        ++exchange_;
    }
    b.capacity = capacity;
    b.stride = stride;
}
TILEMESH_HOST std::array<std::uint32_t*, 4> MeshCore::begin_stream(std::uint32_t link, Piece const& piece, std::uint32_t tiles,
                                                                   std::array<std::uint32_t*, 4> last) noexcept
{
    auto const& bank = banks_[link];
    for (Direction d : news) {
        auto* const stretch = bank.stretch(piece.worker, d);
        auto*& next = last[index(d)];
        auto*& free = workers_[piece.worker].streams[4 * std::size_t{link} + index(d)];
        if (piece.begins) free = stretch;
        else if (next >= stretch) free = next; // the memory of tiles lies before the stretches
        bool const fits = std::size_t{piece.n} * bank.stride <= bank.stretch_words - static_cast<std::size_t>(free - stretch);
        next = fits ? free : bank.items[bank.now].data() + (std::size_t{index(d)} * tiles + piece.first_tile) * bank.stride;
    }
    return last;
}
TILEMESH_HOST void MeshCore::limit_link(StoreView const& store, std::uint32_t link, std::uint32_t items)
{
    auto const before = store.link_capacities[link];
    store.limit_link(link, items, has_mail(link));
    try {
        make_bank(store, link);
    } catch (...) { // out of memory: the channel keeps its old capacity
        store.link_capacities[link] = before;
        throw;
    }
}
TILEMESH_HOST std::vector<Peak> MeshCore::peaks(StoreView const& store) const
{
    std::vector<std::uint32_t> most(store.state_count + store.link_count);
    for (auto const& w : workers_)
        for (std::size_t i = 0; i < most.size(); ++i) most[i] = std::max(most[i], w.peaks[WorkerState::line + i]);
    return list_peaks(store, most.data(), most.data() + store.state_count);
}
TILEMESH_HOST void MeshCore::rethrow()
{
    std::exception_ptr first;
    for (auto& w : workers_) {
        if (!first) first = w.thrown;
        w.thrown = nullptr;
    }
    if (first) std::rethrow_exception(first);
}

TILEMESH_HOST machine::Place MeshCore::sent(StoreView const& store, std::uint32_t link, std::uint32_t tile, Direction d) const noexcept
{
    auto const now = ends(link);
    auto* const head = now.out_head(slot(store.links[link].edge, tile, d));
    std::uint32_t* items;
    std::memcpy(&items, head + 2, sizeof items);
    return {head, items, now.capacity};
}
TILEMESH_HOST void MeshCore::deliver(StoreView const& store, std::uint32_t link, std::uint32_t from, Direction d, std::uint32_t const* head,
                                     std::uint32_t const* items) noexcept
{
    auto const now = ends(link);
    auto const read_at = slot(store.links[link].edge, from, d);
    auto* const place = now.out_items + (std::size_t{index(d)} * store.grid.size() + from) * now.stride;
    auto* const to = now.out_head(read_at);
    std::memcpy(place, items, std::size_t{head[0]} * store.links[link].item_words * 4);
    std::memcpy(to + 2, &place, sizeof place);
    to[0] = head[0];
    to[1] = head[1];
    workers_[0].mail[link].insert(read_at / 4);
}

TILEMESH_HOST bool MeshCore::has_mail(std::uint32_t link) const noexcept
{
    for (auto const& w : workers_)
        if (!w.mail[link].empty()) return true;
    return false;
}
TILEMESH_HOST bool MeshCore::any_busy() const noexcept
{
    for (auto const& w : workers_)
        if (!w.busy.empty()) return true;
    return false;
}
TILEMESH_HOST void MeshCore::forget_waking(KernelFacts const& kernel) noexcept
{
    for (auto& w : workers_) {
        w.busy.clear();
        for (auto const& use : kernel.links)
            if (use.reads) w.mail[use.link].clear();
    }
}
TILEMESH_HOST void MeshCore::list_waking(KernelFacts const& kernel) noexcept
{
    for (auto& w : workers_) {
        active_.take(w.busy);
        for (auto const& use : kernel.links)
            if (use.reads) active_.take(w.mail[use.link]);
    }
}
TILEMESH_HOST void MeshCore::run_on_team(Steps const& steps, std::uint32_t step, std::uint32_t const* tiles, std::uint32_t n,
                                         std::uint32_t most_alone) noexcept
{
    auto const run_tiles = steps.run[step];
    if (team_.size() > 1 && n > most_alone) {
        shares_.set(n);
        team_.share([&](std::uint32_t w) noexcept { run_tiles(steps.mesh, w, tiles, n, true); });
    } else {
        run_tiles(steps.mesh, 0, tiles, n, false);
    }
}
TILEMESH_HOST MeshCore::Failure MeshCore::collect(StoreView const& store, RunState& run, StepFacts const& step, Passed& passed)
{
    Failure failure;
    for (auto& w : workers_) {
        passed.messages += std::exchange(w.messages, 0);
        passed.tile_runs += std::exchange(w.runs, 0);
        passed.live_bytes += std::exchange(w.live_bytes, 0);
        failure.add(w.failure);
    }
    if (run.trace) [[unlikely]]
        append_sample(run, {run.step(), step.votes, store.capacity_a_side(*step.kernel), passed.sent, {}, step.kernel->edge,
                            store.absent_a_side(*step.kernel)});
    return failure;
}
/// Appends a superstep with the samples of all threads to the trace.
TILEMESH_HOST void MeshCore::append_sample(RunState& run, SuperstepSample&& s)
{
    rethrow();
    for (auto& w : workers_) {
        s.tiles.insert(s.tiles.end(), w.samples.begin(), w.samples.end());
        w.samples.clear();
    }
    std::sort(s.tiles.begin(), s.tiles.end(), [](auto const& a, auto const& b) { return a.tile < b.tile; });
    run.trace->supersteps.push_back(std::move(s));
}
TILEMESH_HOST Passed MeshCore::superstep(StoreView const& store, RunState& run, Steps const& steps)
{
    auto const& step = steps.program->steps[run.step()];
    auto const& facts = *step.kernel;
    auto const mail = [&](std::uint32_t link) { return has_mail(link); };
    auto n = store.grid.size();
    bool const all = step.everywhere && rectangle_.covers(store.grid);
    if (all) {
        forget_waking(facts);
    } else {
        if (!step.everywhere && !any_busy() && !mail_to_read(facts, mail)) return {};
        list_waking(facts);
        if (step.everywhere)
            for (auto y = rectangle_.y0; y < rectangle_.y1; ++y)
                active_.insert(y * store.grid.width + rectangle_.x0, y * store.grid.width + rectangle_.x1);
        n = active_.list(tiles_.data());
    }
    auto const* const tiles = all ? nullptr : tiles_.data();
    if (sends_over_unread(facts, mail)) throw run.failed(store.grid, 0, over_unread);
    run_on_team(steps, run.step(), tiles, n, step.everywhere ? 1 : most_tiles_of_one_thread);

    Passed passed;
    passed.ran = true;
    passed.sent = sent_anything(facts, mail);
    flip(facts);
    auto const failure = collect(store, run, step, passed);
    if (failure.count != 0) throw run.failed(store.grid, failure.tile, failure.text, failure.count);
    return passed;
}
TILEMESH_HOST RunCalls MeshCore::calls(Running& running) noexcept
{
    static constexpr auto of = [](void* engine) -> Running& { return *static_cast<Running*>(engine); };
    return {&running, [](void* e) { return of(e).core.superstep(of(e).store, of(e).run, of(e).steps); },
            [](void* e) { return of(e).core.any_busy(); }, [](void* e) { return of(e).core.digest_of(of(e).store, 0, of(e).store.grid.size()); },
            [](void* e) { return of(e).core.peaks(of(e).store); }};
}
TILEMESH_HOST std::uint64_t MeshCore::digest_of(StoreView const& store, std::uint32_t begin, std::uint32_t end) noexcept
{
    shares_.set(end - begin);
    team_.share([&](std::uint32_t w) noexcept {
        for (std::uint32_t first = 0, last = 0; shares_.take(w, first, last);)
            for (auto t = begin + first; t < begin + last; ++t) {
                std::uint64_t mail = 0;
                for (std::uint32_t l = 0; l < store.link_count; ++l)
                    if (!store.undigested_links[l])
                        for (Direction d : news) mail = store.mix_mail(mail, l, ends(l).in(4 * t + index(d)));
                workers_[w].digest += mix(mail, store.digest_states(t));
            }
    });
    std::uint64_t digest = 0;
    for (auto& w : workers_) digest += std::exchange(w.digest, 0);
    return digest;
}

}}} // namespace tilemesh::engine
