"""A donkey car's tub: `catalog_*.catalog` with a JSON record a line, `manifest.json` and images/."""

import glob
import json
import math
import os
from dataclasses import dataclass
from typing import List, Set

from ratslam_tools import text_file
from ratslam_tools.datasets.images import natural_key
from ratslam_tools.errors import InputError, require_folder

MAX_INDEX = 2**53
MAX_TIME_MS = 2**32 * 1000


@dataclass(frozen=True, order=True)
class Record:
    """One image with the commands that were given when it was taken."""

    index: int
    time_ms: int
    angle: float  # -1 full left ... +1 full right
    throttle: float
    image: str  # name in images/


@dataclass
class Tub:
    """The records that are not deleted, by index. `deleted` is the number of deleted ones in the manifest."""

    records: List[Record]
    deleted: int = 0


def read(folder: str) -> Tub:
    """Records of all catalogs. @throws InputError for a malformed line, a file of another folder or no record."""
    require_folder(folder)
    records: List[Record] = []
    paths = glob.glob(os.path.join(glob.escape(folder), "catalog_*.catalog"))
    for path in sorted(paths, key=natural_key):
        for number, line in text_file.read_lines(path):
            records.append(_record(path, number, line))
    if not records:
        raise InputError(f"{folder}: no catalog_*.catalog with records")
    deleted = _deleted(os.path.join(folder, "manifest.json"))
    kept = sorted(record for record in records if record.index not in deleted)
    if not kept:
        raise InputError(f"{folder}: all {len(records)} records are deleted, says manifest.json")
    for before, after in zip(kept, kept[1:]):
        if before.index == after.index:
            raise InputError(f"{folder}: record {after.index} is there twice")
    return Tub(kept, len(records) - len(kept))


def _record(path: str, number: int, line: str) -> Record:
    try:
        fields = json.loads(line)
        record = Record(
            _whole(fields["_index"], MAX_INDEX),
            _whole(fields["_timestamp_ms"], MAX_TIME_MS),
            float(fields["user/angle"]),
            float(fields["user/throttle"]),
            str(fields["cam/image_array"]),
        )
        if not (abs(record.angle) <= 1e6 and abs(record.throttle) <= 1e6):
            raise ValueError("a command that is not finite")
    except KeyError as error:
        raise InputError(f"{path}:{number}: not a record: no {text_file.shown(str(error))}") from None
    except (ValueError, TypeError, OverflowError, RecursionError) as error:
        raise InputError(f"{path}:{number}: not a record: {text_file.shown(str(error))}") from None
    if os.path.basename(record.image) != record.image or record.image in ("", ".", "..") or "\0" in record.image:
        raise InputError(f"{path}:{number}: '{text_file.shown(record.image)}' is no name of a file in images/")
    return record


def _whole(value, limit: int) -> int:
    """A number or text as an int. @throws ValueError unless it is a whole number of at least 0 and below `limit`."""
    if isinstance(value, str):
        value = text_file.finite_number(value)
    if isinstance(value, float) and not (math.isfinite(value) and value == int(value)):
        raise ValueError(f"{value} is no whole number")
    number = int(value)
    if not 0 <= number < limit:
        raise ValueError(f"{str(number)[:24]} lies outside 0 to {limit}")
    return number


def _deleted(path: str) -> Set[int]:
    """deleted_indexes of a manifest (JSON values, one a line); none without a manifest."""
    if not os.path.exists(path):
        return set()
    deleted: Set[int] = set()
    for number, line in text_file.read_lines(path):
        try:
            value = json.loads(line)
            indexes = value.get("deleted_indexes", []) if isinstance(value, dict) else []
            deleted.update(_whole(index, MAX_INDEX) for index in indexes)
        except (ValueError, TypeError, OverflowError, RecursionError) as error:
            raise InputError(f"{path}:{number}: not a line of a manifest: {text_file.shown(str(error))}") from None
    return deleted
