#pragma once
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/splat/counts.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/homes/counts.hpp>
#include <tilemesh/splat/setup.hpp>
#include <type_traits>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// Why a record, or its copy on some tile, is not in the picture.
enum class Cause : std::uint32_t {
    unplaced,      ///< the record's anchor tile has no storage left (`hold`); the host keeps the record
    storage_full,  ///< the record, or the copy, found no storage slot and is lost
    channel_full,  ///< the copy found no slot in the channel (`drop`)
    late,          ///< the record, or the copy, is still under way, because the frame's hops are bounded
    no_bloom       ///< the setup does not bloom, and the footprint leaves the anchor tile
};
inline constexpr std::uint32_t causes = 5;
TILEMESH_HOST char const* to_string(Cause cause) noexcept;

/// A record, or one copy of it, that the picture lacks.
struct Loss {
    static constexpr std::uint32_t whole = 0xffffffffu;
    splat::GaussianId id;
    std::uint32_t tile; ///< index of the tile that lacks the copy; `whole`: the record itself
    Cause cause;
    std::uint32_t full_tile = whole; ///< for an unplaced record: index of its anchor tile, which has no slot left; `whole`: none

    friend bool operator==(Loss const&, Loss const&) = default;
};

/// The tiles whose storage is too small for a frame. A tile needs a slot for each visible record and each copy that belongs on it, and for
/// each stored record that is not on screen.
struct FullTiles {
    std::uint32_t count = 0;   ///< tiles that need more slots than they have
    std::uint32_t fullest = 0; ///< index of the tile that needs the most
    std::uint64_t slots_needed = 0, slots_available = 0; ///< slots of the fullest tile

    friend bool operator==(FullTiles const&, FullTiles const&) = default;
};

/// The program that rendered a frame, or that shall: `automatic` renders with `anchored` until a frame would lose something, then with
/// `homes`.
using splat::Program, splat::to_string;

/// A tile whose part of the picture is cut short by a bound on rounds (program of homes). Its pixels are exact for all splats that are
/// nearer than `depth`, and lack the splats behind.
struct UnfinishedTile {
    std::uint32_t tile; ///< its index
    float depth;        ///< along z of the camera, in world units

    friend bool operator==(UnfinishedTile const&, UnfinishedTile const&) = default;
};

/// The counts and times of one frame. Every number except `host_ms` is exact: it is equal on every engine and with any number of threads.
/// `report_fields` below gives the meaning and the unit of each number.
struct FrameReport {
    std::string camera;
    Program program = Program::anchored; ///< that rendered the frame; never `automatic`
    std::uint32_t width = 0, height = 0;
    struct ByStage {
        std::uint64_t project = 0, route = 0, bloom = 0, composite = 0;
        std::uint64_t total() const noexcept { return project + route + bloom + composite; }
    } passes, exchanges;
    struct {
        std::uint64_t visible = 0, moved = 0, held = 0, dropped = 0, unplaced = 0, parked = 0, under_way = 0;
    } gaussians;
    struct Refused {
        std::uint64_t channel_full = 0, no_credit = 0, storage_full = 0, copies_full = 0, copies_refused = 0;
        std::uint64_t by_channels() const noexcept { return channel_full + no_credit; }
        std::uint64_t by_storage() const noexcept { return storage_full + copies_full; }
    } refused;
    std::vector<Loss> lost;
    std::optional<FullTiles> full_tiles; ///< set if a record or copy found no slot, and some tile needs more slots than it has
    std::uint64_t copies = 0, lost_copies = 0, late_copies = 0;
    std::uint64_t messages = 0, hops = 0;
    std::uint64_t exchanged_live_bytes = 0, exchanged_capacity_bytes = 0;
    std::uint64_t pairs = 0, pairs_contributing = 0;
    std::uint32_t peak_storage = 0, peak_channel = 0;
    std::vector<UnfinishedTile> unfinished; ///< one for each of `homes.unfinished_tiles`, in the order of tiles
    /// Only for the program of homes (splat/homes): all 0 otherwise.
    struct {
        std::uint64_t rounds = 0, parcels = 0, entries = 0, refused = 0, unfinished_tiles = 0;
        std::uint64_t chapters = 0, streamed_bytes = 0; ///< 0 if the map's records all have homes
    } homes;
    struct {
        double project = 0, route = 0, bloom = 0, composite = 0, picture = 0, total = 0;
    } host_ms;
    std::vector<std::uint64_t> digests; ///< digests of all live words, one per compute phase; empty without the option

