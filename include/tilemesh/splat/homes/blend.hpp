#pragma once
#include <tilemesh/splat/blending_block.hpp>
#include <tilemesh/splat/cell_tiles.hpp>
#include <tilemesh/splat/depth_sort.hpp>
#include <tilemesh/splat/homes/block_lists.hpp>
#include <tilemesh/splat/homes/regions.hpp>

/// Blends a window's splats into the blocks that a tile keeps. The arithmetic, and every bit, is that of blending.hpp: a pixel sees the
/// operations of one long list, whatever rounds cut it into. `fast` blends the cells that a block touches.
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
    bool const whole = block.exists && block.x + block_width <= camera.width && block.y + block_height <= camera.height;
    for (auto& row : kept.transmittance)
        for (float& t : row) t = whole ? 1.0f : -1.0f;
    for (std::uint32_t j = 0; j < block_height && block.exists && !whole; ++j)
        for (std::uint32_t i = 0; i < block_width; ++i)
            if (block.x + i < camera.width && block.y + j < camera.height) kept.transmittance[j][i] = 1.0f;
}
/// Those of the strips `mine` in which a pixel goes on, as bits. It reads no other strip, because another worker may write it.
template <class Kept>
std::uint32_t going_strips(Kept const& kept, std::uint32_t mine, float transmittance_min) noexcept
{
    std::uint32_t going = 0;
    if (mine == (1u << strips_a_block) - 1) {
        std::uint32_t columns[block_width] = {}; // in vectors
        for (auto const& row : kept.transmittance)
            for (std::uint32_t i = 0; i < block_width; ++i) columns[i] |= row[i] >= transmittance_min ? 1u : 0u;
        for (std::uint32_t i = 0; i < block_width; ++i) going |= columns[i] << i / strip_width;
        return going;
    }
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

/// Blends the splats of `hits`, at most blended_between_looks, into those columns of a block that have one of `strips`. Adds the pairs that
/// contributed to `contributing`, strip by strip. Each rule has its own function, so that each can use all registers.
template <class Stop>
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
            blend_columns<Stop, N>(kept, c, strip.hits, strip.count, at, column, m, limits, counts);
            for (std::uint32_t i = 0; i < N; ++i) contributing[(column + i) / strip_width] += counts[i];
        }
    }
};

