#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <istream>
#include <limits>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/rgbd_list.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {
namespace detail {

TILEMESH_HOST std::vector<std::array<StampedFile, 2>> read_stamped_files(std::istream& stream, std::string const& name,
                                                                         std::size_t least_pairs, std::size_t most_pairs,
                                                                         std::string const& form)
{
    std::vector<std::array<StampedFile, 2>> out;
    std::size_t pairs = 0;
    LineReader lines(stream, name);
    while (lines.next()) {
        std::string_view text = lines.text();
        if (auto const first = text.find_first_not_of(blanks); first == std::string_view::npos || text[first] == '#') continue;
        auto const refuse = [&](std::string const& why) {
            throw Error(lines.place() + " is not a picture of a sequence (" + why + "); write " + form);
        };
        std::array<StampedFile, 2> row;
        std::size_t count = 0;
        for (std::string_view word = take_word(text); !word.empty(); word = take_word(text), ++count) {
            if (count >= 2 * most_pairs) refuse("it has more than " + std::to_string(2 * most_pairs) + " words; names with blanks are not read");
            auto& [seconds, file] = row[count / 2];
            if (count % 2 == 0) {
                if (!parse_number(word, seconds) || !(std::fabs(seconds) <= largest_number))
                    refuse("\"" + shown(word) + "\" is not a time in seconds");
            } else {
                if (!is_plain(word)) refuse("\"" + shown(word) + "\" is not a file name that can be printed");
                file = std::string(word);
            }
        }
        if (count % 2 != 0) refuse("its last time has no file");
        if (count / 2 < least_pairs || (pairs != 0 && count / 2 != pairs))
            refuse(std::to_string(count) + " words where " + std::to_string(2 * std::max(pairs, least_pairs)) + " are needed");
        pairs = count / 2;
        if (out.size() == most_poses) throw Error(name + " is too long (more than " + std::to_string(most_poses) + " pictures); split it");
        out.push_back(row);
    }
    if (out.empty()) throw Error(name + " lists no picture (every line is blank or a comment); write " + form);
    return out;
}

} // namespace detail

TILEMESH_HOST std::vector<std::string> rgbd_notes(std::vector<RgbdFrame> const& frames)
{
    std::size_t far = 0, furthest = 0;
    auto const apart = [&](std::size_t i) { return std::fabs(frames[i].colour.seconds - frames[i].depth.seconds); };
    for (std::size_t i = 0; i < frames.size(); ++i) {
        // Stamps are rounded: 0.02 s between stamps of 1.3e9 s are not exactly that in double.
        double const rounding = 1e-15 * std::fabs(frames[i].colour.seconds);
        if (frames[i].depth.file.empty() || apart(i) <= most_seconds_apart + rounding) continue;
        if (far++ == 0 || apart(i) > apart(furthest)) furthest = i;
    }
    if (far == 0) return {};
    return {"pictures whose depth is more than " + number_text(most_seconds_apart) + " s away: " + std::to_string(far) +
            ", the furthest is " + number_text(apart(furthest)) + " s away, of the picture at " +
            number_text(frames[furthest].colour.seconds)};
}

TILEMESH_HOST std::vector<StampedFile> read_file_list(std::istream& stream, std::string const& name)
{
    std::vector<StampedFile> out;
    for (auto& row : detail::read_stamped_files(stream, name, 1, 1, "timestamp file")) out.push_back(row[0]);
    std::stable_sort(out.begin(), out.end(), [](auto const& a, auto const& b) { return a.seconds < b.seconds; });
    return out;
}

TILEMESH_HOST std::vector<RgbdFrame> associate(std::vector<StampedFile> const& colour,
                                               std::vector<StampedFile> const& depth, double most_seconds)
{
    constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
    std::vector<std::size_t> nearest(colour.size(), none), winner(depth.size(), none);
    auto const apart = [&](std::size_t i, std::size_t k) { return std::fabs(colour[i].seconds - depth[k].seconds); };
    for (std::size_t i = 0; i < colour.size(); ++i) {
        auto const after = static_cast<std::size_t>(std::lower_bound(depth.begin(), depth.end(), colour[i].seconds,
                                                                     [](auto const& d, double t) { return d.seconds < t; }) - depth.begin());
        for (std::size_t const k : {after - 1, after}) // after - 1 wraps to a number that is no index
            if (k < depth.size() && apart(i, k) <= most_seconds && (nearest[i] == none || apart(i, k) < apart(i, nearest[i]))) nearest[i] = k;
        if (auto const k = nearest[i]; k != none && (winner[k] == none || apart(i, k) < apart(winner[k], k))) winner[k] = i;
    }
    std::vector<RgbdFrame> out;
    for (std::size_t i = 0; i < colour.size(); ++i)
        out.push_back({colour[i], nearest[i] != none && winner[nearest[i]] == i ? depth[nearest[i]] : StampedFile{}});
    return out;
}

TILEMESH_HOST std::vector<RgbdFrame> read_rgbd_list(std::istream& stream, std::string const& name)
{
    std::vector<RgbdFrame> out;
    for (auto& row : detail::read_stamped_files(stream, name, 1, 2, "timestamp rgb_file, or timestamp rgb_file timestamp depth_file"))
        out.push_back({row[0], row[1]});
    std::stable_sort(out.begin(), out.end(), [](auto const& a, auto const& b) { return a.colour.seconds < b.colour.seconds; });
    return out;
}

TILEMESH_HOST std::vector<RgbdFrame> load_rgbd(std::filesystem::path const& path)
{
    namespace fs = std::filesystem;
    std::error_code ignored;
    constexpr auto any_length = std::numeric_limits<std::uint64_t>::max();
    auto const there = [&](fs::path const& file) { return fs::exists(file, ignored); };
    auto const open = [&](fs::path const& file) { return detail::open_file(file, any_length, "a list of pictures"); };
    bool const folder = fs::is_directory(path, ignored);
    fs::path const root = folder ? path : path.parent_path(), association = folder ? path / "associations.txt" : path;
    std::vector<RgbdFrame> frames;
    if (!folder || there(association)) {
        auto stream = open(association);
        frames = read_rgbd_list(stream, detail::shown_path(association));
    } else {
        if (!there(path / "rgb.txt"))
            throw Error(detail::shown_path(path) + " is no sequence (it has neither associations.txt nor rgb.txt); name a folder of the TUM RGB-D "
                        "benchmark, or an association file");
        auto colour_stream = open(path / "rgb.txt");
        auto const colour = read_file_list(colour_stream, detail::shown_path(path / "rgb.txt"));
        std::vector<StampedFile> depth;
        if (there(path / "depth.txt")) {
            auto depth_stream = open(path / "depth.txt");
            depth = read_file_list(depth_stream, detail::shown_path(path / "depth.txt"));
        }
        frames = associate(colour, depth);
    }
    for (auto& [colour, depth, mask] : frames) {
        colour.file = root / colour.file;
        if (!depth.file.empty()) depth.file = root / depth.file;
    }
    return frames;
}

}}} // namespace tilemesh::scene
