#pragma once
#include "options.hpp"
#include "shots.hpp"
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <tilemesh/report/run_report.hpp>
#include <tilemesh/splat/model.hpp>
#include <vector>

namespace render_map {

/// The file of --resume in the folder of the pictures. Its first line is the run's `MadeFrom`, then comes a line for each frame:
/// its number, the size and digest of each of its files, and its part of report.json.
inline constexpr char const* journal_file = "resume.jsonl";

/// What the frames of this run follow from: the version, the options that change a frame, and the bytes of every file in `read`.
/// Throws `tilemesh::Error` for a file that cannot be read twice. Cost: reads every file once more.
tilemesh::report::MadeFrom made_from(Options const& options, std::vector<std::filesystem::path> const& read);

/// The frames that are finished, of this run and of those that were cut off before it.
///
/// A frame of an earlier run is taken over where its line is whole and its files have the size and digest that the line says.
/// The digests have 64 bits: they find what happens to files, not what somebody does on purpose.
class Journal {
public:
    /// Reads what earlier runs left in `folder`, and begins the file where there is none. Throws `tilemesh::Error` where an
    /// earlier run was made from something else: its frames stay as they are. Cost: reads the files of the frames taken over.
    Journal(std::filesystem::path const& folder, tilemesh::report::MadeFrom const& made_from, std::size_t frames);

    /// How a frame gets into the report.
    enum class Way {
        render,    ///< in full
        replay,    ///< it is taken over, but a later frame begins where it leaves the records
        take_over  ///< it is taken over, and so are all that follow
    };
    Way way(std::size_t frame) const;
    std::size_t taken_over() const noexcept { return taken_over_; }

    /// The report of a frame that is taken over. Call it once a frame.
    tilemesh::report::RunFrame take(std::size_t frame);

    /// Adds a frame, whose files are written.
    void add(std::size_t frame, tilemesh::report::RunFrame const& report, std::vector<std::filesystem::path> const& files);

private:
    void read_line(std::string const& line);
    std::filesystem::path path_, folder_;
    std::vector<std::optional<tilemesh::report::RunFrame>> found_;
    bool begins_line_ = true; ///< the file ends with a line break
    std::size_t taken_over_ = 0;
    std::size_t rendered_ = 0; ///< 1 + the last frame to render
};

/// Moves the records as a frame does, and leaves its pixels out where nothing can tell: `with_pixels` must be true where a
/// neighbour in the sequence has the same view and is rendered in full, because a view that only differs in its model is
/// another view to the renderer.
void replay(AnyRenderer& renderer, tilemesh::splat::Camera const& camera, bool with_pixels);

/// For each frame, whether a frame that is rendered in full is in its run of equal views.
std::vector<bool> needs_pixels(std::vector<Shot> const& shots, tilemesh::splat::Model const& model, Journal const& journal);

} // namespace render_map
