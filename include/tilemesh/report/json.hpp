#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/report/certificate.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/json_text.hpp>
#include <tilemesh/report/run_report.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// The version of report.json's form. It changes when a member changes its name, its place or its meaning, or is removed, and
/// when a word (a cause) gets a new value. New members do not change it, so a reader ignores members that it does not know.
inline constexpr std::uint32_t report_schema = 2;

namespace detail {

/// The digits of nlohmann-json, so that the report has the bytes of a document that is read and printed again.
inline std::string digits(double value)
{
    return nlohmann::ordered_json(value).dump();
}

/// Writes a value, or null in its place.
template <class T>
void write_or_null(JsonText& json, std::string_view name, bool there, T const& value)
{
    json.key(name);
    if (there) json.value(value);
    else json.value(nullptr);
}

inline void write(JsonText& json, std::string_view name, ErrorMeasures const& e)
{
    json.object(name, [&] {
        json.member("rmse", e.rmse);
        json.member("max_levels", e.max_levels);
        json.member("p999_levels", e.p999_levels);
        json.member("psnr_db", e.psnr_db);
        json.member("ssim", e.ssim);
    });
}

/// The measures are null if the pictures were not compared.
inline void write(JsonText& json, std::string_view name, Comparison const& other)
{
    json.object(name, [&] {
        json.member("file", other.file);
        write_or_null(json, "problem", !other.problem.empty(), other.problem);
        bool const compared = other.problem.empty();
        auto const& m = other.measures;
        write_or_null(json, "psnr_db", compared, m.psnr_db);
        write_or_null(json, "ssim", compared, m.ssim);
        write_or_null(json, "l1", compared, m.l1);
        write_or_null(json, "largest", compared, m.largest);
        if (compared) json.list("largest_at", m.largest_at);
        else json.member("largest_at", nullptr);
        write_or_null(json, "error", !other.error.empty(), other.error);
    });
}

inline void write(JsonText& json, std::string_view name, Certificate const& c)
{
    json.object(name, [&] {
        json.member("largest_levels", c.largest);
        json.member("p99_levels", c.p99);
        json.member("median_levels", c.median);
        json.member("widest_interval_levels", c.widest);
        json.member("pixels_beyond", c.beyond);
        json.member("pixels_in_100_bits", c.in_wide);
        json.member("pixels_undecided", c.undecided);
        json.list("ids_not_enclosed", c.not_enclosed);
        auto const plane = [&](std::string_view which, std::optional<Certificate::OfPlane> const& of) {
            if (!of) return;
            json.object(which, [&] {
                json.member("largest", of->largest);
                json.member("p99", of->p99);
                json.member("median", of->median);
            });
        };
        plane("depth", c.depth);
        plane("alpha", c.alpha);
        json.objects("causes", c.causes, [&](auto const& cause) {
            json.member("word", cause.first);
            json.member("pixels", cause.second);
        });
        json.objects("worst", c.worst, [&](Certificate::Pixel const& pixel) {
            json.list("pixel", std::array{pixel.x, pixel.y});
            json.member("levels", pixel.levels);
            json.object("cause", [&, &cause = pixel.cause] {
                json.member("word", cause.word);
                write_or_null(json, "id", cause.id != 0, cause.id);
                write_or_null(json, "other_id", cause.other_id != 0, cause.other_id);
                json.member("left_levels", cause.left);
            });
        });
    });
}

inline void write(JsonText& json, ReportField const& field, std::string_view name, FrameReport const& r)
{
    if (field.exact()) json.member(name, field.count(r));
    else json.member(name, field.milliseconds(r));
}

inline std::string text_of(RunFrame const& frame)
{
    JsonText json(1, digits);
    auto const& r = frame.report;
    json.object([&] {
        json.member("camera", r.camera);
        json.member("program", to_string(r.program));
        if (frame.timestamp_s) json.member("timestamp_s", *frame.timestamp_s);
        if (frame.view) {
            json.list("intrinsics_px", frame.view->intrinsics_px);
            json.member_as_is("world_to_camera", matrix_text(frame.view->world_to_camera, digits));
            if (auto const& s = frame.view->shutter; s.rolls())
                json.list("rolling_shutter", std::array{s.turn[0], s.turn[1], s.turn[2], s.move[0], s.move[1], s.move[2]});
            if (auto const& lens = frame.view->lens; lens.kind != splat::LensKind::pinhole) {
                json.member("lens", splat::lens_names[static_cast<std::size_t>(lens.kind)]);
                json.list("lens_coefficients", std::array{lens.k[0], lens.k[1], lens.k[2], lens.k[3], lens.k[4], lens.k[5], lens.p[0], lens.p[1]});
            }
        }
        json.list("size_px", std::array{r.width, r.height});
        json.list("grid", frame.grid);
        json.list("tile_px", frame.tile_px);
        if (!frame.image.empty()) json.member("image", frame.image);
        if (!frame.depth.empty()) json.member("depth", frame.depth);
        if (!frame.alpha.empty()) json.member("alpha", frame.alpha);
        for (auto const* field = std::begin(report_fields); field != std::end(report_fields); ++field) {
            auto const group = field->group();
            if (group == "size_px" || field->name == "lost") continue; // an array above, a list below
            if (group.empty()) {
                write(json, *field, field->name, r);
                continue;
            }
            auto const of_group = [&](auto const& other) { return other.group() == group; };
            if (std::find_if(std::begin(report_fields), field, of_group) != field) continue; // written with the first of its group
            json.object(group, [&] {
                for (auto const& other : report_fields)
                    if (of_group(other)) write(json, other, other.leaf(), r);
            });
            if (group == "losses" && r.full_tiles)
                json.object("full_tiles", [&] {
                    json.member("count", r.full_tiles->count);
                    json.member("fullest", r.full_tiles->fullest);
                    json.member("slots_needed", r.full_tiles->slots_needed);
                    json.member("slots_available", r.full_tiles->slots_available);
                });
        }
        if (frame.modelled)
            json.object("modelled", [&] {
                json.member("cost_model", frame.modelled->cost_model);
                json.member("cycles", frame.modelled->cycles);
                json.member("ms", frame.modelled->ms);
            });
        auto const measured = [&](std::string_view name, auto const& measures) {
            if (measures) write(json, name, *measures);
        };
        measured("error", frame.error);
        measured("error_same_cuts", frame.error_same_cuts);
        measured("certified", frame.certified);
        measured("compared_certified", frame.compared_certified);
        measured("photograph", frame.photograph);
        measured("compared", frame.compared);
        if (!r.unfinished.empty())
            json.objects("unfinished", r.unfinished, [&](UnfinishedTile const& cut) {
                json.member("tile", cut.tile);
                json.member("depth", double{cut.depth});
            });
        json.objects("lost", r.lost, [&](Loss const& loss) { // last: it may be long
            bool const whole = loss.tile == Loss::whole;
            auto const tile = whole ? loss.full_tile : loss.tile;
            json.member("id", static_cast<std::uint32_t>(loss.id));
            json.member("what", whole ? "record" : "copy");
            json.member("cause", to_string(loss.cause));
            write_or_null(json, "tile", tile != Loss::whole, tile);
        });
    });
    return json.text();
}

inline void write_machine(JsonText& json, RunReport const& run)
{
    auto const size = [&](std::string_view name, auto const& of_first) {
        if (run.frames.empty()) json.member(name, nullptr);
        else json.list(name, of_first(run.frames.front()));
    };
    std::uint64_t budgeted = 0, outside = 0;
    for (auto const& region : run.machine.ledger) (region.budgeted ? budgeted : outside) += region.bytes;
    json.object("machine", [&] {
        json.member("name", run.machine.name);
        size("grid", [](RunFrame const& frame) { return frame.grid; });
        size("tile_px", [](RunFrame const& frame) { return frame.tile_px; });
        json.member("sram_bytes", run.machine.sram_bytes);
        json.member("storage_slots", run.machine.storage_slots);
        json.member("channel_slots", run.machine.channel_slots);
        json.member("budgeted_bytes", budgeted);
        json.objects("ledger", run.machine.ledger, [&](machine::Region const& region) {
            json.member("region", std::string_view(region.name.text, region.name.size));
            json.member("bytes", region.bytes);
            json.member("what", region.what);
            json.member("budgeted", region.budgeted);
        });
        if (outside != 0)
            json.member("note", "regions with budgeted = false, " + std::to_string(outside) +
                                    " bytes, are lists that our kernels keep and that the budget of preset " + run.preset + " has no room for");
    });
}

/// report.json without its frames.
inline std::string text_of_head(RunReport const& run)
{
    JsonText json(1, digits);
    json.object([&] {
        json.member("schema", report_schema);
        json.member("version", std::to_string(TILEMESH_VERSION / 10000) + "." + std::to_string(TILEMESH_VERSION / 100 % 100) + "." +
                                   std::to_string(TILEMESH_VERSION % 100));
        json.object("map", [&] {
            json.member("name", run.map.name);
            write_or_null(json, "path", !run.map.path.empty(), run.map.path);
            json.member("gaussians", run.map.gaussians);
            json.member("rejected", run.map.rejected);
            json.list("notes", run.map.notes);
        });
        write_machine(json, run);
        json.member("preset", run.preset);
        json.member("program", to_string(run.program));
        json.object("policies", [&, &p = run.policies] {
            json.member("routing", p.routing);
            json.member("addressing", p.addressing);
            json.member("saturation", p.saturation);
            json.member("footprint", p.footprint);
            json.member("copies", p.copies);
            json.member("pixels", p.pixels);
            json.member("arithmetic", p.arithmetic);
            if (p.hops == 0) json.member("hops", "quiet");
            else json.member("hops", p.hops);
            if (p.rounds == 0) json.member("rounds", "all");
            else json.member("rounds", p.rounds);
        });
        json.member("quality", run.quality);
        json.object("cut_offs", [&] {
            json.member("alpha_min", double{run.cut_offs.alpha_min});
            json.member("transmittance_min", double{run.cut_offs.transmittance_min});
            json.member("alpha_max", double{run.cut_offs.alpha_max});
        });
        json.array("background", run.background, [&](float channel) { json.value(double{channel}); });
        json.object("setup", [&] {
            for (auto const& field : run.setup) {
                if (!field.word.empty()) json.member(field.name, field.word);
                else if (field.number == std::floor(field.number)) json.member(field.name, static_cast<std::uint64_t>(field.number));
                else json.member(field.name, field.number);
            }
        });
        json.objects("features", run.features, [&](RunReport::Feature const& feature) {
            json.member("feature", feature.name);
            json.member("kept", feature.kept);
            json.member("why", feature.why);
        });
        json.member("engine", run.engine);
        json.member("threads", run.threads);
        if (run.ranks > 1) json.member("ranks", run.ranks);
        if (!run.made_from.version.empty())
            json.object("made_from", [&] {
                json.member("version", run.made_from.version);
                json.list("options", run.made_from.options);
                json.objects("files", run.made_from.files, [&](MadeFrom::File const& file) {
                    json.member("path", file.path);
                    json.member("bytes", file.bytes);
                    json.member("digest", file.digest);
                });
            });
        if (auto const means = photograph_means(run); means.compared + means.not_compared != 0)
            json.object("photographs", [&] {
                json.member("compared", means.compared);
                json.member("not_compared", means.not_compared);
                json.member("psnr_db", means.psnr_db);
                json.member("ssim", means.ssim);
                json.member("l1", means.l1);
            });
        json.list("notes", run.notes);
        write_or_null(json, "advice", !run.advice.empty(), run.advice);
    });
    return json.text();
}

/// Calls `put(text)` for each piece of report.json: the head, then frame after frame.
template <class Put>
void put_json(RunReport const& run, Put const& put)
{
    auto head = text_of_head(run);
    head.resize(head.size() - 2); // without "\n}"
    put(head);
    put(",\n \"frames\": [");
    for (auto const& frame : run.frames) {
        put(&frame == run.frames.data() ? "\n" : ",\n");
        put(text_of(frame));
    }
    put("\n ]\n}\n");
}

} // namespace detail

