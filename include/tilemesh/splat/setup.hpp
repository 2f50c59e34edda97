#pragma once
#include <cstdint>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/splat/rules.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The capacities of a frame's lists on one tile, in slots. They are values, not types: renderers, ledgers and meshes of different sizes
/// share one type and its code.
///
/// Start from a preset's sizes and change single members: `auto sizes = splat::lossless.sizes; sizes.storage = 700;`. A mistyped name does
/// not compile.
struct Sizes {
    /// Anchored records and copies; each slot also has a mark, a projected record and a sort key. Homes: splats of a window that the tile
    /// holds; at least 1
    std::uint32_t storage = 0;
    std::uint32_t road = 0;          ///< messages of routing in one channel end (one direction); homes: splats under way, at least 1
    std::uint32_t beam = 0;          ///< messages of bloom in one channel end (one direction); homes have no such channel
    std::uint32_t waiting = 0;       ///< messages in each of routing's two FIFOs; at least 1 with `Hold` and in homes
    std::uint32_t tile_pixels = 0;   ///< pixels of the framebuffer; homes: 80 for each block
    bool lists_fit = true;           ///< marks, projected records and sort keys count against the SRAM
    bool one_channel_memory = false; ///< road and beam share one SRAM region
    // Only in the program of homes. The last three follow from the grid and the frame.
    std::uint32_t homes = 0;         ///< records that live on the tile
    std::uint32_t tile_blocks = 0;   ///< blocks of 16 x 5 pixels
    std::uint32_t columns = 0, tiles = 0; ///< districts in a row of the grid, and of the grid: every tile keeps a table of all of them

    friend constexpr bool operator==(Sizes const& a, Sizes const& b) noexcept
    {
        return a.storage == b.storage && a.road == b.road && a.beam == b.beam && a.waiting == b.waiting &&
               a.tile_pixels == b.tile_pixels && a.lists_fit == b.lists_fit && a.one_channel_memory == b.one_channel_memory &&
               a.homes == b.homes && a.tile_blocks == b.tile_blocks && a.columns == b.columns && a.tiles == b.tiles;
    }
};

/// The program that renders: records move to anchor tiles; or they stay on their homes, and splats travel; or the first until it lacks
/// something, then the second.
enum class Program : std::uint32_t { automatic, anchored, homes };

/// Returns "auto", "anchored" or "homes".
constexpr char const* to_string(Program program) noexcept
{
    return program == Program::automatic ? "auto" : program == Program::anchored ? "anchored" : "homes";
}

/// The format in which the machine stores a pixel's colour.
enum class ColourFormat : std::uint32_t { float32, rgbx8, own };

/// What a user chooses, as one literal value: the machine, the program, the sizes of a tile's lists, the policies, the records, the planes
/// of pixels, and the rules of the picture. Every ledger, renderer, program and report takes this value.
///
/// Start from a setup of the library (`lossless`, `paper`, `prototype`, `homes_setup`) and change what you want to change:
/// `constexpr auto narrow = with(lossless, [](Setup& s) { s.sizes.road = 8; });`. By the names of render/setup_fields.hpp:
/// `with(lossless, {{"channel-slots", 8}, {"saturation", "drop"}})`.
///
/// A setup as a type, for a program whose kernels are compiled for it alone, and for policies of your own: `SetupType` (setup_types.hpp).
struct Setup {
    char const* name = "lossless"; ///< every report shows it
    MachineSize machine = size_of_machine<Mk2>();
    Program program = Program::anchored;
    Sizes sizes{};
    // Policies (policies.hpp). The program of homes has those of `homes_setup`.
    bool holds = true;              ///< a full channel holds records back (`Hold`), or they are lost (`Drop`)
    bool carried = true;            ///< the anchor tile travels with the record (`Carried`), or is computed on the way (`Recomputed`)
    bool reusable = true;           ///< bloom sends records (`WorldCopies`) or splats (`ScreenCopies`)
    bool ranks = false;             ///< `LargestFirst` of the saturation
    /// False: in each new view the host places every record on its anchor tile. A record that finds no room there is tried again in the
    /// next view.
    bool routes = true;
    bool blooms = true;             ///< false: no copies; the report lists a splat as lost on all tiles except its anchor
    std::uint32_t sh_degree = 0;    ///< of the harmonics in a record, 0 to 3
    ColourFormat colour = ColourFormat::float32;
    bool depth = false, alpha = false; ///< planes beside the colour
    Rules rules{};
    /// Only in the program of homes. `fit`: as many homes as the map needs, if the SRAM has room for them, and `storage` shrinks to what
    /// they leave. `district`: tiles along a side of a district (homes/regions.hpp), a power of 2; 0: the smallest with which a tile's lists
    /// fit.
    bool fit = false;
    std::uint32_t district = 1;
    /// Bytes of a record, of a pixel and of a frame's parameters of your own type; 0: those of the degree, of the colour and its planes, and of
    /// FrameParameters.
    std::uint32_t own_record_bytes = 0, own_pixel_bytes = 0, own_parameter_bytes = 0;

