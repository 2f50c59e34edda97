#include "packed.hpp"
#include <common/machine_over.hpp>
#include <common/packed_record.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/renderer.hpp>
#include <utility>

namespace policies {

namespace {

namespace splat = tilemesh::splat;
namespace render = tilemesh::render;

struct Largest : splat::Lossless {
    using Saturation = splat::LargestFirst<splat::Hold>;
};

template <class S>
using RendererOf = render::FrameRenderer<splat::PoliciesOf<S>, tilemesh::Mesh, tilemesh::Traced<tilemesh::AnyMachine>>;

template <class S>
class Packed final : public bench::MachineOver<PackedMachine, RendererOf<S>> {
    using Base = bench::MachineOver<PackedMachine, RendererOf<S>>;

public:
    Packed(tilemesh::scene::Map const& map, typename S::Parameters const& parameters, tilemesh::RendererOptions const& options)
        : Base(map, render::setup_for<S>(options), options)
    {
        this->renderer_.begin_with(parameters);
    }
    render::Setup const& setup() const override { return this->renderer_.setup(); }
    tilemesh::Trace const& trace() const override { return this->renderer_.trace(); }
};

template <class Base>
std::unique_ptr<PackedMachine> make(tilemesh::scene::Map const& map, std::uint32_t bytes, splat::CompactBox const& box,
                                    tilemesh::RendererOptions const& options)
{
    if (bytes == 32)
        return std::make_unique<Packed<splat::WithRecord<Base, splat::Compact32>>>(map, splat::PackedParameters<splat::Compact32>{},
                                                                                   options);
    splat::PackedParameters<splat::Compact16> parameters{};
    parameters.box = box;
    return std::make_unique<Packed<splat::WithRecord<Base, splat::Compact16>>>(map, parameters, options);
}

/// Flops, divisions and roots, and other instructions of `unpacked`.
struct Unpacking {
    std::uint64_t flops, roots, others;
};
constexpr Unpacking unpacking_32{18, 8, 284}, unpacking_16{30, 8, 222};

} // namespace

std::unique_ptr<PackedMachine> make_packed_machine(tilemesh::scene::Map const& map, std::uint32_t bytes, bool ranks,
                                                   splat::CompactBox const& box, tilemesh::RendererOptions options)
{
    options.arithmetic = splat::Arithmetic::precise;
    return ranks ? make<Largest>(map, bytes, box, options) : make<splat::Lossless>(map, bytes, box, options);
}

tilemesh::CostModel model_with_unpacking(std::uint32_t bytes)
{
    namespace d = tilemesh::model_detail;
    auto const& u = bytes == 32 ? unpacking_32 : unpacking_16;
    auto model = tilemesh::mk2();
    auto const slots = d::projection_slots() + d::slots_of(u.flops, u.roots, u.others);
    set_price(model, "projection", slots * d::one_worker, "arithmetic: a projection of mk2(), and the instructions that unpack its record");
    return model;
}

} // namespace policies
