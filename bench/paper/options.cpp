#include "options.hpp"

namespace paper {

shared::OptionTable table_of(Options& own, std::span<shared::Word const> words)
{
    using shared::option;
    shared::Option<Options> const rows[] = {
        shared::words<&Options::tables>("table", "NAME", "{}; may be repeated [all]", words),
        option<&Options::out>("out", "DIR", "SVG plots and PNG pictures"),
        option<&Options::threads>("threads", "N", "host threads; results do not depend on them [all of this machine's]", {1, 1024})};
    return bench::table_of({"paper",
                            "Prints the tables and figures of the paper's results beside ours: table | row | quantity | paper | ours |\n"
                            "ratio | kind. If the paper's text gives no number, `paper` is \"no figure in the source\". If a map is\n"
                            "missing, `ours` is \"skipped\". `kind` says how ours was found: counted on a machine or by projection,\n"
                            "modelled in cycles, predicted from a placement, fitted, or by arithmetic.\n",
                            "fewer frames and maps, smaller saturated pictures", "the rows, with a note on each", false},
                           own, rows);
}

} // namespace paper
