#include "measure.hpp"
#include "packed.hpp"
#include <algorithm>
#include <cmath>
#include <common/compact.hpp>
#include <common/homes_machine.hpp>
#include <common/machine.hpp>
#include <cstring>
#include <functional>
#include <iostream>
#include <limits>
#include <numeric>
#include <optional>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <utility>

namespace policies {

namespace {

namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
namespace render = tilemesh::render;
using tilemesh::report::Image;

tilemesh::CostModel const& cost_model()
{
    static tilemesh::CostModel const model = tilemesh::mk2();
    return model;
}
double psnr(Image const& image, Image const& exact)
{
    bool const same = image.rgb.size() == exact.rgb.size() &&
                      std::memcmp(image.rgb.data(), exact.rgb.data(), image.rgb.size() * sizeof(float)) == 0;
    return same ? std::numeric_limits<double>::infinity() : tilemesh::report::compare(image, exact).psnr_db;
}

/// The map as it is after its records were packed into so many bytes; 60: as it is.
scene::Map packed(scene::Map map, std::uint32_t bytes)
{
    auto const box = splat::CompactBox::of(map.gaussians.data(), static_cast<std::uint32_t>(map.gaussians.size()));
    for (auto& g : map.gaussians) {
        splat::Compact32 half;
        splat::Compact16 quarter;
        if (bytes == 32 ? !try_pack(g, half) : bytes == 16 && !try_pack(g, box, quarter))
            throw tilemesh::Error("Gaussian " + std::to_string(static_cast<std::uint32_t>(g.id)) + " of " + map.name + " in " +
                                  std::to_string(bytes) + " bytes (a number of it has no place there); choose another map");
        if (bytes == 32) g = unpacked(half);
        if (bytes == 16) g = unpacked(quarter, box);
    }
    return map;
}

/// A policy of the anchored program: what it changes in the setup `lossless`.
struct Policy {
    std::string name;
    bool holds = true, ranks = false, limited = false; ///< limited: to the slots of the authors' public code
    std::uint32_t hops = 0;
    std::uint32_t record_bytes = 60;
};

class Measurement {
public:
    Measurement(bench::Scene const& s, Options const& options, std::vector<Row>& rows, std::vector<Products>& products,
                std::vector<std::string>& broken)
        : scene_(s), options_(options), grid_(options.quick ? tilemesh::Grid{10, 9} : tilemesh::Grid{40, 36}), rows_(rows),
          products_(products), broken_(broken)
    {}

