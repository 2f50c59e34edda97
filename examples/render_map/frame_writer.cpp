#include "frame_writer.hpp"
#include "../shared/png.hpp"
#include "outputs.hpp"
#include <tilemesh/report/image_file.hpp>
#include <utility>

namespace render_map {

namespace report = tilemesh::report;

namespace {
/// Pictures in flight, and what encodes them, take at most this memory beside one frame's (limits.cpp).
constexpr std::size_t most_bytes_in_flight = std::size_t{1} << 28, bytes_a_pixel = 12 + 15;
} // namespace

bool FrameWriter::is_full(Frame const& next) const noexcept
{
    if (in_flight_.empty()) return false;
    if (video_) return true;
    auto const bytes = bytes_a_pixel * next.rendered.image.width * next.rendered.image.height;
    return in_flight_.size() >= options_.renderer.threads || (in_flight_.size() + 1) * bytes > most_bytes_in_flight;
}

void FrameWriter::start(Frame frame, Shot const& shot)
{
    auto& entry = in_flight_.emplace_back(InFlight{std::move(frame)});
    // With both policies, an implementation that gets no thread defers the call to the wait.
    try {
        entry.written = std::async(std::launch::async | std::launch::deferred, [this, &of = entry.frame, &shot] { write(of, shot); });
    } catch (...) {
        in_flight_.pop_back();
        throw;
    }
}

std::optional<Frame> FrameWriter::finish()
{
    if (!is_writing()) return {};
    auto& oldest = in_flight_.front();
    oldest.written.wait();
    auto written = std::move(oldest.written);
    std::optional<Frame> frame = std::move(oldest.frame);
    in_flight_.pop_front();
    written.get();
    return frame;
}

void FrameWriter::write(Frame& frame, Shot const& shot) const
{
    auto& [index, rendered, entry, files] = frame;
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
