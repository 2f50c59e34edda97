#include "rgbd_photo.hpp"
#include "depth_bytes.hpp"
#include "photographs_of.hpp"
#include "picture_input.hpp"
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <new>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <vector>

namespace shared {

namespace fs = std::filesystem;
namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
using tilemesh::Error;

namespace {

/// Is a PNG grey with 16 bits? Its header has the bits at byte 24 and the kind of colour at byte 25, 0 for grey (PNG specification, 11.2.1).
bool is_grey_of_16_bits(fs::path const& path, std::string const& or_else)
{
    std::array<char, 26> head{};
    errno = 0;
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> const file(std::fopen(path.c_str(), "rb"), std::fclose);
    if (!file && errno == ENOMEM) throw std::bad_alloc();
    if (!file)
        throw Error(path.string() + " cannot be opened (" + std::generic_category().message(errno) + "); make it readable" + or_else);
    return std::fread(head.data(), 1, head.size(), file.get()) == head.size() && std::string_view(head.data() + 1, 3) == "PNG" &&
           head[24] == 16 && head[25] == 0;
}

} // namespace

std::vector<fs::path> pictures_of(std::vector<scene::RgbdFrame> const& list)
{
    std::vector<fs::path> out;
    for (auto const& frame : list) out.push_back(frame.colour.file);
    return out;
}

scene::Size size_of(scene::RgbdFrame const& frame)
{
    return picture_size(frame.colour.file);
}

RgbdPhoto read_photo(scene::RgbdFrame const& frame, scene::Size size, double levels, std::string const& or_else)
{
    auto const require_size = [&](fs::path const& file) {
        if (auto const own = picture_size(file); !same(own, size))
            throw Error(file.string() + " has " + by(own) + " pixels (the first picture has " + by(size) +
                        ", and a depth has its picture's size); give pictures of one size");
    };
    require_size(frame.colour.file);
    RgbdPhoto out{read_picture(frame.colour.file, size, no_background), {}};
    if (std::all_of(out.colour.rgb.begin(), out.colour.rgb.end(), [](float value) { return std::isnan(value); }))
        throw Error(frame.colour.file.string() + " shows nothing (no pixel of it is opaque); write it without an alpha channel");
    apply_mask(out.colour, frame.mask);
    if (frame.depth.file.empty()) return out;
    require_size(frame.depth.file);
    if (!is_grey_of_16_bits(frame.depth.file, or_else))
        throw Error(frame.depth.file.string() + " is no depth (depths are grey PNG files of 16 bits); convert it" + or_else);
    auto const picture = read_picture(frame.depth.file, size, {});
    std::vector<std::uint16_t> written;
    for (std::size_t i = 0; i < picture.rgb.size(); i += 3)
        written.push_back(static_cast<std::uint16_t>(std::lround(double{picture.rgb[i]} * 65535.0)));
    if (has_swapped_bytes(written, size.width))
        throw Error(frame.depth.file.string() +
                    " has depths whose two bytes are swapped (swapped back, neighbours are near each other); write 16 bits with the "
                    "high byte first" +
                    or_else);
    out.depth = report::Plane(size.width, size.height);
    for (std::size_t i = 0; i < written.size(); ++i)
        out.depth.values[i] = std::isnan(out.colour.rgb[3 * i]) || written[i] == 65535 ? 0.0f : static_cast<float>(written[i] / levels);
    return out;
}

} // namespace shared
