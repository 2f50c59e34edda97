// test: unoptimised asan, without tsan, cost 20
// The program of homes on adversarial maps, with random capacities, grids and frames. Each round of each tile is checked against a list of
// all splats, and the picture against the naive loop.
#include "blended.hpp"
#include <tilemesh/render/homes_renderer.hpp>

using namespace tilemesh;
namespace homes = splat::homes;
using splat::block_height, splat::block_width;
using support::Random;

namespace {
using Policies = homes::HostPolicies<>;
using Homes = render::HomesRenderer<Policies>;

constexpr char const* kinds[] = {"needles", "equal depths", "coincident means", "one pixel",      "dust",
                                 "walls",   "the frame's edge", "a cloud",      "an opaque clump"};
constexpr std::uint32_t kind_count = sizeof kinds / sizeof *kinds;

/// Gaussians in front of `support::lens(width, height)`. Their ids are not in the order of their rows, and some are above 2^31.
std::vector<splat::Gaussian> adversarial(std::uint32_t kind, std::uint32_t n, std::uint32_t width, std::uint32_t height, Random& random)
{
    auto const camera = support::lens(width, height);
    std::vector<splat::Gaussian> out = support::cloud(n, random.bits());
    std::vector<std::uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0u);
    for (std::uint32_t i = n; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
    /// Puts a Gaussian's mean onto a pixel coordinate at depth z.
    auto const put = [&](splat::Gaussian& g, float x, float y, float z) {
        g.mean_world[0] = (x - camera.cx) / camera.fx * z;
        g.mean_world[1] = (y - camera.cy) / camera.fy * z;
        g.mean_world[2] = z;
    };
    auto const anywhere = [&](splat::Gaussian& g, float z) {
        put(g, random.uniform(0, static_cast<float>(width)), random.uniform(0, static_cast<float>(height)), z);
    };
    auto const size_px = [&](splat::Gaussian& g, float sigma_px) {
        for (float& s : g.log_scale) s = std::log(sigma_px * g.mean_world[2] / camera.fx);
    };
    float const px = random.uniform(0, static_cast<float>(width)), py = random.uniform(0, static_cast<float>(height));
    for (std::uint32_t i = 0; i < n; ++i) {
        auto& g = out[i];
        g.id = splat::GaussianId{random.below(2) == 0 ? order[i] + 1 : 0xffffffffu - order[i]};
        switch (kind) {
        case 0:
            anywhere(g, random.uniform(1, 4));
            g.log_scale[0] = random.uniform(-2, 2);
            g.log_scale[1] = g.log_scale[2] = -9;
            break;
        case 1: // all at one depth, or at one of two depths that are neighbours
            anywhere(g, 2);
            if (n % 2 == 0 && random.below(2) == 0) g.mean_world[2] = std::nextafter(2.0f, 3.0f);
            break;
        case 2:
            put(g, px, py, 3);
            break;
        case 3:
            put(g, std::floor(px) + random.uniform(0, 1), std::floor(py) + random.uniform(0, 1), 1.5f + 0.125f * static_cast<float>(random.below(16)));
            size_px(g, 0.3f);
            g.opacity = random.uniform(0.01f, 0.2f);
            break;
        case 4:
            anywhere(g, random.uniform(0.5f, 9));
            size_px(g, std::exp(random.uniform(-12, -1)));
            break;
        case 5:
            anywhere(g, random.uniform(1, 2));
            size_px(g, random.uniform(20, 500));
            g.opacity = random.uniform(0.005f, 0.08f);
            break;
        case 6: {
            float const w = static_cast<float>(width), h = static_cast<float>(height);
            float const along = random.uniform(0, 1), off = random.uniform(-3, 3);
            bool const far = random.below(2) == 0;
            if (random.below(2) == 0)
                put(g, (far ? w : 0.0f) + off, along * h, random.uniform(1, 3));
            else
                put(g, along * w, (far ? h : 0.0f) + off, random.uniform(1, 3));
            size_px(g, random.uniform(0.1f, 6));
            break;
        }
        case 8: // a clump, whose blocks stop before the others
            anywhere(g, 1 + 0.01f * static_cast<float>(random.below(200)));
            if (i % 4 != 0) put(g, px + random.uniform(-6, 6), py + random.uniform(-3, 3), g.mean_world[2]);
            size_px(g, random.uniform(4, 12));
            g.opacity = random.uniform(0.7f, 1);
            break;
        default:
            break;
        }
    }
    return out;
}

bool same(homes::Key const& a, homes::Key const& b) { return !(a < b) && !(b < a); }

/// A visible splat of a view, and the blocks of the frame in which it shows something.
struct Item {
    homes::Key key;
    splat::PixelRect blocks; ///< of its rectangle
    std::vector<std::pair<std::uint32_t, std::uint32_t>> shown;
};
std::vector<Item> items_of(scene::Map const& map, splat::Camera const& camera, splat::Rules const& rules)
{
    auto const view = splat::make_view(camera, rules);
    auto const tiling = splat::make_tiling(camera.width, camera.height, camera.width, camera.height);
    // The pairs of `fast` differ by 2e-5; a pair this close to the limit may or may not count.
    float const least = rules.alpha_min + (rules.arithmetic == splat::Arithmetic::fast ? 4e-5f : 0.0f);
    std::vector<Item> items;
    for (auto const& g : map.gaussians) {
        auto const s = splat::project(g, view, tiling);
        if (!s.visible()) continue;
        auto const r = s.rect();
        Item item{{s.depth_key, static_cast<std::uint32_t>(g.id)},
                  {r.x0 / block_width, (r.x1 - 1) / block_width + 1, r.y0 / block_height, (r.y1 - 1) / block_height + 1},
                  {}};
        for (auto j = item.blocks.y0; j < item.blocks.y1; ++j)
            for (auto i = item.blocks.x0; i < item.blocks.x1; ++i) {
                bool shows = false;
                for (auto y = std::max(r.y0, j * block_height); y < std::min(r.y1, (j + 1) * block_height) && !shows; ++y)
                    for (auto x = std::max(r.x0, i * block_width); x < std::min(r.x1, (i + 1) * block_width) && !shows; ++x)
                        shows = splat::alpha_at(s, static_cast<float>(x) + 0.5f - camera.cx, static_cast<float>(y) + 0.5f - camera.cy) >= least;
                if (shows) item.shown.emplace_back(i, j);
            }
        items.push_back(std::move(item));
    }
    std::sort(items.begin(), items.end(), [](Item const& a, Item const& b) { return a.key < b.key; });
    return items;
}

/// Watches a renderer. In each round, when delivery is quiet, it compares what each tile holds with the list of all splats.
class Watch {
public:
    explicit Watch(Homes& renderer) : renderer_(renderer)
    {
        renderer.observe([this](SuperstepEvent const& e) {
            if (e.kernel == homes::Begin<Policies>::name) chapter();
            if (e.kernel == homes::Merge<Policies>::name) round();
            if (e.kernel == homes::Advance<Policies>::name) finished_bits();
        });
    }
    void begin(std::vector<Item> items, float transmittance_min)
    {
        items_ = std::move(items);
        transmittance_min_ = transmittance_min;
        wrong_ = {};
    }
    struct Wrong {
        std::uint32_t order, outside, missing, needless, moved, slots, late, bits, uncalled;
        friend bool operator==(Wrong const&, Wrong const&) = default;
    };
    Wrong const& wrong() const { return wrong_; }
    std::uint64_t partly_finished = 0; ///< finished blocks of tiles that went on

private:
    template <class X>
    auto state(TileId t)
    {
        return std::as_const(renderer_.mesh()).template state<X>(t);
    }
    homes::Window window(TileId t) { return std::as_const(renderer_.mesh()).template state<homes::Window>(t); }

