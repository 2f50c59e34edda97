// Kernel code as a codelet compiler sees it: every header of machine/ and splat/, and each kernel of both frame
// programs, called on words that another owner holds. kernels.sh compiles this as C++17 and C++20 and checks which symbols the object needs.
#include "kernel_headers.hpp" // every header of machine/ and splat/: CMakeLists.txt writes this file

namespace {
using namespace tilemesh;

/// A tile's memory: its states as one piece, and the eight ends of each channel.
struct Sram {
    std::uint32_t* states;
    std::uint32_t* links[5];
    void const* frame;
    Here here;
    Worker worker;
};

template <class Program, class Setup>
struct Source {
    using Layout = Tile<typename Setup::Machine, Program, Setup>;
    Sram const& sram;

    template <class X>
    machine::Place state() const noexcept
    {
        auto* const words = sram.states + Layout::template offset<X>();
        if constexpr (is_list<X>)
            return {words, words + X::head_words, capacity_of<X>(Setup::sizes)};
        else
            return {nullptr, words, 1};
    }
    template <class C>
    machine::Place end(std::uint32_t number) const noexcept
    {
        constexpr auto slots = capacity_of<C>(Setup::sizes);
        auto* const words = sram.links[machine::index_in<C>(typename Layout::Links{})] + number * C::Receiver::words(slots);
        return {words, words + C::Receiver::head_words, slots};
    }
    template <class C>
    machine::Place in(Direction d) const noexcept
    {
        return end<C>(index(d));
    }
    template <class C>
    machine::Place out(Direction d) const noexcept
    {
        return end<C>(4 + index(d));
    }
    template <class P>
    P const* shared() const noexcept
    {
        return static_cast<P const*>(sram.frame);
    }
    Here here() const noexcept { return sram.here; }
    Worker worker() const noexcept { return sram.worker; }
};

template <class Program, class Setup, class Kernel>
std::uint32_t run(Sram const& sram) noexcept
{
    Source<Program, Setup> source{sram};
    return static_cast<std::uint32_t>(run_kernel<Kernel>(source));
}

/// The policies that no preset has together: back-pressure with recomputed anchors, projected copies and 8-bit pixels, in one channel memory.
struct Screen : splat::Lossless {
    using Copies = splat::ScreenCopies;
    using Addressing = splat::Recomputed;
    using Pixel = splat::Rgbx8Pixel;
    static constexpr splat::Sizes sizes{2000, 200, 200, 200, 32 * 20, true, /*one_channel_memory*/ true};
};
using Shaded = splat::Fitted<splat::Lossless, 3>;
using Still = splat::Fitted<splat::Lossless, 0, false>;
using Alone = splat::Fitted<splat::Lossless, 1, false, false>;
struct Bent : splat::Lossless { // through any lens
    using Parameters = splat::LensParameters;
};
using Planes = splat::WithPixel<splat::Lossless, splat::WithAlpha<splat::WithDepth<splat::FloatPixel>>>;

/// The program of homes on the paper's grid at 1280 x 720: splats held, in a channel end, no beam, in a FIFO; pixels; then homes, blocks and
/// the table of districts.
struct Homes {
    using Machine = Mk2;
    using Values = splat::homes::ValuePolicies<>;
    static constexpr splat::Sizes sizes{2000, 120, 0, 120, 640, true, false, 900, 8, 40, 1440};
};
struct DistrictHomes : Homes { // a table of 10 x 9 districts
    using Values = splat::homes::DistrictPolicies<2>;
    static constexpr splat::Sizes sizes{2000, 120, 0, 120, 640, true, false, 900, 8, 10, 90};
};
struct BentHomes : Homes {
    using Values = splat::homes::LensPolicies<>;
};
struct ShadedHomes : Homes { // degree 2, with planes
    using Values = splat::homes::ValuePolicies<2, splat::WithAlpha<splat::WithDepth<splat::FloatPixel>>>;
    static constexpr splat::Sizes sizes{1500, 120, 0, 120, 640, true, false, 300, 8, 40, 1440};
};
} // namespace

#define EXPORT(name, Program, Setup, ...)                                                                                          \
    extern "C" std::uint32_t name(Sram const& s) noexcept                                                                         \
    {                                                                                                                             \
        return run<Program, Setup, __VA_ARGS__>(s);                                                                               \
    }
