#include "rank_renderer.hpp"

render_map::MakeRankRenderer& render_map::on_ranks_placed = render_map::make_on_ranks<false, 0, false, true>;
render_map::MakeRankRenderer& render_map::on_ranks_placed_shaded = render_map::make_on_ranks<false, 3, false, true>;
render_map::MakeRankRenderer& render_map::on_ranks_placed_unspread = render_map::make_on_ranks<false, 0, false, false>;
