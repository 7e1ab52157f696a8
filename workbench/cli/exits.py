"""Exit codes: what a calling script may rely on."""

SUCCESS = 0
FAILURE = 1
BAD_INPUT = 2
NO_PLAN = 3
NO_LINK = 4
INTERRUPTED = 130
OUTPUT_CLOSED = 141
