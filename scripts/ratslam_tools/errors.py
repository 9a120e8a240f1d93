"""The one exception that every command line turns into one line on stderr and exit status 1."""

import argparse
import math
import os
import signal
import sys
import threading


class InputError(Exception):
    """Bad input: the message names the file or option, what is wrong with it and what is expected."""


def require_folder(path: str, hint: str = "") -> None:
    """@throws InputError if there is no such folder. @param hint is added to the message about a missing folder."""
    if os.path.exists(path) and not os.path.isdir(path):
        raise InputError(f"{path}: it is a file, and a folder is needed")
    if not os.path.isdir(path):
        raise InputError(f"{path}: no such folder{hint}")


def require_effect(holds: bool, why: str, **options) -> None:
    """@throws InputError naming the first of the options (None or False: not given) unless they have an effect here."""
    for name, value in () if holds else options.items():
        if value is not None and value is not False:
            shown = f"{value:g}" if isinstance(value, float) else str(value)
            given = f"--{name}" if value is True else f"--{name}: {shown}"
            raise InputError(f"{given} has no effect: {why}")


def run_main(main_function, argv=None) -> int:
    """Calls `main_function(argv)` and returns the process's exit status (0, 1 after one clear line, or 128 and the number of the
    signal that ended it)."""
    _hear_requests_to_end()
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")  # a file's name need not be text of the terminal's encoding
    try:
        _require_words(sys.argv[1:] if argv is None else argv)
        main_function(argv)
        if sys.stdout is not None:  # it may have been closed
            sys.stdout.flush()
    except InputError as error:
        print(f"error: {one_line(error)}", file=sys.stderr)
        return 1
    except KeyboardInterrupt as request:
        print("interrupted", file=sys.stderr)
        return 128 + (request.args[0] if request.args else signal.SIGINT)
    except BrokenPipeError:
        # The reader of a pipe (head, less) has ended. That is no error, and nothing more can be printed.
        sys.stderr.close()
        return 0
    except OSError as error:  # a full disk, or a folder without permission
        where = f"{error.filename}: " if error.filename else ""
        print(f"error: {where}{one_line(error.strerror or error)}", file=sys.stderr)
        return 1
    except MemoryError:
        print("error: the memory of this machine does not suffice", file=sys.stderr)
        return 1
    return 0


def _hear_requests_to_end() -> None:
    """Makes SIGTERM and SIGHUP end a command as Ctrl-C does: the programs that it has started are stopped, and files that are
    not complete are removed. A signal that is ignored, as nohup leaves it, remains so."""

    def interrupt(number, _):
        raise KeyboardInterrupt(number)

    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) == signal.SIG_DFL:
                signal.signal(number, interrupt)


MAY_BE_EMPTY = ("--root", "--topic-root")  # names of topics may begin with nothing


def _require_words(words) -> None:
    """@throws InputError for an empty argument, which mostly is a variable of the shell that is not set. The options of
    MAY_BE_EMPTY are exempt, and what follows `--` is for another program to judge.
    """
    own = list(words[: words.index("--")] if "--" in words else words)
    for before, word in zip(["", *own], own):
        if word == "" and before not in MAY_BE_EMPTY:
            raise InputError(f"{before}: the word behind it is empty" if before else "the first argument is empty")
        if word.startswith("--") and word.endswith("=") and word[:-1] not in MAY_BE_EMPTY:
            raise InputError(f"{word[:-1]}: its value is empty")


def one_line(error) -> str:
    """A message in one line of printable text."""
    return "".join(letter if letter.isprintable() else " " for letter in " ".join(str(error).split()))


def finite(text: str) -> float:
    """The number in an option's text, as a type for argparse. @throws argparse.ArgumentTypeError unless it is finite."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"'{text}' is not a finite number")
    return number
