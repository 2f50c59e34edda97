#include "sweep.hpp"
#include "setups.hpp"
#include <algorithm>
#include <cmath>
#include <common/homes_machine.hpp>
#include <cstring>
#include <limits>
#include <numeric>
#include <tilemesh/report/naive.hpp>
#include <utility>

namespace channel_capacity {

namespace {

using tilemesh::TileId;
using tilemesh::report::Cause;
using tilemesh::report::Image;
using tilemesh::report::Loss;

constexpr std::uint32_t dense_tiles = tiles / 20; // 5 %

/// The tiles that a Gaussian touches in a view.
class Wanted {
public:
    Wanted(splat::Camera const& camera, splat::Rules const& rules)
        : view_(splat::make_view(camera, rules)),
          tiling_(splat::make_tiling(camera.width, camera.height, (camera.width + grid_columns - 1) / grid_columns,
                                     (camera.height + grid_rows - 1) / grid_rows))
    {}
    template <class F>
    void for_each_tile(splat::Gaussian const& g, F const& f) const
    {
        auto const s = splat::project(g, view_, tiling_);
        if (!s.visible()) return;
        auto const r = s.rect();
        for (auto y = r.y0 / tiling_.tile_height; y <= (r.y1 - 1) / tiling_.tile_height; ++y)
            for (auto x = r.x0 / tiling_.tile_width; x <= (r.x1 - 1) / tiling_.tile_width; ++x) f(y * grid_columns + x);
    }

private:
    splat::View view_;
    splat::Tiling tiling_;
};

/// The facts about a camera that need no machine.
struct Reference {
    Image image;
    std::vector<std::uint32_t> wanted; ///< copies and records a tile
    std::uint64_t sum = 0, dense_sum = 0;
    std::vector<std::uint32_t> dense; ///< the tiles with the most copies and records
};

Reference make_reference(Scene const& scene, splat::Camera const& camera, splat::Rules const& rules)
{
    Reference r;
    r.image = tilemesh::report::render_naive(scene.map.gaussians, camera, rules);
    r.wanted.resize(tiles);
    Wanted const wanted(camera, rules);
    for (auto const& g : scene.map.gaussians) wanted.for_each_tile(g, [&](std::uint32_t t) { ++r.wanted[t]; });
    r.sum = std::accumulate(r.wanted.begin(), r.wanted.end(), std::uint64_t{0});
    r.dense.resize(tiles);
    std::iota(r.dense.begin(), r.dense.end(), 0u);
    std::stable_sort(r.dense.begin(), r.dense.end(), [&](auto a, auto b) { return r.wanted[a] > r.wanted[b]; });
    r.dense.resize(dense_tiles);
    for (auto t : r.dense) r.dense_sum += r.wanted[t];
    return r;
}

bool same_bits(Image const& a, Image const& b)
{
    return a.rgb.size() == b.rgb.size() && std::memcmp(a.rgb.data(), b.rgb.data(), a.rgb.size() * sizeof(float)) == 0;
}

/// Only the PSNR, by `report::compare`'s formula: it chooses the frame that is compared in full.
double psnr_db(Image const& a, Image const& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) {
        double const e = double{a.rgb[i]} - double{b.rgb[i]};
        sum += e * e;
    }
    return sum > 0 ? -10 * std::log10(sum / static_cast<double>(a.rgb.size())) : std::numeric_limits<double>::infinity();
}

/// The row of a Gaussian in a map. Ids are 1 + the row in the file; some rows may have been rejected.
class RowOf {
public:
    explicit RowOf(scene::Map const& map)
    {
        for (std::uint32_t row = 0; row < map.gaussians.size(); ++row) {
            auto const id = static_cast<std::uint32_t>(map.gaussians[row].id);
            if (id >= rows_.size()) rows_.resize(id + 1);
            rows_[id] = row;
        }
    }
    std::uint32_t at(splat::GaussianId id) const { return rows_.at(static_cast<std::uint32_t>(id)); }

private:
    std::vector<std::uint32_t> rows_;
};

/// For each tile, the number of Gaussians that the picture lacks there.
std::vector<std::uint32_t> missing_by_tile(Scene const& scene, Wanted const& wanted, report::FrameReport const& r, std::size_t loaded,
                                           RowOf const& row_of)
{
    std::vector<std::uint32_t> missing(tiles);
    auto const whole = [&](std::uint32_t row) { wanted.for_each_tile(scene.map.gaussians[row], [&](std::uint32_t t) { ++missing[t]; }); };
    for (auto const& l : r.lost) {
        if (l.tile == Loss::whole) whole(row_of.at(l.id));
        else ++missing[l.tile];
    }
    for (auto row = loaded; row < scene.map.gaussians.size(); ++row) whole(static_cast<std::uint32_t>(row));
    return missing;
}

/// The measures of equal pictures.
tilemesh::report::ErrorMeasures equal_pictures()
{
    return {0, 0, 0, std::numeric_limits<double>::infinity(), 1, 0, 0};
}

class MotionSweep {
public:
    MotionSweep(Scene const& scene, std::string const& motion, SweepPlan const& plan, std::filesystem::path const& data,
                std::vector<std::string>& broken)
        : scene_(scene), motion_(motion), cold_(motion == "static"), plan_(plan), broken_(broken),
          cameras_(cameras_of(motion, scene, cold_ ? 1 : plan.frames, data)), row_of_(scene.map)
    {
        auto const rules = make_machine(Saturation::hold, {}, {})->rules();
        for (auto const& camera : cameras_) {
            wanted_.emplace_back(camera, rules);
            if (cold_ && !references_.empty()) references_.push_back(references_.front());
            else references_.push_back(make_reference(scene, camera, rules));
        }
    }

