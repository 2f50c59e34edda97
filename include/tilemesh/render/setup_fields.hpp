#pragma once
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/splat/quality.hpp>
#include <tilemesh/splat/setup.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// A word that stands for a number.
struct Word {
    std::string_view word;
    std::uint64_t number;
    template <class T>
    constexpr Word(std::string_view text, T value) : word(text), number(static_cast<std::uint64_t>(value))
    {
    }
};

/// A `most` that no sentence names.
inline constexpr double any_number = 0xffffffffu;

/// The values that something takes: words; or whole numbers from `least` to `most` and words; or any numbers in these limits (none, if both
/// are equal).
struct Values {
    enum Kind : unsigned char { word, whole, number } kind = word;
    double least = 0, most = 0;
    std::string_view unit{};
    std::span<Word const> words{};

    /// "it takes a whole number from 1 to 64", "there are hold or drop"
    TILEMESH_HOST std::string takes() const;
    /// The number that the text says, or that its word stands for; none for a text that is no such value.
    TILEMESH_HOST std::optional<double> read(std::string_view text) const;
    /// The text that `read` reads as this number.
    TILEMESH_HOST std::string text(double value) const;
};

/// The name that differs from `unknown` in at most a third of its letters, or begins like it; empty if there is none.
TILEMESH_HOST std::string_view nearest(std::string_view unknown, std::vector<std::string_view> const& names);

namespace detail {
TILEMESH_HOST double preset_of(splat::Setup const& setup);
TILEMESH_HOST void set_preset(splat::Setup& setup, double preset);
TILEMESH_HOST double machine_of(splat::Setup const& setup);
TILEMESH_HOST void set_machine(splat::Setup& setup, double machine);
TILEMESH_HOST double quality_of(splat::Setup const& setup);
TILEMESH_HOST void set_quality(splat::Setup& setup, double quality);

inline constexpr Word presets[] = {{"lossless", 0}, {"paper", 1}, {"prototype", 2}};
inline constexpr Word machines[] = {{"mk2", 0}, {"test", 1}};
inline constexpr std::uint32_t no_quality = 0xffffffffu; ///< rules that no quality names
inline constexpr Word qualities[] = {{"default", no_quality},
                                     {"evaluation", splat::Quality::evaluation},
                                     {"viewing", splat::Quality::viewing},
                                     {"on_sensor", splat::Quality::on_sensor},
                                     {"training", splat::Quality::training}};
inline constexpr Word programs[] = {{"anchored", splat::Program::anchored}, {"homes", splat::Program::homes}, {"auto", splat::Program::automatic}};
inline constexpr Word switches[] = {{"off", false}, {"on", true}};
inline constexpr Word saturations[] = {{"hold", true}, {"drop", false}};
inline constexpr Word priorities[] = {{"first", false}, {"largest", true}};
inline constexpr Word addressings[] = {{"carried", true}, {"recomputed", false}};
inline constexpr Word copies[] = {{"world", true}, {"screen", false}};
inline constexpr Word colours[] = {{"float", splat::ColourFormat::float32}, {"rgbx8", splat::ColourFormat::rgbx8}};
inline constexpr Word footprints[] = {{"opacity_box", splat::Footprint::opacity_box},
                                      {"three_sigma_square", splat::Footprint::three_sigma_square},
                                      {"three_sigma_tiles", splat::Footprint::three_sigma_tiles}};
inline constexpr Word arithmetics[] = {{"precise", splat::Arithmetic::precise}, {"fast", splat::Arithmetic::fast}};
inline constexpr Word coverages[] = {{"of_record", splat::Coverage::of_record}, {"preserved", splat::Coverage::preserved}};
inline constexpr Word stops[] = {{"after_crossing", splat::Stop::after_crossing}, {"before_crossing", splat::Stop::before_crossing}};
inline constexpr Word near_planes[] = {{"of_camera", splat::NearPlane::of_camera}, {"fixed", splat::NearPlane::fixed}};
inline constexpr Word borders[] = {{"of_picture", splat::SlopeBorder::of_picture}, {"of_half_width", splat::SlopeBorder::of_half_width}};

constexpr Values in_slots{Values::whole, 0, any_number, "slots"};
constexpr Values as_share{Values::number, 0, 1};
} // namespace detail

