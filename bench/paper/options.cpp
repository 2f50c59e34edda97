#include "options.hpp"
#include <algorithm>
#include <thread>

namespace paper {

Options parse(std::vector<std::string> const& all, std::vector<std::string> const& names)
{
    Options options;
    options.threads = std::max(1u, std::thread::hardware_concurrency());
    for (bench::Words words(all); words.next();) {
        auto const& option = words.option();
        if (options.take(words)) continue;
        if (option == "--out") options.out = words.path();
        else if (option == "--table") options.tables.push_back(words.one_of(names));
        else if (option == "--threads") options.threads = words.number(1, 1024);
        else words.refuse();
    }
    options.finish();
    return options;
}

std::string help(std::vector<std::string> const& names)
{
    std::string list;
    for (auto const& name : names) list += (list.empty() ? "" : ", ") + name;
    return "Usage: paper [options]\n"
           "Prints the tables and figures of the paper's results beside ours: table | row | quantity | paper | ours | ratio | kind.\n"
           "If the paper's text gives no number, `paper` is \"no figure in the source\". If a map is missing, `ours` is\n"
           "\"skipped\". `kind` says how ours was found: counted on a machine or by projection, modelled in cycles, predicted\n"
           "from a placement, fitted, or by arithmetic.\n"
           "\n"
           "  --table NAME     " +
           list +
           ";\n"
           "                   may be repeated. Default: all\n"
           "  --csv FILE       the rows, with a note on each\n"
           "  --out DIR        SVG plots and PNG pictures\n" +
           bench::help_of_data +
           "  --threads N      host threads; default: all of this machine's. Results do not depend on it\n"
           "  --quick          fewer frames and maps, smaller saturated pictures\n"
           "  --help           this text\n"
           "\n" +
           bench::help_of_exit;
}

} // namespace paper
