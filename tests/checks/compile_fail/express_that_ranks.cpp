// EXPECT: a torus or express links with a saturation policy that drops or ranks records
#include <tilemesh/render/setup.hpp>
#include <tilemesh/splat/contribution.hpp>
#include <tilemesh/splat/topologies.hpp>

struct Ranks : tilemesh::splat::Lossless {
    using Saturation = tilemesh::splat::LargestFirst<tilemesh::splat::Hold>;
};
using Setup = tilemesh::splat::WithLinks<Ranks, tilemesh::splat::ExpressLinks<4>>;

tilemesh::render::Setup facts()
{
    return tilemesh::render::setup_for<Setup>();
}