    /// All windows begin anew, and wait for the records that are on their homes now.
    void chapter()
    {
        ids_.clear();
        resident_.clear();
        frontiers_.clear();
        arrived_.clear();
        auto const grid = renderer_.mesh().grid();
        for (std::uint32_t t = 0; t < grid.size(); ++t)
            for (auto const& r : state<homes::Home<Policies>>(grid.tile(t))) {
                ids_[r.row] = static_cast<std::uint32_t>(r.id);
                resident_.insert(static_cast<std::uint32_t>(r.id));
            }
    }
    void round()
    {
        auto const& fold = renderer_.fold();
        for (std::uint32_t ty = 0; ty < fold.y.tiles; ++ty)
            for (std::uint32_t tx = 0; tx < fold.x.tiles; ++tx) check(TileId::at(tx, ty), fold);
    }
    void check(TileId t, homes::Fold const& fold)
    {
        auto const w = window(t);
        auto const in_runs = state<homes::Keys>(t);
        auto const order = state<homes::Order>(t);
        std::vector<splat::SortKey> keys;
        for (auto const i : order) keys.push_back(in_runs[i]);
        auto const held = state<homes::Held<Policies>>(t);
        wrong_.slots += keys.size() != held.size() || in_runs.size() != held.size();
        auto const tile = renderer_.grid().width * t.y() + t.x();
        auto const arrived_so_far = std::as_const(renderer_.mesh()).template state<homes::Counts>(t).arrived;
        auto const arrived = arrived_so_far - std::exchange(arrived_[tile], arrived_so_far); // in this round
        if (w.done()) {
            wrong_.slots += !keys.empty();
            wrong_.uncalled += arrived;
            return;
        }
        homes::Key const lo{w.lo_depth, w.lo_id}, frontier{w.frontier_depth, w.frontier_id};
        for (std::uint32_t b = 0; b < fold.tile_blocks(); ++b) partly_finished += homes::block_at(fold, t, b).exists && (w.finished & fold.bit_of(b)) != 0;
        // Windows follow each other without a gap, from the nearest depth on.
        auto const before = frontiers_.emplace(tile, homes::Key{renderer_.mesh().template broadcast<homes::TableParameters>().chapter_depth, 0}).first;
        wrong_.moved += !same(before->second, lo);
        before->second = frontier;

        std::vector<std::uint32_t> used;
        for (std::uint32_t i = 0; i < keys.size(); ++i) {
            homes::Key const key{keys[i].depth_key, static_cast<std::uint32_t>(keys[i].id)};
            if (i > 0) wrong_.order += !(homes::Key{keys[i - 1].depth_key, static_cast<std::uint32_t>(keys[i - 1].id)} < key);
            wrong_.outside += key < lo || !(key < frontier);
            used.push_back(keys[i].slot);
        }
        std::sort(used.begin(), used.end());
        for (std::uint32_t i = 0; i < used.size(); ++i) wrong_.slots += used[i] != i;

        auto const less = [](Item const& a, homes::Key const& b) { return a.key < b; };
        auto item = std::lower_bound(items_.begin(), items_.end(), lo, less);
        auto const end = std::lower_bound(item, items_.end(), frontier, less);
        auto const unfinished_tiles_block = [&](std::uint32_t i, std::uint32_t j) {
            if (fold.x.tile_of(i) != t.x() || fold.y.tile_of(j) != t.y()) return false;
            std::uint32_t k = 0, l = 0;
            while (fold.x.block(t.x(), k) != i) ++k;
            while (fold.y.block(t.y(), l) != j) ++l;
            return (w.finished & fold.bit_of(l * fold.x.layers + k)) == 0;
        };
        auto const touches = [&](Item const& splat) { // an unfinished block of the tile, with its rectangle
            for (auto y = splat.blocks.y0; y < splat.blocks.y1; ++y)
                for (auto x = splat.blocks.x0; x < splat.blocks.x1; ++x)
                    if (unfinished_tiles_block(x, y)) return true;
            return false;
        };
        // Homes know the two depths of a window, and send nothing from outside them.
        auto const called = std::count_if(std::lower_bound(items_.begin(), items_.end(), homes::Key{w.lo_depth, 0}, less),
                                          std::lower_bound(items_.begin(), items_.end(), homes::Key{w.hi_depth, 0}, less),
                                          [&](Item const& splat) { return resident_.count(splat.key.id) != 0 && touches(splat); });
        wrong_.uncalled += arrived > called ? 1u : 0u;
        std::uint32_t i = 0;
        for (; item != end; ++item) {
            if (resident_.count(item->key.id) == 0) continue;
            bool const is_held = i < keys.size() && keys[i].depth_key == item->key.depth && static_cast<std::uint32_t>(keys[i].id) == item->key.id;
            if (is_held) {
                wrong_.slots += ids_[held[keys[i++].slot].row] != item->key.id;
                wrong_.needless += !touches(*item);
            } else {
                for (auto const& [x, y] : item->shown) wrong_.missing += unfinished_tiles_block(x, y);
            }
        }
        wrong_.outside += static_cast<std::uint32_t>(keys.size()) - i; // unknown splats
    }
    /// A bit is set if and only if each pixel of its blocks has stopped.
    void finished_bits()
    {
        auto const& fold = renderer_.fold();
        for (std::uint32_t ty = 0; ty < fold.y.tiles; ++ty)
            for (std::uint32_t tx = 0; tx < fold.x.tiles; ++tx) {
                auto const t = TileId::at(tx, ty);
                auto const w = window(t);
                auto const blocks = state<homes::BlocksOf<Policies>>(t);
                std::uint32_t going = 0;
                for (std::uint32_t b = 0; b < blocks.size(); ++b)
                    for (auto const& row : blocks[b].transmittance)
                        for (float const v : row)
                            if (v >= transmittance_min_) going |= fold.bit_of(b);
                wrong_.bits += w.finished != ~going;
                wrong_.late += going == 0 && !w.done();
            }
    }

