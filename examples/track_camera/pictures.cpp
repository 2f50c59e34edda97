#include "pictures.hpp"
#include "../shared/checksums.hpp"
#include "../shared/picture_input.hpp"
#include "../shared/png.hpp"
#include "outputs.hpp"
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <new>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <utility>

namespace track_camera {

namespace fs = std::filesystem;
namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
using tilemesh::Error;

namespace {

/// Is a PNG grey with 16 bits? Its header has the bits at byte 24 and the kind of colour at byte 25, 0 for grey (PNG specification, 11.2.1).
bool is_grey_of_16_bits(fs::path const& path)
{
    std::array<char, 26> head{};
    errno = 0;
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> const file(std::fopen(path.c_str(), "rb"), std::fclose);
    if (!file && errno == ENOMEM) throw std::bad_alloc();
    if (!file) throw Error(path.string() + " cannot be opened (" + std::generic_category().message(errno) + "); make it readable, or use --no-depth");
    return std::fread(head.data(), 1, head.size(), file.get()) == head.size() && std::string_view(head.data() + 1, 3) == "PNG" && head[24] == 16 && head[25] == 0;
}
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

scene::Size size_of(scene::RgbdFrame const& frame)
{
    return shared::picture_size(frame.colour.file);
}

Photo read_photo(scene::RgbdFrame const& frame, scene::Size size, double levels)
{
    auto const require_size = [&](fs::path const& file) {
        if (auto const own = shared::picture_size(file); own.width != size.width || own.height != size.height)
            throw Error(file.string() + " has " + std::to_string(own.width) + " x " + std::to_string(own.height) + " pixels (the first picture has " + std::to_string(size.width) + " x " +
                        std::to_string(size.height) + ", and a depth has its picture's size); give pictures of one size");
    };
    require_size(frame.colour.file);
    Photo out{shared::read_picture(frame.colour.file, size, {}), {}};
    if (frame.depth.file.empty()) return out;
    require_size(frame.depth.file);
    if (!is_grey_of_16_bits(frame.depth.file)) throw Error(frame.depth.file.string() + " is no depth (depths are grey PNG files of 16 bits); convert it, or use --no-depth");
    auto const picture = shared::read_picture(frame.depth.file, size, {});
    out.depth = report::Plane(size.width, size.height);
    for (std::size_t i = 0; i < out.depth.values.size(); ++i) out.depth.values[i] = static_cast<float>(std::round(double{picture.rgb[3 * i]} * 65535.0) / levels);
    return out;
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
    std::array<char, 64> stamp{};
    std::snprintf(stamp.data(), stamp.size(), "%.6f", seconds);
    shared::write_png(folder_ / "rgb" / name, colour);
    report::write_whole(folder_ / "depth" / name, depth_png(depth, levels_));
    list_ += std::string(stamp.data()) + " rgb/" + name + " " + stamp.data() + " depth/" + name + "\n";
}

void PhotoWriter::finish(std::string const& truth_tum) const
{
    report::write_whole(folder_ / "associations.txt", list_);
    report::write_whole(folder_ / "groundtruth.txt", truth_tum);
}

} // namespace track_camera
