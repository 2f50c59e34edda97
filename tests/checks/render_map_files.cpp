// Random names for the files that render_map reads and writes: links, hard links, folders that are links, `..`, capital letters, line
// breaks and escapes. A model, independent of render_map's own check, tells for each run whether two files clash. render_map must refuse a
// run with a clash and change no file. Any other run must succeed, write the same outputs as a run with plain names, and change nothing else.
//
// usage: check_render_map_files RENDER_MAP RUNS [FIRST_SEED]: a failure prints its seed, and the seed alone repeats it.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

std::string contents(fs::path const& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
void write(fs::path const& path, std::string const& text)
{
    std::ofstream(path, std::ios::binary) << text;
}

// --- what is read ------------------------------------------------------------------------------

std::string map_text()
{
    std::string text = "ply\nformat ascii 1.0\nelement vertex 2\n";
    for (auto const* p : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
        text += std::string("property float ") + p + "\n";
    return text + "end_header\n-1 0 3 1 0.5 0 2 -1 -1 -1 1 0 0 0\n1 0 3 1 0.5 0 2 -1 -1 -1 1 0 0 0\n";
}
constexpr char const* cameras_json = R"({"cameras": [{"scene": "any", "name": "a", "width": 16, "height": 12, "fx": 9, "fy": 9, "cx": 8, "cy": 6,
 "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 3], [0, 0, 0, 1]]}]})";
constexpr char const* colmap_cameras = "1 PINHOLE 16 12 9 9 8 6\n";
constexpr char const* colmap_images = "1 1 0 0 0 0 0 3 1 a\n\n";
constexpr char const* walk = "0 0 0 0 0 0 0 1\n1 0.1 0 0 0 0 0 1\n";
constexpr char const* events[] = {"slot", "projection", "routed", "copied", "comparison", "pair", "pixel", "sent_byte", "capacity_byte", "tile_cycle"};

// --- runs --------------------------------------------------------------------------------------

struct Result {
    int status = 0;
    std::string errors;
};

/// Runs the program in `folder`. A run that hangs is ended by SIGALRM.
Result run(fs::path const& program, fs::path const& folder, Words const& words, fs::path const& out, bool append)
{
    auto const errors = folder.parent_path() / "stderr";
    auto const child = fork();
    if (child < 0) throw std::runtime_error("fork failed");
    if (child == 0) {
        alarm(60);
        int const in = open("/dev/null", O_RDONLY);
        int const to = open(out.c_str(), O_WRONLY | O_CREAT | (append ? O_APPEND : O_TRUNC), 0666);
        int const err = open(errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
        if (chdir(folder.c_str()) != 0 || dup2(in, 0) < 0 || dup2(to, 1) < 0 || dup2(err, 2) < 0) _exit(99);
        std::vector<char*> arguments{const_cast<char*>(program.c_str())};
        for (auto const& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
        arguments.push_back(nullptr);
        execv(program.c_str(), arguments.data());
        _exit(99);
    }
    int status = 0;
    while (waitpid(child, &status, 0) < 0) {}
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), contents(errors)};
}

// --- the model ---------------------------------------------------------------------------------

using Id = std::pair<dev_t, ino_t>;

/// The place to which a file with this name is written: links followed, the folder by its real path, letters without case. Empty if there
/// is no such folder.
std::string place(fs::path path)
{
    for (int i = 0; fs::is_symlink(fs::symlink_status(path)) && i < 50; ++i) path = path.parent_path() / fs::read_symlink(path);
    std::error_code ring;
    if (fs::is_symlink(fs::symlink_status(path)) || !fs::is_directory(path.parent_path(), ring)) return {};
    auto name = path.filename().string();
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return c < 128 ? static_cast<char>(std::tolower(c)) : static_cast<char>(c); });
    return (fs::canonical(path.parent_path()) / name).string();
}
bool identify(fs::path const& path, Id& id)
{
    struct stat file {};
    if (stat(path.c_str(), &file) != 0 || !S_ISREG(file.st_mode)) return false;
    id = {file.st_dev, file.st_ino};
    return true;
}

/// Every file below a folder, with its content or the target of its link.
std::map<std::string, std::string> snapshot(fs::path const& folder)
{
    std::map<std::string, std::string> files;
    for (auto const& entry : fs::recursive_directory_iterator(folder)) {
        auto const status = entry.symlink_status();
        auto& text = files[entry.path().string()];
        if (fs::is_symlink(status)) text = "link to " + fs::read_symlink(entry.path()).string();
        else if (fs::is_regular_file(status)) text = "file: " + contents(entry.path());
        else text = fs::is_directory(status) ? "folder" : "other";
    }
    return files;
}

