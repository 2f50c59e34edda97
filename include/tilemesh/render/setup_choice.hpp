#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup_facts.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// A setup that is put together at run time from the library's policies. It gives the facts and the exact ledger of the setup; no template
/// is instantiated for each combination.
struct SetupChoice {
    char const* name = "";
    MachineSize machine{};
    splat::Sizes sizes{};
    bool holds = true;              ///< true: `Hold`; false: `Drop`
    bool carried = true;            ///< true: `Carried`; false: `Recomputed`
    bool reusable = true;           ///< true: `WorldCopies`; false: `ScreenCopies`
    bool routes = true, blooms = true;
    std::uint32_t sh_degree = 0;    ///< of a record, 0 to 3
    ColourFormat colour = ColourFormat::float32;
    bool depth = false, alpha = false;
    splat::Rules rules{};           ///< rules of the picture
    bool ranks = false;             ///< true: `LargestFirst` of the above
};
/// A setup of the library's policies, as a choice that the caller may change.
template <class S>
constexpr SetupChoice choice_of() noexcept
{
    using Colour = splat::ColourOf<typename S::Pixel>;
    static_assert(splat::is_known_colour<typename S::Pixel>, "a setup with pixels of its own (a choice knows FloatPixel and Rgbx8Pixel); "
                                                             "ask facts_of<S>()");
    return {S::name,
            size_of_machine<typename S::Machine>(),
            S::sizes,
            S::Saturation::holds,
            S::Addressing::carried,
            S::Copies::reusable,
            S::routes,
            S::blooms,
            S::Record::sh_degree,
            std::is_same_v<Colour, splat::FloatPixel> ? ColourFormat::float32 : ColourFormat::rgbx8,
            S::Pixel::has_depth,
            S::Pixel::has_alpha,
            rules_of<S>(),
            splat::may_rank<typename S::Saturation>};
}

constexpr std::uint32_t record_bytes(std::uint32_t sh_degree) noexcept
{
    return static_cast<std::uint32_t>(sizeof(splat::Gaussian)) + 12 * splat::harmonics_per_channel(sh_degree);
}
static_assert(record_bytes(1) == sizeof(splat::ShadedGaussian<1>) && record_bytes(3) == sizeof(splat::ShadedGaussian<3>));

constexpr splat::FrameWords words_of(SetupChoice const& c) noexcept
{
    auto const record = record_bytes(c.sh_degree);
    auto const mark = static_cast<std::uint32_t>(c.routes || c.blooms ? sizeof(splat::Mark) : sizeof(splat::AnchorMark));
    return {record, record + (c.carried ? static_cast<std::uint32_t>(sizeof(TileId)) : 0u),
            c.reusable ? record : static_cast<std::uint32_t>(sizeof(splat::ScreenCopy)),
            (c.colour == ColourFormat::rgbx8 ? 4u : 12u) + (c.depth ? 4u : 0u) + (c.alpha ? 4u : 0u),
            splat::slot_list_bytes(c.sizes.lists_fit, mark)};
}

/// The ledger of a choice: the lines of `Tile<Machine, Frame<S>, S>::ledger()` for the equivalent setup S, and their sum.
struct ChoiceLedger {
    std::vector<machine::Region> lines;
    std::uint64_t bytes = 0; ///< sum of the lines that count against the SRAM

