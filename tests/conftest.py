"""For every test: Ctrl-C can be pressed in what a test starts."""

import signal

# A shell's background jobs ignore SIGINT, and what they start inherits that.
signal.signal(signal.SIGINT, signal.default_int_handler)
