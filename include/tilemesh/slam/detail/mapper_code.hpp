#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/mapping/refiner.hpp>
#include <tilemesh/slam/mapper.hpp>
#include <tilemesh/slam/state_bytes.hpp>
#include <tilemesh/splat/map/insert.hpp>
#include <tilemesh/splat/map/loss.hpp>
#include <tilemesh/splat/map/optimise.hpp>
#include <tilemesh/track/spoil.hpp>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace slam {

TILEMESH_HOST char const* name_of(Optimiser optimiser) noexcept
{
    return optimiser == Optimiser::adam ? "adam" : "by-kind";
}

TILEMESH_HOST std::size_t keyframe_of_step(std::size_t newest, std::uint32_t step, std::uint32_t window, std::uint64_t seed) noexcept
{
    if (step % 2 == 0) return newest;
    auto const all = newest + 1, of = step % 4 == 1 ? std::min<std::size_t>(all, window) : all;
    auto const share = track::random_bits(seed, newest, step, 0) >> 32; // of 2^32
    return newest - static_cast<std::size_t>(share * of >> 32);
}

TILEMESH_HOST std::size_t keyframe_of_round(std::size_t count, std::uint32_t step, std::uint64_t seed)
{
    // The round's order: by random keys, with the round's number in the place of a frame's.
    auto const round = step / count, place = step % count;
    std::vector<std::pair<std::uint64_t, std::size_t>> order(count);
    for (std::size_t k = 0; k < count; ++k) order[k] = {track::random_bits(seed, round, k, 1), k};
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(place), order.end());
    return order[place].second;
}

/// The map in a refiner of one of the optimisers, and the keyframes.
struct Mapper::Work {
    using ByAdam = mapping::Refiner<splat::map::Adam>;
    using ByKind = mapping::Refiner<splat::map::SecondMomentByKind>;
    using View = KeyframeView;

    MapperOptions options;
    float scene_depth;
    std::variant<ByAdam, ByKind> refiner;
    std::vector<View> keyframes;

    Work(scene::Map map, float depth, MapperOptions const& o) : options(o), scene_depth(depth), refiner(refiner_of(std::move(map), o)) {}

    template <class F>
    auto with_refiner(F const& f) { return std::visit(f, refiner); }
    static std::variant<ByAdam, ByKind> refiner_of(scene::Map map, MapperOptions const& o)
    {
        mapping::RefineOptions how;
        how.view.tile = o.tile;
        how.view.threads = o.threads;
        how.view.loss.depth = o.depth_weight;
        how.rules.coverage = o.coverage;
        if (o.optimiser == Optimiser::adam) return ByAdam(std::move(map), how);
        return ByKind(std::move(map), how);
    }
    std::vector<splat::Gaussian> missing_in(View const& view, std::uint32_t keyframe);
};

/// The Gaussians that a keyframe inserts, in the order of its cells.
inline std::vector<splat::Gaussian> Mapper::Work::missing_in(View const& view, std::uint32_t keyframe)
{
    namespace map = splat::map;
    scene::check_no_panorama(view.camera, "an insertion");
    scene::check_no_shutter(view.camera, "an insertion");
    mapping::Seen seen;
    with_refiner([&](auto& r) { r.measure(view.camera, view.target, &seen); }); // refuses a target of another size
    auto c = view.camera;
    splat::bound_lens(c);
    auto const grid = map::CellGrid::of(c.width, c.height, options.insert.cell);
    std::vector<splat::Gaussian> out;
    for (std::uint32_t row = 0; row < grid.rows; ++row)
        for (std::uint32_t column = 0; column < grid.columns; ++column) {
            map::CellSums sums;
            for (std::uint32_t y = row * grid.cell; y < c.height && y < (row + 1) * grid.cell; ++y)
                for (std::uint32_t x = column * grid.cell; x < c.width && x < (column + 1) * grid.cell; ++x) {
                    float const* const rgb = seen.colour.pixel(x, y);
                    sums.add(view.target.pixels[std::size_t{y} * c.width + x],
                             {{rgb[0], rgb[1], rgb[2]}, seen.depth.at(x, y), seen.cover.at(x, y)});
                }
            if (sums.wants_gaussian(options.insert))
                out.push_back(map::gaussian_of_cell(sums, c, grid, column, row, keyframe, options.insert));
        }
    return out;
}

TILEMESH_HOST Mapper::Mapper(scene::Map map, float scene_depth, MapperOptions const& options)
{
    auto const positive = [](float v) { return v > 0 && v <= 1e18f; };
    if (!positive(scene_depth) || !positive(options.rate))
        throw Error("a map cannot grow with a scene depth of " + std::to_string(scene_depth) + " and a rate of " +
                    std::to_string(options.rate) + " (both must be above 0); give the median depth of the first picture, and a rate of 2");
    if (options.window == 0 || options.insert.cell == 0)
        throw Error("a map cannot grow with a window of " + std::to_string(options.window) + " keyframes and cells of " +
                    std::to_string(options.insert.cell) + " pixels (both must be 1 or more); change them");
    for (auto const& g : map.gaussians)
        if (static_cast<std::uint32_t>(g.id) > splat::map::most_cells)
            throw Error("a map with the id " + std::to_string(static_cast<std::uint32_t>(g.id)) + " cannot grow (ids above " +
                        std::to_string(splat::map::most_cells) +
                        " are those of keyframes); number its Gaussians from 1, or take a smaller map");
    work_ = std::make_unique<Work>(std::move(map), scene_depth, options);
}
TILEMESH_HOST Mapper::~Mapper() = default;
TILEMESH_HOST Mapper::Mapper(Mapper&&) noexcept = default;
TILEMESH_HOST Mapper& Mapper::operator=(Mapper&&) noexcept = default;