#define KERNEL(prefix, kernel, Setup, Kernel) EXPORT(prefix##_##kernel, splat::Frame<Setup>, Setup, splat::Kernel<Setup>)
#define HOMES_KERNEL(prefix, kernel, Setup, Kernel) \
    EXPORT(prefix##_##kernel, splat::homes::Frame<Setup::Values>, Setup, splat::homes::Kernel<Setup::Values>)
#define ALL_HOMES_KERNELS(prefix, Setup)                                                                                          \
    HOMES_KERNEL(prefix, project, Setup, Project)                                                                                 \
    HOMES_KERNEL(prefix, begin, Setup, Begin)                                                                                     \
    HOMES_KERNEL(prefix, tell, Setup, Tell)                                                                                       \
    HOMES_KERNEL(prefix, offer, Setup, Offer)                                                                                     \
    HOMES_KERNEL(prefix, deliver, Setup, Deliver)                                                                                 \
    HOMES_KERNEL(prefix, sort_runs, Setup, SortRuns)                                                                              \
    HOMES_KERNEL(prefix, merge, Setup, Merge)                                                                                     \
    HOMES_KERNEL(prefix, blend, Setup, Blend)                                                                                     \
    HOMES_KERNEL(prefix, advance, Setup, Advance)                                                                                 \
    HOMES_KERNEL(prefix, finish, Setup, Finish)
#define ALL_KERNELS(prefix, Setup)                                                                                               \
    KERNEL(prefix, project, Setup, Project)                                                                                      \
    KERNEL(prefix, route, Setup, Route)                                                                                          \
    KERNEL(prefix, bloom, Setup, Bloom)                                                                                          \
    KERNEL(prefix, depth_sort, Setup, DepthSort)                                                                                 \
    KERNEL(prefix, composite, Setup, Composite)

ALL_KERNELS(lossless, splat::Lossless)
ALL_KERNELS(paper, splat::Paper)
ALL_KERNELS(prototype, splat::Prototype)
ALL_KERNELS(screen, Screen)
ALL_KERNELS(planes, Planes)
ALL_KERNELS(shaded, Shaded)
KERNEL(bent, project, Bent, Project)
KERNEL(bent, route, Bent, Route)
ALL_HOMES_KERNELS(homes, Homes)
ALL_HOMES_KERNELS(shaded_homes, ShadedHomes)
HOMES_KERNEL(bent_homes, project, BentHomes, Project)
HOMES_KERNEL(district_homes, tell, DistrictHomes, Tell)
HOMES_KERNEL(district_homes, offer, DistrictHomes, Offer)
HOMES_KERNEL(district_homes, deliver, DistrictHomes, Deliver)

// The kernels of a program that tracks.
using Tracked = splat::pose::Tracked<splat::Lossless>;
#define POSE_KERNEL(kernel, Kernel) EXPORT(tracked_##kernel, splat::pose::PoseFrame<Tracked>, Tracked, Kernel)
POSE_KERNEL(project, splat::Project<Tracked>)
POSE_KERNEL(route, splat::Route<Tracked>)
POSE_KERNEL(bloom, splat::Bloom<Tracked>)
POSE_KERNEL(composite_with_pose, splat::pose::CompositeWithPose<Tracked>)
POSE_KERNEL(send_cells, splat::pose::SendCells<Tracked>)
POSE_KERNEL(add_gradients, splat::pose::AddGradients<Tracked>)

// What a program that improves the map is made of: both walks of a worker, and the step of a Gaussian.
extern "C" void map_walk(splat::map::WalkMemory<2, 16>& memory, splat::PixelRect const& tile, splat::Camera const& camera, splat::map::WalkRules const& rules,
                         splat::Splat const* splats, std::uint32_t n, splat::TargetPixel const* target, splat::map::SplatSums* to, Worker worker) noexcept
{
    auto const at = [=](std::uint32_t i) noexcept -> splat::Splat const& { return splats[i]; };
    auto const seen = [](auto const&, splat::map::BlockLoss const& loss) noexcept { return loss.pixels != 0; };
    auto const add = [=](std::uint32_t i, splat::map::SplatSums const& s) noexcept { to[i] += s; };
    splat::map::walk_tile(memory, tile, camera, rules, n, at, target, tile.x1 - tile.x0, worker, seen, add);
}
template <class Optimiser>
void map_step(splat::Gaussian& g, splat::View const& view, splat::Splat const& s, splat::map::SplatSums const& sums, splat::map::Rates const& rates,
              typename Optimiser::State& state) noexcept
{
    splat::map::Slopes<splat::detail::OneFloat> slopes;
    if (splat::map::slopes_of(g, view, splat::map::moments_of(sums, s, view.rules.dilation, 4.0f), slopes))
        Optimiser::step(g, slopes, splat::map::faded(rates, 0.5f), splat::map::Decays{}, state);
}
template void map_step<splat::map::Adam>(splat::Gaussian&, splat::View const&, splat::Splat const&, splat::map::SplatSums const&, splat::map::Rates const&,
                                         splat::map::Adam::State&) noexcept;
template void map_step<splat::map::SecondMomentByKind>(splat::Gaussian&, splat::View const&, splat::Splat const&, splat::map::SplatSums const&,
                                                       splat::map::Rates const&, splat::map::SecondMomentByKind::State&) noexcept;

// The program that improves a map.
namespace {
struct Mapping {
    using Machine = Mk2;
    static constexpr splat::map::MapSizes sizes = splat::map::sizes_on<splat::map::SecondMomentByKind>(size_of_machine<Mk2>(), {32, 20}, 300, 100);
};
} // namespace
#define MAP_KERNEL(kernel, Kernel) EXPORT(mapping_##kernel, splat::map::MapStep<splat::map::SecondMomentByKind>, Mapping, splat::map::Kernel)
MAP_KERNEL(begin_view, BeginView)
MAP_KERNEL(project_records, ProjectRecords)
MAP_KERNEL(cast, Cast)
MAP_KERNEL(sort_entries, SortEntries)
MAP_KERNEL(walk, Walk)
MAP_KERNEL(add_up, AddUp)
MAP_KERNEL(give_back, Return)
MAP_KERNEL(take_step, TakeStep<splat::map::SecondMomentByKind>)
MAP_KERNEL(begin_rest, BeginRest)
MAP_KERNEL(find_goals, FindGoals)
MAP_KERNEL(start_rest, StartRest)
MAP_KERNEL(offer_room, OfferRoom<splat::map::SecondMomentByKind>)
MAP_KERNEL(move_records, MoveRecords<splat::map::SecondMomentByKind>)
// The program that grows the map.
namespace {
struct Growing {
    using Machine = Mk2;
    static constexpr splat::map::MapSizes sizes =
        splat::map::sizes_on<splat::map::SecondMomentByKind, splat::map::GrowStep>(size_of_machine<Mk2>(), {32, 20}, 300, 100, 2);
};
} // namespace
#define GROW_KERNEL(kernel, Kernel) EXPORT(growing_##kernel, splat::map::GrowStep<splat::map::SecondMomentByKind>, Growing, splat::map::Kernel)
GROW_KERNEL(begin_cells, BeginCells)
GROW_KERNEL(look, Look)
GROW_KERNEL(pass_cells, PassCells)
GROW_KERNEL(insert_cells, InsertCells<splat::map::SecondMomentByKind>)
GROW_KERNEL(remove_faded, RemoveFaded<splat::map::SecondMomentByKind>)
// With harmonics.
namespace {
using ShadedOptimiser = splat::map::Shaded<splat::map::SecondMomentByKind, 3>;
struct ShadedMapping {
    using Machine = Mk2;
    static constexpr splat::map::MapSizes sizes = splat::map::sizes_on<ShadedOptimiser>(size_of_machine<Mk2>(), {32, 20}, 300, 100);
};
} // namespace
EXPORT(shaded_project_records, splat::map::MapStep<ShadedOptimiser>, ShadedMapping, splat::map::ProjectShaded<ShadedOptimiser>)
EXPORT(shaded_take_step, splat::map::MapStep<ShadedOptimiser>, ShadedMapping, splat::map::TakeStep<ShadedOptimiser>)
// What these are made of: the cell of a keyframe, and what goes.
extern "C" bool map_insert(splat::map::CellSums& sums, splat::TargetPixel const& target, splat::map::ShownPixel const& shown, splat::Camera const& camera,
                           splat::map::CellGrid const& grid, std::uint32_t cell, splat::Gaussian& to) noexcept
{
    sums.add(target, shown);
    splat::map::InsertRules const rules{};
    if (!sums.wants_gaussian(rules)) return false;
    to = splat::map::gaussian_of_cell(sums, camera, grid, cell % grid.columns, cell / grid.columns, 1, rules);
    return !splat::map::is_removed(to, splat::map::RemoveRules{}, 1.0f);
}

// The kernels of a setup without routing (Still), and of one without routing and bloom (Alone).
KERNEL(still, project, Still, Project)
KERNEL(still, bloom, Still, Bloom)
KERNEL(still, composite, Still, Composite)
KERNEL(alone, project, Alone, Project)
KERNEL(alone, depth_sort, Alone, DepthSort)
KERNEL(alone, composite, Alone, Composite)
