// The tables and figures of the paper's results, compared with the counts, models and predictions of this library.
#include "options.hpp"
#include "print.hpp"
#include "stages.hpp"
#include "tables.hpp"
#include <chrono>
#include <common/program.hpp>
#include <filesystem>
#include <iostream>
#include <string>
#include <system_error>
#include <tilemesh/error.hpp>
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

shared::OptionTable options_of(paper::Options& own)
{
    static std::vector<shared::Word> words; // the rows have views of them
    if (words.empty())
        for (auto const& table : tables) words.emplace_back(table.name, words.size());
    return paper::table_of(own, words);
}

int run(paper::Options const& options)
{
    bench::expect_folder_of(options.csv);
    if (!options.out.empty()) {
        std::error_code why;
        std::filesystem::create_directories(options.out, why);
        if (!std::filesystem::is_directory(options.out))
            throw tilemesh::Error("cannot make the folder " + options.out.string() + " (" + why.message() +
                                  "); name another with --out");
    }
    paper::Context const context{options.data, options.out, options.threads, options.quick};
    paper::Rows rows;
    auto const begin = std::chrono::steady_clock::now();
    for (auto const& table : tables) {
        if (!bench::chosen(options.tables, table.name)) continue;
        table.append(context, rows);
        auto const seconds =
            std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - begin).count();
        std::cerr << table.name << " (" << seconds << " s)\n";
    }
    paper::print(std::cout, rows);
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, paper::csv(rows));
    for (auto const& row : rows)
        if (row.broken) return 1;
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, options_of, run,
                          "not enough memory (the largest map has a quarter of a million records); try --quick or fewer tables");
}
