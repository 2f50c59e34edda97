#pragma once
#include "../../examples/shared/option_table.hpp"
#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace bench {

/// The options of every bench. A bench derives its own from them.
struct Options {
    std::filesystem::path data; ///< with maps/, trajectories/ and cameras.json; empty if there is none
    std::filesystem::path csv;  ///< empty: not written
    bool quick = false;
    bool spoil = false; ///< the rasteriser blends by wrong rules: a bench that compares pictures must report it
    bool help = false;
    bool reads = true; ///< of `About`

    /// Is called after all words are taken: finds the data folder if none was named. Throws Error for a folder without data.
    void finish(shared::OptionTable const& given);
};

/// What --help says of a bench.
struct About {
    char const* name;
    char const* what;  ///< whole lines
    char const* quick; ///< what --quick does
    char const* csv = "write the rows";
    bool spoils = true; ///< it has --spoil
    bool reads = true;  ///< it reads what --data names
};
/// The table of a bench's options: its own rows, then those of every bench.
shared::OptionTable table_of(About const& about, Options& own);
template <class Own, class Rows>
shared::OptionTable table_of(About const& about, Own& own, Rows const& rows)
{
    auto table = table_of(about, own);
    table.add("", own, rows);
    return table;
}

/// With --spoil the rasteriser clamps alpha at this value. Every map has Gaussians that are more opaque.
inline constexpr float spoilt_alpha_max = 0.5f;

/// Is `names` empty, or does it contain this name?
inline bool chosen(std::vector<std::string> const& names, std::string const& name)
{
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

/// Throws Error if a file's folder does not exist, or if the file is a folder. A bench should notice this before it measures for minutes.
void expect_folder_of(std::filesystem::path const& file);
/// Makes the folder that `option` names; nothing for an empty name. Throws Error if it cannot.
void make_folder(std::filesystem::path const& folder, char const* option);

/// Says that a scene (or a scene with a motion) is left out, because there is no such file.
void say_skipped(std::string const& name, char const* what = "map");
/// Prints a line for each check that fails, or `all_hold` if none does. Returns the exit status.
int verdict(std::vector<std::string> const& broken, char const* all_hold = "All that must hold does.");

} // namespace bench