    Homes& renderer_;
    std::vector<Item> items_;
    float transmittance_min_ = 0;
    std::map<std::uint32_t, std::uint32_t> ids_; ///< of the renderer's rows
    std::set<std::uint32_t> resident_;
    std::map<std::uint32_t, homes::Key> frontiers_;
    std::map<std::uint32_t, std::uint32_t> arrived_; ///< parcels that each tile has had in this chapter
    Wrong wrong_{};
};
std::ostream& operator<<(std::ostream& out, Watch::Wrong const& w)
{
    return out << "order " << w.order << ", outside " << w.outside << ", missing " << w.missing << ", needless " << w.needless << ", moved "
               << w.moved << ", slots " << w.slots << ", late " << w.late << ", bits " << w.bits;
}

/// The frame as one list, without tiles, by the kernel's arithmetic.
report::Image one_list(std::vector<splat::Gaussian> const& gaussians, splat::Camera const& camera, splat::Rules const& rules)
{
    support::SortedSplats const scene(gaussians, camera, rules);
    report::Image image(camera.width, camera.height);
    std::vector<splat::FloatPixel> pixels(std::size_t{camera.width} * camera.height);
    auto const at = [&](std::uint32_t i) -> splat::Splat const& { return scene.splats[i]; };
    splat::blend_tile({0, camera.width, 0, camera.height}, camera, rules, static_cast<std::uint32_t>(scene.splats.size()), at, pixels.data(),
                      camera.width, Worker{0, 1});
    std::memcpy(image.rgb.data(), pixels.data(), pixels.size() * sizeof(splat::FloatPixel));
    return image;
}

struct Case {
    std::uint32_t kind = 0, n = 0, homes = 0, held = 1, slots = 1, waiting = 1, threads = 1;
    Extent2 frame{}, grid{};
    bool fold = true;
    splat::Rules rules{};
};
render::Setup choice_of(Case const& c)
{
    auto choice = splat::homes_setup;
    choice.machine.sram_bytes = 1u << 26;
    choice.sizes = splat::homes::homes_sizes(c.homes != 0 ? c.homes : c.n / (c.grid.width * c.grid.height) + 1, std::max(c.held, 1u), 200, 200);
    choice.rules = c.rules;
    return choice;
}
RendererOptions options_of(Case const& c)
{
    return {.threads = c.threads, .grid = c.grid, .channel_slots = c.slots, .waiting_slots = c.waiting, .fold = c.fold};
}
Case random_case(std::uint32_t number, Random& random)
{
    constexpr Extent2 grids[] = {{1, 1}, {1, 7}, {7, 1}, {4, 3}, {5, 4}, {9, 6}, {3, 11}, {12, 2}, {2, 2}, {6, 17}};
    constexpr Extent2 frames[] = {{37, 23}, {90, 53}, {16, 5}, {17, 6}, {1, 1}, {101, 61}, {130, 9}, {33, 95}, {80, 50}, {15, 4}};
    constexpr std::uint32_t helds[] = {1, 2, 3, 7, 20, 64, 100, 300};
    Case c;
    c.kind = number % kind_count;
    c.n = 20 + random.below(support::fast() ? 60 : 180);
    c.held = helds[random.below(8)];
    c.slots = 1 + random.below(20);
    c.waiting = 1 + random.below(5);
    c.threads = 1 + random.below(3);
    c.frame = frames[random.below(10)];
    c.grid = grids[random.below(10)];
    c.fold = random.below(4) != 0;
    if (random.below(4) == 0) c.homes = 1 + random.below(c.n / (c.grid.width * c.grid.height) + 1); // some maps come in chapters
    // Walls that span more than 4 columns or 8 rows of tiles, several on a home: they travel as several parcels.
    if (number == 5) c.frame = {130, 9}, c.grid = {7, 1}, c.homes = 0;
    if (number == 5 + kind_count) c.frame = {33, 95}, c.grid = {1, 11}, c.homes = 0;
    // Tiles of 18 blocks, each held in several rounds.
    if (number % (2 * kind_count) == 8) c.n = 80, c.held = 7, c.frame = {90, 53}, c.grid = {2, 2};
    if (random.below(3) == 0) c.rules.arithmetic = splat::Arithmetic::fast;
    if (random.below(4) == 0) c.rules.transmittance_min = random.below(2) == 0 ? 1e-4f : 0.3f;
    if (random.below(6) == 0) c.rules.alpha_max = 0.99f;
    if (random.below(6) == 0) c.rules.footprint = splat::Footprint::three_sigma_square;
    return c;
}
/// Views that step, jump and come back. A step to the side keeps all depths.
std::vector<splat::Camera> views_of(Case const& c)
{
    auto const base = support::lens(c.frame.width, c.frame.height);
    auto side = base;
    side.position[0] += 0.05f;
    return {base, side, support::lens(c.frame.width, c.frame.height, 0.7f), base};
}
std::string words(Case const& c)
{
    auto const n = [](std::uint32_t v) { return std::to_string(v); };
    return std::string(kinds[c.kind]) + ", " + n(c.n) + " Gaussians, K " + n(c.held) + ", slots " + n(c.slots) + ", FIFO " + n(c.waiting) + ", homes " + n(c.homes) + ", threads " +
           n(c.threads) + ", frame " + n(c.frame.width) + " x " + n(c.frame.height) + ", grid " + n(c.grid.width) + " x " + n(c.grid.height) +
           (c.fold ? ", folded" : "") + (c.rules.arithmetic == splat::Arithmetic::fast ? ", fast" : "");
}
} // namespace

