#pragma once
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/run_report.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// Reads back one entry of `frames` in report.json; `json_of` writes the same entry from the result. Digests and two error measures
/// are not in report.json: here they are empty or 0. Throws `tilemesh::Error` if a number is missing, has another type, or is too large.
inline RunFrame frame_of(nlohmann::ordered_json const& json)
{
    using Json = nlohmann::ordered_json;
    auto const error = [](Json const& from) {
        auto const number = [&](char const* key) {
            return from.at(key).is_null() ? std::numeric_limits<double>::infinity() : from.at(key).get<double>();
        };
        ErrorMeasures e{};
        e.rmse = number("rmse"), e.max_levels = number("max_levels"), e.p999_levels = number("p999_levels");
        e.psnr_db = number("psnr_db"), e.ssim = number("ssim");
        return e;
    };
    auto const comparison = [](Json const& from) {
        auto const text = [&](char const* key) { return from.at(key).is_null() ? std::string() : from.at(key).get<std::string>(); };
        Comparison other{from.at("file").get<std::string>(), text("problem"), {}, text("error")};
        if (!other.problem.empty()) return other;
        auto& m = other.measures;
        m.psnr_db = from.at("psnr_db").is_null() ? std::numeric_limits<double>::infinity() : from.at("psnr_db").get<double>();
        m.ssim = from.at("ssim").get<double>(), m.l1 = from.at("l1").get<double>(), m.largest = from.at("largest").get<double>();
        from.at("largest_at").get_to(m.largest_at);
        return other;
    };
    RunFrame frame;
    auto& r = frame.report;
    try {
        json.at("camera").get_to(r.camera);
        auto const& program = json.at("program").get_ref<std::string const&>();
        if (program != to_string(Program::anchored) && program != to_string(Program::homes))
            throw Error("a frame of a report has the program \"" + program + "\" (there are anchored and homes); write the report again");
        r.program = program == to_string(Program::homes) ? Program::homes : Program::anchored;
        json.at("grid").get_to(frame.grid);
        json.at("tile_px").get_to(frame.tile_px);
        if (json.contains("timestamp_s")) frame.timestamp_s = json.at("timestamp_s").get<double>();
        if (json.contains("intrinsics_px") || json.contains("world_to_camera")) {
            auto& view = frame.view.emplace();
            json.at("intrinsics_px").get_to(view.intrinsics_px);
            auto const rows = json.at("world_to_camera").get<std::array<std::array<double, 4>, 4>>();
            for (std::size_t i = 0; i < 16; ++i) view.world_to_camera[i] = rows[i / 4][i % 4];
            if (json.contains("rolling_shutter")) {
                auto const words = json.at("rolling_shutter").get<std::array<float, 6>>();
                for (std::size_t i = 0; i < 6; ++i) (i < 3 ? view.shutter.turn[i] : view.shutter.move[i - 3]) = words[i];
            }
            if (json.contains("lens")) {
                auto const& name = json.at("lens").get_ref<std::string const&>();
                std::size_t kind = 0;
                while (kind < std::size(splat::lens_names) && name != splat::lens_names[kind]) ++kind;
                if (kind == std::size(splat::lens_names))
                    throw Error("a frame of a report has the lens \"" + name + "\" (there are opencv, fisheye and fov); write the report again");
                view.lens.kind = static_cast<splat::LensKind>(kind);
                auto const coefficients = json.at("lens_coefficients").get<std::array<float, 8>>();
                for (std::size_t i = 0; i < 8; ++i) (i < 6 ? view.lens.k[i] : view.lens.p[i - 6]) = coefficients[i];
            }
        }
        frame.image = json.value("image", "");
        frame.depth = json.value("depth", "");
        frame.alpha = json.value("alpha", "");
        for (auto const& field : report_fields) {
            if (field.name == "lost" || field.group() == "losses") continue; // a list and its sums, below
            auto const group = std::string(field.group()), leaf = std::string(field.leaf());
            auto const& from = group.empty() ? json : json.at(group);
            auto const& value = group == "size_px" ? from.at(leaf == "width" ? 0u : 1u) : from.at(leaf);
            if (!field.exact()) {
                field.set_milliseconds(r, value.get<double>());
                continue;
            }
            auto const n = value.get<std::uint64_t>();
            field.set_count(r, n);
            if (field.count(r) != n)
                throw Error("a frame of a report has " + std::to_string(n) + " as " + std::string(field.name) +
                            " (a report holds 32 bits of it); write the report again");
        }
        for (auto const& loss : json.at("lost")) {
            auto const& cause = loss.at("cause").get_ref<std::string const&>();
            auto const& what = loss.at("what").get_ref<std::string const&>();
            auto const tile = loss.at("tile").is_null() ? Loss::whole : loss.at("tile").get<std::uint32_t>();
            std::uint32_t number = 0;
            while (number < causes && cause != to_string(Cause{number})) ++number;
            if (number == causes) throw Error("a frame of a report has the loss \"" + cause + "\" (there is no such cause); write the report again");
            if (what != "record" && what != "copy")
                throw Error("a frame of a report has lost a \"" + what + "\" (a loss is a record or a copy); write the report again");
            bool const whole = what == "record";
            r.lost.push_back({splat::GaussianId{loss.at("id").get<std::uint32_t>()}, whole ? Loss::whole : tile, Cause{number},
                              whole ? tile : Loss::whole});
        }
        if (json.contains("unfinished"))
            for (auto const& cut : json.at("unfinished")) r.unfinished.push_back({cut.at("tile").get<std::uint32_t>(), cut.at("depth").get<float>()});
        for (auto const& field : report_fields)
            if (field.group() == "losses" && json.at("losses").at(std::string(field.leaf())).get<std::uint64_t>() != field.count(r))
                throw Error("a frame of a report has other " + std::string(field.name) + " than its list `lost`; write the report again");
        if (json.contains("full_tiles")) {
            auto const& full = json.at("full_tiles");
            r.full_tiles = FullTiles{full.at("count").get<std::uint32_t>(), full.at("fullest").get<std::uint32_t>(),
                                     full.at("slots_needed").get<std::uint64_t>(), full.at("slots_available").get<std::uint64_t>()};
        }
        if (json.contains("modelled")) {
            auto const& modelled = json.at("modelled");
            frame.modelled = Modelled{modelled.at("cost_model").get<std::string>(), modelled.at("cycles").get<std::uint64_t>(),
                                      modelled.at("ms").get<double>()};
        }
        if (json.contains("error")) frame.error = error(json.at("error"));
        if (json.contains("error_same_cuts")) frame.error_same_cuts = error(json.at("error_same_cuts"));
        if (json.contains("photograph")) frame.photograph = comparison(json.at("photograph"));
        if (json.contains("compared")) frame.compared = comparison(json.at("compared"));
    } catch (nlohmann::json::exception const& why) {
        throw Error(std::string("a frame of a report cannot be read (") + why.what() + "); write the report again");
    }
    return frame;
}

}}} // namespace tilemesh::report
