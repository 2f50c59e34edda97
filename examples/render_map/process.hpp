#pragma once

namespace render_map {

/// Makes every failure of an output an error that can be read: a closed pipe and a file at its size limit fail the write instead
/// of ending the process, and a standard stream that the parent left closed is opened so that writing to it fails, so that no
/// picture gets its number.
void make_outputs_fail_softly();

/// After this call, if the C++ runtime has no memory even for an exception, the process does not abort: it ends with the line and the
/// status of `refuse_for_memory`.
void end_softly_without_memory();

/// Writes one line to standard error: there is not enough memory. Allocates nothing. Returns the exit status, 2.
[[nodiscard]] int refuse_for_memory() noexcept;

/// From here on the first SIGINT or SIGTERM is only noted, and the frame in work is finished; the next one ends the process at
/// once. `announce`: says so on standard error. A signal that the parent has switched off stays off.
void note_interrupts(bool announce);

/// The signal that was noted; 0: none.
int interrupt() noexcept;

/// "SIGINT" or "SIGTERM".
char const* signal_name(int signal) noexcept;

} // namespace render_map
