#pragma once
#include "rows.hpp"
#include <ostream>
#include <string>

namespace paper {

/// The rows as columns, then what must hold and does not, a line each.
void print(std::ostream&, Rows const&);
/// The same with notes: `table,row,quantity,paper,ours,ratio,kind,how,note`. Rows and quantities are tokens (`route_mean_ms`); kind is
/// measured, modelled, fitted, null_model, or no_figure where the paper has none; `how` is the printed kind. Notes in quotes where they need them.
std::string csv(Rows const&);

} // namespace paper
