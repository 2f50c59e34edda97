#pragma once
#include <common/machine.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

/// Other links for routing: a torus, and express links that skip tiles (splat/topologies.hpp).
namespace policies {

enum class Links { mesh, torus, express4, express8 };
inline constexpr Links other_links[] = {Links::torus, Links::express4, Links::express8};
char const* name_of(Links links) noexcept;

/// `lossless` with these links for routing, in the same SRAM, in `precise` arithmetic; not for `mesh`.
class LinkMachine {
public:
    virtual ~LinkMachine() = default;
    virtual void render(tilemesh::splat::Camera const&) = 0;
    virtual tilemesh::report::Image const& image() const = 0;
    virtual tilemesh::report::FrameReport const& report() const = 0;
    virtual tilemesh::Trace const& trace() const = 0;
    virtual std::uint64_t sram_bytes() const = 0;
};
std::unique_ptr<LinkMachine> make_link_machine(Links, tilemesh::scene::Map const&, std::uint32_t threads, tilemesh::Grid);

/// Routing of one frame.
struct LinkRow {
    std::string map, view;
    Links links = Links::mesh;
    bool lossy = false;            ///< records are missing from the picture
    std::uint64_t exchanges = 0, hops = 0;
    double milliseconds = 0;       ///< modelled, of the step
    double frame_milliseconds = 0; ///< of the whole frame
    double bound = 0;              ///< of the step's exchanges, if every record went straight to its anchor tile (any_to_any)
    double moving = 0;             ///< exchange, sync and vote of the step
};
LinkRow link_row(std::string map, std::string view, Links, tilemesh::report::FrameReport const&, tilemesh::Trace const&, tilemesh::Grid);

/// Routing alone, of as many records as the gather of the authors' code moves: every tile has `a_tile` records, whose anchor tiles are a
/// random permutation, so every tile also gets `a_tile`.
struct GatherRow {
    Links links = Links::mesh;
    std::uint32_t slots = 0; ///< of each channel end; of a FIFO as many
    std::uint64_t exchanges = 0, hops = 0, bytes = 0;
    double compiled_ms = 0, live_ms = 0; ///< exchange, sync and vote, if exchanges move whole channels, and if they move messages
    double compute_ms = 0;
    double bound_ms = 0;     ///< any_to_any
    bool all_there = false;  ///< every record is on its anchor tile, once
};
std::vector<GatherRow> gather(tilemesh::Grid, std::uint32_t a_tile, std::uint32_t threads);

std::string table(std::vector<LinkRow> const&);
std::string table(std::vector<GatherRow> const&);
/// The wires and the SRAM that each kind of links adds to a mesh.
std::string table_of_wires(tilemesh::Grid);
/// The section of README.md.
std::string section_of_links(std::vector<LinkRow> const&, std::vector<GatherRow> const&, tilemesh::Grid);

} // namespace policies
