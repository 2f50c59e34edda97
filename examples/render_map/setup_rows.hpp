#pragma once
#include "../shared/option_table.hpp"
#include "options.hpp"
#include <array>

/// The options of render_map that choose the machine, its program and its rules.
namespace render_map {

namespace detail {

using shared::field;
using shared::Form;
using shared::option;
using shared::OptionValue;
using shared::Word;
using shared::words;
using tilemesh::RendererOptions;
using tilemesh::render::setup_field;
using tilemesh::render::setup_fields;

inline constexpr Word fits[] = {{"scene", true}, {"off", false}};

inline void set_machine(Options& o, OptionValue const& given)
{
    auto const text = given.text;
    o.machine_named = true;
    if (text.find_first_of("./") != text.npos) { // a name has neither
        o.machine = text;
        o.choice.machine = MachineKind::file;
    } else if (auto const machine = setup_fields[setup_field("machine")].values.read(text)) {
        o.choice.machine = static_cast<MachineKind>(static_cast<std::uint32_t>(*machine));
    } else {
        throw shared::Misfit{"there are mk2, test and files"};
    }
}

} // namespace detail

inline constexpr auto setup_rows = [] {
    using namespace detail;
    return std::to_array<shared::Option<Options>>({
        shared::listed<setup_field("preset"), &Options::choice, &Choice::fields>("lossless"),
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
        words<&Options::choice, &Choice::fit>("fit", "NAME", "scene (leave out features that the scene does not need) | off [scene]", fits),
    });
}();
inline constexpr auto renderer_rows = shared::rows_of_renderer<&Options::renderer>();
inline constexpr auto policy_rows =
    shared::rows_of_everyone([](auto field) { return shared::listed<field(), &Options::choice, &Choice::fields>("the preset's"); });

} // namespace render_map
