#pragma once
#include "../shared/printer.hpp"
#include "../shared/text.hpp"
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <string>
#include <unistd.h>
#include <vector>

namespace render_map {

using shared::clock_text;

/// One line on standard error that is overwritten. It prints nothing unless standard error is a terminal and `wanted` is true.
class Progress {
public:
    explicit Progress(bool wanted) : shown_(wanted && isatty(STDERR_FILENO) == 1) {}
    ~Progress() { say(""); }
    Progress(Progress const&) = delete;
    Progress& operator=(Progress const&) = delete;

    void say(std::string const& text) const
    {
        if (shown_) std::cerr << "\r\033[K" << text << std::flush;
    }

    /// Begins the next of `frames` frames.
    void begin_frame(std::string const& name, std::size_t frames)
    {
        frames_ = frames;
        auto const now = Clock::now();
        if (begun_++ != 0) took_.push_back(std::chrono::duration<double>(now - began_).count());
        began_ = now;
        // 30 characters of a name: the line must fit into 80 columns, otherwise it is not overwritten but repeated.
        frame_ = "frame " + std::to_string(begun_) + " of " + std::to_string(frames_) + ", " + shared::one_line(name, 30) + ": ";
    }

    /// Shows the step of the frame, and the expected time of all remaining frames. Each is expected to take the median time of the last
    /// nine frames, which one slow frame does not change.
    void say_frame(char const* what) const
    {
        auto text = frame_ + what;
        if (!took_.empty()) {
            std::vector<double> last(took_.end() - std::min<std::ptrdiff_t>(9, std::ssize(took_)), took_.end());
            auto const middle = last.begin() + std::ssize(last) / 2;
            std::nth_element(last.begin(), middle, last.end());
            auto const spent = std::chrono::duration<double>(Clock::now() - began_).count();
            auto const left = *middle * static_cast<double>(frames_ - begun_ + 1) - std::min(spent, *middle);
            text += ", " + clock_text(static_cast<std::uint64_t>(left + 0.5)) + " left";
        }
        say(text);
    }

private:
    using Clock = std::chrono::steady_clock;
    bool shown_;
    std::size_t frames_ = 0, begun_ = 0;
    std::string frame_;
    Clock::time_point began_;
    std::vector<double> took_; ///< seconds of each finished frame
};

} // namespace render_map
