#pragma once
#include "front.hpp"
#include "rows.hpp"
#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace error_vs_time {

/// The conditions of a run, so that it can be repeated.
struct Provenance {
    std::string compiler, cpu, git; ///< empty: not known
    std::string build, command;     ///< CMake's build type; the options of the run, without paths
    std::uint32_t threads = 1, rounds = 0;
    bool native = false;            ///< built for the processor it ran on (-march=native)
};

inline char const* to_string(Shape shape)
{
    constexpr char const* names[] = {"float32", "half_factor", "half_conic"};
    return names[static_cast<std::uint32_t>(shape)];
}
inline char const* to_string(Crossing crossing)
{
    return crossing == Crossing::blend ? "blend" : "drop";
}
inline char const* to_string(splat::Footprint footprint)
{
    return footprint == splat::Footprint::opacity_box         ? "opacity_box"
           : footprint == splat::Footprint::three_sigma_tiles ? "three_sigma_tiles"
                                                              : "three_sigma_square";
}
inline char const* to_string(splat::Arithmetic arithmetic)
{
    return arithmetic == splat::Arithmetic::precise ? "precise" : "fast";
}

namespace detail {

/// The shortest text that reads back as the same float.
inline std::string shortest(float value)
{
    std::array<char, 64> text{};
    auto const end = std::to_chars(text.data(), text.data() + text.size(), value);
    return {text.data(), end.ptr};
}
/// A field of RFC 4180.
inline std::string quoted(std::string const& text)
{
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string out = "\"";
    for (char const c : text) out += c == '"' ? "\"\"" : std::string(1, c);
    return out + "\"";
}

struct Field {
    char const* column;
    std::string text;
};

/// One row with the names of its columns, so that the header and the rows cannot differ.
inline std::vector<Field> fields_of(Row const& r, std::vector<Noise> const& noise, Provenance const& from)
{
    std::vector<Field> out;
    bool const ok = r.failed.empty();
    auto const text = [&](char const* column, std::string const& value) { out.push_back({column, quoted(value)}); };
    auto const setting = [&](char const* column, std::uint64_t value) { out.push_back({column, std::to_string(value)}); };
    auto const real = [&](char const* column, float value) { out.push_back({column, shortest(value)}); };
    auto const result = [&](char const* column, std::string value) { out.push_back({column, ok ? std::move(value) : "NaN"}); };
    auto const counter = [&](char const* column, std::uint64_t value) { result(column, std::to_string(value)); };
    auto const flag = [&](char const* column, bool value) { out.push_back({column, ok && value ? "1" : "0"}); };

    auto const times = band_of(r.host_ms, 0.2);
    auto const least = r.host_ms.empty() ? times.median : *std::min_element(r.host_ms.begin(), r.host_ms.end());
    auto const claim = claim_of(r, noise);
    auto const& c = r.counters;

    text("scene", r.scene);
    text("camera", r.camera);
    text("setting", r.setting.name);
    result("e_cut_rmse", scientific(r.cut.rmse, 4));
    result("e_round_rmse", scientific(r.round.rmse, 4));
    result("e_mesh_max", fixed(r.mesh.max_levels, 4));
    result("psnr_db", fixed(r.total.psnr_db, 3));
    result("ssim", fixed(r.total.ssim, 6));
    result("max_levels", fixed(r.total.max_levels, 4));
    result("modelled_ms", fixed(r.modelled_ms, 4));
    result("host_ms", fixed(times.median, 4));
    counter("pairs", c.pairs);
    flag("on_front", r.on_front);

    text("knob", r.setting.knob);
    setting("gaussians", r.gaussians);
    setting("width", r.size.width);
    setting("height", r.size.height);
    setting("frames", r.frames);
    auto const& rules = r.setting.rules;
    real("alpha_min", rules.alpha_min);
    real("alpha_max", rules.alpha_max);
    real("transmittance_min", rules.transmittance_min);
    real("dilation", rules.dilation);
    real("jacobian_limit", rules.jacobian_limit);
    text("footprint", to_string(rules.footprint));
    text("arithmetic", to_string(rules.arithmetic));
    auto const& knobs = r.setting.knobs;
    real("sigmas", knobs.sigmas);
    text("shape", to_string(knobs.shape));
    setting("key_bits", knobs.key_bits);
    setting("degree", knobs.degree);
    text("crossing", to_string(knobs.crossing));
    auto const& limits = r.setting.limits;
    text("saturation", limits.drop ? "drop" : "hold");
    setting("channel_slots", limits.channel_slots);
    setting("hops", limits.hops);
    setting("storage_slots", limits.storage_slots);

    result("rmse", scientific(r.total.rmse, 4));
    result("mae", scientific(r.total.mae, 4));
    result("p999_levels", fixed(r.total.p999_levels, 4));
    result("share_over_one_level", fixed(r.total.share_over_one_level, 6));
    auto const part = [&](auto const& columns, report::ErrorMeasures const& m) {
        result(columns[0], fixed(m.psnr_db, 3));
        result(columns[1], scientific(m.mae, 4));
        result(columns[2], fixed(m.p999_levels, 4));
        result(columns[3], fixed(m.ssim, 6));
        result(columns[4], fixed(m.share_over_one_level, 6));
    };
    static constexpr char const* of_cut[] = {"e_cut_psnr_db", "e_cut_mae", "e_cut_p999_levels", "e_cut_ssim", "e_cut_share_over_one_level"};
    static constexpr char const* of_round[] = {"e_round_psnr_db", "e_round_mae", "e_round_p999_levels", "e_round_ssim",
                                               "e_round_share_over_one_level"};
    static constexpr char const* of_mesh[] = {"e_mesh_psnr_db", "e_mesh_mae", "e_mesh_p999_levels", "e_mesh_ssim",
                                              "e_mesh_share_over_one_level"};
    result("e_cut_max", fixed(r.cut.max_levels, 4));
    part(of_cut, r.cut);
    result("e_round_max", fixed(r.round.max_levels, 4));
    part(of_round, r.round);
    result("e_mesh_rmse", scientific(r.mesh.rmse, 4));
    part(of_mesh, r.mesh);
    result("twice_products", scientific(r.twice_products, 4));
    result("split_off", scientific(r.split_off, 4));
    result("certified_levels", r.frames > 1 ? "NaN" : fixed(r.certified_levels + 5e-5, 4)); // rounded up
    result("popping_rmse", r.frames > 1 ? scientific(r.popping, 4) : "NaN");
    counter("lost", r.lost);
    counter("late", r.late);
    counter("unplaced", r.unplaced);

    counter("exchanges", c.exchanges.total());
    counter("messages", c.messages);
    counter("live_bytes", c.exchanged_live_bytes);
    counter("capacity_bytes", c.exchanged_capacity_bytes);
    counter("copies", c.copies);
    counter("peak_storage", c.peak_storage);
    counter("peak_channel", c.peak_channel);
    counter("pairs_contributing", c.pairs_contributing);
    counter("projected_bytes", r.projected_bytes);

    counter("host_rounds", r.host_ms.size());
    result("host_ms_min", fixed(least, 4));
    result("host_ms_p20", fixed(times.low, 4));
    result("host_ms_p80", fixed(times.high, 4));
    result("host_over_default", fixed(claim.ratio, 4));
    result("host_over_default_low", fixed(claim.low, 4));
    result("host_over_default_high", fixed(claim.high, 4));
    text("claim", to_string(claim));
    out.push_back({"aa_noise", fixed(noise_of(noise, r.scene), 4)});
    flag("on_front_modelled", r.on_front_modelled);
    result("front_pairs", fixed(r.front_pairs, 4));
    text("status", ok ? "ok" : r.failed);

    text("compiler", from.compiler);
    text("native", from.native ? "yes" : "no");
    text("cpu", from.cpu);
    setting("threads", from.threads);
    setting("rounds", from.rounds);
    text("seed", "none"); // the bench draws no random numbers
    text("git", from.git);
    text("build", from.build);
    text("command", from.command);
    text("tile", "32x20");
    text("program", limits.homes ? "homes" : "anchored");
    counter("homes_rounds", c.homes.rounds); // `rounds` are those of the bench's timing
    return out;
}

} // namespace detail

