#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/mapping/detail/parallel.hpp>
#include <tilemesh/mapping/view_sums.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/map/chain.hpp>
#include <tilemesh/splat/map/optimise.hpp>
#include <tilemesh/splat/project_all.hpp>
#include <tilemesh/splat/view.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace mapping {

/// The rules with which maps are refined: alpha_max as trainers have it, and a stop at 1e-4. With a stop at 5e-3, slopes would be off by
/// up to 13 %.
constexpr splat::Rules refining_rules() noexcept
{
    splat::Rules rules;
    rules.alpha_max = 0.99f;
    rules.transmittance_min = 1e-4f;
    return rules;
}

/// How a map is refined.
struct RefineOptions {
    splat::Rules rules = refining_rules(); ///< the arithmetic is `precise`, whatever they say
    ViewOptions view{};
    splat::map::Decays decays{};
};

/// A map that follows pictures: a step renders one view, compares it with its target, and moves each Gaussian that the view shows by its
/// slopes.
///
/// After the same steps, the map has the same bits for any tile of whole blocks, any number of threads, and every compiler that fuses
/// multiply_add alike. `Optimiser` is a policy of splat/map/optimise.hpp; harmonics have `splat::map::HarmonicsStep`. The mean's pull
/// through the direction of its harmonics is left out. A step adds and removes no Gaussian; `add` and `remove_if` do.
///
/// A Gaussian with a degenerate record (`splat::map::chain_rule`) does not move. Throws `Error` as `ViewSums`.
///
/// Memory: the map, 56 + 40 bytes a Gaussian and sizeof(Optimiser::State), besides `ViewSums`.
template <class Optimiser = splat::map::SecondMomentByKind>
class Refiner {
public:
    using State = typename Optimiser::State;

    explicit Refiner(scene::Map map, RefineOptions const& options = {})
        : options_(options), map_(std::move(map)), states_(map_.gaussians.size()),
          harmonics_(map_.sh_degree == 0 ? 0 : map_.gaussians.size()), splats_(map_.gaussians.size()), sums_(options.view)
    {}

    /// Compares a view with its target. `seen`, if it is not null, gets the picture.
    Fit measure(splat::Camera const& camera, Target const& target, Seen* seen = nullptr)
    {
        auto const view = splat::make_view(camera, options_.rules);
        project(view);
        return sums_.measure(splats_, map_.gaussians, view, target, seen);
    }
    /// The picture of a view.
    Seen render(splat::Camera const& camera)
    {
        Seen seen;
        Target const none{camera.width, camera.height, std::vector<splat::TargetPixel>(std::size_t{camera.width} * camera.height)};
        measure(camera, none, &seen);
        return seen;
    }
    /// One step by one view. Returns how well the picture agreed before the step.
    Fit step(splat::Camera const& camera, Target const& target, splat::map::Rates const& rates)
    {
        auto const view = splat::make_view(camera, options_.rules);
        project(view);
        auto const fit = sums_.add_up(splats_, map_.gaussians, view, target);
        in_parts([&](std::size_t i) noexcept {
            auto const& sums = sums_.sums()[i];
            if (sums.empty()) return;
            splat::map::RecordSlopes slopes;
            auto& g = map_.gaussians[i];
            auto const moments = splat::map::moments_of(sums, splats_[i], view.rules.dilation, options_.view.loss.limit);
            if (!splat::map::slopes_of(g, view, moments, slopes)) return;
            bool const clamps_colour = map_.sh_degree == 0;
            if (map_.sh_degree == 1) step_harmonics<1>(i, view, slopes, rates.harmonics);
            if (map_.sh_degree == 2) step_harmonics<2>(i, view, slopes, rates.harmonics);
            if (map_.sh_degree == 3) step_harmonics<3>(i, view, slopes, rates.harmonics);
            Optimiser::step(g, slopes, rates, options_.decays, states_[i], clamps_colour);
        });
        return fit;
    }

    /// Adds Gaussians behind all others, with optimiser states that have seen no step; their harmonics are 0. Their ids must be new: ids
    /// break ties of depth, so with equal ids bits would depend on the order of the records.
    void add(std::span<splat::Gaussian const> more)
    {
        resize(map_.gaussians.size() + more.size()); // first: where memory ends, no Gaussian is without its harmonics
        map_.gaussians.insert(map_.gaussians.end(), more.begin(), more.end());
    }
    /// Removes each Gaussian g for which `goes(g)` is true, with its harmonics and optimiser state. All others keep theirs, their ids and
    /// their order. Returns how many went.
    template <class Goes>
    std::size_t remove_if(Goes const& goes)
    {
        std::size_t const words = harmonics_a_row();
        std::size_t kept = 0;
        for (std::size_t i = 0; i < map_.gaussians.size(); ++i) {
            if (goes(std::as_const(map_.gaussians[i]))) continue;
            if (kept != i) {
                map_.gaussians[kept] = map_.gaussians[i];
                states_[kept] = states_[i];
                if (words != 0) {
                    harmonics_[kept] = harmonics_[i];
                    std::copy_n(map_.harmonics.data() + words * i, words, map_.harmonics.data() + words * kept);
                }
            }
            ++kept;
        }
        auto const gone = map_.gaussians.size() - kept;
        map_.gaussians.resize(kept);
        resize(kept);
        return gone;
    }

