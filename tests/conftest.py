"""Being here puts `tests/` on the path, so that test modules can share code (`recorded_runs`)."""

import signal

# Where the suite runs in the background, a shell may have had Ctrl-C ignored; the tests of Ctrl-C, and the processes
# that they start, need what everybody has in front of a terminal.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
