// The C interface of tilemesh.h over the renderer that serves all presets.
#define TILEMESH_C_EXPORT
#include "tilemesh.h"
#include "../render_map/followed_facts.hpp"
#include "../render_map/instruments.hpp"
#include "../render_map/missing.hpp"
#include "../shared/codecs.hpp"
#include "../shared/option_json.hpp"
#include "../shared/option_table.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <glm/vec3.hpp>
#include <istream>
#include <iterator>
#include <limits>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <streambuf>
#include <string>
#include <string_view>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/render/describe.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/renderer_fields.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/render/setup_fields.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/json.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/lens.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/splat/quality.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <utility>
#include <vector>
#if defined(__EMSCRIPTEN__)
#    include <emscripten/heap.h>
#else
#    include <tilemesh/render/homes_renderer.hpp>
#    include <tilemesh/scene/camera_json.hpp>
#    include <tilemesh/scene/named_camera.hpp>
#    include <tilemesh/track/depth_misfit.hpp>
#    include <tilemesh/track/pose_evaluator.hpp>
#    include <tilemesh/track/tracker.hpp>
#endif

namespace {

namespace render = tilemesh::render;
namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
using Json = nlohmann::ordered_json;
using shared::Option;
using shared::option;
using shared::Word;
using tilemesh::Error;
using tilemesh::RendererOptions, tilemesh::Extent2;
using tilemesh::render::setup_field, tilemesh::render::setup_fields;

/// The page has one thread and no files, and leaves out the program of homes and the tracker.
#if defined(__EMSCRIPTEN__)
constexpr bool is_page = true;
#else
constexpr bool is_page = false;
#endif

/// Something that a frame has and that was not rendered.
struct NoFrame : Error {
    using Error::Error;
};
/// Something that this build of the library leaves out.
struct NotBuilt : Error {
    using Error::Error;
};

/// All presets on all machines, with a trace: the modelled time and most of the heat maps come from it.
using Core = render::HostRenderer;
using Policies = Core::Policies;

std::string dumped(Json const& json)
{
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// --- settings --------------------------------------------------------------------------------------------------------------

struct Settings {
    std::uint32_t width = 640, height = 360, mesh = 0;
    RendererOptions renderer; ///< what its rows set; `options_of` adds what others do
    std::string preset = "lossless", machine = "mk2", quality = "default", program = "anchored", lens = "pinhole";
    std::vector<render::SetupValue> fields; ///< those that every program has; others are the preset's
    std::array<double, 3> background{};
    bool difference = false, depth = false, alpha = false, exposure = false, antialias = false;
    std::int64_t follow = -1;

    bool operator==(Settings const&) const = default;
    /// Do both need the same mesh?
    bool same_mesh(Settings other) const
    {
        other.difference = difference, other.exposure = exposure, other.follow = follow, other.background = background, other.lens = lens;
        return *this == other;
    }
    bool anchored() const { return program == "anchored"; }
};

constexpr Word nobody[] = {{"-1", -1}};

/// The name of a setting in JSON; rows of tables of fields have hyphens.
std::string json_name(shared::OptionRow const& row)
{
    std::string name(row.name);
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}
/// The row of a field that every program has: its words, and "preset".
template <std::size_t Field, std::size_t... I>
constexpr std::array<Word, sizeof...(I) + 1> with_preset(std::index_sequence<I...>)
{
    return {{{"preset", -1}, setup_fields[Field].values.words[I]...}};
}
template <std::size_t Field>
constexpr auto policy_words = with_preset<Field>(std::make_index_sequence<setup_fields[Field].values.words.size()>());
template <std::size_t Field>
constexpr Option<Settings> policy()
{
    auto row = shared::listed<Field, &Settings::fields>({});
    row.words = policy_words<Field>;
    row.set = [](Settings& s, shared::OptionValue const& value) {
        auto const name = setup_fields[Field].name;
        auto const at = std::find_if(s.fields.begin(), s.fields.end(), [name](auto const& f) { return f.name == name; });
        if (at != s.fields.end()) at->text = value.text;
        else s.fields.emplace_back(name, value.text);
        std::erase_if(s.fields, [](auto const& f) { return f.text == "preset"; });
    };
    row.get = [](Settings const& s) {
        auto const at = std::find_if(s.fields.begin(), s.fields.end(), [](auto const& f) { return f.name == setup_fields[Field].name; });
        return shared::OptionValue{.text = at != s.fields.end() ? std::string_view(at->text) : "preset"};
    };
    return row;
}
constexpr auto policy_rows = shared::rows_of_everyone([](auto of) { return policy<of()>(); });

constexpr Option<Settings> own_rows[] = {
    option<&Settings::width>("width", "N", "Width of the picture", {16, 4096, "pixels"}),
    option<&Settings::height>("height", "N", "Height of the picture", {16, 4096, "pixels"}),
    option<&Settings::renderer, &RendererOptions::tile, &Extent2::width>(
        "tile_width", "N", "Width of a tile; 0: the picture is spread over 40 x 36 tiles", {0, 4096, "pixels"}),
    option<&Settings::renderer, &RendererOptions::tile, &Extent2::height>(
        "tile_height", "N", "Height of a tile; 0: the picture is spread over 40 x 36 tiles", {0, 4096, "pixels"}),
    shared::field<setup_field("channel-slots"), &Settings::renderer, &RendererOptions::channel_slots>("", {}),
    shared::field<setup_field("storage-slots"), &Settings::renderer, &RendererOptions::storage_slots>("", {}),
    shared::field<setup_field("waiting-slots"), &Settings::renderer, &RendererOptions::waiting_slots>("", {}),
    option<&Settings::mesh>("mesh", "N", "Number of the mesh; another number begins a new one", {0, 1'000'000}),
    option<&Settings::renderer, &RendererOptions::threads>("threads", "N", "Threads of the host; the picture does not depend on them",
                                                           {1, is_page ? 1 : 256}),
    shared::field<setup_field("preset"), &Settings::preset>("", {}),
    shared::field<setup_field("machine"), &Settings::machine>("", {}),
    shared::field<setup_field("quality"), &Settings::quality>("", {}),
    shared::field<setup_field("program"), &Settings::program>("", {}),
    option<&Settings::lens>("lens", "KIND[,N...]", "The lens of the cameras, as render_map's --lens", {0, 255}),
    option<&Settings::background>("background", "R,G,B", "The colour behind the Gaussians", {0, 1}),
    option<&Settings::difference>("difference", "", "Compares each frame with the complete picture"),
    option<&Settings::renderer, &RendererOptions::digest>("digest", "", "The report has digests of the machine's words"),
    option<&Settings::depth>("depth", "", "Frames have the plane of depths"),
    option<&Settings::alpha>("alpha", "", "Frames have the plane of covered shares"),
    option<&Settings::exposure>("exposure", "", "A tracker also finds gain and offset"),
    option<&Settings::antialias>("antialias", "", "Dims each splat as much as the 0.3 pixels enlarge it, for maps trained so"),
    option<&Settings::follow>("follow", "ID", "Id of the Gaussian whose path is recorded; -1: none", {0, 4294967295.0}, nobody, "-1",
                              "it is the id of a Gaussian, or -1")};
constexpr auto renderer_rows = [] {
    auto rows = shared::rows_of_renderer<&Settings::renderer>();
    for (auto& row : rows) row.least = 0; // 0 stands for the word
    return rows;
}();
constexpr auto setting_rows = [] {
    return []<std::size_t... I, std::size_t... J, std::size_t... K>(std::index_sequence<I...>, std::index_sequence<J...>, std::index_sequence<K...>)
    {
        return std::array{own_rows[I]..., renderer_rows[J]..., policy_rows[K]...};
    }
    (std::make_index_sequence<std::size(own_rows)>(), std::make_index_sequence<std::size(renderer_rows)>(),
     std::make_index_sequence<std::size(policy_rows)>());
}();
/// Options of render_map's maps and cameras that are no settings here, and why.
constexpr std::pair<char const*, char const*> no_settings[] = {
    {"turn", "the caller's cameras look at a map from any side"},
    {"sh_degree", "a map keeps the colours that it is loaded with; cut them in the file, or with render_map --sh-degree"},
    {"near", "number 16 of a camera is its near plane"}};
bool is_slots(shared::OptionRow const& row)
{
    return row.unit == "slots" && row.words.empty();
}

/// The slots of a tile on the machine `test`. render_map's has 40,000, which is more memory than a browser gives a page.
constexpr std::uint32_t test_slots = 8000;

splat::Tiling tiling_of(Settings const& settings)
{
    return tilemesh::tiling_for(settings.renderer, settings.width, settings.height);
}
/// The setup on a machine with room for so many records on a tile, and for its pixels.
render::Setup roomy(render::Setup setup, splat::Tiling const& tiling, std::uint32_t slots)
{
    setup.machine = tilemesh::size_of_machine<splat::RoomyMachine>();
    setup.sizes.storage = slots;
    setup.sizes.tile_pixels = std::max(setup.sizes.tile_pixels, tiling.tile_width * tiling.tile_height);
    setup.sizes.lists_fit = true;
    return setup;
}

/// The setup that the settings name, as render_map makes it of the same options.
render::Setup setup_of(Settings const& settings, std::uint32_t sh_degree)
{
    auto fields = settings.fields;
    fields.emplace_back("preset", settings.preset);
    auto setup = render::fitted(with(splat::lossless, fields), sh_degree, true, true);
    if (settings.machine == "test") setup = roomy(setup, tiling_of(settings), test_slots);
    return settings.depth || settings.alpha ? render::with_planes(setup, settings.depth, settings.alpha) : setup;
}
std::uint32_t preset_slots(splat::Sizes const& sizes, std::string_view name)
{
    return name == "channel_slots" ? std::min(sizes.road, sizes.beam) : name == "storage_slots" ? sizes.storage : name == "waiting_slots" ? sizes.waiting : 0;
}
tilemesh::RendererOptions options_of(Settings const& settings)
{
    auto options = settings.renderer;
    if (settings.antialias) options.coverage = splat::Coverage::preserved;
    auto const number = [](std::size_t of, std::string const& word) { return static_cast<std::uint32_t>(*setup_fields[of].values.read(word)); };
    if (settings.quality != "default") options.quality = static_cast<splat::Quality>(number(setup_field("quality"), settings.quality));
    options.program = static_cast<report::Program>(number(setup_field("program"), settings.program));
    return options;
}

/// The choice of homes of the same machine, pixels and rules.
render::Setup homes_of(Settings const& settings, std::uint32_t sh_degree)
{
    auto const setup = setup_of(settings, sh_degree);
    auto homes = splat::as_homes(setup);
    homes.district = 1;
    if (settings.machine == "test") homes.sizes.storage = setup.sizes.storage;
    return homes;
}
/// Throws Error unless homes can render with these settings. Returns whether nothing keeps `auto` on the anchored program.
bool check_homes([[maybe_unused]] Settings const& settings, [[maybe_unused]] scene::Map const& map)
{
#if defined(__EMSCRIPTEN__)
    throw NotBuilt("the program " + settings.program + " (this build has only the anchored program); set program to \"anchored\"");
#else
    if (settings.difference || settings.follow > 0)
        throw Error("the program " + settings.program + " with " + (settings.difference ? "difference" : "follow") +
                    " (only the anchored program has it); set program to \"anchored\", or leave it out");
    auto const only = render::only_anchored(setup_of(settings, map.sh_degree), settings.renderer);
    if (settings.program != "homes") return !only;
    if (only)
        throw Error("the program homes with " + only.text() + "; leave it out, or set program to \"anchored\"");
    auto const choice = homes_of(settings, map.sh_degree);
    auto const options = options_of(settings);
    render::check_limits(choice, options);
    (void)render::layout_homes(choice, options, {settings.width, settings.height}, map.gaussians.size());
    return true;
#endif
}

/// Throws Error unless a renderer with these settings can be made for this map.
void check(Settings const& settings, scene::Map const& map)
{
    bool const may_change = !settings.anchored() && check_homes(settings, map);
    for (auto const& field : render::renderer_fields)
        if (!may_change && settings.program != "homes" && field.get(settings.renderer) != field.get({}) &&
            std::find(std::begin(render::only_homes), std::end(render::only_homes), field.name) != std::end(render::only_homes))
            throw Error("the setting " + std::string(field.name) +
                        " with the anchored program (only the program of homes has it); leave it out, or set program to \"homes\"");
    (void)scene::lens_of_text(settings.lens);
    if (settings.program == "homes") return;
    auto const setup = setup_of(settings, map.sh_degree);
    auto const facts = render::checked(setup);
    for (auto const& row : setting_rows) {
        auto const most = preset_slots(setup.sizes, json_name(row));
        if (auto const asked = row.get(settings).whole; is_slots(row) && asked > most)
            throw Error("the setting " + json_name(row) + " of " + std::to_string(asked) + " (preset " + setup.name + " has " +
                        std::to_string(most) + "); give it a smaller number, or 0 for the preset's");
    }
    if ((settings.renderer.tile.width == 0) != (settings.renderer.tile.height == 0))
        throw Error("a tile with one side of 0 pixels (0 means that the picture is spread over the grid); give both sides, or none");
    render::check_hops(setup, settings.renderer.hops);
    if (!may_change) // else homes render a frame whose pixels have no room
        (void)render::layout_frame({{}, settings.renderer.tile}, settings.width, settings.height, facts.machine, facts.sizes.tile_pixels, facts.name);
}

/// The settings after a JSON object changed some of them.
Settings changed(Settings settings, std::string_view text)
{
    auto const json = shared::json_of(text, "the text of the settings");
    if (!json.is_object())
        throw Error(std::string("settings that are no object (they are a JSON ") + json.type_name() + "); give an object such as {\"channel_slots\": 8}");
    for (auto const& [name, value] : json.items()) {
        auto const shown = value.is_structured() ? std::string("a JSON ") + value.type_name() : dumped(value).substr(0, 60); // a dump recurses
        auto const refuse = [&name = name, &shown](std::string const& why) {
            throw Error("the setting " + dumped(name).substr(0, 60) + " of " + shown + " (" + why + "); see tilemesh_set in tilemesh.h");
        };
        auto const row = std::find_if(setting_rows.begin(), setting_rows.end(), [&name = name](auto const& one) { return json_name(one) == name; });
        for (auto const& [other, why] : no_settings)
            if (name == other) refuse(std::string("it is none: ") + why);
        if (row == setting_rows.end()) {
            std::vector<std::string> names;
            for (auto const& one : setting_rows) names.push_back(json_name(one));
            auto const near = shared::nearest(name, {names.begin(), names.end()});
            refuse("there is no such setting" + (near.empty() ? "" : ", but there is " + std::string(near)));
        }
        try {
            set_from_json(settings, *row, value);
        } catch (shared::Misfit const& misfit) {
            refuse(misfit.why);
        }
    }
    return settings;
}

// --- input -----------------------------------------------------------------------------------------------------------------

/// A stream over bytes that somebody else owns.
class Bytes : public std::streambuf {
public:
    Bytes(void const* bytes, std::size_t length)
    {
        auto* const first = static_cast<char*>(const_cast<void*>(bytes));
        setg(first, first, first + length);
    }

protected:
    pos_type seekoff(off_type by, std::ios_base::seekdir from, std::ios_base::openmode) override
    {
        auto const base = from == std::ios_base::beg ? eback() : from == std::ios_base::cur ? gptr() : egptr();
        off_type const to = (base - eback()) + by;
        if (to < 0 || to > egptr() - eback()) return pos_type(off_type(-1));
        setg(eback(), eback() + to, egptr());
        return pos_type(to);
    }
    pos_type seekpos(pos_type to, std::ios_base::openmode mode) override { return seekoff(off_type(to), std::ios_base::beg, mode); }
};

/// `origin`: what the reader subtracted from the means of the map.
splat::Camera camera_of(double const* numbers, Settings const& settings, std::array<double, 3> const& origin)
{
    if (numbers == nullptr) throw Error("no camera (its address is null); give 17 numbers");
    std::array<float, 17> f{};
    for (std::size_t i = 0; i < f.size(); ++i) {
        f[i] = static_cast<float>(numbers[i] - (i >= 9 && i < 12 ? origin[i - 9] : 0.0));
        if (!std::isfinite(numbers[i]) || !std::isfinite(f[i]))
            throw Error("number " + std::to_string(i) + " of a camera is not finite (a float must hold it); correct the camera");
    }
    splat::Camera camera{};
    for (std::size_t i = 0; i < 9; ++i) camera.rotation[i / 3][i % 3] = f[i];
    for (std::size_t i = 0; i < 3; ++i) camera.position[i] = f[9 + i];
    camera.fx = f[12], camera.fy = f[13], camera.cx = f[14], camera.cy = f[15];
    camera.near_depth = f[16];
    camera.lens = scene::lens_of_text(settings.lens);
    camera.width = settings.width, camera.height = settings.height;
    render::check_camera(camera);
    return camera;
}
/// The 17 numbers of a camera, in the coordinates of the map's file.
std::array<double, 17> numbers_of(splat::Camera const& camera, std::array<double, 3> const& origin)
{
    std::array<double, 17> numbers{};
    for (std::size_t i = 0; i < 9; ++i) numbers[i] = double{camera.rotation[i / 3][i % 3]};
    for (std::size_t i = 0; i < 3; ++i) numbers[9 + i] = double{camera.position[i]} + origin[i];
    std::size_t at = 12;
    for (float const v : {camera.fx, camera.fy, camera.cx, camera.cy, camera.near_depth}) numbers[at++] = double{v};
    return numbers;
}

#if !defined(__EMSCRIPTEN__)
// --- the tracker ------------------------------------------------------------------------------------------------------------

/// A tracker of one map, with its mesh. The poses are those of the map without its origin.
class Tracking {
public:
    Tracking(scene::Map const& map, Settings const& settings, splat::Camera const& start, bool with_depth)
        : size_{settings.width, settings.height}, with_depth_(with_depth), lens_(scene::lens_of(start)), scale_(scale_of(map, settings, start)),
          evaluate_(map, {size_.width, size_.height}, {settings.renderer.threads, {}}),
          tracker_(lens_, scale_, scene::pose_of(start), options(with_depth))
    {
        if (settings.antialias) evaluate_.rules().coverage = splat::Coverage::preserved;
        auto& how = evaluate_.options();
        how.with_depth = with_depth;
        how.with_exposure = settings.exposure;
        how.scene_depth = static_cast<float>(scale_);
    }

    Json track(float const* rgb, float const* depth, std::size_t pixels, double seconds, std::array<double, 3> const& origin,
               double* camera)
    {
        auto const all = std::size_t{size_.width} * size_.height;
        if (rgb == nullptr) throw Error("no picture to track (its address is null); give 3 floats a pixel");
        if (pixels != all)
            throw Error("a picture of " + std::to_string(pixels) + " pixels (the tracker began with " + std::to_string(size_.width) +
                        " x " + std::to_string(size_.height) + ", which are " + std::to_string(all) +
                        "); give a picture of that size, or begin again");
        if (with_depth_ && depth == nullptr)
            throw Error("no depth of the picture (its address is null, and the tracker began with depth); give one, or begin without");
        if (!std::isfinite(seconds))
            throw Error("a time stamp that is not finite (the prediction needs the time between frames); give seconds");
        // A map may shine beyond 1, and resampling swings a little below 0.
        if (auto const* const odd = std::find_if(rgb, rgb + 3 * all, [](float v) { return v < -0.5f || v > 2.0f; }); odd != rgb + 3 * all)
            throw Error("a picture with a colour of " + tilemesh::number_text(double{*odd}) +
                        " (colours are 0 to 1, and at most 2 where a map shines); " +
                        (*odd < 0 ? "bring its range to 0 to 1" : "divide levels of 0 to 255 by 255"));
        tilemesh::track::TrackTarget target{report::Image(size_.width, size_.height), {}};
        std::copy(rgb, rgb + 3 * all, target.colour.rgb.begin());
        if (with_depth_) {
            target.depth = report::Plane(size_.width, size_.height);
            std::copy(depth, depth + all, target.depth.values.begin());
            // The first picture's view is about that of the first camera.
            auto const misfit = is_first_ ? tilemesh::track::depth_misfit(target.depth, scale_, 10.0) : std::string();
            if (!misfit.empty())
                throw Error("a depth that is not that of the map (" + misfit + "); give depths in units of the map, with their bytes in order");
        }
        is_first_ = false;
        evaluate_.set_target(std::move(target));
        auto const f = tracker_.track_at(evaluate_, seconds);
        auto const numbers = numbers_of(f.pose, origin);
        if (camera != nullptr) std::copy(numbers.begin(), numbers.end(), camera);
        return {{"verdict", tilemesh::track::name_of(f.verdict)}, {"why", f.why}, {"seconds", seconds}, {"camera", numbers},
                {"mean_cost", f.mean_cost}, {"evaluations", f.solution.evaluations},
                {"exposure", {{"log_gain", f.exposure.log_gain}, {"offset", f.exposure.offset}}}, {"median_depth", scale_}};
    }

private:
    static tilemesh::track::TrackerOptions options(bool with_depth)
    {
        tilemesh::track::TrackerOptions how;
        how.rows_per_pixel = with_depth ? 4.0 : 3.0;
        return how;
    }
    static double scale_of(scene::Map const& map, Settings const& settings, splat::Camera const& start)
    {
        auto const setup = render::with_planes(render::fitted(splat::setup_of<splat::Lossless>(), map.sh_degree, true, true), true, true);
        tilemesh::RendererOptions how;
        how.threads = settings.renderer.threads;
        auto const shown = Core(map, render::checked(setup), how, {}).render(start);
        auto const depth = tilemesh::track::median_depth(shown.depth, shown.alpha);
        if (!(depth > 0)) throw Error("the view of the first camera shows nothing of the map (no pixel is half covered); choose another camera");
        return depth;
    }
    /// In doubles, which a pose has and a camera of floats has not.
    std::array<double, 17> numbers_of(scene::Pose const& pose, std::array<double, 3> const& origin) const
    {
        std::array<double, 17> numbers{};
        for (int i = 0; i < 9; ++i) numbers[static_cast<std::size_t>(i)] = pose.rotation[i % 3][i / 3];
        for (int i = 0; i < 3; ++i) numbers[static_cast<std::size_t>(9 + i)] = pose.position[i] + origin[static_cast<std::size_t>(i)];
        std::size_t at = 12;
        for (double const v : {lens_.fx, lens_.fy, lens_.cx, lens_.cy, double{lens_.near_depth}}) numbers[at++] = v;
        return numbers;
    }

    scene::Size size_;
    bool with_depth_, is_first_ = true;
    scene::Intrinsics lens_;
    double scale_;
    tilemesh::track::PoseEvaluator evaluate_;
    tilemesh::track::Tracker tracker_;
};
#endif

// --- the machine, superstep by superstep -------------------------------------------------------------------------------------

/// A tile after a superstep in which it ran. The refusals, losses and pairs are those of the superstep.
struct TileAfter {
    std::uint32_t tile, records, copies, refused, dropped;
    std::uint64_t pairs;
};

/// The state of every tile through a frame, as changes. A tile that does not run does not change, so only the tiles that ran are read.
class Watch {
public:
    std::vector<std::vector<TileAfter>> supersteps; ///< of the last frame

    void begin_frame(std::uint32_t tiles)
    {
        supersteps.clear();
        seen_.assign(tiles, {});
    }
    void look(Core& core, tilemesh::SuperstepEvent const& event)
    {
        auto const& mesh = std::as_const(core.mesh());
        auto const grid = mesh.grid();
        if (seen_.size() != grid.size()) seen_.assign(grid.size(), {});
        // These steps neither add nor remove a slot.
        bool const same_slots = event.step == Core::Steps::composite || event.step == Core::Steps::depth_sort;
        auto& after = supersteps.emplace_back();
        auto const& ran = mesh.trace().supersteps.back().tiles;
        after.reserve(ran.size());
        for (auto const& sample : ran) {
            auto const tile = grid.tile(sample.tile);
            auto const& counts = mesh.template state<splat::Counts>(tile);
            auto& seen = seen_[sample.tile];
            if (event.step == Core::Steps::project) seen.refused = seen.dropped = 0; // it resets the tile's counters
            auto const refused = counts.by_channels() + counts.copies_refused;
            auto const dropped = counts.by_storage();
            auto const marks = mesh.template state<splat::Marks<Policies>>(tile);
            if (!same_slots) {
                std::uint32_t copies = 0;
                for (auto const& mark : marks) copies += mark.bits >> 8 & 1u; // Mark::copy, without a branch
                seen.copies = copies;
            }
            TileAfter now{sample.tile, marks.size(), seen.copies, refused - seen.refused, dropped - seen.dropped, 0};
            seen.refused = refused;
            seen.dropped = dropped;
            if (event.step == Core::Steps::composite)
                for (auto const evaluated : mesh.template state<splat::Work>(tile).evaluated)
                    now.pairs += std::uint64_t{evaluated} * splat::pairs_a_count;
            after.push_back(now);
        }
    }

private:
    struct Seen {
        std::uint32_t copies, refused, dropped;
    };
    std::vector<Seen> seen_; ///< by tiles: its copies, and what it has counted up to now
};
static_assert(splat::Mark::copy == 1u << 8, "Watch counts this bit");

std::string hexadecimal(std::uint64_t value)
{
    std::string text(16, '0');
    for (std::size_t i = 0; i < 16; ++i) text[15 - i] = "0123456789abcdef"[value >> (4 * i) & 15u];
    return text;
}
std::uint64_t digest_of(report::Image const& image)
{
    std::uint64_t digest = tilemesh::engine::mix(image.width, image.height);
    for (float const v : image.rgb) {
        std::uint32_t word;
        std::memcpy(&word, &v, sizeof word);
        digest = (digest ^ word) * 0x100000001b3u; // as engine::mix_words
    }
    return tilemesh::engine::mix(digest, image.rgb.size());
}
/// Of all exact numbers of the report, its losses and its digests.
std::uint64_t digest_of(report::FrameReport const& r)
{
    std::uint64_t digest = 0;
    for (auto const& field : report::report_fields)
        if (field.exact()) digest = tilemesh::engine::mix(digest, field.count(r));
    for (auto const& loss : r.lost) {
        digest = tilemesh::engine::mix(digest, std::uint64_t{static_cast<std::uint32_t>(loss.id)} << 32 | loss.tile);
        digest = tilemesh::engine::mix(digest, std::uint64_t{static_cast<std::uint32_t>(loss.cause)} << 32 | loss.full_tile);
    }
    for (auto const words : r.digests) digest = tilemesh::engine::mix(digest, words);
    return digest;
}
std::uint64_t memory_bytes()
{
#if defined(__EMSCRIPTEN__)
    return emscripten_get_heap_size();
#else
    return 0;
#endif
}

} // namespace

// --- the handle ------------------------------------------------------------------------------------------------------------

struct tilemesh_handle {
    tilemesh_handle() : model_(tilemesh::mk2()) {}
    tilemesh_handle(tilemesh_handle const&) = delete; // the core's observer points at it
    tilemesh_handle& operator=(tilemesh_handle const&) = delete;

