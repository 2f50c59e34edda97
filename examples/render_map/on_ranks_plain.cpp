#include "rank_renderer.hpp"

render_map::MakeRankRenderer& render_map::on_ranks_plain = render_map::make_on_ranks<false, 0>;
render_map::MakeRankRenderer& render_map::on_ranks_planes = render_map::make_on_ranks<true, 0>;