    void run(Saturation saturation, std::vector<Row>& rows)
    {
        auto const all = capacities(plan_, saturation);
        Row const* free = nullptr; // the last row that ran and had no refusals
        Row kept;
        for (std::size_t i = 0; i < all.size(); ++i) {
            auto const s = storage_left(saturation, all[i]);
            bool const same = free != nullptr && s >= free->storage_needed && std::uint64_t{s} * tiles >= scene_.map.gaussians.size();
            // Of the capacities that need not run, the last one runs: its row must be the same.
            bool const check = same && (i + 1 == all.size() || storage_left(saturation, all[i + 1]) < free->storage_needed);
            if (same && !check) {
                Row row = *free;
                row.capacity = all[i];
                row.storage = s;
                row.ran = false;
                rows.push_back(row);
                continue;
            }
            Row const row = run_one(saturation, all[i], s);
            if (check && !(row.exchanges == free->exchanges && row.messages == free->messages && row.peak_channel == free->peak_channel &&
                           row.modelled == free->modelled &&
                           row.peak_storage == free->peak_storage && row.complete()))
                complain(row, "differs from that of " + std::to_string(free->capacity) + " slots, although no limit binds in either");
            rows.push_back(row);
            if (row.refused_channel == 0 && row.refused_storage == 0 && row.complete()) {
                kept = row;
                free = &kept;
            }
        }
    }

