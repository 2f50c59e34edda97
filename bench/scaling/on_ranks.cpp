// The engine over the ranks of MPI: scaling, supersteps with and without records at the edges of bands, traffic, waiting, memory.
#include "scaling.hpp"
#include "ranks.hpp"
#include <algorithm>
#include <bit>
#include <common/statistics.hpp>
#include <cstring>
#include <fstream>
#include <iostream>
#include <malloc.h>
#include <memory>
#include <mpi.h>
#include <string>
#include <string_view>
#include <thread>
#include <tilemesh/mpi/mpi_mesh.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <utility>
#include <vector>

namespace scaling {

namespace {

using namespace tilemesh;

// --- the programs ------------------------------------------------------------------------------------------------------
constexpr std::uint32_t edge = 16; ///< cells along the edge of a tile's block

struct Block {
    float kelvin[edge][edge];
};
struct Cells {
    float kelvin[edge];
};
struct Rim : Channel<Cells, 1> {};
/// The heat equation on 16 x 16 cells a tile. Outside of the grid it is as warm as at its edge.
struct Relax {
    static constexpr char const* name = "relax";
    void operator()(Block& block, In<Rim> in, Out<Rim> out) const noexcept
    {
        auto& now = block.kelvin;
        float old[edge + 2][edge + 2];
        for (std::uint32_t y = 0; y < edge; ++y) std::memcpy(&old[y + 1][1], now[y], sizeof now[y]);
        for (std::uint32_t i = 0; i < edge; ++i) {
            old[0][i + 1] = rim(in, Direction::north, i, now[0][i]);
            old[edge + 1][i + 1] = rim(in, Direction::south, i, now[edge - 1][i]);
            old[i + 1][0] = rim(in, Direction::west, i, now[i][0]);
            old[i + 1][edge + 1] = rim(in, Direction::east, i, now[i][edge - 1]);
        }
        for (std::uint32_t y = 0; y < edge; ++y)
            for (std::uint32_t x = 0; x < edge; ++x) {
                float const flow = old[y][x + 1] + old[y + 2][x + 1] + old[y + 1][x] + old[y + 1][x + 2] - 4 * old[y + 1][x + 1];
                now[y][x] = old[y + 1][x + 1] + 0.2f * flow;
            }
        Cells north, south, west, east;
        for (std::uint32_t i = 0; i < edge; ++i) {
            north.kelvin[i] = now[0][i];
            south.kelvin[i] = now[edge - 1][i];
            west.kelvin[i] = now[i][0];
            east.kelvin[i] = now[i][edge - 1];
        }
        out[Direction::north].unchecked_push(north);
        out[Direction::south].unchecked_push(south);
        out[Direction::west].unchecked_push(west);
        out[Direction::east].unchecked_push(east);
    }

private:
    static float rim(In<Rim> const& in, Direction side, std::uint32_t i, float own) noexcept
    {
        return in[side].empty() ? own : in[side][0].kelvin[i];
    }
};
using Heat = Repeat<Relax>;

/// 60 bytes, the size of a Gaussian.
struct Parcel {
    std::uint32_t words[15];
};
struct Wire : Channel<Parcel, 100> {};
struct Turns {
    std::uint32_t left;         ///< passes in which this tile sends, and stays busy
    std::uint32_t north, south; ///< records to each of these sides in each of them
};
/// Tiles that the host chose send records over the edges of bands. All others are idle.
struct Tick {
    static constexpr char const* name = "tick";
    Vote operator()(Turns& turns, In<Wire> in, Out<Wire> out) const noexcept
    {
        (void)in;
        if (turns.left == 0) return Vote::quiet;
        --turns.left;
        Parcel parcel;
        for (std::uint32_t i = 0; i < 15; ++i) parcel.words[i] = turns.left + i;
        for (std::uint32_t i = 0; i < turns.north; ++i) out[Direction::north].push(parcel);
        for (std::uint32_t i = 0; i < turns.south; ++i) out[Direction::south].push(parcel);
        return turns.left != 0 ? Vote::busy : Vote::quiet;
    }
};
using Ticking = Sequence<Superstep<Tick>, UntilQuiet<Tick>>;
using Roomy = TestMachine<64u << 20>; // room for both programs, and any number of tiles

// --- one line of the table ---------------------------------------------------------------------------------------------
struct Line {
    std::string what;
    Grid grid{1, 1};
    std::uint32_t threads = 1, records = 0;
    std::shared_ptr<Team> team;
    std::vector<double> us;                                    ///< time of a superstep, by round
    std::vector<double> waiting;                               ///< share of the time in which the ranks of the team wait, by round
    double messages = 0, bytes = 0, agreements = 0;            ///< of a rank in a superstep: the mean over ranks
    std::uint64_t checksum = 0;                                ///< of all states after the run

