#pragma once
#include "rows.hpp"

namespace paper {

/// Milliseconds of each stage over the tiles: the authors' prototype as a program, with prices that are fitted on Salad alone.
void stages(Context const&, Rows&);

} // namespace paper
