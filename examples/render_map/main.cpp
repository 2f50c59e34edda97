// render_map: a 3D Gaussian map in, pictures and a report out. `render_map --help` lists the options.
#include "choice.hpp"
#include "options.hpp"
#include "png.hpp"
#include "shots.hpp"
#include "summary.hpp"
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <string>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/report/json.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/ply.hpp>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
using render_map::Options;
using report::thousands;

/// One line on standard error that is written over; nothing unless that is a terminal and somebody wants to see it.
class Progress {
public:
    explicit Progress(bool wanted) : shown_(wanted && isatty(STDERR_FILENO) == 1) {}
    ~Progress() { say(""); }
    Progress(Progress const&) = delete;
    Progress& operator=(Progress const&) = delete;

    void say(std::string const& text) const
    {
        if (shown_) std::cerr << "\r\033[K" << text << std::flush;
    }

private:
    bool shown_;
};

/// Sizes that would fill a host's memory before the library finds anything wrong with them. A tile that is in use takes some
/// pages of the host's memory, about 18 KB: 2^18 tiles are 5 GB. 2^26 pixels are 2 GB of picture, framebuffers and PNG.
void check_sizes(Options const& options, std::vector<render_map::Shot> const& shots)
{
    constexpr std::uint64_t most_tiles = 1u << 18, most_pixels = 1u << 26;
    auto const grid = options.renderer.grid, tile = options.renderer.tile;
    for (auto const& shot : shots) {
        auto const& camera = shot.camera;
        auto const pixels = std::uint64_t{camera.width} * camera.height;
        if (pixels > most_pixels)
            throw tilemesh::Error("a frame of " + std::to_string(camera.width) + " x " +
                                  std::to_string(camera.height) +
                                  " pixels is too large (at most " + thousands(most_pixels) +
                                  " pixels are rendered at once); choose another --size");
        auto tiles = std::uint64_t{grid.width} * grid.height;
        if (grid.width == 0 && tile.width != 0)
            tiles = std::uint64_t{(camera.width + tile.width - 1) / tile.width} *
                    ((camera.height + tile.height - 1) / tile.height);
        if (tiles > most_tiles)
            throw tilemesh::Error("a grid of " + thousands(tiles) +
                                  " tiles is too large (this program simulates at most " +
                                  thousands(most_tiles) +
                                  "); choose larger tiles or a smaller --grid");
    }
}

/// Makes the folder for the pictures and looks whether the report can go where it should: better now than after an hour.
std::filesystem::path prepare_outputs(Options const& options)
{
    auto const out = options.out.value_or("tilemesh_out");
    std::error_code refused;
    std::filesystem::create_directories(out, refused);
    if (refused || !std::filesystem::is_directory(out))
        throw tilemesh::Error("cannot write to " + out.string() + " (" +
                              (refused ? refused.message() : "it is no directory") +
                              "); name a writable directory with --out");
    if (options.report) {
        auto const folder = std::filesystem::absolute(*options.report).parent_path();
        if (std::filesystem::is_directory(*options.report) || !std::filesystem::is_directory(folder))
            throw tilemesh::Error("cannot write the report to " + options.report->string() +
                                  " (that is a directory, or is in none); name a file with --report");
    }
    return out;
}

std::string file_name(std::size_t frame, char const* extension)
{
    auto digits = std::to_string(frame);
    if (digits.size() < 4) digits.insert(0, 4 - digits.size(), '0');
    return "frame_" + digits + extension;
}

char const* to_string(splat::Footprint footprint)
{
    return footprint == splat::Footprint::opacity_box ? "opacity_box" : "three_sigma_square";
}