    virtual ~Line() = default;
    /// Runs the program once. Returns its counters, and the time in ms of its supersteps. Collective over the team.
    virtual std::pair<RunCounters, double> run() = 0;
    /// The number of supersteps that the time is of.
    virtual double supersteps(RunCounters const&) const = 0;

    void measure()
    {
        meet();
        if (team->contains_me()) {
            MPI_Barrier(team->comm());
            calls = {};
            auto const [counters, ms] = run();
            auto const passes = supersteps(counters);
            double sums[] = {calls.messages, calls.bytes, calls.agreements, calls.waiting_ms};
            MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_DOUBLE, MPI_SUM, team->comm());
            us.push_back(1000 * ms / passes);
            waiting.push_back(sums[3] / team->ranks() / ms);
            messages = sums[0] / team->ranks() / passes;
            bytes = sums[1] / team->ranks() / passes;
            agreements = sums[2] / team->ranks() / passes;
        }
        meet();
    }
};

struct HeatLine final : Line {
    HeatLine(std::shared_ptr<Team> on, Grid g, std::uint32_t with_threads, std::uint32_t times)
    {
        team = std::move(on), grid = g, threads = with_threads;
        if (team->contains_me())
            mesh_ = std::make_unique<MpiMesh<Heat, Roomy>>(team->comm(), Heat{times}, grid, MpiMeshOptions{.threads = threads});
    }
    std::pair<RunCounters, double> run() override
    {
        for (auto [tile, block] : mesh_->states<Block>())
            for (std::uint32_t y = 0; y < edge; ++y)
                for (std::uint32_t x = 0; x < edge; ++x)
                    block.kelvin[y][x] = static_cast<float>((tile.x() * edge + x) * 7 + (tile.y() * edge + y) * 13 % 101);
        calls = {};
        auto counters = mesh_->run();
        checksum = 0;
        for (auto [tile, block] : mesh_->states<Block>())
            for (auto const& row : block.kelvin)
                for (float const k : row) checksum += (tile.packed * 2654435761u + 1) * std::uint64_t{std::bit_cast<std::uint32_t>(k)};
        PMPI_Allreduce(MPI_IN_PLACE, &checksum, 1, MPI_UINT64_T, MPI_SUM, team->comm());
        auto const ms = counters.steps.at(0).milliseconds;
        return {std::move(counters), ms};
    }
    double supersteps(RunCounters const& c) const override { return static_cast<double>(c.steps.at(0).passes); }

private:
    std::unique_ptr<MpiMesh<Heat, Roomy>> mesh_;
};

/// `records` records cross each edge between two bands in each direction and superstep. With one rank, they cross the middle of the grid.
struct TickLine final : Line {
    TickLine(std::shared_ptr<Team> on, std::uint32_t n, std::uint32_t with_threads, std::uint32_t turns) : turns_(turns)
    {
        team = std::move(on), records = n, threads = with_threads;
        grid = Grid{100, 8 * world_size()};
        if (!team->contains_me()) return;
        mesh_ = std::make_unique<MpiMesh<Ticking, Roomy>>(team->comm(), Ticking{}, grid, MpiMeshOptions{.threads = threads});
    }
    std::pair<RunCounters, double> run() override
    {
        auto const& bands = mesh_->bands();
        std::vector<std::uint32_t> edges; // the rows south of an edge
        for (std::uint32_t r = 1; r < bands.ranks(); ++r) edges.push_back(bands.first(r));
        if (edges.empty()) edges.push_back(grid.height / 2);
        auto const share = [&](std::uint32_t x) { return records / grid.width + (x < records % grid.width ? 1 : 0); };
        for (auto [tile, turns] : mesh_->states<Turns>()) {
            turns = {0, 0, 0};
            if (tile.x() == 0 && tile.y() == 0) turns.left = turns_; // one tile is busy in every line
            for (auto const y : edges) {
                if (tile.y() + 1 == y) turns.south = share(tile.x());
                if (tile.y() == y) turns.north = share(tile.x());
            }
            if (turns.south + turns.north != 0) turns.left = turns_;
        }
        calls = {};
        auto counters = mesh_->run();
        auto const ms = counters.steps.at(0).milliseconds + counters.steps.at(1).milliseconds;
        checksum = counters.messages() / edges.size();
        return {std::move(counters), ms};
    }
    double supersteps(RunCounters const& c) const override { return static_cast<double>(c.steps.at(0).passes + c.steps.at(1).passes); }

private:
    std::uint32_t turns_;
    std::unique_ptr<MpiMesh<Ticking, Roomy>> mesh_;
};

// --- the network -------------------------------------------------------------------------------------------------------
/// Between ranks 0 and 1: half a round trip of 4 bytes, the call that sends them, and the bandwidth of messages of 4 MiB. Returns
/// microseconds, microseconds and bytes per microsecond.
struct Link {
    std::vector<double> latency_us, overhead_us, bytes_per_us;
};
void measure(Link& link, bool quick)
{
    meet();
    if (auto const me = world_rank(); me < 2 && world_size() > 1) {
        std::vector<char> buffer(4 << 20);
        auto const bounce = [&](int bytes, int times) { // ms
            bench::Stopwatch watch;
            for (int i = 0; i < times; ++i)
                for (int turn = 0; turn < 2; ++turn)
                    if (me == turn)
                        MPI_Send(buffer.data(), bytes, MPI_CHAR, 1 - me, 0, MPI_COMM_WORLD);
                    else
                        MPI_Recv(buffer.data(), bytes, MPI_CHAR, 1 - me, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
            return watch.lap();
        };
        int const times = quick ? 100 : 1000;
        bounce(4, times);
        link.latency_us.push_back(1000 * bounce(4, times) / times / 2);
        link.bytes_per_us.push_back(2.0 * static_cast<double>(buffer.size()) * 10 / (1000 * bounce(static_cast<int>(buffer.size()), 10)));
        double sending_ms = 0;
        for (int i = 0; i < times; ++i) {
            MPI_Request request;
            bench::Stopwatch watch;
            if (me == 0)
                PMPI_Isend(buffer.data(), 4, MPI_CHAR, 1, 0, MPI_COMM_WORLD, &request);
            else
                PMPI_Irecv(buffer.data(), 4, MPI_CHAR, 0, 0, MPI_COMM_WORLD, &request);
            sending_ms += watch.lap();
            PMPI_Wait(&request, MPI_STATUS_IGNORE);
        }
        link.overhead_us.push_back(1000 * sending_ms / times);
    }
    meet();
}
/// The agreement of a program with two channels: nine words.
double agreement_us(Team const& team, int times)
{
    std::uint64_t words[9] = {};
    MPI_Barrier(team.comm());
    bench::Stopwatch watch;
    for (int i = 0; i < times; ++i) {
        MPI_Request request;
        PMPI_Iallreduce(MPI_IN_PLACE, words, 9, MPI_UINT64_T, MPI_SUM, team.comm(), &request);
        PMPI_Wait(&request, MPI_STATUS_IGNORE);
    }
    return 1000 * watch.lap() / times;
}

// --- memory ------------------------------------------------------------------------------------------------------------
/// The largest resident set of this process since the last reset, in bytes.
double peak_bytes()
{
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
        if (word == "VmHWM:") {
            double kilobytes = 0;
            status >> kilobytes;
            return 1024 * kilobytes;
        }
    return 0;
}
/// The largest peak of a rank, with the rest of the process, while the team builds and runs a mesh. Collective over the world.
template <class Program, class Load>
double peak_of(Team const& team, Program const& program, Grid grid, Load const& load)
{
    meet();
    ::malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5"; // the peak begins again
    double peak = 0;
    if (team.contains_me()) {
        MpiMesh<Program, Roomy> mesh{team.comm(), program, grid};
        load(mesh);
        mesh.run();
        peak = peak_bytes();
        MPI_Allreduce(MPI_IN_PLACE, &peak, 1, MPI_DOUBLE, MPI_MAX, team.comm());
    }
    meet();
    return peak;
}

struct Peak {
    char const* what;
    std::uint32_t ranks;
    double bytes, share;
};
std::vector<Peak> measure_memory(std::vector<std::shared_ptr<Team>> const& teams, Grid grid)
{
    std::vector<Peak> peaks;
    for (bool const blocks : {true, false}) {
        double alone = 0;
        for (auto const& team : teams) {
            auto const bytes = blocks ? peak_of(*team, Heat{2}, grid,
                                                [](auto& mesh) {
                                                    for (auto [tile, block] : mesh.template states<Block>()) block.kelvin[0][0] = 300;
                                                })
                                      : peak_of(*team, Ticking{}, grid, [](auto& mesh) {
                                            for (auto [tile, turns] : mesh.template states<Turns>()) turns = {1, 0, 0};
                                        });
            if (alone == 0) alone = bytes;
            peaks.push_back({blocks ? "heat, 1,024 bytes a tile" : "tick, 12 bytes a tile", team->ranks(), bytes, bytes / alone});
        }
    }
    return peaks;
}

// --- all of it ---------------------------------------------------------------------------------------------------------
std::string text_of(Grid grid)
{
    return std::to_string(grid.width) + " x " + std::to_string(grid.height);
}
/// The line that `line` is compared with: the same on one rank and one thread.
Line const& alone(std::vector<std::unique_ptr<Line>> const& lines, Line const& line)
{
    return **std::find_if(lines.begin(), lines.end(), [&](auto const& l) {
        return l->what == line.what && l->records == line.records && l->team->ranks() == 1 && l->threads == 1;
    });
}

} // namespace

OnRanks::OnRanks(int argc, char** argv)
{
    on_ = std::any_of(argv, argv + argc, [](char const* word) { return std::string_view(word) == "--ranks"; });
    if (!on_) return;
    int level = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level);
    if (world_rank() == 0) return;
    std::cout.setstate(std::ios::failbit);
    std::cerr.setstate(std::ios::failbit);
}
OnRanks::~OnRanks()
{
    if (on_) MPI_Finalize();
}

