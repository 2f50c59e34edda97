#include "journal.hpp"
#include "../shared/text.hpp"
#include "outputs.hpp"
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/json.hpp>
#include <tilemesh/report/json_frame.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tuple>
#include <utility>

namespace render_map {

namespace {

namespace fs = std::filesystem;
namespace report = tilemesh::report;
using Json = nlohmann::ordered_json;
using tilemesh::Error;

/// The size of a file, and the digest of its bytes.
struct Contents {
    std::uint64_t bytes = 0;
    std::string digest;
};
/// A digest of 64 bits, as hexadecimal digits. It detects accidental damage, but not deliberate changes.
class Digest {
public:
    /// Adds `n` bytes; zeros fill the last word. Only the last call may have an `n` that is no multiple of 8.
    void add(char const* bytes, std::size_t n) noexcept
    {
        for (std::size_t i = 0; i < n; i += 8) {
            std::uint64_t word = 0;
            std::memcpy(&word, bytes + i, std::min<std::size_t>(8, n - i));
            // FNV-1a's step for a word (Fowler, Noll, Vo), then the high half is mixed into the low half. Otherwise two changes of a top
            // bit cancel.
            h_ = (h_ ^ word) * 0x100000001b3u;
            h_ ^= h_ >> 32;
        }
    }
    std::string text() const
    {
        std::array<char, 16> digits{};
        return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), h_, 16).ptr};
    }

private:
    std::uint64_t h_ = 0x9e3779b97f4a7c15u; // any start that is not 0
};

/// Returns nothing if there is no such file, or if it is not a regular file. Throws `Error` with the system's reason if it cannot be read.
std::optional<Contents> contents_of(fs::path const& path)
{
    std::error_code refused;
    if (!fs::is_regular_file(path, refused)) return {};
    auto const fail = [&] {
        if (errno == ENOMEM) throw std::bad_alloc();
        throw Error("cannot take the digest of " + path.string() + " (" + std::generic_category().message(errno != 0 ? errno : EIO) +
                    "); make it readable, or leave out --resume");
    };
    errno = 0;
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> const in(std::fopen(path.c_str(), "rb"), std::fclose);
    if (!in) fail();
    std::vector<char> block(1u << 20);
    std::uint64_t bytes = 0;
    Digest digest;
    for (std::size_t n = block.size(); n == block.size();) {
        errno = 0;
        n = std::fread(block.data(), 1, block.size(), in.get());
        if (std::ferror(in.get()) != 0) fail();
        digest.add(block.data(), n);
        bytes += n;
    }
    return Contents{bytes, digest.text()};
}

std::string line_of(Json const& json)
{
    return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// A frame's line ends with the digest of the list's first line and of the line's own text before `seal`.
constexpr std::string_view seal = ",\"digest\":\"";
std::string digest_of_line(std::string_view head_line, std::string_view text)
{
    auto const all = std::string(head_line).append(text);
    Digest digest;
    digest.add(all.data(), all.size());
    return digest.text();
}
/// Is this line as it was written?
bool is_sealed(std::string_view head_line, std::string_view line)
{
    auto const at = line.rfind(seal);
    return at != line.npos && line.substr(at + seal.size()) == digest_of_line(head_line, line.substr(0, at)) + "\"}";
}

/// The names, sizes and digests of a run's files. A frame may be named after a file, but not after its folder.
std::vector<std::tuple<std::string, std::uint64_t, std::string>> files_of(Json const& run)
{
    std::vector<std::tuple<std::string, std::uint64_t, std::string>> files;
    for (auto const& file : run.at("files"))
        files.emplace_back(fs::path(file.at("path").get<std::string>()).filename().string(), file.at("bytes").get<std::uint64_t>(),
                           file.at("digest").get<std::string>());
    return files;
}

/// One clause: the first difference between the inputs of the runs `then` and `now`; empty if there is none.
std::string difference(Json const& then, Json const& now)
{
    if (then.at("version") != now.at("version"))
        return "its frames are of " + then.at("version").get<std::string>() + ", this is " + now.at("version").get<std::string>();
    auto const alone = [](Json const& run, Json const& other, std::string text) {
        auto const& others = other.at("options");
        auto const begin = text.size();
        for (auto const& option : run.at("options"))
            if (std::find(others.begin(), others.end(), option) == others.end()) text += " " + shared::one_line(option.get<std::string>(), 60);
        return text.size() == begin ? std::string() : text;
    };
    if (then.at("options") != now.at("options"))
        return "its frames were rendered" + alone(then, now, " with") + alone(now, then, " without");
    auto const was = files_of(then), is = files_of(now);
    for (auto const& file : is)
        if (std::find(was.begin(), was.end(), file) == was.end()) {
            auto const known = std::any_of(was.begin(), was.end(), [&](auto const& other) { return std::get<0>(other) == std::get<0>(file); });
            return shared::one_line(std::get<0>(file), 200) + (known ? " has changed since" : " was not among its files");
        }
    for (auto const& file : was)
        if (std::find(is.begin(), is.end(), file) == is.end()) return shared::one_line(std::get<0>(file), 200) + " was among its files";
    return "";
}

} // namespace

