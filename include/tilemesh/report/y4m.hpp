#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <utility>

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
inline std::string y4m_header(std::uint32_t width, std::uint32_t height, FrameRate rate)
{
    return "YUV4MPEG2 W" + std::to_string(width) + " H" + std::to_string(height) + " F" + std::to_string(rate.frames) + ":" +
           std::to_string(rate.seconds) + " Ip A1:1 C444 XCOLORRANGE=LIMITED\n";
}

/// The bytes of a frame, 6 and 3 a pixel. Each value of the picture is clamped to [0, 1], and each sample is rounded to the nearest integer.
/// A NaN counts as 0. No gamma is applied, as in `rgb8`.
inline std::string y4m_frame(Image const& picture)
{
    auto const pixels = picture.rgb.size() / 3;
    std::string frame = "FRAME\n";
    auto const head = frame.size();
    frame.resize(head + 3 * pixels);
    auto* const luma = frame.data() + head;
    auto const clamped = [](float value) { return value > 0.0f ? std::min(double{value}, 1.0) : 0.0; };
    auto const sample = [](double value) { return static_cast<char>(static_cast<unsigned char>(value + 0.5)); };
    for (std::size_t i = 0; i < pixels; ++i) {
        double const r = clamped(picture.rgb[3 * i]), g = clamped(picture.rgb[3 * i + 1]), b = clamped(picture.rgb[3 * i + 2]);
        double const y = 0.299 * r + 0.587 * g + 0.114 * b;
        luma[i] = sample(16 + 219 * y);
        luma[pixels + i] = sample(128 + 224 * (b - y) / 1.772);
        luma[2 * pixels + i] = sample(128 + 224 * (r - y) / 1.402);
    }
    return frame;
}

/// A video that is written frame by frame. A file gets its name in `finish` (`WholeFile`); a video that is destroyed without it leaves
/// nothing. A device, a pipe or a stream gets each frame at once.
///
/// The constructor, `add` and `finish` throw the errors of `WholeFile`. Cost: memory for one frame; 3 bytes a pixel and frame on disk.
class Y4mVideo {
public:
    /// Throws `tilemesh::Error` also for a size or a rate with a 0.
    Y4mVideo(std::filesystem::path const& path, std::uint32_t width, std::uint32_t height, FrameRate rate = {}, Outlasts outlasts = Outlasts::process)
        : width_(width), height_(height), header_(checked_header(rate)),
          file_(path, std::to_string(std::size_t{3} * width * height + 6) + " bytes per frame", outlasts)
    {
    }
    /// To an open stream, which the caller closes. `what` names it in an error: "the video to standard output".
    Y4mVideo(std::FILE* stream, std::string what, std::uint32_t width, std::uint32_t height, FrameRate rate = {})
        : width_(width), height_(height), header_(checked_header(rate)),
          file_(stream, std::move(what), "send it to a program that reads it to its end, or to a file with room")
    {
    }

    /// Throws `tilemesh::Error` also for a picture of another size.
    void add(Image const& picture)
    {
        if (picture.width != width_ || picture.height != height_ || picture.rgb.size() != std::size_t{3} * width_ * height_)
            throw Error("a frame of " + by(picture.width, picture.height) + " pixels is no frame of this video (its frames have " +
                        by(width_, height_) + "); render all frames at one size");
        file_.put(std::exchange(header_, {}));
        file_.put(y4m_frame(picture));
        file_.flush();
    }
    /// Call it once, after the last frame. A video without a frame has its header alone.
    void finish()
    {
        file_.put(std::exchange(header_, {}));
        file_.finish();
    }

private:
    static std::string by(std::uint32_t width, std::uint32_t height) { return std::to_string(width) + " x " + std::to_string(height); }
    std::string checked_header(FrameRate rate) const
    {
        if (width_ == 0 || height_ == 0) throw Error("a video cannot have " + by(width_, height_) + " pixels (its frames would be empty); choose sides of 1 or more");
        if (rate.frames == 0 || rate.seconds == 0)
            throw Error("a video cannot have " + std::to_string(rate.frames) + "/" + std::to_string(rate.seconds) +
                        " frames per second (that is no rate); choose two numbers of 1 or more");
        return y4m_header(width_, height_, rate);
    }

    std::uint32_t width_, height_;
    std::string header_; ///< empty once it is written
    WholeFile file_;
};

}}} // namespace tilemesh::report
