#pragma once
#include <cstdint>
#include <tilemesh/render/host_form.hpp>

/// The form of the frame program for several processes (mpi/mpi_mesh.hpp): tiles and channels hold records, and the rules of the setup are
/// words of the frame's parameters. So setups that differ in machine, sizes, saturation, addressing, copies or colour format share one set
/// of policies, as in the host's form (render/host_form.hpp), and no tile needs a table of the host.
///
/// Slots, bytes on the wire, counters and pictures are those of the setup, bit for bit. Digests are those of this form. A record with its
/// anchor takes 64 to 244 bytes in a message between processes, whatever it takes on the machine.
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The frame's parameters, and the rules of the setup.
struct PolicyParameters : LensParameters {
    static constexpr char const* name = "frame parameters and rules";
    PolicyWords policies;
};
/// A tile reads its records as on the machine; only the bytes of messages are words.
template <>
struct Access<PolicyParameters> : Access<LensParameters> {
    TILEMESH_KERNEL static PolicyParameters const& hold(PolicyParameters const& frame) noexcept { return frame; }
    template <class>
    static std::uint32_t road_bytes(PolicyParameters const& frame) noexcept
    {
        return frame.policies.road_bytes;
    }
    template <class>
    static std::uint32_t beam_bytes(PolicyParameters const& frame) noexcept
    {
        return frame.policies.beam_bytes;
    }
};
/// Bloom sends records. If the setup's copies last for one view only, the tiles forget them in a new view.
struct RunTimeWorldCopies : WorldCopies {
    static constexpr char const* name = "at run time";
    template <class Parameters>
    TILEMESH_KERNEL static bool reusable_in(Parameters const& frame) noexcept
    {
        return frame.policies.reusable != 0;
    }
};

/// The policies of setup S by value. Its renderer is `BasicRenderer<Valued<S>, MpiMesh>`; that of S itself has the same pictures and reports,
/// and shares its code with fewer setups. The ledger is that of S.
template <class S>
struct Valued : S {
    using Value = S;
    using Parameters = PolicyParameters;
    using Saturation = RunTimeSaturation;
    using Addressing = RunTimeAddressing;
    using Copies = RunTimeWorldCopies;
    using Pixel = HostPixel<typename S::Pixel>;
};

}}} // namespace tilemesh::splat
