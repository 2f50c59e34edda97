#pragma once
#include <tilemesh/splat/blending_block.hpp>
#include <tilemesh/splat/depth_sort.hpp>
#include <tilemesh/splat/homes/regions.hpp>

/// Blends a window's splats into the blocks that a tile keeps. The arithmetic, and every bit, is that of blending.hpp: a pixel sees the
/// operations of one long list, whatever rounds cut it into.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::homes {

namespace detail {
using namespace splat::detail;
inline constexpr std::uint32_t strips_a_block = block_width / strip_width;

/// Where run r of `runs` begins among n keys.
TILEMESH_KERNEL std::uint32_t run_begin(std::uint32_t n, std::uint32_t runs, std::uint32_t r) noexcept
{
    std::uint32_t const longer = n % runs;
    return n / runs * r + (r < longer ? r : longer);
}
inline void set_place(BlockPlace& at, BlockAt const& block, Camera const& camera) noexcept
{
    at.column = static_cast<std::int32_t>(block.x);
    at.row = static_cast<std::int32_t>(block.y);
    for (std::uint32_t i = 0; i < block_width; ++i) at.xs[i] = static_cast<float>(block.x + i) + 0.5f - camera.cx;
    for (std::uint32_t j = 0; j < block_height; ++j) at.ys[j] = static_cast<float>(block.y + j) + 0.5f - camera.cy;
}
/// Makes a block black. Pixels outside the frame are dead: their transmittance is negative.
template <class Kept>
void begin_block(Kept& kept, BlockAt const& block, Camera const& camera) noexcept
{
    kept = {};
    for (std::uint32_t j = 0; j < block_height; ++j)
        for (std::uint32_t i = 0; i < block_width; ++i)
            kept.transmittance[j][i] = block.exists && block.x + i < camera.width && block.y + j < camera.height ? 1.0f : -1.0f;
}
/// Those of the strips `mine` in which a pixel goes on, as bits. It reads no other strip, because another worker may write it.
template <class Kept>
std::uint32_t going_strips(Kept const& kept, std::uint32_t mine, float transmittance_min) noexcept
{
    std::uint32_t going = 0;
    for (std::uint32_t s = 0; s < strips_a_block; ++s) {
        if ((mine >> s & 1u) == 0) continue;
        for (auto const& row : kept.transmittance)
            for (std::uint32_t i = 0; i < strip_width; ++i) going |= row[s * strip_width + i] >= transmittance_min ? 1u << s : 0u;
    }
    return going;
}

/// The strips that worker `index` of `count` blends in block `number`, as bits. Strips are dealt one by one, so that the workers share a
/// crowded block.
TILEMESH_KERNEL std::uint32_t strips_of(Worker worker, std::uint32_t number) noexcept
{
    std::uint32_t strips = 0;
    for (std::uint32_t s = 0; s < strips_a_block; ++s)
        strips |= (number * strips_a_block + s) % worker.count == worker.index ? 1u << s : 0u;
    return strips;
}

/// Blends the splats of `hits`, a run (`run_length`), into those columns of a block that have one of `strips`. Adds the pairs that contributed to
/// `contributing`, strip by strip. Each rule has its own function, so that each can use all registers.
template <class Rule, class Stop>
struct BlendStrips {
    template <class Set, class Kept, std::uint32_t Size>
    TILEMESH_KERNEL static void run(Kept& kept, Chunk<Size> const& c, std::uint32_t const* hits, std::uint32_t n, BlockPlace const& at,
                                    std::uint32_t strips, Rules const& m, RowLimits const& limits,
                                    std::uint32_t (&contributing)[strips_a_block]) noexcept
    {
        constexpr std::uint32_t N = Set::most_lanes;
        static_assert(N % strip_width == 0, "lanes are whole strips");
        [[maybe_unused]] alignas(vector_bytes) volatile std::uint32_t const on_bounds = 0; // as in BlendBlock
        constexpr std::uint32_t strips_at_once = (1u << N / strip_width) - 1;
        for (std::uint32_t column = 0; column < block_width; column += N) {
            if ((strips >> column / strip_width & strips_at_once) == 0) continue;
            StripHits<N> const strip(hits, n, column);
            if (strip.count == 0) continue;
            std::uint32_t counts[N];
            blend_columns<Rule, Stop, Set, N>(kept, c, strip.hits, strip.count, at, column, m, limits, counts);
            for (std::uint32_t i = 0; i < N; ++i) contributing[(column + i) / strip_width] += counts[i];
        }
    }
};

/// Blends n splats, front to back, into the strips that are the share of `worker`, N columns at a time. With more than one worker, N is the
/// width of a strip, so that a worker writes only its own strips. With one worker, a stopped strip may be blended beside one that goes on; it
/// changes no bit.
template <class Rule, class Stop, std::uint32_t N, std::uint32_t Size, std::uint32_t Group, class Kept, class SplatAt>
void blend_kept_by(Kept* blocks, Fold const& fold, TileId tile, Camera const& camera, Rules const& rules, std::uint32_t finished,
                   std::uint32_t n, SplatAt const& at, Worker worker, std::uint32_t workers, Work& work) noexcept
{
    struct Open {
        BlockPlace at;
        Kept* kept;
        std::uint32_t number, going, blended;
    };
    typename Rule::Denormals const denormals;
    RowLimits const limits{rules.alpha_min};
    SetOf<N> const set{};
    Open group[Group];
    Chunk<Size> chunk;
    std::uint32_t hits[Size + SetOf<N>::most_lanes]; // one is read ahead
    std::uint32_t const all = fold.tile_blocks();
    for (std::uint32_t next = 0; next < all;) {
        std::uint32_t open = 0;
        for (; open < Group && next < all; ++next) {
            auto const place = block_at(fold, tile, next);
            if (!place.exists || (finished & fold.bit_of(next)) != 0) continue;
            auto& b = group[open];
            b.going = going_strips(blocks[next], strips_of(worker, next), rules.transmittance_min);
            if (b.going == 0) continue;
            b.kept = blocks + next;
            b.number = next;
            b.blended = 0;
            set_place(b.at, place, camera);
            ++open;
        }
        std::uint32_t going = open;
        if (open != 0) fetch_ahead(0, n < Size ? n : Size, at);
        for (std::uint32_t begin = 0; begin < n && going != 0; begin += Size) {
            std::uint32_t const most = fill<Rule>(set, chunk, begin, n, at);
            for (std::uint32_t g = 0; g < open; ++g) {
                auto& b = group[g];
                fetch_part_ahead<Size>(begin + Size, n, g, open, at);
                if (b.going == 0) continue;
                std::uint32_t const count = set.template call<ListHits<Rule>>(chunk, most, b.at, rules.alpha_max, &hits[0]);
                std::uint32_t contributing[strips_a_block] = {};
                for (std::uint32_t done = 0; done < count && b.going != 0;) {
                    std::uint32_t part = blended_between_looks - b.blended % blended_between_looks;
                    if (part > count - done) part = count - done;
                    std::uint32_t const* const run = hits + done;
                    part = run_length<Rule>(run, part);
                    set.template call<BlendStrips<Rule, Stop>>(*b.kept, chunk, run, part, b.at, b.going, rules, limits, contributing);
                    for (std::uint32_t s = 0; s < strips_a_block; ++s)
                        if ((b.going >> s & 1u) != 0) work.strips[(b.number * strips_a_block + s) % workers] += part;
                    done += part;
                    b.blended += part;
                    if (b.blended % blended_between_looks == 0) {
                        b.going = going_strips(*b.kept, b.going, rules.transmittance_min);
                        going -= b.going == 0 ? 1 : 0;
                    }
                }
                for (std::uint32_t s = 0; s < strips_a_block; ++s) // only its own: another worker may write the other counters
                    if (contributing[s] != 0) work.contributing[(b.number * strips_a_block + s) % workers] += contributing[s];
            }
        }
    }
}
template <std::uint32_t N, std::uint32_t Size, std::uint32_t Group, class Kept, class SplatAt>
void blend_kept(Kept* blocks, Fold const& fold, TileId tile, View const& view, std::uint32_t finished, std::uint32_t n, SplatAt const& at,
                Worker worker, std::uint32_t workers, Work& work) noexcept
{
    Rules const& rules = view.rules;
    auto const blend = [&](auto rule, auto stop) noexcept {
        blend_kept_by<decltype(rule), decltype(stop), N, Size, Group>(blocks, fold, tile, view.camera, rules, finished, n, at, worker, workers, work);
    };
    bool const each = rules.arithmetic == Arithmetic::precise || !(rules.alpha_min >= faintest_cut);
    if (rules.stop == Stop::after_crossing && each)
        blend(EachPair{}, StopEachPixel{});
    else if (rules.stop == Stop::after_crossing)
        blend(FastRule{}, StopEachPixel{});
    else if (each)
        blend(EachPair{}, StopBeforeCrossing{});
    else
        blend(FastRule{}, StopBeforeCrossing{});
}
} // namespace detail

