#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/rgbd_list.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace scene {
namespace detail {

/// Reads the lines of a list: pairs of a stamp and a file name, as many on each line as on the first, one or two. Each column of stamps has the
/// unit that `seconds_per_unit` finds. A unit other than seconds is a line in `notes`, which may be null, and so are whole seconds more than 1 apart.
inline std::vector<std::array<StampedFile, 2>> read_stamped_files(std::istream& stream, std::string const& name, std::size_t least_pairs,
                                                                  std::size_t most_pairs, std::string const& form, std::vector<std::string>* notes)
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
                file = with_slashes(word);
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
    for (std::size_t i = 0; i < pairs; ++i) {
        std::vector<double> stamps;
        for (auto const& row : out) stamps.push_back(row[i].seconds);
        auto const [first, last] = std::minmax_element(stamps.begin(), stamps.end());
        bool const whole = std::all_of(stamps.begin(), stamps.end(), [](double stamp) { return stamp == std::floor(stamp); });
        bool const far_apart = whole && *last - *first > static_cast<double>(stamps.size() - 1); // seconds, or milliseconds of no date
        double const unit = seconds_per_unit(std::move(stamps));
        if (unit == 1.0 && !far_apart) continue;
        for (auto& row : out) row[i].seconds *= unit;
        auto const note = (unit == 1.0 ? "whole time stamps are read as " : "time stamps are read as ") + unit_name(unit);
        if (notes != nullptr && std::find(notes->begin(), notes->end(), note) == notes->end()) notes->push_back(note);
    }
    return out;
}

/// Stamps are rounded: 0.02 s between stamps of 1.3e9 s are not exactly that in double.
inline double rounding_of_stamps(double seconds)
{
    return 1e-15 * std::fabs(seconds);
}

/// The notes on how many pictures have a depth, and on those that are more than `most_seconds` away from it.
TILEMESH_HOST void add_depth_notes(std::vector<RgbdFrame> const& frames, double most_seconds, std::vector<std::string>& notes)
{
    std::size_t with_depth = 0, far = 0, furthest = 0;
    auto const apart = [&](std::size_t i) { return std::fabs(frames[i].colour.seconds - frames[i].depth.seconds); };
    for (std::size_t i = 0; i < frames.size(); ++i) {
        if (frames[i].depth.file.empty()) continue;
        ++with_depth;
        if (apart(i) <= most_seconds + rounding_of_stamps(frames[i].colour.seconds)) continue;
        if (far++ == 0 || apart(i) > apart(furthest)) furthest = i;
    }
    if (with_depth < frames.size()) notes.push_back(std::to_string(with_depth) + " of " + std::to_string(frames.size()) + " pictures have a depth");
    if (far != 0)
        notes.push_back("pictures whose depth is more than " + number_text(most_seconds) + " s away: " + std::to_string(far) + ", the furthest is " +
                        number_text(apart(furthest)) + " s away, of the picture at " + number_text(frames[furthest].colour.seconds));
}

} // namespace detail

TILEMESH_HOST std::vector<StampedFile> read_file_list(std::istream& stream, std::string const& name, std::vector<std::string>* notes)
{
    std::vector<StampedFile> out;
    for (auto& row : detail::read_stamped_files(stream, name, 1, 1, "timestamp file", notes)) out.push_back(row[0]);
    std::stable_sort(out.begin(), out.end(), [](auto const& a, auto const& b) { return a.seconds < b.seconds; });
    return out;
}

