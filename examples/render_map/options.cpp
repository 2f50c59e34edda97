#include "options.hpp"
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <thread>
#include <tilemesh/error.hpp>
#include <vector>

namespace render_map {

namespace {

using tilemesh::Error;

// --- values ------------------------------------------------------------------------------------

std::uint32_t whole_number(std::string_view option, std::string_view text, std::uint32_t most)
{
    std::uint32_t value = 0;
    auto const [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value == 0 || value > most)
        throw Error(std::string(option) + " cannot be \"" + std::string(text) +
                    "\" (it takes a whole number from 1 to " + std::to_string(most) +
                    "); write for example " + std::string(option) + " 1");
    return value;
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
        throw Error(std::string(option) + " cannot be \"" + std::string(text) +
                    "\" (it takes WxH, two whole numbers from 1 to 65535); write for example " +
                    std::string(option) + " " + example);
    return result;
}

double degrees(std::string_view option, std::string_view text)
{
    double value = 0;
    auto const digits = text.substr(text.starts_with('+') ? 1 : 0);
    auto const [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value))
        throw Error(std::string(option) + " cannot be \"" + std::string(text) +
                    "\" (it takes degrees a frame, a number); write for example " +
                    std::string(option) + " 0.5");
    return value;
}

std::filesystem::path file(std::string_view option, std::string_view text)
{
    if (text.empty())
        throw Error(std::string(option) +
                    " cannot be empty (it takes a name in the file system); name one");
    return text;
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
    throw Error(std::string(option) + " cannot be \"" + std::string(text) + "\" (there are " +
                choices + "); choose one of these");
}

// --- options -----------------------------------------------------------------------------------

struct Option {
    std::string_view name;
    std::string_view value; ///< what the help calls it; empty: the option takes none
    std::string_view help;
    void (*set)(Options&, std::string_view option, std::string_view text);
};

/// Most frames of an orbit: beyond it the list of cameras alone takes more memory than a large map.
constexpr std::uint32_t most_frames = 1'000'000;
/// More threads than any host that this runs on has; a typing error should not start a million.
constexpr std::uint32_t most_threads = 1024;

constexpr Option options[] = {
    {"--cameras", "FILE", "cameras from a JSON file; without --camera all of the map's scene",
     [](Options& o, auto name, auto text) { o.cameras = file(name, text); }},
    {"--camera", "SCENE/NAME", "one camera of that file; NAME alone where it is unique",
     [](Options& o, auto, auto text) { o.camera = text; }},
    {"--orbit", "DEGREES", "turn the camera about the map's middle, so far a frame",
     [](Options& o, auto name, auto text) { o.orbit_degrees = degrees(name, text); }},
    {"--frames", "N", "frames of the orbit",
     [](Options& o, auto name, auto text) { o.frames = whole_number(name, text, most_frames); }},
    {"--trajectory", "FILE", "one frame a pose of a TUM trajectory (camera to world)",
     [](Options& o, auto name, auto text) { o.trajectory = file(name, text); }},
    {"--relative", "", "the trajectory's motion since its first pose, on top of the camera",
     [](Options& o, auto, auto) { o.relative = true; }},
    {"--size", "WxH", "pixels [the camera's own; 1280x720 where none is named]",
     [](Options& o, auto name, auto text) {
         auto const [width, height] = extent(name, text, "1280x720");
         o.size = tilemesh::scene::Size{width, height};
     }},

    {"--preset", "NAME", "lossless | paper | prototype [lossless]",
     [](Options& o, auto name, auto text) {
         o.choice.preset = one_of<Preset>(name, text,
                                          {{"lossless", Preset::lossless},
                                           {"paper", Preset::paper},
                                           {"prototype", Preset::prototype}});
     }},
    {"--machine", "NAME", "mk2 | test: 64 MiB a tile, any number of tiles [mk2]",
     [](Options& o, auto name, auto text) {
         o.choice.machine = one_of<MachineKind>(
             name, text, {{"mk2", MachineKind::mk2}, {"test", MachineKind::test}});
     }},
    {"--grid", "WxH", "tiles [40x36, or what --size and --tile need]",
     [](Options& o, auto name, auto text) { o.renderer.grid = extent(name, text, "40x36"); }},
    {"--tile", "WxH", "pixels of a tile [the frame spread evenly over the grid]",
     [](Options& o, auto name, auto text) { o.renderer.tile = extent(name, text, "32x20"); }},
    {"--channel-slots", "N", "at most N records in a channel [the preset's]",
     [](Options& o, auto name, auto text) {
         o.renderer.channel_slots = whole_number(name, text, 0xffffffffu);
     }},
    {"--storage-slots", "N", "at most N records on a tile [the preset's]",
     [](Options& o, auto name, auto text) {
         o.renderer.storage_slots = whole_number(name, text, 0xffffffffu);
     }},
    {"--saturation", "NAME", "hold | drop [the preset's]",
     [](Options& o, auto name, auto text) {
         o.choice.saturation = one_of<SaturationKind>(
             name, text, {{"hold", SaturationKind::hold}, {"drop", SaturationKind::drop}});
     }},
    {"--footprint", "NAME", "opacity_box | three_sigma_square [the preset's]",
     [](Options& o, auto name, auto text) {
         using tilemesh::splat::Footprint;
         o.renderer.footprint =
             one_of<Footprint>(name, text,
                               {{"opacity_box", Footprint::opacity_box},
                                {"three_sigma_square", Footprint::three_sigma_square}});
     }},
    {"--copies", "NAME", "world | screen: what bloom sends [the preset's]",
     [](Options& o, auto name, auto text) {
         o.choice.copies = one_of<CopiesKind>(
             name, text, {{"world", CopiesKind::world}, {"screen", CopiesKind::screen}});
     }},
    {"--hops", "N|quiet", "supersteps of routing, and of bloom, a frame [quiet]",
     [](Options& o, auto name, auto text) {
         if (text != "quiet") o.renderer.hops = whole_number(name, text, 0xfffffffeu);
     }},
    {"--pixels", "NAME", "float | rgbx8 [the preset's]",
     [](Options& o, auto name, auto text) {
         o.choice.pixels = one_of<PixelKind>(
             name, text, {{"float", PixelKind::float32}, {"rgbx8", PixelKind::rgbx8}});
     }},
    {"--arithmetic", "NAME", "precise; fast is not in this version [precise]",
     [](Options&, auto name, auto text) {
         if (text == "fast")
             throw Error("--arithmetic cannot be \"fast\" (it is not available in this version); "
                         "choose precise");
         (void)one_of<int>(name, text, {{"precise", 0}});
     }},

    {"--engine", "NAME", "threads | sequential: slower, checks every write [threads]",
     [](Options& o, auto name, auto text) {
         o.choice.engine = one_of<EngineKind>(
             name, text,
             {{"threads", EngineKind::threads}, {"sequential", EngineKind::sequential}});
     }},
    {"--threads", "N", "host threads [all of this machine's]",
     [](Options& o, auto name, auto text) {
         o.renderer.threads = whole_number(name, text, most_threads);
     }},

    {"--out", "DIR", "where frame_0000.png ... go [tilemesh_out]",
     [](Options& o, auto name, auto text) { o.out = file(name, text); }},
    {"--float", "", "also frame_0000.pfm: linear float32, unclamped, on black",
     [](Options& o, auto, auto) { o.pfm = true; }},
    {"--reference", "", "also render in double, with and without cut-offs, and compare (slow)",
     [](Options& o, auto, auto) { o.reference = true; }},
    {"--report", "FILE", "everything counted, as JSON",
     [](Options& o, auto name, auto text) { o.report = file(name, text); }},
    {"--quiet", "", "no progress, no table",
     [](Options& o, auto, auto) { o.quiet = true; }},
    {"--help", "", "this text", [](Options& o, auto, auto) { o.help = true; }},
};

/// Options that begin a group of the help, and the group's title.
constexpr struct {
    std::string_view first, title;
} groups[] = {{"--cameras", "What to see"},
              {"--preset", "The machine and its rules"},
              {"--engine", "The host"},
              {"--out", "What comes out"}};

/// What no single option can know: which of them go together.
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
    needs("--frames", "--orbit", "it counts the frames of an orbit");
    needs("--orbit", "--frames", "an orbit has as many frames as you ask for");
    needs("--relative", "--trajectory", "it says how to read a trajectory");
    if (o.orbit_degrees && o.trajectory)
        throw Error("--orbit and --trajectory are both given (each moves the camera); choose one");
    if (o.choice.engine == EngineKind::sequential && is_given("--threads") &&
        o.renderer.threads != 1)
        throw Error("--threads " + std::to_string(o.renderer.threads) +
                    " and --engine sequential are both given (that engine has one thread); leave "
                    "one of them out");