TEST_CASE("homes, random maps and machines: each round holds exactly the splats of its windows, and the picture is the naive loop's")
{
    Random random(21);
    std::uint32_t const cases = support::fast() ? 4 * kind_count : 16 * kind_count;
    std::uint64_t rounds = 0, refused = 0, waits = 0, chapters = 0, partly_finished = 0;
    for (std::uint32_t number = 0; number < cases; ++number) {
        auto const c = random_case(number, random);
        auto const what = words(c);
        CAPTURE(what);
        auto const map = support::map_of(adversarial(c.kind, c.n, c.frame.width, c.frame.height, random));
        Homes renderer(map, choice_of(c), options_of(c));
        Watch watch(renderer);
        for (auto const& view : views_of(c)) {
            watch.begin(items_of(map, view, renderer.rules()), renderer.rules().transmittance_min);
            auto const frame = renderer.render(view);
            CHECK(watch.wrong() == Watch::Wrong{});
            CHECK(support::differing_pixels(frame.image, one_list(map.gaussians, view, renderer.rules())) == 0);
            if (c.rules.arithmetic == splat::Arithmetic::precise)
                CHECK(support::differing_pixels(frame.image, report::render_naive(map.gaussians, view, renderer.rules())) == 0);
            CHECK(frame.report.homes.unfinished_tiles == 0);
            CHECK(frame.report.peak_storage <= c.held);
            CHECK(frame.report.peak_channel <= c.slots);
            chapters += frame.report.homes.chapters;
            rounds += frame.report.homes.rounds;
            refused += frame.report.homes.refused;
            waits += frame.report.refused.by_channels();
        }
        CHECK(renderer.render(views_of(c).back()).report.passes.total() == 0);
        partly_finished += watch.partly_finished;
    }
    // The cases are hard: they need many rounds, tiles are full, links are congested, blocks stop before others of their tile.
    CHECK(chapters > cases);
    CHECK(partly_finished > cases);
    CHECK(rounds > 10 * cases);
    CHECK(refused > 100 * cases);
    CHECK(waits > 100 * cases);
}

