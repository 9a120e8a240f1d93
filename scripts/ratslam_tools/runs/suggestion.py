"""Parameters that suit a recording, found from its first minutes in the order in which they depend on each other.

1. Crop: remove rows and columns that never change (bonnet, robot) or show nothing (sky, ceiling).
2. Scale: a pose cell is as wide as the robot moves in a few frames, so that the packet moves smoothly.
3. Threshold: experiences : templates between 1 : 1 and 2 : 1. With fewer experiences every image is a place of its own;
   with more one view stands for many places.
4. Injection: the least energy with which the pose cells follow views that come back, on short loops and on long ones.
   With more energy single false recalls would move the packet.
"""

import itertools
import math
import os
from dataclasses import dataclass
from typing import Callable, Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from ratslam_tools.datasets import bags, image_message, images, recorder
from ratslam_tools.errors import InputError
from ratslam_tools.runs import run_folder, runner

FRAMES_A_CELL = 2.5  # frames to cross a pose cell at the usual speed
MOVING = 0.1  # below this share of the 90 % quantile of the speeds the robot stands still
EDGE = 0.35  # a row with less than this share of the median change or texture is cropped
LARGEST_CUT = 0.45  # of the image, from one side
RATIO = (1.2, 1.8)  # wanted experiences : templates
THRESHOLDS = (0.005, 0.3)
ENERGIES = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4)
LONG_AGO = 50  # a view comes back if it was last seen more than so many frames before
LEAST_LOOP = 5  # least number of frames that come back in a loop; fewer may be false recalls
HOLE = 10  # largest distance between consecutive frames of a loop that come back
ENOUGH = 0.9  # share of the best energy's frames
# What is looked for in every recording. The first run shows whether threshold_key() is looked for too.
KEYS = (*(f"image_crop_{axis}_{end}" for axis in "xy" for end in ("min", "max")), "pc_cell_x_size", "pc_vt_inject_energy")
Runs = Callable[[Dict[str, str]], run_folder.Run]


@dataclass(frozen=True)
class View:
    """Which images of a recording the runs see, and how: options of ratslam_run."""

    topic: Optional[str] = None  # of a bag; None: the first of images
    folder: Optional[str] = None  # of a KITTI sequence; None: image_0
    rotate: Optional[str] = None
    start: int = 0  # the first image

    @staticmethod
    def of_options(words: Sequence[str]) -> "View":
        """The view that options of ratslam_run choose. It takes the beginning of an option's name for the option."""
        names = ("--image-topic", "--image-folder", "--rotate", "--from-frame")
        whole = []
        for word in words:
            begin, equals, value = word.partition("=")
            meant = [name for name in names if len(begin) > len("--") and name.startswith(begin)]
            whole.append(meant[0] + equals + value if len(meant) == 1 else word)
        topic, folder, rotate, start = (runner.option(whole, name) for name in names)
        return View(topic, folder, rotate, int(start) if start and start.isdecimal() else 0)  # it refuses what is no number


def sample_images(source: str, frames: int, count: int = 60, view: View = View()) -> List[np.ndarray]:
    """Grey images at equal distances over the first `frames` that runs see of a folder or bag, upright. Unreadable ones are
    left out, as in a run. @throws InputError if none is left"""
    read = _sample_bag if bags.is_bag(source) else _sample_folder
    quarters = int(view.rotate) // 90 if view.rotate in ("90", "180", "270") else 0  # None or 0; a run refuses the rest
    return [np.rot90(image, -quarters) for image in images.with_eight_bits(read(source, frames, count, view))]