    void load(char const* name, void const* bytes, std::size_t length)
    {
        auto map = bytes == nullptr ? scene::built_in_map() : read_map(name, bytes, length);
        take(std::move(map));
    }
    void load_file([[maybe_unused]] char const* path)
    {
        if (path == nullptr) throw Error("no map (the path is null); name a file, or a folder of SOG");
#if defined(__EMSCRIPTEN__)
        throw NotBuilt("a map in a file (this build has no files); give its bytes to tilemesh_load");
#else
        take(scene::load_map(std::filesystem::path(path), shared::codecs(), scene::FarMeans::moved));
#endif
    }
    void set(char const* json)
    {
        if (json == nullptr) return;
        ensure_map();
        auto settings = changed(settings_, json);
        check(settings, *map_);
        settings_ = std::move(settings);
    }
    void render_frame(double const* numbers)
    {
        ensure_map();
        auto const camera = camera_of(numbers, settings_, map_->origin);
        if (!renderer_ || !settings_.same_mesh(used_)) make_renderer();
        has_frame_ = false;
        auto& rules = renderer_->rules();
        for (std::size_t c = 0; c < 3; ++c) rules.background[c] = static_cast<float>(settings_.background[c]);
        watch_.begin_frame(0);
        follower_.begin_frame();
        cost_ = {};
        try {
            renderer_->render_into(camera, frame_);
        } catch (...) {
            if (!core_) renderer_.reset(); // homes and auto begin anew
            throw;
        }
        if (core_) cost_ = model_cost(model_, core_->trace(), core_->mesh().grid());
        used_ = settings_;
        camera_ = camera;
        complete_ = nullptr;
        if (settings_.difference) render_complete();
        describe();
        has_frame_ = true;
    }
    void begin_tracking([[maybe_unused]] double const* numbers, [[maybe_unused]] bool with_depth)
    {
#if defined(__EMSCRIPTEN__)
        throw NotBuilt("tracking (this build leaves it out); use the native library");
#else
        ensure_map();
        auto const camera = camera_of(numbers, settings_, map_->origin);
        tracking_.reset(); // first, because two machines may not fit into memory
        tracked_ = nullptr;
        tracking_ = std::make_unique<Tracking>(*map_, settings_, camera, with_depth);
#endif
    }
    void track([[maybe_unused]] float const* rgb, [[maybe_unused]] float const* depth, [[maybe_unused]] std::size_t pixels,
               [[maybe_unused]] double seconds, [[maybe_unused]] double* camera)
    {
#if defined(__EMSCRIPTEN__)
        throw NotBuilt("tracking (this build leaves it out); use the native library");
#else
        if (!tracking_) throw NoFrame("no tracker (none began with this map); call tilemesh_track_begin first");
        tracked_ = tracking_->track(rgb, depth, pixels, seconds, map_->origin, camera);
#endif
    }

