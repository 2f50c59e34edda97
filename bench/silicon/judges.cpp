#include "judges.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <common/statistics.hpp>
#include <cstddef>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <map>
#include <sstream>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/network.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <utility>

namespace silicon {

namespace {

namespace report = tilemesh::report;
using tilemesh::Error;
using tilemesh::Network;
using tilemesh::NetworkNode;
using tilemesh::NetworkTransfer;

/// What the word in the column `missing` stands for.
constexpr std::array<std::pair<std::string_view, char const*>, 10> reasons = {{
    {"", ""},
    {"rows", "which rows of cores are switched off is not published: the first rows are taken"},
    {"median", "published is a median over cores, and the model has the last one; which rows are switched off is not published"},
    {"lookups", "the program looks up 400 records a tile: instructions that no document prices; there is no host copy in it"},
    {"clock", "a C600 may run at 1.49 GHz, and a copy may share buses"},
    {"load", "a compiled exchange of our model does not know load"},
    {"forward", "our Reduce wakes a core on each hop and ends in a corner; the wafer's routers forward in one cycle to its middle"},
    {"wafer", "the price is that of documents about the first wafer; measured was the third"},
    {"stages", "a price of Sort that explains its mean and its slowest tile"},
    {"host", "timed on the host around a launch"},
}};

/// The fields of a line. No field has a comma.
std::vector<std::string> fields_of(std::string const& line)
{
    std::vector<std::string> fields(1);
    for (char const c : line) {
        if (c == ',') fields.emplace_back();
        else if (c != '\r') fields.back() += c;
    }
    return fields;
}

/// The table's cores of a machine, in the order of its rows. The published tests number them so.
struct Cores {
    Network network;
    std::vector<std::uint32_t> columns, rows;
    NetworkNode at(std::uint32_t column, std::uint32_t row) const { return {columns[column], rows[row]}; }
};
Cores cores_of(std::string const& machine)
{
    if (machine == "Wormhole") return {tilemesh::wormhole(), {1, 2, 3, 4, 6, 7, 8, 9}, {1, 2, 3, 4, 5, 7, 8, 9}};
    return {tilemesh::blackhole(), {1, 2, 3, 4, 5, 6, 7, 10, 11, 12, 13, 14, 15}, {2, 3, 4, 5, 6, 7, 8, 9, 10, 11}};
}

/// The words of a phase.
class Phase {
public:
    Phase(std::string const& text, std::function<void(std::string const&)> refuse) : words_(text), refuse_(std::move(refuse)) {}
    std::string word()
    {
        std::string w;
        if (!(words_ >> w)) refuse_("its phase is too short");
        return w;
    }
    std::uint32_t number(std::uint32_t most)
    {
        auto const w = word();
        auto const n = tilemesh::number_of<std::uint32_t>(w).value_or(0);
        if (n == 0 || n > most) refuse_("a number of its phase is not from 1 to " + std::to_string(most));
        return last_ = n;
    }
    std::uint32_t last() const noexcept { return last_; }
    bool reads()
    {
        auto const w = word();
        if (w != "read" && w != "write") refuse_("its phase neither reads nor writes");
        return w == "read";
    }

private:
    std::istringstream words_;
    std::function<void(std::string const&)> refuse_;
    std::uint32_t last_ = 0;
};

/// Transfers between cores, as the published tests make them: over NOC 0, partner by partner.
std::vector<NetworkTransfer> transfers(Cores const& cores, std::string const& kind, Phase& phase)
{
    std::vector<NetworkTransfer> out;
    bool const reads = phase.reads();
    auto const add = [&](NetworkNode here, NetworkNode there, std::uint32_t times, std::uint64_t bytes, std::uint32_t core) {
        for (std::uint32_t i = 0; i < times; ++i)
            out.push_back({reads ? there : here, reads ? here : there, tilemesh::NetworkWay::columns_first, bytes, core});
    };
    auto const width = static_cast<std::uint32_t>(cores.columns.size()), all = width * static_cast<std::uint32_t>(cores.rows.size());
    if (kind == "pair") {
        bool const turn = phase.word() == "turn";
        auto const times = phase.number(1024), bytes = phase.number(1u << 20);
        add(cores.at(0, 0), cores.at(turn ? 1 : 0, 1), times, bytes, 0);
    } else if (kind == "one") {
        auto const partners = phase.number(all - 1), times = phase.number(1024), bytes = phase.number(1u << 20);
        for (std::uint32_t i = 1; i <= partners; ++i) add(cores.at(0, 0), cores.at(i % width, i / width), times, bytes, 0);
    } else {
        auto const side = phase.number(8), times = phase.number(1024), bytes = phase.number(1u << 20);
        for (std::uint32_t me = 0; me < side * side; ++me)
            for (std::uint32_t to = 0; to < side * side; ++to)
                add(cores.at(me % side, me / side), cores.at(to % side, to / side), times, bytes, me);
    }
    return out;
}

void predict(Judge& judge, std::string const& text, std::map<std::string, double> const& stages, std::function<void(std::string const&)> const& refuse)
{
    Phase phase(text, refuse);
    auto const kind = phase.word();
    if (kind == "pair" || kind == "one" || kind == "each") {
        if (judge.machine != "Wormhole" && judge.machine != "Blackhole") refuse("no network of this machine is known");
        auto const cores = cores_of(judge.machine);
        auto const time = tilemesh::time_of(cores.network, transfers(cores, kind, phase));
        judge.predicted = static_cast<double>(time.drained);
        judge.at_least = static_cast<double>(time.at_least);
        judge.bound_by = tilemesh::NetworkResource::names[time.bound.kind];
        judge.last = kind != "each";
        judge.bytes = phase.last();
    } else if (kind == "compiled") {
        // One exchange in which each tile receives so many bytes, and its sync.
        auto const mk2 = tilemesh::mk2();
        auto const bytes = std::uint64_t{phase.number(1u << 30)};
        auto const moved = (bytes * mk2.exchange_millicycles_a_byte + 999) / 1000;
        judge.predicted = tilemesh::milliseconds(mk2, mk2.exchange_cycles + moved + mk2.sync_cycles);
        judge.bound_by = "port in";
    } else if (kind == "reduce") {
        // Passes of a Reduce to all tiles (tests/engine/reduce.cpp), each of a hop and 2 T_R + 1 cycles of a core, T_R = 2 (arXiv 2404.15888).
        double const across = phase.number(4096), down = phase.number(4096), ways = across - 1 + down - 1;
        judge.predicted = 2 * ways * (1 + 2 * 2 + 1) / ways;
        judge.bound_by = "hops";
    } else if (kind == "wafer") { // examples/machines/wse2.txt: a cycle a hop, and 4 bytes a cycle (arXiv 2010.03660)
        auto const what = phase.word();
        if (what != "hop" && what != "word") refuse("its phase is neither a hop nor a word of the wafer");
        judge.predicted = 1;
        judge.bound_by = what == "hop" ? "hops" : "link";
    } else if (kind == "load") {
        judge.predicted = 1;
        judge.bound_by = "none";
    } else if (kind == "stage") {
        auto const scene = phase.word(), quantity = phase.word();
        auto const found = stages.find(scene + ' ' + quantity);
        if (found == stages.end()) return;
        judge.predicted = found->second;
        judge.bound_by = quantity.substr(0, quantity.find('_')) == "exchange" ? "port in" : "compute";
    } else {
        refuse("its phase is none that this program predicts");
    }
}

std::string whole(std::filesystem::path const& path, char const* option)
{
    std::ifstream file(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(file), {}};
    if (!file || text.empty()) throw Error("nothing to read in " + path.string() + " (" + option + " names a CSV file); name another file");
    return text;
}

/// "scene quantity" -> predicted milliseconds, of a CSV file of the bench paper. Only lines of its table `stage` count; in their first five
/// fields is no comma.
std::map<std::string, double> stages_of(std::filesystem::path const& paper)
{
    std::map<std::string, double> out;
    if (paper.empty()) return out;
    std::istringstream lines(whole(paper, "--paper"));
    for (std::string line; std::getline(lines, line);) {
        auto const f = fields_of(line);
        if (f.size() < 7 || f[0] != "stage" || f[6] == "null_model" || f[4].empty()) continue;
        if (auto const ms = tilemesh::number_of<double>(f[4])) out.emplace(f[1] + ' ' + f[2], *ms);
    }
    return out;
}

double off(Judge const& j) { return std::abs(j.predicted / j.measured - 1); }
std::string percent(double share) { return report::decimals(100 * share, 1) + " %"; }

/// Small transfers are another question than large ones: a core's time, not a link's.
void print_by_bytes(std::vector<Judge> const& judges)
{
    std::map<std::pair<std::string, std::uint32_t>, std::vector<double>> ratios;
    for (auto const& j : judges)
        if (j.bytes != 0) ratios[{j.machine, j.bytes}].push_back(j.predicted / j.measured);
    if (ratios.empty()) return;
    report::Table table{{"machine", "bytes a transfer", "rows", "median ratio", "median error"}};
    for (auto const& [key, all] : ratios) {
        std::vector<double> errors;
        for (double const r : all) errors.push_back(std::abs(r - 1));
        table.add_row({key.first, std::to_string(key.second), std::to_string(all.size()), report::decimals(bench::median(all), 2),
                       percent(bench::median(errors))});
    }
    std::cout << table << '\n';
}

} // namespace

std::vector<Judge> read_judges(std::filesystem::path const& file, std::filesystem::path const& paper)
{
    auto const stages = stages_of(paper);
    std::istringstream lines(whole(file, "--judges"));
    std::vector<Judge> out;
    std::size_t number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        auto const refuse = [&](std::string const& why) {
            throw Error("line " + std::to_string(number) + " of the measurements cannot be used (" + why + "); correct the line");
        };
        auto const f = fields_of(line);
        if (number == 1) {
            if (line.find("machine,figure,measured,unit,phase,missing,source") != 0) refuse("the file does not begin with the names of its columns");
            continue;
        }
        if (f.size() != 7) refuse("it has " + std::to_string(f.size()) + " fields of 7");
        Judge judge;
        judge.machine = f[0], judge.figure = f[1], judge.unit = f[3], judge.source = f[6];
        auto const [end, failed] = tilemesh::read_number(f[2].data(), f[2].data() + f[2].size(), judge.measured);
        if (failed != std::errc{} || end != f[2].data() + f[2].size() || !(judge.measured > 0) || !std::isfinite(judge.measured))
            refuse("its measured value is no positive number");
        if (judge.source.empty()) refuse("it has no source");
        auto const reason = std::find_if(reasons.begin(), reasons.end(), [&](auto const& r) { return r.first == f[5]; });
        if (reason == reasons.end()) refuse("its column missing has no word that this program knows");
        judge.missing = reason->second;
        predict(judge, f[4], stages, refuse);
        out.push_back(std::move(judge));
    }
    return out;
}

