#include "options.hpp"
#include "../../examples/shared/text.hpp"
#include <cstdlib>
#include <iostream>
#include <system_error>
#include <tilemesh/error.hpp>

namespace bench {

using tilemesh::Error;

shared::OptionTable table_of(About const& about, Options& own)
{
    using shared::option;
    static constexpr shared::Option<Options> rows[] = {
        option<&Options::csv>("csv", "FILE", ""),
        option<&Options::data>("data", "DIR",
                               "maps/, trajectories/ and cameras.json; a bench skips maps that are missing [the environment variable TILEMESH_DATA]"),
        option<&Options::quick>("quick", "", ""), option<&Options::help>("help", "", "this text"),
        option<&Options::spoil>("spoil", "", "give the rasteriser other blending rules than the mesh: the checks must fail")};
    own.reads = about.reads;
    shared::OptionTable table(about.name, "usage: " + std::string(about.name) + " [options]\n" + about.what);
    table.add("", own, std::span(rows).first(about.spoils ? 5 : 4));
    table.says("csv", about.csv);
    table.says("quick", about.quick);
    table.ends_with("\nExit status: 0: all checks hold. 1: a check fails. 2: an error; one line on standard error names the\n"
                    "problem, the reason and a remedy.\n");
    return table;
}

void Options::finish(shared::OptionTable const& given)
{
    if (!reads) return;
    bool const named = given.is_given("data");
    if (char const* const folder = std::getenv("TILEMESH_DATA"); folder != nullptr && !named) data = folder;
    if (!data.empty() && std::filesystem::is_directory(data / "maps")) return;
    if (named)
        throw Error("--data cannot be \"" + shared::one_line(data.string(), 60) +
                    "\" (there is no folder maps in it); name the folder that holds maps/, trajectories/ and cameras.json");
    data.clear();
}

void expect_folder_of(std::filesystem::path const& file)
{
    if (!file.empty() && file.has_parent_path() && !std::filesystem::is_directory(file.parent_path()))
        throw Error("cannot write " + file.string() + " (its folder is not there); make the folder, or name another file");
    if (std::filesystem::is_directory(file)) throw Error("cannot write " + file.string() + " (it is a folder); name a file");
}

void make_folder(std::filesystem::path const& folder, char const* option)
{
    if (folder.empty()) return;
    std::error_code why;
    std::filesystem::create_directories(folder, why);
    if (!std::filesystem::is_directory(folder))
        throw Error("cannot make the folder " + folder.string() + " (" + why.message() + "); name another with " + option);
}

void say_skipped(std::string const& name, char const* what)
{
    std::cout << "skipped: " << name << " (its " << what << " is not there; name its folder with --data)\n";
}

int verdict(std::vector<std::string> const& broken, char const* all_hold)
{
    for (auto const& what : broken) std::cout << "BROKEN: " << what << "\n";
    if (broken.empty() && *all_hold != '\0') std::cout << all_hold << "\n";
    return broken.empty() ? 0 : 1;
}

} // namespace bench
