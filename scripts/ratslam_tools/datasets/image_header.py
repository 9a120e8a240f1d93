"""Check of the header of a compressed image before it is decoded: kind, size, and whether the image is complete.

Only JPEG and PNG of the sizes of cameras are decoded. Other codecs of OpenCV may end the process, and a picture of a
few kilobytes may unpack to gigabytes.
"""

import struct
from typing import Tuple

MAX_PIXELS = 50_000_000
MAX_SIDE = 65535
PNG = b"\x89PNG\r\n\x1a\n"


def measure(data: bytes) -> Tuple[int, int]:
    """Width and height of a whole image. @throws ValueError with the reason for bytes that are neither JPEG nor PNG, cut off,
    or of too large an image.
    """
    try:
        if data[:3] == b"\xff\xd8\xff":
            width, height = _walk_jpeg(data)
        elif data[:8] == PNG:
            width, height = _walk_png(data)
        else:
            raise ValueError(f"{len(data)} bytes that are neither JPEG nor PNG")
    except (struct.error, IndexError):
        raise ValueError(f"it was cut off after {len(data)} bytes") from None
    if width == 0 or height == 0:
        raise ValueError("it has no pixels")
    if width > MAX_SIDE or height > MAX_SIDE or width * height > MAX_PIXELS:
        raise ValueError(f"{width}x{height} pixels: at most {MAX_PIXELS} and sides of {MAX_SIDE} are taken")
    return width, height


def _walk_png(data: bytes) -> Tuple[int, int]:
    if data[12:16] != b"IHDR":
        raise ValueError("a PNG without its header")
    size = struct.unpack_from(">II", data, 16)
    position = len(PNG)
    while True:
        length, kind = struct.unpack_from(">I4s", data, position)
        if kind == b"IEND":
            return size
        position += length + 12


def _walk_jpeg(data: bytes) -> Tuple[int, int]:
    """Reads the segments up to the first scan. Pictures inside segments (thumbnails) are skipped."""
    size, position = None, 2
    while True:
        if data[position] != 0xFF:
            raise ValueError("a JPEG without its markers")
        while data[position] == 0xFF:  # any number of fill bytes
            position += 1
        marker = data[position]
        position += 1
        if marker == 0x01 or 0xD0 <= marker <= 0xD8:
            continue
        (length,) = struct.unpack_from(">H", data, position)
        if length < 2 or marker == 0xD9:
            raise ValueError("a JPEG without an image")
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            size = struct.unpack_from(">HH", data, position + 3)[::-1]
        position += length
        if marker == 0xDA:
            break
    if size is None:
        raise ValueError("a JPEG that does not tell its size")
    if data.find(b"\xff\xd9", position) < 0:
        raise ValueError(f"it was cut off after {len(data)} bytes")
    return size
