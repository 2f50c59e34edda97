#include "options.hpp"
#include "../shared/input_rows.hpp"
#include "ranks.hpp"
#include <algorithm>
#include <string_view>
#include <thread>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>

namespace render_map {

namespace {

using namespace shared;
using tilemesh::Error;
using tilemesh::RendererOptions;
using tilemesh::render::setup_field, tilemesh::render::setup_fields;

/// "30", or "30000/1001".
void set_frame_rate(Options& o, OptionValue const& given)
{
    constexpr std::uint32_t most = 1'000'000; // the rate of any camera; players read both numbers into 32 bits
    auto const text = given.text;
    auto const slash = std::min(text.find('/'), text.size());
    auto const number = [&](std::string_view digits) -> std::uint32_t {
        auto const value = tilemesh::number_of<std::uint32_t>(digits).value_or(0);
        return value <= most ? value : 0;
    };
    o.fps = {number(text.substr(0, slash)), slash == text.size() ? 1 : number(text.substr(slash + 1))};
    if (o.fps.frames == 0 || o.fps.seconds == 0) throw Misfit{"it takes N or N/D, whole numbers from 1 to 1000000"};
}

constexpr Option<Options> picture_rows[] = {
    input<&Options::compare>("compare", "FILE", "compare with another renderer's picture, PFM or PNG"),
    option<&Options::error_picture>("error-picture", "", "also write frame_0000.error.png: where --photos or --compare differ"),
    option<&Options::reference>("reference", "", "compare with double precision, with and without cut-offs (slow)"),
    option<&Options::certify>("certify", "", "prove how far each picture is from the exact formula; with --float, also write the bounds"),
    option<&Options::bound>("bound", "", "bound each pixel's error on the tiles, too: frame_0000.bound.pfm (a second mesh)"),
    option<&Options::choice, &Choice::exact_rays>("exact-rays", "", "draw Gaussians by exact rays, not as conics: those that are large and near, panoramas"),
    option<&Options::judge_scenes>("judge-scenes", "DIR", "write 12 small maps with bounding pictures, to judge other renderers; nothing else")};

constexpr Word fits[] = {{"scene", true}, {"off", false}};

void set_machine(Options& o, OptionValue const& given)
{
    auto const text = given.text;
    o.machine_named = true;
    if (text.find_first_of("./") != text.npos) { // a name has neither
        o.machine = text;
        o.choice.machine = MachineKind::file;
    } else if (auto const machine = setup_fields[setup_field("machine")].values.read(text)) {
        o.choice.machine = static_cast<MachineKind>(static_cast<std::uint32_t>(*machine));
    } else {
        throw Misfit{"there are mk2, test and files"};
    }
}

constexpr Option<Options> setup_rows[] = {
    listed<setup_field("preset"), &Options::choice, &Choice::fields>("lossless"),
    field<setup_field("program"), &Options::renderer, &RendererOptions::program>("NAME", "auto"),
    {{"machine", "NAME|FILE", "mk2 | test (64 MiB per tile) | a file (see below)", Form::text, 0, 0, {}, {}, "test", {}, "mk2 if it has room"},
     set_machine},
    option<&Options::renderer, &RendererOptions::grid>("grid", "WxH", "number of tiles [40x36, or as many as --size and --tile need]", {1, 65535},
                                                       {}, "40x36"),
    option<&Options::renderer, &RendererOptions::tile>("tile", "WxH", "pixels per tile [the frame spread evenly over the grid]", {1, 65535}, {},
                                                       "32x20"),
    field<setup_field("channel-slots"), &Options::channel_slots>("N", "the preset's slots", "limit each channel to N records"),
    field<setup_field("storage-slots"), &Options::storage_slots>("N", "the preset's slots", "limit the storage of each tile to N records"),
    field<setup_field("footprint"), &Options::renderer, &RendererOptions::footprint>("NAME", "the preset's", "{}"),
    field<setup_field("arithmetic"), &Options::renderer, &RendererOptions::arithmetic>("NAME", "fast"),
    field<setup_field("quality"), &Options::renderer, &RendererOptions::quality>("NAME", "the preset's", "see below: {}", 1),
    words<&Options::choice, &Choice::fit>("fit", "NAME", "scene (leave out features that the scene does not need) | off [scene]", fits)};
constexpr auto renderer_rows = rows_of_renderer<&Options::renderer>();
constexpr auto policy_rows = rows_of_everyone([](auto field) { return listed<field(), &Options::choice, &Choice::fields>("the preset's"); });

constexpr Word engines[] = {{"threads", EngineKind::threads}, {"sequential", EngineKind::sequential}};
constexpr Option<Options> engine_rows[] = {
    words<&Options::choice, &Choice::engine>("engine", "NAME", "threads | sequential (slower, checks every write) [threads]", engines)};

constexpr Option<Options> output_rows[] = {
    option<&Options::out>("out", "DIR", "folder for frame_0000.png, frame_0001.png, ... [tilemesh_out]"),
    option<&Options::pfm>("float", "", "also write frame_0000.pfm: linear float32, unclamped"),
    option<&Options::choice, &Choice::depth>("depth", "", "also write frame_0000.depth.pfm: depth along z in world units; 0: nothing"),
    option<&Options::choice, &Choice::alpha>("alpha", "", "also write frame_0000.alpha.pfm: covered share of each pixel, 0 to 1"),
    option<&Options::video>("video", "FILE", "also write a raw video, which players and encoders read; -: standard output"),
    {{"fps", "N", "frames per second of the video, as 30 or 30000/1001 [30]", Form::text, 0, 0, {}, {}, "30000/1001"}, set_frame_rate},
    option<&Options::report>("report", "FILE", "write all counters as JSON"),
    option<&Options::trace>("trace", "DIR", "write what each tile did, and modelled cycles: HTML, CSV, JSON"),
    option<&Options::trace_tiles>("trace-tiles", "", "also write .tiles.csv of a frame with more than 200,000 lines (10 MB)"),
    input<&Options::cost_model>("cost-model", "FILE", "cost model for the trace, a text file like DIR/model.txt [--machine's]"),
    input<&Options::energy>("energy", "FILE", "energy model for the trace: joules and source of each event (see below)"),
    option<&Options::follow>("follow", "ID", "write the life of one Gaussian (ID: 1 + its row) to DIR/follow_ID.csv", {1, any_number}),
    option<&Options::explain>("explain", "", "print the features that this map and these cameras do not need, and why"),
    option<&Options::resume>("resume", "", "list finished frames in --out; after a kill or a crash, render the rest"),
    option<&Options::strict>("strict", "", "end with status 1 if a picture lacks something"),
    option<&Options::version>("version", "", "print the version")};

constexpr Pairing pairings[] = {
    {Pairing::needs, "orbit", "frames", "an orbit has as many frames as you ask for"},
    {Pairing::excludes, "photos", "orbit", "nobody photographed the views of a moved camera"},
    {Pairing::excludes, "photos", "trajectory", "nobody photographed the views of a moved camera"},
    {Pairing::excludes, "photos", "compare", "a frame is compared with one picture"},
    {Pairing::excludes, "photos", "size", "a photograph has the size of its camera, divided by --scale"},
    {Pairing::needs, "fps", "video", "it is the rate of a video"},
    {Pairing::needs, "trace-tiles", "trace", "it is a table of a trace"},
    {Pairing::needs, "cost-model", "trace", "cycles are modelled from a trace"},
    {Pairing::needs, "energy", "trace", "energy is counted from a trace"},
    {Pairing::needs, "follow", "trace", "what is followed is written beside a trace"},
    {Pairing::excludes, "exact-rays", "bound", "the bound is that of conics"},
    {Pairing::needs, "rolling-shutter", "trajectory", "it says how the camera moves"},
    {Pairing::excludes, "rolling-shutter", "exact-rays", "its rays start from one place"},
    {Pairing::excludes, "rolling-shutter", "bound", "it bounds the projection of a camera at rest"},
    {Pairing::excludes, "rolling-shutter", "certify", "it encloses the projection of a camera at rest"},
    {Pairing::excludes, "exact-rays", "certify", "what is enclosed are conics"},
    {Pairing::excludes, "exact-rays", "trace", "its mesh keeps no trace"},
    {Pairing::excludes, "exact-rays", "preset", "it is a program with sizes of its own"},
    {Pairing::excludes, "exact-rays", "program", "its program is anchored"},
    {Pairing::excludes, "exact-rays", "footprint", "its footprint is the exact one"},
    {Pairing::excludes, "resume", "bound", "an earlier run has no bounds"},
    {Pairing::excludes, "resume", "certify", "an earlier run has no pictures of full precision to certify"},
    {Pairing::excludes, "resume", "trace", "the report of a trace needs every tile of every frame"},
    {Pairing::excludes, "resume", "video", "the video would lack the frames that an earlier run wrote"}};

/// Options that change no picture and no counter. They may differ in a run that resumes another.
constexpr std::string_view beside_frames[] = {"threads", "out", "report", "resume", "explain", "quiet", "strict"};

/// An option that only the anchored program has, and why homes do not have it; empty: there is none.
struct OnlyAnchoredOption {
    std::string option, why, remedy;
};
OnlyAnchoredOption only_anchored(Options const& o)
{
    auto const setup = setup_of(o.choice, 0);
    if (auto const only = tilemesh::render::only_anchored(setup, o.renderer); only) {
        std::string const field(only.field), value(only.value);
        bool const of_preset = !value.empty() && !o.choice.names(field);
        auto const remedy = field == "tile" ? "choose --grid" : of_preset && field == "saturation" ? "add --saturation hold" : "";
        return {of_preset ? std::string("--preset ") + setup.name : "--" + field + (value.empty() ? "" : " " + value), std::string(only.why), remedy};
    }
    if (o.follow) return {"--follow", "records of homes never move", ""};
    return {};
}

/// --judge-scenes takes the rules of the picture, and nothing of a run.
void check_judge_scenes(Options const& o, OptionTable const& table)
{
    constexpr std::string_view rules[] = {"judge-scenes", "preset", "quality", "background", "antialias", "footprint", "arithmetic", "threads", "quiet"};
    for (auto const& [row, text] : table.given())
        if (o.judge_scenes && std::find(std::begin(rules), std::end(rules), row->name) == std::end(rules))
            throw Error("--judge-scenes and --" + std::string(row->name) + " are both given (the scenes have maps and cameras of their own); leave one of them out");
}

/// Checks that several processes can do what the options ask for.
void check_ranks(Options const& o)
{
    auto const n = ranks::number();
    if (n == 1) return;
    auto const refuse = [n](char const* option, char const* why, char const* remedy) {
        throw Error(std::string(option) + " with " + std::to_string(n) + " processes (" + why + "); " + remedy);
    };
    if (o.choice.engine == EngineKind::sequential) refuse("--engine sequential", "that engine checks the memory of one process", "leave it out, or start one process");
    if (o.bound) refuse("--bound", "the bound's mesh has the whole map", "start one process");
    if (o.choice.exact_rays) refuse("--exact-rays", "its mesh has the whole map", "start one process");
    if (o.choice.trace) refuse("--trace", "each process has the trace of its own tiles", "start one process");
}

/// Checks that the options fit together where that depends on their values.
void check_together(Options const& o, OptionTable const& table)
{
    if (!o.trajectory) table.require({Pairing::needs, "frames", "orbit", "it counts the frames of an orbit or of a --trajectory"});
    if (!o.cameras || o.orbit_degrees) table.require({Pairing::needs, "every", "trajectory", "it counts the poses of a trajectory, or the cameras of a file"});
    if (o.near_depth && o.renderer.quality == tilemesh::splat::Quality::training)
        throw Error("--near and --quality training are both given (the trainers' rasteriser has its near plane at 0.2); leave one of them out");
    if (o.choice.exact_rays && (o.choice.engine == EngineKind::sequential || o.choice.machine == MachineKind::file))
        throw Error("--exact-rays with " + std::string(o.choice.machine == MachineKind::file ? "the machine of a file" : "--engine sequential") +
                    " (its program is built for threads, and for the machines mk2 and test); leave one of them out");
    if (o.error_picture && !o.photos && !o.compare)
        throw Error("--error-picture is given without --photos or --compare (it shows how two pictures differ); add one of them or leave it out");
    if (o.choice.engine == EngineKind::sequential && table.is_given("threads") && o.threads != 1)
        throw Error("--threads " + std::to_string(o.threads) + " and --engine sequential are both given (that engine has one thread); leave one of them out");

    using tilemesh::report::Program;
    if (auto const only = only_anchored(o); o.renderer.program == Program::homes && !only.option.empty())
        throw Error("--program homes and " + only.option + " are both given (" + only.why + "); " +
                    (only.remedy.empty() ? "" : only.remedy + ", or ") + "leave one of them out");
    else if (o.renderer.program == Program::anchored || !only.option.empty())
        for (std::string_view const option : tilemesh::render::only_homes)
            if (table.is_given(option))
                throw Error("--" + std::string(option) + " and " + (only.option.empty() ? "--program anchored" : only.option) +
                            " are both given (only the program of homes has " + std::string(option) + "); leave one of them out");

    if (o.renderer.hops != 0 && setup_of(o.choice, 0).sizes.one_channel_memory) {
        std::string others;
        for (auto const& [word, preset] : tilemesh::render::setup_fields[tilemesh::render::setup_field("preset")].values.words)
            if (!setup_of(o.choice.with_preset(word), 0).sizes.one_channel_memory) others.append(others.empty() ? "" : " or ").append("--preset ").append(word);
        throw Error("--hops " + std::to_string(o.renderer.hops) + " and --preset " + setup_of(o.choice, 0).name +
                    " are both given (its routing and bloom take turns in one set of channels, which a bound on hops would leave full); choose " +
                    others + ", or leave --hops out");
    }
}

constexpr char const* usage =
    "render_map [MAP ...] [options]\n"
    "Renders a 3D Gaussian map on a simulated mesh of tiles, each with its own SRAM and four\n"
    "neighbours, and counts messages, memory and work. Without a map, it renders a built-in desk.\n"
    "\n"
    "A picture of a map, from a camera that shows all of it:\n"
    "  render_map room.ply\n"
    "From the cameras of a SLAM system or of training, all or one of them:\n"
    "  render_map room.ply --cameras cameras.json\n"
    "  render_map room.ply --cameras sparse/0 --camera frame_0042.jpg\n"
    "An orbit of 60 frames, half a degree apart:\n"
    "  render_map room.ply --orbit 0.5 --frames 60\n"
    "The motion of a hand-held camera, starting at the camera that shows all of the map:\n"
    "  render_map room.ply --trajectory fr1_desk.txt --relative\n"
    "The picture with channels that are too small:\n"
    "  render_map room.ply --preset prototype --channel-slots 10 --report report.json\n"
    "The error against double precision:\n"
    "  render_map room.ply --reference\n"
    "PSNR and SSIM of the held-out views of a map that was trained at half size:\n"
    "  render_map room.ply --cameras sparse/0 --photos images --every 8 --scale 2\n"
    "The tiles, steps and channels that the machine waits for, and the path of one Gaussian:\n"
    "  render_map room.ply --trace where --follow 4711\n";

/// What --help says behind the options.
constexpr char const* notes =
    "\n"
    "Write a value as the next word or behind '='. After --, every word is a map.\n"
    "\n"
    "Files that are read\n"
    "  Maps: 3DGS PLY, compressed PLY, .splat, SPZ (versions 1 to 4) and SOG (an archive, or a folder\n"
    "  with meta.json). Several maps are one; the ids count on. An SPZ has y up and z back: its y and z\n"
    "  change sign.\n"
    "  Cameras: tilemesh's own JSON (cameras[] with world_to_camera), the cameras.json of 3DGS\n"
    "  training, the transforms.json of nerfstudio and instant-ngp, or a COLMAP model, text or binary\n"
    "  (cameras.txt, images.txt, cameras.bin, images.bin, or their folder).\n"
    "  Trajectories, one pose per line, camera to world; the first pose tells the form:\n"
    "    TUM      timestamp tx ty tz qx qy qz qw, in seconds\n"
    "    EuRoC    timestamp,px,py,pz,qw,qx,qy,qz, in nanoseconds\n"
    "    KITTI    the 12 numbers of a 3x4 matrix, row by row\n"
    "    Replica  the 16 numbers of a 4x4 matrix, row by row\n"
    "  --rolling-shutter takes the motion between the poses before and after each, from their time\n"
    "  stamps. A pose is that of the row of the picture's centre.\n"
    "  Machines: a line `machine NAME`, then one number per line, `NUMBER VALUE UNIT SOURCE`, as\n"
    "  examples/machines/bow.txt: tiles, SRAM, code, workers, clock, barrier, exchange. A preset that\n"
    "  does not fit there gets smaller channels, and storage takes the rest. The report has the name of\n"
    "  the machine.\n"
    "  Cost models: as --trace writes them (model.txt); they may have the lines of a network.\n"
    "  Energy models: a line `energy NAME`, then one event per line, `EVENT VALUE fJ SOURCE`. No event\n"
    "  has a built-in value; include/tilemesh/model/energy.hpp lists the events.\n"
    "\n"
    "Photographs\n"
    "  The photograph of a camera is a PNG or JPEG below DIR. It has the name of the camera, with that or\n"
    "  another extension, with or without its folders. PSNR and L1 are over the three channels, peak 1.\n"
    "  SSIM is that of 3DGS' own evaluation: a Gaussian window of 11 x 11 and sigma 1.5, each channel\n"
    "  alone, data range 1, zeros outside the picture. The frame is clamped to [0, 1], not rounded;\n"
    "  transparency shows the --background. --every 8 takes the field's held-out views: every\n"
    "  eighth of the sorted names. --scale 2 halves the cameras, and the photographs that are not\n"
    "  halved yet (Pillow's bicubic filter). A photograph that is missing, damaged or of another size\n"
    "  gets one line on standard error; the others are compared, and the exit status is 1.\n"
    "  --compare measures a PFM as it is, without clamping. An error picture shows the difference of\n"
    "  each channel, divided by the largest one.\n"
    "\n"
    "Qualities\n"
    "  A quality sets two cut-offs: the faintest term that is blended, and the transmittance at which\n"
    "  a pixel is finished. The default's are 1/255 and 5e-3. The list has the pairs, against the\n"
    "  default's, and the error against double precision without cut-offs, on three maps at 640 x 360\n"
    "  with opacity boxes (a 3-sigma square is a cut-off of its own):\n"
    "    evaluation  1/8160, 1e-4  1.4 times  RMSE 3e-5 to 7e-5, PSNR above 83 dB\n"
    "    viewing     1/128, 5e-3   0.9 times  RMSE 1.8e-3 to 3e-3, PSNR 50 to 55 dB\n"
    "    on_sensor   1/64, 1e-2    0.8 times  RMSE 3.3e-3 to 5.7e-3, PSNR 44 to 50 dB\n"
    "  training has all rules of the rasteriser that 3D Gaussian Splatting trains with: 1/255; alpha at\n"
    "  most 0.99; a stop before the term that would leave less than 1e-4; the 16x16 tiles that a\n"
    "  3-sigma square touches (three_sigma_tiles); a near plane at 0.2, whatever the camera says.\n"
    "\n"
    "Programs\n"
    "  anchored: a record lives on the tile of its centre, and the tiles that it touches store copies.\n"
    "  A small step of the camera moves few records, but a crowded tile may be full. homes: a record\n"
    "  lives on any tile. In each view, homes send its splat to the tiles that see it, in as many rounds\n"
    "  as these need; the picture is complete for any map. auto: anchored until a frame would lack\n"
    "  something, then homes for good. Options that only anchored has keep auto there: drop (--preset\n"
    "  paper, prototype), --copies screen, --hops, --tile, --follow.\n"
    "\n"
    "Conventions\n"
    "  World units are the map's. Cameras as in OpenCV: x right, y down, z forward; the centre of\n"
    "  pixel (i, j) is (i + 0.5, j + 0.5). Colours are written as they are trained, without gamma.\n"
    "  Without --near, a camera whose file names no near plane has it at 0.2, or at a tenth of the\n"
    "  median depth of what its picture shows if that is less; a note counts what the plane hides.\n"
    "\n"
    "The numbers of the summary\n"
    "  Host times: `other` is what no stage has, and `frame` is the sum of all rows. Gaussians: visible\n"
    "  ones have something on screen, parked ones have not; moved ones changed their tile. Held counts\n"
    "  refusals by full channels, after which a record waits. Unplaced ones found their tile full, and\n"
    "  dropped ones are lost. Pairs are of a splat and a pixel: compositing looked at those evaluated,\n"
    "  and those contributing changed the pixel. Exchanged bytes: those of the messages, and those that\n"
    "  a machine moves whose exchanges, planned at compile time, move all channels, full or empty.\n"
    "  include/tilemesh/report/frame_report.hpp explains each number of a report. The last table of a\n"
    "  trace's report.html explains them too.\n"
    "\n"
    "Files that are written\n"
    "  frame_0000.png, frame_0001.png, ... and the files that options ask for. --trace DIR writes\n"
    "  report.html, which a browser shows without a network, model.txt, and frames.csv with the\n"
    "  counters of all frames. For each frame it writes .tiles.csv (above 200,000 lines only with\n"
    "  --trace-tiles), .supersteps.csv, .heat.csv, .heat_*.png and .trace.json (ui.perfetto.dev), and\n"
    "  with --energy .energy.csv. If --most-passes ends the run, it writes no_progress.txt, which names\n"
    "  the steps that the tiles repeat.\n"
    "  --video writes YUV4MPEG2: 3 bytes per pixel and frame, in the colours of BT.601, 16 to 235. With\n"
    "  --video -, the summary goes to standard error. All frames must have one size.\n"
    "  A run never writes over a file that it reads, even through a link, and writes no file twice.\n"
    "  With --resume, resume.jsonl lists the finished frames. After a kill or a crash, start the same\n"
    "  command again: it keeps every frame of that list whose files are complete, and ends with the\n"
    "  pictures and counters of an uninterrupted run. It refuses another map, option or version.\n"
    "  A file gets its name only when it is complete; with --report, after the disk has its bytes.\n"
    "  Ctrl-C finishes the current frame, writes the report and the video of the finished frames, and\n"
    "  ends the run. A second Ctrl-C ends it at once. After an error there is no video.\n"
    "\n"
    "Exit status\n"
    "  0: all files are written. 1: with --strict, a picture lacks something: records, copies, or what a\n"
    "  bound on rounds cuts off; standard error always says so. Also 1: a frame could not be compared\n"
    "  with its photograph. 2: an error; one line on standard error\n"
    "  names the problem, the reason and a remedy. 130: SIGINT (Ctrl-C). 143: SIGTERM.\n";

OptionTable table_of(Options& o)
{
    OptionTable table("render_map", usage);
    table.takes_words("map", ~std::size_t{0}, [&o](std::string_view word) { o.maps.emplace_back(word); });
    table.add("The map", o, map_rows);
    table.add("What to see", o, camera_rows, camera_pairings);
    table.says("cameras", "cameras from a file (see below); without --camera, all of the map's scene");
    table.says("near", "the near plane, in world units [the file's, or see below]");
    table.add("What to see", o, motion_rows, motion_pairings);
    table.says("trajectory", "render a frame per pose of a file (see below), with the lens of --camera");
    table.says("every", "render every Nth pose of the trajectory, or camera by name, from the first");
    table.add("What to compare with", o, photograph_rows, photograph_pairings);
    table.add("What to compare with", o, picture_rows);
    table.add("The machine and its rules", o, setup_rows);
    table.add("The machine and its rules", o, renderer_rows);
    table.add("The machine and its rules", o, policy_rows);
    table.add("The host", o, engine_rows);
    table.add("The host", o, host_rows);
    table.says("threads", "number of host threads [all of this machine's]");
    table.says("quiet", "print no progress and no table");
    table.add("What comes out", o, output_rows, pairings);
    table.ends_with(notes);
    return table;
}

} // namespace

Options parse_options(std::span<char const* const> words)
{
    Options result;
    result.bends = true;
    auto table = table_of(result);
    if (!table.read(words)) return result;
    for (auto const& path : table.inputs()) result.inputs.emplace_back(path);
    if (result.machine) result.inputs.push_back(*result.machine);
    for (auto const& [row, text] : table.given()) {
        if (std::find(std::begin(beside_frames), std::end(beside_frames), row->name) != std::end(beside_frames)) continue;
        bool const is_input = row->form == Form::input || (row->name == "machine" && result.machine);
        result.shaping.push_back("--" + std::string(row->name) + (row->value.empty() || is_input ? "" : "=" + text));
    }
    auto& renderer = result.renderer;
    renderer.channel_slots = result.channel_slots.value_or(0);
    renderer.storage_slots = result.storage_slots.value_or(0);
    renderer.background = result.background;
    if (result.antialias) renderer.coverage = result.coverage();
    result.choice.trace = result.trace.has_value();
    if (!table.is_given("threads"))
        result.threads = result.choice.engine == EngineKind::sequential
                             ? 1
                             : std::clamp(std::thread::hardware_concurrency() / ranks::on_this_host(), 1u, most_threads);
    renderer.threads = result.threads;
    for (std::size_t k = 0; result.maps.size() > 1 && k < result.maps.size(); ++k)
        result.shaping.push_back("map " + std::to_string(k + 1) + " " + result.maps[k].lexically_normal().filename().string());
    check_together(result, table);
    check_judge_scenes(result, table);
    check_ranks(result);
    result.choice.stays_anchored = renderer.program == tilemesh::report::Program::anchored || !only_anchored(result).option.empty();
    return result;
}

std::string help_text()
{
    Options any;
    return table_of(any).help();
}

std::string version_text()
{
    return "render_map (tilemesh) " + std::to_string(TILEMESH_VERSION / 10000) + "." +
           std::to_string(TILEMESH_VERSION / 100 % 100) + "." + std::to_string(TILEMESH_VERSION % 100) + "\n";
}

} // namespace render_map
