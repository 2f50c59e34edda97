#include "rank_renderer.hpp"

render_map::MakeRankHomes& render_map::homes_on_ranks_plain = render_map::make_homes_on_ranks<0, tilemesh::splat::FloatPixel>;
render_map::MakeRankHomes& render_map::homes_on_ranks_any = render_map::make_homes_on_ranks<3, tilemesh::render::HomesPlanes>;
