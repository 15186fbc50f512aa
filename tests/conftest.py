"""What holds for every room's tests."""

import signal

# A shell's background job starts with Ctrl-C ignored, and every process inherits that: the tests that press it need it.
signal.signal(signal.SIGINT, signal.default_int_handler)