    explicit ChoiceLedger(SetupChoice const& c)
    {
        using Names = splat::PoliciesOf<splat::Lossless>;
        auto const words = words_of(c);
        auto const list = [](std::uint64_t slots, std::uint64_t slot_bytes) { return 8 + slots * slot_bytes; };
        // If `limit` gives the slots of a channel, only the channel's heads count.
        auto const channel = [&](std::uint32_t slots, std::uint32_t message) { return 8 * list(slots == dynamic_capacity ? 0 : slots, message); };
        auto const road = channel(c.sizes.road, words.road_message), beam = channel(c.sizes.beam, words.beam_message);
        bool const shared = c.sizes.one_channel_memory && c.routes && c.blooms;
        if (c.routes) add(splat::Road<Names>::name, "channel, 8 ends", road);
        if (c.blooms) add(splat::Beam<Names>::name, "channel, 8 ends", shared ? (beam > road ? beam - road : 0) : beam);
        bool const fit = c.sizes.lists_fit;
        auto const mark = c.routes || c.blooms ? sizeof(splat::Mark) : sizeof(splat::AnchorMark);
        add(splat::Storage<Names>::name, "state", list(c.sizes.storage, words.record));
        add(splat::Marks<Names>::name, "state", list(c.sizes.storage, mark), fit);
        add(splat::Splats<Names>::name, "state", list(c.sizes.storage, sizeof(splat::Splat)), fit);
        if (c.routes) add(splat::FlowControl::name, "state", sizeof(splat::FlowControl));
        if (c.blooms) add(splat::OwedCopies::name, "state", sizeof(splat::OwedCopies));
        add(splat::Counts::name, "state", sizeof(splat::Counts));
        if (c.routes && c.holds) {
            add(splat::Waiting<Names, 0>::name, "state", list(c.sizes.waiting, words.road_message));
            add(splat::Waiting<Names, 1>::name, "state", list(c.sizes.waiting, words.road_message));
        }
        add(splat::Order<Names>::name, "state", list(c.sizes.storage, sizeof(splat::SortKey)), fit);
        add(splat::Framebuffer<Names>::name, "state", list(c.sizes.tile_pixels, words.pixel));
        add(splat::Work::name, "state", sizeof(splat::Work));
        add(splat::FrameParameters::name, "broadcast", sizeof(splat::FrameParameters));
        add("code and stacks", "reserve", c.machine.code_bytes);
    }

private:
    void add(char const* name, char const* what, std::uint64_t region_bytes, bool budgeted = true)
    {
        auto const line = region_bytes < 0xffffffffu ? static_cast<std::uint32_t>(region_bytes) : 0xffffffffu;
        lines.push_back({as_name(name), what, line, budgeted});
        bytes += budgeted ? region_bytes : 0;
    }
};
inline std::vector<machine::Region> ledger_of(SetupChoice const& c)
{
    return ChoiceLedger(c).lines;
}
inline std::uint64_t sram_bytes_of(SetupChoice const& c)
{
    return ChoiceLedger(c).bytes;
}

/// The facts of a choice. Throws Error if it does not fit into its machine's SRAM, if it holds without FIFOs, or if `Work` has no counters
/// for the machine's number of workers (`Work::max_workers`).
inline SetupFacts facts_of(SetupChoice const& c)
{
    check_workers(c.machine, splat::Work::max_workers);
    auto const words = words_of(c);
    ChoiceLedger ledger(c);
    SetupFacts f{c.name,
                 c.machine,
                 c.sizes,
                 {c.holds ? 1u : 0u, c.carried ? 1u : 0u, c.reusable ? 1u : 0u, words.road_message, words.beam_message,
                  c.ranks && (c.routes || c.blooms) ? 1u : 0u},
                 c.sh_degree,
                 words.record,
                 c.colour,
                 c.depth,
                 c.alpha,
                 c.routes,
                 c.blooms,
                 c.rules,
                 ledger.bytes,
                 std::move(ledger.lines)};
    if (f.sram_bytes > c.machine.sram_bytes) throw does_not_fit(c.machine, f.ledger, f.sram_bytes);
    if (c.routes && c.holds && c.sizes.waiting == 0) throw Error(detail::needs_fifos);
    return f;
}

namespace detail {
/// Are all types of a setup the library's own? Then its facts are those of a choice, and need no code for this setup.
template <class S>
inline constexpr bool is_of_the_library =
    splat::is_known_colour<typename S::Pixel> && std::is_same_v<typename S::Parameters, splat::FrameParameters> &&
    std::is_same_v<typename S::Projected, splat::Splat> &&
    std::is_same_v<typename S::Record, splat::GaussianOfDegree<S::Record::sh_degree>> &&
    (std::is_same_v<typename S::Saturation, splat::Hold> || std::is_same_v<typename S::Saturation, splat::Drop> ||
     std::is_same_v<typename S::Saturation, splat::LargestFirst<splat::Hold>> ||
     std::is_same_v<typename S::Saturation, splat::LargestFirst<splat::Drop>>) &&
    (std::is_same_v<typename S::Addressing, splat::Carried> || std::is_same_v<typename S::Addressing, splat::Recomputed>) &&
    (std::is_same_v<typename S::Copies, splat::WorldCopies> || std::is_same_v<typename S::Copies, splat::ScreenCopies>);
template <class S>
SetupFacts facts_at(splat::Sizes const& sizes)
{
    if constexpr (is_of_the_library<S>) {
        auto choice = choice_of<S>();
        choice.sizes = sizes;
        return facts_of(choice);
    } else {
        return facts_with<S>(sizes);
    }
}
} // namespace detail

