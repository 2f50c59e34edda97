// The projection of a record of one colour; with -DSHADED in a unit that has harmonics too.
#ifdef SHADED
#    include <tilemesh/splat/harmonics.hpp>
template tilemesh::splat::Splat tilemesh::splat::project(tilemesh::splat::ShadedGaussian<3> const&, tilemesh::splat::View const&,
                                                         tilemesh::splat::TileSize const&) noexcept;
#else
#    include <tilemesh/splat/projection.hpp>
#endif

namespace leave_out {
using namespace tilemesh::splat;
using Projection = Splat (*)(Gaussian const&, View const&, TileSize const&) noexcept;
extern Projection const projection;
Projection const projection = project;
} // namespace leave_out