TEST_CASE("homes, bounded rounds: each unfinished tile shows exactly the splats in front of its frontier")
{
    Random random(23);
    std::uint32_t unfinished = 0, some_missing = 0;
    for (std::uint32_t number = 0; number < (support::fast() ? kind_count : 4 * kind_count); ++number) {
        auto c = random_case(number, random);
        c.held = 1 + random.below(8);
        c.rules.arithmetic = splat::Arithmetic::precise;
        auto const what = words(c);
        CAPTURE(what);
        auto const map = support::map_of(adversarial(c.kind, c.n, c.frame.width, c.frame.height, random));
        auto o = options_of(c);
        o.rounds = 1 + random.below(4);
        Homes renderer(map, choice_of(c), o);
        for (auto const& view : views_of(c)) {
            auto const frame = renderer.render(view);
            CHECK(frame.report.homes.rounds <= o.rounds); // all chapters share them
            auto const& fold = renderer.fold();
            auto const& mesh = std::as_const(renderer.mesh());
            std::set<std::uint32_t> resident;
            for (std::uint32_t t = 0; t < mesh.grid().size(); ++t)
                for (auto const& r : mesh.template state<homes::Home<Policies>>(mesh.grid().tile(t))) resident.insert(static_cast<std::uint32_t>(r.id));
            // The keys of all records in front of the camera, and the farthest one that has been on a home.
            std::map<std::uint32_t, homes::Key> keys;
            homes::Key farthest{0, 0}, of_map{0, 0};
            for (auto const& g : map.gaussians) {
                homes::Key const key{splat::depth_key(g, splat::make_view(view, renderer.rules())), static_cast<std::uint32_t>(g.id)};
                if (key.depth == 0) continue;
                keys[key.id] = key;
                of_map = std::max(of_map, key);
                if (resident.count(key.id) != 0) farthest = std::max(farthest, key);
            }
            bool const more = farthest < of_map;
            std::uint64_t missing = 0;
            auto const behind = [&](splat::GaussianId id, std::uint32_t x, std::uint32_t y) {
                auto const t = TileId::at(fold.x.tile_of(x / block_width), fold.y.tile_of(y / block_height));
                auto const& w = mesh.template state<homes::Window>(t);
                auto const key = keys.at(static_cast<std::uint32_t>(id));
                bool const is_behind = farthest < key || (!w.done() && !(key < homes::Key{w.lo_depth, w.lo_id}));
                missing += is_behind ? 1 : 0;
                return is_behind;
            };
            CHECK(support::differing_pixels(frame.image, report::render_naive(map.gaussians, view, renderer.rules(), behind)) == 0);
            std::uint32_t tiles = 0, going = 0;
            for (std::uint32_t y = 0; y < fold.y.tiles; ++y)
                for (std::uint32_t x = 0; x < fold.x.tiles; ++x) {
                    auto const& w = mesh.template state<homes::Window>(TileId::at(x, y));
                    tiles += !w.done();
                    going += w.finished != 0xffffffffu;
                }
            if (more) tiles = going;
            CHECK(frame.report.homes.unfinished_tiles == tiles);
            CHECK(frame.report.unfinished.size() == tiles);
            // A tile that is done with the last chapter lacks what is behind the chapter.
            homes::Key next{homes::infinite_depth, 0};
            for (auto const& [id, key] : keys)
                if (farthest < key) next = std::min(next, key);
            for (auto const& u : frame.report.unfinished) {
                auto const& w = mesh.template state<homes::Window>(mesh.grid().tile(u.tile));
                CHECK(u.depth == splat::depth_of_key(w.done() ? next.depth : w.lo_depth));
            }
            unfinished += tiles;
            some_missing += missing != 0;
        }
    }
    CHECK(unfinished > 20);
    CHECK(some_missing > 5);
}