/// A field of `Of`: its name, the values that it takes, its meaning, and the member that it reads and writes.
template <class Of>
struct FieldOf {
    std::string_view name;    ///< "channel-slots"; in JSON "channel_slots"
    Values values;
    std::string_view meaning; ///< begins with a small letter, ends without a full stop; "{}" stands for the words
    double (*get)(Of const&) = nullptr;
    void (*set)(Of&, double) = nullptr; ///< the number must be one that `values` has
    /// `everyone`: an option of render_map, a setting of C and Python and a policy of studies, without a line of theirs. `alone`: programs
    /// may name it. `several`: it writes several members; report.json has the fields of these instead.
    enum For : unsigned char { alone, everyone, several } use = alone;

    constexpr FieldOf(std::string_view field, Values takes, std::string_view sentence, double (*read)(Of const&), void (*write)(Of&, double),
                      For who = alone)
        : name(field), values(takes), meaning(sentence), get(read), set(write), use(who)
    {
    }
    /// `Member`: a lambda that returns a reference to the member of an `Of`, const or not.
    template <class Member>
    constexpr FieldOf(std::string_view field, Values takes, std::string_view sentence, Member, For who = alone)
        : FieldOf(
              field, takes, sentence, [](Of const& s) { return static_cast<double>(Member{}(s)); },
              [](Of& s, double value) {
                  using T = std::remove_reference_t<decltype(Member{}(s))>;
                  if constexpr (std::is_same_v<T, bool>) Member{}(s) = value != 0;
                  else if constexpr (std::is_enum_v<T>) Member{}(s) = static_cast<T>(static_cast<std::uint32_t>(value));
                  else Member{}(s) = static_cast<T>(value);
              },
              who)
    {
    }
    std::string text(Of const& of) const { return values.text(get(of)); }
};
/// A field of `Setup`. Options of programs and their --help, settings of C and Python, policies of a study, and the setup in report.json with
/// its schema come from the table of these.
using SetupField = FieldOf<splat::Setup>;

