#pragma once
#include <algorithm>
#include <bit>
#include <cstddef>
#include <tilemesh/model/hosts.hpp>

namespace tilemesh { inline namespace v0_2 {
namespace model_detail {

inline void expect_hosts(HostNetwork const& net, std::span<HostSuperstep const> supersteps, std::span<std::uint32_t const> first_row)
{
    auto const refuse = [](std::string const& problem, char const* why, char const* what) { throw Error(problem + " (" + why + "); " + what); };
    if (!(net.latency_us >= 0) || !(net.overhead_us >= 0) || !(net.bytes_per_us > 0))
        refuse("network \"" + net.name + "\"", "a negative time, or no bandwidth", "correct its figures");
    if (first_row.size() < 2 || first_row.front() != 0 || !std::is_sorted(first_row.begin(), first_row.end()))
        refuse(std::to_string(first_row.size()) + " first rows", "they begin with 0, ascend, and end with the grid's height", "give bands of rows");
    for (auto const& s : supersteps) {
        auto const sent = s.north_bytes.size();
        if (s.row_us.size() != first_row.back() || s.south_bytes.size() != sent || (sent != 0 && sent != s.row_us.size()))
            refuse("a superstep of " + std::to_string(s.row_us.size()) + " rows", "its lists or the bands have other lengths",
                   "give one number for each row");
    }
}

} // namespace model_detail

TILEMESH_HOST HostPrediction predict_hosts(HostNetwork const& net, std::span<HostSuperstep const> supersteps,
                                           std::span<std::uint32_t const> first_row, double agreement_bytes)
{
    model_detail::expect_hosts(net, supersteps, first_row);
    struct Host {
        std::uint32_t first, last;
        double compute = 0, edges = 0; ///< of all rows, and of the rows at the edges of the band
    };
    std::vector<Host> with_rows;
    for (std::size_t h = 0; h + 1 < first_row.size(); ++h)
        if (first_row[h] != first_row[h + 1]) with_rows.push_back({first_row[h], first_row[h + 1]});
    auto const hosts = first_row.size() - 1;
    auto const rounds = static_cast<double>(std::bit_width(hosts - 1)); // ceil(log2(hosts))
    double const agreement = rounds == 0 ? 0 : rounds * (net.latency_us + agreement_bytes / net.bytes_per_us);

    HostPrediction out;
    double alone = 0;
    for (auto const& s : supersteps) {
        bool const sends = !s.north_bytes.empty();
        for (auto& h : with_rows) {
            h.compute = 0;
            for (auto y = h.first; y < h.last; ++y) h.compute += s.row_us[y];
            h.edges = s.row_us[h.first] + (h.last - h.first > 1 ? s.row_us[h.last - 1] : 0);
        }
        double slowest = 0, ready = 0, end = 0;
        for (std::size_t h = 0; h < with_rows.size(); ++h) {
            auto const& mine = with_rows[h];
            auto const arrival = [&](Host const& from, double bytes) { return from.edges + net.latency_us + bytes / net.bytes_per_us; };
            double neighbours = 0, arrived = 0, bytes = 0;
            if (sends && h > 0) {
                ++neighbours;
                arrived = arrival(with_rows[h - 1], s.south_bytes[with_rows[h - 1].last - 1]);
                bytes += s.north_bytes[mine.first];
            }
            if (sends && h + 1 < with_rows.size()) {
                ++neighbours;
                arrived = std::max(arrived, arrival(with_rows[h + 1], s.north_bytes[with_rows[h + 1].first]));
                bytes += s.south_bytes[mine.last - 1];
            }
            auto const sent = mine.compute + neighbours * net.overhead_us;
            slowest = std::max(slowest, mine.compute);
            ready = std::max(ready, sent);
            end = std::max(end, std::max(sent + neighbours * net.overhead_us, arrived));
            alone += s.times * mine.compute;
            out.bytes += s.times * bytes;
            out.messages += s.times * neighbours;
        }
        out.slowest_us += s.times * slowest;
        out.frame_us += s.times * std::max(end, ready + agreement);
    }
    out.efficiency = out.frame_us > 0 ? alone / (static_cast<double>(hosts) * out.frame_us) : 1;
    return out;
}

TILEMESH_HOST std::vector<HostSuperstep> host_supersteps(Trace const& trace, Grid grid, CostModel const& model, std::span<double const> step_us)
{
    if (step_us.size() != trace.kernels.size())
        throw Error(std::to_string(step_us.size()) + " host times (the trace has " + std::to_string(trace.kernels.size()) +
                    " steps); give one for each step");
    model_detail::expect_sums_fit(model);
    model_detail::StepPrices const prices(model, trace);
    std::vector<double> cycles(trace.kernels.size(), 0);
    std::vector<HostSuperstep> out;
    for (std::size_t i = 0; i < trace.supersteps.size(); ++i) {
        auto const& s = trace.supersteps[i];
        auto& superstep = out.emplace_back();
        superstep.row_us.assign(grid.height, 0);
        if (s.capacity_bytes != 0) superstep.north_bytes = superstep.south_bytes = superstep.row_us;
        for (auto const& t : s.tiles) {
            auto const row = t.tile / grid.width;
            auto const of_tile = static_cast<double>(prices.compute_cycles(i, t.operations));
            superstep.row_us[row] += of_tile;
            cycles[s.step] += of_tile;
            auto const add = [&](std::vector<double>& bytes, Direction d, bool at_edge) {
                if (auto const n = t.sent_bytes[index(d)]; n != 0 && !at_edge) bytes[row] += n + 12.0;
            };
            add(superstep.north_bytes, Direction::north, row == 0);
            add(superstep.south_bytes, Direction::south, row + 1 == grid.height);
        }
    }
    for (std::size_t i = 0; i < out.size(); ++i) {
        auto const step = trace.supersteps[i].step;
        for (double& us : out[i].row_us) us *= cycles[step] > 0 ? step_us[step] / cycles[step] : 0;
    }
    return out;
}

TILEMESH_HOST std::vector<HostSuperstep> enlarged(std::span<HostSuperstep const> supersteps, std::uint32_t times, std::vector<bool> const& travels)
{
    if (times == 0 || travels.size() != supersteps.size())
        throw Error("a grid cannot be enlarged (by 0, or without a word for each superstep); give a factor, and say which supersteps travel");
    std::vector<HostSuperstep> out(supersteps.begin(), supersteps.end());
    for (std::size_t i = 0; i < out.size(); ++i) {
        if (travels[i]) out[i].times *= times;
        for (auto list : {&HostSuperstep::row_us, &HostSuperstep::north_bytes, &HostSuperstep::south_bytes}) {
            std::vector<double> rows;
            for (double const row : out[i].*list) rows.insert(rows.end(), times, row * times);
            out[i].*list = rows;
        }
    }
    return out;
}

}} // namespace tilemesh
