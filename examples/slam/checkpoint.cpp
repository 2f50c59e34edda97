#include "checkpoint.hpp"
#include "../shared/sha256.hpp"
#include "../shared/text.hpp"
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <memory>
#include <new>
#include <span>
#include <system_error>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/whole_file.hpp>

namespace slam_program {

namespace {

namespace fs = std::filesystem;
using tilemesh::Error;

/// The number changes with the layout of the state.
std::string first_line()
{
    return "slam (tilemesh) " + std::to_string(TILEMESH_VERSION) + ", checkpoint 1\n";
}

/// The bytes of a regular file. Nothing if there is no such file. `what` and `remedy` begin and end an error.
std::optional<std::string> bytes_of(fs::path const& path, std::string const& what, std::string const& remedy)
{
    auto const fail = [&](std::string const& why) { throw Error(what + path.string() + " (" + why + "); " + remedy); };
    std::error_code refused;
    if (!fs::exists(path, refused)) return {};
    if (!fs::is_regular_file(path, refused)) fail("--resume reads it twice, and it is no regular file");
    auto const reason = [&] {
        if (errno == ENOMEM) throw std::bad_alloc();
        fail(std::generic_category().message(errno != 0 ? errno : EIO));
    };
    errno = 0;
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> const in(std::fopen(path.c_str(), "rb"), std::fclose);
    if (!in) reason();
    std::string bytes;
    std::vector<char> block(1u << 20);
    for (std::size_t n = block.size(); n == block.size();) {
        errno = 0;
        n = std::fread(block.data(), 1, block.size(), in.get());
        if (std::ferror(in.get()) != 0) reason();
        bytes.append(block.data(), n);
    }
    return bytes;
}

std::string seal_of(std::string const& made_from, std::string_view count, std::string_view state)
{
    return shared::sha256(made_from + std::string(count) + shared::sha256(state));
}

} // namespace

Checkpoint::Checkpoint(Options const& options, std::vector<fs::path> const& read)
    : path_(options.out / checkpoint_file), aside_(options.out / set_aside_file)
{
    std::string text;
    for (auto const& option : options.shaping) text += option + "\n";
    for (auto const& file : read) {
        auto const bytes = bytes_of(file, "cannot take the digest of ", "make it a readable file, or leave out --resume");
        text += bytes ? shared::sha256(*bytes) + "\n" : "absent\n";
    }
    made_from_ = shared::sha256(text);
}

std::optional<std::string> Checkpoint::find(std::size_t frames) const
{
    auto const bytes = bytes_of(path_, "cannot resume from ", "make it readable, or remove it to begin anew");
    if (!bytes) return {};
    // version, inputs, frames, seal, state
    std::array<std::string, 4> lines;
    std::size_t at = 0;
    for (auto& line : lines)
        if (auto const end = bytes->find('\n', at); end != std::string::npos) line = bytes->substr(at, end - at), at = end + 1;
    auto state = bytes->substr(at);
    std::string why;
    if (lines[0] + "\n" != first_line()) why = "is not of this version (its first line is another)";
    else if (lines[3] != seal_of(lines[1], lines[2], state)) why = "is damaged (its digest is of other bytes)";
    else if (lines[1] != made_from_) why = "is of another run (its options or the files that it read are others)";
    else if (auto const count = tilemesh::number_of<std::uint64_t>(lines[2]); !count) why = "is damaged (its number of frames is none)";
    else if (*count > frames) why = "has more frames than --frames allows (" + lines[2] + ")";
    if (why.empty()) return state;
    std::error_code refused;
    fs::rename(path_, aside_, refused);
    if (refused)
        throw Error("cannot rename " + path_.string() + ", which " + why.substr(0, why.find(" (")) + " (" + refused.message() +
                    "); move it elsewhere, or name another directory with --out");
    std::cerr << shared::one_line(path_.string()) << " " << why << "; the run begins anew, and " << set_aside_file << " keeps that file"
              << std::endl;
    return {};
}

void Checkpoint::write(std::size_t frames, std::string_view state) const
{
    auto const count = std::to_string(frames);
    tilemesh::report::write_whole(path_, first_line() + made_from_ + "\n" + count + "\n" + seal_of(made_from_, count, state) + "\n",
                                  std::as_bytes(std::span(state)), tilemesh::report::Outlasts::power_loss);
}

} // namespace slam_program