/// All fields. The first ones write several members; `with` writes in the order of this table. A new member of `Setup` is a row here;
/// tests/render/setup_fields.cpp fails for a member without one.
inline constexpr SetupField setup_fields[] = {
    {"preset", {.words = detail::presets}, "a published setup: {}", detail::preset_of, detail::set_preset, SetupField::several},
    {"machine", {.words = detail::machines}, "mk2 | test (64 MiB per tile, room for a whole map)",
     detail::machine_of, detail::set_machine, SetupField::several},
    {"quality", {.words = detail::qualities}, "cut-offs and rules of the picture: {}", detail::quality_of, detail::set_quality, SetupField::several},
    {"channel-slots", detail::in_slots, "messages in one channel end of routing, and of bloom",
     [](splat::Setup const& s) {
         return static_cast<double>(s.program == splat::Program::homes || s.sizes.road < s.sizes.beam ? s.sizes.road : s.sizes.beam);
     },
     [](splat::Setup& s, double n) {
         s.sizes.road = static_cast<std::uint32_t>(n);
         if (s.program != splat::Program::homes) s.sizes.beam = s.sizes.road;
     },
     SetupField::several},
    {"program", {.words = detail::programs}, "anchored | homes | auto (homes once anchored would lack something)",
     [](splat::Setup const& s) { return static_cast<double>(s.program); },
     [](splat::Setup& s, double n) {
         auto const program = static_cast<splat::Program>(static_cast<std::uint32_t>(n));
         if (program == splat::Program::homes && s.program != program) s = splat::as_homes(s);
         s.program = program;
     },
     SetupField::several},

    {"tiles", {Values::whole, 1, any_number, "tiles"}, "tiles of the machine", [](auto& s) -> auto& { return s.machine.tiles; }},
    {"sram", {Values::whole, 1, any_number, "bytes"}, "SRAM of a tile", [](auto& s) -> auto& { return s.machine.sram_bytes; }},
    {"code", {Values::whole, 0, any_number, "bytes"}, "SRAM of a tile that code takes", [](auto& s) -> auto& { return s.machine.code_bytes; }},
    {"workers", {Values::whole, 1, 1024, "workers"}, "threads of a tile", [](auto& s) -> auto& { return s.machine.workers; }},
    {"clock", {Values::whole, 1, any_number, "kHz"}, "clock of a tile", [](auto& s) -> auto& { return s.machine.clock_khz; }},

    {"storage-slots", detail::in_slots, "records and copies that a tile stores; homes: splats of a window that it holds",
     [](auto& s) -> auto& { return s.sizes.storage; }},
    {"road-slots", detail::in_slots, "messages in a channel end of routing; homes: splats under way", [](auto& s) -> auto& { return s.sizes.road; }},
    {"beam-slots", detail::in_slots, "messages in one channel end of bloom", [](auto& s) -> auto& { return s.sizes.beam; }},
    {"waiting-slots", detail::in_slots, "messages in each FIFO of routing", [](auto& s) -> auto& { return s.sizes.waiting; }},
    {"home-slots", detail::in_slots, "homes: records that live on a tile", [](auto& s) -> auto& { return s.sizes.homes; }},
    {"tile-pixels", {Values::whole, 0, any_number, "pixels"}, "pixels of a tile's framebuffer", [](auto& s) -> auto& { return s.sizes.tile_pixels; }},
    {"lists-fit", {.words = detail::switches}, "marks, projected records and sort keys count against the SRAM",
     [](auto& s) -> auto& { return s.sizes.lists_fit; }},
    {"one-channel-memory", {.words = detail::switches}, "routing and bloom share one memory for their channels",
     [](auto& s) -> auto& { return s.sizes.one_channel_memory; }},

    {"saturation", {.words = detail::saturations}, "a full channel: hold records back | drop copies",
     [](splat::Setup const& s) { return static_cast<double>(s.holds); },
     [](splat::Setup& s, double holds) { // a setup that drops has no FIFOs
         s.holds = holds != 0;
         if (s.holds && s.sizes.waiting == 0) s.sizes.waiting = splat::lossless.sizes.waiting;
     },
     SetupField::everyone},
    {"priority", {.words = detail::priorities}, "a full tile keeps, a full channel takes: first (come) | largest",
     [](auto& s) -> auto& { return s.ranks; },
     SetupField::everyone},
    {"copies", {.words = detail::copies}, "bloom sends copies in {} coordinates", [](auto& s) -> auto& { return s.reusable; }, SetupField::everyone},
    {"pixels", {.words = detail::colours}, "framebuffers of the tiles: {}", [](auto& s) -> auto& { return s.colour; }, SetupField::everyone},
    {"addressing", {.words = detail::addressings}, "a record's anchor tile travels with it, or is computed on the way: {}",
     [](auto& s) -> auto& { return s.carried; }},
    {"routing", {.words = detail::switches}, "records travel to their anchor tiles; off: the host places them",
     [](auto& s) -> auto& { return s.routes; }},
    {"bloom", {.words = detail::switches}, "tiles send copies to the other tiles that a splat touches", [](auto& s) -> auto& { return s.blooms; }},
    {"sh-degree", {Values::whole, 0, 3}, "highest degree of view-dependent colour in a record", [](auto& s) -> auto& { return s.sh_degree; }},
    {"depth", {.words = detail::switches}, "tiles store the depth of a pixel", [](auto& s) -> auto& { return s.depth; }},
    {"alpha", {.words = detail::switches}, "tiles store the covered share of a pixel", [](auto& s) -> auto& { return s.alpha; }},
    {"fit", {.words = detail::switches}, "homes: as many as the map needs, if the SRAM has room for them", [](auto& s) -> auto& { return s.fit; }},
    {"district", {Values::whole, 0, 32768, "tiles"}, "homes: tiles along a side of a district; 0: the smallest that fits",
     [](auto& s) -> auto& { return s.district; }},

    {"footprint", {.words = detail::footprints}, "the pixels that a splat may touch: {}", [](auto& s) -> auto& { return s.rules.footprint; }},
    {"arithmetic", {.words = detail::arithmetics}, "precise (bits of a naive loop) | fast (alpha within 2e-5 of it)",
     [](auto& s) -> auto& { return s.rules.arithmetic; }},
    {"coverage", {.words = detail::coverages}, "the opacity of a splat that the dilation enlarges: {}",
     [](splat::Setup const& s) { return static_cast<double>(s.rules.coverage); },
     [](splat::Setup& s, double n) { s.rules.coverage = static_cast<splat::Coverage>(n); }},
    {"stop", {.words = detail::stops}, "the term at which a pixel is finished: {}", [](auto& s) -> auto& { return s.rules.stop; }},
    {"near-plane", {.words = detail::near_planes}, "the near plane: {}",
     [](splat::Setup const& s) { return static_cast<double>(s.rules.near_plane); },
     [](splat::Setup& s, double n) { s.rules.near_plane = static_cast<splat::NearPlane>(n); }},
    {"slope-border", {.words = detail::borders}, "the border that bounds the slopes of a splat: {}",
     [](splat::Setup const& s) { return static_cast<double>(s.rules.slope_border); },
     [](splat::Setup& s, double n) { s.rules.slope_border = static_cast<splat::SlopeBorder>(n); }},
    {"alpha-min", detail::as_share, "a term below it does not count", [](auto& s) -> auto& { return s.rules.alpha_min; }},
    {"alpha-max", detail::as_share, "alpha is at most this", [](auto& s) -> auto& { return s.rules.alpha_max; }},
    {"transmittance-min", detail::as_share, "a pixel below it is finished", [](auto& s) -> auto& { return s.rules.transmittance_min; }},
    {"dilation", {Values::number, 0, 1e3, "pixels squared"}, "added to both variances of a splat", [](auto& s) -> auto& { return s.rules.dilation; }},
    {"jacobian-limit", {Values::number, 0, 1e3}, "slopes are clamped to so many distances to the border; 0: no clamp",
     [](auto& s) -> auto& { return s.rules.jacobian_limit; }},
    {"background-red", detail::as_share, "the colour behind the splats: red", [](auto& s) -> auto& { return s.rules.background[0]; }},
    {"background-green", detail::as_share, "green", [](auto& s) -> auto& { return s.rules.background[1]; }},
    {"background-blue", detail::as_share, "blue", [](auto& s) -> auto& { return s.rules.background[2]; }},
};