std::string judges_csv(std::vector<Judge> const& judges)
{
    std::string out = "machine,figure,measured,unit,predicted,ratio,at_least,bound_by,missing,source\n";
    auto const shown = [](double v) { return bench::fixed(v, v < 10 ? 4 : 0); };
    for (auto const& j : judges) {
        bool const has = !j.bound_by.empty();
        auto missing = j.missing;
        std::replace(missing.begin(), missing.end(), ',', ';');
        out += j.machine + ',' + j.figure + ',' + bench::fixed(j.measured, j.measured < 100 ? 4 : 1) + ',' + j.unit + ',' + (has ? shown(j.predicted) : "") + ',' +
               (has ? bench::fixed(j.predicted / j.measured, 3) : "") + ',' + (j.at_least > 0 ? shown(j.at_least) : "") + ',' +
               (has ? j.bound_by : "skipped") + ',' + missing + ',' + j.source + '\n';
    }
    return out;
}

bool print_judges(std::vector<Judge> const& judges, std::uint32_t worst)
{
    std::vector<std::string> machines;
    for (auto const& j : judges)
        if (std::find(machines.begin(), machines.end(), j.machine) == machines.end()) machines.push_back(j.machine);
    report::Table table{{"machine", "rows", "skipped", "median ratio", "median error", "p90", "within 25 %", "bound above", "bounded by"}};
    bool holds = true;
    std::size_t rows = 0;
    for (auto const& machine : machines) {
        std::vector<double> errors, ratios;
        std::size_t skipped = 0, above = 0, hits = 0;
        std::map<std::string, std::size_t> bounds;
        for (auto const& j : judges) {
            if (j.machine != machine) continue;
            if (j.bound_by.empty()) {
                ++skipped;
                continue;
            }
            errors.push_back(off(j));
            ratios.push_back(j.predicted / j.measured);
            hits += off(j) <= 0.25 ? 1 : 0;
            above += j.last && j.at_least > j.measured ? 1 : 0;
            ++bounds[j.bound_by];
        }
        rows += errors.size();
        holds = holds && above == 0;
        std::string by;
        for (auto const& [name, n] : bounds) by += (by.empty() ? "" : ", ") + name + ' ' + std::to_string(n);
        bool const any = !errors.empty();
        table.add_row({machine, std::to_string(errors.size()), std::to_string(skipped), any ? report::decimals(bench::median(ratios), 2) : "-",
                       any ? percent(bench::median(errors)) : "-", any ? percent(bench::quantile(errors, 0.9)) : "-", std::to_string(hits),
                       std::to_string(above), any ? by : "-"});
    }
    std::cout << rows << " published measurements, predicted over measured\n" << table << '\n';
    print_by_bytes(judges);
    std::vector<Judge> sorted;
    std::copy_if(judges.begin(), judges.end(), std::back_inserter(sorted), [](auto const& j) { return !j.bound_by.empty(); });
    auto const far = [](Judge const& j) { return std::abs(std::log(j.predicted / j.measured)); };
    std::stable_sort(sorted.begin(), sorted.end(), [&](auto const& a, auto const& b) { return far(a) > far(b); });
    sorted.resize(std::min<std::size_t>(worst, sorted.size()));
    for (auto const& j : sorted)
        std::cout << "worst: " << j.machine << ", " << j.figure << ": ratio " << report::decimals(j.predicted / j.measured, 2) << ", bound by " << j.bound_by
                  << (j.missing.empty() ? "" : "; missing: " + j.missing) << '\n';
    if (!holds) std::cout << "BROKEN: a bound of documented rates is above a measured time\n";
    return holds;
}

} // namespace silicon
