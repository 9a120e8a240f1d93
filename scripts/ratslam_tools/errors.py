"""The one exception that every command line turns into one line on stderr and exit status 1."""

import sys


class InputError(Exception):
    """Bad input: the message names the file or option, what is wrong with it and what is expected."""


def run_main(main_function, argv=None) -> int:
    """Calls `main_function(argv)` and returns the process's exit status (0, or 1 after one clear line)."""
    try:
        main_function(argv)
        sys.stdout.flush()
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of a pipe (head, less) has gone: not an error of ours, and nothing more can be printed.
        sys.stderr.close()
        return 0
    return 0
