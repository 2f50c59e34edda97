#include "runs.hpp"
#include "../render_map/instruments.hpp"
#include "../render_map/reference.hpp"
#include "../render_map/renderers.hpp"
#include "../shared/sha256.hpp"
#include <algorithm>
#include <chrono>
#include <iterator>
#include <limits>
#include <memory>
#include <numeric>
#include <tilemesh/any_renderer.hpp>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/string_stream.hpp>
#include <tilemesh/splat/setup.hpp>
#include <utility>

namespace explore {

namespace {

namespace render = tilemesh::render;
namespace report = tilemesh::report;
namespace splat = tilemesh::splat;

render::SetupChoice preset_of(std::string const& name)
{
    return name == "paper" ? render::choice_of<splat::Paper>() : name == "prototype" ? render::choice_of<splat::Prototype>() : render::choice_of<splat::Lossless>();
}

tilemesh::RendererOptions options_of(Setting const& s, std::uint32_t threads)
{
    tilemesh::RendererOptions options;
    options.threads = threads;
    options.grid = s.grid;
    options.program = s.homes ? report::Program::homes : report::Program::anchored;
    options.quality = s.quality;
    return options;
}

/// An error of the renderer, with an advice that a study can follow.
std::string in_words_of_a_study(std::string const& error)
{
    constexpr char const* remedy = "name fewer slots in \"sizes\", a larger \"grid\" or a machine with more \"sram\"";
    if (error.find("does not fit in a tile's SRAM") != error.npos) return with_remedy(error, remedy);
    if (error.find(" slots hold ") != error.npos) // of all tiles: too few for the map
        return with_remedy(error, "name more slots of \"storage\" in \"sizes\", a larger \"grid\" or a machine with more \"sram\"");
    return error;
}

void size_anchored(Setting const& s, Sized& out)
{
    auto const& view = s.subject->views.front();
    auto const tiling = tilemesh::tiling_for(options_of(s, 1), view.width, view.height);
    tilemesh::Extent2 const tile{tiling.tile_width, tiling.tile_height};
    auto const& asked = s.capacities;
    auto setup = render::fitted(preset_of(s.preset), s.subject->map.sh_degree, true, true);
    setup = render::on_machine(setup, size_of(*s.machine), tile.width * tile.height);
    if (!asked.of_preset) {
        setup.sizes.road = asked.road.value_or(setup.sizes.road);
        setup.sizes.beam = asked.beam.value_or(setup.sizes.beam);
        if (setup.holds) setup.sizes.waiting = asked.waiting.value_or(setup.sizes.waiting);
        setup.sizes.tile_pixels = tile.width * tile.height;
        if (asked.storage) setup.sizes.storage = *asked.storage;
        else setup = render::fill_storage(setup, {s.grid.width, s.grid.height}, tile);
    }
    auto const facts = render::facts_of(setup); // refuses what does not fit
    out.anchored = setup;
    out.sram_bytes = facts.sram_bytes;
    out.storage = setup.sizes.storage;
    out.channel = std::max(setup.sizes.road, setup.sizes.beam);
    out.waiting = setup.sizes.waiting;
}

void size_homes(Setting const& s, Sized& out)
{
    auto const setup = render::fitted(preset_of(s.preset), s.subject->map.sh_degree, true, true);
    if (!setup.holds) throw tilemesh::Error("homes with preset " + s.preset + " (homes drop nothing); choose preset lossless");
    auto const& asked = s.capacities;
    render::HomesChoice homes;
    homes.name = setup.name;
    homes.fit = true;
    homes.sh_degree = s.subject->map.sh_degree;
    homes.colour = setup.colour;
    homes.rules = setup.rules;
    homes = render::on_machine(homes, size_of(*s.machine));
    if (!asked.of_preset) {
        homes.sizes.parcels = asked.road.value_or(homes.sizes.parcels);
        homes.sizes.waiting = asked.waiting.value_or(homes.sizes.waiting);
        homes.sizes.held = asked.storage.value_or(std::numeric_limits<std::int32_t>::max());
    }
    auto const& view = s.subject->views.front();
    auto const layout_of = [&] {
        return render::layout_homes(homes, options_of(s, 1), {view.width, view.height}, s.subject->map.gaussians.size());
    };
    auto const layout = [&] {
        if (!asked.of_preset && asked.storage) return layout_of();
        try {
            return layout_of();
        } catch (tilemesh::Error const&) { // of the preset or "the rest", which name no number: what does one slot lack?
            homes.sizes.held = 1;
            static_cast<void>(layout_of());
            throw tilemesh::Error((asked.of_preset ? "preset " + s.preset : "storage \"the rest\"") + " of homes on machine " + s.machine->name +
                                  " (beside homes and channels of " + std::to_string(homes.sizes.parcels) + " slots, a tile has room for fewer than " +
                                  std::to_string(render::least_held) + " splats); name fewer slots of \"channel\" in \"sizes\", a larger \"grid\" or a machine with more \"sram\"");
        }
    }();
    if (!asked.of_preset && asked.storage && layout.sizes.held < *asked.storage)
        throw tilemesh::Error("storage " + std::to_string(*asked.storage) + " of homes on machine " + s.machine->name + " (a tile has room for " +
                              std::to_string(layout.sizes.held) + " slots beside homes and channels); choose at most that many");
    homes.sizes = layout.sizes;
    homes.fit = false;
    out.homes = homes;
    out.sram_bytes = layout.ledger.bytes;
    out.storage = layout.sizes.held;
    out.channel = layout.sizes.parcels;
    out.waiting = layout.sizes.waiting;
}

} // namespace

Sized sizes_of(Setting const& s)
{
    Sized out;
    try {
        if (std::uint64_t{s.grid.width} * s.grid.height > s.machine->need("tiles"))
            throw tilemesh::Error("a grid of " + std::to_string(s.grid.width) + " x " + std::to_string(s.grid.height) + " tiles (machine " + s.machine->name +
                                  " has " + std::to_string(s.machine->need("tiles")) + "); choose a smaller grid");
        if (s.homes) size_homes(s, out);
        else size_anchored(s, out);
    } catch (tilemesh::Error const& error) {
        out.refused = in_words_of_a_study(error.what());
    }
    return out;
}

std::string run_key(Setting const& s, Sized const& sized)
{
    std::string text = s.subject->key;
    auto const add = [&](auto const& value) {
        text += ' ';
        if constexpr (std::is_arithmetic_v<std::decay_t<decltype(value)>>) text += std::to_string(value);
        else text += value;
    };
    add(s.homes ? "homes" : "anchored");
    add(s.preset);
    add(s.quality ? name(*s.quality) : "default");
    for (auto const n : {s.grid.width, s.grid.height, static_cast<std::uint32_t>(s.machine->need("workers"))}) add(n);
    auto const& a = sized.anchored.sizes;
    auto const& h = sized.homes.sizes;
    if (!sized.refused.empty()) add(sized.refused);
    else if (s.homes) for (auto const n : {h.homes, h.held, h.parcels, h.waiting}) add(n);
    else for (auto const n : {a.storage, a.road, a.beam, a.waiting, a.tile_pixels}) add(n);
    return text;
}

std::string point_digest(Setting const& s, std::string const& key)
{
    report::StringStream model; // a digest of a text that is cut short would be that of another point
    if (s.prices->model) write_cost_model(model, *s.prices->model);
    for (auto const& [parameter, value] : s.prices->changed) model << parameter << ' ' << value << '\n';
    return shared::sha256(std::to_string(TILEMESH_VERSION) + "\n" + s.name + "\n" + key + "\n" + machine_file_text(*s.machine) + model.str());
}

std::string refusal_of(tilemesh::Error const& error)
{
    return in_words_of_a_study(error.what());
}

std::vector<report::Image> references_of(Subject const& subject, std::uint32_t threads)
{
    std::vector<report::Image> out;
    for (auto const& view : subject.views) out.push_back(render_map::reference_of(subject.map, view, splat::Rules{}, report::Cuts::none, threads));
    return out;
}

Frames run(Setting const& s, Sized const& sized, std::vector<report::Image> const& references, std::uint32_t threads)
{
    auto const begin = std::chrono::steady_clock::now();
    auto const options = options_of(s, threads);
    auto const renderer = s.homes ? render_map::make_homes_traced(s.subject->map, sized.homes, options, render_map::EngineKind::threads)
                                  : render_map::make_anchored_traced(s.subject->map, render::facts_of(sized.anchored), options, render_map::EngineKind::threads);
    auto& instruments = dynamic_cast<render_map::Instruments&>(*renderer);
    Frames out;
    out.point.psnr_db = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < s.subject->views.size(); ++i) {
        auto frame = renderer->render(s.subject->views[i]);
        auto const& r = frame.report;
        auto const grid = renderer->grid();
        out.frames.push_back({instruments.take_trace(), {grid.width, grid.height}});
        out.point.psnr_db = std::min(out.point.psnr_db, report::compare(frame.image, references[i]).psnr_db);
        out.point.lost += r.lost.size() + r.unfinished.size();
        out.point.exchanges += r.exchanges.total();
        out.point.passes += r.passes.total();
        out.point.pairs += r.pairs;
        out.point.capacity_bytes += r.exchanged_capacity_bytes;
        if (i == 0) out.picture = std::move(frame.image);
    }
    out.point.sram_bytes = sized.sram_bytes;
    out.point.storage = sized.storage;
    out.point.channel = sized.channel;
    out.point.waiting = sized.waiting;
    out.point.host_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return out;
}