    void all()
    {
        view("whole", {scene_.camera});
        std::string const motion = options_.quick ? "orbit0.5" : "fr1_xyz";
        if (bench::has_motion(motion, options_.data)) view(motion, bench::cameras_of(motion, scene_, 4, options_.data));
    }

private:
    void view(std::string const& name, std::vector<splat::Camera> const& cameras)
    {
        view_ = name;
        cameras_ = cameras;
        auto rules = bench::HomesSetting::precise();
        if (options_.spoil) rules.alpha_max = bench::spoilt_alpha_max;
        exact_ = tilemesh::report::render_naive(scene_.map.gaussians, cameras.back(), rules);
        for (std::uint32_t const bytes : {60u, 32u, 16u}) homes(bytes);
        std::uint32_t const hops = options_.quick ? 4 : 40;
        Policy const policies[] = {{"hold, first come"},
                                   {.name = "hold, largest first", .ranks = true},
                                   {.name = "hold, records of 32 bytes", .record_bytes = 32},
                                   {.name = "hold, records of 16 bytes", .record_bytes = 16},
                                   {.name = "hold, records of 32 bytes, largest first", .ranks = true, .record_bytes = 32},
                                   {.name = "drop, few slots, first come", .holds = false, .limited = true},
                                   {.name = "drop, few slots, largest first", .holds = false, .ranks = true, .limited = true},
                                   {.name = "hold, few slots, first come", .limited = true},
                                   {.name = "hold, few slots, largest first", .ranks = true, .limited = true},
                                   {.name = "hold, " + std::to_string(hops) + " hops, first come", .hops = hops},
                                   {.name = "hold, " + std::to_string(hops) + " hops, largest first", .ranks = true, .hops = hops}};
        for (auto const& policy : policies) anchored(policy);
    }
    void complain(Row const& row, std::string const& what)
    {
        broken_.push_back(row.map + ", " + row.view + ", " + row.policy + ": " + what);
    }
    Row& add(std::string policy)
    {
        rows_.push_back({});
        auto& row = rows_.back();
        row.map = scene_.map.name, row.view = view_, row.policy = std::move(policy);
        return row;
    }
    tilemesh::RunCost fill(Row& row, tilemesh::report::FrameReport const& r, tilemesh::Trace const& trace, Image const& image, bool rounded,
                          tilemesh::CostModel const& model = cost_model())
    {
        row.exchanges = r.exchanges.total();
        row.exchanged_bytes = r.exchanged_live_bytes;
        row.host_ms = r.host_ms.total - r.host_ms.picture;
        row.missing = r.lost.size();
        row.lossy = rounded || row.missing != 0;
        row.psnr_db = psnr(image, exact_);
        auto cost = tilemesh::model_cost(model, trace, grid_);
        std::uint64_t cycles = 0;
        for (auto const& s : cost.supersteps) cycles += s.total();
        row.modelled_ms = tilemesh::milliseconds(model, cycles);
        std::vector<std::uint64_t> busy(grid_.size(), 0);
        for (auto const& step : cost.busy)
            for (std::size_t t = 0; t < step.size(); ++t) busy[t] += step[t];
        auto const sum = std::accumulate(busy.begin(), busy.end(), std::uint64_t{0});
        if (sum != 0)
            row.slowest_over_mean = static_cast<double>(*std::max_element(busy.begin(), busy.end())) * grid_.size() /
                                    static_cast<double>(sum);
        if (!row.lossy && !std::isinf(row.psnr_db)) complain(row, "nothing is missing and the picture is not the naive one");
        if (row.sram_bytes > tilemesh::Mk2::sram_bytes) complain(row, std::to_string(row.sram_bytes) + " bytes do not fit into a tile");
        std::cerr << row.map << ", " << row.view << ", " << row.policy << "\n";
        return cost;
    }
    void homes(std::uint32_t record_bytes)
    {
        auto& row = add(record_bytes == 60 ? "homes" : "homes, records of " + std::to_string(record_bytes) + " bytes");
        auto const map = packed(scene_.map, record_bytes);
        auto const machine = bench::make_homes_machine(map, {.threads = options_.threads, .grid = grid_});
        for (auto const& camera : cameras_) machine->render(camera);
        // Only the records on their home tiles are packed: tiles send splats.
        std::uint64_t const records = (map.gaussians.size() + grid_.size() - 1) / grid_.size();
        row.sram_bytes = machine->sram_bytes() - (60 - record_bytes) * records;
        row.storage = machine->setting().held;
        auto const& trace = machine->trace();
        auto const cost = fill(row, machine->report(), trace, machine->image(), record_bytes != 60);
        if (record_bytes == 60 && view_ == "whole") products(machine->report(), trace, cost);
    }
    void anchored(Policy const& policy)
    {
        auto& row = add(policy.name);
        auto setup = splat::setup_of<splat::Lossless>();
        setup.rules.arithmetic = splat::Arithmetic::precise;
        setup.holds = policy.holds;
        setup.ranks = policy.ranks;
        auto const before = setup;
        setup.own_record_bytes = policy.record_bytes;
        setup = splat::refitted(setup, before); // more slots in the same bytes
        row.sram_bytes = tilemesh::render::sram_bytes_of(setup);
        tilemesh::RendererOptions options{.threads = options_.threads, .grid = {grid_.width, grid_.height}, .keep_pixels = false};
        options.hops = policy.hops;
        row.storage = setup.sizes.storage;
        if (policy.limited) {
            options.channel_slots = options_.quick ? 20 : 100;
            options.storage_slots = row.storage = options_.quick ? 700 : 800;
            row.sram_bytes -= (setup.sizes.storage - row.storage) * std::uint64_t{splat::slot_bytes(before)} +
                              8 * (setup.sizes.road - options.channel_slots) * std::uint64_t{splat::road_bytes(before)} +
                              8 * (setup.sizes.beam - options.channel_slots) * std::uint64_t{splat::beam_bytes(before)};
        }
        auto const machine = bench::make_traced_machine(packed(scene_.map, policy.record_bytes), setup, options);
        for (auto const& camera : cameras_) machine->render(camera);
        if (policy.record_bytes != 60) return stored_packed(policy, row, options, *machine);
        (void)fill(row, machine->report(), machine->trace(), machine->image(), false);
        // What the bench shows must be so: a rank is worth its time on full tiles of a first view.
        if (policy.ranks && policy.limited && view_ == "whole" && row.missing != 0) {
            auto const& first = rows_[rows_.size() - 2];
            if (row.psnr_db < first.psnr_db) complain(row, "first come is nearer to the exact picture");
        }
    }

