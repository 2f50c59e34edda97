#pragma once
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <utility>
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

/// A row without our figure.
inline Row skipped(char const* table, std::string row, char const* quantity, std::optional<double> paper, char const* kind, std::string const& why)
{
    return {table, std::move(row), quantity, paper, {}, kind, "skipped: " + why};
}

/// The input of every table.
struct Context {
    std::filesystem::path data; ///< empty: no data; tables that need data say "skipped"
    std::filesystem::path out;  ///< for pictures and plots; empty: none are written
    std::uint32_t threads = 2;
    bool quick = false;         ///< fewer frames, in tables that say so
};

// One function for each table or figure of the paper's results. It appends its rows, and writes its picture if there is a folder for
// pictures. If a map is missing, a table appends the paper's rows without ours.

/// Bytes of each scene, the share of a scene that a tile's buffer holds, slots of channels and storage, and the ledgers of our presets.
void memory(Context const&, Rows&);
/// Modelled frames per second of the library's kernels against the number of Gaussians.
void fps(Context const&, Rows&);
/// Power times time: the paper's own arithmetic, and modelled times with the paper's power.
void power(Context const&, Rows&);
/// Milliseconds of each stage over the tiles: the authors' prototype as a program, with prices that are fitted on Salad alone.
void stages(Context const&, Rows&);
/// The number of Gaussians whose anchor tile changes between two frames, in six motions on Sloth.
void churn(Context const&, Rows&);
/// The number of Gaussians per tile in near, middle and far views.
void load(Context const&, Rows&);
/// Supersteps until all records and copies are on their tiles: after a cold start, and after the camera moved back.
void convergence(Context const&, Rows&);
/// Bytes between host and machine, and their share of the time.
void host_io(Context const&, Rows&);
/// Pictures of a dense scene with full channels; their holes are those of the list of dropped records. Beside each there is the complete
/// picture and a plan: tiles of the list in grey, pixels that differ in white.
void saturation(Context const&, Rows&);
/// The number of frames until a Gaussian whose anchor moved is on its tile, with one and with more hops a frame.
void latency(Context const&, Rows&);

/// Prints the rows as columns, then each violated condition on a line.
void print(std::ostream&, Rows const&);
/// The rows as CSV, with notes: `table,row,quantity,paper,ours,ratio,kind,how,note`. Rows and quantities are tokens (`route_mean_ms`).
/// `kind` is measured, modelled, fitted, null_model, or no_figure if the paper has none. `how` is the kind that `print` shows. Notes are
/// quoted if needed.
std::string csv(Rows const&);

} // namespace paper
