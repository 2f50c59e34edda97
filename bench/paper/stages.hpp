#pragma once
#include "rows.hpp"

namespace paper {

/// Milliseconds of each stage over the tiles: the authors' prototype, run as it is known, under prices fitted on Salad alone.
void stages(Context const&, Rows&);

} // namespace paper
