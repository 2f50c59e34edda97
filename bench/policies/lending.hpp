#pragma once
#include "measure.hpp"
#include <cstdint>
#include <memory>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace policies {

/// The anchored program with lent strips (splat/lending.hpp), with a trace.
class LendingMachine {
public:
    virtual ~LendingMachine() = default;
    virtual void render(tilemesh::splat::Camera const&) = 0;
    virtual tilemesh::report::Image const& image() const = 0;
    virtual tilemesh::report::FrameReport const& report() const = 0;
    virtual tilemesh::Trace const& trace() const = 0;
    virtual std::uint64_t sram_bytes() const = 0;
    virtual std::uint32_t storage() const = 0;
};
std::unique_ptr<LendingMachine> make_lending_machine(tilemesh::scene::Map const&, tilemesh::RendererOptions const&);

/// The names of the two rows: the same storage without and with lending.
inline constexpr char without_lending[] = "hold, room for lending", with_lending[] = "hold, lent strips";

/// Sets the members of a row that tell blending from lending.
void set_parts(Row& row, tilemesh::Trace const& trace, tilemesh::RunCost const& cost, tilemesh::CostModel const& model);

/// A table of those members, with a view in each row.
std::string table_of_lending(std::vector<Row> const& rows);

/// A sentence: the SRAM that lending takes, and the storage that makes room for it.
std::string cost_of_lending(std::vector<Row> const& rows);

/// A sentence for each view: what lending gives and what it costs.
std::string findings_of_lending(std::vector<Row> const& rows);

} // namespace policies
