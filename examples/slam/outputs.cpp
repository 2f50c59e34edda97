#include "outputs.hpp"
#include "../shared/output_files.hpp"
#include "checkpoint.hpp"
#include <algorithm>
#include <iterator>
#include <string>
#include <tilemesh/report/distinct_files.hpp>
#include <unistd.h>

namespace slam_program {

namespace fs = std::filesystem;

void prepare_outputs(Options const& options, std::vector<fs::path> const& read)
{
    constexpr char const *out_remedy = "name another directory with --out", *report_remedy = "name another file with --report",
                         *page_remedy = "name another file with --page";
    shared::make_folder(options.out, "--out");
    for (char const* const name : out_files) shared::check_file(options.out / name, "a result", out_remedy);
    if (options.resume)
        for (char const* const name : {checkpoint_file, set_aside_file})
            shared::check_file(options.out / name, "the checkpoint", out_remedy);
    if (options.report) shared::check_file(*options.report, "the report", report_remedy);
    if (options.page) shared::check_file(*options.page, "the page", page_remedy);
    tilemesh::report::DistinctFiles files;
    for (auto const& file : read) files.read(file);
    if (!options.quiet) files.write_stream(STDOUT_FILENO, "standard output", "send it to another file, or use --quiet");
    files.write_stream(STDERR_FILENO, "standard error", "send it to another file");
    auto const is_result = [&](std::string const& name) {
        if (options.resume && (name == checkpoint_file || name == set_aside_file)) return true;
        return std::find(std::begin(out_files), std::end(out_files), name) != std::end(out_files);
    };
    files.write_into(options.out, is_result, "a result", out_remedy);
    if (options.report) files.write(*options.report, "the report", report_remedy);
    if (options.page) files.write(*options.page, "the page", page_remedy);
}

} // namespace slam_program