    scene::Map const& map() const noexcept { return map_; }
    RefineOptions const& options() const noexcept { return options_; }
    std::vector<State> const& states() const noexcept { return states_; }
    using HarmonicsState = splat::map::HarmonicsStep::State;
    /// The states of the harmonics; none at degree 0.
    std::vector<HarmonicsState> const& harmonics_states() const noexcept { return harmonics_; }

    /// Takes the records, harmonics and states of another refiner with the same options and a map of the same degree; it goes on with the
    /// bits of the other. Throws `Error` if their numbers do not fit, and changes nothing then.
    void restore(std::vector<splat::Gaussian> gaussians, std::vector<float> harmonics, std::vector<State> states,
                 std::vector<HarmonicsState> harmonics_states)
    {
        auto const n = gaussians.size(), shaded = map_.sh_degree == 0 ? 0 : n;
        if (states.size() != n || harmonics_states.size() != shaded || harmonics.size() != shaded * harmonics_a_row())
            throw Error("a refiner cannot take over " + std::to_string(n) + " Gaussians with " + std::to_string(states.size()) +
                        " states of the optimiser and " + std::to_string(harmonics.size()) +
                        " harmonics (each Gaussian has one state, and those of the map's degree); give those of one refiner");
        splats_.resize(n);
        map_.gaussians = std::move(gaussians);
        map_.harmonics = std::move(harmonics);
        states_ = std::move(states);
        harmonics_ = std::move(harmonics_states);
    }

private:
    static constexpr std::size_t part_size = 1024; ///< records that a thread takes at once
    std::size_t parts() const noexcept { return (map_.gaussians.size() + part_size - 1) / part_size; }
    /// Calls f(i) for each Gaussian, on all threads.
    template <class F>
    void in_parts(F const& f)
    {
        detail::in_parallel(options_.view.threads, parts(), [&](std::size_t part) noexcept {
            for (std::size_t i = part * part_size; i < map_.gaussians.size() && i < (part + 1) * part_size; ++i) f(i);
        });
    }

    std::size_t harmonics_a_row() const noexcept { return 3 * std::size_t{splat::harmonics_per_channel(map_.sh_degree)}; }
    void resize(std::size_t n)
    {
        states_.resize(n);
        splats_.resize(n);
        if (map_.sh_degree == 0) return;
        harmonics_.resize(n);
        map_.harmonics.resize(n * harmonics_a_row());
    }

    void project(splat::View const& view)
    {
        auto const tiling = splat::make_tiling(view.camera.width, view.camera.height, options_.view.tile.tile_width,
                                               options_.view.tile.tile_height);
        detail::in_parallel(options_.view.threads, parts(), [&](std::size_t part) noexcept {
            auto const first = part * part_size, n = std::min(part_size, map_.gaussians.size() - first);
            splat::project_all(map_.gaussians.data() + first, static_cast<std::uint32_t>(n), view, tiling, splats_.data() + first);
            switch (map_.sh_degree) {
            case 1: return shade<1>(first, n, view);
            case 2: return shade<2>(first, n, view);
            case 3: return shade<3>(first, n, view);
            default: return;
            }
        });
    }
    template <std::uint32_t Degree>
    void shade(std::size_t first, std::size_t n, splat::View const& view) noexcept
    {
        constexpr std::size_t words = 3 * splat::harmonics_per_channel(Degree);
        for (std::size_t i = first; i < first + n; ++i)
            if (splats_[i].visible() && !splat::shade<Degree>(map_.gaussians[i], map_.harmonics.data() + words * i, view,
                                                              splats_[i])) splats_[i] = {};
    }

    template <std::uint32_t Degree>
    void step_harmonics(std::size_t i, splat::View const& view, splat::map::RecordSlopes const& slopes, float rate) noexcept
    {
        constexpr std::size_t words = 3 * splat::harmonics_per_channel(Degree);
        splat::map::HarmonicsStep::step<Degree>(map_.harmonics.data() + words * i, map_.gaussians[i], view, slopes, rate,
                                                options_.decays, harmonics_[i]);
    }

    RefineOptions options_;
    scene::Map map_;
    std::vector<State> states_;
    std::vector<HarmonicsState> harmonics_;
    std::vector<splat::Splat> splats_;
    ViewSums sums_;
};

}}} // namespace tilemesh::mapping
