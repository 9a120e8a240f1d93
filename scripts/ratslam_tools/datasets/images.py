"""Image files: their pixels, and the order of a folder of them."""

import os
import re
from typing import List, Sequence, Tuple

import numpy as np

from ratslam_tools.datasets.image_header import measure
from ratslam_tools.errors import InputError, require_folder

ENDINGS = (".png", ".jpg", ".jpeg")
_DIGITS = re.compile(r"([0-9]+)")


def natural_key(name: str) -> tuple:
    """Sort key in which runs of digits count as numbers: image9.png before image10.png."""
    parts = _DIGITS.split(name)
    words = [part if index % 2 == 0 else (part.lstrip("0") or "0") for index, part in enumerate(parts)]
    return tuple((len(word), word) if index % 2 else (0, word) for index, word in enumerate(words)) + ((0, name),)


def list_files(folder: str) -> List[str]:
    """Names in a folder in natural order. Names that begin with a dot are left out, because other systems leave such
    files.

    @throws InputError if it cannot be read.
    """
    try:
        names = os.listdir(folder)
    except OSError as error:
        raise InputError(f"{folder}: cannot be read: {error.strerror}") from None
    return sorted((name for name in names if not name.startswith(".")), key=natural_key)


def list_images(folder: str) -> List[str]:
    """Paths of the images of a folder in natural order. @throws InputError if there are none."""
    require_folder(folder)
    paths = [os.path.join(folder, name) for name in list_files(folder) if name.lower().endswith(ENDINGS)]
    images = [path for path in paths if not os.path.isdir(path)]
    if not images:
        raise InputError(f"{folder}: no images ({', '.join(ENDINGS)})")
    return images


def times_of(images: Sequence[str], count: int, path: str, what: str = "time") -> List[int]:
    """Which of `count` times, or other entries (what), in the file `path` belongs to each image.

    If there are as many times as images, they belong together in order. If there are more times, the numbers in the
    images' names decide. They count from 0, from 1 if the last number is that of the last time, or from the first
    number if first and last fit. @throws InputError if the numbers do not fit, or there are fewer times than images.
    """
    if count == len(images):
        return list(range(count))
    complaint = f"{path}: {count} {what}s for {len(images)} images"
    if count < len(images):
        raise InputError(complaint)
    numbers = _numbers(images)
    if numbers is None:
        raise InputError(f"{complaint}, whose names do not tell which of them is missing")
    first, last = numbers[0], numbers[-1]
    if last == count and first >= 1:
        base = 1
    elif last < count:
        base = 0
    elif last - first + 1 == count:
        base = first
    else:
        raise InputError(f"{complaint} numbered {first} to {last}: which {what} is whose is not clear")
    return [number - base for number in numbers]


def _numbers(images: Sequence[str]):
    """The numbers at the ends of the names; None unless they are ascending and the names are equal before them."""
    numbers, before = [], set()
    for path in images:
        match = re.fullmatch(r"(.*?)([0-9]{1,18})", os.path.splitext(os.path.basename(path))[0])
        if match is None:
            return None
        before.add(match.group(1))
        numbers.append(int(match.group(2)))
    rising = all(after > number for number, after in zip(numbers, numbers[1:]))
    return numbers if len(before) == 1 and rising else None


def measure_image(path: str) -> Tuple[int, int]:
    """Width and height of an image file, which is not decoded. @throws InputError as load_image."""
    return _read_image(path, measure)


def load_image(path: str, colour: bool) -> np.ndarray:
    """The stored pixels of an image file as ratslam_run takes them (docs/images.md): grey (h, w) of 8 or 16 bits, or BGR
    (h, w, 3) of 8 bits. Orientation tags are ignored. @param colour whether images become BGR; those of 16 grey bits stay
    grey. @throws InputError for a file that is no readable image.
    """
    return _read_image(path, lambda data: decode(data, colour))


def _read_image(path: str, read):
    """The result of read(bytes) for an image file. @throws InputError naming the file if it cannot be read, or if `read`
    raises ValueError."""
    if not os.path.isfile(path):
        raise InputError(f"{path}: not a readable image: there is no such file")
    try:
        with open(path, "rb") as file:
            return read(file.read())
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise InputError(f"{path}: not a readable image: {error}") from None


def decode(data: bytes, colour: bool) -> np.ndarray:
    """The pixels of a JPEG or PNG as in load_image. @throws ValueError with the reason for other data."""
    import cv2

    measure(data)
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)  # ignores orientation tags
    except cv2.error:
        image = None
    if image is None:
        raise ValueError("it is corrupt")
    if image.ndim == 3 and image.shape[2] == 4:
        image = np.ascontiguousarray(image[:, :, :3])
    if image.ndim == 3 and image.dtype == np.uint16:
        image = np.rint(image / 257.0).astype(np.uint8)
    if image.ndim == 3 and not colour:
        return cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    if image.ndim == 2 and image.dtype == np.uint8 and colour:
        return cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    return image


def with_eight_bits(images: Sequence[np.ndarray]) -> List[np.ndarray]:
    """Grey images (h, w) of one camera, each converted to 8 bits. 16-bit images are scaled by the number of bits that the
    brightest one uses: 8, 10, 12, 14 or 16, as in ratslam_run (system/image_stage.h).
    """
    largest = max((int(image.max()) for image in images if image.dtype == np.uint16), default=0)
    bits = next((bits for bits in (8, 10, 12, 14) if largest < 1 << bits), 16)
    return [(image >> (bits - 8)).astype(np.uint8) if image.dtype == np.uint16 else image for image in images]