    auto const own = describe(o.choice);
    auto const at_most = [&](std::string_view option, std::uint32_t asked, std::uint32_t most) {
        if (asked > most)
            throw Error(std::string(option) + " cannot be " + std::to_string(asked) + " (preset " +
                        own.preset + " on machine " + own.machine + " has " +
                        std::to_string(most) + "); choose fewer, or another preset or machine");
    };
    at_most("--storage-slots", o.renderer.storage_slots, own.storage_slots);
    at_most("--channel-slots", o.renderer.channel_slots, own.channel_slots);
}

} // namespace

Options parse_options(std::span<char const* const> words)
{
    Options result;
    std::vector<std::string_view> given;
    for (std::size_t i = 0; i < words.size(); ++i) {
        std::string_view const word = words[i];
        if (!word.starts_with('-')) {
            if (!result.map.empty())
                throw Error("two maps, " + result.map.string() + " and " + std::string(word) +
                            " (one run renders one map); name one");
            result.map = file("the map's name", word);
            continue;
        }

        auto const equals = word.find('=');
        auto const name = word == "-h" ? std::string_view("--help") : word.substr(0, equals);
        auto const* const option = std::find_if(
            std::begin(options), std::end(options), [&](Option const& o) { return o.name == name; });
        if (option == std::end(options))
            throw Error("there is no option " + std::string(name) +
                        " (render_map does not know it); see render_map --help");
        if (std::find(given.begin(), given.end(), option->name) != given.end())
            throw Error(std::string(name) + " is given twice (which one counts is not said); leave "
                                            "one out");
        given.push_back(option->name);

        std::string_view text;
        if (option->value.empty()) {
            if (equals != std::string_view::npos)
                throw Error(std::string(name) + " takes no value (it is there or not); write " +
                            std::string(name) + " alone");
        } else if (equals != std::string_view::npos) {
            text = word.substr(equals + 1);
        } else if (i + 1 < words.size() && !std::string_view(words[i + 1]).starts_with("--")) {
            text = words[++i];
        } else {
            throw Error(std::string(name) + " has no value (it takes " +
                        std::string(option->value) + "); write it behind the option");
        }
        option->set(result, option->name, text);
    }
    if (result.help) return result;

    if (result.renderer.threads == 0 ||
        std::find(given.begin(), given.end(), "--threads") == given.end())
        result.renderer.threads = result.choice.engine == EngineKind::sequential
                                      ? 1
                                      : std::clamp(std::thread::hardware_concurrency(), 1u,
                                                   most_threads);
    check_together(result, given);
    return result;
}

std::string help_text()
{
    std::string text =
        "render_map [MAP.ply] [options]\n"
        "Renders a 3D Gaussian map on a simulated mesh of tiles, each with its own SRAM and four\n"
        "neighbours. Without a map: the built-in desk.\n\n"
        "  render_map                                          the built-in map, one picture\n"
        "  render_map room.ply --orbit 0.5 --frames 60         walk around a map of your own\n"
        "  render_map room.ply --preset paper --reference --report report.json\n"
        "                                                      what the paper's machine loses\n";
    for (auto const& option : options) {
        for (auto const& group : groups)
            if (group.first == option.name) text.append("\n").append(group.title).append("\n");
        std::string line = "  ";
        line.append(option.name).append(" ").append(option.value);
        line.resize(std::max<std::size_t>(line.size() + 1, 24), ' ');
        text.append(line).append(option.help).append("\n");
    }
    return text + "\nOptions take their value as the next word or behind '='. Exit status: 0; 2 "
                  "with one line on\nstandard error when something is wrong.\n";
}

} // namespace render_map
