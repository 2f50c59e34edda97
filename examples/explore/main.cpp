// explore: a study of machines, policies and capacities. It renders what must be rendered once, and prices the rest.
#include "../shared/input_rows.hpp"
#include "../shared/output_files.hpp"
#include "../shared/png.hpp"
#include "../shared/process.hpp"
#include "../shared/sha256.hpp"
#include "../shared/text.hpp"
#include "page.hpp"
#include "runs.hpp"
#include "study.hpp"
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <tilemesh/error.hpp>
#include <tilemesh/report/distinct_files.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <tuple>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;
namespace report = tilemesh::report;
using explore::Frames;
using explore::Point;
using explore::Setting;
using explore::Sized;
using explore::Study;
using report::thousands;
using tilemesh::Error;
using Json = nlohmann::ordered_json;

constexpr char const *points_file = "points.jsonl", *page_file = "index.html";

struct Options : shared::HostInput {
    fs::path study, csv, out;
};
constexpr shared::Option<Options> rows[] = {
    shared::option<&Options::csv>("csv", "FILE", "a line a point"),
    shared::option<&Options::out>("out", "DIR", "points.jsonl, index.html with the Pareto front, and a picture a run")};

std::optional<Options> options_of(int argc, char** argv)
{
    Options o;
    o.threads = std::clamp(std::thread::hardware_concurrency(), 1u, shared::most_threads);
    shared::OptionTable table("explore",
                              "usage: explore STUDY.json --csv FILE --out DIR [options]\n"
                              "Renders each view of a study once for all points with the same counts, and prices the others\n"
                              "without a run: prices, clocks and networks change no count. Capacities, policies and workers do, so\n"
                              "that their points run.\n"
                              "  STUDY.json            the study (examples/README.md): machines, programs, presets, sizes, costs\n",
                              true);
    table.takes_words("study", 1, [&o](std::string_view word) { o.study = word; });
    table.add("What comes out", o, rows);
    table.add("The host", o, shared::host_rows);
    table.says("threads", "number of host threads [all of this machine's]");
    table.ends_with("\nThe same command goes on after an interrupt: a point of points.jsonl with the same digest does not\nrun again.\n");
    if (!shared::read_command_line(table, o, nullptr, argc, argv)) return {};
    if (o.study.empty()) throw Error("no study is named (there is nothing to explore); name one: explore STUDY.json --csv FILE --out DIR");
    if (o.csv.empty()) throw Error("no table is named (a study ends in one); add --csv FILE");
    if (o.out.empty()) throw Error("no folder is named (points and pictures go there); add --out DIR");
    return o;
}

bool is_picture(std::string const& name)
{
    return name.starts_with("run_") && name.ends_with(".png");
}

void check_outputs(Options const& o, Study const& study)
{
    constexpr char const *csv_remedy = "name another file with --csv", *out_remedy = "name another directory with --out";
    shared::make_folder(o.out, "--out");
    shared::check_file(o.csv, "the table", csv_remedy);
    report::DistinctFiles files;
    for (auto const& file : study.read) files.read(file);
    if (!o.quiet) files.write_stream(STDOUT_FILENO, "standard output", "send it to another file, or use --quiet");
    files.write_stream(STDERR_FILENO, "standard error", "send it to another file");
    files.write_into(o.out, is_picture, "a picture", out_remedy);
    files.write(o.out / points_file, "the list of points", out_remedy);
    files.write(o.out / page_file, "the page", out_remedy);
    files.write(o.csv, "the table", csv_remedy);
}

// --- the list of finished points ---------------------------------------------------------------

/// Before the digest of a line's other bytes, which ends it: a line that was edited is none.
constexpr std::string_view check_member = ",\"check\":\"";

/// The members of a point in its line, in this order.
constexpr auto point_members =
    std::tuple(std::pair("digest", &Point::digest), std::pair("name", &Point::name), std::pair("psnr_db", &Point::psnr_db),
               std::pair("modelled_ms", &Point::modelled_ms), std::pair("sram_bytes", &Point::sram_bytes),
               std::pair("exchanged_bytes", &Point::exchanged_bytes), std::pair("lost", &Point::lost), std::pair("left_out", &Point::left_out),
               std::pair("refused", &Point::refused), std::pair("picture", &Point::picture), std::pair("cycles", &Point::cycles),
               std::pair("exchanges", &Point::exchanges), std::pair("passes", &Point::passes), std::pair("pairs", &Point::pairs),
               std::pair("first_ms", &Point::first_ms), std::pair("later_ms", &Point::later_ms),
               std::pair("slowest_to_mean", &Point::slowest_to_mean), std::pair("host_ms", &Point::host_ms), std::pair("storage", &Point::storage),
               std::pair("channel", &Point::channel), std::pair("waiting", &Point::waiting), std::pair("beam", &Point::beam),
               std::pair("whole_channels", &Point::whole_channels), std::pair("weakest", &Point::weakest),
               std::pair("weakest_share", &Point::weakest_share));