report::MadeFrom made_from(Options const& options, std::vector<fs::path> const& read)
{
    report::MadeFrom result;
    auto const version = version_text();
    result.version = version.substr(0, version.find('\n'));
    result.options = options.shaping;
    for (auto const& file : read) {
        auto const contents = contents_of(file);
        if (!contents)
            throw Error("cannot take the digest of " + file.string() +
                        " (--resume reads every file twice, and that one is no regular file); leave out --resume");
        result.files.push_back({file.string(), contents->bytes, contents->digest});
        // The order of maps gives the ids, and two maps may have one name.
        for (std::size_t k = 0; options.maps.size() > 1 && k < options.maps.size(); ++k)
            if (options.maps[k] == file) result.options.push_back("map " + std::to_string(k + 1) + ": " + contents->digest);
    }
    std::sort(result.options.begin(), result.options.end());
    auto const key = [](auto const& file) { return std::tuple(fs::path(file.path).filename(), file.bytes, file.digest); };
    std::sort(result.files.begin(), result.files.end(), [&](auto const& a, auto const& b) { return key(a) < key(b); });
    result.files.erase(std::unique(result.files.begin(), result.files.end(), [&](auto const& a, auto const& b) { return key(a) == key(b); }),
                       result.files.end());
    return result;
}

Journal::Journal(fs::path const& folder, report::MadeFrom const& made_from, std::size_t frames, Names const& names)
    : path_(folder / journal_file), folder_(folder), found_(frames), rendered_(frames)
{
    auto const refuse = [&](std::string const& why) {
        throw Error("cannot resume in " + folder.string() + " (" + why + "); name another directory with --out, or remove " + path_.string() +
                    " and render every frame again");
    };
    report::RunReport run;
    run.made_from = made_from;
    head_line_ = line_of(report::json_of(run).at("made_from"));
    std::error_code refused;
    if (!fs::exists(path_, refused)) {
        report::write_whole(path_, head_line_);
        return;
    }
    if (!fs::is_regular_file(path_, refused)) refuse(path_.string() + " is no regular file");
    errno = 0;
    std::ifstream in(path_, std::ios::binary);
    if (!in.is_open() && errno == ENOMEM) throw std::bad_alloc();
    in.exceptions(std::ios::badbit); // lack of memory, or an unreadable disk, is not the end of the list
    std::string line;
    auto const next_line = [&] {
        try {
            return static_cast<bool>(std::getline(in, line));
        } catch (std::ios_base::failure const&) {
            refuse(path_.string() + " cannot be read");
            return false;
        }
    };
    if (!next_line()) refuse(path_.string() + " is empty");
    if (line + "\n" != head_line_) {
        std::string why = path_.string() + " is not the list of frames that this version writes";
        try {
            why = difference(Json::parse(line), Json::parse(head_line_));
        } catch (nlohmann::json::exception const&) { // `why` has the text already
        }
        if (!why.empty()) refuse(why);
        head_line_ = line + "\n"; // the files may have other folders
    }
    // A line that was written only in part has no line break at its end.
    std::vector<std::size_t> changed;
    for (std::size_t number = 2; next_line(); ++number) {
        begins_line_ = !in.eof();
        if (!begins_line_ || line.empty()) continue;
        if (is_sealed(head_line_, line))
            read_line(line, names);
        else
            changed.push_back(number);
    }
    while (rendered_ != 0 && found_[rendered_ - 1]) --rendered_;
    taken_over_ = static_cast<std::size_t>(std::count_if(found_.begin(), found_.end(), [](auto const& frame) { return frame.has_value(); }));
    if (changed.empty() || taken_over_ == frames) return; // a later line has the frame
    bool const one = changed.size() == 1;
    damage_ = shared::one_line(path_.string()) + ": line " + std::to_string(changed[0]) +
              (one ? "" : " and " + std::to_string(changed.size() - 1) + " more") + " changed after the run wrote " + (one ? "it" : "them") +
              " (the digest is of another text); " + (one ? "its frame is" : "their frames are") + " rendered again";
}