TEST_CASE("homes, capacities around the number of splats: K - 1, K and K + 1 coincident means")
{
    std::uint32_t const k = 20;
    Case c{.held = k, .slots = 5, .waiting = 5, .frame = {40, 20}, .grid = {2, 2}};
    auto const view = support::lens(40, 20);
    auto side = view;
    side.position[0] += 0.05f;
    for (std::uint32_t const n : {0u, 1u, k - 1, k, k + 1, 2 * k, 2 * k + 1}) {
        CAPTURE(n);
        c.n = n;
        std::vector<splat::Gaussian> gaussians;
        for (std::uint32_t i = 0; i < n; ++i) {
            auto g = support::ball(n - i, 0.1f, 0.2f, 0.2f, 0.05f);
            g.mean_world[2] = 2;
            gaussians.push_back(g);
        }
        auto const map = support::map_of(gaussians);
        Homes renderer(map, choice_of(c), options_of(c));
        Watch watch(renderer);
        for (auto const& v : {view, side}) {
            watch.begin(items_of(map, v, renderer.rules()), renderer.rules().transmittance_min);
            auto const frame = renderer.render(v);
            CHECK(watch.wrong() == Watch::Wrong{});
            CHECK(support::differing_pixels(frame.image, report::render_naive(gaussians, v, renderer.rules())) == 0);
            // A cut lies above the depth of its splat. Here all have one depth, so that a cut of the last frame adds the round behind it. A
            // tile that blends at most 0.95 K makes no cut, and a tile that has to refuse splats forgets it.
            bool const has_cut = !same_view(v, view) && n == k;
            std::uint32_t const full = n > k ? (n + k - 1) / k : 1;
            CHECK(frame.report.homes.rounds == full + (has_cut ? 1u : 0u));
        }
    }
}

