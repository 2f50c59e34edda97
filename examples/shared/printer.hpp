#pragma once
#include "output_files.hpp"
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <optional>
#include <string>
#include <tilemesh/error.hpp>

namespace shared {

/// 41 as "0:41", 3675 as "1:01:15".
inline std::string clock_text(std::uint64_t seconds)
{
    auto const two = [](std::uint64_t number) { return (number < 10 ? ":0" : ":") + std::to_string(number); };
    auto const minutes = seconds / 60;
    if (minutes < 60) return std::to_string(minutes) + two(seconds % 60);
    return std::to_string(minutes / 60) + two(minutes % 60) + two(seconds % 60);
}

/// How far a long run is, and how long the rest takes at its pace so far.
class Pace {
public:
    /// `begun`: the steps that were done before this run.
    Pace(std::size_t begun, std::size_t count) noexcept : begun_(begun), count_(count) {}
    /// " (12 of 60, 0:41 left)"; less than 10 seconds are not worth a word.
    std::string after(std::size_t done) const
    {
        auto text = " (" + std::to_string(done) + " of " + std::to_string(count_);
        if (done > begun_ && done < count_) {
            auto const spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
            auto const left = spent / static_cast<double>(done - begun_) * static_cast<double>(count_ - done);
            if (left >= 10 && left < 1e9) text += ", " + clock_text(static_cast<std::uint64_t>(left + 0.5)) + " left";
        }
        return text + ")";
    }

private:
    std::size_t begun_, count_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// What a run prints on standard output. A text that cannot be printed does not end the run: the first error stays in `problem`.
class Printer {
public:
    /// `remedy` is the end of that error: what is safe, and what to do.
    Printer(bool quiet, char const* remedy) noexcept : remedy_(remedy), quiet_(quiet) {}
    void say(std::string const& text)
    {
        if (quiet_ || problem) return;
        try {
            print(text, remedy_, std::cout);
        } catch (tilemesh::Error const& error) {
            problem = error.what();
        }
    }
    std::optional<std::string> problem;

private:
    char const* remedy_;
    bool quiet_;
};

} // namespace shared
