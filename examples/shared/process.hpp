#pragma once
#include <functional>
#include <optional>
#include <string>
#include <unistd.h>

namespace shared {

/// Makes every failure of an output an error that can be reported. A closed pipe, or a file at its size limit, makes the write fail instead
/// of ending the process. A standard stream that the parent left closed is opened so that writing to it fails; otherwise a picture could
/// get its number.
void make_outputs_fail_softly();

/// After this call, if the C++ runtime has no memory even for an exception, the process does not abort: it ends with the line and the
/// status of `refuse_for_memory`.
void end_softly_without_memory();

/// Writes one line to standard error: out of memory. It allocates nothing. Returns the exit status, 2.
[[nodiscard]] int refuse_for_memory() noexcept;

/// Writes an error as one line to standard error (`one_line`), for any names in it. Returns the exit status, 2.
[[nodiscard]] int refuse(std::string const& text);

/// The body of a program: calls the functions above that make failures soft, then `work`. Returns the exit status of `work`. If `work`
/// throws, returns 2, and standard error has one line: the text of a `tilemesh::Error`, or what the system refused. `program` names the
/// program in that line.
[[nodiscard]] int run_softly(std::string const& program, std::function<int()> const& work) noexcept;

/// From here on the first SIGINT or SIGTERM is only noted, and the current frame is finished. The next signal ends the process at once.
/// `announce`: report this on standard error. A signal that the parent has switched off stays off.
void note_interrupts(bool announce);

/// The signal that was noted; 0: none.
int interrupt() noexcept;

/// "SIGINT" or "SIGTERM".
char const* signal_name(int signal) noexcept;

/// The main function of a program that finishes its current frame at a signal: reads the options (empty: there is nothing to run), notes
/// interrupts, and runs. `Options` has `quiet`.
template <class Options>
[[nodiscard]] int run_program(std::string const& program, std::optional<Options> (*options_of)(int, char**), int (*run)(Options const&),
                              int argc, char** argv) noexcept
{
    auto const work = [&] {
        auto const options = options_of(argc, argv);
        if (!options) return 0;
        note_interrupts(!options->quiet && isatty(STDERR_FILENO) == 1);
        return run(*options);
    };
    return run_softly(program, std::cref(work)); // a copy of `work` would allocate, where nothing catches yet
}

} // namespace shared
