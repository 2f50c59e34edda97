// Whole frames over the ranks of MPI: the threads of one rank against as many ranks, in turn.
#include "scaling.hpp"
#include "ranks.hpp"
#include <algorithm>
#include <common/scenes.hpp>
#include <common/statistics.hpp>
#include <cstring>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <tilemesh/mpi/mpi_mesh.hpp>
#include <tilemesh/render/ranks/host.hpp>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <utility>
#include <vector>

namespace scaling {

namespace {

using namespace tilemesh;
using OverRanks = BasicRenderer<splat::Lossless, MpiMesh>;

/// One way to run a motion. A frame's time is that of the slowest rank, until rank 0 has the picture.
struct Line {
    std::string motion;
    std::shared_ptr<Team> team;
    std::uint32_t threads = 1;
    bool weighted = false; ///< bands of equal work, not of equal height
    std::unique_ptr<OverRanks> renderer;
    std::vector<double> ms, project, route, bloom, composite, picture; ///< by frame
    std::vector<double> waiting;                                       ///< share of the time in MPI_Wait: the mean over ranks
    double messages = 0, bytes = 0, agreements = 0;                    ///< of a rank in the last frame: the mean over ranks
    RenderedFrame frame;

    void render(splat::Camera const& camera, bool measured)
    {
        meet();
        if (team->contains_me()) {
            calls = {};
            MPI_Barrier(team->comm());
            bench::Stopwatch watch;
            renderer->render_into(camera, frame);
            double ms_here = watch.lap();
            double sums[] = {calls.messages, calls.bytes, calls.agreements, calls.waiting_ms};
            MPI_Allreduce(MPI_IN_PLACE, &ms_here, 1, MPI_DOUBLE, MPI_MAX, team->comm());
            MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_DOUBLE, MPI_SUM, team->comm());
            if (measured) {
                auto const& host = frame.report.host_ms;
                ms.push_back(ms_here);
                project.push_back(host.project);
                route.push_back(host.route);
                bloom.push_back(host.bloom);
                composite.push_back(host.composite);
                picture.push_back(host.picture);
                waiting.push_back(sums[3] / team->ranks() / ms_here);
            }
            messages = sums[0] / team->ranks();
            bytes = sums[1] / team->ranks();
            agreements = sums[2] / team->ranks();
        }
        meet();
    }
};

std::string text_of(Line const& line)
{
    auto const ranks = line.team->ranks();
    return std::to_string(ranks) + (ranks == 1 ? " rank x " : " ranks x ") + std::to_string(line.threads) +
           (line.threads == 1 ? " thread" : " threads") + (line.weighted ? ", weighted" : "");
}
/// The work of each row of tiles in a moved frame, in nanoseconds: the time of projection by records, that of compositing by pairs. Rank 0
/// measures it, and every rank gets it. Collective over the world.
std::vector<std::uint32_t> work_of_rows(std::shared_ptr<Team> const& one, scene::Map const& map, std::vector<splat::Camera> const& cameras)
{
    std::vector<std::uint32_t> work(36);
    meet();
    if (one->contains_me()) {
        OverRanks renderer{map, {}, MpiMeshOptions{.comm = one->comm()}};
        RenderedFrame frame;
        for (std::size_t i = 0; i < 3; ++i) renderer.render_into(cameras[i], frame);
        auto const& mesh = std::as_const(renderer.mesh());
        std::vector<double> pairs(work.size()), records(work.size());
        double all_pairs = 1, all_records = 1;
        for (TileId const tile : mesh.grid().tiles()) {
            for (auto const evaluated : mesh.state<splat::Work>(tile).evaluated) pairs[tile.y()] += evaluated;
            records[tile.y()] += mesh.state<splat::Counts>(tile).projected;
        }
        for (auto const n : pairs) all_pairs += n;
        for (auto const n : records) all_records += n;
        auto const& ms = frame.report.host_ms;
        for (std::size_t y = 0; y < work.size(); ++y)
            work[y] = static_cast<std::uint32_t>(1e6 * (ms.composite * pairs[y] / all_pairs + ms.project * records[y] / all_records));
    }
    MPI_Bcast(work.data(), static_cast<int>(work.size()), MPI_UINT32_T, 0, MPI_COMM_WORLD);
    return work;
}
/// The median, over frames, of the ratio of two lines' times. They were measured in turn, so what slows the machine slows both.
double ratio(Line const& a, Line const& b)
{
    std::vector<double> ratios;
    for (std::size_t i = 0; i < a.ms.size(); ++i) ratios.push_back(a.ms[i] / b.ms[i]);
    return bench::median(ratios);
}

} // namespace

