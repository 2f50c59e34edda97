#pragma once
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// What a message costs between two hosts: latency, overhead and bandwidth of LogGP (Alexandrov, Ionescu, Schauser, Scheiman 1995). No two
/// messages share a link, and every pair of hosts is equally far apart.
struct HostNetwork {
    std::string name;
    double latency_us = 0;                ///< of a small message, from send to receipt: half a round trip. It contains both overheads
    double overhead_us = 0;               ///< for which a message occupies the processor of its sender, and that of its receiver
    double bytes_per_us = INFINITY;       ///< bandwidth of a link, each way; 1,000 bytes per microsecond are 1 GB/s
    std::string source;                   ///< a document, or a measurement
};

/// A superstep as the hosts see it, row by row of the grid.
struct HostSuperstep {
    double times = 1;                     ///< a frame has so many supersteps like this one
    std::vector<double> row_us;           ///< time of one host for the tiles of each row, in microseconds
    std::vector<double> north_bytes;      ///< bytes of messages from each row to the row north of it; empty: the kernel does not send
    std::vector<double> south_bytes;      ///< from each row to the row south of it; as long as north_bytes
};

/// A predicted frame. No cluster has confirmed it.
struct HostPrediction {
    double frame_us = 0;
    double slowest_us = 0;                ///< compute time of the slowest host of each superstep; the rest of frame_us is communication
    double efficiency = 0;                ///< time of one host / (hosts * frame_us)
    double bytes = 0;                     ///< sent by all hosts, to neighbours
    double messages = 0;                  ///< sent by all hosts, to neighbours
};

/// Predicts a frame over hosts, each with a band of rows, for the engine of mpi/mpi_mesh.hpp. Host h has the rows first_row[h] to
/// first_row[h + 1] - 1 and may have none; the last entry is the grid's height. Channels that wrap are not modelled.
///
/// A superstep is over when both of these are:
///   messages    each host has computed its rows and has its neighbours' messages. A message leaves when its sender has computed the first
///               and the last row of its band, and arrives latency + bytes / bandwidth later. Each message adds an overhead at both ends.
///   agreement   begins when the last host has computed and sent; ceil(log2(hosts)) messages follow one another (recursive doubling).
///
/// Throws Error for figures below zero, and for lists of other lengths than the grid's height. Cost: rows times supersteps.
TILEMESH_HOST HostPrediction predict_hosts(HostNetwork const& net, std::span<HostSuperstep const> supersteps,
                                           std::span<std::uint32_t const> first_row, double agreement_bytes);

/// The supersteps of a traced run, with measured host times. `step_us` has the host time of each step of the program, of a run on one
/// thread. Each step's time is divided among its supersteps and rows like the modelled cycles of their tiles. A row's bytes are those of
/// the messages that its tiles sent, and 12 bytes for each tile and side: column, size and note. Throws Error as model_cost does, and if
/// there is not one time for each step.
TILEMESH_HOST std::vector<HostSuperstep> host_supersteps(Trace const& trace, Grid grid, CostModel const& model, std::span<double const> step_us);

/// The supersteps of a grid that is `times` as wide and as high, with as many records on each tile. A row has `times` the tiles, so its time
/// and its bytes grow by this factor. A record that crosses the grid has `times` the way: superstep i occurs `times` as often if travels[i].
/// Throws Error if `times` is 0.
TILEMESH_HOST std::vector<HostSuperstep> enlarged(std::span<HostSuperstep const> supersteps, std::uint32_t times, std::vector<bool> const& travels);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/hosts_code.hpp>
#endif
