#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace paper {

/// One figure of the paper beside ours.
struct Row {
    std::string table;           ///< of the paper, as `stages` or `churn`
    std::string row;             ///< scene, or motion
    std::string quantity;        ///< what, and its unit
    std::optional<double> paper; ///< empty: no figure in the source
    std::optional<double> ours;  ///< empty: not reached here, `note` says why
    std::string kind;            ///< of ours: counted, modelled, predicted, fitted, arithmetic
    std::string note = {};       ///< contradictions, assumptions; ends up in the CSV
    bool broken = false;         ///< something that must hold does not: the program says so and ends with 1
};
using Rows = std::vector<Row>;

/// What every table gets.
struct Context {
    std::filesystem::path data; ///< empty: none, tables that need it say "skipped"
    std::filesystem::path out;  ///< for pictures and plots; empty: none are written
    std::uint32_t threads = 2;
    bool quick = false;         ///< fewer frames, where the table says so
};

} // namespace paper
