#pragma once
#include "options.hpp"
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slam_program {

/// The files of --resume, in the folder of --out: the state of the run, and a state that this run could not go on from.
inline constexpr char const *checkpoint_file = "checkpoint.bin", *set_aside_file = "checkpoint.bin.old";

/// The state of a run that goes on after it was stopped: one file, written whole or not at all.
///
/// Its first line names the version. The second line is the SHA-256 of the inputs that determine the state: the options that change it,
/// and the bytes of every file that the run reads. The third line is the number of frames. The fourth line is the SHA-256 of the two lines
/// before and of the state, which follows.
class Checkpoint {
public:
    /// `read`: `files_read`. Throws `tilemesh::Error` for a file that cannot be read twice. Cost: reads every file once more.
    Checkpoint(Options const& options, std::vector<std::filesystem::path> const& read);

    /// The state of an earlier run with the same inputs and at most `frames` frames. Nothing if there is none; then a file that is damaged,
    /// or of another run, is renamed to `set_aside_file`, and standard error says so in one line. Throws `tilemesh::Error` for a file that
    /// cannot be read.
    std::optional<std::string> find(std::size_t frames) const;
    /// The disk has the state when it returns. Throws `tilemesh::Error` as `report::write_whole`.
    void write(std::size_t frames, std::string_view state) const;

private:
    std::filesystem::path path_, aside_;
    std::string made_from_;
};

} // namespace slam_program
