"""The pixels of a sensor_msgs/Image in the encodings that ratslam_run takes. cv_bridge's own converter for Python cannot be
loaded on Ubuntu 20.04.
"""

import numpy as np

# Encoding: bytes a value, values a pixel, and OpenCV's conversion to grey (none: it is grey).
_FORMS = {
    "mono8": (1, 1, None),
    "8UC1": (1, 1, None),
    "mono16": (2, 1, None),
    "16UC1": (2, 1, None),
    "bgr8": (1, 3, "COLOR_BGR2GRAY"),
    "8UC3": (1, 3, "COLOR_BGR2GRAY"),
    "rgb8": (1, 3, "COLOR_RGB2GRAY"),
    "bgra8": (1, 4, "COLOR_BGRA2GRAY"),
    "8UC4": (1, 4, "COLOR_BGRA2GRAY"),
    "rgba8": (1, 4, "COLOR_RGBA2GRAY"),
    "bgr16": (2, 3, "COLOR_BGR2GRAY"),
    "rgb16": (2, 3, "COLOR_RGB2GRAY"),
    "yuv422": (1, 2, "COLOR_YUV2GRAY_UYVY"),
    "yuv422_yuy2": (1, 2, "COLOR_YUV2GRAY_YUY2"),
    # OpenCV names a pattern by its second row.
    "bayer_rggb8": (1, 1, "COLOR_BayerBG2GRAY"),
    "bayer_bggr8": (1, 1, "COLOR_BayerRG2GRAY"),
    "bayer_gbrg8": (1, 1, "COLOR_BayerGR2GRAY"),
    "bayer_grbg8": (1, 1, "COLOR_BayerGB2GRAY"),
    "bayer_rggb16": (2, 1, "COLOR_BayerBG2GRAY"),
    "bayer_bggr16": (2, 1, "COLOR_BayerRG2GRAY"),
    "bayer_gbrg16": (2, 1, "COLOR_BayerGR2GRAY"),
    "bayer_grbg16": (2, 1, "COLOR_BayerGB2GRAY"),
}


def grey(message) -> np.ndarray:
    """The grey image (height, width) of 8 or 16 bits. @throws ValueError for another encoding, or data that do not fill it."""
    import cv2

    if message.encoding not in _FORMS:
        raise ValueError(f"encoding '{message.encoding}' is none of {', '.join(_FORMS)}")
    size, channels, conversion = _FORMS[message.encoding]
    row, least = message.step, message.width * size * channels
    # The last row may be without its padding.
    if message.height * message.width == 0 or row < least or len(message.data) < row * (message.height - 1) + least:
        raise ValueError(
            f"{len(message.data)} bytes do not hold {message.width}x{message.height} pixels of {message.encoding} "
            f"in rows of {row} bytes"
        )
    padded = bytes(message.data[: row * message.height]).ljust(row * message.height, b"\0")
    rows = np.frombuffer(padded, np.uint8).reshape(message.height, row)[:, :least]
    values = np.ascontiguousarray(rows).view(">u2" if message.is_bigendian and size == 2 else f"<u{size}")
    if size == 2:
        values = values.astype(np.uint16)
    if conversion is None:
        return values
    pixels = values.reshape(message.height, message.width, channels) if channels > 1 else values
    return cv2.cvtColor(pixels, getattr(cv2, conversion))