/// The facts of a setup with its own sizes. A setup that does not fit into its machine's SRAM does not compile.
template <class S>
SetupFacts facts_of()
{
    static_assert(Tile<typename S::Machine, splat::Frame<S>, S>::bytes <= S::Machine::sram_bytes);
    static_assert(!S::routes || !S::Saturation::holds || S::sizes.waiting >= 1,
                  "a setup that holds needs FIFOs (without one no credit is ever given and nothing moves); give Sizes::waiting "
                  "room for at least one message");
    static_assert(S::Machine::workers >= 1 && S::Machine::workers <= splat::Work::max_workers,
                  "a machine with more workers than Work counts for; raise Work::max_workers");
    return detail::facts_at<S>(S::sizes);
}
/// The facts of a setup with other sizes. Throws Error if the sizes do not fit.
template <class S>
SetupFacts facts_of(splat::Sizes const& sizes)
{
    if (S::routes && S::Saturation::holds && sizes.waiting == 0) throw Error(detail::needs_fifos);
    if constexpr (!detail::is_of_the_library<S>) require_fit<splat::Frame<S>>(size_of_machine<typename S::Machine>(), sizes);
    return detail::facts_at<S>(sizes);
}
/// The facts of a setup. If the options name sizes, the facts have these sizes.
template <class S>
SetupFacts facts_of(RendererOptions const& options)
{
    return options.sizes ? facts_of<S>(*options.sizes) : facts_of<S>();
}

/// Reduces the choice to what a scene needs, in the same bytes of SRAM (`splat::Fitted`): records of another degree, and no routing or
/// bloom if these would have nothing to do. A choice with `one_channel_memory` keeps both routing and bloom: to leave out one of them would
/// free memory that the other one needs.
constexpr SetupChoice fitted(SetupChoice c, std::uint32_t degree, bool routes, bool blooms) noexcept
{
    auto const before = words_of(c);
    std::uint64_t const freed = (c.routes && !routes ? splat::routing_bytes(c.sizes, before, c.holds) : 0) +
                                (c.blooms && !blooms ? splat::bloom_bytes(c.sizes, before) : 0);
    c.sh_degree = degree;
    c.routes = routes;
    c.blooms = blooms;
    c.sizes = splat::refitted(c.sizes, before, words_of(c), freed);
    return c;
}
/// Returns the choice with planes in addition to the colours. If the SRAM has no room for them, storage gives up slots.
inline SetupChoice with_planes(SetupChoice c, bool depth, bool alpha)
{
    auto const before = words_of(c);
    auto const used = sram_bytes_of(c);
    c.depth = depth;
    c.alpha = alpha;
    auto const room = c.machine.sram_bytes > used ? c.machine.sram_bytes - used : 0;
    c.sizes = splat::with_pixels_of(c.sizes, before, words_of(c).pixel, room);
    return c;
}

/// Returns the choice for tiles of `tile` pixels, with as many slots of storage as the rest of its machine's SRAM has room for: one more does
/// not fit. All other sizes stay. Throws Error if the machine has fewer tiles than the grid, or has room for no slot.
TILEMESH_HOST SetupChoice fill_storage(SetupChoice c, Grid grid, Extent2 tile);

/// Returns the choice on another machine, for tiles of `tile_pixels` pixels. If its sizes fit there and have the pixels, they stay. Otherwise
/// the framebuffer has the pixels, channels and FIFOs shrink as the SRAM without the code does (`channel_slots`: they have so many slots, at
/// most the choice's), and storage takes the rest, at least one slot. `facts_of` refuses what does not fit even so.
TILEMESH_HOST SetupChoice on_machine(SetupChoice c, MachineSize const& machine, std::uint32_t tile_pixels, std::uint32_t channel_slots = 0);

}}} // namespace tilemesh::render

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/render/detail/fill_storage_code.hpp>
#endif