    /// The program of homes: each channel end and each FIFO has c slots, and the splats that a tile holds get the remaining bytes.
    void run_homes(std::vector<Row>& rows)
    {
        auto const records = scene_.map.gaussians.size();
        auto const held = [&](std::uint32_t c) { return bench::most_held(records, c, {grid_columns, grid_rows}, scene_.camera.width, scene_.camera.height); };
        auto all = plan_.channel_slots;
        constexpr std::uint32_t fewest = 16; // with one, a frame has thousands of rounds
        for (auto const s : plan_.storage_slots) { // the largest capacity that leaves so many
            std::uint32_t low = 1, high = 4096;
            while (low + 1 < high) (held((low + high) / 2) >= std::max(s, fewest) ? low : high) = (low + high) / 2;
            all.push_back(low);
        }
        std::sort(all.begin(), all.end());
        all.erase(std::unique(all.begin(), all.end()), all.end());
        for (auto const c : all)
            if (held(c) != 0) rows.push_back(run_one_of_homes(c, held(c)));
    }

private:
    Row run_one_of_homes(std::uint32_t c, std::uint32_t held)
    {
        Row row;
        row.scene = scene_.map.name;
        row.motion = motion_;
        row.capacity = c;
        row.storage = held;
        row.saturation = Saturation::homes;
        row.worst = equal_pictures();
        row.psnr_last_db = row.worst.psnr_db;
        auto const machine = bench::make_homes_machine(scene_.map, {.held = held, .homes = static_cast<std::uint32_t>((scene_.map.gaussians.size() + tiles - 1) / tiles),
                                                                    .slots = c, .grid = {grid_columns, grid_rows}});
        for (std::size_t i = 0; i < cameras_.size(); ++i) {
            machine->render(cameras_[i]);
            auto const& r = machine->report();
            if (!same_bits(machine->image(), references_[i].image)) complain(row, "the picture is not the naive one");
            if (r.homes.unfinished_tiles != 0) complain(row, "a tile is not finished");
            if (machine->sram_bytes() > Budget<Held>::machine.sram_bytes) complain(row, "a tile has more bytes than Mk2");
            if (i == 0 && !cold_) continue;
            if (i == 1 && cold_) {
                if (r.exchanges.total() != 0 || r.messages != 0) complain(row, "the view is the same and something moves");
                continue;
            }
            ++row.frames;
            row.modelled.push_back(modelled_homes(machine->trace()));
            row.exchanges += r.exchanges.total();
            row.exchanges_most = std::max(row.exchanges_most, r.exchanges.total());
            row.rounds += r.homes.rounds;
            row.hops += r.hops;
            row.messages += r.messages;
            row.held += r.refused.by_channels();
            row.refused_channel += r.refused.by_channels();
            row.refused_storage += r.homes.refused;
            row.peak_channel = std::max(row.peak_channel, r.peak_channel);
            row.peak_storage = std::max(row.peak_storage, r.peak_storage);
            row.wanted += references_[i].sum;
            row.wanted_dense += references_[i].dense_sum;
        }
        return row;
    }
    void complain(Row const& row, std::string const& what)
    {
        broken_.push_back(row.scene + " " + row.motion + " " + to_string(row.saturation) + ", " + std::to_string(row.capacity) +
                          " slots: " + what);
    }