int frames_on_ranks(Options const& options)
{
    bench::expect_folder_of(options.csv);
    scene::Size const size{options.quick ? 320u : 1280u, options.quick ? 180u : 720u};
    auto const scene = bench::load_scene(bench::has_scene("sloth", options.data) ? "sloth" : "built_in", options.data, size);
    std::uint32_t const rounds = options.quick ? 2 : 31, warm_up = options.quick ? 1 : 3;

    // One rank with n threads for each number of ranks n, and n ranks with one thread, in bands of equal height and of equal work.
    struct Form {
        std::shared_ptr<Team> team;
        std::uint32_t threads;
        bool weighted;
    };
    std::vector<Form> forms;
    auto const one = std::make_shared<Team>(1);
    for (auto const n : numbers_of_ranks()) {
        forms.push_back({one, n, false});
        if (n == 1) continue;
        auto const team = std::make_shared<Team>(n);
        forms.push_back({team, 1, false});
        forms.push_back({team, 1, true});
    }
    auto const work = work_of_rows(one, scene.map, bench::cameras_of("orbit0.5", scene, 2, options.data));
    std::vector<std::unique_ptr<Line>> lines;
    bool same = true;
    for (std::string const motion : {"static", "orbit0.5"}) {
        auto const first = lines.size();
        for (auto const& form : forms) {
            auto line = std::make_unique<Line>();
            line->motion = motion;
            line->team = form.team;
            line->threads = form.threads;
            line->weighted = form.weighted;
            MpiMeshOptions engine;
            engine.comm = form.team->comm();
            engine.row_weights = form.weighted ? work : std::vector<std::uint32_t>(work.size(), 1); // without weights, the renderer chooses
            if (form.team->contains_me())
                line->renderer = std::make_unique<OverRanks>(scene.map, RendererOptions{.threads = form.threads}, engine);
            lines.push_back(std::move(line));
        }
        auto const cameras = bench::cameras_of(motion, scene, warm_up + rounds, options.data);
        for (std::size_t i = 0; i < cameras.size(); ++i)
            for (std::size_t l = first; l < lines.size(); ++l) {
                auto& line = *lines[l];
                line.render(cameras[i], i > warm_up);
                if (world_rank() != 0) continue;
                auto const& a = line.frame.image.rgb;
                auto const& b = lines[first]->frame.image.rgb;
                if (a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0) continue;
                same = false;
                std::cout << "BROKEN: " << motion << ", frame " << i << ", " << text_of(line)
                          << ": the picture is not that of one rank\n";
            }
        for (std::size_t l = first; l < lines.size(); ++l) lines[l]->renderer.reset();
        std::cerr << motion << "\n";
    }
    if (world_rank() != 0) return 0;

    std::cout << "Frames of " << scene.map.name << " at " << size.width << " x " << size.height << " on 40 x 36 tiles, " << rounds
              << " frames a line, in turn.\n";
    report::Table table{{"motion", "ranks x threads", "ms a frame (20 to 80 %)", "project", "route", "bloom", "composite", "picture",
                         "messages a rank", "bytes a rank", "agreements", "waiting, %"}};
    std::string csv = "motion,ranks,threads,weighted,ms,ms_low,ms_high,project,route,bloom,composite,picture,messages,bytes,agreements,waiting,ratio\n";
    for (auto const& line : lines) {
        table.add_row({line->motion, text_of(*line), spread(line->ms), bench::fixed(bench::median(line->project), 2),
                       bench::fixed(bench::median(line->route), 2), bench::fixed(bench::median(line->bloom), 2),
                       bench::fixed(bench::median(line->composite), 2), bench::fixed(bench::median(line->picture), 2),
                       bench::fixed(line->messages, 1), bench::fixed(line->bytes, 0), bench::fixed(line->agreements, 0),
                       bench::fixed(100 * bench::median(line->waiting), 0)});
    }
    std::cout << table << "\n";
    for (auto const& line : lines) {
        // One rank with as many threads as this line has ranks.
        auto const& other = **std::find_if(lines.begin(), lines.end(), [&](auto const& l) {
            return l->motion == line->motion && l->team->ranks() == 1 && l->threads == line->team->ranks() * line->threads;
        });
        auto const slower = ratio(*line, other);
        if (line->team->ranks() > 1)
            std::cout << line->motion << ": " << text_of(*line) << " / " << text_of(other) << " = "
                      << bench::fixed(slower, 2) << "\n";
        csv += line->motion + "," + std::to_string(line->team->ranks()) + "," + std::to_string(line->threads) + "," +
               (line->weighted ? "1" : "0");
        for (double const ms : {bench::median(line->ms), bench::quantile(line->ms, 0.2), bench::quantile(line->ms, 0.8), bench::median(line->project),
                                bench::median(line->route), bench::median(line->bloom), bench::median(line->composite),
                                bench::median(line->picture), line->messages, line->bytes, line->agreements, bench::median(line->waiting), slower})
            csv += "," + bench::fixed(ms, 4);
        csv += "\n";
    }
    if (!options.csv.empty()) report::write_whole(options.csv, csv);
    if (same) std::cout << "All pictures are the same, bit for bit.\n";
    return same ? 0 : 1;
}

} // namespace scaling
