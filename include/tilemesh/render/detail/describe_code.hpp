#pragma once
#include <algorithm>
#include <tilemesh/render/describe.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/render/setup_fields.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

TILEMESH_HOST void describe(report::RunReport& run, splat::Setup setup, splat::Rules const& rules, RendererOptions const& options)
{
    setup.rules = rules;
    auto const limited = [](std::uint32_t asked, std::uint32_t own) { return asked != 0 ? std::min(asked, own) : own; };
    bool const homes = setup.program == splat::Program::homes;
    auto const& sizes = setup.sizes;
    run.machine = {setup.machine.name, setup.machine.sram_bytes,
                   limited(homes && options.held_slots != 0 ? options.held_slots : options.storage_slots, sizes.storage),
                   limited(options.channel_slots, homes || !setup.blooms ? (homes || setup.routes ? sizes.road : 0) : sizes.beam), ledger_of(setup)};
    run.preset = setup.name;
    run.program = options.program;
    run.threads = options.threads;
    run.quality = options.quality ? splat::name(*options.quality) : "default";
    auto const text = [&](std::size_t field) { return setup_fields[field].text(setup); };
    run.policies = {splat::RowFirst::name,
                    text(setup_field("addressing")),
                    text(setup_field("saturation")) + (setup.ranks ? ", largest first" : ""),
                    text(setup_field("footprint")),
                    text(setup_field("copies")),
                    text(setup_field("pixels")),
                    text(setup_field("arithmetic")),
                    options.hops,
                    options.rounds};
    run.cut_offs = {rules.alpha_min, rules.transmittance_min, rules.alpha_max};
    run.background = {rules.background[0], rules.background[1], rules.background[2]};
    run.setup.clear();
    for (auto const& field : setup_fields) {
        if (field.use == SetupField::several) continue;
        std::string name(field.name);
        std::replace(name.begin(), name.end(), '-', '_');
        run.setup.push_back({name, field.values.kind == Values::word ? field.text(setup) : "", field.get(setup)});
    }
}

}}} // namespace tilemesh::render