/// One line per row, in the given order, under a header. Format: RFC 4180 (text with a comma, a quote or a line break is quoted). The first
/// columns are
/// scene,camera,setting,e_cut_rmse,e_round_rmse,e_mesh_max,psnr_db,ssim,max_levels,modelled_ms,host_ms,pairs,on_front
/// (e_mesh_max and max_levels in levels, host_ms is the median). All knobs, measures, counters and costs follow. A row that failed shows
/// its setting; its results are NaN (on_front and on_front_modelled 0), and `status` says why it failed. The `status` of other rows is ok.
/// A value that a row cannot have (the popping of one frame, the host times of a sequence) is NaN. Noise that was not measured is inf.
inline std::string csv(std::vector<Row> const& rows, std::vector<Noise> const& noise, Provenance const& provenance)
{
    std::string out;
    auto const line = [&](std::vector<detail::Field> const& fields, auto const& text_of) {
        for (std::size_t i = 0; i < fields.size(); ++i) {
            if (i != 0) out += ',';
            out += text_of(fields[i]);
        }
        out += '\n';
    };
    line(detail::fields_of({}, {}, {}), [](detail::Field const& f) { return f.column; });
    for (auto const& row : rows)
        line(detail::fields_of(row, noise, provenance), [](detail::Field const& f) -> std::string const& { return f.text; });
    return out;
}

} // namespace error_vs_time