def _sample_folder(source: str, frames: int, count: int, view: View) -> List[np.ndarray]:
    files = _files_of(source, view.folder)
    _require_start(view, len(files), source)
    paths = files[view.start : view.start + frames]
    sampled, reason = [], None
    for path in paths[:: max(1, len(paths) // count)]:
        try:
            sampled.append(images.load_image(path, colour=False))
        except InputError as error:
            reason = reason or error
    if not sampled:
        raise InputError(f"{source}: no image can be read; the first: {reason}")
    return sampled


def _require_start(view: View, count: int, source: str) -> None:
    """@throws InputError if the first image lies behind the last of `count`"""
    if view.start >= max(count, 1):
        raise InputError(f"--from-frame: {view.start} is not allowed: {source} has {count} images, counted from 0")


def _files_of(source: str, folder: Optional[str]) -> List[str]:
    """Paths of the images that ratslam_run finds in a folder, in its order."""
    chosen = os.path.join(source, folder or "image_0")
    if folder or os.path.isdir(chosen):
        return images.list_images(chosen)
    if os.path.isfile(os.path.join(source, "data_image.txt")) or os.path.isdir(os.path.join(source, "images")):
        return recorder.read_images(source)
    raise InputError(f"{source}: neither a bag nor a folder with image_0/, data_image.txt or images/")


def _sample_bag(path: str, frames: int, count: int, view: View) -> List[np.ndarray]:
    import cv2

    sampled, reason = [], ""
    with bags.reading(path) as bag:
        topics = bag.get_type_and_topic_info().topics
        kinds = ("sensor_msgs/Image", "sensor_msgs/CompressedImage")
        images_of = [name for name, info in sorted(topics.items()) if info.msg_type in kinds]
        topic = view.topic
        named = [name for name in images_of if topic in (None, name) or name == f"{topic}/compressed"]
        if not named:
            there = f", but {', '.join(images_of)}" if images_of else ""
            raise InputError(f"{path}: no topic of images{f' {topic}' if topic else ''}{there}")
        _require_start(view, topics[named[0]].message_count, path)
        step = max(1, min(frames, topics[named[0]].message_count - view.start) // count)
        messages: Iterator = bags.each_message(bag, named[0], topics[named[0]].msg_type)
        for number, message in enumerate(itertools.islice(messages, view.start, view.start + frames)):
            if number % step:
                continue
            if message is None:
                reason = reason or "its messages are damaged or of another type"
                continue
            try:
                if hasattr(message, "encoding"):
                    sampled.append(image_message.grey(message))
                else:
                    sampled.append(images.decode(bytes(message.data), colour=False))
            except (cv2.error, ValueError, TypeError) as error:
                reason = str(error).split("\n", maxsplit=1)[0]
    if not sampled:
        raise InputError(f"{path}: {named[0]}: no image can be read{': ' + reason if reason else ''}")
    return sampled


def crop(sampled: List[np.ndarray]) -> Dict[str, str]:
    """The part of the image that changes and shows something; empty if that is the whole image."""
    size = sampled[0].shape
    stack = np.array([image for image in sampled if image.shape == size], dtype=np.float32)
    change = stack.std(axis=0)
    texture = np.abs(np.diff(stack, axis=2)).mean(axis=0)
    settings = {}
    rows = _kept(np.minimum(_share(change.mean(axis=1)), _share(texture.mean(axis=1))))
    columns = _kept(_share(change.mean(axis=0)))
    for axis, kept, length in (("y", rows, size[0]), ("x", columns, size[1])):
        if kept[0] > 0.05 * length:
            settings[f"image_crop_{axis}_min"] = str(kept[0])
        if kept[1] < 0.95 * length:
            settings[f"image_crop_{axis}_max"] = str(kept[1])
    return settings


def _share(values: np.ndarray) -> np.ndarray:
    return values / max(float(np.median(values)), 1e-6)


def _kept(shares: np.ndarray) -> Tuple[int, int]:
    """First row kept and the one after the last. Rows are removed only from the ends."""
    most = int(LARGEST_CUT * len(shares))
    begin, end = 0, len(shares)
    while begin < most and shares[begin] < EDGE:
        begin += 1
    while len(shares) - end < most and shares[end - 1] < EDGE:
        end -= 1
    return begin, end


def cell_size(stamps: np.ndarray, speeds: np.ndarray) -> float:
    """Edge of a pose cell, rounded to 1, 1.5, 2, 3, 5 or 7 times a power of ten, in the unit of the speeds (per second), which
    may be negative. @throws InputError if nothing moves.
    """
    speeds, periods = np.abs(speeds), np.diff(stamps)
    fast = float(np.quantile(speeds, 0.9)) if len(speeds) else 0.0
    if fast <= 0.0 or len(periods) == 0:
        raise InputError("the odometry says that nothing moves: no scale can be found; is it the right topic?")
    step = float(np.median(speeds[speeds > MOVING * fast])) * float(np.median(periods))
    exact = FRAMES_A_CELL * step
    digit = 10.0 ** math.floor(math.log10(exact))
    return min((1, 1.5, 2, 3, 5, 7, 10), key=lambda factor: abs(math.log(factor * digit / exact))) * digit


def ratio_of(run: run_folder.Run) -> float:
    """Experiences : templates."""
    counts = run.summary.get("counts", {})
    return counts.get("experiences", 0) / max(1, counts.get("templates", 0))


def threshold_key(run: run_folder.Run) -> Optional[str]:
    """The threshold of recalls; None for vt_recall: belief, where it only decides which views are new places."""
    parameters = run.summary.get("parameters", {})
    if parameters.get("vt_recall") == "belief":
        return None
    return "vt_orientation_threshold" if parameters.get("vt_descriptor") == "orientation" else "vt_match_threshold"


def threshold(runs: Runs, settings: Dict[str, str], key: str, tries: int = 8) -> Tuple[str, float]:
    """The threshold whose ratio is in RATIO or nearest to it, and that ratio."""
    low, high = (math.log(value) for value in THRESHOLDS)
    best: Optional[Tuple[float, str, float]] = None
    for _ in range(tries):
        middle = 0.5 * (low + high)
        value = f"{math.exp(middle):.3g}"
        ratio = ratio_of(runs({**settings, key: value}))
        miss = max(RATIO[0] - ratio, ratio - RATIO[1], 0.0)
        if best is None or miss < best[0]:
            best = (miss, value, ratio)
        if miss == 0.0:
            break
        low, high = (middle, high) if ratio < RATIO[0] else (low, middle)
    return best[1], best[2]


def loops_of(ids: np.ndarray) -> List[np.ndarray]:
    """Frames of each loop: stretches in which views come back. @param ids the view of each frame, -1 for none."""
    last_new: Dict[int, int] = {}  # when a view was last seen without coming back
    loops: List[List[int]] = []
    for frame, view in enumerate(ids):
        if view < 0:
            continue
        if view not in last_new or frame - last_new[view] <= LONG_AGO:
            last_new[view] = frame
        elif loops and frame - loops[-1][-1] <= HOLE:
            loops[-1].append(frame)
        else:
            loops.append([frame])
    return [np.array(loop) for loop in loops if len(loop) >= LEAST_LOOP]


def followed(run: run_folder.Run) -> float:
    """Sum over the loops of the share of their frames in which the map is at an old place; 0 without loops."""
    if run.templates is None or run.actions is None:
        return 0.0
    stamps, actions = run.templates["stamp"], run.actions
    decided = actions["action"] > 0
    places, when = actions["dest_id"][decided], np.searchsorted(stamps, actions["stamp"][decided])
    made: Dict[float, int] = {}
    for place, frame in zip(places, when):
        made.setdefault(place, int(frame))
    current = np.searchsorted(when, np.arange(len(stamps)), side="right") - 1
    age = np.array([frame - made[places[row]] if row >= 0 else 0 for frame, row in enumerate(current)])
    return float(sum(np.mean(age[loop] > LONG_AGO) for loop in loops_of(run.templates["template_id"])))


def injection(runs: Runs, settings: Dict[str, str]) -> Optional[str]:
    """The least energy that follows nearly as much as the best one; None if no energy follows anything."""
    shares = [followed(runs({**settings, "pc_vt_inject_energy": f"{energy:g}"})) for energy in ENERGIES]
    enough = ENOUGH * max(shares)
    return next((f"{energy:g}" for energy, share in zip(ENERGIES, shares) if share >= enough > 0.0), None)
