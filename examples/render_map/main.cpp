// render_map: a 3D Gaussian map in, pictures and a report out. `render_map --help` lists the options.
#include "../shared/near_note.hpp"
#include "../shared/output_files.hpp"
#include "../shared/process.hpp"
#include "../shared/text.hpp"
#include "bound.hpp"
#include "certify.hpp"
#include "choice.hpp"
#include "explain.hpp"
#include "frame_writer.hpp"
#include "instruments.hpp"
#include "journal.hpp"
#include "judge_scenes.hpp"
#include "limits.hpp"
#include "options.hpp"
#include "outputs.hpp"
#include "photographs.hpp"
#include "progress.hpp"
#include "ranks.hpp"
#include "reference.hpp"
#include "shots.hpp"
#include "summary.hpp"
#include "trace_output.hpp"
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/describe.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/run_report.hpp>
#include <tilemesh/report/string_stream.hpp>
#include <tilemesh/report/table.hpp>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
using render_map::Options;
using render_map::Progress;
using report::thousands;

report::RunReport describe_run(Options const& options, scene::Map const& map, std::uint64_t gaussians, tilemesh::Renderer& renderer)
{
    report::RunReport run;
    run.map = {map.name, map.path, gaussians, map.rejected, map.notes};
    run.engine =
        render_map::ranks::number() > 1                            ? "mpi"
        : options.choice.engine == render_map::EngineKind::threads ? "threads"
                                                                   : "sequential";
    run.ranks = render_map::ranks::number();
    tilemesh::render::describe(run, renderer.setup(), renderer.rules(), options.renderer);
    return run;
}

/// Describes the machine as the program of homes divides it, from the size of the first frame that homes rendered. Notes where `auto` changed
/// to homes. It uses the frames' reports alone, so that a run which takes over frames describes itself as an uninterrupted run.
void describe_homes(Options const& options, render_map::Needs const& needs, tilemesh::Renderer& renderer, report::RunReport& run)
{
    auto const first = std::find_if(run.frames.begin(), run.frames.end(),
                                    [](auto const& frame) { return frame.report.program == report::Program::homes; });
    if (first == run.frames.end()) return;
    auto const choice = render_map::homes_of(options.choice, renderer.setup().sh_degree);
    auto const layout = tilemesh::render::layout_homes(choice, options.renderer, {first->report.width, first->report.height},
                                                       run.map.gaussians - needs.used.culled);
    tilemesh::render::describe(run, layout.setup, renderer.rules(), options.renderer);
    if (run.program != report::Program::automatic) return;
    auto const anchored = tilemesh::render::checked(setup_for(options.choice, needs.used));
    bool const room = tilemesh::render::may_fit_anchored(0, anchored, options.renderer).frame({first->report.width, first->report.height});
    run.notes.push_back("from " + first->image + " on, the program of homes renders (" +
                        (room ? "on anchored tiles, records or copies would be missing)" : "anchored tiles have no room for its pixels)"));
}

/// ": row 3 ...", the reader's note on the first row that it rejects; empty if there is none.
std::string first_rejected(scene::Map const& map)
{
    auto const note = std::find_if(map.notes.begin(), map.notes.end(), [](auto const& text) { return text.starts_with("row "); });
    return note == map.notes.end() ? std::string() : ": " + *note;
}

/// Refuses an empty map, because it has no picture. Its header does not matter.
void require_gaussians(scene::Map const& map, std::uint64_t gaussians)
{
    if (gaussians != 0) return;
    auto const why = (map.rejected == 0 ? std::string("it has no rows") : "all of its " + thousands(map.rejected) + " rows are rejected") +
                     first_rejected(map);
    throw tilemesh::Error(map.path + " has no Gaussian to render (" + why + "); name another map, or export it again");
}

// --- the run -----------------------------------------------------------------------------------

