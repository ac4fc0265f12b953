"""The command `ipmlang`: hands the arguments to `cli` and leaves with its exit code."""

from __future__ import annotations

import signal
import sys


def main() -> None:
    """Run the command line and exit: 0 fine, 1 the user's file is wrong, 2 the command is wrong."""
    from ipmlang.cli import run_command_line

    signal.signal(signal.SIGTERM, signal.default_int_handler)  # temporary files are cleared away
    sys.exit(run_command_line(sys.argv[1:]))


if __name__ == "__main__":
    main()
