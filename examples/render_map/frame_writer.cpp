#include "frame_writer.hpp"
#include "../shared/png.hpp"
#include "outputs.hpp"
#include <tilemesh/report/image_file.hpp>
#include <utility>

namespace render_map {

namespace report = tilemesh::report;

void FrameWriter::start(Frame frame, Shot const& shot)
{
    frame_ = std::move(frame);
    // With both policies, an implementation that gets no thread defers the call to the wait.
    written_ = std::async(std::launch::async | std::launch::deferred, [this, &shot] { write(shot); });
}

std::optional<Frame> FrameWriter::finish()
{
    if (!is_writing()) return {};
    written_.wait();
    auto frame = std::exchange(frame_, std::nullopt);
    written_.get();
    return frame;
}

void FrameWriter::write(Shot const& shot)
{
    auto& [index, rendered, entry, files] = *frame_;
    auto const path = [&, &index = index, &files = files](char const* extension) -> auto const& {
        return files.emplace_back(frame_path(options_, index, extension));
    };
    auto const lasts = outlasts(options_);
    entry.image = frame_file(index, ".png");
    shared::write_png(path(".png"), rendered.image, lasts);
    if (options_.pfm) report::write_pfm(path(".pfm"), rendered.image, lasts);
    if (options_.choice.depth) {
        entry.depth = frame_file(index, ".depth.pfm");
        report::write_pfm(path(".depth.pfm"), rendered.depth, lasts);
    }
    if (options_.choice.alpha) {
        entry.alpha = frame_file(index, ".alpha.pfm");
        report::write_pfm(path(".alpha.pfm"), rendered.alpha, lasts);
    }
    if (other_ || shot.photograph) {
        auto const error = options_.error_picture ? frame_path(options_, index, ".error.png") : std::filesystem::path();
        if (compare_frame(options_, shot, other_, rendered.image, error, entry)) files.push_back(error);
    }
    if (video_) video_->add(rendered.image);
}

} // namespace render_map
