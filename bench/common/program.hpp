#pragma once
#include "../../examples/shared/text.hpp"
#include <common/options.hpp>
#include <iostream>
#include <new>
#include <tilemesh/error.hpp>

namespace bench {

/// Calls `run`, which returns the exit status; an Error is one line and status 2. `too_large`: the line if it is out of memory.
template <class Run>
int guarded(Run const& run, char const* too_large)
try {
    return run();
} catch (tilemesh::Error const& error) {
    std::cerr << shared::one_line(error.what()) << '\n'; // a name may hold any bytes
    return 2;
} catch (std::bad_alloc const&) {
    std::cerr << too_large << '\n';
    return 2;
}

/// The main function of a bench with the options `Own`, which `table(Own&)` names and `Own::finish` completes. `run` gets them.
template <class Own, class Run>
int program(int argc, char** argv, shared::OptionTable (*table)(Own&), Run const& run, char const* too_large)
{
    return guarded(
        [&] {
            Own options;
            auto words = table(options);
            if (!words.read({argv + 1, argv + argc})) {
                std::cout << words.help();
                return 0;
            }
            options.finish(words);
            return run(options);
        },
        too_large);
}

} // namespace bench
