// The machine without splatting: the speed at which it moves records of 60 bytes by value, and the cost of a superstep in which almost
// nothing happens. Exit status 1 if a check fails.
#include "job.hpp"
#include <algorithm>
#include <common/program.hpp>
#include <iostream>
#include <sstream>
#include <tilemesh/report/whole_file.hpp>

using namespace traffic;

namespace {

shared::OptionTable table_of(bench::Options& own)
{
    auto table =
        bench::table_of({"mesh", "Moves records between random tiles and checks every arrival. Measures hops per second and an idle superstep.\n",
                         "run few rounds, and leave out the grid of 1,000 x 850 tiles",
                         "write the table: grid,records,capacity,threads,exchanges,hops,hops_per_s,idle_superstep_us,rss_bytes", false, false},
                        own);
    table.says("data", "accepted, not needed: this program reads no file");
    return table;
}

/// The median, and the band of the middle 60 %.
struct Band {
    double low, median, high;
};
Band band(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    auto const at = [&](double q) { return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)]; };
    return {at(0.2), at(0.5), at(0.8)};
}

struct Line {
    std::unique_ptr<Job> job;
    Run run;
    std::vector<double> hops_per_s, idle_us;
};

/// Measures all lines in turn, round after round, so that a busy moment of the computer affects all of them.
void measure(std::vector<Line>& lines, int rounds)
{
    for (int r = 0; r < rounds; ++r)
        for (auto& line : lines) {
            line.run = line.job->run();
            line.hops_per_s.push_back(static_cast<double>(line.run.hops) / line.run.seconds);
            line.idle_us.push_back(line.job->idle_seconds() * 1e6);
        }
}
void print(Line const& line)
{
    auto const& load = line.job->load();
    auto const hops = band(line.hops_per_s), idle = band(line.idle_us);
    std::printf("%4u x %-4u %8u %8u %7u %10llu %10llu   %6.1f (%.1f to %.1f) %10.2f (%.2f to %.2f) %8.1f\n", load.grid.width,
                load.grid.height, load.records, line.job->capacity(), line.job->threads(),
                static_cast<unsigned long long>(line.run.exchanges), static_cast<unsigned long long>(line.run.hops),
                hops.median / 1e6, hops.low / 1e6, hops.high / 1e6, idle.median, idle.low, idle.high,
                static_cast<double>(line.job->rss_bytes()) / 1e6);
    std::fflush(stdout);
}
void write(std::ostream& out, Line const& line)
{
    auto const& load = line.job->load();
    out << load.grid.width << 'x' << load.grid.height << ',' << load.records << ',' << line.job->capacity() << ','
        << line.job->threads() << ',' << line.run.exchanges << ',' << line.run.hops << ',' << band(line.hops_per_s).median << ','
        << band(line.idle_us).median << ',' << line.job->rss_bytes() << '\n';
}

int run(bench::Options const& options)
{
    bench::expect_folder_of(options.csv);
    int status = 0;
    std::ostringstream csv;
    csv << "grid,records,capacity,threads,exchanges,hops,hops_per_s,idle_superstep_us,rss_bytes\n";
    try {
        // The reference job: as many records as the largest of the paper's maps has Gaussians.
        Grid const paper{40, 36};
        std::uint32_t const records = 91'450;
        int const rounds = options.quick ? 3 : 15;
        std::printf("      grid  records capacity threads  exchanges       hops   M hops a second (band) us an idle superstep (band)  RSS MB\n");
        std::vector<Line> lines;
        auto const add = [](std::unique_ptr<Job> job, std::vector<Line>& to) {
            to.push_back({std::move(job), {}, {}, {}});
        };
        for (std::uint32_t threads : {1u, 2u}) {
            add(std::make_unique<Job>(Load{paper, paper, records}, Sizes{400, 200, 200}, threads), lines);
            add(std::make_unique<Job>(Load{{400, 250}, paper, records}, Sizes{400, 200, 200}, threads), lines);
            add(std::make_unique<Job>(Load{paper, paper, records}, Sizes{10, 200, 200}, threads), lines);
            add(std::make_unique<Job>(Load{paper, paper, records}, Sizes{4000, 200, 4000}, threads), lines);
        }
        measure(lines, rounds);
        for (auto const& line : lines) print(line);
        for (std::size_t i = 0; i < lines.size(); i += 4)
            std::printf("the same on 400 x 250 tiles, %u threads: %.2f times the time\n", lines[i].job->threads(),
                        band(lines[i].hops_per_s).median / band(lines[i + 1].hops_per_s).median);
        for (auto const& line : lines) write(csv, line);
        lines.clear();
        if (!options.quick) {
            // A record goes 617 hops on average here. Each channel end has four slots: every end is used sooner or later, and two buffers
            // of four slots are 5 KB per tile.
            Grid const field{1000, 850};
            for (std::uint32_t threads : {1u, 2u}) {
                std::vector<Line> one;
                add(std::make_unique<Job>(Load{field, field, 100'000}, Sizes{4, 16, 8}, threads), one);
                measure(one, 1); // about a minute each
                print(one[0]);
                write(csv, one[0]);
            }
        }
    } catch (Error const& broken) {
        std::cout << "BROKEN: " << broken.what() << "\n";
        status = 1;
    }
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv.str());
    return status;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, table_of, run, "not enough memory (the largest grid has 850,000 tiles); use --quick");
}