/// "frame_0000.png", or "frame_0000.png to frame_0059.png, and each as .pfm and .depth.pfm".
std::string written_files(Options const& options, report::RunReport const& run)
{
    auto text = run.frames.front().image;
    if (run.frames.size() > 1) text += " to " + run.frames.back().image;
    std::string separator = run.frames.size() > 1 ? ", and each as " : ", and as ";
    auto const extensions = render_map::picture_extensions(options);
    for (std::size_t i = 1; i < extensions.size(); ++i) {
        text.append(separator).append(extensions[i]);
        separator = " and ";
    }
    if (options.report) text += ", and " + options.report->string();
    return text;
}

/// Refuses to follow a Gaussian that is not in the map.
void require_followed(Options const& options, scene::Map const& map)
{
    if (!options.follow) return;
    splat::GaussianId const id{*options.follow};
    if (std::any_of(map.gaussians.begin(), map.gaussians.end(), [id](auto const& g) { return g.id == id; })) return;
    auto const rows = map.gaussians.size() + map.rejected;
    throw tilemesh::Error("--follow cannot be " + std::to_string(*options.follow) + " (map " + map.name + " has " +
                          thousands(rows) + (rows == 1 ? " row" : " rows") + (*options.follow <= rows ? ", and that one is rejected" : "") +
                          "); name 1 + the row of a Gaussian");
}

/// If a mesh is not quiet after --most-passes and keeps a trace, further lines of its error say what it repeats. These lines go into a
/// file, and the error that is thrown instead names the file.
tilemesh::RenderedFrame render(tilemesh::Renderer& renderer, render_map::Instruments* instruments, splat::Camera const& camera,
                               render_map::TraceOutput const* trace)
{
    try {
        return instruments ? instruments->render(camera) : renderer.render(camera);
    } catch (tilemesh::Error const& error) {
        std::string const text = error.what();
        auto const first_line = text.find('\n');
        if (!trace || first_line == std::string::npos) throw;
        throw tilemesh::Error(text.substr(0, first_line) + " in " + trace->write_no_progress(text));
    }
}

/// Compares a frame with the double reference, without cut-offs and with those of the renderer.
void compare_with_references(Options const& options, scene::Map const& map, splat::Camera const& camera, splat::Rules const& rules,
                             Progress const& progress, render_map::Frame& frame)
{
    auto const error = [&](report::Cuts cuts) {
        return report::compare(frame.rendered.image, render_map::reference_of(map, camera, rules, cuts, options.renderer.threads, options.choice.exact_rays));
    };
    progress.say_frame("reference 1 of 2");
    frame.entry.error = error(report::Cuts::none);
    progress.say_frame("reference 2 of 2");
    frame.entry.error_same_cuts = error(report::Cuts::same);
}

