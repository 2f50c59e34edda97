#include "options.hpp"
#include "../shared/text.hpp"
#include "ranks.hpp"
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <span>
#include <string_view>
#include <thread>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <utility>
#include <vector>

namespace render_map {

namespace {

using tilemesh::Error;

// --- values ------------------------------------------------------------------------------------

/// The user's text, short enough that the rest of the error stays visible: 60 bytes show any typing error.
std::string in_quotes(std::string_view text)
{
    return "\"" + shared::one_line(std::string(text), 60) + "\"";
}

/// `any_number`: any number of 32 bits, so that an error names no upper bound.
constexpr std::uint32_t any_number = 0xffffffffu;

std::uint32_t whole_number(std::string_view option, std::string_view text, std::uint32_t most, std::uint32_t least = 1)
{
    std::uint32_t value = 0;
    auto const [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value < least || value > most)
        throw Error(std::string(option) + " cannot be " + in_quotes(text) + " (it takes a whole number" +
                    (most == any_number ? ", 1 or more" : " from 1 to " + std::to_string(most)) + "); write for example " +
                    std::string(option) + " 1");
    return value;
}

/// "30", or "30000/1001".
tilemesh::report::FrameRate frame_rate(std::string_view option, std::string_view text)
{
    constexpr std::uint32_t most = 1'000'000; // the rate of any camera; players read both numbers into 32 bits
    auto const slash = std::min(text.find('/'), text.size());
    auto const number = [&](std::string_view digits) -> std::uint32_t {
        std::uint32_t value = 0;
        auto const [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        return error == std::errc{} && end == digits.data() + digits.size() && value <= most ? value : 0;
    };
    tilemesh::report::FrameRate const rate{number(text.substr(0, slash)), slash == text.size() ? 1 : number(text.substr(slash + 1))};
    if (rate.frames == 0 || rate.seconds == 0)
        throw Error(std::string(option) + " cannot be " + in_quotes(text) +
                    " (it takes N or N/D, whole numbers from 1 to 1000000); write for example " + std::string(option) + " 30000/1001");
    return rate;
}

tilemesh::Extent2 extent(std::string_view option, std::string_view text, char const* example)
{
    auto const number = [&](std::string_view digits) -> std::uint32_t {
        std::uint32_t value = 0;
        auto const [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), value);
        bool const good =
            error == std::errc{} && end == digits.data() + digits.size() && value <= 65535;
        return good ? value : 0;
    };
    auto const x = text.find('x');
    tilemesh::Extent2 result;
    if (x != std::string_view::npos)
        result = {number(text.substr(0, x)), number(text.substr(x + 1))};
    if (result.width == 0 || result.height == 0)
        throw Error(std::string(option) + " cannot be " + in_quotes(text) +
                    " (it takes WxH, two whole numbers from 1 to 65535); write for example " + std::string(option) + " " +
                    example);
    return result;
}

double degrees(std::string_view option, std::string_view text)
{
    double value = 0;
    auto const digits = text.substr(text.starts_with('+') ? 1 : 0);
    auto const [end, error] = tilemesh::read_number(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value))
        throw Error(std::string(option) + " cannot be " + in_quotes(text) +
                    " (it takes degrees, a number); write for example " + std::string(option) + " 0.5");
    return value;
}

/// Three numbers from `least` to `most`, separated by commas; nothing if the text is something else.
std::optional<std::array<double, 3>> three_numbers(std::string_view text, double least, double most)
{
    std::array<double, 3> result{};
    auto const* at = text.data();
    auto const* const end = at + text.size();
    bool good = true;
    for (std::size_t i = 0; i < 3 && good; ++i) {
        if (at != end && *at == '+') ++at;
        auto const [stop, error] = tilemesh::read_number(at, end, result[i]);
        good = error == std::errc{} && result[i] >= least && result[i] <= most && (i < 2 ? stop != end && *stop == ',' : stop == end);
        at = stop + (i < 2 && good ? 1 : 0);
    }
    if (!good) return {};
    return result;
}
std::array<double, 3> point(std::string_view option, std::string_view text)
{
    if (auto const result = three_numbers(text, -1e30, 1e30)) return *result;
    throw Error(std::string(option) + " cannot be " + in_quotes(text) + " (it takes X,Y,Z, three numbers within 1e30 in world units); write for example " +
                std::string(option) + " 0,-1,0");
}
std::array<float, 3> colour(std::string_view option, std::string_view text)
{
    auto const result = three_numbers(text, 0, 1);
    if (!result)
        throw Error(std::string(option) + " cannot be " + in_quotes(text) + " (it takes R,G,B, three numbers from 0 to 1); write for example " +
                    std::string(option) + " 1,1,1");
    return {static_cast<float>((*result)[0]), static_cast<float>((*result)[1]), static_cast<float>((*result)[2])};
}

std::filesystem::path file(std::string_view option, std::string_view text)
{
    if (text.empty())
        throw Error(std::string(option) +
                    " cannot be empty (it takes a name in the file system); name one");
    return text;
}

/// Registers a file that the run reads. Every option with an input file calls this, so that the run does not overwrite it.
std::filesystem::path input(Options& options, std::string_view option, std::string_view text)
{
    return options.inputs.emplace_back(file(option, text));
}

template <class T>
struct Word {
    char const* word;
    T value;
};
template <class T, std::size_t N>
T one_of(std::string_view option, std::string_view text, Word<T> const (&words)[N])
{
    std::string choices;
    for (auto const& [word, value] : words) {
        if (text == word) return value;
        choices += (choices.empty() ? "" : ", ") + std::string(word);
    }
    throw Error(std::string(option) + " cannot be " + in_quotes(text) + " (there are " + choices +
                "); choose one of these");
}

constexpr Word<Preset> presets[] = {{"lossless", Preset::lossless}, {"paper", Preset::paper}, {"prototype", Preset::prototype}};

// --- options -----------------------------------------------------------------------------------

struct Option {
    std::string_view name;
    std::string_view value; ///< what the help calls it; empty: the option takes none
    std::string_view help;
    void (*set)(Options&, std::string_view option, std::string_view text);
};

/// More threads than any host has. A typing error should not start a million threads.
constexpr std::uint32_t most_threads = 1024;

constexpr Option options[] = {
    {"--cameras", "FILE", "cameras from a file (see below); without --camera, all of the map's scene",
     [](Options& o, auto name, auto text) { o.cameras = input(o, name, text); }},
    {"--camera", "SCENE/NAME", "render one camera of that file; NAME alone is enough if it is unique",
     [](Options& o, auto name, auto text) {
         // Longer than any name in a camera file; the error that lists the names would not fit a screen.
         if (text.empty() || text.size() > 255)
             throw Error(std::string(name) + " cannot be " + in_quotes(text) +
                         " (it takes SCENE/NAME, 1 to 255 bytes); name a camera or leave the option out");
         o.camera = text;
     }},
    {"--list", "", "print the names of that file's cameras, one per line, and render nothing",
     [](Options& o, auto, auto) { o.list = true; }},
    {"--from", "X,Y,Z", "stand at this point of the world, without a camera file",
     [](Options& o, auto name, auto text) { o.from = point(name, text); }},
    {"--look", "X,Y,Z", "look from there at this point [the map's middle]",
     [](Options& o, auto name, auto text) { o.look = point(name, text); }},
    {"--up", "X,Y,Z", "the direction that is up in the map, as 0,1,0 [0,-1,0: y points down]",
     [](Options& o, auto name, auto text) { o.up = point(name, text); }},
    {"--fov", "DEGREES", "field of view from the left to the right border [60]",
     [](Options& o, auto name, auto text) {
         o.fov = degrees(name, text);
         if (!(*o.fov >= 1 && *o.fov <= 179))
             throw Error(std::string(name) + " cannot be " + in_quotes(text) + " (a field of view is 1 to 179 degrees); write for example --fov 60");
     }},
    {"--orbit", "DEGREES", "turn the camera around the map's middle, by DEGREES per frame",
     [](Options& o, auto name, auto text) { o.orbit_degrees = degrees(name, text); }},
    {"--frames", "N", "render N frames of the orbit, or the first N poses (see --every)",
     [](Options& o, auto name, auto text) { o.frames = whole_number(name, text, most_frames); }},
    {"--trajectory", "FILE", "render a frame per pose of a file (see below), with the lens of --camera",
     [](Options& o, auto name, auto text) { o.trajectory = input(o, name, text); }},
    {"--trajectory-format", "NAME", "the form of that file: tum, euroc, kitti or replica [the file tells it]",
     [](Options& o, auto name, auto text) {
         using tilemesh::scene::TrajectoryFormat;
         o.trajectory_format = one_of<TrajectoryFormat>(name, text,
                                                        {{"tum", TrajectoryFormat::tum}, {"euroc", TrajectoryFormat::euroc}, {"kitti", TrajectoryFormat::kitti}, {"replica", TrajectoryFormat::replica}});
     }},
    {"--every", "N", "render every Nth pose of the trajectory, or camera by name, from the first",
     [](Options& o, auto name, auto text) { o.every = whole_number(name, text, any_number); }},
    {"--relative", "", "move the camera as the trajectory moves from its first pose",
     [](Options& o, auto, auto) { o.relative = true; }},
    {"--size", "WxH", "size in pixels [the camera's own, or 1280x720]",
     [](Options& o, auto name, auto text) {
         auto const [width, height] = extent(name, text, "1280x720");
         o.size = tilemesh::scene::Size{width, height};
     }},

    {"--near", "D", "the near plane, in world units [the file's, or see below]",
     [](Options& o, auto name, auto text) {
         double value = 0;
         auto const [end, error] = tilemesh::read_number(text.data(), text.data() + text.size(), value);
         if (error != std::errc{} || end != text.data() + text.size() || !(value >= 1e-30 && value <= 1e30))
             throw Error(std::string(name) + " cannot be " + in_quotes(text) + " (a near plane is a distance above 0, in world units); write for example --near 0.01");
         o.near_depth = static_cast<float>(value);
     }},
    {"--turn", "NAME", "turn the map about an axis by 90, 180 or 270 degrees: x90, x180 ... z270",
     [](Options& o, auto name, auto text) {
         using tilemesh::scene::Turn;
         o.turn = one_of<Turn>(name, text,
                               {{"x90", Turn::x90},
                                {"x180", Turn::x180},
                                {"x270", Turn::x270},
                                {"y90", Turn::y90},
                                {"y180", Turn::y180},
                                {"y270", Turn::y270},
                                {"z90", Turn::z90},
                                {"z180", Turn::z180},
                                {"z270", Turn::z270}});
     }},
    {"--ignore-distortion", "", "take a lens with distortion for a pinhole, although its pictures are bent",
     [](Options& o, auto, auto) { o.distorted = tilemesh::scene::DistortedLens::ignored; }},
    {"--scale", "N", "divide the sides of the cameras' pictures by N, as trainers do [1]",
     [](Options& o, auto name, auto text) { o.scale = whole_number(name, text, 64); }},

    {"--preset", "NAME", "lossless | paper | prototype [lossless]",
     [](Options& o, auto name, auto text) {
         o.choice.preset = one_of<Preset>(name, text, presets);
     }},
    {"--program", "NAME", "auto (homes once anchored would lack something) | anchored | homes [auto]",
     [](Options& o, auto name, auto text) {
         using tilemesh::report::Program;
         o.renderer.program = one_of<Program>(
             name, text, {{"auto", Program::automatic}, {"anchored", Program::anchored}, {"homes", Program::homes}});
     }},
    {"--machine", "NAME|FILE", "mk2 | test (64 MiB per tile) | a file (see below) [mk2 if it has room]",
     [](Options& o, auto name, auto text) {
         o.machine_named = true;
         if (text.find_first_of("./") != std::string_view::npos) { // a name has neither
             o.machine = input(o, name, text);
             o.choice.machine = MachineKind::file;
             return;
         }
         o.choice.machine = one_of<MachineKind>(
             name, text, {{"mk2", MachineKind::mk2}, {"test", MachineKind::test}});
     }},
    {"--grid", "WxH", "number of tiles [40x36, or as many as --size and --tile need]",
     [](Options& o, auto name, auto text) { o.renderer.grid = extent(name, text, "40x36"); }},
    {"--tile", "WxH", "pixels per tile [the frame spread evenly over the grid]",
     [](Options& o, auto name, auto text) { o.renderer.tile = extent(name, text, "32x20"); }},
    {"--channel-slots", "N", "limit each channel to N records [the preset's slots]",
     [](Options& o, auto name, auto text) { o.channel_slots = o.renderer.channel_slots = whole_number(name, text, any_number, 0); }},
    {"--storage-slots", "N", "limit the storage of each tile to N records [the preset's slots]",
     [](Options& o, auto name, auto text) { o.storage_slots = o.renderer.storage_slots = whole_number(name, text, any_number, 0); }},
    {"--held", "N", "homes: limit the splats that a tile holds [--storage-slots, or what fits]",
     [](Options& o, auto name, auto text) { o.renderer.held_slots = whole_number(name, text, any_number); }},
    {"--rounds", "N|all", "homes: end a frame after N rounds, complete or not [all]",
     [](Options& o, auto name, auto text) {
         if (text != "all" && text != "0") o.renderer.rounds = whole_number(name, text, any_number);
     }},
    {"--fold", "NAME", "homes: on (spread each part of the picture over the grid) | off [on]",
     [](Options& o, auto name, auto text) { o.renderer.fold = one_of<bool>(name, text, {{"on", true}, {"off", false}}); }},
    {"--saturation", "NAME", "a full channel: hold records back | drop copies [the preset's]",
     [](Options& o, auto name, auto text) {
         o.choice.saturation = one_of<SaturationKind>(
             name, text, {{"hold", SaturationKind::hold}, {"drop", SaturationKind::drop}});
     }},
    {"--priority", "NAME", "a full tile keeps, a full channel takes: first (come) | largest [first]",
     [](Options& o, auto name, auto text) {
         o.choice.largest_first = one_of<bool>(name, text, {{"first", false}, {"largest", true}});
     }},
    {"--footprint", "NAME", "opacity_box | three_sigma_square | three_sigma_tiles [the preset's]",
     [](Options& o, auto name, auto text) {
         using tilemesh::splat::Footprint;
         o.renderer.footprint =
             one_of<Footprint>(name, text,
                               {{"opacity_box", Footprint::opacity_box},
                                {"three_sigma_square", Footprint::three_sigma_square},
                                {"three_sigma_tiles", Footprint::three_sigma_tiles}});
     }},
    {"--copies", "NAME", "bloom sends copies in world | screen coordinates [the preset's]",
     [](Options& o, auto name, auto text) {
         o.choice.copies = one_of<CopiesKind>(
             name, text, {{"world", CopiesKind::world}, {"screen", CopiesKind::screen}});
     }},
    {"--hops", "N|quiet", "end routing, and bloom, of a frame after N exchanges [quiet]",
     [](Options& o, auto name, auto text) {
         if (text != "quiet") o.renderer.hops = std::min(whole_number(name, text, any_number), any_number - 1);
     }},
    {"--most-passes", "N", "stop with an error if routing, or bloom, needs more than N passes",
     [](Options& o, auto name, auto text) { o.renderer.most_passes = whole_number(name, text, any_number); }},
    {"--pixels", "NAME", "framebuffers of the tiles: float | rgbx8 [the preset's]",
     [](Options& o, auto name, auto text) {
         o.choice.pixels = one_of<PixelKind>(
             name, text, {{"float", PixelKind::float32}, {"rgbx8", PixelKind::rgbx8}});
     }},
    {"--arithmetic", "NAME", "precise (bits of a naive loop) | fast (alpha within 2e-5 of it) [fast]",
     [](Options& o, auto name, auto text) {
         using tilemesh::splat::Arithmetic;
         o.renderer.arithmetic =
             one_of<Arithmetic>(name, text, {{"precise", Arithmetic::precise}, {"fast", Arithmetic::fast}});
     }},

    {"--quality", "NAME", "see below: evaluation | viewing | on_sensor | training [the preset's]",
     [](Options& o, auto name, auto text) {
         using tilemesh::splat::Quality;
         o.renderer.quality = one_of<Quality>(name, text,
                                              {{"evaluation", Quality::evaluation},
                                               {"viewing", Quality::viewing},
                                               {"on_sensor", Quality::on_sensor},
                                               {"training", Quality::training}});
     }},
    {"--background", "R,G,B", "the colour behind the Gaussians, 0 to 1 [0,0,0: black]",
     [](Options& o, auto name, auto text) { o.renderer.background = colour(name, text); }},
    {"--antialias", "", "dim each splat as much as the 0.3 pixels enlarge it (maps trained so)",
     [](Options& o, auto, auto) { o.renderer.coverage = tilemesh::splat::Coverage::preserved; }},
    {"--sh-degree", "N", "highest degree of view-dependent colour, 0 to 3 [the map's]",
     [](Options& o, auto name, auto text) {
         o.sh_degree = one_of<std::uint32_t>(name, text, {{"0", 0}, {"1", 1}, {"2", 2}, {"3", 3}});
     }},
    {"--fit", "NAME", "scene (leave out features that the scene does not need) | off [scene]",
     [](Options& o, auto name, auto text) { o.choice.fit = one_of<bool>(name, text, {{"scene", true}, {"off", false}}); }},

    {"--engine", "NAME", "threads | sequential (slower, checks every write) [threads]",
     [](Options& o, auto name, auto text) {
         o.choice.engine = one_of<EngineKind>(
             name, text,
             {{"threads", EngineKind::threads}, {"sequential", EngineKind::sequential}});
     }},
    {"--threads", "N", "number of host threads [all of this machine's]",
     [](Options& o, auto name, auto text) { o.renderer.threads = whole_number(name, text, most_threads); }},

    {"--out", "DIR", "folder for frame_0000.png, frame_0001.png, ... [tilemesh_out]",
     [](Options& o, auto name, auto text) { o.out = file(name, text); }},
    {"--float", "", "also write frame_0000.pfm: linear float32, unclamped",
     [](Options& o, auto, auto) { o.pfm = true; }},
    {"--depth", "", "also write frame_0000.depth.pfm: depth along z in world units; 0: nothing",
     [](Options& o, auto, auto) { o.choice.depth = true; }},
    {"--alpha", "", "also write frame_0000.alpha.pfm: covered share of each pixel, 0 to 1",
     [](Options& o, auto, auto) { o.choice.alpha = true; }},
    {"--video", "FILE", "also write a raw video, which players and encoders read; -: standard output",
     [](Options& o, auto name, auto text) { o.video = file(name, text); }},
    {"--fps", "N", "frames per second of the video, as 30 or 30000/1001 [30]",
     [](Options& o, auto name, auto text) { o.fps = frame_rate(name, text); }},
    {"--reference", "", "compare with double precision, with and without cut-offs (slow)",
     [](Options& o, auto, auto) { o.reference = true; }},
    {"--photos", "DIR", "compare with the cameras' photographs: PSNR, SSIM, L1 (see below)",
     [](Options& o, auto name, auto text) { o.photos = input(o, name, text); }},
    {"--compare", "FILE", "compare with another renderer's picture, PFM or PNG",
     [](Options& o, auto name, auto text) { o.compare = input(o, name, text); }},
    {"--error-picture", "", "also write frame_0000.error.png: where --photos or --compare differ",
     [](Options& o, auto, auto) { o.error_picture = true; }},
    {"--report", "FILE", "write all counters as JSON",
     [](Options& o, auto name, auto text) { o.report = file(name, text); }},
    {"--trace", "DIR", "write what each tile did, and modelled cycles: HTML, CSV, JSON",
     [](Options& o, auto name, auto text) {
         o.trace = file(name, text);
         o.choice.trace = true;
     }},
    {"--trace-tiles", "", "also write .tiles.csv of a frame with more than 200,000 lines (10 MB)",
     [](Options& o, auto, auto) { o.trace_tiles = true; }},
    {"--cost-model", "FILE", "cost model for the trace, a text file like DIR/model.txt [--machine's]",
     [](Options& o, auto name, auto text) { o.cost_model = input(o, name, text); }},
    {"--energy", "FILE", "energy model for the trace: joules and source of each event (see below)",
     [](Options& o, auto name, auto text) { o.energy = input(o, name, text); }},
    {"--follow", "ID", "write the life of one Gaussian (ID: 1 + its row) to DIR/follow_ID.csv",
     [](Options& o, auto name, auto text) { o.follow = whole_number(name, text, any_number); }},
    {"--explain", "", "print the features that this map and these cameras do not need, and why",
     [](Options& o, auto, auto) { o.explain = true; }},
    {"--quiet", "", "print no progress and no table", [](Options& o, auto, auto) { o.quiet = true; }},
    {"--resume", "", "list finished frames in --out; after a kill or a crash, render the rest",
     [](Options& o, auto, auto) { o.resume = true; }},
    {"--strict", "", "end with status 1 if a picture lacks something",
     [](Options& o, auto, auto) { o.strict = true; }},
    {"--version", "", "print the version", [](Options& o, auto, auto) { o.version = true; }},
    {"--help", "", "print this text", [](Options& o, auto, auto) { o.help = true; }},
};

/// Options that begin a group of the help, and the group's title.
constexpr struct {
    std::string_view first, title;
} groups[] = {{"--cameras", "What to see"},
              {"--preset", "The machine and its rules"},
              {"--engine", "The host"},
              {"--out", "What comes out"}};

/// Options that change no picture and no counter. They may differ in a run that resumes another.
constexpr std::string_view beside_frames[] = {"--threads", "--out", "--report", "--resume", "--explain", "--quiet", "--strict"};

/// An option that only the anchored program has, and why homes do not have it; empty: there is none.
struct OnlyAnchored {
    std::string option, why, remedy;
};
OnlyAnchored only_anchored(Options const& o)
{
    auto const setup = setup_of(o.choice, 0);
    auto const of_preset = [&](bool asked, char const* option) { return asked ? std::string(option) : std::string("--preset ") + setup.name; };
    if (!setup.holds)
        return {of_preset(o.choice.saturation.has_value(), "--saturation drop"), "homes drop nothing", o.choice.saturation ? "" : "add --saturation hold"};
    if (!setup.reusable) return {of_preset(o.choice.copies.has_value(), "--copies screen"), "homes send no copies to keep", ""};
    if (setup.ranks) return {"--priority largest", "homes lose nothing that a rank could save", ""};
    if (o.renderer.hops != 0) return {"--hops", "homes have no routing to end; --rounds ends a frame of homes", ""};
    if (o.renderer.tile.width != 0) return {"--tile", "homes divide the frame into blocks of 16 x 5 pixels", "choose --grid"};
    if (o.follow) return {"--follow", "records of homes never move", ""};
    return {};
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
    if (o.choice.trace) refuse("--trace", "each process has the trace of its own tiles", "start one process");
}

/// Checks that the options fit together, which no single option can know.
void check_together(Options const& o, std::vector<std::string_view> const& given)
{
    auto const is_given = [&](std::string_view name) {
        return std::find(given.begin(), given.end(), name) != given.end();
    };
    auto const needs = [&](std::string_view option, std::string_view other, char const* why) {
        if (is_given(option) && !is_given(other))
            throw Error(std::string(option) + " is given without " + std::string(other) + " (" +
                        why + "); add " + std::string(other) + " or leave it out");
    };
    needs("--camera", "--cameras", "a camera is looked up in a camera file");
    if (!o.trajectory) needs("--frames", "--orbit", "it counts the frames of an orbit or of a --trajectory");
    needs("--orbit", "--frames", "an orbit has as many frames as you ask for");
    if (!o.cameras || o.orbit_degrees) needs("--every", "--trajectory", "it counts the poses of a trajectory, or the cameras of a file");
    needs("--list", "--cameras", "it prints the names of a camera file");
    needs("--look", "--from", "a camera looks from a point");
    for (auto const option : {"--from", "--up", "--fov"})
        if (is_given(option) && o.cameras)
            throw Error(std::string(option) + " and --cameras are both given (each places the camera); leave one of them out");
    if (o.near_depth && o.renderer.quality == tilemesh::splat::Quality::training)
        throw Error("--near and --quality training are both given (the trainers' rasteriser has its near plane at 0.2); leave one of them out");
    needs("--ignore-distortion", "--cameras", "a camera file says how a lens bends the picture");
    needs("--scale", "--cameras", "it divides the sizes that a camera file has");
    needs("--photos", "--cameras", "a camera file names the photographs");
    if (o.photos && (o.orbit_degrees || o.trajectory))
        throw Error(std::string("--photos and ") + (o.trajectory ? "--trajectory" : "--orbit") +
                    " are both given (nobody photographed the views of a moved camera); leave one of them out");
    if (o.photos && o.compare)
        throw Error("--photos and --compare are both given (a frame is compared with one picture); leave one of them out");
    if (o.size && (o.photos || is_given("--scale")))
        throw Error(std::string(o.photos ? "--photos" : "--scale") +
                    " and --size are both given (a photograph has the size of its camera, divided by --scale); leave --size out");
    if (o.error_picture && !o.photos && !o.compare)
        throw Error("--error-picture is given without --photos or --compare (it shows how two pictures differ); add one of them or leave it out");
    needs("--relative", "--trajectory", "it says how to read a trajectory");
    needs("--trajectory-format", "--trajectory", "it says how to read a trajectory");
    if (o.orbit_degrees && o.trajectory)
        throw Error("--orbit and --trajectory are both given (each moves the camera); choose one");
    if (o.choice.engine == EngineKind::sequential && is_given("--threads") &&
        o.renderer.threads != 1)
        throw Error("--threads " + std::to_string(o.renderer.threads) +
                    " and --engine sequential are both given (that engine has one thread); leave "
                    "one of them out");

    needs("--fps", "--video", "it is the rate of a video");
    needs("--trace-tiles", "--trace", "it is a table of a trace");
    needs("--cost-model", "--trace", "cycles are modelled from a trace");
    needs("--energy", "--trace", "energy is counted from a trace");
    needs("--follow", "--trace", "what is followed is written beside a trace");

    if (o.resume && o.trace)
        throw Error("--resume and --trace are both given (the report of a trace needs every tile of every frame); leave one of them out");

    if (o.resume && o.video)
        throw Error("--resume and --video are both given (the video would lack the frames that an earlier run wrote); leave one of them out");

    using tilemesh::report::Program;
    if (auto const only = only_anchored(o); o.renderer.program == Program::homes && !only.option.empty())
        throw Error("--program homes and " + only.option + " are both given (" + only.why + "); " +
                    (only.remedy.empty() ? "" : only.remedy + ", or ") + "leave one of them out");
    else if (o.renderer.program == Program::anchored || !only.option.empty())
        for (auto const option : {"--rounds", "--held", "--fold"})
            if (is_given(option))
                throw Error(std::string(option) + " and " + (only.option.empty() ? "--program anchored" : only.option) +
                            " are both given (only the program of homes has " + (option + 2) + "); leave one of them out");

    auto const shares_channels = [&](Preset preset) {
        auto choice = o.choice;
        choice.preset = preset;
        return setup_of(choice, 0).sizes.one_channel_memory;
    };
    if (o.renderer.hops != 0 && shares_channels(o.choice.preset)) {
        std::string others;
        for (auto const& [word, preset] : presets)
            if (!shares_channels(preset)) others.append(others.empty() ? "" : " or ").append("--preset ").append(word);
        throw Error("--hops " + std::to_string(o.renderer.hops) + " and --preset " + setup_of(o.choice, 0).name +
                    " are both given (its routing and bloom take turns in one set of channels, which a bound on hops would leave full); choose " +
                    others + ", or leave --hops out");
    }
}

/// The least number of insertions, deletions, replacements and swaps of neighbours that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b)
{
    std::vector<std::size_t> before_last, last, row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        before_last = std::exchange(last, row);
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before_last[j - 2] + 1);
        }
    }
    return row.back();
}