void each_member(auto const& visit)
{
    std::apply([&](auto const&... member) { (visit(member.first, member.second), ...); }, point_members);
}

/// A point as a line. Infinite PSNR (equal pictures) is null.
std::string line_of(Point const& p)
{
    auto json = Json::object();
    each_member([&](char const* name, auto member) {
        if constexpr (requires { (p.*member).value(); }) json[name] = p.*member ? Json(*(p.*member)) : Json();
        else json[name] = p.*member;
    });
    auto line = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    line.pop_back(); // "}"
    return line + std::string(check_member) + shared::sha256(line) + "\"}\n";
}
std::optional<Point> point_of(std::string const& line)
try {
    auto const before = line.substr(0, line.rfind(check_member));
    if (line != before + std::string(check_member) + shared::sha256(before) + "\"}") return {};
    auto const json = Json::parse(line);
    Point p;
    p.psnr_db = std::numeric_limits<double>::infinity();
    each_member([&](char const* name, auto member) {
        auto const& value = json.at(name);
        if (value.is_null()) return; // infinite, or no such time
        if constexpr (requires { (p.*member).value(); }) p.*member = value.template get<double>();
        else value.get_to(p.*member);
    });
    return p;
} catch (Json::exception const&) { // of another version
    return {};
}

/// The points of an earlier run, by digest. Points whose lines were edited, or whose pictures are gone, are not among them; `note` says so.
std::map<std::string, Point> read_points(fs::path const& out, std::string& note)
{
    std::map<std::string, Point> found;
    std::size_t edited = 0, gone = 0;
    std::ifstream in(out / points_file, std::ios::binary);
    for (std::string line; std::getline(in, line);) {
        auto point = point_of(line);
        std::error_code refused;
        if (!point) ++edited;
        else if (!point->picture.empty() && !fs::is_regular_file(out / point->picture, refused)) ++gone;
        else found.insert_or_assign(point->digest, std::move(*point));
    }
    for (auto const& [count, what] :
         {std::pair(edited, "lines that were edited, or that another version wrote"), std::pair(gone, "points whose picture is gone")})
        if (count != 0) note += std::string("note: ") + points_file + ": " + what + ": " + thousands(count) + "; they are measured again\n";
    return found;
}

/// Threads that end with their scope, also where an exception ends it.
struct Threads {
    std::vector<std::thread> all;
    Threads() = default;
    ~Threads() { for (auto& one : all) one.join(); }
    Threads(Threads const&) = delete;
    Threads& operator=(Threads const&) = delete;
};

// --- the runs ----------------------------------------------------------------------------------

/// Settings with equal counts.
struct Group {
    std::string key;
    std::vector<std::size_t> members; ///< indices of settings
    Sized sized;
};

class Exploration {
public:
    Exploration(Options const& options, Study const& study) : options_(options), study_(study), points_(study.settings.size()), done_(study.settings.size())
    {
        std::map<std::string, std::size_t> groups;
        auto const found = read_points(options.out, note_);
        for (std::size_t i = 0; i < study.settings.size(); ++i) {
            auto sized = sizes_of(study.settings[i]);
            auto key = run_key(study.settings[i], sized);
            sram_.push_back(sized.sram_bytes);
            digests_.push_back(point_digest(study.settings[i], key));
            if (auto const known = found.find(digests_[i]); known != found.end()) {
                points_[i] = known->second;
                identify(i);
                done_[i] = true;
                ++taken_over_;
                continue;
            }
            if (!sized.refused.empty()) {
                identify(i);
                points_[i].refused = sized.refused;
                done_[i] = true;
                continue;
            }
            auto const [place, is_new] = groups.emplace(key, groups_.size());
            if (is_new) groups_.push_back({std::move(key), {}, std::move(sized)});
            groups_[place->second].members.push_back(i);
        }
    }
    std::size_t runs() const { return groups_.size(); }
    std::size_t taken_over() const { return taken_over_; }
    std::string const& note() const { return note_; }
    std::size_t to_price() const
    {
        std::size_t n = 0;
        for (auto const& group : groups_) n += group.members.size();
        return n;
    }
    std::vector<Point> const& points() const { return points_; }
    std::size_t finished() const { return static_cast<std::size_t>(std::count(done_.begin(), done_.end(), true)); }