/// Renders and writes every frame until an interrupt, and adds it to `result`. It takes over the frames that the journal has. While a frame
/// is rendered, `writer` writes the frames before; their errors come first.
void render_frames(Options const& options, scene::Map const& map, std::vector<render_map::Shot> const& shots, render_map::FrameWriter& writer,
                   tilemesh::Renderer& renderer, render_map::TraceOutput* trace, render_map::Journal* journal, Progress& progress,
                   std::optional<render_map::OtherPicture> const& other, report::RunReport& result)
{
    std::optional<render_map::Instruments> watching;
    auto* const instruments = trace ? &watching.emplace(renderer) : nullptr;
    if (instruments && options.follow) instruments->follow(splat::GaussianId{*options.follow});
    auto const add = [&](render_map::Frame frame) {
        if (journal) journal->add(frame.index, frame.entry, frame.files);
        result.frames.push_back(std::move(frame.entry));
    };
    auto const finish_one = [&] {
        progress.say_frame("writing");
        add(writer.finish().value());
    };
    auto const finish_writing = [&] {
        while (writer.is_writing()) finish_one();
    };
    auto const before_its_error = [&](auto const& step) {
        try {
            return step();
        } catch (...) {
            finish_writing();
            throw;
        }
    };
    render_map::BoundRenderer bounds;
    using Way = render_map::Journal::Way;
    auto const with_pixels = journal ? render_map::needs_pixels(shots, renderer.rules(), *journal) : std::vector<bool>();
    for (std::size_t i = 0; i < shots.size() && shared::interrupt() == 0; ++i) {
        auto const& camera = shots[i].camera;
        progress.begin_frame(shots[i].name, shots.size());
        if (auto const way = journal ? journal->way(i) : Way::render; way != Way::render) {
            progress.say_frame("replaying");
            if (way == Way::replay)
                before_its_error([&] { render_map::replay(renderer, camera, with_pixels[i] || journal->program(i) == report::Program::homes); });
            finish_writing();
            result.frames.push_back(journal->take(i));
            continue;
        }
        progress.say_frame("rendering");
        render_map::Frame frame{i, before_its_error([&] { return render(renderer, instruments, camera, trace); }), {}};
        frame.entry.report = std::move(frame.rendered.report);
        frame.entry.report.camera = shots[i].name;
        frame.entry.timestamp_s = shots[i].timestamp_s;
        frame.entry.view.emplace(camera, map.origin);
        frame.entry.grid = {renderer.grid().width, renderer.grid().height};
        frame.entry.tile_px = {renderer.tile().width, renderer.tile().height};
        while (writer.is_full(frame)) finish_one();
        writer.start(std::move(frame), shots[i]);
        if (!trace && !options.reference && !options.certify && !options.bound) continue;

        // A trace describes the mesh as this frame left it, and a reference and an enclosure take all threads: the next frame waits for them.
        progress.say_frame("writing");
        frame = writer.finish().value();
        if (trace && instruments) frame.entry.modelled = trace->add_frame(i, frame.entry, frame.rendered.image, *instruments);
        if (options.reference && shared::interrupt() != 0) { // two references take longer than the rest of the frame
            result.frames.push_back(std::move(frame.entry));    // and the journal has no frame without them
            break;
        }
        if (options.reference) compare_with_references(options, map, camera, renderer.rules(), progress, frame);
        if (options.bound && shared::interrupt() == 0) {
            progress.say_frame("bounding");
            if (!bounds) bounds = render_map::make_bound_renderer(map, options.renderer.threads);
            result.notes.push_back(render_map::bound(options, bounds, camera, renderer.rules(), shots.size(), frame));
        }
        if (options.certify && shared::interrupt() == 0) {
            progress.say_frame("certifying");
            result.notes.push_back(render_map::certify(options, map, camera, renderer.rules(), shots.size(), frame, other));
        }
        add(std::move(frame));
    }
    finish_writing();
}

/// Adds to the report what its pictures lack, and what would help. Returns both in one line; empty if nothing is missing. First describes
/// the program of homes, if it rendered.
std::string note_missing(Options const& options, render_map::Needs const& needs, tilemesh::Renderer& renderer, report::RunReport& run)
{
    describe_homes(options, needs, renderer, run);
    if (auto note = render_map::free_sram(options, run); !note.empty() && !run.frames.empty()) run.notes.push_back(std::move(note));
    if (!renderer.change_refused().empty()) run.notes.push_back("the program of homes cannot take over: " + renderer.change_refused());
    auto const text = render_map::missing_text(run);
    if (text.empty()) return text;
    run.notes.push_back(text);
    run.advice = render_map::advice(options, needs, run);
    return text + "; " + run.advice;
}