report::RunReport describe_run(Options const& options, scene::Map const& map)
{
    auto const setup = render_map::describe(options.choice);
    auto const limited = [](std::uint32_t asked, std::uint32_t own) { return asked != 0 ? asked : own; };
    report::RunReport run;
    run.map = {map.name, map.path, map.gaussians.size(), map.rejected, map.notes};
    run.machine = {setup.machine, setup.sram_bytes,
                   limited(options.renderer.storage_slots, setup.storage_slots),
                   limited(options.renderer.channel_slots, setup.channel_slots), setup.ledger};
    run.preset = setup.preset;
    run.engine =
        options.choice.engine == render_map::EngineKind::threads ? "threads" : "sequential";
    run.threads = options.renderer.threads;
    run.policies = {setup.routing,
                    setup.addressing,
                    setup.saturation,
                    to_string(options.renderer.footprint.value_or(setup.footprint)),
                    setup.copies,
                    setup.pixels,
                    "precise",
                    options.renderer.hops};
    return run;
}

// --- the run -----------------------------------------------------------------------------------

void run(Options const& options)
{
    Progress const progress(!options.quiet);
    progress.say("loading the map");
    auto const map = options.map.empty() ? scene::built_in_map() : scene::load_ply(options.map);
    auto const shots = render_map::make_shots(options, map);
    check_sizes(options, shots);
    auto const renderer = render_map::make_renderer(options.choice, map, options.renderer);
    auto const out = prepare_outputs(options);

    auto result = describe_run(options, map);
    result.frames.reserve(shots.size());
    for (std::size_t i = 0; i < shots.size(); ++i) {
        auto const& name = shots[i].name;
        auto const& camera = shots[i].camera;
        auto const say = [&](char const* what) {
            progress.say("frame " + std::to_string(i + 1) + " of " + std::to_string(shots.size()) +
                         ", " + name + ": " + what);
        };
        say("rendering");
        auto rendered = renderer->render(camera);
        report::RunFrame frame;
        frame.report = std::move(rendered.report);
        frame.report.camera = name;
        frame.grid = {renderer->grid().width, renderer->grid().height};
        frame.tile_px = {renderer->tile().width, renderer->tile().height};

        say("writing");
        frame.image = file_name(i, ".png");
        render_map::write_png(out / frame.image, rendered.image);
        if (options.pfm) report::write_pfm(out / file_name(i, ".pfm"), rendered.image);

        if (options.reference) {
            auto const error = [&](report::Cuts cuts) {
                return report::compare(rendered.image,
                                       report::render_double(map.gaussians, camera, renderer->model(),
                                                             cuts, options.renderer.threads));
            };
            say("reference without cut-offs");
            frame.error = error(report::Cuts::none);
            say("reference with the same cut-offs");
            frame.error_same_cuts = error(report::Cuts::same);
        }
        result.frames.push_back(std::move(frame));
    }
    progress.say("");
    if (options.report) report::write_json(*options.report, result);
    if (options.quiet) return;

    render_map::print_summary(std::cout, result);
    std::cout << "\nwrote " << (out / result.frames.front().image).string();
    if (result.frames.size() > 1) std::cout << " to " << result.frames.back().image;
    if (options.pfm) std::cout << ", and each as .pfm";
    if (options.report) std::cout << ", and " << options.report->string();
    std::cout << '\n';
}

/// Bad input ends in one line, whatever the names in it hold.
int refuse(std::string text)
{
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    std::cerr << text << std::endl;
    return 2;
}

} // namespace

int main(int argc, char** argv)
{
    try {
        auto const options = render_map::parse_options(
            {argv + std::min(argc, 1), static_cast<std::size_t>(std::max(argc - 1, 0))});
        if (options.help) {
            std::cout << render_map::help_text();
            return 0;
        }
        run(options);
        return 0;
    } catch (tilemesh::Error const& error) {
        return refuse(error.what());
    } catch (std::bad_alloc const&) {
        return refuse("not enough memory (an allocation failed); choose a smaller map, frame or grid");
    } catch (std::filesystem::filesystem_error const& error) {
        return refuse("cannot use " + error.path1().string() + " (" + error.code().message() +
                      "); check the path and its permissions");
    } catch (std::system_error const& error) {
        return refuse(std::string("the system refused a resource (") + error.what() +
                      "); choose fewer --threads or try again");
    } catch (std::exception const& error) {
        return refuse(std::string("render_map cannot go on (") + error.what() +
                      "); please report this with the command line");
    }
}
