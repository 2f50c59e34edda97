// torture_program RENDER_MAP FAILING_CALLS CORPUS [PROGRAM]
// Runs several command lines of render_map, or of PROGRAM (track_camera, slam, explore), on a tiny map, with the library FAILING_CALLS
// preloaded. The k-th allocation, open, write, rename, fsync, mkdir or thread start fails, alone or with all after it, for every k up to the
// last. Each run must end with status 0 and the right files, or with status 2 and one line "<problem> (<why>); <what to do>". Each file must
// be complete or unchanged, the inputs must not change, and nothing else may be left behind. Where the same command goes on after an error
// (slam --resume, explore), it must then end with the right files. Unless the environment variable TILEMESH_TORTURE is "all", it tries about four
// values of k for each kind of call and command line; with "all" every one of up to 2,000, or as many of more. It prints a table at the end.
#include "torture.hpp"
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <new>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <sys/mman.h>
#include <sys/wait.h>
#include <tilemesh/model/cost_parameters.hpp>
#include <unistd.h>
#include <vector>

namespace {

namespace fs = std::filesystem;
using torture::Kind;
using torture::Page;

std::string contents(fs::path const& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// The files below a folder: path and text.
using Files = std::map<std::string, std::string>;
Files texts_of(fs::path const& folder)
{
    Files all;
    if (!fs::exists(folder)) return all;
    for (auto const& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) all[entry.path().lexically_relative(folder).string()] = contents(entry.path());
    return all;
}
/// The list of finished frames. A frame that cannot be read back is rendered again, and has its line again: `once` leaves that out.
constexpr char const* journal = "resume.jsonl";
constexpr char const* checkpoint = "checkpoint.bin";
std::string once(std::string const& text)
{
    std::istringstream in(text);
    std::set<std::string> lines;
    std::string all;
    for (std::string line; std::getline(in, line);)
        if (lines.insert(line).second) all += line + (in.eof() ? "" : "\n");
    return all;
}
/// The same files, to be compared: host times differ from run to run, so they are 0.
Files files_of(fs::path const& folder)
{
    static std::regex const times("\"(keyframe_)?host_ms(_per_frame)?\": ?(\\{[^}]*\\}|[-+.0-9e]+)"), seals(",\"(digest|check)\":\"[0-9a-f]*\"\\}\n");
    auto all = texts_of(folder);
    for (auto& [name, text] : all) {
        fs::path const file = fs::path(name).filename();
        if (file.extension().string().starts_with(".json")) text = std::regex_replace(text, times, "\"host_ms\": 0");
        if (file.extension() == ".jsonl") text = std::regex_replace(text, seals, "}\n"); // a digest has the times, too
        if (file == journal) text = once(text);
        if (file == checkpoint && !text.empty()) text = checkpoint; // it has times; a run that goes on proves it
    }
    return all;
}

struct Ended {
    int status = 0;   ///< 128 + the signal where one ended it
    std::string out, err;
};

class Driver {
public:
    Driver(fs::path program, fs::path failing) : program_(std::move(program)), failing_(std::move(failing))
    {
        auto name = (fs::temp_directory_path() / "tilemesh_torture_XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
        work_ = name;
        auto const file = (work_ / "page").string();
        file_ = ::open(file.c_str(), O_RDWR | O_CREAT, 0600);
        if (file_ < 0 || ::ftruncate(file_, sizeof(Page)) != 0) throw std::runtime_error("no file for the page");
        auto* const at = ::mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
        if (at == MAP_FAILED) throw std::runtime_error("no memory for the page");
        page_ = new (at) Page;
        fs::create_directory(work_ / "in");
    }
    ~Driver() { fs::remove_all(work_); }
    Driver(Driver const&) = delete;
    Driver& operator=(Driver const&) = delete;

    fs::path work() const { return work_; }
    Page& page() { return *page_; }

    Ended run(std::vector<std::string> const& words) { return run(program_, words); }
    Ended run(fs::path const& of, std::vector<std::string> const& words)
    {
        auto const child = ::fork();
        if (child < 0) throw std::runtime_error("no process");
        if (child == 0) {
            if (::chdir(work_.c_str()) != 0) ::_exit(99);
            ::dup2(::open("/dev/null", O_RDONLY), 0);
            ::dup2(::open("stdout", O_WRONLY | O_CREAT | O_TRUNC, 0600), 1);
            ::dup2(::open("stderr", O_WRONLY | O_CREAT | O_TRUNC, 0600), 2);
            ::setenv("TILEMESH_TORTURE_PAGE", std::to_string(file_).c_str(), 1);
            ::setenv("LD_PRELOAD", failing_.c_str(), 1);
            std::vector<char*> arguments;
            auto program = of.string();
            arguments.push_back(program.data());
            auto copy = words;
            for (auto& word : copy) arguments.push_back(word.data());
            arguments.push_back(nullptr);
            ::alarm(60); // what hangs is ended, and counts as wrong
            ::execv(program.c_str(), arguments.data());
            ::_exit(98);
        }
        int status = 0;
        while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {}
        Ended ended;
        ended.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        ended.out = contents(work_ / "stdout");
        ended.err = contents(work_ / "stderr");
        return ended;
    }

private:
    fs::path program_, failing_, work_;
    int file_ = -1;
    Page* page_ = nullptr;
};

/// One line. Before it may stand what explore says while it runs.
bool is_refusal(std::string const& text)
{
    static std::regex const form("((run )?[0-9]+ (of|points: )[^\\n]*\\n)*[^(\\n][^\\n]* \\([^\\n]*\\); [^\\n]+\\n");
    return std::regex_match(text, form);
}

/// Standard output with each number, and the blanks and rules that make room for it, as one #: times differ from run to run.
std::string masked(std::string const& text)
{
    static std::regex const numbers("[-0-9., ]+");
    return std::regex_replace(text, numbers, "#");
}

/// The files, but for the counts of an HTML page: how many points are from an earlier run.
Files results_of(Files files)
{
    for (auto& [name, text] : files)
        if (fs::path(name).extension() == ".html") text = masked(text);
    return files;
}

/// A whole report.json that says that it has not all frames.
bool is_report_of_frames_done(std::string const& text)
{
    return text.find("stopped after frame") != std::string::npos && text.ends_with("}\n") && nlohmann::json::accept(text);
}

/// A whole binary PLY of floats: it has as many bytes as its header says.
bool is_whole_ply(std::string const& text)
{
    constexpr std::string_view mark = "end_header\n", count = "element vertex ";
    auto const end = text.find(mark), vertices = text.find(count);
    if (end == text.npos || vertices > end) return false;
    std::size_t properties = 0;
    for (auto at = text.find("property float "); at < end; at = text.find("property float ", at + 1)) ++properties;
    return text.size() == end + mark.size() + 4 * properties * std::stoul(text.substr(vertices + count.size()));
}
/// Each line is one of the right ones.
bool is_some_lines(std::string const& text, std::string const& right)
{
    if (!text.empty() && text.back() != '\n') return false;
    std::istringstream lines(text), all(right);
    std::set<std::string> known;
    for (std::string line; std::getline(all, line);) known.insert(line);
    for (std::string line; std::getline(lines, line);)
        if (known.count(line) == 0) return false;
    return true;
}

/// Is it a whole file of track_camera, slam or explore about what was done before the call that failed?
bool is_of_the_part_done(fs::path const& name, std::string const& text, std::string const& right)
{
    if (name.extension() == ".ply") return is_whole_ply(text);
    if (name.extension() == ".html") return text.ends_with("</html>\n");
    if (name.extension() == ".jsonl") return is_some_lines(text, right);
    if (name.extension() == ".tum" || name.extension() == ".txt") return text.ends_with('\n') && right.starts_with(text);
    if (name.filename() == "residual.png")
        return text.starts_with(right.substr(0, 24)) && text.ends_with(right.substr(right.size() - 12)); // size, end
    if (name.filename() == "paths.svg") return text.ends_with("</svg>\n");
    return name.extension() == ".json" && nlohmann::json::accept(text);
}

/// The list of finished frames is written line by line: the first lines of the right one, and perhaps one that is cut short.
bool is_journal_so_far(std::string const& text, std::string const& right)
{
    return right.starts_with(text.substr(0, text.rfind('\n') + 1));
}

struct Row {
    std::string name;
    std::uint64_t last = 0, runs = 0, right = 0, refused = 0, wrong = 0;
};

struct Command {
    char const* name;
    std::vector<std::string> words;
};

std::vector<Command> commands()
{
    return {
        {"render", {"in/map.ply", "--size", "40x30", "--grid", "3x2", "--threads", "1", "--out", "files/out", "--report", "files/out/report.json",
                    "--float", "--depth", "--alpha", "--orbit", "20", "--frames", "2"}},
        {"trace", {"in/map.ply", "--cameras", "in/own.json", "--camera", "desk/front", "--size", "40x30", "--grid", "3x2", "--threads", "1", "--out", "files/out",
                   "--trace", "files/trace", "--cost-model", "in/costs.txt", "--energy", "in/energy.txt", "--follow", "1", "--explain"}},
        {"video", {"in/map.ply", "--size", "40x30", "--grid", "3x2", "--threads", "1", "--orbit", "20", "--frames", "2", "--out", "files/out",
                   "--video", "files/walk.y4m"}},
        {"resume", {"in/map.ply", "--size", "40x30", "--grid", "3x2", "--threads", "1", "--orbit", "20", "--frames", "2", "--out", "files/out",
                    "--report", "files/out/report.json", "--resume", "--quiet"}},
        {"checked", {"in/map.ply", "--cameras", "in/training.json", "--size", "40x30", "--grid", "3x2", "--engine", "sequential", "--out",
                     "files/out", "--quiet"}},
        {"threads", {"in/map.ply", "--trajectory", "in/plain.tum", "--relative", "--frames", "2", "--size", "40x30", "--grid", "3x2", "--threads", "3",
                     "--out", "files/out", "--reference", "--quiet"}},
        {"colmap", {"in/map.ply", "--cameras", "in/model", "--size", "40x30", "--grid", "3x2", "--threads", "1", "--out", "files/out", "--preset", "paper"}},
        {"help", {"--help"}},
        {"refusal", {"in/no_such_map.ply"}},
    };
}

std::vector<Command> commands_of_track_camera()
{
    return {
        {"rendered", {"in/some.ply", "--frames", "2", "--size", "48x36", "--threads", "1", "--out", "files/out", "--report", "files/report.json",
                      "--save-photos", "files/photos"}},
        {"photos", {"in/some.ply", "--photos", "in/photos", "--cameras", "in/lens.json", "--trajectory", "in/photos/groundtruth.txt", "--threads", "1", "--out",
                    "files/out", "--report", "files/report.json", "--quiet"}},
        {"threads", {"in/some.ply", "--frames", "1", "--size", "48x36", "--threads", "3", "--out", "files/out", "--quiet"}},
        {"refusal", {"in/no_such_map.ply"}},
    };
}
std::vector<Command> commands_of_slam(bool has_photos)
{
    auto const sized = [](std::vector<std::string> words, char const* threads) {
        for (auto const* word : {"--frames", "2", "--steps", "1", "--finish", "1", "--keyframe-every", "2", "--threads", threads, "--out", "files/out"})
            words.emplace_back(word);
        return words;
    };
    std::vector<Command> all = {
        {"rendered", sized({"--render", "in/some.ply", "--size", "48x36", "--report", "files/report.json", "--page", "files/page.html"}, "1")},
        {"resume", sized({"--render", "in/some.ply", "--size", "48x36", "--report", "files/report.json", "--resume", "--quiet"}, "1")},
        {"threads", sized({"--map", "in/some.ply", "--render", "in/some.ply", "--size", "48x36", "--quiet"}, "3")},
        {"refusal", {"--render", "in/no_such_map.ply"}},
    };
    if (has_photos)
        all.push_back({"photos", sized({"--photos", "in/photos", "--cameras", "in/any_lens.json", "--trajectory", "in/photos/groundtruth.txt", "--quiet"}, "1")});
    return all;
}

std::vector<Command> commands_of_explore()
{
    return {
        {"study", {"in/study.json", "--csv", "files/points.csv", "--out", "files/out", "--threads", "1"}},
        {"threads", {"in/study.json", "--csv", "files/points.csv", "--out", "files/out", "--threads", "3", "--quiet"}},
        {"refusal", {"in/no_such_study.json", "--csv", "files/points.csv", "--out", "files/out"}},
    };
}
/// Two runs and four points; one of the machines is too small.
constexpr char const* study = R"({"maps": [{"file": "map.ply", "cameras": "own.json", "camera": "desk/front"}], "size": [40, 30], "grid": [3, 2],
  "machines": ["mk2.txt", {"file": "mk2.txt", "name": "small", "sram": 134000}], "programs": ["homes"],
  "sizes": [{"channel": [4, 8]}], "costs": ["machine", {"exchange_byte": 125}]}
)";

/// A map of 150 Gaussians in which a camera finds its pose.
void write_some(fs::path const& path)
{
    std::ofstream out(path);
    out << "ply\nformat ascii 1.0\nelement vertex 150\n";
    for (auto const* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
        out << "property float " << name << '\n';
    out << "end_header\n";
    std::uint32_t state = 1;
    auto const next = [&](double from, double to) { // MMIX's generator (Knuth) in 32 bits
        state = 1664525u * state + 1013904223u;
        return from + (to - from) * (state >> 8) / 16777216.0;
    };
    for (int i = 0; i < 150; ++i) {
        out << next(-1.5, 1.5) << ' ' << next(-1, 1) << ' ' << next(3, 5);
        for (int c = 0; c < 3; ++c) out << ' ' << next(-1.5, 1.5);
        out << " 2";
        for (int c = 0; c < 3; ++c) out << ' ' << next(-2.5, -1.5);
        out << " 1 " << next(0, 1) << ' ' << next(0, 1) << " 0\n";
    }
}

/// What is wrong with a run; empty: nothing.
std::string fault(Ended const& ended, Ended const& right, Files const& now, Files const& right_files, Files const& old, bool has_parts)
{
    if (ended.status != 0 && ended.status != 2) return "status " + std::to_string(ended.status) + ": " + ended.err;
    if (ended.status == right.status) { // whatever failed, it went on
        if (ended.err == right.err && now == right_files && masked(ended.out) == masked(right.out)) return {};
        if (ended.status == 0) return "status 0, and another result: " + ended.err + ended.out;
    }
    if (!is_refusal(ended.err)) return "not one line of an error: " + ended.err;
    for (auto const& [name, text] : now) {
        auto const before = old.find(name), after = right_files.find(name);
        bool const as_before = before != old.end() && before->second == text, as_after = after != right_files.end() && after->second == text;
        bool const of_frames_done = fs::path(name).filename() == "report.json" && is_report_of_frames_done(text);
        bool const so_far = fs::path(name).filename() == journal && after != right_files.end() && is_journal_so_far(text, after->second);
        bool const of_part = has_parts && after != right_files.end() && is_of_the_part_done(name, text, after->second);
        if (!as_before && !as_after && !of_frames_done && !so_far && !of_part) return "a part of " + name + " is left; " + ended.err;
    }
    for (auto const& [name, text] : old)
        if (now.find(name) == now.end()) return name + " is lost; " + ended.err;
    return {};
}

} // namespace

int main(int argc, char** argv)
try {
    char const* const wanted = std::getenv("TILEMESH_TORTURE");
    bool const all = wanted != nullptr && std::string(wanted) == "all";
    std::vector<fs::path> paths;
    for (int i = 1; i < argc; ++i) paths.push_back(fs::absolute(argv[i]));
    if (paths.size() != 3 && paths.size() != 4) {
        std::cerr << "torture_program: three or four paths are needed; usage: torture_program RENDER_MAP FAILING_CALLS CORPUS [PROGRAM]\n";
        return 2;
    }
    std::string const program = paths.size() == 4 ? paths[3].filename().string() : "render_map";
    Driver driver(paths.size() == 4 ? paths[3] : paths[0], paths[1]);
    auto const in = driver.work() / "in";
    fs::copy_file(paths[2] / "ply" / "little_endian.ply", in / "map.ply");
    for (auto const* name : {"own.json", "training.json"}) fs::copy_file(paths[2] / "cameras" / name, in / name);
    fs::copy_file(paths[2] / "trajectory" / "plain.tum", in / "plain.tum");
    std::ofstream costs(in / "costs.txt"), energy(in / "energy.txt");
    tilemesh::write_cost_model(costs, tilemesh::mk2());
    costs.close();
    energy << "energy of a test\n";
    for (auto const* event : {"slot", "projection", "routed", "copied", "comparison", "pair", "pixel", "sent_byte", "capacity_byte", "tile_cycle"})
        energy << event << " 1 fJ a test\n";
    energy.close();
    fs::create_directory(in / "model");
    std::ofstream(in / "model" / "cameras.txt") << "1 PINHOLE 64 48 50 50 32 24\n";
    std::ofstream(in / "model" / "images.txt") << "1 1 0 0 0 0 0 0 1 a.png\n\n";
    auto const track_camera = paths[0].parent_path() / "track_camera";
    bool const has_photos = program == "track_camera" || (program == "slam" && fs::exists(track_camera));
    if (program != "render_map") write_some(in / "some.ply");
    if (has_photos) {
        auto const made = driver.run(track_camera, {"in/some.ply", "--frames", "2", "--size", "48x36", "--save-photos", "in/photos", "--out", "out"});
        if (made.status != 0) throw std::runtime_error("no photographs: " + made.err);
        constexpr char const* lens = R"("name": "a", "width": 48, "height": 36, "fx": 40, "fy": 40, "cx": 24, "cy": 18,
            "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]})";
        std::ofstream(in / "lens.json") << R"({"cameras": [{"scene": "some", )" << lens;
        std::ofstream(in / "any_lens.json") << R"({"cameras": [{)" << lens;
    }
    if (program == "explore") {
        fs::copy_file(fs::path(paths[2]).parent_path().parent_path().parent_path() / "examples" / "machines" / "mk2.txt", in / "mk2.txt");
        std::ofstream(in / "study.json") << study;
    }
    auto const inputs = files_of(in);

    auto const files = driver.work() / "files";
    std::vector<Row> rows;
    for (auto const& command : program == "track_camera" ? commands_of_track_camera() : program == "slam" ? commands_of_slam(has_photos)
                               : program == "explore" ? commands_of_explore() : commands()) {
        std::string const command_name = command.name;
        bool const goes_on = (program == "slam" && command_name == "resume") || (program == "explore" && command_name != "refusal");
        // An output that is already there must be whole after every run: as it was, or new. Every second run finds the outputs of an earlier one;
        // with --resume these are the right ones.
        auto const prepare = [&](Files const& old) {
            fs::remove_all(files);
            fs::create_directory(files);
            for (auto const& [name, text] : old) {
                fs::create_directories((files / name).parent_path());
                std::ofstream(files / name, std::ios::binary) << text;
            }
        };
        for (std::uint32_t kind = 0; kind < std::size(torture::names); ++kind) {
            auto const name = std::string(command.name) + ", " + torture::names[kind];
            auto& page = driver.page();
            auto const order = [&](std::uint64_t first, bool alone) {
                page.kind = static_cast<Kind>(kind);
                page.alone = alone ? 1 : 0;
                page.first = first;
                page.calls = 0;
            };
            order(0, true);
            prepare({});
            auto const right = driver.run(command.words);
            auto const right_files = files_of(files);
            if (right.status != 0 && std::string(command.name) != "refusal") {
                std::cerr << "torture_program: " << command.name << " ends with status " << right.status << ": " << right.err;
                return 1;
            }
            auto old = texts_of(files); // --resume goes on from them
            if (command_name != "resume")
                for (auto& [file, text] : old) text = fs::path(file).extension() == ".jsonl" ? "" : "as it was\n"; // explore notes foreign lines
            auto const old_files = command_name != "resume" ? old : right_files;
            Row row{name, page.calls, 0, 0, 0, 0};
            std::uint64_t const most = all ? 2000 : 4;
            auto const step = std::max<std::uint64_t>(1, row.last / most);
            for (bool const alone : {true, false})
                for (std::uint64_t k = 1; k <= row.last; k += step) {
                    bool const from_old = k / step % 2 == 0;
                    prepare(from_old ? old : Files{});
                    order(k, alone);
                    auto const ended = driver.run(command.words);
                    ++row.runs;
                    auto what = fault(ended, right, files_of(files), right_files, from_old ? old_files : Files{}, program != "render_map");
                    if (what.empty() && files_of(in) != inputs) what = "an input changed";
                    // pthread_create says EAGAIN both without memory and without threads.
                    bool const is_told = ended.err.find("memory") != std::string::npos || ended.err.find("thread") != std::string::npos;
                    if (what.empty() && page.kind == Kind::memory && right.status == 0 && ended.status == 2 && !is_told)
                        what = "lack of memory is told as something else: " + ended.err;
                    if (what.empty() && goes_on && ended.status == 2) {
                        order(0, true);
                        auto const again = driver.run(command.words);
                        if (again.status != 0 || results_of(files_of(files)) != results_of(right_files)) what = "the same command does not go on: " + ended.err + again.err;
                    }
                    if (what.empty()) {
                        ++(ended.status == 0 ? row.right : row.refused);
                    } else if (++row.wrong <= 5) {
                        std::cout << "WRONG: " << name << ", k " << k << (alone ? "" : " and all after") << ": " << what << std::endl;
                    }
                }
            rows.push_back(row);
        }
    }
    std::printf("%-24s %8s %8s %8s %8s %8s\n", "case", "last k", "runs", "right", "refused", "wrong");
    Row sum{"all", 0, 0, 0, 0, 0};
    for (auto const& row : rows)
        sum.last += row.last, sum.runs += row.runs, sum.right += row.right, sum.refused += row.refused, sum.wrong += row.wrong;
    std::erase_if(rows, [](Row const& row) { return row.last == 0; });
    rows.push_back(sum);
    for (auto const& row : rows) {
        std::printf("%-24s", row.name.c_str());
        for (unsigned long long const count : {row.last, row.runs, row.right, row.refused, row.wrong}) std::printf(" %8llu", count);
        std::printf("\n");
    }
    return sum.wrong == 0 && sum.runs != 0 ? 0 : 1;
} catch (std::exception const& error) {
    std::cerr << "torture_program: " << error.what() << '\n';
    return 2;
}