    /// Runs every group, several at once, until an interrupt. Writes the list of points after each.
    void run()
    {
        write_points();
        auto const workers = static_cast<std::uint32_t>(std::min<std::size_t>(options_.threads, std::max<std::size_t>(groups_.size(), 1)));
        auto const threads = std::max(1u, options_.threads / workers);
        std::atomic<std::size_t> next{0};
        auto const work = [&] {
            for (std::size_t g = next++; g < groups_.size() && shared::interrupt() == 0 && !failed_; g = next++) {
                try {
                    run_group(groups_[g], threads);
                } catch (...) {
                    std::lock_guard const lock(mutex_);
                    if (!failed_) error_ = std::current_exception();
                    failed_ = true;
                }
            }
        };
        {
            Threads others;
            try {
                for (std::uint32_t k = 1; k < workers; ++k) others.all.emplace_back(work);
            } catch (...) {
                failed_ = true; // those that were started end after their run
                throw;
            }
            work();
        }
        if (error_) std::rethrow_exception(error_);
    }

private:
    void identify(std::size_t i)
    {
        points_[i].name = study_.settings[i].name;
        points_[i].map = study_.settings[i].subject->name;
        points_[i].digest = digests_[i];
        points_[i].sram_bytes = sram_[i]; // points of one run may have different machines
    }
    void run_group(Group const& group, std::uint32_t threads)
    {
        auto const& first = study_.settings[group.members.front()];
        std::string refused;
        std::optional<Frames> frames;
        try {
            frames = explore::run(first, group.sized, references(first), threads);
        } catch (explore::Interrupted const&) {
            return;
        } catch (Error const& error) { // the renderer refuses this setting: that is a result, too
            refused = explore::refusal_of(error);
        }
        std::vector<Point> priced(group.members.size());
        std::string picture;
        if (frames) {
            picture = "run_" + shared::sha256(group.key).substr(0, 16) + ".png";
            report::write_whole(options_.out / picture, shared::png_bytes(frames->picture));
            std::atomic<std::size_t> next{0};
            std::exception_ptr error;
            auto const price = [&] {
                for (std::size_t k = next++; k < priced.size(); k = next++) {
                    try {
                        auto const i = group.members[k];
                        priced[k] = explore::priced(study_.settings[i], *frames, digests_[i]);
                    } catch (Error const& wrong) { // a network without room for the grid, a price that is missing
                        priced[k].refused = wrong.what();
                    } catch (...) {
                        std::lock_guard const lock(mutex_);
                        error = std::current_exception();
                    }
                }
            };
            {
                Threads others;
                for (std::uint32_t k = 1; k < threads; ++k) others.all.emplace_back(price);
                price();
            }
            if (error) std::rethrow_exception(error);
        }
        std::lock_guard const lock(mutex_);
        for (std::size_t k = 0; k < priced.size(); ++k) {
            auto const i = group.members[k];
            points_[i] = std::move(priced[k]);
            identify(i);
            points_[i].picture = picture;
            if (!frames) points_[i].refused = refused;
            done_[i] = true;
        }
        ++ran_;
        write_points();
        if (!options_.quiet)
            std::cerr << shared::one_line("run " + thousands(ran_) + " of " + thousands(groups_.size()) + ": " + first.name + ", " + thousands(priced.size()) +
                                              (priced.size() == 1 ? " point" : " points, one run"), 200)
                      << std::endl;
    }
    /// The references of a setting's map, computed once.
    std::vector<report::Image> const& references(Setting const& s)
    {
        std::lock_guard const lock(references_mutex_);
        auto const at = references_.find(s.subject.get());
        if (at != references_.end()) return at->second;
        auto all = explore::references_of(*s.subject, options_.threads); // whole or, after an exception, not there
        return references_.emplace(s.subject.get(), std::move(all)).first->second;
    }
    void write_points() const
    {
        std::string text;
        for (std::size_t i = 0; i < points_.size(); ++i)
            if (done_[i]) text += line_of(points_[i]);
        report::write_whole(options_.out / points_file, text);
    }