int run_on_ranks(Options const& options)
{
    if (options.frames) return frames_on_ranks(options);
    bench::expect_folder_of(options.csv);
    auto threads = options.threads;
    if (std::find(threads.begin(), threads.end(), 1u) == threads.end()) threads.insert(threads.begin(), 1); // speed-ups are over one thread
    std::vector<std::shared_ptr<Team>> teams;
    for (auto const n : numbers_of_ranks()) teams.push_back(std::make_shared<Team>(n));

    auto const large = options.quick ? Grid{100, 85} : Grid{1000, 850};
    auto const peaks = measure_memory(teams, large);
    std::cerr << "memory\n";

    std::vector<std::unique_ptr<Line>> lines;
    std::uint32_t const times = options.quick ? 5 : 40, turns = options.quick ? 50 : 1000;
    std::uint32_t const height = options.quick ? 12 : 48;
    for (auto const& team : teams)
        for (auto const t : threads) {
            lines.push_back(std::make_unique<HeatLine>(team, Grid{96, height * 2}, t, times));
            lines.back()->what = "strong";
            lines.push_back(std::make_unique<HeatLine>(team, Grid{96, height * team->ranks()}, t, times));
            lines.back()->what = "weak";
        }
    for (auto const& team : teams)
        for (std::uint32_t const n : {0u, 1u, 10u, 100u, 1'000u, 10'000u}) {
            lines.push_back(std::make_unique<TickLine>(team, n, 1, n > 100 ? turns / 10 : turns));
            lines.back()->what = n == 0 ? "idle" : "records";
        }
    Link link;
    std::vector<std::vector<double>> agreements(teams.size());
    std::uint32_t const rounds = options.quick ? 2 : 9;
    for (std::uint32_t round = 0; round <= rounds; ++round) { // round 0 touches all memory
        for (auto& line : lines) {
            line->measure();
            if (round == 0) line->us.clear(), line->waiting.clear();
        }
        measure(link, options.quick);
        for (std::size_t i = 0; i < teams.size(); ++i) {
            meet();
            if (teams[i]->contains_me()) agreements[i].push_back(agreement_us(*teams[i], options.quick ? 50 : 500));
            meet();
        }
        std::cerr << "round " << round << " of " << rounds << "\n";
    }
    if (world_rank() != 0) return 0;

    std::cout << "MpiMesh on " << world_size() << " ranks, " << std::thread::hardware_concurrency() << " processors.\n";
    tilemesh::report::Table table{{"what", "tiles", "records an edge", "ranks", "threads", "us a superstep (20 to 80 %)", "speed-up",
                                   "messages a rank", "bytes a rank", "agreements", "waiting, %"}};
    std::string csv = "part,tiles,records,ranks,threads,us,us_low,us_high,speed_up,messages,bytes,agreements,waiting,peak_bytes\n";
    bool same = true;
    for (auto const& line : lines) {
        auto const& one = alone(lines, *line);
        auto const us = bench::median(line->us);
        auto const work = line->what == "weak" ? static_cast<double>(line->grid.size()) / one.grid.size() : 1;
        auto const speed_up = work * bench::median(one.us) / us;
        if (line->what != "weak" && line->checksum != one.checksum) {
            same = false;
            std::cout << "BROKEN: " << line->what << ", " << line->team->ranks() << " ranks, " << line->threads
                      << " threads: the result is not that of one rank\n";
        }
        table.add_row({line->what, text_of(line->grid), std::to_string(line->records), std::to_string(line->team->ranks()),
                       std::to_string(line->threads), spread(line->us), bench::fixed(speed_up, 2), bench::fixed(line->messages, 2),
                       bench::fixed(line->bytes, 0), bench::fixed(line->agreements, 2), bench::fixed(100 * bench::median(line->waiting), 0)});
        csv += line->what + "," + std::to_string(line->grid.size()) + "," + std::to_string(line->records) + "," +
               std::to_string(line->team->ranks()) + "," + std::to_string(line->threads) + "," + bench::fixed(us, 3) + "," +
               bench::fixed(bench::quantile(line->us, 0.2), 3) + "," + bench::fixed(bench::quantile(line->us, 0.8), 3) + "," +
               bench::fixed(speed_up, 3) + "," + bench::fixed(line->messages, 3) + "," + bench::fixed(line->bytes, 1) + "," +
               bench::fixed(line->agreements, 3) + "," + bench::fixed(bench::median(line->waiting), 3) + ",\n";
    }
    std::cout << table << "\n";
    tilemesh::report::Table memory{{"memory", "tiles", "ranks", "largest peak of a rank, MB", "of one rank's"}};
    for (auto const& p : peaks) {
        memory.add_row({p.what, text_of(large), std::to_string(p.ranks), bench::fixed(p.bytes / 1e6, 0), bench::fixed(p.share, 2)});
        csv += "memory of " + std::string(p.what).substr(0, 4) + "," + std::to_string(large.size()) + ",," + std::to_string(p.ranks) +
               ",1,,,,,,,,," + bench::fixed(p.bytes, 0) + "\n";
    }
    std::cout << memory << "\n";
    if (world_size() > 1)
        std::cout << "Between two ranks: " << spread(link.latency_us) << " us latency, " << spread(link.overhead_us)
                  << " us overhead, " << bench::fixed(bench::median(link.bytes_per_us) / 1000, 2) << " GB/s.\n";
    for (std::size_t i = 0; i < teams.size(); ++i)
        std::cout << "Agreement of " << teams[i]->ranks() << (teams[i]->ranks() == 1 ? " rank: " : " ranks: ") << spread(agreements[i]) << " us.\n";
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv);
    if (same) std::cout << "All results are the same, bit for bit.\n";
    return same ? 0 : 1;
}

} // namespace scaling