/// Blends the splats of a window into the strips of one worker, or into all strips by one host thread.
template <class Kept, class SplatAt>
void blend_window(Kept* blocks, Fold const& fold, TileId tile, View const& view, std::uint32_t finished, std::uint32_t n, SplatAt const& at,
                  Worker worker, Work& work) noexcept
{
    detail::blend_kept<strip_width, 16, 1>(blocks, fold, tile, view, finished, n, at, worker, worker.count, work);
}
template <class Kept, class SplatAt>
void blend_whole_window(Kept* blocks, Fold const& fold, TileId tile, View const& view, std::uint32_t finished, std::uint32_t n,
                        SplatAt const& at, std::uint32_t workers, Work& work) noexcept
{
    detail::blend_kept<splat::detail::lanes_in_use, 128, 8>(blocks, fold, tile, view, finished, n, at, Worker{0, 1}, workers, work);
}

/// Sorts the keys of the window in runs, one for each worker. No exchange.
template <class P>
struct SortRuns {
    static constexpr char const* name = "sort runs";
    void operator()(Window& window, Keys& keys, Worker worker) const noexcept
    {
        if (worker.index == 0) window.runs = worker.count;
        std::uint32_t const n = keys.size(), first = detail::run_begin(n, worker.count, worker.index);
        splat::detail::intro_sort(keys.begin() + first, detail::run_begin(n, worker.count, worker.index + 1) - first);
    }
    /// For a cost model. All workers wait for the one with the longest run.
    static Operations operations(Keys const& keys, Worker worker) noexcept
    {
        std::uint32_t const longest = (keys.size() + worker.count - 1) / worker.count;
        Operations o;
        o[Operation::comparison] = times(longest, heap_levels(longest));
        return o;
    }
};