    Options const& options_;
    Study const& study_;
    std::vector<Group> groups_;
    std::vector<std::string> digests_;
    std::vector<std::uint64_t> sram_;
    std::vector<Point> points_;
    std::vector<bool> done_;
    std::size_t taken_over_ = 0, ran_ = 0;
    std::string note_;
    std::map<explore::Subject const*, std::vector<report::Image>> references_;
    std::mutex mutex_, references_mutex_;
    std::atomic<bool> failed_ = false;
    std::exception_ptr error_;
};

/// What a point costs.
std::string text_of(Setting const& s, Point const& p)
{
    return p.name + ": " + (std::isinf(p.psnr_db) ? "equal" : report::decimals(p.psnr_db, 2) + " dB") + ", " + report::decimals(p.modelled_ms, 4) +
           " ms (" + explore::weakest_text(p) + "), " + thousands(p.sram_bytes) + " bytes of SRAM a tile (" + thousands(explore::free_bytes(s, p)) +
           " free), " + thousands(p.exchanged_bytes) + " bytes exchanged" + (p.whole_channels ? " by whole channels\n" : " as messages\n");
}
/// Machines that no point of a map's front has: the fastest point of each, or why it has none.
std::string beside_front(Study const& study, std::vector<Point> const& points, std::string const& map, std::vector<std::size_t> const& front)
{
    std::string text;
    std::set<std::string> said;
    auto const machine_of = [&](std::size_t i) -> std::string const& { return study.settings[i].machine->name; };
    for (auto const i : front) said.insert(machine_of(i));
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (study.settings[i].subject->name != map || !said.insert(machine_of(i)).second) continue;
        auto best = i;
        for (auto k = i; k < points.size(); ++k)
            if (study.settings[k].subject->name == map && machine_of(k) == machine_of(i) && points[k].refused.empty() &&
                (!points[best].refused.empty() || points[k].modelled_ms < points[best].modelled_ms))
                best = k;
        auto const& p = points[best];
        text += "  " + (p.refused.empty() ? "beside it: " + text_of(study.settings[best], p)
                                          : shared::one_line("refused: " + p.name + ": " + p.refused) + "\n");
    }
    return text;
}

int run(Options const& o)
{
    auto const study = explore::load_study(o.study);
    check_outputs(o, study);
    Exploration exploration(o, study);
    auto const how = thousands(study.settings.size()) + " points: " + thousands(exploration.taken_over()) + " from an earlier run, " +
                     thousands(exploration.runs()) + " runs for " + thousands(exploration.to_price()) +
                     " points. Points with the same counts share a run; prices, clocks and networks need none.";
    if (!o.quiet) std::cerr << exploration.note() << how << std::endl;
    for (auto const& note : study.notes)
        if (!o.quiet) std::cerr << shared::one_line(note) << std::endl;
    exploration.run();
    if (auto const signal = shared::interrupt(); signal != 0 && exploration.finished() < study.settings.size()) {
        std::cerr << "interrupted after " << exploration.finished() << " of " << study.settings.size() << " points (" << shared::signal_name(signal)
                  << "); the same command goes on" << std::endl;
        return 128 + signal;
    }
    auto const& points = exploration.points();
    std::vector<tilemesh::StudyPoint> const values(points.begin(), points.end());
    report::write_whole(o.csv, csv_of(study, points));
    auto said = how;
    for (auto const& note : study.notes) said += " Note: " + note + ".";
    report::write_whole(o.out / page_file, page_of(study, points, said));
    if (o.quiet) return 0;
    std::string text = how + "\n";
    bool has_knee = false;
    for (auto const& [map, front] : fronts_of(values)) {
        auto const of = std::find_if(study.settings.begin(), study.settings.end(), [&name = map](Setting const& s) { return s.subject->name == name; });
        text += "the front of " + map + " (" + of->subject->view + "):\n";
        for (auto const i : front) {
            if (front.size() > 20 && i != front.front() && i != front.back()) continue; // the line below counts these
            text += "  " + text_of(study.settings[i], points[i]);
        }
        if (front.size() > 20) text += "  (" + thousands(front.size() - 2) + " points between the fastest and the slowest are in the table)\n";
        text += beside_front(study, points, map, front);
        text += knee_text(values, front) + "\n";
        has_knee = has_knee || knee_of(values, front);
    }
    if (has_knee) text += std::string(tilemesh::knee_meaning) + "\n";
    text += "wrote " + o.csv.string() + " and " + (o.out / page_file).string() + "\n";
    shared::print(text, "the study is written; --quiet prints errors only", std::cout);
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    return shared::run_program("explore", options_of, run, argc, argv);
}