/// The number of a field's row, at compile time. A name that is not in the table does not compile.
consteval std::size_t setup_field(std::string_view name)
{
    for (std::size_t i = 0; i < std::size(setup_fields); ++i)
        if (setup_fields[i].name == name) return i;
    throw "setup_fields has no field of this name";
}
/// The field of that name, where "_" counts as "-"; null if there is none.
TILEMESH_HOST SetupField const* find_setup_field(std::string_view name);

/// A field by its name, and its value as a text.
struct SetupValue {
    std::string name, text;

    friend bool operator==(SetupValue const&, SetupValue const&) = default;
    SetupValue(std::string_view field, std::string_view value) : name(field), text(value) {}
    template <class T>
        requires std::is_arithmetic_v<T>
    SetupValue(std::string_view field, T value)
        : name(field)
    {
        if constexpr (std::is_same_v<T, bool>) text = value ? "on" : "off";
        else if constexpr (std::is_integral_v<T>) text = std::to_string(value);
        else text = number_text(static_cast<double>(value));
    }
};

}}} // namespace tilemesh::render

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// Returns a setup with other values of some fields, in the order of `render::setup_fields`; of a field that is named twice, the last one
/// counts. Throws Error for a name that is no field (it tells the nearest one), and for a value that the field does not take.
TILEMESH_HOST Setup with(Setup setup, std::span<render::SetupValue const> values);
inline Setup with(Setup const& setup, std::initializer_list<render::SetupValue> values)
{
    return with(setup, std::span(values.begin(), values.size()));
}

}}} // namespace tilemesh::splat

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/render/detail/setup_fields_code.hpp>
#endif
