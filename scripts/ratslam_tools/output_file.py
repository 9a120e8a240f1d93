"""Files that commands write: each gets its name only when it is complete; pipes and devices are written as they are."""

import itertools
import os
import stat
import sys
from contextlib import contextmanager, suppress

from ratslam_tools.errors import InputError, one_line


def _new_beside(path: str) -> str:
    """Creates an empty file beside `path`, with the permissions of any new file. No file has its name before: neither one of
    the user nor that of another command that writes the same output."""
    for number in itertools.count(1):
        part = path + (".part" if number == 1 else f".part{number}")
        with suppress(FileExistsError):
            os.close(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666))
            return part


@contextmanager
def replacing(path: str, what: str = ""):
    """The name of a new empty file that takes the place of `path` once the block has filled it; else it is removed.

    @param what is written, for the message. @throws InputError if it cannot be written.
    """
    whole, part = os.path.realpath(path), None
    try:
        part = _new_beside(whole)
        yield part
        os.replace(part, whole)
    except BaseException as error:
        if part is not None:
            with suppress(OSError):
                os.unlink(part)
        if isinstance(error, OSError) and (part is None or error.filename in (part, None)):
            raise _refused(path, what, error) from None
        raise


@contextmanager
def writing(path: str, mode: str, what: str = "", **form):
    """A file for writing, open as by open(mode, **form). What is no regular file is written in place, and what leads to stdout
    follows what was printed. @throws InputError as replacing.
    """
    stream = _stream_to(path)
    if stream is None and not _is_special(path):
        with replacing(path, what) as part, open(part, mode, **form) as file:
            yield file
        return
    try:
        with open(path if stream is None else os.dup(stream.fileno()), mode, **form) as file:
            yield file
    except BrokenPipeError:  # the reader has had enough, which is no error
        raise
    except OSError as error:
        if error.filename not in (path, None):
            raise
        raise _refused(path, what, error) from None


def _refused(path: str, what: str, error: OSError) -> InputError:
    return InputError(f"{path}: {what}cannot be written: {error.strerror or one_line(error)}")


def _is_special(path: str) -> bool:
    """Whether there is something that is no regular file, such as a pipe, a device or a folder."""
    try:
        return not stat.S_ISREG(os.stat(path).st_mode)
    except OSError:
        return False


def _stream_to(path: str):
    """stdout or stderr, without text that waits in it, if that is what `path` leads to (/dev/stdout); else None. Opened by its
    name, a file to which the stream is redirected would be written from its beginning.
    """
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # no such file; a stream that is closed, or only in memory
            if os.path.samestat(os.stat(path), os.fstat(stream.fileno())):
                stream.flush()
                return stream
    return None