/// The remedy for an unknown option: the option that differs in at most a third of its letters, or begins like it.
std::string remedy_for(std::string_view unknown)
{
    std::string_view nearest;
    std::size_t least = 100; // more than every name's length
    if (unknown.size() < least)
        for (auto const& option : options) {
            auto distance = edit_distance(unknown, option.name);
            if (unknown.size() > 3 && option.name.starts_with(unknown)) distance = 1;
            if (distance < least && 3 * distance <= option.name.size()) {
                least = distance;
                nearest = option.name;
            }
        }
    if (nearest.empty()) return "see render_map --help";
    return "write " + std::string(nearest) + ", or see render_map --help";
}

} // namespace

Options parse_options(std::span<char const* const> words)
{
    Options result;
    std::vector<std::string_view> given;
    bool options_end = false;
    for (std::size_t i = 0; i < words.size(); ++i) {
        std::string_view const word = words[i];
        if (options_end || !word.starts_with('-')) {
            result.maps.push_back(input(result, "the map's name", word));
            continue;
        }
        if (word == "--") {
            options_end = true;
            continue;
        }

        auto const equals = word.find('=');
        auto const name = word == "-h" ? std::string_view("--help") : word.substr(0, equals);
        auto const* const option = std::find_if(
            std::begin(options), std::end(options), [&](Option const& o) { return o.name == name; });
        if (option == std::end(options))
            throw Error("there is no option " + shared::one_line(std::string(name), 60) + " (render_map does not know it); " +
                        remedy_for(name));
        if (std::find(given.begin(), given.end(), option->name) != given.end())
            throw Error(std::string(name) + " is given twice (which one counts is not said); leave one out");
        given.push_back(option->name);

        std::string_view text;
        if (option->value.empty()) {
            if (equals != std::string_view::npos)
                throw Error(std::string(name) + " takes no value (it is there or not); write " + std::string(name) +
                            " alone");
        } else if (equals != std::string_view::npos) {
            text = word.substr(equals + 1);
        } else if (i + 1 < words.size() && !std::string_view(words[i + 1]).starts_with("--")) {
            text = words[++i];
        } else {
            throw Error(std::string(name) + " has no value (it takes " + std::string(option->value) +
                        "); write it behind the option, or behind = where it begins with --");
        }
        auto const inputs = result.inputs.size();
        option->set(result, option->name, text);
        bool const is_input = result.inputs.size() != inputs;
        if (std::find(std::begin(beside_frames), std::end(beside_frames), option->name) == std::end(beside_frames))
            result.shaping.push_back(std::string(option->name) + (option->value.empty() || is_input ? "" : "=" + std::string(text)));
        if (result.help || result.version) return result;
    }

    if (result.renderer.threads == 0 ||
        std::find(given.begin(), given.end(), "--threads") == given.end())
        result.renderer.threads = result.choice.engine == EngineKind::sequential
                                      ? 1
                                      : std::clamp(std::thread::hardware_concurrency() / ranks::on_this_host(), 1u,
                                                   most_threads);
    for (std::size_t k = 0; result.maps.size() > 1 && k < result.maps.size(); ++k)
        result.shaping.push_back("map " + std::to_string(k + 1) + " " + result.maps[k].lexically_normal().filename().string());
    check_together(result, given);
    check_ranks(result);
    result.choice.stays_anchored = result.renderer.program == tilemesh::report::Program::anchored || !only_anchored(result).option.empty();
    return result;
}

std::string version_text()
{
    return "render_map (tilemesh) " + std::to_string(TILEMESH_VERSION / 10000) + "." +
           std::to_string(TILEMESH_VERSION / 100 % 100) + "." + std::to_string(TILEMESH_VERSION % 100) + "\n";
}

std::string help_text()
{
    std::string text = "render_map [MAP ...] [options]\n"
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
    for (auto const& option : options) {
        for (auto const& group : groups)
            if (group.first == option.name) text.append("\n").append(group.title).append("\n");
        std::string line = "  ";
        line.append(option.name).append(" ").append(option.value);
        line.resize(std::max<std::size_t>(line.size() + 1, 24), ' ');
        text.append(line).append(option.help).append("\n");
    }
    return text + "\n"
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
                  "  Machines: a line `machine NAME`, then one number per line, `NUMBER VALUE UNIT SOURCE`, as\n"
                  "  examples/machines/bow.txt: tiles, SRAM, code, workers, clock, barrier, exchange. A preset that\n"
                  "  does not fit there gets smaller channels, and storage takes the rest. The report names the machine.\n"
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
}

} // namespace render_map
