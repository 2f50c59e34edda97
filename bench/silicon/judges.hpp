#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace silicon {

/// A published measurement, and what the library's models say about it.
struct Judge {
    std::string machine, figure, unit, missing, source;
    double measured = 0, predicted = 0;
    double at_least = 0;   ///< a bound of documented rates; 0: none
    bool last = true;      ///< `measured` is of the last core, so that no bound may be above it
    std::string bound_by{}; ///< empty: the row has no prediction (skipped)
    std::uint32_t bytes = 0; ///< of each transfer; 0: the row is no phase of equal transfers
};

/// Reads a table of measurements (machine,figure,measured,unit,phase,missing,source) and predicts each. `paper`: a CSV file of the bench
/// paper, whose rows are the predictions of the stages; empty: these rows have none. Throws tilemesh::Error for a file that is no such table.
std::vector<Judge> read_judges(std::filesystem::path const& file, std::filesystem::path const& paper);

/// The table as CSV: machine,figure,measured,unit,predicted,ratio,at_least,bound_by,missing,source.
std::string judges_csv(std::vector<Judge> const& judges);

/// Errors by machine, what bounds its rows, errors by the bytes of a transfer, and the worst rows. Returns false if a bound of documented
/// rates is above a measured time.
bool print_judges(std::vector<Judge> const& judges, std::uint32_t worst);

} // namespace silicon