    /// A program whose tiles store and send packed records. It must do what `by_floats` does: the program whose records were rounded before
    /// they were loaded.
    void stored_packed(Policy const& policy, Row& row, tilemesh::RendererOptions const& options, bench::TracedMachine const& by_floats)
    {
        auto const box = splat::CompactBox::of(scene_.map.gaussians.data(), static_cast<std::uint32_t>(scene_.map.gaussians.size()));
        auto const machine = make_packed_machine(packed(scene_.map, policy.record_bytes), policy.record_bytes, policy.ranks, box, options);
        for (auto const& camera : cameras_) machine->render(camera);
        auto const &r = machine->report(), &other = by_floats.report();
        if (psnr(machine->image(), by_floats.image()) < std::numeric_limits<double>::infinity())
            complain(row, "the picture is not that of rounded records");
        if (r.exchanges.total() != other.exchanges.total() || r.messages != other.messages || r.hops != other.hops ||
            r.exchanged_live_bytes != other.exchanged_live_bytes || r.copies != other.copies || r.lost.size() != other.lost.size())
            complain(row, "it exchanges or lacks other records than the program of rounded records");
        auto const box_bytes = policy.record_bytes == 16 ? sizeof box : 0;
        if (tilemesh::render::sram_bytes_of(machine->setup()) != row.sram_bytes + box_bytes || machine->setup().sizes.storage != row.storage)
            complain(row, "its ledger is not that of smaller records");
        row.sram_bytes = tilemesh::render::sram_bytes_of(machine->setup());
        (void)fill(row, r, machine->trace(), machine->image(), true, model_with_unpacking(policy.record_bytes));
    }

    /// The picture with colours, and if asked weights, rounded to half precision; sums are floats.
    Image rounded(bool weights)
    {
        using splat::detail::half_bits;
        using splat::detail::half_value;
        auto map = scene_.map;
        for (auto& g : map.gaussians)
            for (float& c : g.colour) c = half_value(half_bits(c));
        auto const rules = bench::HomesSetting::precise();
        if (!weights) return tilemesh::report::render_naive(map.gaussians, cameras_.back(), rules);
        auto const& camera = cameras_.back();
        auto const view = splat::make_view(camera, rules);
        auto const tiling = splat::make_tiling(camera.width, camera.height, camera.width, camera.height);
        std::vector<std::pair<splat::Splat, splat::GaussianId>> items;
        for (auto const& g : map.gaussians)
            if (auto const s = splat::project(g, view, tiling); s.visible()) items.emplace_back(s, g.id);
        std::sort(items.begin(), items.end(), [](auto const& a, auto const& b) {
            return a.first.depth_key != b.first.depth_key ? a.first.depth_key < b.first.depth_key : a.second < b.second;
        });
        float const lowest = splat::lowest_power_for(rules.alpha_min);
        Image image(camera.width, camera.height);
        std::vector<float> left(std::size_t{camera.width} * camera.height, 1.0f);
        for (auto const& item : items) {
            auto const& s = item.first;
            auto const r = s.rect();
            for (auto y = r.y0; y < r.y1; ++y)
                for (auto x = r.x0; x < r.x1; ++x) {
                    float& t = left[std::size_t{y} * camera.width + x];
                    if (t < rules.transmittance_min) continue;
                    float const dx = static_cast<float>(x) + 0.5f - camera.cx, dy = static_cast<float>(y) + 0.5f - camera.cy;
                    float const alpha = std::min(splat::alpha_at(s, dx, dy, lowest), rules.alpha_max);
                    if (alpha < rules.alpha_min) continue;
                    float const weight = half_value(half_bits(alpha * t));
                    for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] += weight * s.colour[c];
                    t -= alpha * t;
                }
        }
        return image;
    }
    void products(tilemesh::report::FrameReport const& r, tilemesh::Trace const& trace, tilemesh::RunCost const& cost)
    {
        Products p;
        p.map = scene_.map.name;
        double all = 0, blend = 0;
        for (auto const& s : cost.supersteps) {
            all += static_cast<double>(s.total());
            if (trace.kernels[s.step] == "blend") blend += static_cast<double>(s.total());
        }
        double const least = static_cast<double>(r.pairs) * 4 / 64 / grid_.size(); // cycles, if all tiles had the same number of pairs
        p.blend_share = blend / all;
        p.bound = all / (all - blend);
        p.bound_of_colours = all / (all - blend + std::min(least, blend));
        p.colours_db = psnr(rounded(false), exact_);
        auto const both = rounded(true);
        p.both_db = psnr(both, exact_);
        p.both_rmse = tilemesh::report::compare(both, exact_).rmse;
        products_.push_back(p);
    }

    bench::Scene const& scene_;
    Options const& options_;
    tilemesh::Grid grid_;
    std::vector<Row>& rows_;
    std::vector<Products>& products_;
    std::vector<std::string>& broken_;
    std::string view_;
    std::vector<splat::Camera> cameras_;
    Image exact_{1, 1};
};

} // namespace

void measure(bench::Scene const& s, Options const& options, std::vector<Row>& rows, std::vector<Products>& products,
             std::vector<std::string>& broken)
{
    Measurement(s, options, rows, products, broken).all();
}

} // namespace policies
