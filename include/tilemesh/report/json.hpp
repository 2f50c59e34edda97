#pragma once
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/run_report.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <utility>
#include <vector>

namespace tilemesh::report {

namespace detail {

/// A number, or null where JSON has none: the PSNR of equal pictures is infinite.
inline nlohmann::ordered_json finite_or_null(double value)
{
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

inline nlohmann::ordered_json json_of(ErrorMeasures const& e)
{
    return {{"rmse", finite_or_null(e.rmse)},
            {"max_levels", finite_or_null(e.max_levels)},
            {"p999_levels", finite_or_null(e.p999_levels)},
            {"psnr_db", finite_or_null(e.psnr_db)},
            {"ssim", finite_or_null(e.ssim)}};
}

inline nlohmann::ordered_json json_of(Loss const& loss)
{
    nlohmann::ordered_json json{{"id", static_cast<std::uint32_t>(loss.id)},
                                {"cause", to_string(loss.cause)},
                                {"tile", nullptr}};
    if (loss.tile != Loss::whole) json["tile"] = loss.tile;
    return json;
}

inline nlohmann::ordered_json json_of(RunFrame const& frame)
{
    using Json = nlohmann::ordered_json;
    auto const& r = frame.report;
    Json json;
    json["camera"] = r.camera;
    json["size_px"] = {r.width, r.height};
    json["grid"] = frame.grid;
    json["tile_px"] = frame.tile_px;
    if (!frame.image.empty()) json["image"] = frame.image;
    if (!frame.depth.empty()) json["depth"] = frame.depth;
    if (!frame.alpha.empty()) json["alpha"] = frame.alpha;
    for (auto const& field : report_fields) {
        if (field.group() == "size_px") continue; // an array, above
        auto& value = field.group().empty() ? json[std::string(field.name)]
                                            : json[std::string(field.group())][std::string(field.leaf())];
        if (field.name == "lost") {
            value = Json::array();
            for (auto const& loss : r.lost) value.push_back(json_of(loss));
        } else if (field.exact()) {
            value = field.count(r);
        } else {
            value = field.milliseconds(r);
        }
    }
    if (frame.error) json["error"] = json_of(*frame.error);
    if (frame.error_same_cuts) json["error_same_cuts"] = json_of(*frame.error_same_cuts);
    return json;
}

inline nlohmann::ordered_json json_of(std::vector<Region> const& ledger)
{
    auto json = nlohmann::ordered_json::array();
    for (auto const& region : ledger)
        json.push_back({{"region", std::string(region.name.text, region.name.size)},
                        {"bytes", region.bytes},
                        {"what", region.what},
                        {"budgeted", region.budgeted}});
    return json;
}

inline nlohmann::ordered_json json_of(MadeFrom const& made_from)
{
    nlohmann::ordered_json json{{"version", made_from.version}, {"options", made_from.options}};
    json["files"] = nlohmann::ordered_json::array();
    for (auto const& file : made_from.files)
        json["files"].push_back({{"path", file.path}, {"bytes", file.bytes}, {"digest", file.digest}});
    return json;
}

/// report.json without its frames.
inline nlohmann::ordered_json json_of_head(RunReport const& run)
{
    using Json = nlohmann::ordered_json;
    Json json;
    json["map"] = {{"name", run.map.name},
                   {"path", run.map.path.empty() ? Json(nullptr) : Json(run.map.path)},
                   {"gaussians", run.map.gaussians},
                   {"rejected", run.map.rejected},
                   {"notes", run.map.notes}};

    auto& machine = json["machine"];
    machine["name"] = run.machine.name;
    machine["grid"] = run.frames.empty() ? Json(nullptr) : Json(run.frames.front().grid);
    machine["tile_px"] = run.frames.empty() ? Json(nullptr) : Json(run.frames.front().tile_px);
    machine["sram_bytes"] = run.machine.sram_bytes;
    machine["storage_slots"] = run.machine.storage_slots;
    machine["channel_slots"] = run.machine.channel_slots;
    std::uint64_t budgeted = 0, outside = 0;
    for (auto const& region : run.machine.ledger) (region.budgeted ? budgeted : outside) += region.bytes;
    machine["budgeted_bytes"] = budgeted;
    machine["ledger"] = detail::json_of(run.machine.ledger);
    if (outside != 0)
        machine["note"] = "regions with budgeted = false, " + std::to_string(outside) +
                          " bytes, are lists that our kernels keep and that the budget of preset " + run.preset +
                          " has no room for";

    json["preset"] = run.preset;
    json["policies"] = {{"routing", run.policies.routing},       {"addressing", run.policies.addressing},
                        {"saturation", run.policies.saturation}, {"footprint", run.policies.footprint},
                        {"copies", run.policies.copies},         {"pixels", run.policies.pixels},
                        {"arithmetic", run.policies.arithmetic}};
    json["policies"]["hops"] = run.policies.hops == 0 ? Json("quiet") : Json(run.policies.hops);
    json["quality"] = run.quality;
    json["cut_offs"] = {{"alpha_min", finite_or_null(run.cut_offs.alpha_min)},
                        {"transmittance_min", finite_or_null(run.cut_offs.transmittance_min)},
                        {"alpha_max", finite_or_null(run.cut_offs.alpha_max)}};
    json["features"] = Json::array();
    for (auto const& feature : run.features)
        json["features"].push_back({{"feature", feature.name}, {"kept", feature.kept}, {"why", feature.why}});
    json["engine"] = run.engine;
    json["threads"] = run.threads;
    if (!run.made_from.version.empty()) json["made_from"] = json_of(run.made_from);
    json["notes"] = run.notes;
    return json;
}

} // namespace detail

/// report.json of a run, keys in a fixed order. Null stands for the PSNR of two equal pictures (it is infinite), for the tile
/// of a loss that is the record itself, and for the path of a map without a file.
///
/// `machine.grid` and `machine.tile_px` are those of the first frame; each frame has its own, since cameras may differ in
/// size. Ledger entries with `budgeted` false are kept on the tile, but the budget of the preset has no room for them: then
/// `machine.note` says so, and `machine.budgeted_bytes` leaves them out.
inline nlohmann::ordered_json json_of(RunReport const& run)
{
    auto json = detail::json_of_head(run);
    json["frames"] = nlohmann::ordered_json::array();
    for (auto const& frame : run.frames) json["frames"].push_back(detail::json_of(frame));
    return json;
}

/// One entry of report.json's `frames`, read back: `json_of` writes the same again. What report.json leaves out (digests, and two
/// of an error's measures) is empty or 0. Throws `tilemesh::Error` for JSON that lacks a number or has another type in its place.
inline RunFrame frame_of(nlohmann::ordered_json const& json)
{
    using Json = nlohmann::ordered_json;
    auto const read = [](Json const& from, std::initializer_list<std::pair<char const*, std::uint64_t*>> counters) {
        for (auto const& [key, counter] : counters) from.at(key).get_to(*counter);
    };
    auto const error = [](Json const& from) {
        auto const number = [&](char const* key) {
            return from.at(key).is_null() ? std::numeric_limits<double>::infinity() : from.at(key).get<double>();
        };
        ErrorMeasures e{};
        e.rmse = number("rmse"), e.max_levels = number("max_levels"), e.p999_levels = number("p999_levels");
        e.psnr_db = number("psnr_db"), e.ssim = number("ssim");
        return e;
    };
    RunFrame frame;
    auto& r = frame.report;
    try {
        json.at("camera").get_to(r.camera);
        json.at("size_px").at(0).get_to(r.width);
        json.at("size_px").at(1).get_to(r.height);
        json.at("grid").get_to(frame.grid);
        json.at("tile_px").get_to(frame.tile_px);
        frame.image = json.value("image", "");
        frame.depth = json.value("depth", "");
        frame.alpha = json.value("alpha", "");
        read(json.at("supersteps"), {{"project", &r.supersteps.project},
                                     {"route", &r.supersteps.route},
                                     {"bloom", &r.supersteps.bloom},
                                     {"composite", &r.supersteps.composite}});
        read(json.at("gaussians"), {{"visible", &r.gaussians.visible},
                                    {"moved", &r.gaussians.moved},
                                    {"held", &r.gaussians.held},
                                    {"dropped", &r.gaussians.dropped},
                                    {"unplaced", &r.gaussians.unplaced},
                                    {"parked", &r.gaussians.parked},
                                    {"under_way", &r.gaussians.under_way}});
        read(json.at("refused"), {{"channel_full", &r.refused.channel_full},
                                  {"no_credit", &r.refused.no_credit},
                                  {"storage_full", &r.refused.storage_full},
                                  {"copies_full", &r.refused.copies_full},
                                  {"copies_refused", &r.refused.copies_refused}});
        read(json.at("exchanged_bytes"), {{"live", &r.exchanged_live_bytes}, {"capacity", &r.exchanged_capacity_bytes}});
        read(json, {{"copies", &r.copies},
                    {"copies_lost", &r.lost_copies},
                    {"copies_late", &r.late_copies},
                    {"messages", &r.messages},
                    {"hops", &r.hops},
                    {"pairs", &r.pairs},
                    {"pairs_contributing", &r.pairs_contributing}});
        json.at("peak").at("storage").get_to(r.peak_storage);
        json.at("peak").at("channel").get_to(r.peak_channel);
        for (auto const& loss : json.at("lost")) {
            auto const& cause = loss.at("cause").get_ref<std::string const&>();
            auto const& tile = loss.at("tile");
            std::uint32_t number = 0;
            while (number < causes && cause != to_string(Cause{number})) ++number;
            if (number == causes) throw Error("a frame of a report has the loss \"" + cause + "\" (there is no such cause); write the report again");
            r.lost.push_back({splat::GaussianId{loss.at("id").get<std::uint32_t>()},
                              tile.is_null() ? Loss::whole : tile.get<std::uint32_t>(), Cause{number}});
        }
        auto const& ms = json.at("host_ms");
        for (auto const& [key, time] : std::initializer_list<std::pair<char const*, double*>>{{"project", &r.host_ms.project},
                                                                                               {"route", &r.host_ms.route},
                                                                                               {"bloom", &r.host_ms.bloom},
                                                                                               {"composite", &r.host_ms.composite},
                                                                                               {"picture", &r.host_ms.picture},
                                                                                               {"total", &r.host_ms.total}})
            ms.at(key).get_to(*time);
        if (json.contains("error")) frame.error = error(json.at("error"));
        if (json.contains("error_same_cuts")) frame.error_same_cuts = error(json.at("error_same_cuts"));
    } catch (nlohmann::json::exception const& why) {
        throw Error(std::string("a frame of a report cannot be read (") + why.what() + "); write the report again");
    }
    return frame;
}

/// Writes `json_of(run)` as UTF-8 text, whole or not at all. Bytes of a path that are no UTF-8 become U+FFFD. Throws
/// `tilemesh::Error` when the file cannot be written. Cost: memory for one frame's text at a time; a frame that lacks 100,000 copies
/// has 15 MB of it.
inline void write_json(std::filesystem::path const& path, RunReport const& run, Outlasts outlasts = Outlasts::process)
{
    auto const text_of = [](nlohmann::ordered_json const& json) {
        return json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    };
    detail::write_in_pieces(path, "the report", outlasts, [&](auto const& put) {
        auto head = text_of(detail::json_of_head(run));
        head.resize(head.size() - 2); // without "\n}"
        put(head);
        put(",\n \"frames\": [");
        for (auto const& frame : run.frames) {
            put(&frame == run.frames.data() ? "\n" : ",\n");
            put(text_of(detail::json_of(frame)));
        }
        put("\n ]\n}\n");
    });
}

} // namespace tilemesh::report
