#pragma once
#include <algorithm>
#include <cstddef>
#include <tilemesh/report/y4m.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST std::string y4m_header(std::uint32_t width, std::uint32_t height, FrameRate rate)
{
    return "YUV4MPEG2 W" + std::to_string(width) + " H" + std::to_string(height) + " F" + std::to_string(rate.frames) + ":" +
           std::to_string(rate.seconds) + " Ip A1:1 C444 XCOLORRANGE=LIMITED\n";
}

TILEMESH_HOST std::string y4m_frame(Image const& picture)
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

TILEMESH_HOST Y4mVideo::Y4mVideo(std::filesystem::path const& path, std::uint32_t width, std::uint32_t height, FrameRate rate, Outlasts outlasts)
    : width_(width), height_(height), header_(checked_header(rate)),
      file_(path, std::to_string(std::size_t{3} * width * height + 6) + " bytes per frame", outlasts)
{}

TILEMESH_HOST Y4mVideo::Y4mVideo(std::FILE* stream, std::string what, std::uint32_t width, std::uint32_t height, FrameRate rate)
    : width_(width), height_(height), header_(checked_header(rate)),
      file_(stream, std::move(what), "send it to a program that reads it to its end, or to a file with room")
{}

TILEMESH_HOST void Y4mVideo::add(Image const& picture)
{
    if (picture.width != width_ || picture.height != height_ || picture.rgb.size() != std::size_t{3} * width_ * height_)
        throw Error("a frame of " + by(picture.width, picture.height) + " pixels is no frame of this video (its frames have " +
                    by(width_, height_) + "); render all frames at one size");
    file_.put(std::exchange(header_, {}));
    file_.put(y4m_frame(picture));
    file_.flush();
}

TILEMESH_HOST void Y4mVideo::finish()
{
    file_.put(std::exchange(header_, {}));
    file_.finish();
}

TILEMESH_HOST std::string Y4mVideo::checked_header(FrameRate rate) const
{
    if (width_ == 0 || height_ == 0)
        throw Error("a video cannot have " + by(width_, height_) + " pixels (its frames would be empty); choose sides of 1 or more");
    if (rate.frames == 0 || rate.seconds == 0)
        throw Error("a video cannot have " + std::to_string(rate.frames) + "/" + std::to_string(rate.seconds) +
                    " frames per second (that is no rate); choose two numbers of 1 or more");
    return y4m_header(width_, height_, rate);
}

}}} // namespace tilemesh::report