    void const* pixels(std::string_view what)
    {
        need_frame();
        if (what == "rgb_float") return frame_.image.rgb.data();
        if (what == "rgba") return painted(frame_.image);
        if (what == "depth" || what == "alpha") {
            auto const& plane = what == "depth" ? frame_.depth : frame_.alpha;
            if (plane.values.empty())
                throw NoFrame("no picture \"" + std::string(what) + "\" of this frame (the setting " + std::string(what) +
                              " was false); set it to true and render again");
            return plane.values.data();
        }
        if (what != "difference" && what != "complete")
            throw Error("no picture \"" + std::string(what.substr(0, 40)) +
                        "\" (there are rgba, rgb_float, depth, alpha, difference and complete); name one of these");
        if (complete_ == nullptr)
            throw NoFrame("no picture \"" + std::string(what) +
                          "\" of this frame (the setting difference was false); set it to true and render again");
        return what == "complete" ? painted(*complete_) : painted_difference();
    }

    char const* report_text(std::string_view what)
    {
        if (what == "map") return answer(dumped(map_json()));
        if (what == "settings") return answer(dumped(settings_json()));
        if (what == "build") return answer(dumped(build_json()));
        if (what == "track") {
            if (tracked_.is_null()) throw NoFrame("no tracked frame (none was tracked on this map); call tilemesh_track first");
            return answer(dumped(tracked_));
        }
        if (what != "frame" && what != "run" && what != "supersteps" && what != "digest")
            throw Error("no report \"" + std::string(what.substr(0, 40)) +
                        "\" (there are map, settings, build, frame, run, supersteps, digest and track); name one of these");
        if (what == "supersteps") need_trace();
        need_frame();
        if (what == "digest") return answer(dumped({{"picture", hexadecimal(digest_of(frame_.image))}, {"counters", hexadecimal(digest_of(frame_.report))}}));
        if (what == "run") {
            auto run = run_;
            run.frames.front().image = "frame_0000.png"; // the file that render_map would write
            return answer(report::json_of(run).dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
        }
        return answer(dumped(what == "frame" ? frame_json() : supersteps_json()));
    }

    float const* heat(std::string_view what, int superstep);
    char const* tile(std::uint32_t index);
    char const* gaussian(std::uint32_t id);
    char const* trajectory(char const* name, void const* bytes, std::size_t length);
    char const* cameras(char const* path);

    /// Calls `act`, keeps its error, and returns its result, or `failed`.
    template <class T, class Act>
    T guarded(T failed, Act const& act) noexcept
    {
        try {
            error_.clear();
            code_ = TILEMESH_OK;
            return act();
        } catch (std::bad_alloc const&) {
            tell(TILEMESH_NO_MEMORY, "memory is short (the picture, the map or the machine is too large); use a smaller one");
        } catch (NoFrame const& why) {
            tell(TILEMESH_NO_FRAME, why.what());
        } catch (NotBuilt const& why) {
            tell(TILEMESH_NOT_BUILT, why.what());
        } catch (Error const& why) {
            tell(TILEMESH_BAD_INPUT, why.what());
        } catch (std::exception const& why) {
            tell(TILEMESH_FAULT, why.what(), "a fault of the library (", "); report it");
        } catch (...) {
            tell(TILEMESH_FAULT, "an error without a text (the program is at fault); report it");
        }
        return failed;
    }
    char const* error() const noexcept { return error_.c_str(); }
    int code() const noexcept { return code_; }

private:
    void tell(tilemesh_status code, char const* text, char const* before = "", char const* after = "") noexcept
    {
        code_ = code;
        try {
            error_ = as_utf8((std::string(before) + text + after).c_str());
            std::replace_if(error_.begin(), error_.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
        } catch (...) {
            error_.clear();
            for (char const* c = "memory is short"; *c != 0; ++c) error_ += *c; // fits without an allocation
        }
    }
    /// The text with U+FFFD in place of each byte that is no UTF-8, such as those of a file name or of a word that was cut.
    static std::string as_utf8(char const* text)
    {
        return Json::parse(dumped(Json(text))).get<std::string>();
    }
    static scene::Map read_map(char const* name, void const* bytes, std::size_t length)
    {
        if (length > static_cast<std::size_t>(std::numeric_limits<std::ptrdiff_t>::max()))
            throw Error("a map of " + std::to_string(length) + " bytes (no memory holds it); give the length of the file");
        Bytes buffer(bytes, length);
        std::istream stream(&buffer);
        return scene::read_map(stream, name != nullptr ? name : "a file", shared::codecs(), scene::FarMeans::moved);
    }
    void take(scene::Map map)
    {
        if (map.gaussians.empty())
            throw Error((map.path.empty() ? map.name : map.path) + " has no Gaussians that can be drawn (" + std::to_string(map.rejected) +
                        " rows are rejected); choose another map");
        check(settings_, map);
        map_ = std::move(map);
        forget();
    }
    void make_renderer()
    {
        forget_frame(); // first, because two machines may not fit into memory
        watch_ = {};
        facts_ = {};
        auto options = options_of(settings_);
        options.trace = settings_.anchored();
        renderer_ = std::make_unique<tilemesh::Renderer>(*map_, setup_of(settings_, map_->sh_degree), options, homes_of(settings_, map_->sh_degree));
        if (!settings_.anchored()) return;
        core_ = &dynamic_cast<Core&>(renderer_->core());
        core_->observe([this](tilemesh::SuperstepEvent const& event) {
            watch_.look(*core_, event);
            splat::GaussianId const followed{static_cast<std::uint32_t>(settings_.follow)};
            if (settings_.follow > 0) facts_.read(*core_, event, watch_.supersteps.size() - 1, followed, follower_);
        });
    }
    void ensure_map()
    {
        if (!map_) map_ = scene::built_in_map();
    }
    void forget_frame()
    {
        core_ = nullptr;
        renderer_.reset();
        has_frame_ = false;
    }
    void forget()
    {
        forget_frame();
#if !defined(__EMSCRIPTEN__)
        tracking_.reset();
#endif
        tracked_ = nullptr;
    }
    void need_frame() const
    {
        if (!has_frame_ || !renderer_) throw NoFrame("no frame (none was rendered of this map); call tilemesh_render first");
    }
    void need_trace() const
    {
        need_frame();
        if (!core_)
            throw NoFrame("no trace of this frame (the program " + used_.program +
                          " rendered it, and only the anchored program keeps one); set program to \"anchored\" and render again");
    }
    char const* answer(std::string text)
    {
        text_ = std::move(text);
        return text_.c_str();
    }
    tilemesh::Grid grid() const { return {renderer_->grid().width, renderer_->grid().height}; }
    tilemesh::Extent2 tile_size() const
    {
        return renderer_->tile();
    }
    render::Setup const& facts() const { return renderer_->setup(); }
    splat::Rules const& rules() const { return renderer_->rules(); }
    bool is_built_in() const { return map_->path.empty() && map_->name == "built_in"; }

    /// Blends the records of the view without a mesh: every tile gets each record that touches it.
    void render_complete()
    {
        if (frame_.report.lost.empty()) { // nothing is missing: it is the complete picture
            complete_ = &frame_.image;
            return;
        }
        auto const& frame = core_->mesh().template broadcast<Core::Parameters>();
        auto const& tiling = core_->tiling();
        auto const* const splats = frame.splats.get();
        std::vector<std::uint32_t> rows; // of visible records, nearest first, then by ids as the tiles sort them
        for (std::uint32_t row = 0; row < map_->gaussians.size(); ++row)
            if (splats[row].visible()) rows.push_back(row);
        std::sort(rows.begin(), rows.end(), [&](std::uint32_t a, std::uint32_t b) {
            return std::pair(splats[a].depth_key, map_->gaussians[a].id) < std::pair(splats[b].depth_key, map_->gaussians[b].id);
        });
        complete_picture_ = report::Image(camera_.width, camera_.height);
        static_assert(sizeof(splat::FloatPixel) == 3 * sizeof(float), "a picture is an array of pixels");
        std::vector<std::vector<std::uint32_t>> lists(tiling.columns);
        for (std::uint32_t y = 0; y < tiling.rows; ++y) { // one row of tiles after the other, so that the lists stay short
            for (auto& list : lists) list.clear();
            for (auto const row : rows) {
                auto const range = splat::tiles_of(splats[row], tiling);
                if (y < range.first.y() || y > range.last.y()) continue;
                for (auto x = range.first.x(); x <= range.last.x(); ++x) lists[x].push_back(row);
            }
            for (std::uint32_t x = 0; x < tiling.columns; ++x) {
                auto const rect = splat::pixels_of(tiling, camera_, tilemesh::TileId::at(x, y));
                if (rect.empty()) continue;
                auto const& list = lists[x];
                splat::PairCount pairs{};
                splat::blend_whole_tile(rect, frame.view.camera, frame.view.rules, static_cast<std::uint32_t>(list.size()),
                                        [&](std::uint32_t i) noexcept -> splat::Splat const& { return splats[list[i]]; },
                                        reinterpret_cast<splat::FloatPixel*>(complete_picture_.pixel(rect.x0, rect.y0)), camera_.width, &pairs, 1);
            }
        }
        if (core_->setup().colour == render::ColourFormat::rgbx8)
            for (auto& v : complete_picture_.rgb) v = static_cast<float>(splat::Rgbx8Pixel::level(v)) / 255.0f;
        complete_ = &complete_picture_;
    }

    void const* painted(report::Image const& image)
    {
        bytes_.resize(std::size_t{4} * image.width * image.height);
        auto* to = bytes_.data();
        constexpr std::size_t at_once = 192; // floats: levels first, in a loop without a branch, then their places
        std::uint32_t levels[at_once];
        for (std::size_t i = 0; i < image.rgb.size(); i += at_once) {
            auto const n = std::min(at_once, image.rgb.size() - i);
            for (std::size_t k = 0; k < n; ++k) levels[k] = splat::Rgbx8Pixel::level(image.rgb[i + k]);
            for (std::size_t k = 0; k < n; k += 3, to += 4) {
                std::uint32_t const pixel = levels[k] | levels[k + 1] << 8 | levels[k + 2] << 16 | 0xff000000u;
                for (std::size_t c = 0; c < 4; ++c) to[c] = static_cast<unsigned char>(pixel >> (8 * c));
            }
        }
        return bytes_.data();
    }
    /// The largest difference of the three channels paints a pixel: from yellow at half a level to red at a quarter of the range.
    void const* painted_difference()
    {
        auto const &a = frame_.image.rgb, &b = complete_->rgb;
        bytes_.resize(a.size() / 3 * 4);
        auto* to = bytes_.data();
        for (std::size_t i = 0; i < a.size(); i += 3, to += 4) {
            float most = 0;
            for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::fabs(a[i + c] - b[i + c]));
            auto const grey = 0.5f * (0.299f * a[i] + 0.587f * a[i + 1] + 0.114f * a[i + 2]) + 0.1f; // ITU-R BT.601, darkened
            bool const differs = most * 255.0f >= 0.5f;
            float const share = std::min(most * 4.0f, 1.0f);
            float const rgb[3] = {differs ? 1.0f : grey, differs ? 0.85f * (1.0f - share) : grey, differs ? 0.0f : grey};
            for (std::size_t c = 0; c < 3; ++c) to[c] = static_cast<unsigned char>(splat::Rgbx8Pixel::level(rgb[c]));
            to[3] = 255;
        }
        return bytes_.data();
    }

    Json map_json()
    {
        ensure_map();
        scene::Size const size{settings_.width, settings_.height};
        auto const centre = scene::robust_centre(*map_);
        Json json;
        json["name"] = map_->name;
        json["gaussians"] = map_->gaussians.size();
        json["rejected"] = map_->rejected;
        json["sh_degree"] = map_->sh_degree;
        json["notes"] = map_->notes;
        auto const& origin = map_->origin;
        json["start"] = numbers_of(is_built_in() ? scene::built_in_camera(size) : scene::frame_whole(*map_, size), origin);
        json["target"] = {centre.x + origin[0], centre.y + origin[1], centre.z + origin[2]};
        json["up"] = {0, -1, 0};
        return json;
    }
    Json settings_json()
    {
        ensure_map();
        auto const setup = setup_of(settings_, map_->sh_degree);
        Json json, limits, choices;
        for (auto const& row : setting_rows) {
            auto const name = json_name(row);
            json[name] = shared::to_json<Json>(settings_, row);
            if (row.form == shared::Form::word)
                for (auto const& word : row.words) choices[name].push_back(word.word);
            if (row.form != shared::Form::whole || !row.words.empty()) continue;
            auto const most = is_slots(row) ? preset_slots(setup.sizes, name) : static_cast<std::uint32_t>(row.most);
            limits[name] = {{"least", static_cast<std::uint32_t>(row.least)}, {"most", most}, {"unit", row.unit},
                            {"words", std::string(row.meaning) + (is_slots(row) ? "; 0: the preset's number" : "")}};
            auto const asked = row.get(settings_).whole;
            if (is_slots(row)) limits[name]["used"] = asked != 0 ? asked : most;
        }
        auto const tiling = tilemesh::tiling_for(options_of(settings_), settings_.width, settings_.height);
        limits["tile_width"]["used"] = tiling.tile_width;
        limits["tile_height"]["used"] = tiling.tile_height;
        json["limits"] = std::move(limits);
        json["choices"] = std::move(choices);
        return json;
    }
    static Json build_json()
    {
        auto const codecs = shared::codecs();
        auto formats = Json::array({"ply", "compressed ply", "splat"});
        if (codecs.gzip != nullptr) formats.push_back("spz");
        if (codecs.zstd != nullptr) formats.push_back("spz 4");
        if (codecs.webp_read != nullptr && codecs.deflate != nullptr) formats.push_back("sog");
#if defined(__FMA__)
        bool const fused = true;
#else
        bool const fused = false;
#endif
        return {{"interface", TILEMESH_C_VERSION}, {"library", TILEMESH_VERSION}, {"formats", formats},
                {"fused", fused}, {"tracker", !is_page}, {"files", !is_page}};
    }
    /// Describes the last frame as a run of one frame.
    void describe()
    {
        run_ = {};
        run_.map = {map_->name, map_->path, map_->gaussians.size(), map_->rejected, map_->notes};
        run_.engine = "threads";
        render::describe(run_, facts(), rules(), options_of(used_));
        report::RunFrame frame;
        frame.report = frame_.report;
        frame.image = "the picture";
        frame.grid = {grid().width, grid().height};
        frame.tile_px = {tile_size().width, tile_size().height};
        if (core_) frame.modelled = report::Modelled{model_.name, cost_.cycles, milliseconds(model_, cost_.cycles)};
        run_.frames.push_back(std::move(frame));
        run_.advice = advice();
    }
    /// What would help if the picture lacks something.
    std::string advice() const
    {
        auto const& r = frame_.report;
        std::string text;
        auto const add = [&text](std::string const& words) { text += (text.empty() ? "" : "; ") + words; };
        if (r.losses(report::Cause::unplaced) + r.losses(report::Cause::storage_full) != 0) {
            if (!r.full_tiles) add("tiles were full only while records were on their way; more storage slots give room");
            else add("the fullest tile needs " + report::thousands(r.full_tiles->slots_needed) + " storage slots and has " + report::thousands(r.full_tiles->slots_available) +
                     (facts().machine.sram_bytes > tilemesh::Mk2::sram_bytes ? "" : "; the machine \"test\" has more"));
        }
        if (r.losses(report::Cause::channel_full) != 0) add("with saturation \"hold\", records wait for a free slot in a channel");
        if (r.losses(report::Cause::late) != 0) add("with hops 0 a frame ends when all records have arrived");
        return text;
    }
    Json frame_json() const
    {
        auto const& r = frame_.report;
        auto const tile = tile_size();
        auto const whole = static_cast<std::uint64_t>(
            std::count_if(r.lost.begin(), r.lost.end(), [](report::Loss const& loss) { return loss.tile == report::Loss::whole; }));
        Json json = {{"width", r.width}, {"height", r.height}, {"columns", grid().width}, {"rows", grid().height},
                     {"tile_width", tile.width}, {"tile_height", tile.height}, {"program", to_string(r.program)}, {"host_ms", r.host_ms.total},
                     {"modelled_ms", nullptr}, {"modelled_cycles", nullptr}, {"cost_model", nullptr}, {"supersteps", nullptr},
                     {"visible", r.gaussians.visible}, {"moved", r.gaussians.moved},
                     {"held", r.gaussians.held}, {"copies", r.copies}, {"lost_records", whole}, {"lost_copies", r.lost_copies},
                     {"late_copies", r.late_copies},
                     {"refused", report::total(r, "refused")},
                     {"messages", r.messages}, {"pairs", r.pairs}, {"records_bytes", render::record_bytes(facts())}};
        if (core_) {
            json["modelled_ms"] = milliseconds(model_, cost_.cycles);
            json["modelled_cycles"] = cost_.cycles;
            json["cost_model"] = model_.name;
            json["supersteps"] = core_->trace().supersteps.size();
        }
        json["missing"] = render_map::missing_text(run_);
        json["advice"] = run_.advice;
        json["difference"] = nullptr;
        if (complete_ != nullptr) {
            double sum = 0, largest = 0;
            std::uint64_t pixels = 0;
            auto const &a = frame_.image.rgb, &b = complete_->rgb;
            for (std::size_t i = 0; i < a.size(); i += 3) {
                double most = 0;
                for (std::size_t c = 0; c < 3; ++c) {
                    double const d = std::fabs(double{a[i + c]} - double{b[i + c]});
                    sum += d * d;
                    most = std::max(most, d);
                }
                largest = std::max(largest, most);
                pixels += most * 255.0 >= 0.5 ? 1u : 0u;
            }
            Json psnr = nullptr;
            if (sum > 0) psnr = 10.0 * std::log10(static_cast<double>(a.size()) / sum);
            json["difference"] = {{"psnr_db", psnr}, {"largest", largest}, {"pixels", pixels}};
        }
        json["memory_bytes"] = memory_bytes();
        return json;
    }
    static std::uint64_t sent_bytes(tilemesh::TileSample const& t)
    {
        return std::uint64_t{t.sent_bytes[0]} + t.sent_bytes[1] + t.sent_bytes[2] + t.sent_bytes[3];
    }
    Json supersteps_json() const
    {
        auto const& trace = core_->trace();
        auto json = Json::array();
        for (std::size_t i = 0; i < trace.supersteps.size(); ++i) {
            auto const& s = trace.supersteps[i];
            auto const& c = cost_.supersteps[i];
            std::uint64_t bytes = 0;
            for (auto const& t : s.tiles) bytes += sent_bytes(t);
            json.push_back({{"index", i}, {"kernel", trace.kernels[s.step]}, {"tiles", s.tiles.size()}, {"messages_bytes", bytes}, {"sent", s.sent},
                            {"cycles", c.total()}, {"compute", c.compute}, {"exchange", c.exchange}, {"sync", c.sync}, {"vote", c.vote}, {"slowest", c.slowest}});
        }
        return json;
    }

    /// The messages and the slots of a channel end on which a superstep sent so many bytes.
    struct ChannelFill {
        std::uint64_t messages, slots;
    };
    ChannelFill fill(std::uint32_t step, std::uint64_t bytes) const
    {
        auto const& facts = core_->setup();
        bool const road = step == Core::Steps::route, beam = step == Core::Steps::bloom_first || step == Core::Steps::bloom;
        if (!road && !beam) return {0, 1};
        auto const slots = used_.renderer.channel_slots != 0 ? used_.renderer.channel_slots : road ? facts.sizes.road : facts.sizes.beam;
        auto const message = road ? splat::road_bytes(facts) : splat::beam_bytes(facts);
        return {bytes > 8 ? (bytes - 8) / message : 0, slots}; // the head of a channel end has 8 bytes
    }
    std::uint32_t tile_of(report::Loss const& loss) const
    {
        if (loss.tile != report::Loss::whole) return loss.tile;
        if (loss.full_tile != report::Loss::whole) return loss.full_tile;
        auto const* const g = find(static_cast<std::uint32_t>(loss.id));
        if (g == nullptr) return report::Loss::whole;
        auto const s = splat::project(*g, splat::make_view(camera_, core_->rules()), core_->tiling());
        return s.visible() ? grid().index_of(s.anchor) : report::Loss::whole;
    }
    splat::Gaussian const* find(std::uint32_t id) const
    {
        auto const& all = map_->gaussians;
        auto const at = std::lower_bound(all.begin(), all.end(), id, [](splat::Gaussian const& g, std::uint32_t wanted) { return static_cast<std::uint32_t>(g.id) < wanted; });
        return at != all.end() && static_cast<std::uint32_t>(at->id) == id ? &*at : nullptr;
    }
    std::vector<std::uint64_t> busy_cycles(tilemesh::RunCost const& cost) const
    {
        std::vector<std::uint64_t> sums(grid().size(), 0);
        for (auto const& step : cost.busy)
            for (std::size_t t = 0; t < sums.size(); ++t) sums[t] += step[t];
        return sums;
    }
    std::vector<std::uint64_t> busy_cycles_of(std::size_t superstep) const
    {
        auto const& trace = core_->trace();
        return busy_cycles(model_cost(model_, {trace.kernels, trace.operations, {trace.supersteps[superstep]}}, grid()));
    }

    tilemesh::CostModel model_;
    std::optional<scene::Map> map_; ///< empty: the built-in map, until it is needed
    Settings settings_, used_; ///< now; of the last frame
    std::unique_ptr<tilemesh::Renderer> renderer_;
    Core* core_ = nullptr; ///< of the anchored program, with a trace; null for homes and auto
#if !defined(__EMSCRIPTEN__)
    std::unique_ptr<Tracking> tracking_;
#endif
    Json tracked_; ///< null: no frame
    Watch watch_;
    render_map::FollowedFacts<Core> facts_;
    render_map::Follower follower_;
    tilemesh::RenderedFrame frame_;
    report::Image complete_picture_; ///< unless the frame's own is complete
    report::Image const* complete_ = nullptr;
    tilemesh::RunCost cost_;
    splat::Camera camera_{};
    report::RunReport run_;
    bool has_frame_ = false;
    std::string text_, error_;
    tilemesh_status code_ = TILEMESH_OK;
    std::vector<unsigned char> bytes_;
    std::vector<float> heat_;
};

float const* tilemesh_handle::heat(std::string_view what, int superstep)
{
    need_trace();
    auto const& trace = core_->trace();
    auto const count = trace.supersteps.size();
    if (superstep < -1 || superstep >= static_cast<int>(count))
        throw Error("superstep " + std::to_string(superstep) + " (the frame has " + std::to_string(count) + ", from 0; -1 is the whole frame); name one of these");
    bool const whole = superstep == -1;
    std::size_t const first = whole ? 0 : static_cast<std::size_t>(superstep), last = whole ? count : first + 1;
    std::vector<float> out(grid().size(), 0.0f);
    if (what == "load" || what == "copies") {
        for (std::size_t i = 0; i < last && i < watch_.supersteps.size(); ++i)
            for (auto const& t : watch_.supersteps[i]) out[t.tile] = static_cast<float>(what == "load" ? t.records : t.copies);
    } else if (what == "refused" || what == "pairs" || (what == "lost" && !whole)) {
        std::vector<std::uint64_t> sums(out.size(), 0);
        for (std::size_t i = first; i < last && i < watch_.supersteps.size(); ++i)
            for (auto const& t : watch_.supersteps[i]) sums[t.tile] += what == "refused" ? t.refused + t.dropped : what == "pairs" ? t.pairs : t.dropped;
        std::transform(sums.begin(), sums.end(), out.begin(), [](std::uint64_t n) { return static_cast<float>(n); });
    } else if (what == "lost") {
        for (auto const& loss : frame_.report.lost)
            if (auto const t = tile_of(loss); t < out.size()) out[t] += 1.0f;
    } else if (what == "channel") {
        for (std::size_t i = first; i < last; ++i)
            for (auto const& t : trace.supersteps[i].tiles)
                for (auto const bytes : t.sent_bytes) {
                    auto const f = fill(trace.supersteps[i].step, bytes);
                    out[t.tile] = std::max(out[t.tile], static_cast<float>(f.messages) / static_cast<float>(f.slots));
                }
    } else if (what == "busy") {
        auto const sums = whole ? busy_cycles(cost_) : busy_cycles_of(first);
        std::transform(sums.begin(), sums.end(), out.begin(), [](std::uint64_t n) { return static_cast<float>(n); });
    } else {
        throw Error("no heat map \"" + std::string(what.substr(0, 40)) + "\" (there are load, copies, channel, refused, lost, pairs and busy); name one of these");
    }
    heat_ = std::move(out);
    return heat_.data();
}

char const* tilemesh_handle::tile(std::uint32_t index)
{
    need_trace();
    if (index >= grid().size())
        throw Error("tile " + std::to_string(index) + " (the grid has " + std::to_string(grid().size()) + " tiles, from 0); name one of these");
    auto const& mesh = std::as_const(core_->mesh());
    auto const& facts = core_->setup();
    auto const at = grid().tile(index);
    auto const rect = splat::pixels_of(core_->tiling(), camera_, at);
    auto const& frame = core_->mesh().template broadcast<Core::Parameters>();
    Json json = {{"tile", index}, {"column", at.x()}, {"row", at.y()}, {"rect", {rect.x0, rect.y0, rect.x1, rect.y1}}};

    auto const marks = mesh.template state<splat::Marks<Policies>>(at);
    auto const entries = mesh.template state<splat::Splats<Policies>>(at);
    std::uint32_t copies = 0, leaving = 0;
    std::vector<std::pair<splat::Splat, splat::Mark>> shown;
    for (std::uint32_t i = 0; i < marks.size(); ++i) {
        copies += marks[i].is(splat::Mark::copy) ? 1u : 0u;
        leaving += !marks[i].is(splat::Mark::copy) && marks[i].is(splat::Mark::leaving) ? 1u : 0u;
        auto const& s = splat::AccessOf<Policies>::splat_of(frame, entries[i]);
        if (s.visible()) shown.emplace_back(s, marks[i]);
    }
    std::sort(shown.begin(), shown.end(), [](auto const& a, auto const& b) { return std::pair(a.first.depth_key, a.second.id) < std::pair(b.first.depth_key, b.second.id); });
    json["records"] = marks.size();
    json["anchored"] = marks.size() - copies - leaving;
    json["copies"] = copies;
    json["leaving"] = leaving;
    json["slots"] = used_.renderer.storage_slots != 0 ? used_.renderer.storage_slots : facts.sizes.storage;
    auto ledger = Json::array();
    for (auto const& region : render::ledger_of(facts))
        ledger.push_back({{"name", std::string(region.name.text, region.name.size)}, {"what", region.what}, {"bytes", region.bytes}, {"budgeted", region.budgeted}});
    json["ledger"] = std::move(ledger);
    json["ledger_bytes"] = render::sram_bytes_of(facts);
    json["sram_bytes"] = facts.machine.sram_bytes;

    auto const& c = mesh.template state<splat::Counts>(at);
    std::uint64_t pairs = 0;
    for (auto const& step : watch_.supersteps)
        for (auto const& t : step) pairs += t.tile == index ? t.pairs : 0;
    auto const& trace = core_->trace();
    auto& counts = json["counts"];
    for (auto const& field : report::report_fields)
        if (field.group() == "refused" && field.anchored.word != nullptr) counts[std::string(field.leaf())] = c.*field.anchored.word;
    counts["pairs"] = pairs;
    counts["busy_cycles"] = busy_cycles(cost_)[index];

    auto channels = Json::array();
    for (tilemesh::Direction d : tilemesh::news) {
        bool const has = grid().has_neighbour(at, d);
        auto const from = has ? grid().index_of(grid().neighbour(at, d)) : index;
        std::uint64_t sent = 0, received = 0;
        ChannelFill most{0, used_.renderer.channel_slots != 0 ? used_.renderer.channel_slots : facts.sizes.beam};
        for (auto const& s : trace.supersteps)
            for (auto const& t : s.tiles) {
                if (has && t.tile == from) received += t.sent_bytes[tilemesh::index(tilemesh::opposite(d))];
                if (t.tile != index || t.sent_bytes[tilemesh::index(d)] == 0) continue;
                sent += t.sent_bytes[tilemesh::index(d)];
                auto const f = fill(s.step, t.sent_bytes[tilemesh::index(d)]);
                if (f.messages > most.messages) most = f;
            }
        channels.push_back({{"side", render_map::name_of(d)}, {"sent_bytes", sent}, {"most_messages", most.messages}, {"slots", most.slots}, {"received_bytes", received}});
    }
    json["channels"] = std::move(channels);

    auto list = Json::array();
    for (std::size_t i = 0; i < shown.size() && i < 500; ++i) {
        auto const& [s, mark] = shown[i];
        auto const r = s.rect();
        list.push_back({{"id", static_cast<std::uint32_t>(mark.id)},
                        {"kind", mark.is(splat::Mark::copy) ? "copy" : mark.is(splat::Mark::leaving) ? "leaving" : "anchored"},
                        {"x", s.mean_px[0]}, {"y", s.mean_px[1]}, {"radius", std::max(r.x1 - r.x0, r.y1 - r.y0) / 2.0}, {"depth", s.depth()},
                        {"opacity", s.opacity}, {"colour", {s.colour[0], s.colour[1], s.colour[2]}}});
    }
    json["list"] = std::move(list);
    return answer(dumped(json));
}

char const* tilemesh_handle::gaussian(std::uint32_t id)
{
    need_trace();
    auto const* const g = find(id);
    Json json = {{"id", id}, {"state", "not in the map"}, {"anchor", nullptr}, {"copies", Json::array()}, {"mean", nullptr},
                 {"opacity", nullptr}, {"missing", Json::array()}};
    if (g != nullptr) {
        auto const& mesh = std::as_const(core_->mesh());
        std::string state = "with the host";
        for (std::uint32_t t = 0; t < grid().size(); ++t) {
            auto const marks = mesh.template state<splat::Marks<Policies>>(grid().tile(t));
            auto const slot = splat::find(marks, g->id);
            if (slot == splat::no_slot) continue;
            if (marks[slot].is(splat::Mark::copy)) {
                json["copies"].push_back(t);
                continue;
            }
            state = "on a tile";
            json["anchor"] = t;
        }
        auto missing = Json::array();
        for (auto const& loss : frame_.report.lost) {
            if (loss.id != g->id) continue;
            if (loss.cause == report::Cause::late && json["anchor"].is_null()) state = "under way";
            if (loss.cause == report::Cause::storage_full && json["anchor"].is_null()) state = "lost";
            if (auto const t = tile_of(loss); t < grid().size()) missing.push_back(t);
        }
        if (state == "with the host" && !core_->setup().holds) state = "lost";
        json["state"] = state;
        json["mean"] = Json::array();
        for (std::size_t i = 0; i < 3; ++i) json["mean"].push_back(double{g->mean_world[i]} + map_->origin[i]);
        json["opacity"] = g->opacity;
        json["missing"] = std::move(missing);
    }
    json["path"] = nullptr;
    if (used_.follow == std::int64_t{id} && id != 0) {
        auto path = Json::array();
        for (auto const& s : follower_.life().sightings) {
            Json side = nullptr;
            if (s.side) side = render_map::name_of(*s.side);
            path.push_back({{"superstep", s.superstep}, {"kernel", s.kernel}, {"tile", grid().index_of(s.tile)}, {"what", render_map::name_of(s.what)},
                            {"side", side}, {"refusal", s.refusal}});
        }
        json["path"] = std::move(path);
    }
    return answer(dumped(json));
}

char const* tilemesh_handle::trajectory(char const* name, void const* bytes, std::size_t length)
{
    if (bytes == nullptr) throw Error("no trajectory (its address is null); give the content of a file");
    constexpr std::size_t most_poses = 200'000; // 80 MB of text
    Bytes buffer(bytes, length);
    std::istream stream(&buffer);
    std::string const shown = name != nullptr ? name : "a file";
    auto const poses = scene::read_trajectory(stream, shown, most_poses);
    char const* const formats[] = {"tum", "euroc", "kitti", "replica"};
    std::string text = std::string("{\"format\":\"") + formats[static_cast<std::size_t>(poses.format)] + "\",\"stamps\":" + (poses.has_stamps() ? "true" : "false") + ",\"notes\":" +
                       dumped(Json(scene::trajectory_notes(poses))) + ",\"poses\":[";
    auto const put = [&text](double value) { text += tilemesh::number_text(value); };
    for (auto const& [seconds, pose] : poses) {
        text += &seconds == &poses.front().seconds ? "{\"seconds\":" : ",{\"seconds\":";
        put(seconds);
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column) {
                text += row + column == 0 ? ",\"rotation\":[" : ",";
                put(pose.rotation[column][row]);
            }
        for (int axis = 0; axis < 3; ++axis) {
            text += axis == 0 ? "],\"position\":[" : ",";
            put(pose.position[axis]);
        }
        text += "]}";
    }
    return answer(text + "]}");
}

char const* tilemesh_handle::cameras([[maybe_unused]] char const* path)
{
#if defined(__EMSCRIPTEN__)
    throw NotBuilt("a file of cameras (this build has no files); give the numbers of a camera");
#else
    if (path == nullptr) throw Error("no cameras (the path is null); name a file, or a folder of COLMAP");
    Json json = {{"notes", Json::array()}, {"cameras", Json::array()}};
    std::vector<std::string> notes;
    for (auto const& each : scene::load_cameras(std::filesystem::path(path), &notes)) {
        auto numbers = numbers_of(each.camera, {});
        for (int axis = 0; axis < 3 && each.position; ++axis) numbers[static_cast<std::size_t>(9 + axis)] = (*each.position)[axis];
        json["cameras"].push_back({{"name", scene::label(each)}, {"width", each.camera.width}, {"height", each.camera.height}, {"camera", numbers},
                                   {"lens", scene::text_of(each.camera.lens)}});
    }
    json["notes"] = notes;
    return answer(dumped(json));
#endif
}

// --- the functions -----------------------------------------------------------------------------------------------------------

namespace {
std::string_view word(char const* text) noexcept
{
    return text != nullptr ? text : "";
}
} // namespace

extern "C" {

tilemesh_handle* tilemesh_create(void)
{
    try {
        return new tilemesh_handle;
    } catch (...) {
        return nullptr;
    }
}
void tilemesh_destroy(tilemesh_handle* handle)
{
    delete handle;
}
char const* tilemesh_error(tilemesh_handle const* handle)
{
    return handle != nullptr ? handle->error() : "no handle (its address is null); make one with tilemesh_create";
}
int tilemesh_error_code(tilemesh_handle const* handle)
{
    return handle != nullptr ? handle->code() : TILEMESH_BAD_INPUT;
}
int tilemesh_version(void)
{
    return TILEMESH_C_VERSION;
}
int tilemesh_load_file(tilemesh_handle* handle, char const* path)
{
    return handle == nullptr ? 0 : handle->guarded(0, [&] { return handle->load_file(path), 1; });
}
int tilemesh_track_begin(tilemesh_handle* handle, double const* camera, int with_depth)
{
    return handle == nullptr ? 0 : handle->guarded(0, [&] { return handle->begin_tracking(camera, with_depth != 0), 1; });
}
int tilemesh_track(tilemesh_handle* handle, float const* rgb, float const* depth, size_t pixels, double seconds, double* camera)
{
    return handle == nullptr ? 0 : handle->guarded(0, [&] { return handle->track(rgb, depth, pixels, seconds, camera), 1; });
}
int tilemesh_load(tilemesh_handle* handle, char const* name, void const* bytes, size_t length)
{
    return handle == nullptr ? 0 : handle->guarded(0, [&] { return handle->load(name, bytes, length), 1; });
}
char const* tilemesh_trajectory(tilemesh_handle* handle, char const* name, void const* bytes, size_t length)
{
    return handle == nullptr ? nullptr : handle->guarded<char const*>(nullptr, [&] { return handle->trajectory(name, bytes, length); });
}
char const* tilemesh_cameras(tilemesh_handle* handle, char const* path)
{
    return handle == nullptr ? nullptr : handle->guarded<char const*>(nullptr, [&] { return handle->cameras(path); });
}
int tilemesh_set(tilemesh_handle* handle, char const* json)
{
    return handle == nullptr ? 0 : handle->guarded(0, [&] { return handle->set(json), 1; });
}
int tilemesh_render(tilemesh_handle* handle, double const* camera)
{
    return handle == nullptr ? 0 : handle->guarded(0, [&] { return handle->render_frame(camera), 1; });
}
void const* tilemesh_pixels(tilemesh_handle* handle, char const* what)
{
    return handle == nullptr ? nullptr : handle->guarded<void const*>(nullptr, [&] { return handle->pixels(word(what)); });
}
char const* tilemesh_report(tilemesh_handle* handle, char const* what)
{
    return handle == nullptr ? nullptr : handle->guarded<char const*>(nullptr, [&] { return handle->report_text(word(what)); });
}
float const* tilemesh_heat(tilemesh_handle* handle, char const* what, int superstep)
{
    return handle == nullptr ? nullptr : handle->guarded<float const*>(nullptr, [&] { return handle->heat(word(what), superstep); });
}
char const* tilemesh_tile(tilemesh_handle* handle, uint32_t tile)
{
    return handle == nullptr ? nullptr : handle->guarded<char const*>(nullptr, [&] { return handle->tile(tile); });
}
char const* tilemesh_gaussian(tilemesh_handle* handle, uint32_t id)
{
    return handle == nullptr ? nullptr : handle->guarded<char const*>(nullptr, [&] { return handle->gaussian(id); });
}

} // extern "C"
