#include "lending.hpp"
#include <algorithm>
#include <common/statistics.hpp>
#include <cstdint>
#include <numeric>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/render/frame_renderer.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/splat/lending.hpp>

namespace policies {

namespace {

namespace splat = tilemesh::splat;
using Setup = splat::LosslessLending;
using Renderer =
    tilemesh::render::FrameRenderer<splat::PoliciesOf<splat::Referenced<Setup>>, tilemesh::Mesh, tilemesh::Traced<tilemesh::AnyMachine>>;

class Machine final : public LendingMachine {
public:
    Machine(tilemesh::scene::Map const& map, tilemesh::RendererOptions const& options)
        : renderer_(map, tilemesh::render::setup_for<Setup>(options), options, {})
    {
        renderer_.rules().arithmetic = splat::Arithmetic::precise;
    }
    void render(splat::Camera const& camera) override { renderer_.render_into(camera, frame_); }
    tilemesh::report::Image const& image() const override { return frame_.image; }
    tilemesh::report::FrameReport const& report() const override { return frame_.report; }
    tilemesh::Trace const& trace() const override { return renderer_.trace(); }
    std::uint64_t sram_bytes() const override { return tilemesh::render::sram_bytes_of(renderer_.setup()); }
    std::uint32_t storage() const override { return renderer_.setup().sizes.storage; }

private:
    Renderer renderer_;
    tilemesh::RenderedFrame frame_;
};

} // namespace

std::unique_ptr<LendingMachine> make_lending_machine(tilemesh::scene::Map const& map, tilemesh::RendererOptions const& options)
{
    return std::make_unique<Machine>(map, options);
}

void set_parts(Row& row, tilemesh::Trace const& trace, tilemesh::RunCost const& cost, tilemesh::CostModel const& model)
{
    std::uint64_t blend = 0, lend = 0;
    bool after = false;
    for (auto const& s : cost.supersteps) {
        auto const& kernel = trace.kernels[s.step];
        bool const blends = kernel == "composite" || kernel == "composite and lend";
        if (blends) blend += s.total();
        else if (after) lend += s.total();
        after = after || kernel == "depth sort";
        if (!blends) continue;
        auto const& busy = cost.busy[s.step];
        auto const sum = std::accumulate(busy.begin(), busy.end(), std::uint64_t{0});
        row.blend_slowest_over_mean = static_cast<double>(*std::max_element(busy.begin(), busy.end())) * static_cast<double>(busy.size()) /
                                      static_cast<double>(sum);
    }
    row.blend_ms = tilemesh::milliseconds(model, blend);
    row.lend_ms = tilemesh::milliseconds(model, lend);
}

std::string table_of_lending(std::vector<Row> const& rows)
{
    using bench::fixed;
    std::string text = "| map | view | blend, ms | with lending | to lend and return, ms | blend, slowest / mean | with lending |\n"
                       "|---|---|--:|--:|--:|--:|--:|\n";
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
        auto const& o = rows[i];
        auto const& r = rows[i + 1];
        if (o.policy != without_lending || r.policy != with_lending) continue;
        text += "| " + r.map + " | " + r.view + " | " + fixed(o.blend_ms, 2) + " | " + fixed(r.blend_ms, 2) + " | " + fixed(r.lend_ms, 2) +
                " | " + fixed(o.blend_slowest_over_mean, 2) + " | " + fixed(r.blend_slowest_over_mean, 2) + " |\n";
    }
    return text;
}

std::string cost_of_lending(std::vector<Row> const& rows)
{
    using tilemesh::report::thousands;
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
        if (rows[i].policy != without_lending || rows[i + 1].policy != with_lending) continue;
        auto const whole = splat::Lossless::sizes.storage;
        return "Channels and buffers take " + thousands(rows[i + 1].sram_bytes - rows[i].sram_bytes) + " bytes of a tile's SRAM: " +
               thousands(whole - rows[i].storage) + " of its " + thousands(whole) +
               " slots of storage. A map that\nfills its tiles lacks more records.\n";
    }
    return "";
}

std::string findings_of_lending(std::vector<Row> const& rows)
{
    using bench::fixed;
    std::string text;
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
        auto const& o = rows[i];
        auto const& r = rows[i + 1];
        if (o.policy != without_lending || r.policy != with_lending) continue;
        double const time = r.modelled_ms / o.modelled_ms;
        text += "- " + r.map + ", " + r.view + ": **" + with_lending + "**, slowest / mean " + fixed(r.slowest_over_mean, 2) + " for " +
                fixed(o.slowest_over_mean, 2) + " (" + without_lending + "),\n  the same picture in " + fixed(time, 3) +
                " times the modelled time, with " + tilemesh::report::thousands(r.exchanges - o.exchanges) + " exchanges more." +
                (time < 1 ? "\n" : " It does not pay here.\n");
    }
    return text;
}

} // namespace policies
