#pragma once
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <string>
#include <tilemesh/model/assumed_parameters.hpp>
#include <tilemesh/model/bottleneck.hpp>
#include <tilemesh/model/confidence.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_table.hpp>
#include <tilemesh/model/trace_maps.hpp>
#include <tilemesh/model/trace_page.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <utility>

/// Prints the ledger of setup S, the assumptions about its machine, and the cost of three frames: a cold start, a step of 0.5 degrees, and
/// the same view again. If a folder `out` is given, it also writes a page about the cold start. Returns true if three conditions hold:
/// every picture equals in every bit that of a loop without tiles, the step costs less than the cold start, and the same view less than the
/// step.
template <class S>
bool report_on(tilemesh::scene::Map const& map, tilemesh::CostModel const& model, tilemesh::splat::Camera const& camera,
               tilemesh::RendererOptions options, std::filesystem::path const& out)
{
    namespace splat = tilemesh::splat;
    namespace report = tilemesh::report;
    using Shown = tilemesh::BasicRenderer<splat::Referenced<S>>;    // the machine of S; the host moves references
    std::string const machine = S::Machine::name;
    options.threads = 2;
    options.arithmetic = splat::Arithmetic::precise;      // the arithmetic of the naive loop
    Shown renderer{map, options};
    renderer.prepare(camera.width, camera.height);
    auto const grid = renderer.mesh().grid();
    std::cout << "== " << machine << ": " << grid.width << " x " << grid.height << " of " << report::thousands(S::Machine::tiles)
              << " tiles, " << camera.width << " x " << camera.height << " pixels\n"
              << tilemesh::ledger_table(Shown::Layout::ledger(), S::Machine::sram_bytes) << '\n' << tilemesh::assumed_text(model) << '\n';
    auto cameras = tilemesh::scene::orbit(camera, tilemesh::scene::robust_centre(map), 0.5, 2);
    cameras.push_back(cameras.back());
    bool ok = true;
    std::uint64_t before = 0;
    for (auto const& at : cameras) {
        auto const frame = renderer.render(at);
        auto const cost = tilemesh::model_cost(model, renderer.trace(), grid);
        auto const naive = report::render_naive(map.gaussians, at, renderer.rules()).rgb;
        bool const same = frame.image.rgb.size() == naive.size() &&
                          std::memcmp(frame.image.rgb.data(), naive.data(), naive.size() * sizeof(float)) == 0;
        std::cout << '\n' << tilemesh::cost_table(model, renderer.trace(), cost) << "frame: " << tilemesh::milliseconds_text(model, cost.cycles)
                  << " ms modelled, assumed\n" << tilemesh::confidence_text(model, renderer.trace(), cost) << '\n'
                  << frame.report << "\nThe picture " << (same ? "has" : "has NOT") << " the bits of the naive loop's.\n";
        ok = ok && same && frame.report.lost.empty() && (before == 0 || cost.cycles < before);
        if (before == 0 && !out.empty()) {
            auto const ledger = Shown::Layout::ledger();
            tilemesh::TileMap load{"load", "Load", "records that a tile stores, copies among them", true, {}, "records"};
            for (std::uint32_t t = 0; t < grid.size(); ++t)
                load.values.push_back(std::as_const(renderer.mesh()).template state<splat::Marks<typename Shown::Policies>>(grid.tile(t)).size());
            auto file = machine;
            std::replace(file.begin(), file.end(), ' ', '_');
            tilemesh::TracePage page;
            page.title = "A cold start on " + machine + ", by assumed numbers";
            page.facts = {{"numbers", tilemesh::assumed_text(model)}};
            page.ledger.assign(ledger.begin(), ledger.end());
            page.sram_bytes = S::Machine::sram_bytes;
            page.maps = {load};
            page.run = "frame";
            page.because = [&](tilemesh::Bottleneck const& b) { return "it stores " + report::short_number(load.values[b.tile]) + " records"; };
            page.picture = &frame.image;
            page.tile_px = {options.tile.width, options.tile.height};
            tilemesh::write_trace_page(out, file, renderer.trace(), model, grid, page);
        }
        before = cost.cycles;
    }
    std::cout << '\n';
    return ok;
}