TILEMESH_HOST std::vector<RgbdFrame> associate(std::vector<StampedFile> const& colour, std::vector<StampedFile> const& depth, double most_seconds)
{
    constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
    std::vector<std::size_t> nearest(colour.size(), none), winner(depth.size(), none);
    auto const apart = [&](std::size_t i, std::size_t k) { return std::fabs(colour[i].seconds - depth[k].seconds); };
    for (std::size_t i = 0; i < colour.size(); ++i) {
        auto const after = static_cast<std::size_t>(std::lower_bound(depth.begin(), depth.end(), colour[i].seconds,
                                                                     [](auto const& d, double t) { return d.seconds < t; }) - depth.begin());
        for (std::size_t const k : {after - 1, after}) // after - 1 wraps to a number that is no index
            if (k < depth.size() && apart(i, k) <= most_seconds + detail::rounding_of_stamps(colour[i].seconds) &&
                (nearest[i] == none || apart(i, k) < apart(i, nearest[i]))) nearest[i] = k;
        if (auto const k = nearest[i]; k != none && (winner[k] == none || apart(i, k) < apart(winner[k], k))) winner[k] = i;
    }
    std::vector<RgbdFrame> out;
    for (std::size_t i = 0; i < colour.size(); ++i)
        out.push_back({colour[i], nearest[i] != none && winner[nearest[i]] == i ? depth[nearest[i]] : StampedFile{}});
    return out;
}

TILEMESH_HOST std::vector<RgbdFrame> read_rgbd_list(std::istream& stream, std::string const& name, std::vector<std::string>* notes)
{
    std::vector<RgbdFrame> out;
    for (auto& row : detail::read_stamped_files(stream, name, 1, 2, "timestamp rgb_file, or timestamp rgb_file timestamp depth_file", notes))
        out.push_back({row[0], row[1]});
    std::stable_sort(out.begin(), out.end(), [](auto const& a, auto const& b) { return a.colour.seconds < b.colour.seconds; });
    return out;
}

TILEMESH_HOST std::vector<RgbdFrame> load_rgbd(std::filesystem::path const& path, std::optional<double> depth_within, std::vector<std::string>* notes)
{
    namespace fs = std::filesystem;
    std::error_code ignored;
    auto const there = [&](fs::path const& file) { return fs::exists(file, ignored); };
    auto const read = [&](auto const& reader, fs::path const& file) {
        auto stream = detail::open_file(file, std::numeric_limits<std::uint64_t>::max(), "a list of pictures");
        return reader(stream, detail::shown_path(file), notes);
    };
    bool const folder = fs::is_directory(path, ignored);
    fs::path const root = folder ? path : path.parent_path(), association = folder ? path / "associations.txt" : path;
    std::vector<RgbdFrame> frames;
    if (!folder || there(association)) {
        frames = read(read_rgbd_list, association);
    } else {
        if (!there(path / "rgb.txt"))
            throw Error(detail::shown_path(path) + " is no sequence (it has neither associations.txt nor rgb.txt); name a folder of the TUM RGB-D "
                        "benchmark, or an association file");
        auto const colour = read(read_file_list, path / "rgb.txt");
        std::vector<StampedFile> depth;
        if (depth_within && there(path / "depth.txt")) depth = read(read_file_list, path / "depth.txt");
        frames = associate(colour, depth, depth_within.value_or(0.0));
        auto const has_depth = [](RgbdFrame const& frame) { return !frame.depth.file.empty(); };
        if (!depth.empty() && std::none_of(frames.begin(), frames.end(), has_depth)) {
            double nearest = std::numeric_limits<double>::infinity();
            for (auto const& frame : associate(colour, depth, nearest))
                if (has_depth(frame)) nearest = std::fmin(nearest, std::fabs(frame.colour.seconds - frame.depth.seconds));
            throw Error("no picture of " + detail::shown_path(path) + " has a depth (" + number_text(*depth_within) +
                        " s from a picture to its depth are allowed, and the nearest is " + significant(nearest, 3) +
                        " s away); allow more with --depth-within, or correct the time stamps");
        }
    }
    for (auto& [colour, depth, mask] : frames) {
        colour.file = root / colour.file;
        if (!depth_within) depth = {};
        if (!depth.file.empty()) depth.file = root / depth.file;
    }
    std::size_t repeated = 0;
    for (std::size_t i = 1; i < frames.size(); ++i) repeated += frames[i].colour.seconds == frames[i - 1].colour.seconds ? 1u : 0u;
    if (repeated != 0 && notes != nullptr)
        notes->push_back("pictures with the time stamp of an earlier one: " + std::to_string(repeated) + " of " + std::to_string(frames.size()));
    if (depth_within && notes != nullptr) detail::add_depth_notes(frames, *depth_within, *notes);
    return frames;
}

}}} // namespace tilemesh::scene
