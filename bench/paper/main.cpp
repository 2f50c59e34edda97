// The tables and figures of the paper's results, compared with the counts, models and predictions of this library.
#include "tables.hpp"
#include <algorithm>
#include <cmath>
#include <common/program.hpp>
#include <common/statistics.hpp>
#include <filesystem>
#include <iostream>
#include <string>
#include <thread>
#include <tilemesh/report/whole_file.hpp>
#include <vector>

namespace {

struct Table {
    char const* name;
    void (*append)(paper::Context const&, paper::Rows&);
};
/// The tables, in the paper's order.
constexpr Table tables[] = {
    {"memory", paper::memory},   {"fps", paper::fps},
    {"host_io", paper::host_io}, {"load", paper::load},
    {"power", paper::power},     {"stage", paper::stages},
    {"churn", paper::churn},     {"saturation", paper::saturation},
    {"latency", paper::latency}, {"convergence", paper::convergence},
};

struct Options : bench::Options {
    std::filesystem::path out;       ///< a folder for pictures; empty: none
    std::vector<std::string> tables; ///< empty: all
    std::uint32_t threads = std::max(1u, std::thread::hardware_concurrency());
};
shared::OptionTable options_of(Options& own)
{
    static std::vector<shared::Word> words; // the rows have views of them
    if (words.empty())
        for (auto const& table : tables) words.emplace_back(table.name, words.size());
    using shared::option;
    shared::Option<Options> const rows[] = {
        shared::words<&Options::tables>("table", "NAME", "{}; may be repeated [all]", words),
        option<&Options::out>("out", "DIR", "SVG plots and PNG pictures"),
        option<&Options::threads>("threads", "N", "host threads; results do not depend on them [all of this machine's]", {1, 1024})};
    return bench::table_of({"paper",
                            "Prints the tables and figures of the paper's results beside ours: table | row | quantity | paper | ours |\n"
                            "ratio | kind. If the paper's text gives no number, `paper` is \"no figure in the source\". If a map is\n"
                            "missing, `ours` is \"skipped\". `kind` says how ours was found: counted on a machine or by projection,\n"
                            "modelled in cycles, predicted from a placement, fitted, or by arithmetic.\n",
                            "fewer frames and maps, smaller saturated pictures", "the rows, with a note on each", false},
                           own, rows);
}

int run(Options const& options)
{
    bench::expect_folder_of(options.csv);
    bench::make_folder(options.out, "--out");
    paper::Context const context{options.data, options.out, options.threads, options.quick};
    paper::Rows rows;
    double seconds = 0;
    bench::Stopwatch watch;
    for (auto const& table : tables) {
        if (!bench::chosen(options.tables, table.name)) continue;
        table.append(context, rows);
        seconds += watch.lap() / 1000;
        std::cerr << table.name << " (" << bench::fixed(std::floor(seconds), 0) << " s)\n";
    }
    paper::print(std::cout, rows);
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, paper::csv(rows));
    return std::any_of(rows.begin(), rows.end(), [](paper::Row const& row) { return row.broken; }) ? 1 : 0;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, options_of, run,
                          "not enough memory (the largest map has a quarter of a million records); try --quick or fewer tables");
}