// --- a scenario --------------------------------------------------------------------------------

/// The options besides names. Runs with equal features have equal pictures.
struct Features {
    bool cameras = false, colmap = false, trajectory = false, trace = false, energy = false, model = false, pfm = false, alpha = false,
         report = false, video = false, resume = false;
    auto operator<=>(Features const&) const = default;
};
Words words_of(Features const& f)
{
    Words words{"--size", "16x12", "--grid", "2x2", "--threads", "1"};
    if (f.pfm) words.push_back("--float");
    if (f.alpha) words.push_back("--alpha");
    if (f.resume) words.push_back("--resume");
    if (f.cameras) words.insert(words.end(), {"--camera", "a"});
    if (f.trace) words.insert(words.end(), {"--follow", "1"});
    if (!f.trajectory) words.insert(words.end(), {"--orbit", "1", "--frames", "2"});
    return words;
}

/// Files by their names in the folders of the pictures and of the trace.
struct Outputs {
    std::map<std::string, std::string> pictures, trace;
};

class Scenario {
public:
    Scenario(fs::path program, fs::path folder, std::uint64_t seed)
        : program_(std::move(program)), folder_(std::move(folder)), random_(seed)
    {
    }

    /// Empty, or a description of the failure.
    std::string check(std::map<Features, Outputs>& known);

    enum class Outcome : std::uint32_t { not_run, refused, done };
    Outcome outcome() const { return outcome_; }

private:
    bool one_in(unsigned n) { return random_() % n == 0; }
    template <class T>
    T const& any_of(std::vector<T> const& list)
    {
        return list[random_() % list.size()];
    }
    fs::path any_name()
    {
        static Words const names{"frame_0000.png",       "frame_0001.png",       "frame_0002.png", "FRAME_0000.PNG", "frame_0000.pfm",
                                 "frame_0001.alpha.pfm", "frame_00000.png",      "frame_0.png",    "report.json",    "report.html",
                                 "Report.HTML",          "model.txt",            "frames.csv",     "follow_1.csv",   "frame_0000.tiles.csv",
                                 "frame_0001.heat.csv",  "frame_0000.heat_load.png", "frame_0001.trace.json", "no_progress.txt", "resume.jsonl",
                                 "cameras.txt",          "images.txt",           "a map.ply",      "two\nlines",     "\033[31mred",
                                 "latin\xe9",            "percent%s%n",          "frame_0000.png.part",  "walk.y4m",             "walk.y4m.part"};
        return any_of(names);
    }
    fs::path any_folder() { return any_of(std::vector<fs::path>{"in", "in", "pictures", "pictures", "trace", "model"}); }
    /// Another way to write the name of a file that is in one of the folders.
    fs::path spelled(fs::path const& path)
    {
        switch (random_() % 5) {
        case 0: return path.parent_path() / ".." / path;
        case 1: return fs::path(path.parent_path().string() + "_link") / path.filename();
        case 2: return folder_ / path;
        case 3: return "." / path;
        default: return path;
        }
    }
    /// A free place for a new file; empty after some failures.
    fs::path free_place()
    {
        for (int i = 0; i < 20; ++i)
            if (auto const path = any_folder() / any_name(); !fs::exists(fs::symlink_status(folder_ / path))) return path;
        return {};
    }
    /// Puts a file somewhere, and returns a name for it, perhaps that of a link to it.
    fs::path place_input(std::string const& text, fs::path const& own_name)
    {
        auto path = one_in(2) ? fs::path() : free_place();
        if (path.empty()) path = "in" / own_name;
        write(folder_ / path, text);
        if (one_in(3))
            if (auto const link = free_place(); !link.empty()) {
                if (one_in(2)) fs::create_symlink(fs::path("..") / path, folder_ / link);
                else fs::create_hard_link(folder_ / path, folder_ / link);
                things_.push_back(path);
                path = link;
            }
        things_.push_back(path);
        return spelled(path);
    }
    void add_links();
    Outputs reference(Features const& f);
    Words inputs_in(fs::path const& folder, Features const& f);
    std::string energy_text() const
    {
        std::string text = "energy test\n";
        for (auto const* event : events) text += std::string(event) + " 1 fJ nobody\n";
        return text;
    }

    fs::path program_, folder_;
    std::mt19937_64 random_;
    std::vector<fs::path> things_; ///< files that links may lead to
    Outcome outcome_ = Outcome::not_run; ///< a scenario is not run if its files cannot be made, or if it would wait for a reader
};