    /// The number of entries of `lost` with this cause. Cost: one pass over `lost`.
    TILEMESH_HOST std::uint64_t losses(Cause cause) const noexcept;
};

/// The number of a frame whose program ran twice, because the host recalled copies of missing records: that of the first run, that of the
/// last one, or their sum.
enum class Rerun : std::uint32_t { first, last, sum };

/// The member of a tile's state in which the kernels of a program count a number of the report, which has the sum over all tiles and all
/// chapters of a map.
template <class Counts, class Work>
struct CountedIn {
    std::uint32_t Counts::*word = nullptr;                          ///< a word of a tile,
    std::uint32_t (Work::*of_workers)[Work::max_workers] = nullptr; ///< or a word of each worker; both null: no kernel counts it
    std::uint32_t unit = 1;                                         ///< the number in the report that a count stands for
};
using AnchoredCount = CountedIn<splat::Counts, splat::Work>;
using HomesCount = CountedIn<splat::homes::Counts, splat::homes::Work>;

/// One number of a FrameReport. The sums over tiles, text, report.json, its schema, CSV, HTML pages, the C interface and the comparisons of
/// tests read the table of these.
struct ReportField {
    std::string_view name;    ///< its path in report.json: "gaussians.visible"
    std::string_view unit;    ///< unit of the number: "records", "bytes", "ms"
    std::string_view line;    ///< the line of the text that has it; empty: the text has a table for it, or another place
    std::string_view phrase;  ///< the words after the number in that line: "12 visible"
    std::string_view meaning; ///< the meaning of the number, in words
    std::uint64_t (*count)(FrameReport const&) = nullptr; ///< reads an exact number, equal on every engine; null for host time
    double (*milliseconds)(FrameReport const&) = nullptr; ///< reads a time measured on the host; null for an exact number
    void (*set_count)(FrameReport&, std::uint64_t) = nullptr; ///< sets an exact number, cut to its member's bits; null for `lost` and `losses`
    void (*set_milliseconds)(FrameReport&, double) = nullptr; ///< sets a time; null for an exact number
    AnchoredCount anchored;       ///< the member of a tile's state that the kernels of the anchored program count in
    HomesCount homes;             ///< the member that those of the program of homes count in
    Rerun rerun = Rerun::first;

    /// `Member`: a lambda that returns a reference to the member of a report, const or not. Getter and setter both call it. If it returns
    /// a value, there is no setter. `more`, in any order: pointers to members of `splat::Counts` and `splat::homes::Counts`, an
    /// AnchoredCount, a HomesCount and a Rerun.
    template <class Member, class... More>
    constexpr ReportField(std::string_view path, std::string_view counted, std::string_view text_line, std::string_view words,
                          std::string_view sentence, Member, More... more)
        : name(path), unit(counted), line(text_line), phrase(words), meaning(sentence)
    {
        (take(more), ...);
        using Result = std::invoke_result_t<Member, FrameReport&>;
        using T = std::remove_reference_t<Result>;
        if constexpr (!std::is_reference_v<Result>) {
            count = [](FrameReport const& r) -> std::uint64_t { return Member{}(r); };
        } else if constexpr (std::is_same_v<T, double>) {
            milliseconds = [](FrameReport const& r) -> double { return Member{}(r); };
            set_milliseconds = [](FrameReport& r, double ms) { Member{}(r) = ms; };
        } else if constexpr (std::is_unsigned_v<T>) {
            count = [](FrameReport const& r) -> std::uint64_t { return Member{}(r); };
            set_count = [](FrameReport& r, std::uint64_t n) { Member{}(r) = static_cast<T>(n); };
        } else {
            count = [](FrameReport const& r) -> std::uint64_t { return Member{}(r).size(); };
        }
    }

    constexpr bool exact() const noexcept { return count != nullptr; }
    /// "gaussians" of "gaussians.visible"; empty for a name without a dot.
    constexpr std::string_view group() const noexcept
    {
        auto const dot = name.find('.');
        return dot == name.npos ? std::string_view{} : name.substr(0, dot);
    }
    /// "visible" of "gaussians.visible"; the name itself if it has no dot.
    constexpr std::string_view leaf() const noexcept { return name.substr(name.find('.') + 1); }
    /// Is `path` this field's name or its group?
    constexpr bool is_in(std::string_view path) const noexcept { return name == path || group() == path; }
    /// The member of a tile's state with these counters.
    constexpr AnchoredCount const& counted_in(splat::Counts const&) const noexcept { return anchored; }
    constexpr HomesCount const& counted_in(splat::homes::Counts const&) const noexcept { return homes; }
    /// Adds to an exact number.
    void add(FrameReport& r, std::uint64_t n) const { set_count(r, count(r) + n); }

private:
    constexpr void take(std::uint32_t splat::Counts::*word) noexcept { anchored.word = word; }
    constexpr void take(std::uint32_t splat::homes::Counts::*word) noexcept { homes.word = word; }
    constexpr void take(AnchoredCount of) noexcept { anchored = of; }
    constexpr void take(HomesCount of) noexcept { homes = of; }
    constexpr void take(Rerun which) noexcept { rerun = which; }
};

