#pragma once
#include "output_files.hpp"
#include <iostream>
#include <optional>
#include <string>
#include <tilemesh/error.hpp>

namespace shared {

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
