#pragma once
#include "options.hpp"
#include "photographs.hpp"
#include "shots.hpp"
#include <cstddef>
#include <deque>
#include <filesystem>
#include <future>
#include <optional>
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

/// Writes frames on other threads while the next frames are rendered: their pictures, and their comparisons with a photograph or with the
/// picture of --compare. As many frames are in flight as there are threads, if their pictures are small: to encode a picture can take longer
/// than to render one. With a video, to which frames are added in order, one is in flight. If the system refuses a thread, `finish` does
/// the work.
class FrameWriter {
public:
    /// The arguments must outlive the writer. `video`: null if there is none.
    FrameWriter(Options const& options, std::optional<OtherPicture> const& other, tilemesh::report::Y4mVideo* video)
        : options_(options), other_(other), video_(video)
    {
    }

    /// Begins to write a frame of `shot`. If `is_full(frame)`, a frame must be finished first.
    void start(Frame frame, Shot const& shot);

    /// Waits until the oldest frame in flight is written, and returns it; empty if no frame is in flight. Throws the error of its writing.
    std::optional<Frame> finish();

    bool is_writing() const noexcept { return !in_flight_.empty(); }
    bool is_full(Frame const& next) const noexcept;

private:
    struct InFlight {
        Frame frame;
        std::future<void> written{}; ///< its destructor waits for the thread, which uses the frame
    };
    void write(Frame& frame, Shot const& shot) const;

    Options const& options_;
    std::optional<OtherPicture> const& other_;
    tilemesh::report::Y4mVideo* video_;
    std::deque<InFlight> in_flight_; ///< from the oldest on; a frame does not move
};

} // namespace render_map