/// report.json of a run, keys in a fixed order; report.schema.json beside this header describes it. Null stands for the PSNR of two
/// equal pictures (it is infinite), for the measures of pictures that were not compared, for the path of a map without a file, for no advice, and for
/// the tile of a lost record that is on no tile. The tile of an unplaced record is its anchor tile, which is full. The tile of a copy is the tile
/// that lacks it.
///
/// `machine.grid` and `machine.tile_px` are those of the first frame; each frame has its own, since cameras may differ in
/// size. Ledger entries with `budgeted` false are kept on the tile, but the budget of the preset has no room for them: then
/// `machine.note` says so, and `machine.budgeted_bytes` leaves them out.
///
/// The destructor of the document allocates. If it finds no memory, the process ends. `write_json` makes no document.
inline nlohmann::ordered_json json_of(RunReport const& run)
{
    std::string text;
    detail::put_json(run, [&](std::string_view piece) { text += piece; });
    return nlohmann::ordered_json::parse(text);
}

/// Writes `json_of(run)` as UTF-8 text, whole or not at all. Bytes of a path that are no UTF-8 become U+FFFD. Throws
/// `tilemesh::Error` when the file cannot be written. Cost: memory for one frame's text at a time; a frame that lacks 100,000 copies
/// has 15 MB of it.
inline void write_json(std::filesystem::path const& path, RunReport const& run, Outlasts outlasts = Outlasts::process)
{
    WholeFile file(path, "the report", outlasts);
    detail::put_json(run, [&](std::string_view piece) { file.put(piece); });
    file.finish();
}

}}} // namespace tilemesh::report