/// Every number of a FrameReport, in the order of report.json. A new counter is a word of a tile's `Counts`, a member of FrameReport and a
/// row here; tests/report/frame_report.cpp fails for a member without a row.
inline constexpr ReportField report_fields[] = {
    {"size_px.width", "pixels", "", "", "The width of the picture.",
     [](auto& r) -> auto& { return r.width; }},
    {"size_px.height", "pixels", "", "", "The height of the picture.",
     [](auto& r) -> auto& { return r.height; }},

    {"passes.project", "passes", "", "", "Passes of projection: how often its kernel ran on the tiles that had to run.",
     [](auto& r) -> auto& { return r.passes.project; }, Rerun::sum},
    {"passes.route", "passes", "", "", "Passes of routing: how often its kernel ran on the tiles that had to run.",
     [](auto& r) -> auto& { return r.passes.route; }, Rerun::sum},
    {"passes.bloom", "passes", "", "", "Passes of bloom: how often its kernel ran on the tiles that had to run.",
     [](auto& r) -> auto& { return r.passes.bloom; }, Rerun::sum},
    {"passes.composite", "passes", "", "", "Passes of depth sort and compositing: how often its kernels ran on the tiles that had to run.",
     [](auto& r) -> auto& { return r.passes.composite; }, Rerun::sum},

    {"exchanges.project", "exchanges", "", "", "Exchanges of projection that carried something.",
     [](auto& r) -> auto& { return r.exchanges.project; }},
    {"exchanges.route", "exchanges", "", "", "Exchanges of routing that carried something.",
     [](auto& r) -> auto& { return r.exchanges.route; }},
    {"exchanges.bloom", "exchanges", "", "", "Exchanges of bloom that carried something.",
     [](auto& r) -> auto& { return r.exchanges.bloom; }},
    {"exchanges.composite", "exchanges", "", "", "Exchanges of compositing that carried something.",
     [](auto& r) -> auto& { return r.exchanges.composite; }},

    {"gaussians.visible", "records", "Gaussians", "visible",
     "Records with something on screen when the frame begins, on a tile or under way, and records that stay with the host because they "
     "found no slot. Unplaced records are visible. Visible, parked and earlier dropped records add up to all records of the map.",
     [](auto& r) -> auto& { return r.gaussians.visible; }, &splat::Counts::visible, &splat::homes::Counts::visible},
    {"gaussians.moved", "records", "Gaussians", "moved", "Records whose anchor tile changed in this frame.",
     [](auto& r) -> auto& { return r.gaussians.moved; }, &splat::Counts::moved},
    {"gaussians.held", "refusals", "Gaussians", "held",
     "Refusals of a record by a full channel or for lack of credit (`hold`); a record that waits three times counts three.",
     [](auto& r) -> auto& { return r.gaussians.held; }},
    {"gaussians.dropped", "records", "Gaussians", "dropped", "Records that the machine lost for good (`drop`).",
     [](auto& r) -> auto& { return r.gaussians.dropped; }},
    {"gaussians.unplaced", "records", "Gaussians", "unplaced",
     "Records whose anchor tile has no storage left (`hold`); the host keeps them and tries again with the next view.",
     [](auto& r) -> auto& { return r.gaussians.unplaced; }},
    {"gaussians.parked", "records", "Gaussians", "parked",
     "Records with nothing on screen when the frame begins; each stays on its tile. Without routing, it stays with the host.",
     [](auto& r) -> auto& { return r.gaussians.parked; }, &splat::Counts::parked},
    {"gaussians.under_way", "records", "Gaussians", "under way",
     "Records in a channel or a FIFO when the frame ends, because its hops are bounded.",
     [](auto& r) -> auto& { return r.gaussians.under_way; }},

    {"lost", "records and copies", "missing", "records and copies",
     "Records and copies that the picture lacks. At the end of a frame, report.json lists each with its id, its cause and its tile.",
     [](auto& r) -> auto& { return r.lost; }},
    {"losses.unplaced", "records and copies", "", "",
     "Entries of `lost` whose record found its anchor tile full; the host keeps the record (`hold`).",
     [](auto& r) { return r.losses(Cause::unplaced); }},
    {"losses.storage_full", "records and copies", "", "", "Entries of `lost` that found no slot of storage.",
     [](auto& r) { return r.losses(Cause::storage_full); }},
    {"losses.channel_full", "records and copies", "", "", "Entries of `lost` that found no slot in a channel (`drop`).",
     [](auto& r) { return r.losses(Cause::channel_full); }},
    {"losses.late", "records and copies", "", "", "Entries of `lost` that are still under way, because the frame's hops are bounded.",
     [](auto& r) { return r.losses(Cause::late); }},
    {"losses.no_bloom", "records and copies", "", "", "Entries of `lost` that the setup does not send, because it does not bloom.",
     [](auto& r) { return r.losses(Cause::no_bloom); }},

    {"copies", "copies", "copies", "on tiles", "Copies that lie on the tiles when the frame ends.",
     [](auto& r) -> auto& { return r.copies; }, &splat::Counts::copies, Rerun::last},
    {"copies_lost", "copies", "copies", "lost",
     "Copies that their tile lacks because storage or a channel was full, or because the setup does not bloom: all listed copies that "
     "are not late. A record that no tile owns but that left copies counts once for each tile that lacks a copy.",
     [](auto& r) -> auto& { return r.lost_copies; }, Rerun::last},
    {"copies_late", "copies", "copies", "late",
     "Copies that their tile lacks because the copy or its record is still under way: all listed copies that are late.",
     [](auto& r) -> auto& { return r.late_copies; }, Rerun::last},

    {"hops", "messages", "exchanged", "hops of routing",
     "Messages of routing: one for each tile that a record passes on its way.",
     [](auto& r) -> auto& { return r.hops; }, &splat::Counts::hops, &splat::homes::Counts::hops},
    {"messages", "messages", "exchanged", "messages", "Messages of routing and bloom together.",
     [](auto& r) -> auto& { return r.messages; }},
    {"exchanged_bytes.live", "bytes", "exchanged", "bytes in them", "Bytes of these messages, without the 8-byte heads of channel ends.",
     [](auto& r) -> auto& { return r.exchanged_live_bytes; }},
    {"exchanged_bytes.capacity", "bytes", "exchanged", "bytes if each exchange moved all channels whole",
     "Bytes that compile-time exchanges move instead: in each exchange that carries something, the capacity of every channel and its 8-byte heads.",
     [](auto& r) -> auto& { return r.exchanged_capacity_bytes; }},

    {"pairs", "pairs", "pairs", "evaluated", "Gaussian-pixel pairs that compositing evaluated.",
     [](auto& r) -> auto& { return r.pairs; },
     AnchoredCount{nullptr, &splat::Work::evaluated, splat::pairs_a_count},
     HomesCount{nullptr, &splat::homes::Work::evaluated, splat::homes::pairs_a_count}, Rerun::last},
    {"pairs_contributing", "pairs", "pairs", "contributing",
     "Pairs with alpha of at least alpha_min in a pixel that was not finished.",
     [](auto& r) -> auto& { return r.pairs_contributing; },
     AnchoredCount{nullptr, &splat::Work::contributing}, HomesCount{nullptr, &splat::homes::Work::contributing}, Rerun::last},

    {"refused.channel_full", "refusals", "refused", "by full channels",
     "Refusals of a record by a channel without a free slot.",
     [](auto& r) -> auto& { return r.refused.channel_full; }, &splat::Counts::channel_full, &splat::homes::Counts::channel_full},
    {"refused.no_credit", "refusals", "refused", "for lack of credit",
     "Refusals of a record because the receiving tile had announced no room.",
     [](auto& r) -> auto& { return r.refused.no_credit; }, &splat::Counts::no_credit, &splat::homes::Counts::no_credit},
    {"refused.storage_full", "records", "refused", "by full storage",
     "Records that found no free storage slot on their anchor tile.",
     [](auto& r) -> auto& { return r.refused.storage_full; }, &splat::Counts::storage_full},
    {"refused.copies_full", "copies", "refused", "copies by full storage",
     "Copies that found no free storage slot on a tile.",
     [](auto& r) -> auto& { return r.refused.copies_full; }, &splat::Counts::copies_full},
    {"refused.copies_refused", "copies", "refused", "copies by full channels",
     "Copies that were given up, because the channel had no free slot (`drop`).",
     [](auto& r) -> auto& { return r.refused.copies_refused; }, &splat::Counts::copies_refused},

    {"peak.storage", "records", "peaks", "records on a tile",
     "The most records, copies among them, that one tile stored.",
     [](auto& r) -> auto& { return r.peak_storage; }},
    {"peak.channel", "records", "peaks", "in a channel", "The most records that one channel held.",
     [](auto& r) -> auto& { return r.peak_channel; }},

    {"homes.rounds", "rounds", "homes", "rounds",
     "Rounds of the program of homes: in each, tiles tell their windows, homes deliver the splats of these, and tiles blend them.",
     [](auto& r) -> auto& { return r.homes.rounds; }},
    {"homes.parcels", "parcels", "homes", "parcels sent",
     "Parcels that homes sent in all rounds. A parcel is one splat for at most 4 x 8 tiles.",
     [](auto& r) -> auto& { return r.homes.parcels; }, &splat::homes::Counts::sent},
    {"homes.entries", "splats", "homes", "entries",
     "Splats that tiles received from homes in all rounds: one for each tile and round.",
     [](auto& r) -> auto& { return r.homes.entries; }, &splat::homes::Counts::arrived},
    {"homes.refused", "splats", "homes", "refused",
     "Entries that found no room on their tile; homes send them again in a later round.",
     [](auto& r) -> auto& { return r.homes.refused; }, &splat::homes::Counts::refused},
    {"homes.unfinished_tiles", "tiles", "homes", "tiles unfinished",
     "Tiles whose part of the picture a bound on rounds cut short. Each shows the nearest splats exactly.",
     [](auto& r) -> auto& { return r.homes.unfinished_tiles; }},
    {"homes.chapters", "chapters", "homes", "chapters",
     "Parts in which the host sent the map to the tiles, nearest first, because not all of its records fit at once; 0: all fit.",
     [](auto& r) -> auto& { return r.homes.chapters; }},
    {"homes.streamed_bytes", "bytes", "homes", "bytes streamed", "Bytes of the records in these chapters.",
     [](auto& r) -> auto& { return r.homes.streamed_bytes; }},

    {"host_ms.project", "ms", "", "", "Host time of projection.",
     [](auto& r) -> auto& { return r.host_ms.project; }},
    {"host_ms.route", "ms", "", "", "Host time of routing.",
     [](auto& r) -> auto& { return r.host_ms.route; }},
    {"host_ms.bloom", "ms", "", "", "Host time of bloom.",
     [](auto& r) -> auto& { return r.host_ms.bloom; }},
    {"host_ms.composite", "ms", "", "", "Host time of depth sort and compositing.",
     [](auto& r) -> auto& { return r.host_ms.composite; }, Rerun::sum},
    {"host_ms.picture", "ms", "", "",
     "Host time of joining the tiles' framebuffers to one picture, which is no work of the machine.",
     [](auto& r) -> auto& { return r.host_ms.picture; }},
    {"host_ms.total", "ms", "", "", "Host time of the whole frame.",
     [](auto& r) -> auto& { return r.host_ms.total; }},
};