Words Scenario::inputs_in(fs::path const& folder, Features const& f)
{
    fs::create_directories(folder / "sparse");
    write(folder / "map.ply", map_text());
    write(folder / "cameras.json", cameras_json);
    write(folder / "sparse/cameras.txt", colmap_cameras);
    write(folder / "sparse/images.txt", colmap_images);
    write(folder / "walk.txt", walk);
    write(folder / "energy.txt", energy_text());
    Words words{"map.ply"};
    if (f.cameras) words.insert(words.end(), {"--cameras", f.colmap ? "sparse" : "cameras.json"});
    if (f.trajectory) words.insert(words.end(), {"--trajectory", "walk.txt"});
    if (f.energy) words.insert(words.end(), {"--energy", "energy.txt"});
    return words;
}

/// A run with plain names, each kind of file in a folder of its own.
Outputs Scenario::reference(Features const& f)
{
    auto const own = folder_.parent_path() / "reference";
    fs::remove_all(own);
    auto words = inputs_in(own, f);
    for (auto const& word : words_of(f)) words.push_back(word);
    words.insert(words.end(), {"--out", "pictures", "--quiet"});
    if (f.trace) words.insert(words.end(), {"--trace", "trace"});
    if (auto const r = run(program_, own, words, "/dev/null", false); r.status != 0)
        throw std::runtime_error("a run with plain names ends in status " + std::to_string(r.status) + ": " + r.errors);
    Outputs outputs;
    for (auto const& entry : fs::directory_iterator(own / "pictures")) outputs.pictures[entry.path().filename().string()] = contents(entry.path());
    if (f.trace)
        for (auto const& entry : fs::directory_iterator(own / "trace")) outputs.trace[entry.path().filename().string()] = contents(entry.path());
    return outputs;
}

/// Links, older files and pipes under the names of outputs, and others.
void Scenario::add_links()
{
    for (auto n = random_() % 4; n > 0; --n) {
        auto const link = free_place();
        if (link.empty()) return;
        switch (random_() % 8) {
        case 0: write(folder_ / link, "an older file"); break;
        case 1:
            if (one_in(2)) mkfifo((folder_ / link).c_str(), 0666);
            break;
        case 2: fs::create_symlink(fs::path("..") / any_folder() / any_name(), folder_ / link); break; // to what may come to be
        case 3: fs::create_symlink("/dev/null", folder_ / link); break;
        case 4: fs::create_hard_link(fs::canonical(folder_ / any_of(things_)), folder_ / link); break;
        default: fs::create_symlink(fs::path("..") / any_of(things_), folder_ / link); break;
        }
    }
}

