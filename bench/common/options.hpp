#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace bench {

/// The words of a command line, one option after the other: `--name`, `--name value` or `--name=value`. Throws tilemesh::Error for a value
/// that is missing, not allowed or invalid.
class Words {
public:
    explicit Words(std::vector<std::string> words) : words_(std::move(words)) {}

    /// Goes to the next option; false if there is none.
    bool next();
    std::string const& option() const noexcept { return option_; }
    /// The value of the option. `flag`: the option takes none.
    void flag() const;
    std::string value();
    std::filesystem::path path();
    std::uint32_t number(std::uint32_t least, std::uint32_t most);
    template <std::size_t N>
    std::string one_of(char const* const (&names)[N])
    {
        return one_of(std::vector<std::string>(names, names + N));
    }
    std::string one_of(std::vector<std::string> const& names);
    /// Refuses an unknown option.
    [[noreturn]] void refuse() const;

private:
    std::vector<std::string> words_;
    std::size_t at_ = 0;
    std::string option_;
    bool has_value_ = false;
};

/// The options of every bench.
struct Options {
    std::filesystem::path data; ///< with maps/, trajectories/ and cameras.json; empty if there is none
    std::filesystem::path csv;  ///< empty: not written
    bool quick = false;
    bool spoil = false; ///< the rasteriser blends by wrong rules: a bench that compares pictures must report it
    bool help = false;

    /// Takes the current option of `words` if it is one of these. `may_spoil`: the bench compares pictures.
    bool take(Words& words, bool may_spoil = false);
    /// Call it after all words are taken: finds the data folder if none was named. Throws Error for a folder without data.
    void finish();

private:
    bool data_given_ = false;
};

/// Lines of `--help` that several have.
inline constexpr char const* help_of_data =
    "  --data DIR       maps/, trajectories/ and cameras.json; default: the environment variable TILEMESH_DATA. A bench\n"
    "                   skips maps that are missing\n";
inline constexpr char const* help_of_spoil =
    "  --spoil          give the rasteriser other blending rules than the mesh: the checks must fail\n";
inline constexpr char const* help_of_exit =
    "Exit status: 0: all checks hold. 1: a check fails. 2: an error; one line on standard error names the problem, the reason\n"
    "and a remedy.\n";

/// With --spoil the rasteriser clamps alpha at this value. Every map has Gaussians that are more opaque.
inline constexpr float spoilt_alpha_max = 0.5f;

/// Is `names` empty, or does it contain this name?
inline bool chosen(std::vector<std::string> const& names, std::string const& name)
{
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

/// Throws Error if a file's folder does not exist, or if the file is a folder. A bench should notice this before it measures for minutes.
void expect_folder_of(std::filesystem::path const& file);

} // namespace bench
