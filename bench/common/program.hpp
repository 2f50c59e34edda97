#pragma once
#include "../../examples/shared/text.hpp"
#include <common/options.hpp>
#include <iostream>
#include <new>
#include <tilemesh/error.hpp>

namespace bench {

/// The main function of a bench. `parse` makes its options from the words, `help` returns the text of `--help`, `run` returns the exit
/// status. `too_large`: the error text if it is out of memory.
template <class Parse, class Help, class Run>
int program(int argc, char** argv, Parse const& parse, Help const& help, Run const& run, char const* too_large)
try {
    auto const options = parse({argv + 1, argv + argc});
    if (options.help) {
        std::cout << help();
        return 0;
    }
    return run(options);
} catch (tilemesh::Error const& error) {
    std::cerr << shared::one_line(error.what()) << '\n'; // a name may hold any bytes
    return 2;
} catch (std::bad_alloc const&) {
    std::cerr << too_large << '\n';
    return 2;
}

} // namespace bench
