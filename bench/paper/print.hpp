#pragma once
#include "rows.hpp"
#include <ostream>
#include <string>

namespace paper {

/// Prints the rows as columns, then each violated condition on a line.
void print(std::ostream&, Rows const&);
/// The rows as CSV, with notes: `table,row,quantity,paper,ours,ratio,kind,how,note`. Rows and quantities are tokens (`route_mean_ms`).
/// `kind` is measured, modelled, fitted, null_model, or no_figure if the paper has none. `how` is the kind that `print` shows. Notes are
/// quoted if needed.
std::string csv(Rows const&);

} // namespace paper
