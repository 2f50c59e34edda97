#pragma once
#include "../standard.hpp"

// The catalogue of stiff and extreme cases as tests. There is a case named "row N: ..." for each row that applies, and one
// `does_not_apply(N, why)` for each row that does not. tests/checks/stability.sh checks that every row occurs once.
// tests/stability/table.sh writes the table of tests/stability/README.md from the results that the cases report here.
namespace stability {

/// The result of a row's case. `naive` and `ours` are measured, in words or as `number` writes them.
struct Result {
    int row;
    std::string input;
    std::string naive;     ///< result of the naive float32 kernel
    std::string ours;
    std::string tolerance;
    bool bites;            ///< the naive kernel fails the same tolerance; the case has checked this
};

inline std::string number(double v)
{
    char text[32];
    std::snprintf(text, sizeof text, std::fabs(v) >= 1e-3 && std::fabs(v) < 1e5 ? "%.3g" : "%.1e", v);
    return v == 0 ? "0" : text;
}

/// Adds a line to the file that TILEMESH_STABILITY_TABLE names, if it names one.
inline void write_line(std::string const& line)
{
    if (char const* const path = std::getenv("TILEMESH_STABILITY_TABLE")) std::ofstream(path, std::ios::app) << line << '\n';
}
inline void report(Result const& r)
{
    write_line(std::to_string(r.row) + "\t" + r.input + "\t" + r.naive + "\t" + r.ours + "\t" + r.tolerance + "\t" +
               (r.bites ? "bites" : "-"));
}
inline void does_not_apply(int row, char const* why)
{
    CHECK(row > 0);
    write_line(std::to_string(row) + "\t\t\t\t\tdoes not apply: " + why);
}

} // namespace stability
