"""Reading of text files from any system, and writing.

Accepted are a byte order mark, the line endings of any system, and single bytes of another encoding (a name in
Latin-1 among numbers). A file that is no text is refused.
"""

import math
import os
import stat
from contextlib import contextmanager
from typing import Iterable, Iterator, List, Optional, Tuple

from ratslam_tools import output_file
from ratslam_tools.errors import InputError

PIECE = 1 << 20  # bytes
LARGEST = 1 << 30  # bytes: a day of odometry at 200 Hz
UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")


def _pieces(path: str) -> Iterator[bytes]:
    """Content of a regular file, piece by piece. @throws InputError for a file that is not regular (a pipe would
    never end), unreadable, or too large to be read whole.
    """
    try:
        mode = os.stat(path).st_mode
        if not stat.S_ISREG(mode):
            what = "a folder" if stat.S_ISDIR(mode) else "no regular file (a pipe or a device)"
            raise InputError(f"{path}: cannot be read: it is {what}")
        with open(path, "rb") as file:
            for index, piece in enumerate(iter(lambda: file.read(PIECE), b"")):
                if index * PIECE >= LARGEST:
                    raise InputError(f"{path}: cannot be read: it has more than {LARGEST} bytes")
                yield piece
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except ValueError as error:  # a NUL in the name
        raise InputError(f"{path!r}: cannot be read: {error}") from None


def read_text(path: str) -> str:
    """The text of a file without its byte order mark, with `\\n` between lines. Bytes that are no UTF-8 become
    U+FFFD. @throws InputError for an unreadable or binary file.
    """
    pieces = []
    for piece in _pieces(path):  # each piece is checked, because a file that is no text may be endless
        pieces.append(piece)
        if pieces[0].startswith(UTF16_MARKS):
            raise InputError(f"{path}: cannot be read: it is UTF-16 text; save it as UTF-8")
        if b"\0" in piece:
            raise InputError(f"{path}: cannot be read: not a text file")
    text = b"".join(pieces).decode("utf-8-sig", "replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_lines(path: str) -> Iterator[Tuple[int, str]]:
    """(number from 1, line) of each line of a file that is not blank, without blanks at its ends."""
    for number, line in enumerate(read_text(path).split("\n"), 1):
        text = line.strip(" \t\v\f\ufeff\u00a0")
        if text:
            yield number, text


def number(text: str) -> float:
    """A number as programs write it, including NaN and infinity. @throws ValueError for anything else."""
    if "_" in text or not text.isascii():  # Python's own spelling of numbers
        raise ValueError(f"'{shown(text)}' is not a number")
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"'{shown(text)}' is not a number") from None


def finite_number(text: str) -> float:
    """A finite number. @throws ValueError for anything else."""
    value = number(text)
    if not math.isfinite(value):
        raise ValueError(f"'{shown(text)}' is not a finite number")
    return value


def shown(text: str) -> str:
    """Part of a file's text for a message: one line, not too long, printable characters only."""
    line = "".join(letter if letter.isprintable() else "?" for letter in text.strip())
    return line if len(line) <= 60 else line[:57] + "..."


def files_of(path: Optional[str]) -> List[str]:
    """A path, and if it is a folder the files in it."""
    if path is None or not os.path.isdir(path):
        return [path] if path else []
    return [path, *(os.path.join(path, name) for name in os.listdir(path))]


KEPT = ((b"#ROSBAG V", "a recording"), (b"\x89MCAP", "a recording"), (b"SQLite format 3", "a map or another database"))


def require_replaceable(path: str) -> None:
    """@throws InputError if there is a bag or a map where an output is to be written: its name was hardly meant."""
    if not os.path.isfile(path):  # opening a pipe would block
        return
    try:
        with open(path, "rb") as file:
            begin = file.read(16)
    except OSError:
        return
    for magic, what in KEPT:
        if begin.startswith(magic):
            raise InputError(f"{path}: cannot be written: it is {what} and is not overwritten")


def require_other(option: str, path: Optional[str], others: Iterable[Optional[str]], how: str = "read") -> None:
    """@throws InputError naming the option if the file to write is one of those that are read (or `how` written), or lies
    elsewhere under the same name (a link), or as require_replaceable."""
    for given in others:
        if path and given and os.path.realpath(path) == os.path.realpath(given):
            raise InputError(f"{option}: {path} is {how} as well and would be overwritten; give another name")
    if path:
        require_replaceable(path)


@contextmanager
def writing(path: str, newline=None):
    """A text file for writing. It gets its name only when it is complete.

    @throws InputError if it cannot be written, or as require_replaceable.
    """
    require_replaceable(path)
    with output_file.writing(path, "w", encoding="utf-8", errors="surrogateescape", newline=newline) as file:
        yield file