TEST_CASE("homes: an opaque wall at one depth takes one round, in the next view too")
{
    // After the first frame the cut is above the wall's depth. Were it the depth itself, the next frame would begin with an empty window.
    Case const c{.n = 20, .held = 20, .slots = 5, .waiting = 5, .frame = {40, 20}, .grid = {2, 2}};
    std::vector<splat::Gaussian> gaussians;
    for (std::uint32_t i = 0; i < c.n; ++i) {
        auto g = support::ball(i + 1, 0, 0, 50, 0.9f);
        g.mean_world[2] = 2;
        gaussians.push_back(g);
    }
    Homes renderer(support::map_of(gaussians), choice_of(c), options_of(c));
    auto view = support::lens(40, 20);
    CHECK(renderer.render(view).report.homes.rounds == 1);
    view.position[0] += 0.05f;
    CHECK(renderer.render(view).report.homes.rounds == 1);
}

namespace {
/// n Gaussians with one mean, faint so that no pixel stops, on a few pixels.
void coincident(std::uint32_t n, std::uint32_t held, float opacity, float transmittance_min)
{
    Case c{.n = n, .held = held, .slots = 100, .waiting = 50, .threads = 2, .frame = {60, 40}, .grid = {4, 3}};
    c.rules.transmittance_min = transmittance_min;
    std::vector<splat::Gaussian> gaussians;
    for (std::uint32_t i = 0; i < n; ++i) {
        auto g = support::ball(static_cast<std::uint32_t>(std::uint64_t{i} * 7919 % n) + 1, 0.1f, 0.2f, 0.1f, opacity); // 7919 is prime and does not divide n
        g.mean_world[2] = 2;
        for (float& channel : g.colour) channel = static_cast<float>(i % 97) / 96;
        gaussians.push_back(g);
    }
    auto const map = support::map_of(gaussians);
    Homes renderer(map, choice_of(c), options_of(c));
    auto const view = support::lens(60, 40);
    auto const frame = renderer.render(view);
    CHECK(frame.report.homes.refused > 0);
    CHECK(support::differing_pixels(frame.image, report::render_naive(gaussians, view, renderer.rules())) == 0);
}
} // namespace

TEST_CASE("homes: many coincident means")
{
    coincident(2'000, 100, 0.02f, 1e-6f);
    coincident(2'000, 7, 0.5f, 5e-3f);
}

TEST_CASE("slow: homes: a million coincident means")
{
    coincident(1'000'000, 2'000, 0.5f, 5e-3f);
    coincident(1'000'000, 2'000, 0.01f, 1e-4f);
}
