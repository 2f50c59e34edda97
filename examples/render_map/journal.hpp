#pragma once
#include "options.hpp"
#include "shots.hpp"
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <tilemesh/report/run_report.hpp>
#include <tilemesh/splat/rules.hpp>
#include <vector>

namespace render_map {

/// The file of --resume, in the folder of the pictures. Its first line is the run's `MadeFrom`. Each further line is a frame: its number,
/// the size and digest of each of its files, its part of report.json, and the digest of all this.
inline constexpr char const* journal_file = "resume.jsonl";

/// The inputs that determine the frames of this run: the version, the options that change a frame, and the bytes of every file in `read`.
/// The order of the options and of the files does not matter. Throws `tilemesh::Error` for a file that cannot be read twice. Cost: reads
/// every file once more.
tilemesh::report::MadeFrom made_from(Options const& options, std::vector<std::filesystem::path> const& read);

/// The finished frames of this run and of earlier, interrupted runs.
///
/// This run takes over a frame if its line is as it was written, if the line names the files that the frame gets in this run, and if these files
/// have the size and digest in that line. Digests have 64 bits: they detect accidental damage, but not deliberate changes.
class Journal {
public:
    /// The names of a frame's files, in the order in which `add` gets them.
    using Names = std::function<std::vector<std::string>(std::size_t frame)>;

    /// Reads the list of earlier runs in `folder`, or starts one. Throws `tilemesh::Error` if an earlier run had other inputs, and leaves
    /// its frames unchanged. Cost: reads the files of all frames in the list.
    Journal(std::filesystem::path const& folder, tilemesh::report::MadeFrom const& made_from, std::size_t frames, Names const& names);

    /// The way in which a frame gets into the report.
    enum class Way {
        render,    ///< rendered in full
        replay,    ///< taken over, but its records must move, because a later frame is rendered
        take_over  ///< taken over, like all frames after it
    };
    Way way(std::size_t frame) const;
    /// The program that rendered a frame that is replayed or taken over, before `take`.
    tilemesh::report::Program program(std::size_t frame) const { return found_[frame].value().report.program; }
    std::size_t taken_over() const noexcept { return taken_over_; }
    /// One line: the list has lines that are not as they were written, and their frames are rendered again. Empty if there is none.
    std::string const& damage() const noexcept { return damage_; }

    /// Returns the report of a frame that is taken over. Call it once per frame.
    tilemesh::report::RunFrame take(std::size_t frame);

    /// Adds a frame. Its files must be complete.
    void add(std::size_t frame, tilemesh::report::RunFrame const& report, std::vector<std::filesystem::path> const& files);

private:
    void read_line(std::string const& line, Names const& names);
    std::filesystem::path path_, folder_;
    std::string head_line_, damage_;
    std::vector<std::optional<tilemesh::report::RunFrame>> found_;
    bool begins_line_ = true; ///< does the file end with a line break?
    std::size_t taken_over_ = 0;
    std::size_t rendered_ = 0; ///< 1 + the last frame to render
};

/// Moves the records as a frame does. Without `with_pixels` it leaves out the pixels by changing the model, so the renderer sees another
/// view. So `with_pixels` must be true if an adjacent frame has the same view and is rendered in full. It must also be true for a frame of
/// homes: the depths at which its windows end are those of the pixels of the frame before.
void replay(tilemesh::Renderer& renderer, tilemesh::splat::Camera const& camera, bool with_pixels);

/// For each frame: is it, or another frame in the same series of equal views, rendered in full?
std::vector<bool> needs_pixels(std::vector<Shot> const& shots, tilemesh::splat::Rules const& rules, Journal const& journal);

/// Writes the report of the run to the file that --report names. It stands here because the journal compiles the JSON of frames anyway.
/// Throws `tilemesh::Error` if the file cannot be written.
void write_report(Options const& options, tilemesh::report::RunReport const& run);

} // namespace render_map
