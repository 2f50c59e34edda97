#include "rank_renderer.hpp"

render_map::MakeRankRenderer& render_map::on_ranks_shaded = render_map::make_on_ranks<false, 3>;
render_map::MakeRankRenderer& render_map::on_ranks_shaded_planes = render_map::make_on_ranks<true, 3>;