    Row run_one(Saturation saturation, std::uint32_t c, std::uint32_t s)
    {
        Row row;
        row.scene = scene_.map.name;
        row.motion = motion_;
        row.capacity = c;
        row.storage = s;
        row.saturation = saturation;

        // Records for which all tiles together have no slot are not loaded: the last rows of the file.
        auto const loaded = std::min<std::size_t>(scene_.map.gaussians.size(), std::size_t{s} * tiles);
        row.not_loaded = scene_.map.gaussians.size() - loaded;
        std::unique_ptr<Machine> machine;
        if (row.not_loaded == 0) {
            machine = make_machine(saturation, scene_.map, {.storage_slots = s});
        } else {
            scene::Map part = scene_.map;
            part.gaussians.resize(loaded);
            machine = make_machine(saturation, part, {.storage_slots = s});
        }
        machine->limit_channels(cold_ ? c : 0);

        Image worst_image;
        std::size_t worst = 0;
        row.worst = equal_pictures();
        for (std::size_t i = 0; i < cameras_.size(); ++i) {
            machine->render(cameras_[i]);
            auto const& r = machine->report();
            auto const missing = missing_by_tile(scene_, wanted_[i], r, loaded, row_of_);
            auto const sum = std::accumulate(missing.begin(), missing.end(), std::uint64_t{0});
            check(row, *machine, references_[i], sum, loaded);
            row.storage_needed = std::max(row.storage_needed, r.peak_storage);
            if (i == 0 && !cold_) {
                row.missing_first = sum;
                machine->limit_channels(c);
                continue;
            }
            if (i == 1 && cold_) { // nothing moves, even if the first frame lost records
                if (r.exchanges.total() != 0 || r.messages != 0 || sum != row.missing)
                    complain(row, "the view is the same and something moves");
                continue;
            }
            ++row.frames;
            std::string wrong;
            row.modelled.push_back(modelled(machine->trace(), c, r.exchanges.total(), wrong));
            if (!wrong.empty()) complain(row, wrong);
            row.exchanges += r.exchanges.total();
            row.exchanges_most = std::max(row.exchanges_most, r.exchanges.total());
            row.hops += r.hops;
            row.messages += r.messages;
            row.moved += r.gaussians.moved;
            row.held += r.gaussians.held;
            row.dropped = r.gaussians.dropped;
            row.unplaced = std::max(row.unplaced, r.gaussians.unplaced);
            row.lost_copies += r.lost_copies;
            row.late += r.late_copies + r.gaussians.under_way;
            row.refused_channel += r.refused.by_channels() + r.refused.copies_refused;
            row.refused_storage += r.refused.storage_full + r.refused.copies_full;
            row.peak_channel = std::max(row.peak_channel, r.peak_channel);
            row.peak_storage = std::max(row.peak_storage, r.peak_storage);
            row.wanted += references_[i].sum;
            row.wanted_dense += references_[i].dense_sum;
            row.missing += sum;
            for (auto t : references_[i].dense) row.missing_dense += missing[t];

            row.psnr_last_db = sum == 0 ? std::numeric_limits<double>::infinity() : psnr_db(machine->image(), references_[i].image);
            if (row.psnr_last_db < row.worst.psnr_db) {
                row.worst.psnr_db = row.psnr_last_db;
                worst_image = machine->image();
                worst = i;
            }
        }
        if (worst_image.width != 0) row.worst = tilemesh::report::compare(worst_image, references_[worst].image);
        if (row.peak_channel > c) complain(row, "a channel held " + std::to_string(row.peak_channel) + " records");
        return row;
    }

    void check(Row const& row, Machine& machine, Reference const& reference, std::uint64_t missing, std::size_t loaded)
    {
        auto const& r = machine.report();
        if (missing == 0 && !same_bits(machine.image(), reference.image))
            complain(row, "nothing is missing and the picture is not the naive one");
        if (r.peak_storage > row.storage) complain(row, "a tile held " + std::to_string(r.peak_storage) + " records");
        if (r.gaussians.under_way != 0 || r.late_copies != 0) complain(row, "something is under way after a frame without a bound");
        if (row.saturation == Saturation::hold) {
            if (r.gaussians.dropped != 0 || r.refused.copies_refused != 0) complain(row, "hold dropped a record or a copy");
            if (r.peak_storage < row.storage && !r.lost.empty()) complain(row, "hold lost something where no storage was full");
        }
        // Every record is on one tile, or in the list of losses.
        std::vector<bool> seen(loaded);
        std::uint64_t homes = 0;
        for (auto const& stored : machine.stored())
            if (stored.home) {
                auto const at = row_of_.at(stored.id);
                if (seen[at]) complain(row, "record " + std::to_string(at + 1) + " has two homes");
                seen[at] = true;
                ++homes;
            }
        auto const gone = row.saturation == Saturation::hold ? r.gaussians.unplaced : r.gaussians.dropped;
        if (homes + gone != loaded)
            complain(row, std::to_string(homes) + " records are on tiles and " + std::to_string(gone) + " are listed as missing, of " +
                              std::to_string(loaded));
    }

    Scene const& scene_;
    std::string motion_;
    bool cold_;
    SweepPlan const& plan_;
    std::vector<std::string>& broken_;
    std::vector<splat::Camera> cameras_;
    std::vector<Wanted> wanted_;
    std::vector<Reference> references_;
    RowOf row_of_;
};

} // namespace