std::string Scenario::check(std::map<Features, Outputs>& known)
{
    fs::remove_all(folder_);
    for (auto const* name : {"in", "pictures", "trace", "model"}) {
        fs::create_directories(folder_ / name);
        fs::create_directory_symlink(name, folder_ / (std::string(name) + "_link"));
    }
    Features f;
    f.cameras = !one_in(3);
    f.colmap = f.cameras && one_in(2);
    f.trajectory = one_in(3);
    f.trace = one_in(2);
    f.energy = f.trace && one_in(2);
    f.model = f.trace && one_in(2);
    f.pfm = one_in(2);
    f.alpha = one_in(3);
    f.resume = !f.trace && one_in(4);
    f.report = one_in(2);
    f.video = !f.resume && one_in(3);

    // The files that are read, each in some folder, under some name.
    std::vector<fs::path> read;
    Words words;
    auto const input = [&](char const* option, std::string const& text, char const* name) {
        read.push_back(place_input(text, name));
        if (*option != '\0') words.emplace_back(option);
        words.push_back(read.back().string());
    };
    input("", map_text(), "map.ply");
    if (f.cameras && !f.colmap) input("--cameras", cameras_json, "cameras.json");
    if (f.colmap) {
        auto const model = any_folder();
        for (auto const& [name, text] : {std::pair("cameras.txt", colmap_cameras), std::pair("images.txt", colmap_images)}) {
            auto const path = model / name;
            if (!fs::exists(fs::symlink_status(folder_ / path))) {
                if (one_in(3)) {
                    auto const elsewhere = place_input(text, std::string("of_") + name);
                    if (fs::exists(fs::symlink_status(folder_ / path))) return {}; // it took that name itself
                    fs::create_symlink(elsewhere.is_absolute() ? elsewhere : fs::path("..") / elsewhere, folder_ / path);
                } else write(folder_ / path, text);
            } else return {}; // another input has that name
            things_.push_back(path);
            read.push_back(path);
        }
        auto const named = random_() % 3;
        words.insert(words.end(), {"--cameras", (named == 0 ? model : named == 1 ? spelled(model / "cameras.txt") : spelled(model / "images.txt")).string()});
    }
    if (f.trajectory) input("--trajectory", walk, "walk.txt");
    if (f.model) input("--cost-model", contents(folder_.parent_path() / "model.txt"), "my.txt");
    if (f.energy) input("--energy", energy_text(), "energy.txt");
    for (auto const& word : words_of(f)) words.push_back(word);

    // The files that are written.
    auto plain = f;
    plain.report = plain.video = false;
    if (!known.contains(plain)) known[plain] = reference(plain);
    auto const& expected = known[plain];
    auto const folder_name = [&](char const* own) { return one_in(6) ? fs::path("in") : one_in(3) ? fs::path(std::string(own) + "_link") : fs::path(own); };
    auto const pictures = folder_name("pictures"), trace = folder_name("trace");
    words.insert(words.end(), {"--out", pictures.string()});
    if (f.trace) words.insert(words.end(), {"--trace", trace.string()});
    auto const single = [&](char const* option) {
        auto const path = spelled(one_in(4) ? any_of(things_) : any_folder() / any_name());
        words.insert(words.end(), {option, path.string()});
        return path;
    };
    auto const report = f.report ? single("--report") : fs::path(), video = f.video ? single("--video") : fs::path();
    add_links();
    fs::path out = folder_.parent_path() / "stdout";
    bool const appends = one_in(20);
    if (appends) out = folder_ / any_of(things_);
    else words.emplace_back("--quiet");

    // The model's prediction.
    std::set<Id> inputs;
    Id id;
    for (auto const& path : read)
        if (identify(folder_ / path, id)) inputs.insert(id);
    std::map<std::string, fs::path> written; // by place
    std::string clash;
    Id stream;
    bool const to_file = appends && identify(out, stream);
    if (to_file && inputs.contains(stream)) clash = "standard output goes to an input";
    enum class Reread { no, yes };
    auto const add = [&](fs::path const& path, bool may_be_pipe, Reread reread = Reread::no) {
        std::error_code ring;
        auto const status = fs::status(folder_ / path, ring);
        auto const where = place(folder_ / path);
        if (where.empty()) clash = path.string() + " is in no folder";
        if (fs::is_directory(status)) clash = path.string() + " is a folder";
        if (fs::is_fifo(status) && !may_be_pipe) clash = path.string() + " is a pipe";
        if (fs::is_character_file(status)) {
            if (reread == Reread::yes) clash = path.string() + " is a device";
            return;
        }
        if (identify(folder_ / path, id)) {
            if (inputs.contains(id)) clash = path.string() + " is an input";
            if (to_file && id == stream) clash = path.string() + " is standard output";
        }
        if (!written.emplace(where, path).second) clash = path.string() + " and " + written[where].string() + " are one file";
    };
    for (auto const& [name, text] : expected.pictures) add(pictures / name, false, f.resume ? Reread::yes : Reread::no);
    for (auto const& [name, text] : expected.trace) add(trace / name, false);
    if (f.trace) add(trace / "no_progress.txt", false); // an old one is removed
    std::error_code ring;
    if (f.resume && fs::exists(folder_ / pictures / "resume.jsonl", ring)) clash = "there is a list of frames already";
    for (auto const& path : {report, video}) {
        if (path.empty()) continue;
        if (fs::is_fifo(fs::status(folder_ / path, ring))) return {}; // waits for its reader, as it should
        add(path, true);
    }
    if (appends && fs::is_fifo(fs::status(out, ring))) return {};

    // The run.
    auto const before = snapshot(folder_);
    auto const r = run(program_, folder_, words, out, appends);
    auto const after = snapshot(folder_);
    outcome_ = clash.empty() ? Outcome::done : Outcome::refused;
    std::ostringstream said;
    said << "status " << r.status << ", " << (clash.empty() ? "no clash" : "a clash: " + clash) << "\n  run: render_map";
    for (auto const& word : words) said << " '" << word << "'";
    said << "\n  standard error: " << r.errors << "  ";
    if (!clash.empty()) {
        if (r.status != 2) return said.str() + "not refused";
        if (std::count(r.errors.begin(), r.errors.end(), '\n') != 1 || r.errors.find(" (") == r.errors.npos || r.errors.find("); ") == r.errors.npos)
            return said.str() + "not one line of problem, reason and remedy";
        for (auto const& [path, text] : before)
            if (!after.contains(path) || after.at(path) != text) return said.str() + "a refused run changed " + path;
        if (after.size() != before.size()) return said.str() + "a refused run wrote a file";
        return {};
    }
    if (r.status != 0) return said.str() + "refused";
    for (auto const& [path, text] : before) {
        bool const is_link = text.starts_with("link");
        if (path == (folder_ / fs::canonical(folder_ / trace).filename() / "no_progress.txt").string() && f.trace) continue; // removed
        if (!is_link && written.contains(place(path))) continue;
        if (to_file && identify(path, id) && id == stream) continue;
        if (!after.contains(path) || after.at(path) != text) return said.str() + "changed " + path;
    }
    auto const same_bytes = [](std::string_view name) { // without names or times of this run
        for (auto const* end : {".png", ".pfm", ".tiles.csv", ".supersteps.csv", ".heat.csv", ".energy.csv"})
            if (name.ends_with(end)) return true;
        return false;
    };
    for (auto const& [where, outputs] : {std::pair(pictures, &expected.pictures), std::pair(trace, &expected.trace)})
        for (auto const& [name, text] : *outputs) {
            auto const path = folder_ / where / name;
            if (fs::is_character_file(path)) continue;
            if (!fs::is_regular_file(path)) return said.str() + "did not write " + path.string();
            auto const now = contents(path);
            if (same_bytes(name) ? now != text : now.empty() != text.empty()) return said.str() + "wrote something else as " + path.string();
        }
    if (f.report && !fs::is_character_file(folder_ / report)) {
        auto const text = contents(folder_ / report);
        if (!text.starts_with("{\n \"schema\"") || !text.ends_with("}\n")) return said.str() + "the report is not whole";
    }
    if (f.video && !fs::is_character_file(folder_ / video)) {
        auto const text = contents(folder_ / video);
        if (!text.starts_with("YUV4MPEG2 W16 H12 ") || text.size() != text.find('\n') + 1 + 2 * (6 + 3 * 16 * 12)) return said.str() + "the video is not whole";
    }
    for (auto const& [path, text] : after)
        if (!before.contains(path) && !written.contains(place(path))) return said.str() + "left " + path;
    return {};
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 3) return 2;
    auto const program = fs::absolute(argv[1]);
    auto const runs = std::strtoull(argv[2], nullptr, 10), first = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1u;
    std::string name = (fs::temp_directory_path() / "tilemesh_files_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) return 2;
    fs::path const work = fs::canonical(name);
    int failures = 0;
    try {
        // A new option with a file or a folder must be added to this test.
        fs::create_directory(work / "help");
        run(program, work / "help", {"--help"}, work / "stdout", false);
        std::istringstream help(contents(work / "stdout"));
        Words named;
        for (std::string line; std::getline(help, line);) {
            std::istringstream words(line);
            std::string option, value;
            words >> option >> value;
            if (line.starts_with("  --") && (value == "FILE" || value == "DIR")) named.push_back(option);
        }
        // Scenarios have all of them but --photos and --compare, which tables/render_map_photographs.txt tries, and --judge-scenes (render_map_cli.txt).
        if (named != Words{"--cameras", "--trajectory", "--photos", "--compare", "--judge-scenes", "--out", "--video", "--report", "--trace", "--cost-model", "--energy"}) {
            std::cerr << "FAILED: render_map has other options with files than this test knows\n";
            ++failures;
        }
        // The cost model that a trace writes can be read again.
        write(work / "help/map.ply", map_text());
        run(program, work / "help", {"map.ply", "--size", "16x12", "--grid", "2x2", "--quiet", "--out", "o", "--trace", "t"}, "/dev/null", false);
        fs::copy_file(work / "help/t/model.txt", work / "model.txt");

        std::map<Features, Outputs> known;
        std::uint64_t outcomes[3] = {};
        for (auto seed = first; seed < first + runs && failures < 10; ++seed) {
            Scenario scenario(program, work / "run", seed);
            auto const why = scenario.check(known);
            ++outcomes[static_cast<std::uint32_t>(scenario.outcome())];
            if (why.empty()) continue;
            std::cerr << "FAILED: seed " << seed << ": " << why << "\n";
            ++failures;
        }
        std::cout << "render_map_files: " << outcomes[1] << " runs refused, " << outcomes[2] << " done, " << outcomes[0] << " not run\n";
        if (runs >= 100 && (outcomes[1] < runs / 5 || outcomes[2] < runs / 5)) {
            std::cerr << "FAILED: nearly all runs end alike\n";
            ++failures;
        }
    } catch (std::exception const& error) {
        std::cerr << "FAILED: " << error.what() << "\n";
        ++failures;
    }
    fs::remove_all(work);
    return failures == 0 ? 0 : 1;
}
