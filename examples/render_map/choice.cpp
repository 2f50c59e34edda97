#include "choice.hpp"
#include "setups.hpp"
#include "variant.hpp"
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/splat/frame_program.hpp>

namespace render_map {

namespace {

namespace splat = tilemesh::splat;

template <class S>
Description description_of()
{
    using Machine = typename S::Machine;
    Description d;
    d.preset = S::name;
    d.machine = Machine::name;
    d.routing = S::Routing::name;
    d.addressing = S::Addressing::name;
    d.saturation = S::Saturation::name;
    d.copies = S::Copies::name;
    d.pixels = S::Pixel::name;
    d.sram_bytes = Machine::sram_bytes;
    auto const ledger = tilemesh::Tile<Machine, splat::Frame<S>>::ledger();
    d.ledger.assign(ledger.begin(), ledger.end());
    d.storage_slots = S::storage_slots;
    d.channel_slots = splat::Road<S>::static_capacity;
    static_assert(splat::Road<S>::static_capacity == splat::Beam<S>::static_capacity,
                  "--channel-slots is one number for both channels");
    d.footprint = S::footprint;
    d.arithmetic = S::arithmetic;
    return d;
}

template <class Base>
Description describe_on(Choice const& choice)
{
    auto const description = []<class S>(Type<S>) { return description_of<S>(); };
    auto const on = [&]<class Machine>(Type<Machine>) {
        return choice.planes() ? with_planes<Machine>(choice, description) : with_policies<Machine>(choice, description);
    };
    return choice.machine == MachineKind::mk2 ? on(Type<Base>{}) : on(Type<splat::Roomy<Base>>{});
}

} // namespace

Description describe(Choice const& choice)
{
    switch (choice.preset) {
    case Preset::lossless:
        return describe_on<splat::Lossless>(choice);
    case Preset::paper:
        return describe_on<splat::Paper>(choice);
    case Preset::prototype:
        break;
    }
    return describe_on<splat::Prototype>(choice);
}

namespace {

/// Harmonics are compiled with the preset's own policies, on host threads.
void require_compiled_for_harmonics(Choice const& choice, std::uint32_t degree)
{
    std::string option;
    if (choice.trace)
        throw tilemesh::Error("--trace with a map of view-dependent colour, degree " + std::to_string(degree) +
                              " (the machine that keeps a trace is compiled for records of degree 0); add --sh-degree 0");
    Choice preset;
    preset.preset = choice.preset;
    preset.machine = choice.machine;
    auto const own = describe(preset), asked = describe(choice);
    if (choice.preset == Preset::prototype) option = "--preset prototype";
    else if (choice.engine == EngineKind::sequential) option = "--engine sequential";
    else if (choice.planes() && choice.preset != Preset::lossless) option = choice.depth ? "--depth" : "--alpha";
    else if (asked.saturation != own.saturation) option = "--saturation " + asked.saturation;
    else if (asked.copies != own.copies) option = "--copies " + asked.copies;
    else if (!choice.planes() && asked.pixels != own.pixels) option = "--pixels " + asked.pixels;
    if (choice.planes() && choice.preset == Preset::paper)
        throw tilemesh::Error(option + " with preset paper and a map of view-dependent colour, degree " + std::to_string(degree) +
                              " (planes of such a map are compiled for preset lossless); leave out --preset, or add --sh-degree 0");
    if (!option.empty())
        throw tilemesh::Error(option + " with a map of view-dependent colour, degree " + std::to_string(degree) +
                              " (this program has harmonics with the own policies of presets lossless and paper, on host "
                              "threads); leave it out, or add --sh-degree 0");
}

/// Whether the demand may choose the setup: lossless as it is, on host threads.
bool may_be_fitted(Choice const& choice)
{
    Choice own;
    own.machine = choice.machine;
    auto const is = describe(own), asked = describe(choice);
    return choice.preset == Preset::lossless && choice.engine == EngineKind::threads && !choice.planes() && !choice.trace &&
           asked.saturation == is.saturation && asked.copies == is.copies && asked.pixels == is.pixels;
}

std::unique_ptr<AnyRenderer> make_unchecked(Choice const& choice, tilemesh::scene::Map const& map,
                                            tilemesh::scene::Demand const& demand, tilemesh::RendererOptions options)
{
    bool const threads = choice.engine == EngineKind::threads;
    bool const mk2 = choice.machine == MachineKind::mk2;
    if (may_be_fitted(choice))
        if (auto fitted = (mk2 ? fitted_mk2 : fitted_test)(map, demand, options)) return fitted;

    auto const needed = tilemesh::scene::needed(map, demand);
    if (choice.trace) return (choice.preset == Preset::lossless ? lossless_traced : paper_traced)(choice, needed, options);
    if (demand.sh_degree != 0) return (choice.planes() ? shaded_planes : paper_shaded)(choice, needed, options);
    if (choice.planes()) return (choice.preset == Preset::lossless ? lossless_planes : paper_planes)(choice, needed, options);
    auto const pick = [&](MakeRenderer& on_mk2, MakeRenderer& sequential_on_mk2, MakeRenderer& on_test,
                          MakeRenderer& sequential_on_test) {
        return mk2 ? (threads ? on_mk2 : sequential_on_mk2)(choice, needed, options)
                   : (threads ? on_test : sequential_on_test)(choice, needed, options);
    };
    return choice.preset == Preset::lossless
               ? pick(lossless_mk2_threads, lossless_mk2_sequential, lossless_test_threads, lossless_test_sequential)
               : pick(paper_mk2_threads, paper_mk2_sequential, paper_test_threads, paper_test_sequential);
}

} // namespace

std::unique_ptr<AnyRenderer> make_renderer(Choice const& choice, tilemesh::scene::Map const& map,
                                           tilemesh::scene::Demand const& demand, tilemesh::RendererOptions options)
{
    if (demand.sh_degree != 0) require_compiled_for_harmonics(choice, demand.sh_degree);
    // `prototype` is `paper` with fewer slots: a run-time limit gives the same frames and counters as a setup of its own,
    // and saves 32 compiled setups.
    if (choice.preset == Preset::prototype) {
        auto const own = describe(choice);
        if (options.storage_slots == 0) options.storage_slots = own.storage_slots;
        if (options.channel_slots == 0) options.channel_slots = own.channel_slots;
    }
    auto renderer = make_unchecked(choice, map, demand, options);
    renderer->hold_to(demand);
    auto const at_most = [&](char const* option, std::uint32_t asked, std::uint32_t most) {
        if (asked > most && most != 0)
            throw tilemesh::Error(std::string(option) + " cannot be " + std::to_string(asked) + " (records of degree " +
                                  std::to_string(demand.sh_degree) + " leave " + std::to_string(most) +
                                  "); choose fewer, or a lower --sh-degree");
    };
    at_most("--storage-slots", options.storage_slots, renderer->storage_slots());
    at_most("--channel-slots", options.channel_slots, renderer->channel_slots());
    return renderer;
}

} // namespace render_map