/// Merges the runs: `Order` lists the keys, the nearest first. No exchange.
template <class P>
struct Merge {
    static constexpr char const* name = "merge";
    static constexpr std::uint32_t most_runs = Work::max_workers;
    void operator()(Window const& window, Keys const& keys, Order& order) const noexcept
    {
        std::uint32_t const n = keys.size();
        std::uint32_t at[most_runs], end[most_runs], depth[most_runs], id[most_runs]; // of each run: its next key
        auto const look = [&](std::uint32_t r) noexcept {
            bool const ended = at[r] == end[r];
            depth[r] = ended ? infinite_depth : keys[at[r]].depth_bits;
            id[r] = ended ? 0 : static_cast<std::uint32_t>(keys[at[r]].id);
        };
        for (std::uint32_t r = 0; r < most_runs; ++r) {
            at[r] = r < window.runs ? detail::run_begin(n, window.runs, r) : n;
            end[r] = r < window.runs ? detail::run_begin(n, window.runs, r + 1) : n;
            look(r);
        }
        order.resize(n);
        for (std::uint32_t i = 0; i < n; ++i) {
            std::uint32_t nearest = 0, nearest_depth = depth[0], nearest_id = id[0];
            for (std::uint32_t r = 1; r < most_runs; ++r) { // no branch: a predictor could not know the run
                std::uint32_t const less = (depth[r] < nearest_depth ? 1u : 0u) | ((depth[r] == nearest_depth ? 1u : 0u) & (id[r] < nearest_id ? 1u : 0u));
                nearest = less != 0 ? r : nearest;
                nearest_depth = less != 0 ? depth[r] : nearest_depth;
                nearest_id = less != 0 ? id[r] : nearest_id;
            }
            order[i] = at[nearest]++;
            look(nearest);
        }
    }
    /// For a cost model. A comparison is of three keys (KernelWork), so a key takes half as many as there are other runs.
    static Operations operations(Window const& window, Order const& order) noexcept
    {
        Operations o;
        o[Operation::comparison] = times(order.size(), window.runs / 2);
        return o;
    }
};

/// Blends the splats of the window, front to back, into the kept blocks. All workers share each block, column by column. No exchange.
template <class P>
struct Blend {
    static constexpr char const* name = "blend";
    static constexpr std::uint32_t most_workers = Work::max_workers;
    using FrameParameters = typename P::Parameters;
    using Access = splat::Access<FrameParameters>;

    void operator()(Here here, Broadcast<FrameParameters> frame, Window const& window, Held<P> const& held, Keys const& keys,
                    Order const& order, BlocksOf<P>& blocks, Work& work, Worker worker) const noexcept
    {
        work.before[worker.index] = work.strips[worker.index];
        if (window.done()) return;
        auto const at = Access::in_order(*frame, held.begin(), keys.begin(), order.begin());
        machine::in_form(machine::is_wide(*frame), blocks.begin(), [&](auto* kept) noexcept {
            blend_window(kept, frame->fold, here.tile, frame->view, window.finished, keys.size(), at, worker, work);
        });
    }
    /// For a cost model. All workers wait for the worker with the most pairs.
    static Operations operations(Work const& work, Worker worker) noexcept
    {
        std::uint32_t most = 0;
        for (std::uint32_t w = 0; w < worker.count; ++w) {
            std::uint32_t const strips = work.strips[w] - work.before[w];
            most = strips > most ? strips : most;
        }
        Operations o;
        o[Operation::pair] = times(most, worker.count * strip_pairs);
        return o;
    }
    /// Computes the shares of all workers at once, for a host thread.
    struct AllWorkers {
        static constexpr char const* name = Blend::name;
        void operator()(Here here, Broadcast<FrameParameters> frame, Window const& window, Held<P> const& held, Keys const& keys,
                        Order const& order, BlocksOf<P>& blocks, Work& work, Worker worker) const noexcept
        {
            for (std::uint32_t w = 0; w < worker.count; ++w) work.before[w] = work.strips[w];
            if (window.done()) return;
            auto const at = Access::in_order(*frame, held.begin(), keys.begin(), order.begin());
            machine::in_form(machine::is_wide(*frame), blocks.begin(), [&](auto* kept) noexcept {
                blend_whole_window(kept, frame->fold, here.tile, frame->view, window.finished, keys.size(), at, worker.count, work);
            });
        }
    };
};

}}} // namespace tilemesh::splat::homes
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
