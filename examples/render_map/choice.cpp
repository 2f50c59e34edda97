#include "choice.hpp"
#include "setups.hpp"
#include "variant.hpp"
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

std::unique_ptr<AnyRenderer> make_renderer(Choice const& choice, tilemesh::scene::Map const& map,
                                           tilemesh::RendererOptions options)
{
    // `prototype` is `paper` with fewer slots: a run-time limit gives the same frames and counters as a setup of its own,
    // and saves 32 compiled setups.
    if (choice.preset == Preset::prototype) {
        auto const own = describe(choice);
        if (options.storage_slots == 0) options.storage_slots = own.storage_slots;
        if (options.channel_slots == 0) options.channel_slots = own.channel_slots;
    }
    if (choice.planes()) return (choice.preset == Preset::lossless ? lossless_planes : paper_planes)(choice, map, options);
    bool const threads = choice.engine == EngineKind::threads;
    bool const mk2 = choice.machine == MachineKind::mk2;
    auto const pick = [&](MakeRenderer& on_mk2, MakeRenderer& sequential_on_mk2, MakeRenderer& on_test,
                          MakeRenderer& sequential_on_test) {
        return mk2 ? (threads ? on_mk2 : sequential_on_mk2)(choice, map, options)
                   : (threads ? on_test : sequential_on_test)(choice, map, options);
    };
    return choice.preset == Preset::lossless
               ? pick(lossless_mk2_threads, lossless_mk2_sequential, lossless_test_threads, lossless_test_sequential)
               : pick(paper_mk2_threads, paper_mk2_sequential, paper_test_threads, paper_test_sequential);
}

} // namespace render_map
