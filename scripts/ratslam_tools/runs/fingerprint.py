"""What identifies the inputs of a run: it is repeated if one of them has changed.

Names, sizes and contents count, times of change do not: machines that share the runs of a sweep may have copies of a recording.
"""

import functools
import hashlib
import os
import subprocess
from typing import Dict, Iterator, Optional, Sequence, Tuple

OUTPUTS = ("--out", "--save-map", "--video")  # options of ratslam_run that name what it writes
TEXTS = (".txt", ".csv", ".yaml", ".yml")
FLEETING_BYTES = 1 << 16  # a file up to this size is read each time
WHOLE_BYTES = 1 << 26  # of larger files, such as bags, samples stand for the content
SAMPLES, SAMPLE_BYTES = 256, 1 << 16


def of_command(words: Sequence[str], known: Optional[Dict[str, str]] = None) -> Dict[str, str]:
    """Fingerprints of what `ratslam_run INPUT OPTION ...` reads, by name: the program with its own libraries, the recording
    (file or folder), and the files that options name, as `--option FILE` or `--option=FILE`.

    A file is identified by its content (above 64 MiB: by its size and 16 MiB in samples from begin to end), a folder by the
    names and sizes of its files and by the contents of its texts, such as times.txt and calib.txt.
    @param known fingerprints found a moment ago, which are taken instead of new ones; completed.
    """
    found = {} if known is None else known
    names = [words[0], *_libraries(words[0]), *_inputs(words)]
    for name in names:
        path = os.path.expanduser(name)
        if name in found:
            continue
        if os.path.isfile(path):
            found[name] = _content_of(path)
        elif os.path.isdir(path) and name == words[1]:
            found[name] = _folder(path, _option(words, "--out"))
    return {name: found[name] for name in names if name in found}


def _inputs(words: Sequence[str]) -> Iterator[str]:
    """The words, and parts of words, that may name a file to read."""
    before = ""
    for word in words[1:]:
        name, equals, value = word.partition("=")
        if not word.startswith("--"):
            if not _writes(before):
                yield word
        elif equals and not _writes(name):
            yield value
        before = word


def _writes(option: str) -> bool:
    """Whether it is an option for a file to write, or the beginning of one, which ratslam_run takes for it."""
    return len(option) > len("--") and any(output.startswith(option) for output in OUTPUTS)


def _option(words: Sequence[str], name: str) -> Optional[str]:
    return next((following for word, following in zip(words, words[1:]) if word == name), None)


def _libraries(program: str) -> Sequence[str]:
    """Paths of the libraries of this package that a program loads: most of it is in them."""
    if not os.path.isfile(program):
        return ()
    state = os.stat(program)
    return _libraries_of(program, state.st_size, state.st_mtime_ns)


@functools.lru_cache(maxsize=None)
def _libraries_of(program: str, _size: int, _time: int) -> Tuple[str, ...]:
    try:
        listed = subprocess.run(["ldd", program], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False).stdout
    except OSError:
        return ()
    pairs = [line.split() for line in listed.decode("utf-8", "surrogateescape").splitlines()]
    return tuple(pair[2] for pair in pairs if len(pair) > 2 and pair[0].startswith("libratslam") and pair[1] == "=>")


def _content_of(path: str) -> str:
    state = os.stat(path)
    if state.st_size <= FLEETING_BYTES:
        return _digest(path, state.st_size)
    return _digest_once(path, state.st_size, state.st_mtime_ns, state.st_ino)


@functools.lru_cache(maxsize=None)
def _digest_once(path: str, size: int, _time: int, _inode: int) -> str:
    """For all runs of a sweep, as long as the file is not touched."""
    return _digest(path, size)


def _digest(path: str, size: int) -> str:
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        if size <= WHOLE_BYTES:
            for piece in iter(lambda: file.read(1 << 20), b""):
                digest.update(piece)
            return digest.hexdigest()
        for index in range(SAMPLES):
            file.seek(index * (size - SAMPLE_BYTES) // (SAMPLES - 1))
            digest.update(file.read(SAMPLE_BYTES))
    return f"{digest.hexdigest()} of {size} bytes"


def _folder(folder: str, out: Optional[str]) -> str:
    digest, count, total = hashlib.sha256(), 0, 0
    for path in _files(folder, out):
        name = os.path.relpath(path, folder)
        try:
            size = os.path.getsize(path)
            text = _content_of(path) if name.lower().endswith(TEXTS) and os.path.isfile(path) else ""
        except OSError:  # a link to nothing, or a file that may not be read
            size, text = 0, "unreadable"
        digest.update(f"{name}\0{size}\0{text}\0".encode("utf-8", "surrogateescape"))
        count, total = count + 1, total + size
    return f"{count} files of {total} bytes: {digest.hexdigest()}"


def _files(folder: str, out: Optional[str]) -> Iterator[str]:
    """Paths of a folder's files, also of folders within, in order; without hidden ones, and without the folder in which the
    results go."""
    results = os.path.realpath(out) + os.sep if out else ""
    seen = set()
    for place, folders, names in os.walk(folder, followlinks=True):
        state = os.stat(place)
        if (state.st_dev, state.st_ino) in seen:  # a link leads back
            folders.clear()
            continue
        seen.add((state.st_dev, state.st_ino))
        folders[:] = sorted(
            name for name in folders
            if not name.startswith(".") and not results.startswith(os.path.realpath(os.path.join(place, name)) + os.sep)
        )
        yield from (os.path.join(place, name) for name in sorted(names) if not name.startswith("."))
