#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <string_view>

/// A condition that holds for every input. A fuzzer reports an abort as a finding.
inline void require(bool holds, char const* what)
{
    if (holds) return;
    std::fprintf(stderr, "broken: %s\n", what);
    std::abort();
}

/// Without control characters.
inline bool is_one_line(std::string_view text)
{
    return !text.empty() && std::none_of(text.begin(), text.end(), [](char c) { return (c >= 0 && c < ' ') || c == 0x7f; });
}

/// An error is "problem (why); what to do".
inline void require_error(std::string_view text)
{
    require(text.find(" (") != text.npos && text.find("); ") != text.npos, "an error has a problem, a reason and an advice");
    require(is_one_line(text), "an error is one line");
}

/// What lies behind other readers, and how many inputs got there. A fuzzer names it with 0; replay.cpp fails if no mutated input got there.
inline std::map<std::string, unsigned long> reached;
