"""Flat YAML, `key: value` a line with `#` comments: all that configurations and calibrations here need."""

import re
from typing import Dict

from ratslam_tools.errors import InputError

LINE = re.compile(r"^([A-Za-z_][A-Za-z0-9_]*)\s*:\s+(.*)$")


def read(path: str) -> Dict[str, str]:
    """Keys and values as text. @throws InputError naming the line that is of another form or repeats a
    key.
    """
    values: Dict[str, str] = {}
    try:
        with open(path, encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                text = re.sub(r"(^|\s)#.*$", "", line).rstrip()
                if not text or text == "---":
                    continue
                match = LINE.match(text)
                if match is None:
                    raise InputError(f"{path}:{number}: not of the form 'key: value': '{text[:60]}'")
                if match.group(1) in values:
                    raise InputError(f"{path}:{number}: {match.group(1)} is given twice")
                values[match.group(1)] = match.group(2).strip().strip("'\"")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not a text file"
        raise InputError(f"{path}: cannot be read: {reason}") from None
    return values
