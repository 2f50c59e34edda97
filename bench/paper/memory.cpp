#include "tables.hpp"
#include <common/statistics.hpp>
#include <iterator>
#include <string>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/splat/setup_types.hpp>

namespace paper {

namespace {

namespace splat = tilemesh::splat;

constexpr double record_bytes = sizeof(splat::Gaussian);
/// The paper's KB has 1,000 bytes: with these its shares are reproduced, with 1,024 they are not.
constexpr double buffer_bytes = 192'000, buffer_kibibytes = 192 * 1024;

struct Rules {
    char const* name;
    double gaussians;
    char const* source;
    std::optional<double> megabytes, share_percent; ///< the paper's figures
};
constexpr Rules models[] = {
    {"Sloth", 25'161, "the paper's text", 1.5, 12.7},   {"Salad", 38'000, "the paper's \"38K\"; the authors' file has 37,941", {}, {}},
    {"Chairs", 44'000, "the paper's \"44K\"", {}, {}},  {"Pringles", 91'450, "the paper's text", {}, {}},
    {"Bonsai", 272'956, "the paper's text", 16.4, 1.2},
};

/// Draws bars of megabytes, and a line for the share that one tile's buffer holds, as in the paper's figure.
std::string bars()
{
    using bench::fixed;
    constexpr double width = 640, height = 360, left = 60, right = 60, top = 40, bottom = 60;
    double const area_width = width - left - right, area_height = height - top - bottom;
    double const most_megabytes = 18, most_percent = 14;
    auto const text = [](double x, double y, std::string const& anchor, std::string const& what, std::string const& more = {}) {
        return "<text x=\"" + fixed(x, 1) + "\" y=\"" + fixed(y, 1) + "\" text-anchor=\"" + anchor + "\"" + more + ">" + what + "</text>\n";
    };
    std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"640\" height=\"360\" viewBox=\"0 0 640 360\" "
                      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"640\" height=\"360\" fill=\"#ffffff\"/>\n";
    out += text(width / 2, 20, "middle", "Bytes of a model (bars), and the share of it that 192 KB hold (line)", " font-size=\"15\"");
    std::string line, dots;
    std::size_t i = 0;
    for (auto const& m : models) {
        double const megabytes = m.gaussians * record_bytes / 1e6, percent = 100 * buffer_bytes / (m.gaussians * record_bytes);
        double const middle = left + area_width * (static_cast<double>(i++) + 0.5) / std::size(models);
        double const bar = area_height * megabytes / most_megabytes, at = height - bottom - area_height * percent / most_percent;
        out += "<rect x=\"" + fixed(middle - 28, 1) + "\" y=\"" + fixed(height - bottom - bar, 1) + "\" width=\"56\" height=\"" + fixed(bar, 1) +
               "\" fill=\"#56b4e9\"/>\n";
        out += text(middle, height - bottom - bar - 6, "middle", fixed(megabytes, 1) + " MB");
        out += text(middle, height - bottom + 18, "middle", m.name);
        line += (line.empty() ? "M" : "L") + fixed(middle, 1) + " " + fixed(at, 1);
        dots += "<circle cx=\"" + fixed(middle, 1) + "\" cy=\"" + fixed(at, 1) + "\" r=\"3.5\"/>";
        out += text(middle + 32, at + 4, "start", fixed(percent, 1) + " %", " fill=\"#d55e00\"");
    }
    out += "<path d=\"" + line + "\" fill=\"none\" stroke=\"#d55e00\" stroke-width=\"1.8\"/>\n<g fill=\"#d55e00\">" + dots + "</g>\n";
    out += "<path d=\"M" + fixed(left, 1) + " " + fixed(height - bottom, 1) + "h" + fixed(area_width, 1) + "\" stroke=\"#000000\"/>\n";
    return out + "</svg>\n";
}

void add_ledger(tilemesh::render::Setup const& setup, Rows& rows)
{
    std::string const name = std::string("a tile of our ") + setup.name;
    bool const is_paper = std::string(setup.name) == "paper";
    std::uint64_t outside = 0;
    for (auto const& region : tilemesh::render::ledger_of(setup)) {
        std::string what(region.name.text, region.name.size);
        std::erase_if(what, [](char c) { return c == '(' || c == ')'; }); // `waiting (side 0)`: a CSV name keeps only units in brackets
        if (!region.budgeted) {
            outside += region.bytes;
            continue;
        }
        if (region.bytes == 0) continue;
        std::optional<double> paper;
        std::string note = region.what;
        if (is_paper && what == "storage") paper = buffer_bytes, note += "; the paper's about 192 KB";
        if (is_paper && what == "road") paper = buffer_bytes, note += "; the paper's about 192 KB; bloom's channels lie in the same memory";
        if (is_paper && what == "framebuffer") paper = 2560, note += "; the paper's 2.5 KB";
        if (what == "code and stacks") note += "; \"~130 KB\" in a comment of the authors' code";
        rows.push_back({"memory", name, what + " (B)", paper, static_cast<double>(region.bytes), "arithmetic", note});
    }
    rows.push_back({"memory",
                    name,
                    "sum (B)",
                    {},
                    static_cast<double>(tilemesh::render::sram_bytes_of(setup)),
                    "arithmetic",
                    "a tile has " + std::to_string(setup.machine.sram_bytes)});
    if (outside != 0)
        rows.push_back({"memory",
                        name,
                        "outside the budget (B)",
                        {},
                        static_cast<double>(outside),
                        "arithmetic",
                        "lists that our kernels keep and the paper's budget leaves out"});
}

} // namespace

void memory(Context const& context, Rows& rows)
{
    auto const add = [&](char const* row, char const* quantity, std::optional<double> paper, double ours, std::string const& note = {}) {
        rows.push_back({"memory", row, quantity, paper, ours, "arithmetic", note});
    };
    add("a Gaussian", "bytes", 60.0, record_bytes);
    for (auto const& m : models) {
        auto const bytes = m.gaussians * record_bytes;
        add(m.name, "model (MB)", m.megabytes, bytes / 1e6, m.source);
        add(m.name, "share in 192 KB of a tile (%)", m.share_percent, 100 * buffer_bytes / bytes,
            "KB of 1,000 bytes; of 1,024 it is " + bench::fixed(100 * buffer_kibibytes / bytes, 2));
    }
    // The capacities of the authors' public code: it steps through floats by a count of bytes, so a slot is 4 records long.
    constexpr double channel_bytes = 24'000, stride = 4 * record_bytes;
    add("a channel", "slots, 60 bytes each", 400.0, channel_bytes / record_bytes, "24,000 bytes, packed");
    add("a channel", "slots, as the authors' code strides", 400.0, channel_bytes / stride,
        "240 bytes a slot: a byte count taken as a count of floats");
    add("storage", "slots, 60 bytes each", 3200.0, buffer_bytes / record_bytes, "192,000 bytes, packed");
    add("storage", "slots, as the authors' code strides", 3200.0, buffer_bytes / stride, "240 bytes a slot");
    add("eight channels", "bytes", 192'000.0, 8 * channel_bytes, "four sides, in and out");
    add("channels and storage", "bytes", 400'000.0, 8 * channel_bytes + buffer_bytes, "\"roughly 400 KB remains for scene data\"");
    add_ledger(tilemesh::splat::setup_of<splat::Paper>(), rows);
    add_ledger(tilemesh::splat::setup_of<splat::Lossless>(), rows);
    if (!context.out.empty()) tilemesh::report::write_whole(context.out / "memory.svg", bars());
}

} // namespace paper
