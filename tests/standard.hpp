// What most test files include: doctest, what they use of the standard library, and what several parts need.
#pragma once
#include <doctest/doctest.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>
#include <tilemesh/error.hpp>

namespace tests {
/// TILEMESH_FAST=1 makes heavy cases smaller, for sanitizer runs.
inline bool fast()
{
    char const* const value = std::getenv("TILEMESH_FAST");
    return value != nullptr && std::string_view(value) == "1";
}
/// The text of the Error that f throws; empty if it throws none.
template <class F>
std::string error_of(F&& f)
{
    try {
        f();
    } catch (tilemesh::Error const& error) {
        return error.what();
    }
    return {};
}
inline bool has(std::string const& text, std::string const& part) { return text.find(part) != std::string::npos; }

/// SplitMix64: the same numbers everywhere.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint32_t bits()
    {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return static_cast<std::uint32_t>((z ^ (z >> 31)) >> 32);
    }
    std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(std::uint64_t{bits()} * n >> 32); }
    float uniform(float low, float high) { return low + (high - low) * static_cast<float>(bits() >> 8) * 0x1p-24f; }

private:
    std::uint64_t state_;
};
} // namespace tests