tilemesh::CostModel model_of(Setting const& s)
{
    auto model = s.prices->model ? *s.prices->model : cost_model_of(*s.machine);
    for (auto const& [parameter, value] : s.prices->changed) set_parameter(model, parameter, std::stoull(value), "guess: the study has it");
    return model;
}

Point priced(Setting const& s, Frames const& frames, std::string digest)
{
    auto const model = model_of(s);
    auto point = frames.point;
    point.name = s.name;
    point.map = s.subject->name;
    point.digest = std::move(digest);
    if (!s.prices->model) { // a parameter that the study sets is not unknown any more
        auto const names_of = [](std::string const& number) { return number == "barrier" ? std::string("sync") : number == "exchange_start" ? "exchange"
            : number == "exchange" ? "exchange_byte" : number; };
        for (auto const& number : s.machine->unknown()) {
            bool const set = std::any_of(s.prices->changed.begin(), s.prices->changed.end(), [&](auto const& change) { return change[0] == names_of(number); });
            bool const of_time = number != "host_link" && number != "code" && number != "columns" && number != "rows"; // the others are in no time
            if (!set && of_time) point.left_out += (point.left_out.empty() ? "" : ", ") + number;
        }
    }
    std::vector<std::uint64_t> busy;
    std::uint64_t sent_bytes = 0; // messages and heads
    std::uint64_t first_cycles = 0;
    for (auto const& frame : frames.frames) {
        auto const cost = model_cost(model, frame.trace, frame.grid);
        point.cycles += cost.cycles;
        if (&frame == &frames.frames.front()) first_cycles = cost.cycles;
        for (auto const& superstep : frame.trace.supersteps)
            for (auto const& tile : superstep.tiles) sent_bytes = std::accumulate(std::begin(tile.sent_bytes), std::end(tile.sent_bytes), sent_bytes);
        busy.resize(frame.grid.size());
        for (auto const& step : cost.busy)
            for (std::size_t t = 0; t < step.size(); ++t) busy[t] += step[t];
    }
    auto const later = static_cast<double>(frames.frames.size() - 1);
    point.modelled_ms = milliseconds(model, point.cycles) / static_cast<double>(frames.frames.size());
    point.first_ms = milliseconds(model, first_cycles);
    if (later > 0) point.later_ms = milliseconds(model, point.cycles - first_cycles) / later;
    auto const sum = std::accumulate(busy.begin(), busy.end(), 0.0);
    point.slowest_to_mean = sum > 0 ? static_cast<double>(*std::max_element(busy.begin(), busy.end())) * static_cast<double>(busy.size()) / sum : 1;
    point.exchanged_bytes = model.exchange_cost == tilemesh::ExchangeCost::capacity ? point.capacity_bytes : sent_bytes;
    return point;
}

} // namespace explore