/// The field of that name, at compile time: `report_field("gaussians.moved").count(report)`. A name that is not in the table does not
/// compile.
consteval ReportField const& report_field(std::string_view name)
{
    for (auto const& field : report_fields)
        if (field.name == name) return field;
    throw "report_fields has no field of this name";
}

/// The sum of a group of counters, or of one.
TILEMESH_HOST std::uint64_t total(FrameReport const& r, std::string_view path) noexcept;

/// The lines of the text, in order. Every `line` of report_fields is one of them, or empty.
inline constexpr std::string_view text_lines[] = {"Gaussians", "missing", "copies", "exchanged", "refused", "pairs", "peaks", "homes"};

/// Does the text of this frame have the line? The line "homes" is only for frames of that program.
TILEMESH_HOST bool has_line(FrameReport const& r, std::string_view line) noexcept;

/// The numbers of one line of the text: numbers_of(report, "copies") is "96,484 on tiles, 0 lost, 0 late". Empty if no field names the
/// line.
TILEMESH_HOST std::string numbers_of(FrameReport const& r, std::string_view line);

/// The unfinished tile that is cut at the least depth; among equals the first. There must be one.
TILEMESH_HOST UnfinishedTile const& nearest_cut(FrameReport const& r) noexcept;

/// A short text for a terminal: a table of the stages, then one line for each group of counters.
TILEMESH_HOST std::ostream& operator<<(std::ostream& out, FrameReport const& r);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/frame_report_code.hpp>
#endif
