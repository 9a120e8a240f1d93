"""Names of files in the order in which people count: image9.png before image10.png."""

import os
import re
from typing import List

from ratslam_tools.errors import InputError

IMAGE_ENDINGS = (".png", ".jpg", ".jpeg")
_DIGITS = re.compile(r"([0-9]+)")


def natural_key(name: str) -> tuple:
    """Sort key in which runs of digits count as numbers; names that differ in zeros alone stay apart."""
    parts = _DIGITS.split(name)
    words = [part if index % 2 == 0 else (part.lstrip("0") or "0") for index, part in enumerate(parts)]
    return tuple((len(word), word) if index % 2 else (0, word) for index, word in enumerate(words)) + ((0, name),)


def list_files(folder: str) -> List[str]:
    """Names in a folder in natural order; those that begin with a dot (left by foreign systems) are left out.

    @throws InputError if it cannot be read.
    """
    try:
        names = os.listdir(folder)
    except OSError as error:
        raise InputError(f"{folder}: cannot be read: {error.strerror}") from None
    return sorted((name for name in names if not name.startswith(".")), key=natural_key)


def list_images(folder: str) -> List[str]:
    """Paths of the images of a folder in natural order. @throws InputError if there are none."""
    if not os.path.isdir(folder):
        raise InputError(f"{folder}: no such folder")
    paths = [os.path.join(folder, name) for name in list_files(folder) if name.lower().endswith(IMAGE_ENDINGS)]
    images = [path for path in paths if not os.path.isdir(path)]
    if not images:
        raise InputError(f"{folder}: no images ({', '.join(IMAGE_ENDINGS)})")
    return images