/// The whole run. Returns the exit status.
int run(Options options)
{
    Progress progress(!options.quiet);
    render_map::load_machine(options);
    std::optional<render_map::TraceOutput> trace;
    if (options.trace) trace.emplace(options);
    progress.say("loading the map");
    // Over several processes, each has its part of the rows, and `map` has none.
    bool const in_parts = render_map::ranks::number() > 1;
    shared::MapInput whole; // a part is turned and reduced later
    whole.antialias = options.antialias;
    auto map = in_parts ? render_map::ranks::parts().load(options, [&] { return shared::load_maps(options.maps, whole); })
                        : shared::load_maps(options.maps, options);
    auto const gaussians = in_parts ? render_map::ranks::parts().gaussians() : map.gaussians.size();
    require_gaussians(map, gaussians);
    require_followed(options, map);
    std::vector<std::string> notes;
    auto const file_degree = map.sh_degree;
    if (in_parts && options.sh_degree < map.sh_degree) render_map::ranks::parts().at_degree(options.sh_degree);
    map = shared::at_degree(std::move(map), options, notes);
    auto shape = in_parts ? render_map::ranks::parts().shape_of(map.name) : shared::shape_of(map);
    shape.origin = map.origin;
    std::vector<std::filesystem::path> sized_by;
    std::vector<std::string> names;
    auto shots = render_map::make_shots(options, shape, notes, sized_by, names);
    render_map::find_photographs(options, names, shots, notes);
    options.choice.machine = render_map::machine_for(options, shots, notes);
    render_map::fit_machine(options, shots, gaussians, map.sh_degree, notes);
    render_map::check_sizes(options, shots);
    std::vector<splat::Camera> path;
    for (auto const& shot : shots) path.push_back(shot.camera);
    progress.say("looking what the scene needs");
    auto const needs = render_map::needs_of(options, map, path);
    if (needs.seen.culled == gaussians)
        notes.push_back("nothing of the map is on screen in any view: check the camera, or the trajectory's frame (--relative)");
    if (needs.seen.nearer != 0) notes.push_back(shared::near_note(needs.seen.nearer, path));
    render_map::check_slots(options, needs);
    render_map::check_homes(options, needs, shots);
    auto const renderer = render_map::make_renderer(options.choice, map, needs.used, options.renderer);
    auto result = describe_run(options, map, gaussians, *renderer);
    result.notes = notes;
    result.features = render_map::features(options, needs, map, file_degree, *renderer);
    auto const read = render_map::files_read(options, shots, sized_by);
    auto const out = render_map::prepare_outputs(options, shots, read);
    auto const other = render_map::read_other(options, shots);
    auto video = render_map::open_video(options, shots);

    std::optional<render_map::Journal> journal;
    if (options.resume) {
        progress.say("looking for finished frames");
        result.made_from = render_map::made_from(options, read);
        journal.emplace(out, result.made_from, shots.size(), [&](std::size_t frame) { return render_map::picture_files(options, frame); });
        if (!journal->damage().empty()) std::cerr << journal->damage() << std::endl;
    }

    if (in_parts && (options.reference || options.certify)) { // both read the whole map
        std::vector<std::string> said;
        map = shared::at_degree(shared::load_maps(options.maps, options), options, said);
    }
    auto* const tracing = trace ? &*trace : nullptr;
    try {
        render_map::FrameWriter writer(options, other, video.get());
        render_frames(options, map, shots, writer, *renderer, tracing, journal ? &*journal : nullptr, progress, other, result);
        if (video && !result.frames.empty()) video->finish();
    } catch (std::exception const& error) {
        video.reset(); // it is not complete, so its file goes
        // The finished frames are written; their report must not be lost because another frame failed.
        if ((options.report || trace) && !result.frames.empty()) {
            try {
                note_missing(options, needs, *renderer, result);
                result.notes.push_back("stopped after frame " + std::to_string(result.frames.size()) + " of " +
                                       std::to_string(shots.size()) + ": " +
                                       (dynamic_cast<std::bad_alloc const*>(&error) != nullptr ? "not enough memory" : error.what()));
                if (options.report) render_map::write_report(options, result);
                if (trace) trace->finish(result);
            } catch (std::exception const&) { // the first error is the one to report
            }
        }
        throw;
    }
    progress.say("");

    std::string stopped;
    if (auto const signal = shared::interrupt()) {
        auto const of = std::to_string(shots.size()) + " (" + shared::signal_name(signal) + ")";
        stopped = result.frames.empty() ? "interrupted before frame 1 of " + of + "; no picture is written, start again"
                                        : "interrupted after frame " + std::to_string(result.frames.size()) + " of " + of +
                                              "; the frames written are whole, " +
                                              (options.resume ? "the same command goes on" : "start again for the rest");
        result.notes.push_back(stopped.substr(0, stopped.find(';')));
    }
    auto const missing = note_missing(options, needs, *renderer, result);
    if (options.report) render_map::write_report(options, result);
    if (trace && !result.frames.empty()) trace->finish(result);
    if (options.quiet && map.rejected != 0) // otherwise the summary says it
        std::cerr << shared::one_line("map " + map.name + " lacks " + thousands(map.rejected) + " of its " +
                                          thousands(gaussians + map.rejected) + " rows, which are rejected" + first_rejected(map))
                  << std::endl;
    if (!missing.empty()) std::cerr << shared::one_line(missing) << std::endl;
    auto const not_compared = render_map::photograph_problems(result);
    for (auto const& problem : not_compared) std::cerr << problem << std::endl;
    if (!stopped.empty()) {
        std::cerr << stopped << std::endl;
        return 128 + shared::interrupt();
    }
    int const status = (options.strict && !missing.empty()) || !not_compared.empty() ? 1 : 0;
    report::StringStream summary;
    if (options.explain) render_map::explain(summary, result);
    if (options.quiet) {
        shared::print(summary.str(), "the pictures are written; leave out --explain", render_map::text_stream(options));
        return status;
    }
    render_map::print_summary(summary, result);
    if (trace) summary << '\n' << trace->summary();
    summary << "\nwrote " << shared::one_line((out / written_files(options, result)).string()) << '\n';
    if (journal && journal->taken_over() != 0)
        summary << thousands(journal->taken_over()) << " of " << thousands(shots.size()) << " frames were there from an earlier run\n";
    if (trace)
        summary << "wrote " << shared::one_line((*options.trace / "report.html").string()) << ", and the trace beside it\n";
    if (options.video) summary << "wrote " << render_map::video_text(options, result.frames.size()) << '\n';
    shared::print(summary.str(), "the pictures are written; --quiet leaves the summary out", render_map::text_stream(options));
    return status;
}

