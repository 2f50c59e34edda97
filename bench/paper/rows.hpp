#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace paper {

/// A figure of the paper, with ours.
struct Row {
    std::string table;           ///< of the paper, such as `stages` or `churn`
    std::string row;             ///< scene, or motion
    std::string quantity;        ///< the quantity and its unit
    std::optional<double> paper; ///< empty: no figure in the source
    std::optional<double> ours;  ///< empty: no result; `note` says why
    std::string kind;            ///< kind of our figure: counted, modelled, predicted, fitted, arithmetic
    std::string note = {};       ///< contradictions and assumptions, for the CSV
    bool broken = false;         ///< a condition that must hold is violated: the program reports it and ends with status 1
};
using Rows = std::vector<Row>;

/// The input of every table.
struct Context {
    std::filesystem::path data; ///< empty: no data; tables that need data say "skipped"
    std::filesystem::path out;  ///< for pictures and plots; empty: none are written
    std::uint32_t threads = 2;
    bool quick = false;         ///< fewer frames, in tables that say so
};

} // namespace paper
