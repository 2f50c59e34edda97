#pragma once
#include <common/compact.hpp>
#include <common/machine.hpp>
#include <cstdint>
#include <memory>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/scene/map.hpp>

namespace policies {

/// A mesh whose tiles store and send packed records.
class PackedMachine : public bench::Machine {
public:
    virtual tilemesh::render::Setup const& setup() const = 0;
    /// The trace of the last frame.
    virtual tilemesh::Trace const& trace() const = 0;
};
/// `lossless` with records of `bytes` bytes, 32 or 16. `ranks`: what changes the picture most goes first. `map`: of records that were
/// packed and unpacked, in `box` if they have 16 bytes.
std::unique_ptr<PackedMachine> make_packed_machine(tilemesh::scene::Map const& map, std::uint32_t bytes, bool ranks,
                                                   tilemesh::splat::CompactBox const& box, tilemesh::RendererOptions options);

/// The model `mk2()` with the price of a projection that unpacks its record first. Instructions are counted by hand, to about 10 %, in the
/// code that Clang 16 generates with -O2 for RV32IMF, as those of KernelWork (model/cost_parameters.hpp).
tilemesh::CostModel model_with_unpacking(std::uint32_t bytes);

} // namespace policies