    constexpr bool has_planes() const noexcept { return depth || alpha; }
};

/// Returns a changed setup: `change(setup)` writes to a copy.
template <class Change>
constexpr auto with(Setup setup, Change const& change) noexcept -> decltype(change(setup), Setup{})
{
    change(setup);
    return setup;
}

namespace detail {
constexpr Setup make_lossless() noexcept
{
    Setup s;
    s.sizes = {/*storage*/ 2000, /*road*/ 200, /*beam*/ 200, /*waiting*/ 200, /*tile_pixels*/ 32 * 20};
    s.rules.arithmetic = Arithmetic::fast;
    return s;
}
constexpr Setup make_paper(char const* name, std::uint32_t storage, std::uint32_t channel) noexcept
{
    Setup s = make_lossless();
    s.name = name;
    s.holds = s.carried = false;
    s.colour = ColourFormat::rgbx8;
    s.sizes = {storage, channel, channel, /*waiting*/ 0, /*tile_pixels*/ 32 * 20, /*lists_fit*/ false, /*one_channel_memory*/ true};
    s.rules.footprint = Footprint::three_sigma_square;
    s.rules.alpha_max = 0.99f;
    s.rules.transmittance_min = 1e-4f; // that of 3D Gaussian Splatting
    return s;
}
constexpr Setup make_homes() noexcept
{
    Setup s;
    s.name = "homes";
    s.program = Program::homes;
    s.reusable = false; // splats travel
    s.sizes.homes = 950;
    s.sizes.storage = 2800;
    s.sizes.road = s.sizes.waiting = 120;
    return s;
}
} // namespace detail

/// The default. No record is lost, pixels are floats, and the ledger holds everything that the kernels keep (622.4 KiB of Mk2's 624).
/// `Arithmetic::fast` takes 0.70 to 0.74 times the host time of `precise`, and its error against the picture in double precision is not
/// larger (measured by bench/frame and bench/error_vs_time).
///
/// It has two sets of channels, the paper has one; each channel has half the paper's slots. With two real maps and motions up to 2 degrees
/// a frame, one channel carried at most 165 records (measured). A full channel costs passes, not records. FIFOs of 200 messages cost no
/// pass up to 100,000 records (measured). One record in storage takes 136 bytes, including its mark, splat and sort key.
inline constexpr Setup lossless = detail::make_lossless();

/// The paper's numbers (sections "Framebuffer Partitioning" and "Per-tile SRAM capacity"): 400-slot channels, 3,200 slots of 60 bytes,
/// RGBX8, 3-sigma squares, drop. The paper's budget has no room for render lists, FIFOs or credits. The ledger lists what our kernels keep
/// of these outside the budget.
inline constexpr Setup paper = detail::make_paper("paper", 3200, 400);

/// The capacities that the authors' public code really has. That code steps through float buffers by a count of bytes, so a record takes
/// 240 bytes: the paper's 24,000-byte channel holds 100 records, its 192,000-byte storage 800. The ledger counts records of their true
/// size.
inline constexpr Setup prototype = detail::make_paper("prototype", 800, 100);

/// The program of homes and windows on Mk2. With 120 slots a channel end and 2,800 splats a window, four modelled views take the least time
/// or nearly so (bench/any_map).
inline constexpr Setup homes_setup = detail::make_homes();

/// Returns the program of homes on a setup's machine, with its records, pixels and rules, and with as many homes as the map needs.
constexpr Setup as_homes(Setup const& setup) noexcept
{
    Setup homes = homes_setup;
    homes.name = setup.name;
    homes.machine = setup.machine;
    homes.sh_degree = setup.sh_degree;
    homes.colour = setup.colour;
    homes.depth = setup.depth;
    homes.alpha = setup.alpha;
    homes.rules = setup.rules;
    homes.fit = true;
    homes.district = 0;
    return homes;
}

}}} // namespace tilemesh::splat
