#pragma once
#include "../shared/option_table.hpp"
#include "options.hpp"
#include <array>

/// The options of render_map that choose the machine, its program and its rules.
namespace render_map {

namespace detail {

using shared::any_number;
using shared::Form;
using shared::option;
using shared::OptionValue;
using shared::Word;
using shared::words;
using tilemesh::RendererOptions;
using tilemesh::report::Program;
using tilemesh::splat::Arithmetic;
using tilemesh::splat::Footprint;
using tilemesh::splat::Quality;

inline constexpr Word programs[] = {{"auto", Program::automatic}, {"anchored", Program::anchored}, {"homes", Program::homes}};
inline constexpr Word machines[] = {{"mk2", MachineKind::mk2}, {"test", MachineKind::test}};
inline constexpr Word all_rounds[] = {{"all", 0}, {"0", 0}};
inline constexpr Word folds[] = {{"on", true}, {"off", false}};
inline constexpr Word saturations[] = {{"hold", SaturationKind::hold}, {"drop", SaturationKind::drop}};
inline constexpr Word priorities[] = {{"first", false}, {"largest", true}};
inline constexpr Word footprints[] = {{"opacity_box", Footprint::opacity_box},
                                      {"three_sigma_square", Footprint::three_sigma_square},
                                      {"three_sigma_tiles", Footprint::three_sigma_tiles}};
inline constexpr Word copies[] = {{"world", CopiesKind::world}, {"screen", CopiesKind::screen}};
inline constexpr Word quiet_hops[] = {{"quiet", 0}};
inline constexpr Word pixels[] = {{"float", PixelKind::float32}, {"rgbx8", PixelKind::rgbx8}};
inline constexpr Word arithmetics[] = {{"precise", Arithmetic::precise}, {"fast", Arithmetic::fast}};
inline constexpr Word qualities[] = {{"evaluation", Quality::evaluation},
                                     {"viewing", Quality::viewing},
                                     {"on_sensor", Quality::on_sensor},
                                     {"training", Quality::training}};
inline constexpr Word fits[] = {{"scene", true}, {"off", false}};

inline void set_machine(Options& o, OptionValue const& given)
{
    auto const text = given.text;
    o.machine_named = true;
    if (text.find_first_of("./") != text.npos) { // a name has neither
        o.machine = text;
        o.choice.machine = MachineKind::file;
        return;
    }
    for (auto const& [word, machine] : machines)
        if (text == word) {
            o.choice.machine = static_cast<MachineKind>(machine);
            return;
        }
    throw shared::Misfit{"there are mk2, test and files"};
}

} // namespace detail

inline constexpr shared::Word presets[] = {{"lossless", Preset::lossless}, {"paper", Preset::paper}, {"prototype", Preset::prototype}};

inline constexpr auto setup_rows = [] {
    using namespace detail;
    return std::to_array<shared::Option<Options>>({
        words<&Options::choice, &Choice::preset>("preset", "NAME", "{} [lossless]", presets),
        words<&Options::renderer, &RendererOptions::program>("program", "NAME",
                                                             "auto (homes once anchored would lack something) | anchored | homes [auto]", programs),
        {{"machine", "NAME|FILE", "mk2 | test (64 MiB per tile) | a file (see below) [mk2 if it has room]", Form::text, 0, 0, {}, {}, "test"}, set_machine},
        option<&Options::renderer, &RendererOptions::grid>("grid", "WxH", "number of tiles [40x36, or as many as --size and --tile need]", {1, 65535},
                                                           {}, "40x36"),
        option<&Options::renderer, &RendererOptions::tile>("tile", "WxH", "pixels per tile [the frame spread evenly over the grid]", {1, 65535}, {},
                                                           "32x20"),
        option<&Options::channel_slots>("channel-slots", "N", "limit each channel to N records [the preset's slots]", {0, any_number}),
        option<&Options::storage_slots>("storage-slots", "N", "limit the storage of each tile to N records [the preset's slots]", {0, any_number}),
        option<&Options::renderer, &RendererOptions::held_slots>(
            "held", "N", "homes: limit the splats that a tile holds [--storage-slots, or what fits]", {1, any_number}),
        option<&Options::renderer, &RendererOptions::rounds>("rounds", "N|all", "homes: end a frame after N rounds, complete or not [all]",
                                                             {1, any_number}, all_rounds),
        words<&Options::renderer, &RendererOptions::fold>("fold", "NAME", "homes: on (spread each part of the picture over the grid) | off [on]", folds),
        words<&Options::choice, &Choice::saturation>("saturation", "NAME", "a full channel: hold records back | drop copies [the preset's]", saturations),
        words<&Options::choice, &Choice::largest_first>("priority", "NAME", "a full tile keeps, a full channel takes: first (come) | largest [first]",
                                                        priorities),
        words<&Options::renderer, &RendererOptions::footprint>("footprint", "NAME", "{} [the preset's]", footprints),
        words<&Options::choice, &Choice::copies>("copies", "NAME", "bloom sends copies in {} coordinates [the preset's]", copies),
        option<&Options::renderer, &RendererOptions::hops>("hops", "N|quiet", "end routing, and bloom, of a frame after N exchanges [quiet]",
                                                           {1, any_number - 1}, quiet_hops),
        option<&Options::renderer, &RendererOptions::most_passes>("most-passes", "N", "stop with an error if routing, or bloom, needs more than N passes",
                                                                  {1, any_number}),
        words<&Options::choice, &Choice::pixels>("pixels", "NAME", "framebuffers of the tiles: {} [the preset's]", pixels),
        words<&Options::renderer, &RendererOptions::arithmetic>("arithmetic", "NAME",
                                                                "precise (bits of a naive loop) | fast (alpha within 2e-5 of it) [fast]", arithmetics),
        words<&Options::renderer, &RendererOptions::quality>("quality", "NAME", "see below: {} [the preset's]", qualities),
        words<&Options::choice, &Choice::fit>("fit", "NAME", "scene (leave out features that the scene does not need) | off [scene]", fits),
    });
}();

} // namespace render_map
