#pragma once
#include "options.hpp"
#include "photographs.hpp"
#include "shots.hpp"
#include <cstddef>
#include <filesystem>
#include <future>
#include <optional>
#include <string>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/report/run_report.hpp>
#include <tilemesh/report/y4m.hpp>
#include <vector>

namespace render_map {

/// A rendered frame, its entry in the report, and its files in the order in which they are written.
struct Frame {
    std::size_t index = 0;
    tilemesh::RenderedFrame rendered;
    tilemesh::report::RunFrame entry;
    std::vector<std::filesystem::path> files{};
};

/// Writes a frame on another thread while the next frame is rendered: its pictures, its comparison with a photograph or with the picture of
/// --compare, and its part of the video. One frame at a time is in flight, so that two pictures at most are in memory. If the system
/// refuses the thread, `finish` does the work.
class FrameWriter {
public:
    /// The arguments must outlive the writer. `video`: null if there is none.
    FrameWriter(Options const& options, std::optional<OtherPicture> const& other, tilemesh::report::Y4mVideo* video)
        : options_(options), other_(other), video_(video)
    {
    }

    /// Begins to write a frame of `shot`. The frame before must be finished.
    void start(Frame frame, Shot const& shot);

    /// Waits until the frame in flight is written, and returns it; empty if no frame is in flight. Throws the error of its writing.
    std::optional<Frame> finish();

    bool is_writing() const noexcept { return written_.valid(); }

private:
    void write(Shot const& shot);

    Options const& options_;
    std::optional<OtherPicture> const& other_;
    tilemesh::report::Y4mVideo* video_;
    std::optional<Frame> frame_;
    std::future<void> written_; ///< its destructor waits for the thread, which uses the members above
};

} // namespace render_map