/// Does what the arguments ask for. Returns the exit status.
int run_arguments(int argc, char** argv)
{
    auto const options = render_map::parse_options({argv + std::min(argc, 1), static_cast<std::size_t>(std::max(argc - 1, 0))});
    constexpr char const* room = "send it to a file or a terminal with room";
    if (options.help || options.version) {
        shared::print(options.help ? render_map::help_text() : render_map::version_text(), room, std::cout);
        return 0;
    }
    if (options.list) {
        shared::print(shared::camera_names(options), room, std::cout);
        return 0;
    }
    if (options.judge_scenes) {
        if (!options.maps.empty())
            throw tilemesh::Error("--judge-scenes and map " + shared::one_line(options.maps.front().string()) +
                                  " are both given (the scenes have maps of their own); leave the map out, and judge a picture of it with --certify --compare");
        shared::print(render_map::write_judge_scenes(options), room, std::cout);
        return 0;
    }
    shared::note_interrupts(!options.quiet && isatty(STDERR_FILENO) == 1);
    return run(options);
}

} // namespace

int main(int argc, char** argv)
{
    shared::make_outputs_fail_softly(); // in all processes, before MPI begins
    shared::end_softly_without_memory();
    if (auto const status = render_map::ranks::begin(argc, argv)) return *status;
    return render_map::ranks::end(shared::run_softly("render_map", [&] { return run_arguments(argc, argv); }));
}
