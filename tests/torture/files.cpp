// Readers and writers that run out of memory.
#include "../compare_reports.hpp"
#include "../scene/map_writers.hpp"
#include "cloud.hpp"
#include "failing.hpp"
#include <tilemesh/renderer.hpp>
#include <tilemesh/model/assumed_parameters.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/trace_page.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/report/json.hpp>
#include <tilemesh/report/plot.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/report/run_report.hpp>
#include <tilemesh/report/string_stream.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <unistd.h>

namespace {

using namespace torture;
namespace fs = std::filesystem;

/// The value that a call returns. An Error is a result too: lack of memory must not be reported as a bad file.
class Value : public Act {
public:
    explicit Value(std::function<std::string()> make) : make_(std::move(make)) {}
    void act() override
    {
        try {
            text_ = make_();
        } catch (Error const& error) {
            text_ = error.what();
        }
    }
    std::string result() override { return text_; }

private:
    std::function<std::string()> make_;
    std::string text_;
};

std::string contents(fs::path const& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// A new folder, in which each file stays unchanged or is written whole.
class Files : public Act {
public:
    static constexpr char const* before = "as it was";

    Files(std::string old, std::function<void(fs::path const&)> write) : old_(std::move(old)), write_(std::move(write))
    {
        folder_ = fs::temp_directory_path() / ("tilemesh_torture_" + std::to_string(::getpid()));
        fs::create_directory(folder_);
        if (!old_.empty()) std::ofstream(folder_ / old_) << before;
    }
    ~Files() override { fs::remove_all(folder_); }
    void act() override { write_(folder_); }
    std::string result() override
    {
        std::string all;
        for (auto const& [name, text] : files()) all += name + "\n" + text;
        return all;
    }
    std::string after_failure(std::string const& right) override
    {
        auto const now = files();
        if (!old_.empty() && now.find(old_) == now.end()) return old_ + " is lost";
        try {
            if (auto const harm = Act::after_failure(right); !harm.empty()) return harm;
        } catch (Error const& error) {
            return error.what();
        }
        auto const right_files = files();
        for (auto const& [name, text] : now) {
            auto const found = right_files.find(name);
            bool const as_before = name == old_ && text == before, whole = found != right_files.end() && found->second == text;
            if (!as_before && !whole) return "a part of " + name + " is left";
        }
        return {};
    }

private:
    /// By name.
    std::map<std::string, std::string> files() const
    {
        std::map<std::string, std::string> all;
        for (auto const& entry : fs::directory_iterator(folder_)) all[entry.path().filename().string()] = contents(entry.path());
        return all;
    }
    fs::path folder_;
    std::string old_; ///< the file that existed before; empty: none
    std::function<void(fs::path const&)> write_;
};

std::string text_of(scene::Map const& map)
{
    auto const bytes = [](auto const& v) { return std::string(reinterpret_cast<char const*>(v.data()), v.size() * sizeof v[0]); };
    auto out = map.name + bytes(map.gaussians) + bytes(map.harmonics) + std::to_string(map.rejected);
    for (auto const& note : map.notes) out += "\n" + note;
    return out;
}
std::string text_of(std::vector<scene::NamedCamera> const& cameras)
{
    std::string out;
    for (auto const& c : cameras) out.append(c.scene).append(c.name).append(reinterpret_cast<char const*>(&c.camera), sizeof c.camera);
    return out;
}
std::string text_of(scene::Trajectory const& trajectory)
{
    std::string out;
    for (auto const& note : scene::trajectory_notes(trajectory)) out += note + "\n";
    for (auto const& stamped : trajectory) out.append(reinterpret_cast<char const*>(&stamped), sizeof stamped);
    return out;
}

report::RunReport run_report()
{
    Renderer renderer(cloud(), options());
    report::RunReport run;
    run.map.name = "cloud";
    run.machine.ledger = render::ledger_of(renderer.setup());
    run.notes = {"a note that is longer than a short string"};
    for (auto const& camera : views()) {
        report::RunFrame frame;
        frame.report = renderer.render(camera).report;
        frame.report.host_ms = {};
        run.frames.push_back(std::move(frame));
    }
    return run;
}

Case value(std::string name, std::function<std::string()> make)
{
    return {std::move(name), [make = std::move(make)] { return std::make_unique<Value>(make); }};
}
Case files(std::string name, std::string old, std::function<void(fs::path const&)> write)
{
    return {std::move(name), [old = std::move(old), write = std::move(write)] { return std::make_unique<Files>(old, write); }};
}

/// A case for each file of the fuzzers' corpus in that folder.
std::vector<Case> seeds(std::string const& kind, std::string const& extension, std::string (*read)(fs::path const&))
{
    auto const folder = fs::path(__FILE__).parent_path() / ".." / "fuzz" / "corpus" / kind;
    std::vector<fs::path> paths;
    if (fs::is_directory(folder))
        for (auto const& entry : fs::directory_iterator(folder))
            if (extension.empty() || entry.path().extension() == extension) paths.push_back(entry.path());
    REQUIRE_MESSAGE(!paths.empty(), "there is no corpus in ", folder.string());
    std::sort(paths.begin(), paths.end());
    std::vector<Case> all;
    for (auto const& path : paths) all.push_back(value("load " + kind + "/" + path.filename().string(), [path, read] { return read(path); }));
    return all;
}

} // namespace

TEST_SUITE_BEGIN("torture");

TEST_CASE("a map without memory")
{
    torture::torture(seeds("ply", ".ply", [](fs::path const& path) { return text_of(scene::load_ply(path)); }));
}

TEST_CASE("a compressed map without memory")
{
    torture::torture(seeds("maps", "", [](fs::path const& path) { return text_of(scene::load_map(path, scene_test::plain_codecs<false>())); }));

    fs::path const folder = fs::temp_directory_path() / ("tilemesh_torture_sog_" + std::to_string(::getpid()));
    fs::create_directory(folder);
    scene_test::Numbers numbers(1);
    for (auto const& [name, content] : scene_test::PackedSog::random(3, 2, 1, numbers).files({})) std::ofstream(folder / name, std::ios::binary) << content;
    torture::torture({value("load a folder of SOG", [&] { return text_of(scene::load_map(folder, scene_test::plain_codecs())); }),
                      value("two maps, turned", [&] {
                          auto const map = scene::load_map(folder, scene_test::plain_codecs());
                          return text_of(scene::turned(scene::join_maps({map, map}), scene::Turn::y90));
                      })});
    fs::remove_all(folder);
}

TEST_CASE("a camera file without memory")
{
    torture::torture(seeds("cameras", ".json", [](fs::path const& path) { return text_of(scene::load_cameras(path)); }));
}

TEST_CASE("a trajectory without memory")
{
    torture::torture(seeds("trajectory", "", [](fs::path const& path) { return text_of(scene::load_trajectory(path)); }));
}

TEST_CASE("a COLMAP model without memory")
{
    // A seed of a binary model is: B, the length of cameras.bin in a byte, cameras.bin, images.bin.
    torture::torture(seeds("cameras", ".bin", [](fs::path const& path) {
        auto const bytes = contents(path);
        std::size_t const length = static_cast<unsigned char>(bytes.at(1));
        std::istringstream cameras(bytes.substr(2, length)), images(bytes.substr(std::min(2 + length, bytes.size())));
        return text_of(scene::read_colmap_binary(cameras, images));
    }));
}

TEST_CASE("texts without memory are not cut short, and files of text are read")
{
    torture::torture({value("load COLMAP model",
                            [] {
                                std::istringstream cameras("1 PINHOLE 64 48 50 50 32 24\n");
                                std::istringstream images("1 1 0 0 0 0 0 0 1 a picture with a longer name.png\n\n");
                                return text_of(scene::read_colmap(cameras, images));
                            }),
                      value("a text",
                            [] {
                                report::StringStream text;
                                for (int i = 0; i < 300; ++i) text << "piece " << i << ' ' << 0.5 * i << '\n';
                                return text.str();
                            }),
                      value("write and load cost model", [] {
                          report::StringStream text, again;
                          write_cost_model(text, mk2());
                          std::istringstream in(text.str());
                          write_cost_model(again, read_cost_model(in, "model.txt"));
                          return again.str();
                      })});
}

TEST_CASE("a run without memory, from the demand to the error")
{
    torture::torture({value("fit, render", [] { return std::to_string(Renderer(cloud(), options()).render(views()[0]).report.pairs); }),
                      value("reference, 2 threads, and its error",
                            [] {
                                Renderer renderer(cloud(), options());
                                auto const frame = renderer.render(views()[0]);
                                auto const reference =
                                    report::render_double(std::span(cloud().gaussians), views()[0], splat::Rules{}, report::Cuts::same, 2);
                                return std::to_string(report::compare(frame.image, reference).psnr_db);
                            }),
                      value("a mesh that is not quiet explains itself", [] {
                          auto o = options();
                          o.most_passes = 1;
                          return std::to_string(WatchedRenderer(cloud(), o).render(views()[0]).report.pairs);
                      })});
}

TEST_CASE("files without memory are whole, or as they were")
{
    static auto const picture = Renderer(cloud(), options()).render(views()[0]).image;
    static auto const run = run_report();
    torture::torture({files("write pfm", "a", [](auto const& folder) { report::write_pfm(folder / "a", picture); }),
                      files("write ppm", "", [](auto const& folder) { report::write_ppm(folder / "a", picture); }),
                      files("read pfm", "",
                            [](auto const& folder) {
                                report::write_pfm(folder / "a", picture);
                                report::write_pfm(folder / "b", report::read_pfm(folder / "a"));
                            }),
                      files("write report.json", "a", [](auto const& folder) { report::write_json(folder / "a", run); }),
                      files("write svg", "a",
                            [](auto const& folder) {
                                report::Plot plot;
                                plot.title = "A plot whose title is longer than a short string";
                                plot.series = {{"a series", {{1, 2}, {3, 4}}}};
                                report::write_svg(folder / "a", plot);
                            }),
                      files("render and write a trace", "", [](auto const& folder) {
                          WatchedRenderer renderer(cloud(), options());
                          (void)renderer.render(views()[0]);
                          write_trace_page(folder, "a", renderer.trace(), mk2(), renderer.mesh().grid());
                      })});
}