TILEMESH_HOST Keyframe Mapper::add(splat::Camera const& camera, mapping::Target target)
{
    auto& w = *work_;
    auto const& o = w.options;
    auto const grid = splat::map::CellGrid::of(camera.width, camera.height, o.insert.cell);
    if (std::uint64_t{grid.columns} * grid.rows > splat::map::most_cells)
        throw Error("a keyframe of " + std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                    " pixels has too many cells (at most " + std::to_string(splat::map::most_cells) +
                    " have ids); take smaller pictures or larger cells");
    if (w.keyframes.size() >= splat::map::most_keyframes)
        throw Error("there cannot be more keyframes than " + std::to_string(splat::map::most_keyframes) +
                    " (the others have no ids); save the map, and start again from it");
    Work::View view{camera, std::move(target)};
    auto const more = w.missing_in(view, static_cast<std::uint32_t>(w.keyframes.size() + 1));
    w.keyframes.push_back(std::move(view));
    auto const newest = w.keyframes.size() - 1;

    Keyframe out;
    out.inserted = more.size();
    auto const steps = newest == 0 ? o.first_steps : o.steps;
    auto const rates = splat::map::usual_rates(w.scene_depth) * o.rate;
    w.with_refiner([&](auto& refiner) {
        refiner.add(more);
        for (; out.steps < steps && !out.stopped; out.stopped = out.steps < steps && o.stop && o.stop()) {
            auto const& by = w.keyframes[keyframe_of_step(newest, out.steps, o.window, o.seed)];
            refiner.step(by.camera, by.target, splat::map::faded(rates, static_cast<float>(out.steps) / static_cast<float>(steps)));
            ++out.steps;
        }
        out.removed = refiner.remove_if([&](splat::Gaussian const& g) { return splat::map::is_removed(g, o.remove, w.scene_depth); });
        out.gaussians = refiner.map().gaussians.size();
        out.psnr_db = refiner.measure(w.keyframes[newest].camera, w.keyframes[newest].target).psnr_db();
    });
    return out;
}

TILEMESH_HOST std::uint32_t Mapper::refine(std::uint32_t steps)
{
    auto& w = *work_;
    if (w.keyframes.empty()) return 0;
    std::uint32_t taken = 0;
    auto const rates = splat::map::usual_rates(w.scene_depth) * w.options.rate;
    w.with_refiner([&](auto& refiner) {
        for (; taken < steps && !(w.options.stop && w.options.stop()); ++taken) {
            auto const& by = w.keyframes[keyframe_of_round(w.keyframes.size(), taken, w.options.seed)];
            refiner.step(by.camera, by.target, splat::map::faded(rates, static_cast<float>(taken) / static_cast<float>(steps)));
        }
    });
    return taken;
}
TILEMESH_HOST double Mapper::open_share(splat::Camera const& camera, mapping::Target const& target)
{
    mapping::Seen seen;
    work_->with_refiner([&](auto& r) { r.measure(camera, target, &seen); });
    std::size_t open = 0;
    for (std::size_t i = 0; i < target.pixels.size(); ++i) {
        float const depth = target.pixels[i].depth;
        open += depth > 0 && depth < 1e18f && seen.cover.values[i] <= splat::map::least_covered;
    }
    return static_cast<double>(open) / static_cast<double>(target.pixels.size());
}
TILEMESH_HOST mapping::Fit Mapper::measure(splat::Camera const& camera, mapping::Target const& target)
{
    return work_->with_refiner([&](auto& r) { return r.measure(camera, target); });
}
TILEMESH_HOST mapping::Seen Mapper::render(splat::Camera const& camera)
{
    return work_->with_refiner([&](auto& r) { return r.render(camera); });
}

TILEMESH_HOST std::string Mapper::save() const
{
    StateWriter out;
    out.put(work_->options.optimiser);
    out.put(map().sh_degree);
    out.put(std::uint64_t{keyframes()});
    out.put_all(map().gaussians);
    out.put_all(map().harmonics);
    std::visit(
        [&](auto const& refiner) {
            out.put_all(refiner.states());
            out.put_all(refiner.harmonics_states());
        },
        work_->refiner);
    return out.take();
}
TILEMESH_HOST void Mapper::load(std::string_view state, std::vector<KeyframeView> keyframes)
{
    StateReader in(state);
    if (in.get<Optimiser>() != work_->options.optimiser || in.get<std::uint32_t>() != map().sh_degree ||
        in.get<std::uint64_t>() != keyframes.size()) StateReader::fail();
    auto gaussians = in.all<splat::Gaussian>();
    auto harmonics = in.all<float>();
    work_->with_refiner([&](auto& refiner) {
        using Refiner = std::decay_t<decltype(refiner)>;
        auto states = in.all<typename Refiner::State>();
        auto harmonics_states = in.all<typename Refiner::HarmonicsState>();
        in.finish();
        refiner.restore(std::move(gaussians), std::move(harmonics), std::move(states), std::move(harmonics_states));
    });
    work_->keyframes = std::move(keyframes);
}

TILEMESH_HOST scene::Map const& Mapper::map() const noexcept
{
    auto const* const adam = std::get_if<Work::ByAdam>(&work_->refiner);
    return adam != nullptr ? adam->map() : std::get_if<Work::ByKind>(&work_->refiner)->map();
}
TILEMESH_HOST std::size_t Mapper::keyframes() const noexcept
{
    return work_->keyframes.size();
}
TILEMESH_HOST MapperOptions const& Mapper::options() const noexcept
{
    return work_->options;
}

}}} // namespace tilemesh::slam