/// Blends n splats, front to back, into the strips that are the share of `worker`, N columns at a time. With more than one worker, N is the
/// width of a strip, so that a worker writes only its own strips. With one worker, a stopped strip may be blended beside one that goes on; it
/// changes no bit.
template <class Stop, std::uint32_t N, std::uint32_t Size, std::uint32_t Group, class Kept, class SplatAt>
[[gnu::noinline]] void blend_kept_blocks(Kept* blocks, Fold const& fold, TileId tile, Camera const& camera, Rules const& rules,
                                         std::uint32_t finished, std::uint32_t n, SplatAt const& at, Worker worker, std::uint32_t workers,
                                         Work& work) noexcept
{
    struct Open {
        BlockPlace at;
        Kept* kept;
        std::uint32_t number, going, blended;
    };
    RowLimits const limits{rules.alpha_min};
    SetOf<N> const set{};
    Open group[Group];
    Chunk<Size> chunk;
    std::uint32_t hits[Size + SetOf<N>::most_lanes];
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
            std::uint32_t const most = fill(set, chunk, begin, n, at);
            for (std::uint32_t g = 0; g < open; ++g) {
                auto& b = group[g];
                fetch_part_ahead<Size>(begin + Size, n, g, open, at);
                if (b.going == 0) continue;
                std::uint32_t const count = set.template call<ListHits>(chunk, most, b.at, &hits[0]);
                std::uint32_t contributing[strips_a_block] = {};
                for (std::uint32_t done = 0; done < count && b.going != 0;) {
                    std::uint32_t part = blended_between_looks - b.blended % blended_between_looks;
                    if (part > count - done) part = count - done;
                    set.template call<BlendStrips<Stop>>(*b.kept, chunk, hits + done, part, b.at, b.going, rules, limits, contributing);
                    for (std::uint32_t s = 0; s < strips_a_block; ++s)
                        if ((b.going >> s & 1u) != 0)
                            work.evaluated[(b.number * strips_a_block + s) % workers] += part * (strip_width * block_height / pairs_a_count);
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

/// A block is two cells wide; its five rows touch two rows of cells.
inline constexpr std::uint32_t cells_across = block_width / cell_width, bands_a_block = 2, strips_a_cell = cell_width / strip_width;
static_assert(block_height > 1 && block_height <= cell_height + 1,
              "wherever a block begins, it touches at most two rows of cells");

/// Counts the pairs of kept cells, strip by strip. `OpenCell::number` is the number of the first strip. Cells look by their own splats alone, so
/// it does not matter whether a list also has splats that reach other blocks only.
struct StripTally {
    static constexpr bool by_groups = false;
    Work* work;
    std::uint32_t workers;
    float transmittance_min;

    template <class AnyCell>
    void evaluated(AnyCell const& cell, std::uint32_t splats) const noexcept
    {
        for (std::uint32_t s = 0; s < strips_a_cell; ++s)
            if ((cell.columns >> s * strip_width & 1u) != 0)
                work->evaluated[(cell.number + s) % workers] += splats * (strip_width * cell_height / pairs_a_count);
    }
    /// Leaves the columns of the strips in which a pixel goes on.
    template <class AnyCell>
    void look(AnyCell& cell) const noexcept
    {
        std::uint32_t columns[cell_width] = {}, going = 0; // in vectors
        for (auto const& row : cell.state.transmittance)
            for (std::uint32_t i = 0; i < cell_width; ++i) columns[i] |= row[i] >= transmittance_min ? 1u : 0u;
        for (std::uint32_t i = 0; i < cell_width; ++i) going |= (columns[i] * ((1u << strip_width) - 1)) << i / strip_width * strip_width;
        cell.columns &= going;
    }
};
/// Copies those columns of a cell's row that have one of `strips`, which are the cell's.
TILEMESH_KERNEL void copy_strips(float* to, float const* from, std::uint32_t strips) noexcept
{
    constexpr std::uint32_t all = (1u << strips_a_cell) - 1;
    if ((strips & all) == all)
        __builtin_memcpy(to, from, cell_width * sizeof(float));
    else
        for (std::uint32_t i = 0; i < cell_width; ++i)
            if ((strips >> i / strip_width & 1u) != 0) to[i] = from[i];
}
/// Calls f(row of the cell, row of the block) for each plane of each row that a cell and a block have in common.
template <class AnyCell, class Kept, class F>
void for_common_rows(AnyCell& cell, Kept& kept, BlockAt const& block, F const& f) noexcept
{
    std::uint32_t const x = cell.at.column - block.x;
    for (std::uint32_t j = 0; j < cell_height; ++j) {
        std::uint32_t const y = cell.at.row + j - block.y; // wraps above the block
        if (y >= block_height) continue;
        f(cell.state.transmittance[j], kept.transmittance[y] + x);
        f(cell.state.red[j], kept.red[y] + x), f(cell.state.green[j], kept.green[y] + x), f(cell.state.blue[j], kept.blue[y] + x);
        if constexpr (Kept::has_depth) f(cell.state.weight[j], kept.weight[y] + x), f(cell.state.depth[j], kept.depth[y] + x);
    }
}
/// Opens a cell with what a block has kept of it. `strips`: those of the cell that are this worker's; the pixels of the others take no part,
/// because another worker may write them.
template <class AnyCell, class Kept>
void load_cell(AnyCell& cell, Kept const& kept, BlockAt const& block, std::uint32_t strips) noexcept
{
    for_common_rows(cell, kept, block, [strips](float* mine, float const* its) noexcept { copy_strips(mine, its, strips); });
}
/// Gives the block its pixels back.
template <class AnyCell, class Kept>
void keep_cell(AnyCell const& cell, Kept& kept, BlockAt const& block, std::uint32_t strips) noexcept
{
    for_common_rows(cell, kept, block, [strips](float const* mine, float* its) noexcept { copy_strips(its, mine, strips); });
}
/// Opens the cells of a part of a block, `columns` wide and `bands_a_block` high, with what the block has kept of them. `first`: the first cell's
/// column in the block. `strips`: the worker's, of the block.
template <class AnyCell, class Kept>
CellWindow open_cells(AnyCell* cells, std::uint32_t columns, std::uint32_t first, Kept const& kept, BlockAt const& block, std::uint32_t number,
                      std::uint32_t strips, Camera const& camera) noexcept
{
    std::uint32_t const column = block.x + first * cell_width, row = block.y / cell_height * cell_height;
    for (std::uint32_t k = 0; k < columns * bands_a_block; ++k) {
        cells[k].begin({column + k % columns * cell_width, row + k / columns * cell_height, camera.cx, camera.cy}, {});
        cells[k].number = (number * cells_across + first + k % columns) * strips_a_cell;
        cells[k].in_window = k;
        load_cell(cells[k], kept, block, strips >> (cells[k].number % strips_a_block));
    }
    return {column, row, columns, bands_a_block, &camera};
}
/// Gives a block the pixels of a part of it, and counts its pairs.
template <class AnyCell, class Kept>
void close_cells(AnyCell const* cells, std::uint32_t count, Kept& kept, BlockAt const& block, std::uint32_t strips, std::uint32_t workers,
                 Work& work) noexcept
{
    for (std::uint32_t k = 0; k < count; ++k) {
        auto const& cell = cells[k];
        keep_cell(cell, kept, block, strips >> (cell.number % strips_a_block));
        for (std::uint32_t i = 0; i < cell_width; ++i) // only its own: another worker may write the other counters
            if (cell.state.contributing[i] != 0)
                work.contributing[(cell.number + i / strip_width) % workers] += static_cast<std::uint32_t>(cell.state.contributing[i]);
    }
}
/// `blend_kept_blocks` in cells for a worker, which has little memory: a part of a block that is one cell wide at a time.
template <class Rule, std::uint32_t N, std::uint32_t Size, class Kept, class SplatAt>
[[gnu::noinline]] void blend_kept_cells(Kept* blocks, Fold const& fold, TileId tile, Camera const& camera, Rules const& rules, std::uint32_t finished,
                                        std::uint32_t n, SplatAt const& at, Worker worker, std::uint32_t workers, Work& work) noexcept
{
    typename Rule::Denormals const denormals;
    CellMemory<Kept::has_depth, bands_a_block, Size> m;
    StripTally const tally{&work, workers, rules.transmittance_min};
    for (std::uint32_t part = 0; part < fold.tile_blocks() * cells_across; ++part) {
        std::uint32_t const number = part / cells_across, first = part % cells_across;
        auto const place = block_at(fold, tile, number);
        if (!place.exists || (finished & fold.bit_of(number)) != 0) continue;
        std::uint32_t const mine = strips_of(worker, number) & ((1u << strips_a_cell) - 1) << first * strips_a_cell;
        if (going_strips(blocks[number], mine, rules.transmittance_min) == 0) continue;
        auto const window = open_cells(m.cells, 1, first, blocks[number], place, number, mine, camera);
        for (auto& cell : m.cells) tally.look(cell);
        blend_open_cells<Rule, StopAsAsked, N>(m, window, bands_a_block, rules, n, at, tally);
        close_cells(m.cells, bands_a_block, blocks[number], place, mine, workers, work);
    }
}
/// The same for a host thread: block by block, each with the splats that may reach it.
template <class Rule, std::uint32_t N, std::uint32_t Size, class Kept, class SplatAt>
[[gnu::noinline]] void blend_listed_blocks(Kept* blocks, Fold const& fold, TileId tile, Camera const& camera, Rules const& rules,
                                           std::uint32_t finished, std::uint32_t n, SplatAt const& at, std::uint32_t workers, Work& work) noexcept
{
    typename Rule::Denormals const denormals;
    constexpr std::uint32_t cells_a_block = cells_across * bands_a_block, all_strips = (1u << strips_a_block) - 1;
    CellMemory<Kept::has_depth, cells_a_block, Size> m;
    StripTally const tally{&work, workers, rules.transmittance_min};
    struct {
        std::uint32_t columns[cells_a_block], blended[cells_a_block];
    } paused[BlockGroup::most]; // what a cell has no place for in its block, from list to list
    for_each_group(fold, [&](BlockGroup const& group) noexcept {
        std::uint32_t open = 0, begun = 0; // blocks, as bits
        for (std::uint32_t k = 0; k < group.count(); ++k) {
            std::uint32_t const number = group.number(k, fold);
            bool const goes = block_at(fold, tile, number).exists && (finished & fold.bit_of(number)) == 0;
            if (goes && going_strips(blocks[number], all_strips, rules.transmittance_min) != 0) open |= 1u << k;
        }
        if (open == 0) return;
        BlockLists lists(fold, tile, group, camera);
        for (std::uint32_t next = 0; next < n && open != 0;) {
            next = lists.list(next, n, open, at);
            for (std::uint32_t k = 0; k < group.count(); ++k) {
                auto const list = lists.of(k);
                if (list.count == 0) continue;
                std::uint32_t const number = group.number(k, fold);
                auto const place = block_at(fold, tile, number);
                auto const window = open_cells(m.cells, cells_across, 0, blocks[number], place, number, all_strips, camera);
                for (std::uint32_t c = 0; c < cells_a_block; ++c)
                    if ((begun >> k & 1u) == 0) tally.look(m.cells[c]);
                    else m.cells[c].columns = paused[k].columns[c], m.cells[c].blended = paused[k].blended[c];
                begun |= 1u << k;
                blend_open_cells<Rule, StopAsAsked, N>(m, window, cells_a_block, rules, list.count, list, tally);
                close_cells(m.cells, cells_a_block, blocks[number], place, all_strips, workers, work);
                if (!goes_on(m.cells, cells_a_block)) open &= ~(1u << k);
                for (std::uint32_t c = 0; c < cells_a_block; ++c)
                    paused[k].columns[c] = m.cells[c].columns, paused[k].blended[c] = m.cells[c].blended;
            }
        }
    });
}
template <std::uint32_t N, std::uint32_t Size, std::uint32_t Group, class Kept, class SplatAt>
void blend_kept(Kept* blocks, Fold const& fold, TileId tile, View const& view, std::uint32_t finished, std::uint32_t n, SplatAt const& at,
                Worker worker, std::uint32_t workers, Work& work) noexcept
{
    Rules const& rules = view.rules;
    bool const each = rules.arithmetic == Arithmetic::precise || !(rules.alpha_min >= faintest_cut);
    if (!each) {
        if constexpr (Group == 1) blend_kept_cells<FastRule, N, Size>(blocks, fold, tile, view.camera, rules, finished, n, at, worker, workers, work);
        else blend_listed_blocks<FastRule, N, Size>(blocks, fold, tile, view.camera, rules, finished, n, at, workers, work);
    } else if (rules.stop == Stop::after_crossing) {
        blend_kept_blocks<StopEachPixel, N, Size, Group>(blocks, fold, tile, view.camera, rules, finished, n, at, worker, workers, work);
    } else {
        blend_kept_blocks<StopBeforeCrossing, N, Size, Group>(blocks, fold, tile, view.camera, rules, finished, n, at, worker, workers, work);
    }
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

namespace detail {
/// The words behind n keys, in which a host's SortRuns leaves their order for Merge; null if there is no room.
template <class List>
TILEMESH_KERNEL auto* words_behind(List& keys, std::uint32_t n) noexcept
{
    using Word = std::conditional_t<std::is_const_v<std::remove_pointer_t<decltype(keys.begin())>>, std::uint32_t const, std::uint32_t>;
    return n <= (keys.capacity() - n) * (sizeof(SortKey) / 4) ? reinterpret_cast<Word*>(keys.begin() + n) : nullptr;
}
/// Sorts the runs of n keys, all at once. `spare`: room for n keys, outside the keys. It sorts all keys, if they are many by digits of their
/// depths, and then deals them to their runs. If `order` is not null, it gets the numbers of the keys in depth order.
inline void sort_runs_at_once(SortKey* keys, std::uint32_t n, std::uint32_t runs, SortKey* spare, std::uint32_t* order) noexcept
{
    constexpr std::uint32_t tag = 28, slots = (1u << tag) - 1; // a key has its run above its slot
    static_assert(Work::max_workers < 1u << (32 - tag));
    std::uint32_t next[Work::max_workers];
    for (std::uint32_t r = 0; r < runs; ++r) {
        next[r] = run_begin(n, runs, r);
        for (std::uint32_t i = next[r], end = run_begin(n, runs, r + 1); i < end; ++i) keys[i].slot |= r << tag;
    }
    n >= fewest_by_digits ? sort_by_digits(keys, n, spare) : intro_sort(keys, n);
    __builtin_memcpy(spare, keys, n * sizeof *keys);
    for (std::uint32_t i = 0; i < n; ++i) {
        std::uint32_t const at = next[spare[i].slot >> tag]++;
        keys[at] = {spare[i].depth_key, spare[i].id, spare[i].slot & slots};
        if (order != nullptr) order[i] = at;
    }
}
} // namespace detail

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
    /// Sorts the runs of all workers at once, for a host thread.
    struct AllWorkers {
        static constexpr char const* name = SortRuns::name;
        void operator()(Window& window, Keys& keys, Worker worker) const noexcept
        {
            using Access = splat::Access<typename P::Parameters>;
            Access::about_to_read(keys);
            window.runs = worker.count;
            constexpr std::uint32_t most = 2048; // keys in 24 KB of a thread's stack
            std::uint32_t const n = keys.size();
            if (n <= most) {
                SortKey spare[most];
                detail::sort_runs_at_once(keys.begin(), n, worker.count, spare, Access::on_host ? detail::words_behind(keys, n) : nullptr);
            } else {
                for (std::uint32_t r = 0; r < worker.count; ++r) {
                    std::uint32_t const first = detail::run_begin(n, worker.count, r);
                    splat::detail::intro_sort(keys.begin() + first, detail::run_begin(n, worker.count, r + 1) - first);
                }
            }
        }
    };
};

namespace detail {
/// Takes an order of n keys if it is one, whoever left it: keys are distinct, so n numbers below n of rising keys are all of them. Depths
/// are above 0.
inline bool take_order(SortKey const* keys, std::uint32_t n, std::uint32_t const* left, std::uint32_t* order) noexcept
{
    std::uint32_t depth = 0, id = 0, rising = 1; // no branch
    for (std::uint32_t i = 0; i < n; ++i) {
        std::uint32_t const at = left[i] < n ? left[i] : 0, next_id = static_cast<std::uint32_t>(keys[at].id);
        std::uint32_t const less = (depth < keys[at].depth_key ? 1u : 0u) | ((depth == keys[at].depth_key ? 1u : 0u) & (id < next_id ? 1u : 0u));
        rising &= (at == left[i] ? 1u : 0u) & less;
        depth = keys[at].depth_key;
        id = next_id;
        order[i] = at;
    }
    return rising != 0;
}
} // namespace detail

/// Merges the runs: `Order` lists the keys, the nearest first. No exchange.
template <class P>
struct Merge {
    static constexpr char const* name = "merge";
    static constexpr std::uint32_t most_runs = Work::max_workers;
    using Access = splat::Access<typename P::Parameters>;
    void operator()(Window const& window, Keys const& keys, Order& order) const noexcept
    {
        std::uint32_t const n = keys.size();
        std::uint32_t at[most_runs], end[most_runs], depth[most_runs], id[most_runs]; // of each run: its next key
        auto const look = [&](std::uint32_t r) noexcept {
            bool const ended = at[r] == end[r];
            depth[r] = ended ? infinite_depth : keys[at[r]].depth_key;
            id[r] = ended ? 0 : static_cast<std::uint32_t>(keys[at[r]].id);
        };
        for (std::uint32_t r = 0; r < most_runs; ++r) {
            at[r] = r < window.runs ? detail::run_begin(n, window.runs, r) : n;
            end[r] = r < window.runs ? detail::run_begin(n, window.runs, r + 1) : n;
            look(r);
        }
        order.resize(n);
        if constexpr (Access::on_host) {
            auto const* const left = detail::words_behind(keys, n);
            if (left != nullptr && detail::take_order(keys.begin(), n, left, order.begin())) return;
        }
        for (std::uint32_t i = 0; i < n; ++i) {
            std::uint32_t nearest = 0, nearest_depth = depth[0], nearest_id = id[0];
            for (std::uint32_t r = 1; r < most_runs; ++r) { // no branch: a predictor could not know the run
                std::uint32_t const less =
                    (depth[r] < nearest_depth ? 1u : 0u) | ((depth[r] == nearest_depth ? 1u : 0u) & (id[r] < nearest_id ? 1u : 0u));
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
        work.before[worker.index] = work.evaluated[worker.index];
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
            std::uint32_t const evaluated = work.evaluated[w] - work.before[w];
            most = evaluated > most ? evaluated : most;
        }
        Operations o;
        o[Operation::pair] = times(most, worker.count * pairs_a_count);
        return o;
    }
    /// Computes the shares of all workers at once, for a host thread.
    struct AllWorkers {
        static constexpr char const* name = Blend::name;
        void operator()(Here here, Broadcast<FrameParameters> frame, Window const& window, Held<P> const& held, Keys const& keys,
                        Order const& order, BlocksOf<P>& blocks, Work& work, Worker worker) const noexcept
        {
            for (std::uint32_t w = 0; w < worker.count; ++w) work.before[w] = work.evaluated[w];
            if (window.done()) return;
            Access::about_to_read(held);
            Access::about_to_read(keys);
            Access::about_to_read(order);
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
