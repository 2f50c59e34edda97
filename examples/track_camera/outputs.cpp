#include "outputs.hpp"
#include "../shared/checksums.hpp"
#include "../shared/output_files.hpp"
#include "../shared/png.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/distinct_files.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <unistd.h>
#include <utility>

namespace track_camera {

namespace fs = std::filesystem;
namespace report = tilemesh::report;

namespace {

template <std::size_t N>
bool is_one_of(char const* const (&names)[N], std::string const& name)
{
    return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

/// Is it the `photo_file` of one of the first `frames` frames? A number has six digits or more.
bool is_photo(std::string const& name, std::size_t frames)
{
    std::size_t frame = 0;
    for (auto const c : name.substr(0, name.find('.'))) {
        if (c < '0' || c > '9' || frame >= frames) return false;
        frame = 10 * frame + static_cast<std::size_t>(c - '0');
    }
    return frame < frames && name == photo_file(frame);
}

constexpr char const *out_remedy = "name another directory with --out", *report_remedy = "name another file with --report",
                     *photos_remedy = "name another directory with --save-photos";

void put_word(std::string& to, std::uint32_t word)
{
    for (int shift = 24; shift >= 0; shift -= 8) to.push_back(static_cast<char>(word >> shift & 0xffu));
}
/// A chunk of a PNG: its length, name and bytes, and their CRC-32 (PNG specification, 5.3).
void put_chunk(std::string& to, std::string_view name, std::string_view bytes)
{
    put_word(to, static_cast<std::uint32_t>(bytes.size()));
    auto const first = to.size();
    to.append(name).append(bytes);
    put_word(to, shared::crc32(std::string_view(to).substr(first)));
}
/// Bytes as a zlib stream of stored blocks (RFC 1950 and 1951).
std::string stored(std::string_view bytes)
{
    std::string out{'\x78', '\x01'};
    shared::Adler32 sum;
    sum.add(bytes);
    do {
        auto const block = bytes.substr(0, 65535);
        bytes.remove_prefix(block.size());
        auto const size = static_cast<std::uint32_t>(block.size());
        for (std::uint32_t const byte : {bytes.empty() ? 1u : 0u, size & 0xffu, size >> 8, ~size & 0xffu, ~size >> 8 & 0xffu}) out.push_back(static_cast<char>(byte));
        out.append(block);
    } while (!bytes.empty());
    put_word(out, sum.value());
    return out;
}

} // namespace

std::string photo_file(std::size_t frame)
{
    std::array<char, 64> name{};
    std::snprintf(name.data(), name.size(), "%06zu.png", frame);
    return name.data();
}

void prepare_outputs(Options const& options, std::vector<fs::path> const& read, std::size_t frames)
{
    shared::make_folder(options.out, "--out");
    for (char const* const name : out_files) shared::check_file(options.out / name, "a result", out_remedy);
    if (options.report) shared::check_file(*options.report, "the report", report_remedy);
    if (options.save_photos) {
        for (auto const& folder : {*options.save_photos, *options.save_photos / "rgb", *options.save_photos / "depth"}) shared::make_folder(folder, "--save-photos");
        for (char const* const name : photo_lists) shared::check_file(*options.save_photos / name, "a list", photos_remedy);
        for (char const* const part : {"rgb", "depth"}) shared::check_file(*options.save_photos / part / photo_file(0), "a picture", photos_remedy);
    }

    report::DistinctFiles files;
    for (auto const& file : read) files.read(file);
    if (!options.quiet) files.write_stream(STDOUT_FILENO, "standard output", "send it to another file, or use --quiet");
    files.write_stream(STDERR_FILENO, "standard error", "send it to another file");
    files.write_into(
        options.out, [](std::string const& name) { return is_one_of(out_files, name); }, "a result", out_remedy);
    if (options.save_photos) {
        files.write_into(
            *options.save_photos, [](std::string const& name) { return is_one_of(photo_lists, name); }, "a list", photos_remedy);
        if (std::error_code none; fs::equivalent(*options.save_photos / "rgb", *options.save_photos / "depth", none))
            throw tilemesh::Error("cannot write pictures to " + options.save_photos->string() + " (its folders rgb and depth are one); " + photos_remedy);
        for (char const* const part : {"rgb", "depth"})
            files.write_into(
                *options.save_photos / part, [frames](std::string const& name) { return is_photo(name, frames); }, "a picture", photos_remedy);
    }
    if (options.report) files.write(*options.report, "the report", report_remedy);
}

std::string depth_png(report::Plane const& depth, double levels)
{
    std::string rows;
    rows.reserve((2 * std::size_t{depth.width} + 1) * depth.height);
    for (std::uint32_t y = 0; y < depth.height; ++y) {
        rows.push_back('\0'); // no filter
        for (std::uint32_t x = 0; x < depth.width; ++x) {
            double const level = std::round(double{depth.at(x, y)} * levels);
            auto const word = level >= 1.0 && level <= 65535.0 ? static_cast<std::uint32_t>(level) : 0u;
            rows.push_back(static_cast<char>(word >> 8));
            rows.push_back(static_cast<char>(word & 0xffu));
        }
    }
    std::string png("\x89PNG\r\n\x1a\n", 8), head;
    put_word(head, depth.width);
    put_word(head, depth.height);
    head.append({16, 0, 0, 0, 0}); // bits, grey, and the only ways of compression, filters and order
    put_chunk(png, "IHDR", head);
    put_chunk(png, "IDAT", stored(rows));
    put_chunk(png, "IEND", {});
    return png;
}

PhotoWriter::PhotoWriter(fs::path folder, double levels) : folder_(std::move(folder)), levels_(levels) {}

void PhotoWriter::write(double seconds, report::Image const& colour, report::Plane const& depth)
{
    auto const name = photo_file(written_++);
    auto const stamp = tilemesh::decimals(seconds, 6);
    shared::write_png(folder_ / "rgb" / name, colour);
    report::write_whole(folder_ / "depth" / name, depth_png(depth, levels_));
    list_ += stamp + " rgb/" + name + " " + stamp + " depth/" + name + "\n";
}

void PhotoWriter::finish(std::string const& truth_tum) const
{
    report::write_whole(folder_ / "associations.txt", list_);
    report::write_whole(folder_ / "groundtruth.txt", truth_tum);
}

} // namespace track_camera
