#pragma once
#include "compact.hpp"
#include <tilemesh/splat/access.hpp>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/projection.hpp>
#include <tilemesh/splat/setup_types.hpp>

/// Setups whose tiles store and send records of 32 and of 16 bytes. A tile unpacks a record to floats each time that it projects it. It
/// never packs one: what it sends is what it stores. The host packs, when it loads a record.
TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The frame's parameters of such a setup. The box of all records of 16 bytes is a part of them: 24 bytes a tile.
template <class Packed>
struct PackedParameters;
template <>
struct PackedParameters<Compact32> : FrameParameters {
    Gaussian unpack(Compact32 const& record) const noexcept { return unpacked(record); }
    bool try_pack(Gaussian const& g, Compact32& to) const noexcept { return try_pack_again(g, to); }
};
template <>
struct PackedParameters<Compact16> : FrameParameters {
    CompactBox box;
    Gaussian unpack(Compact16 const& record) const noexcept { return unpacked(record, box); }
    bool try_pack(Gaussian const& g, Compact16& to) const noexcept { return try_pack_again(g, box, to); }
};

template <class Packed>
struct Access<PackedParameters<Packed>> : Access<FrameParameters> {
    using Parameters = PackedParameters<Packed>;
    TILEMESH_KERNEL static Parameters const& hold(Parameters const& frame) noexcept { return frame; }
    static Splat project(Packed const& record, Parameters const& frame) noexcept
    {
        return splat::project(frame.unpack(record), frame.view, frame.tiling);
    }
    /// The record of a map whose records were all unpacked. A record without an id for one that was not.
    template <class Record>
    static Record stored(Gaussian const& g, Parameters const& parameters) noexcept
    {
        Record record;
        if (!parameters.try_pack(g, record)) record = {};
        return record;
    }
};

/// `Base` with packed records, and with more slots in the same bytes of SRAM.
template <class Base, class Packed>
struct WithRecord : Base {
    using Record = Packed;
    using Parameters = PackedParameters<Packed>;
    static constexpr Sizes sizes = [] {
        auto now = setup_of<Base>();
        now.own_record_bytes = sizeof(Packed);
        return refitted(now, setup_of<Base>()).sizes;
    }();
};

}}} // namespace tilemesh::splat
TILEMESH_EXACT_END
