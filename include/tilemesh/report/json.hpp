#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/run_report.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

namespace detail {

/// Writes JSON text as nlohmann-json prints it with an indent of one blank. It builds no nlohmann-json document, because the destructor
/// of a document allocates: without memory, that would end the process.
class JsonText {
public:
    template <class T>
    void value(T const& scalar)
    {
        text_ += nlohmann::ordered_json(scalar).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    }
    /// A number, or null where JSON has none: the PSNR of equal pictures is infinite.
    void finite(double number)
    {
        if (std::isfinite(number)) value(number);
        else value(nullptr);
    }
    /// Starts the next item of an array; write its value next.
    void item()
    {
        text_ += first_ ? "\n" : ",\n";
        text_.append(depth_, ' ');
        first_ = false;
    }
    /// Starts the next member of an object; write its value next.
    void key(std::string_view name)
    {
        item();
        value(name);
        text_ += ": ";
    }
    template <class T>
    void member(std::string_view name, T const& scalar)
    {
        key(name);
        value(scalar);
    }
    /// Writes an object; `write()` writes its members.
    template <class Write>
    void object(Write const& write)
    {
        nest('{', '}', write);
    }
    template <class Write>
    void array(Write const& write)
    {
        nest('[', ']', write);
    }
    template <class Scalars>
    void list(std::string_view name, Scalars const& scalars)
    {
        key(name);
        array([&] {
            for (auto const& scalar : scalars) {
                item();
                value(scalar);
            }
        });
    }
    std::string const& text() const noexcept { return text_; }

private:
    template <class Write>
    void nest(char open, char close, Write const& write)
    {
        text_ += open;
        ++depth_;
        first_ = true;
        write();
        --depth_;
        if (!first_) {
            text_ += '\n';
            text_.append(depth_, ' ');
        }
        first_ = false; // the item around it
        text_ += close;
    }
    std::string text_;
    std::size_t depth_ = 0;
    bool first_ = true; ///< the innermost array or object is still empty
};

inline void write(JsonText& json, ErrorMeasures const& e)
{
    json.object([&] {
        for (auto const& [name, value] : {std::pair("rmse", e.rmse), std::pair("max_levels", e.max_levels), std::pair("p999_levels", e.p999_levels),
                                          std::pair("psnr_db", e.psnr_db), std::pair("ssim", e.ssim)}) {
            json.key(name);
            json.finite(value);
        }
    });
}

inline void write(JsonText& json, Loss const& loss)
{
    json.object([&] {
        json.member("id", static_cast<std::uint32_t>(loss.id));
        json.member("cause", to_string(loss.cause));
        json.key("tile");
        if (loss.tile != Loss::whole) json.value(loss.tile);
        else json.value(nullptr);
    });
}

inline void write(JsonText& json, ReportField const& field, std::string_view name, FrameReport const& r)
{
    json.key(name);
    if (field.name == "lost")
        json.array([&] {
            for (auto const& loss : r.lost) {
                json.item();
                write(json, loss);
            }
        });
    else if (field.exact()) json.value(field.count(r));
    else json.value(field.milliseconds(r));
}

inline std::string text_of(RunFrame const& frame)
{
    JsonText json;
    auto const& r = frame.report;
    json.object([&] {
        json.member("camera", r.camera);
        json.list("size_px", std::array{r.width, r.height});
        json.list("grid", frame.grid);
        json.list("tile_px", frame.tile_px);
        if (!frame.image.empty()) json.member("image", frame.image);
        if (!frame.depth.empty()) json.member("depth", frame.depth);
        if (!frame.alpha.empty()) json.member("alpha", frame.alpha);
        for (auto const* field = std::begin(report_fields); field != std::end(report_fields); ++field) {
            auto const group = field->group();
            if (group == "size_px") continue; // an array, above
            if (group.empty()) {
                write(json, *field, field->name, r);
                continue;
            }
            auto const of_group = [&](auto const& other) { return other.group() == group; };
            if (std::find_if(std::begin(report_fields), field, of_group) != field) continue; // written with the first of its group
            json.key(group);
            json.object([&] {
                for (auto const& other : report_fields)
                    if (of_group(other)) write(json, other, other.leaf(), r);
            });
        }
        if (frame.error) {
            json.key("error");
            write(json, *frame.error);
        }
        if (frame.error_same_cuts) {
            json.key("error_same_cuts");
            write(json, *frame.error_same_cuts);
        }
    });
    return json.text();
}

inline void write(JsonText& json, std::vector<Region> const& ledger)
{
    json.array([&] {
        for (auto const& region : ledger) {
            json.item();
            json.object([&] {
                json.member("region", std::string_view(region.name.text, region.name.size));
                json.member("bytes", region.bytes);
                json.member("what", region.what);
                json.member("budgeted", region.budgeted);
            });
        }
    });
}

inline void write_machine(JsonText& json, RunReport const& run)
{
    auto const size = [&](std::string_view name, auto const& of_first) {
        if (run.frames.empty()) json.member(name, nullptr);
        else json.list(name, of_first(run.frames.front()));
    };
    std::uint64_t budgeted = 0, outside = 0;
    for (auto const& region : run.machine.ledger) (region.budgeted ? budgeted : outside) += region.bytes;
    json.object([&] {
        json.member("name", run.machine.name);
        size("grid", [](RunFrame const& frame) { return frame.grid; });
        size("tile_px", [](RunFrame const& frame) { return frame.tile_px; });
        json.member("sram_bytes", run.machine.sram_bytes);
        json.member("storage_slots", run.machine.storage_slots);
        json.member("channel_slots", run.machine.channel_slots);
        json.member("budgeted_bytes", budgeted);
        json.key("ledger");
        write(json, run.machine.ledger);
        if (outside != 0)
            json.member("note", "regions with budgeted = false, " + std::to_string(outside) +
                                    " bytes, are lists that our kernels keep and that the budget of preset " + run.preset +
                                    " has no room for");
    });
}

/// report.json without its frames.
inline std::string text_of_head(RunReport const& run)
{
    JsonText json;
    json.object([&] {
        json.key("map");
        json.object([&] {
            json.member("name", run.map.name);
            json.key("path");
            if (run.map.path.empty()) json.value(nullptr);
            else json.value(run.map.path);
            json.member("gaussians", run.map.gaussians);
            json.member("rejected", run.map.rejected);
            json.list("notes", run.map.notes);
        });
        json.key("machine");
        write_machine(json, run);
        json.member("preset", run.preset);
        json.key("policies");
        json.object([&] {
            auto const& p = run.policies;
            json.member("routing", p.routing);
            json.member("addressing", p.addressing);
            json.member("saturation", p.saturation);
            json.member("footprint", p.footprint);
            json.member("copies", p.copies);
            json.member("pixels", p.pixels);
            json.member("arithmetic", p.arithmetic);
            json.key("hops");
            if (p.hops == 0) json.value("quiet");
            else json.value(p.hops);
        });
        json.member("quality", run.quality);
        json.key("cut_offs");
        json.object([&] {
            for (auto const& [name, value] : {std::pair("alpha_min", run.cut_offs.alpha_min),
                                              std::pair("transmittance_min", run.cut_offs.transmittance_min),
                                              std::pair("alpha_max", run.cut_offs.alpha_max)}) {
                json.key(name);
                json.finite(double{value});
            }
        });
        json.key("features");
        json.array([&] {
            for (auto const& feature : run.features) {
                json.item();
                json.object([&] {
                    json.member("feature", feature.name);
                    json.member("kept", feature.kept);
                    json.member("why", feature.why);
                });
            }
        });
        json.member("engine", run.engine);
        json.member("threads", run.threads);
        if (!run.made_from.version.empty()) {
            json.key("made_from");
            json.object([&] {
                json.member("version", run.made_from.version);
                json.list("options", run.made_from.options);
                json.key("files");
                json.array([&] {
                    for (auto const& file : run.made_from.files) {
                        json.item();
                        json.object([&] {
                            json.member("path", file.path);
                            json.member("bytes", file.bytes);
                            json.member("digest", file.digest);
                        });
                    }
                });
            });
        }
        json.list("notes", run.notes);
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

/// report.json of a run, keys in a fixed order. Null stands for the PSNR of two equal pictures (it is infinite), for the tile
/// of a loss that is the record itself, and for the path of a map without a file.
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
    RunFrame frame;
    auto& r = frame.report;
    try {
        json.at("camera").get_to(r.camera);
        json.at("grid").get_to(frame.grid);
        json.at("tile_px").get_to(frame.tile_px);
        frame.image = json.value("image", "");
        frame.depth = json.value("depth", "");
        frame.alpha = json.value("alpha", "");
        for (auto const& field : report_fields) {
            if (field.name == "lost") continue; // a list, below
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
            auto const& tile = loss.at("tile");
            std::uint32_t number = 0;
            while (number < causes && cause != to_string(Cause{number})) ++number;
            if (number == causes) throw Error("a frame of a report has the loss \"" + cause + "\" (there is no such cause); write the report again");
            r.lost.push_back({splat::GaussianId{loss.at("id").get<std::uint32_t>()},
                              tile.is_null() ? Loss::whole : tile.get<std::uint32_t>(), Cause{number}});
        }
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
    detail::write_in_pieces(path, "the report", outlasts, [&](auto const& put) { detail::put_json(run, put); });
}

}}} // namespace tilemesh::report