/// Ignores a line with other files than this run writes, and a line whose files have changed. These frames are rendered
/// again.
void Journal::read_line(std::string const& line, Names const& names)
{
    try {
        auto const json = Json::parse(line);
        auto const number = json.at("frame").get<std::size_t>();
        if (number >= found_.size()) return;
        std::vector<std::string> named;
        for (auto const& file : json.at("files")) named.push_back(file.at("name").get<std::string>());
        auto frame = report::frame_of(json.at("report"));
        auto expected = names(number);
        if (frame.photograph && !frame.photograph->problem.empty()) // then there is no picture of its error
            std::erase_if(expected, [](auto const& name) { return name.ends_with(".error.png"); });
        if (named != expected) return;
        for (auto const& file : json.at("files")) {
            auto const path = folder_ / file.at("name").get<std::string>();
            std::error_code refused;
            if (fs::file_size(path, refused) != file.at("bytes").get<std::uint64_t>() || refused) return;
            auto const contents = contents_of(path);
            if (!contents || contents->digest != file.at("digest").get<std::string>()) return;
        }
        found_[number] = std::move(frame);
    } catch (nlohmann::json::exception const&) {
    } catch (Error const&) {
    }
}

Journal::Way Journal::way(std::size_t frame) const
{
    if (!found_[frame]) return Way::render;
    return frame < rendered_ ? Way::replay : Way::take_over;
}

report::RunFrame Journal::take(std::size_t frame)
{
    return std::move(found_[frame].value());
}

void Journal::add(std::size_t frame, report::RunFrame const& report, std::vector<fs::path> const& files)
{
    Json json{{"frame", frame}};
    json["files"] = Json::array();
    for (auto const& file : files) {
        auto const contents = contents_of(file);
        if (!contents) throw Error("cannot read " + file.string() + " again (it is no regular file); leave out --resume");
        json["files"].push_back({{"name", file.filename().string()}, {"bytes", contents->bytes}, {"digest", contents->digest}});
    }
    report::RunReport run;
    run.frames = {report};
    json["report"] = std::move(report::json_of(run).at("frames").at(0));
    auto line = line_of(json);
    line.resize(line.size() - 2); // without the brace and the line break
    auto const digest = digest_of_line(head_line_, line);
    auto const text = std::string(begins_line_ ? "" : "\n") // ends a line that was written only in part
                          .append(line).append(seal).append(digest).append("\"}\n");
    begins_line_ = true;
    errno = 0;
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(std::fopen(path_.c_str(), "ab"), std::fclose);
    bool written = out && std::fwrite(text.data(), 1, text.size(), out.get()) == text.size();
    if (out) written = std::fclose(out.release()) == 0 && written;
    if (!written)
        throw Error("cannot write " + path_.string() + " (" + std::generic_category().message(errno != 0 ? errno : EIO) +
                    "); name a writable directory with --out");
}

void replay(tilemesh::Renderer& renderer, tilemesh::splat::Camera const& camera, bool with_pixels)
{
    auto const before = renderer.rules().transmittance_min;
    // 2 is above the transmittance of an empty pixel, so each pixel is finished before its first Gaussian. Only compositing reads
    // this number.
    if (!with_pixels) renderer.rules().transmittance_min = 2;
    renderer.render(camera);
    renderer.rules().transmittance_min = before;
}

std::vector<bool> needs_pixels(std::vector<Shot> const& shots, tilemesh::splat::Rules const& rules, Journal const& journal)
{
    auto const same_view = [&](std::size_t a, std::size_t b) {
        // The renderer compares views in the same way.
        auto const x = tilemesh::splat::make_view(shots[a].camera, rules), y = tilemesh::splat::make_view(shots[b].camera, rules);
        return std::memcmp(&x, &y, sizeof x) == 0;
    };
    std::vector<bool> needed(shots.size(), false);
    for (std::size_t begin = 0, end = 0; begin < shots.size(); begin = end) {
        bool any = false;
        for (end = begin; end < shots.size() && (end == begin || same_view(end - 1, end)); ++end)
            any = any || journal.way(end) == Journal::Way::render;
        std::fill(needed.begin() + static_cast<std::ptrdiff_t>(begin), needed.begin() + static_cast<std::ptrdiff_t>(end), any);
    }
    return needed;
}

void write_report(Options const& options, report::RunReport const& run)
{
    report::write_json(*options.report, run, outlasts(options));
}

} // namespace render_map
