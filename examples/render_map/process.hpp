#pragma once

namespace render_map {

/// Makes every failure of an output an error that can be reported. A closed pipe, or a file at its size limit, makes the write fail instead
/// of ending the process. A standard stream that the parent left closed is opened so that writing to it fails; otherwise a picture could
/// get its number.
void make_outputs_fail_softly();

/// After this call, if the C++ runtime has no memory even for an exception, the process does not abort: it ends with the line and the
/// status of `refuse_for_memory`.
void end_softly_without_memory();

/// Writes one line to standard error: out of memory. It allocates nothing. Returns the exit status, 2.
[[nodiscard]] int refuse_for_memory() noexcept;

/// From here on the first SIGINT or SIGTERM is only noted, and the current frame is finished. The next signal ends the process at once.
/// `announce`: report this on standard error. A signal that the parent has switched off stays off.
void note_interrupts(bool announce);

/// The signal that was noted; 0: none.
int interrupt() noexcept;

/// "SIGINT" or "SIGTERM".
char const* signal_name(int signal) noexcept;

} // namespace render_map
