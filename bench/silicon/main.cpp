// How well the model of a network predicts a measured chip: traces of a NoC with time stamps of the device, against counted loads.
#include "judges.hpp"
#include <algorithm>
#include <cmath>
#include <common/options.hpp>
#include <common/program.hpp>
#include <common/statistics.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/model/network.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace {

namespace report = tilemesh::report;
using tilemesh::Error;

struct Options : bench::Options {
    std::filesystem::path traces, judges, paper;
    std::uint32_t worst = 5;

    void finish(shared::OptionTable const& given)
    {
        bench::Options::finish(given);
        if (traces.empty() && judges.empty())
            throw Error("no traces to judge by (--traces is not given); name a folder with --traces DIR, or a table with --judges FILE");
        if (judges.empty() && !paper.empty()) throw Error("no measurements to judge by (--paper is given without --judges); add --judges FILE");
        bench::expect_folder_of(csv);
    }
};
constexpr shared::Option<Options> rows[] = {
    shared::option<&Options::traces>("traces", "DIR",
                                     "a folder of .json files, each a list of events; with --judges, each trace is one more measurement"),
    shared::option<&Options::judges>("judges", "FILE", "machine,figure,measured,unit,phase,missing,source (bench/silicon/judges.csv)"),
    shared::option<&Options::paper>("paper", "FILE", "what `paper --table stage --csv FILE` wrote: the predictions of the stages"),
    shared::option<&Options::worst>("worst", "N", "print the N rows with the largest error [5]", {0, 10'000})};
shared::OptionTable table_of(Options& own)
{
    auto table =
        bench::table_of({"silicon",
                         "Reads NoC traces of a Wormhole chip, and compares the cycles from the first transfer to the end of the\n"
                         "last barrier with the model of include/tilemesh/model/network.hpp. With --judges, compares published\n"
                         "measurements of several machines with the library's models. One of --traces and --judges is needed.\n",
                         "accepted, not needed: it takes seconds",
                         "write trace,measured_cycles,predicted_cycles,at_least_cycles,loaded_cycles,transfers,bytes,bound_by; with --judges "
                         "machine,figure,measured,unit,predicted,ratio,at_least,bound_by,missing,source",
                         false, false},
                        own, rows);
    table.says("data", "accepted, not needed");
    return table;
}

/// A phase of a measured program.
struct Trace {
    std::string name;
    std::uint64_t measured = 0, bytes = 0; ///< cycles; bytes of all transfers
    std::vector<tilemesh::NetworkTransfer> transfers;
    tilemesh::NetworkTime time{};
};

Trace read(std::filesystem::path const& path)
{
    auto const name = path.stem().string();
    auto const refuse = [&](std::string const& why) { throw Error("trace " + name + " cannot be used (" + why + "); name a folder of NoC traces"); };
    std::ifstream file(path, std::ios::binary);
    auto const events = nlohmann::json::parse(file, nullptr, false);
    if (!events.is_array()) refuse("it is no JSON list of events");
    struct Event {
        std::uint64_t stamp;
        tilemesh::NetworkTransfer transfer;
    };
    std::vector<Event> moves;
    std::map<std::tuple<std::string, std::uint32_t, std::uint32_t>, std::uint32_t> cores;
    std::uint64_t end = 0;
    auto const add = [&](nlohmann::json const& e) {
        if (!e.is_object() || !e.contains("timestamp") || !e.contains("type")) return;
        auto const stamp = e.at("timestamp").get<std::uint64_t>();
        auto const type = e.at("type").get<std::string>();
        if (type.ends_with("BARRIER_END")) end = std::max(end, stamp);
        bool const reads = type.find("READ") != type.npos, writes = type.find("WRITE") != type.npos;
        if ((!reads && !writes) || e.value("num_bytes", 0) <= 0 || e.value("dx", -1) < 0) return;
        tilemesh::NetworkNode const here{e.at("sx").get<std::uint32_t>(), e.at("sy").get<std::uint32_t>()};
        tilemesh::NetworkNode const there{e.at("dx").get<std::uint32_t>(), e.at("dy").get<std::uint32_t>()};
        auto const core = cores.try_emplace({e.at("proc").get<std::string>(), here.x, here.y}, static_cast<std::uint32_t>(cores.size())).first->second;
        auto const way = e.at("noc") == "NOC_0" ? tilemesh::NetworkWay::columns_first : tilemesh::NetworkWay::rows_first;
        moves.push_back({stamp, {reads ? there : here, reads ? here : there, way, e.at("num_bytes").get<std::uint64_t>(), core}});
    };
    try {
        for (auto const& e : events) add(e);
    } catch (nlohmann::json::exception const&) {
        refuse("an event lacks a member, or has one of another kind");
    }
    if (moves.empty() || end == 0) refuse("it has no transfers, or no barrier ends");
    std::stable_sort(moves.begin(), moves.end(), [](auto const& a, auto const& b) { return a.stamp < b.stamp; });
    if (end <= moves.front().stamp) refuse("its last barrier ends before its first transfer");
    Trace trace{name, end - moves.front().stamp, 0, {}, {}};
    for (auto const& move : moves) {
        trace.transfers.push_back(move.transfer);
        trace.bytes += move.transfer.bytes;
    }
    trace.time = tilemesh::time_of(tilemesh::wormhole(), trace.transfers);
    return trace;
}

std::string place(tilemesh::NetworkResource const& r)
{
    std::string const at = r.kind == tilemesh::NetworkResource::issue ? " " + std::to_string(r.at.x)
                                                                      : " (" + std::to_string(r.at.x) + " " + std::to_string(r.at.y) + ")";
    return tilemesh::NetworkResource::names[r.kind] + at + (r.side == ' ' ? "" : std::string(" ") + r.side);
}

/// Relative errors of a prediction, and how many pairs of traces that differ by more than 5 % it puts into the right order.
void add_row(report::Table& table, std::vector<Trace> const& traces, char const* name, std::vector<double> const& guess)
{
    std::vector<double> off;
    std::size_t above = 0, pairs = 0, right = 0;
    for (std::size_t i = 0; i < traces.size(); ++i) {
        auto const m = static_cast<double>(traces[i].measured);
        off.push_back(std::abs(guess[i] / m - 1));
        above += guess[i] > m ? 1 : 0;
        for (std::size_t j = 0; j < i; ++j) {
            auto const other = static_cast<double>(traces[j].measured);
            if (std::abs(m / other - 1) <= 0.05) continue;
            ++pairs;
            right += (guess[i] > guess[j]) == (m > other) ? 1 : 0;
        }
    }
    table.add_row({name, report::decimals(100 * bench::quantile(off, 0.5), 1) + " %", report::decimals(100 * bench::quantile(off, 0.9), 1) + " %",
                   std::to_string(right) + " of " + std::to_string(pairs), std::to_string(above)});
}

std::vector<Trace> read_all(Options const& o)
{
    std::vector<std::filesystem::path> files;
    std::error_code failed;
    for (auto const& entry : std::filesystem::directory_iterator(o.traces, failed))
        if (entry.path().extension() == ".json") files.push_back(entry.path());
    if (failed || files.empty()) throw Error("no .json file in " + o.traces.string() + " (--traces names a folder of NoC traces); name another folder");
    std::sort(files.begin(), files.end());
    std::vector<Trace> traces;
    for (auto const& file : files) traces.push_back(read(file));
    return traces;
}

/// Published measurements, and the traces as more of them.
int judge(Options const& o)
{
    std::vector<silicon::Judge> judges;
    if (!o.traces.empty())
        for (auto const& t : read_all(o))
            judges.push_back({"Wormhole (traces)", t.name, "cycles", "", "tt-npe trace", static_cast<double>(t.measured), static_cast<double>(t.time.drained),
                              static_cast<double>(t.time.at_least), true, tilemesh::NetworkResource::names[t.time.bound.kind]});
    for (auto& j : silicon::read_judges(o.judges, o.paper)) judges.push_back(std::move(j));
    bool const holds = silicon::print_judges(judges, o.worst);
    if (!o.csv.empty()) {
        report::WholeFile file(o.csv, "some kilobytes");
        file.put(silicon::judges_csv(judges));
        file.finish();
    }
    return holds ? 0 : 1;
}

int run(Options const& o)
{
    if (!o.judges.empty()) return judge(o);
    auto const traces = read_all(o);
    auto const guesses = [&](auto const& of) {
        std::vector<double> all;
        for (auto const& t : traces) all.push_back(static_cast<double>(of(t)));
        return all;
    };
    auto const prices = guesses([](Trace const& t) { return static_cast<double>(t.measured) / static_cast<double>(t.bytes); });
    auto const measured = guesses([](Trace const& t) { return t.measured; });
    double const price = bench::median(prices), median = bench::median(measured);
    report::Table table{{"prediction", "median error", "p90", "pairs in order", "above the measured"}};
    add_row(table, traces, "null: the median of all", guesses([&](Trace const&) { return median; }));
    add_row(table, traces, "null: one price a byte", guesses([&](Trace const& t) { return price * static_cast<double>(t.bytes); }));
    add_row(table, traces, "ports, links, channels: documents alone", guesses([](Trace const& t) { return t.time.at_least; }));
    add_row(table, traces, "and issue, latency", guesses([](Trace const& t) { return t.time.loaded; }));
    add_row(table, traces, "in rounds: the prediction", guesses([](Trace const& t) { return t.time.drained; }));
    std::cout << traces.size() << " traces of " << tilemesh::wormhole().name << ", modelled against measured cycles\n" << table << '\n';

    std::map<std::string, std::size_t> bound;
    for (auto const& t : traces) ++bound[tilemesh::NetworkResource::names[t.time.bound.kind]];
    std::cout << "bound by:";
    for (auto const& [name, n] : bound) std::cout << ' ' << name << ' ' << n << (name == bound.rbegin()->first ? "\n" : ",");
    auto worst = traces;
    auto const off = [](Trace const& t) { return std::abs(std::log(static_cast<double>(t.time.drained) / static_cast<double>(t.measured))); };
    std::stable_sort(worst.begin(), worst.end(), [&](auto const& a, auto const& b) { return off(a) > off(b); });
    worst.resize(std::min<std::size_t>(o.worst, worst.size()));
    for (auto const& t : worst)
        std::cout << "worst: " << t.name << " measured " << t.measured << ", predicted " << t.time.drained << ", bound by " << place(t.time.bound) << '\n';

    bool const holds = std::all_of(traces.begin(), traces.end(), [](auto const& t) { return t.time.at_least <= t.measured; });
    if (!holds) std::cout << "BROKEN: a bound of documented rates is above a measured time\n";
    if (o.csv.empty()) return holds ? 0 : 1;
    std::string csv = "trace,measured_cycles,predicted_cycles,at_least_cycles,loaded_cycles,transfers,bytes,bound_by\n";
    for (auto const& t : traces)
        csv += t.name + "," + std::to_string(t.measured) + "," + std::to_string(t.time.drained) + "," + std::to_string(t.time.at_least) + "," +
               std::to_string(t.time.loaded) + "," + std::to_string(t.transfers.size()) + "," + std::to_string(t.bytes) + "," + place(t.time.bound) + "\n";
    report::WholeFile file(o.csv, "some kilobytes");
    file.put(csv);
    file.finish();
    return holds ? 0 : 1;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, table_of, run, "out of memory (the traces are too large); judge fewer");
}