std::uint64_t Row::cycles_most() const
{
    std::uint64_t most = 0;
    for (auto const& m : modelled) most = std::max(most, m.cycles(capacity));
    return most;
}
std::uint64_t Row::cycles_mean() const
{
    std::uint64_t sum = 0;
    for (auto const& m : modelled) sum += m.cycles(capacity);
    return (sum + frames / 2) / std::max(frames, 1u);
}
std::uint64_t Row::exchange_mean() const
{
    std::uint64_t sum = 0;
    for (auto const& m : modelled) sum += m.exchange(capacity);
    return (sum + frames / 2) / std::max(frames, 1u);
}

std::uint32_t storage_left(Saturation saturation, std::uint32_t capacity)
{
    return saturation == Saturation::hold ? Budget<Held>::storage_slots(capacity) : Budget<Dropped>::storage_slots(capacity);
}

std::vector<std::uint32_t> capacities(SweepPlan const& plan, Saturation saturation)
{
    std::uint32_t const most = saturation == Saturation::hold ? Budget<Held>::most_channel_slots : Budget<Dropped>::most_channel_slots;
    std::vector<std::uint32_t> all;
    for (auto c : plan.channel_slots)
        if (c >= 1 && c <= most) all.push_back(c);
    for (auto s : plan.storage_slots) {
        auto c = most;
        while (c > 1 && storage_left(saturation, c) < s) --c;
        all.push_back(c);
    }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
}

std::vector<Row> sweep(Scene const& scene, std::string const& motion, SweepPlan const& plan, std::filesystem::path const& data,
                       std::vector<std::string>& broken)
{
    MotionSweep sweeper(scene, motion, plan, data, broken);
    std::vector<Row> rows;
    for (auto saturation : {Saturation::hold, Saturation::drop}) sweeper.run(saturation, rows);
    sweeper.run_homes(rows);
    return rows;
}

Image saturated_pair(Scene const& scene, std::string const& motion, std::uint32_t capacity, scene::Size cut,
                     std::filesystem::path const& data)
{
    auto const cameras = cameras_of(motion, scene, 1, data);
    auto machine = make_machine(Saturation::drop, scene.map, {.storage_slots = storage_left(Saturation::drop, capacity)});
    machine->limit_channels(motion == "static" ? capacity : 0);
    machine->render(cameras[0]);
    if (motion != "static") {
        machine->limit_channels(capacity);
        machine->render(cameras[1]);
    }
    auto const& image = machine->image();
    auto const& camera = motion == "static" ? cameras[0] : cameras[1];
    auto const full = tilemesh::report::render_naive(scene.map.gaussians, camera, machine->rules());

    // The part of the picture with the largest error, aligned to the tiles' grid.
    auto const dx = (camera.width + grid_columns - 1) / grid_columns, dy = (camera.height + grid_rows - 1) / grid_rows;
    cut.width = std::min(cut.width, camera.width);
    cut.height = std::min(cut.height, camera.height);
    double most = -1;
    std::uint32_t left = 0, top = 0;
    for (std::uint32_t y = 0; y + cut.height <= camera.height; y += dy)
        for (std::uint32_t x = 0; x + cut.width <= camera.width; x += dx) {
            double sum = 0;
            for (auto py = y; py < y + cut.height; py += 2)
                for (auto px = x; px < x + cut.width; px += 2) {
                    auto const* a = image.pixel(px, py);
                    auto const* b = full.pixel(px, py);
                    for (int c = 0; c < 3; ++c) sum += double{a[c] - b[c]} * double{a[c] - b[c]};
                }
            if (sum > most) most = sum, left = x, top = y;
        }
    constexpr std::uint32_t gap = 8;
    Image pair(2 * cut.width + gap, cut.height);
    std::fill(pair.rgb.begin(), pair.rgb.end(), 1.0f);
    for (std::uint32_t y = 0; y < cut.height; ++y) {
        auto const bytes = std::size_t{3} * cut.width * sizeof(float);
        std::memcpy(pair.pixel(0, y), image.pixel(left, top + y), bytes);
        std::memcpy(pair.pixel(cut.width + gap, y), full.pixel(left, top + y), bytes);
    }
    return pair;
}

} // namespace channel_capacity
