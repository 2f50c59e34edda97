#include "runs.hpp"
#include "../render_map/reference.hpp"
#include "../shared/process.hpp"
#include "../shared/sha256.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <iterator>
#include <limits>
#include <numeric>
#include <tilemesh/config.hpp>
#include <tilemesh/model/confidence.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/render/homes_layout.hpp>
#include <tilemesh/render/renderer_fields.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/string_stream.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <utility>

namespace explore {

namespace {

namespace render = tilemesh::render;
namespace report = tilemesh::report;
namespace splat = tilemesh::splat;

tilemesh::RendererOptions options_of(Setting const& s, std::uint32_t threads)
{
    tilemesh::RendererOptions options;
    options.threads = threads;
    options.grid = s.grid;
    options.program = s.homes ? report::Program::homes : report::Program::anchored;
    options.trace = true;
    options.quality = s.quality;
    if (s.subject->antialias) options.coverage = splat::Coverage::preserved;
    return options;
}

/// What the sizes use of a tile's SRAM. A tile without room for one more slot of storage is full: what is left is only rounding.
std::uint64_t used_sram(Setting const& s, std::uint64_t bytes, std::uint64_t with_one_slot_more)
{
    auto const sram = s.machine->need("sram");
    return with_one_slot_more > sram ? sram : bytes;
}

tilemesh::Extent2 tile_of(Setting const& s)
{
    auto const& view = s.subject->views.front();
    auto const tiling = tilemesh::tiling_for(options_of(s, 1), view.width, view.height);
    return {tiling.tile_width, tiling.tile_height};
}

/// An error of the renderer, with an advice that a study can follow.
std::string in_words_of_a_study(std::string const& error)
{
    if (error.find("does not fit in a tile's SRAM") != error.npos)
        return with_remedy(error, "name fewer slots in \"sizes\", or a machine with more \"sram\"");
    if (error.find(" slots hold ") != error.npos) // of all tiles: too few for the map
        return with_remedy(error, "name more slots of \"storage\" in \"sizes\", a larger \"grid\" or a machine with more \"sram\"");
    return error;
}
/// The advice for a setting that does not fit. With one slot of each list it takes `least` bytes, and on all of the machine's tiles `small`.
std::string room_advice(Setting const& s, std::uint64_t least, std::uint64_t small)
{
    auto const sram = s.machine->need("sram");
    if (least <= sram) return "name fewer slots in \"sizes\", or a machine with more \"sram\"";
    std::string const grid = small <= sram ? "name a larger \"grid\" and fewer slots in \"sizes\", or" : "name";
    return grid + " a machine with more \"sram\" than " + report::thousands(least) + " bytes: one slot of each list takes these, and a picture several times as many";
}

render::Setup anchored_of(Setting const& s)
{
    auto fields = s.policies;
    fields.emplace_back("preset", s.preset);
    return render::fitted(with(splat::lossless, fields), s.subject->map.sh_degree, true, true);
}
std::string anchored_advice(Setting const& s)
{
    auto setup = anchored_of(s);
    auto const tile = tile_of(s);
    auto const& view = s.subject->views.front();
    auto const tiles = s.machine->need("tiles");
    setup.machine = size_of(*s.machine);
    for (auto* slots : {&setup.sizes.storage, &setup.sizes.road, &setup.sizes.beam, &setup.sizes.waiting}) *slots = std::min(*slots, 1u);
    setup.sizes.tile_pixels = tile.width * tile.height;
    auto const least = render::sram_bytes_of(setup);
    setup.sizes.tile_pixels = static_cast<std::uint32_t>((std::uint64_t{view.width} * view.height + tiles - 1) / tiles);
    return room_advice(s, least, render::sram_bytes_of(setup));
}

void size_anchored(Setting const& s, Sized& out)
{
    auto const tile = tile_of(s);
    auto const& asked = s.capacities;
    auto setup = render::on_machine(anchored_of(s), size_of(*s.machine), tile.width * tile.height);
    if (!asked.of_preset) {
        auto const waiting = setup.sizes.waiting;
        setup = with(setup, asked.channels);
        if (!setup.holds) setup.sizes.waiting = waiting; // a setup that drops has no FIFOs
        setup.sizes.tile_pixels = tile.width * tile.height;
        if (asked.storage) setup.sizes.storage = *asked.storage;
        else setup = render::fill_storage(setup, {s.grid.width, s.grid.height}, tile);
    }
    render::check_setup(setup);
    out.anchored = setup;
    ++setup.sizes.storage;
    out.sram_bytes = used_sram(s, render::sram_bytes_of(out.anchored), render::sram_bytes_of(setup));
    out.storage = out.anchored.sizes.storage;
    out.channel = setup.sizes.road;
    out.beam = setup.sizes.beam;
    out.waiting = setup.sizes.waiting;
}

render::HomesLayout layout_of(Setting const& s, render::Setup const& homes)
{
    auto const& view = s.subject->views.front();
    return render::layout_homes(homes, options_of(s, 1), {view.width, view.height}, s.subject->map.gaussians.size());
}
/// The homes of a setting with the slots of its preset, as far as they fit on the machine.
render::Setup homes_of(Setting const& s)
{
    auto const setup = anchored_of(s);
    auto homes = splat::homes_setup;
    homes.name = setup.name;
    homes.fit = true;
    homes.district = 0;
    homes.sh_degree = s.subject->map.sh_degree;
    homes.colour = setup.colour;
    homes.rules = setup.rules;
    auto kept = homes;
    kept.machine = size_of(*s.machine);
    auto const& view = s.subject->views.front();
    bool const fits = render::keeps_sizes(kept, options_of(s, 1), {view.width, view.height}, s.subject->map.gaussians.size());
    return fits ? kept : render::on_machine(homes, kept.machine, 0);
}
std::string homes_advice(Setting const& s)
{
    auto homes = homes_of(s);
    homes.fit = false;
    for (auto* slots : {&homes.sizes.homes, &homes.sizes.storage, &homes.sizes.road, &homes.sizes.waiting}) *slots = 1;
    homes.machine.sram_bytes = std::numeric_limits<std::uint32_t>::max();
    homes.district = std::bit_ceil(std::max(s.grid.width, s.grid.height)); // one window, which takes least
    auto const least = tilemesh::render::sram_bytes_of(layout_of(s, homes).setup);
    return room_advice(s, least, least);
}
/// Refuses a preset's storage, or "the rest", of less than `least_held` slots: with the bytes that are missing, and a number that does run.
[[noreturn]] void refuse_rest(Setting const& s, render::Setup homes)
{
    auto const homes_with = [&s](render::Setup const& c) { // of a tile; 0: it does not fit
        try {
            return layout_of(s, c).setup.sizes.homes;
        } catch (tilemesh::Error const&) {
            return 0u;
        }
    };
    auto narrow = homes;
    narrow.sizes.road = narrow.sizes.waiting = 1;
    bool const narrow_fits = homes_with(narrow) != 0;
    homes.sizes.storage = 1;
    auto sizes = layout_of(s, homes).setup.sizes; // refuses what does not fit even so
    auto runs = render::least_held;
    auto held_homes = 0u;
    for (; runs > 1; runs /= 2) {
        homes.sizes.storage = runs;
        held_homes = homes_with(homes);
        if (held_homes != 0) break;
    }
    auto const grid = std::uint64_t{s.grid.width} * s.grid.height;
    sizes.homes = static_cast<std::uint32_t>((s.subject->map.gaussians.size() + grid - 1) / grid);
    sizes.storage = render::least_held;
    homes.sizes = sizes;
    auto const bytes = render::sram_bytes_of(homes), sram = std::uint64_t{homes.machine.sram_bytes};
    auto const count = [](std::uint64_t n) { return report::thousands(n); };
    auto const what = s.capacities.of_preset ? "preset " + s.preset : std::string("storage \"the rest\"");
    throw tilemesh::Error(what + " of homes on machine " + s.machine->name + " (" + count(render::least_held) +
                          " slots of storage, the fewest that are chosen unasked, are " + count(bytes - std::min(bytes, sram)) + " bytes over beside " +
                          count(sizes.homes) + " homes and channels of " + count(sizes.road) + " slots); name a number of \"storage\" in \"sizes\", as " +
                          count(runs) + (held_homes != 0 && held_homes < sizes.homes ? " (the map then comes in chapters)" : "") +
                          (narrow_fits ? ", fewer slots of \"channel\" and \"waiting\"," : "") + " or a machine with more \"sram\"");
}

void size_homes(Setting const& s, Sized& out)
{
    auto homes = homes_of(s);
    auto const& asked = s.capacities;
    if (!asked.of_preset) {
        homes = with(homes, asked.channels);
        homes.sizes.storage = asked.storage.value_or(std::numeric_limits<std::int32_t>::max());
    }
    auto const layout = [&] {
        if (!asked.of_preset && asked.storage) return layout_of(s, homes);
        try {
            return layout_of(s, homes);
        } catch (tilemesh::Error const&) { // of the preset or "the rest", which name no number
            refuse_rest(s, homes);
        }
    }();
    if (!asked.of_preset && asked.storage && layout.setup.sizes.storage < *asked.storage)
        throw tilemesh::Error("storage " + std::to_string(*asked.storage) + " of homes on machine " + s.machine->name + " (a tile has room for " +
                              std::to_string(layout.setup.sizes.storage) + " slots beside homes and channels); choose at most that many");
    homes.sizes = layout.setup.sizes;
    homes.fit = false;
    homes.district = layout.setup.district;
    out.homes = homes;
    ++homes.sizes.storage;
    out.sram_bytes = used_sram(s, tilemesh::render::sram_bytes_of(layout.setup), render::sram_bytes_of(homes));
    out.storage = layout.setup.sizes.storage;
    out.channel = layout.setup.sizes.road;
    out.waiting = layout.setup.sizes.waiting;
}

} // namespace

Sized sizes_of(Setting const& s)
{
    Sized out;
    try {
        if (std::uint64_t{s.grid.width} * s.grid.height > s.machine->need("tiles"))
            throw tilemesh::Error("a grid of " + std::to_string(s.grid.width) + " x " + std::to_string(s.grid.height) + " tiles (machine " + s.machine->name +
                                  " has " + std::to_string(s.machine->need("tiles")) + "); choose a smaller grid");
        if (std::uint64_t{s.grid.width} * s.grid.height > most_tiles)
            throw tilemesh::Error("a grid of " + std::to_string(s.grid.width) + " x " + std::to_string(s.grid.height) + " tiles (machine " +
                                  s.machine->name + "; explore takes at most " + report::thousands(most_tiles) +
                                  "); give the machine fewer \"columns\" and \"rows\", or all machines a smaller \"grid\"");
        if (auto const only = render::only_anchored(anchored_of(s), {}); s.homes && only)
            throw tilemesh::Error("homes with " + only.text() + "; leave it out, or choose preset lossless");
        try {
            if (s.homes) size_homes(s, out);
            else size_anchored(s, out);
        } catch (tilemesh::Error const& error) {
            std::string const text = error.what();
            if (text.find("does not fit in a tile's SRAM") == text.npos) throw;
            out.refused = with_remedy(text, s.homes ? homes_advice(s) : anchored_advice(s));
        }
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
    for (auto const& policy : s.policies) add(policy.name + " " + policy.text);
    add(s.quality ? name(*s.quality) : "default");
    for (auto const n : {s.grid.width, s.grid.height, static_cast<std::uint32_t>(s.machine->need("workers"))}) add(n);
    auto const& a = sized.anchored.sizes;
    auto const& h = sized.homes.sizes;
    if (!sized.refused.empty()) add(sized.refused);
    else if (s.homes) for (auto const n : {h.homes, h.storage, h.road, h.waiting, sized.homes.district}) add(n);
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
    splat::Rules rules;
    if (subject.antialias) rules.coverage = splat::Coverage::preserved;
    for (auto const& view : subject.views) {
        if (shared::interrupt() != 0) throw Interrupted{};
        out.push_back(render_map::reference_of(subject.map, view, rules, report::Cuts::none, threads));
    }
    return out;
}

Frames run(Setting const& s, Sized const& sized, std::vector<report::Image> const& references, std::uint32_t threads)
{
    auto const begin = std::chrono::steady_clock::now();
    auto const options = options_of(s, threads);
    tilemesh::Renderer renderer{s.subject->map, s.homes ? sized.homes : sized.anchored, options};
    renderer.observe([](auto const&) { // a frame may take minutes
        if (shared::interrupt() != 0) throw Interrupted{};
    });
    Frames out;
    out.point.psnr_db = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < s.subject->views.size(); ++i) {
        auto frame = renderer.render(s.subject->views[i]);
        auto const& r = frame.report;
        auto const grid = renderer.grid();
        out.frames.push_back({renderer.trace(), {grid.width, grid.height}});
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
    out.point.beam = sized.beam;
    out.point.waiting = sized.waiting;
    out.point.host_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return out;
}

tilemesh::CostModel model_of(Setting const& s)
{
    auto model = s.prices->model ? *s.prices->model : cost_model_of(*s.machine);
    for (auto const& [parameter, value] : s.prices->changed) set_parameter(model, parameter, value, "guess: the study has it");
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
            auto const sets = [&](auto const& change) { return change.first == names_of(number); };
            bool const set = std::any_of(s.prices->changed.begin(), s.prices->changed.end(), sets);
            bool const of_time = number != "host_link" && number != "code" && number != "columns" && number != "rows"; // the others are in no time
            if (!set && of_time) point.left_out += (point.left_out.empty() ? "" : ", ") + number;
        }
    }
    std::vector<std::uint64_t> busy;
    std::uint64_t sent_bytes = 0; // messages and heads
    std::uint64_t first_cycles = 0;
    std::array<std::uint64_t, tilemesh::price_kind_names.size()> by_kind{};
    std::vector<tilemesh::Confidence> known;
    for (auto const& frame : frames.frames) {
        auto const cost = model_cost(model, frame.trace, frame.grid);
        point.cycles += cost.cycles;
        known.push_back(confidence_of(model, frame.trace, cost));
        for (std::size_t k = 0; k < by_kind.size(); ++k) by_kind[k] += known.back().cycles[k];
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
    point.whole_channels = model.exchange_cost == tilemesh::ExchangeCost::capacity;
    point.exchanged_bytes = point.whole_channels ? point.capacity_bytes : sent_bytes;
    std::size_t weakest = by_kind.size() - 1;
    while (weakest > 0 && by_kind[weakest] == 0) --weakest;
    point.weakest = tilemesh::price_kind_names[weakest];
    point.weakest_share = point.cycles != 0 ? static_cast<double>(by_kind[weakest]) / static_cast<double>(point.cycles) : 0;
    std::vector<std::string> names;
    for (auto const& one : known) { // those of the first frame with the most cycles come first
        if (static_cast<std::size_t>(one.weakest) != weakest) continue;
        for (auto const& name : one.names)
            if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
    for (auto const& name : names) point.weakest += (&name == names.data() ? ": " : ", ") + name;
    return point;
}

} // namespace explore
