#pragma once
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/whole_file.hpp>

/// Raw video as a YUV4MPEG2 stream (.y4m), which players and encoders read from a file or a pipe. The format is that of `yuv4mpeg(5)` of
/// mjpegtools: one line of text, then for each frame the line "FRAME" and the planes Y', Cb, Cr, 8 bits a sample, rows from the top.
///
/// The chroma has full resolution (C444), so a video has 3 bytes a pixel, and its sides may be odd. The colours are those of ITU-R BT.601-7,
/// section 2.5: Y' = 0.299 R' + 0.587 G' + 0.114 B' as 16 to 235, (B' - Y') / 1.772 and (R' - Y') / 1.402 as 16 to 240 around 128. The
/// format has no word for the matrix: programs assume BT.601. The header says XCOLORRANGE=LIMITED, FFmpeg's word for 16 to 235.

namespace tilemesh { inline namespace v0_2 { namespace report {

/// Frames in so many seconds: 30 in 1, or 30000 in 1001. Both numbers are 1 or more.
struct FrameRate {
    std::uint32_t frames = 30, seconds = 1;
};

/// The first line of a stream.
TILEMESH_HOST std::string y4m_header(std::uint32_t width, std::uint32_t height, FrameRate rate);

/// The bytes of a frame, 6 and 3 a pixel. Each value of the picture is clamped to [0, 1], and each sample is rounded to the nearest integer.
/// A NaN counts as 0. No gamma is applied, as in `rgb8`.
TILEMESH_HOST std::string y4m_frame(Image const& picture);

/// A video that is written frame by frame. A file gets its name in `finish` (`WholeFile`); a video that is destroyed without it leaves
/// nothing. A device, a pipe or a stream gets each frame at once.
///
/// The constructor, `add` and `finish` throw the errors of `WholeFile`. Cost: memory for one frame; 3 bytes a pixel and frame on disk.
class Y4mVideo {
public:
    /// Throws `tilemesh::Error` also for a size or a rate with a 0.
    TILEMESH_HOST Y4mVideo(std::filesystem::path const& path, std::uint32_t width, std::uint32_t height,
                           FrameRate rate = {}, Outlasts outlasts = Outlasts::process);
    /// To an open stream, which the caller closes. `what` names it in an error: "the video to standard output".
    TILEMESH_HOST Y4mVideo(std::FILE* stream, std::string what, std::uint32_t width, std::uint32_t height, FrameRate rate = {});

    /// Throws `tilemesh::Error` also for a picture of another size.
    TILEMESH_HOST void add(Image const& picture);
    /// Call it once, after the last frame. A video without a frame has its header alone.
    TILEMESH_HOST void finish();

private:
    static std::string by(std::uint32_t width, std::uint32_t height) { return std::to_string(width) + " x " + std::to_string(height); }
    TILEMESH_HOST std::string checked_header(FrameRate rate) const;

    std::uint32_t width_, height_;
    std::string header_; ///< empty once it is written
    WholeFile file_;
};

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/y4m_code.hpp>
#endif
