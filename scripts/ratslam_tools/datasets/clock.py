"""A recording's clock that was set back while it ran (by the network's time, by hand)."""

from typing import List, Optional, Tuple

# Fewer images in a row than these behind the latest time come late; so many run on another clock.
MIN_BEHIND = 3
# A file is in no order at all where more than this share of its times lies before the one before it.
MAX_DESCENTS = 0.05
# Images of one clock follow each other within so many usual steps.
MAX_STEP = 5


def clock_set_back(images: List[Tuple[int, str]]) -> Optional[Tuple[int, float]]:
    """Looks at (stamp [ns], name) in the order of their file, which is that of their recording.

    Returns the first stamp after the clock was set back, and by how much [s]; None where it was not. Single
    late lines, repeated lines and files in no order are none of it.
    """
    lines = list(dict.fromkeys(images))
    stamps = [stamp for stamp, _ in lines]
    steps = [after - before for before, after in zip(stamps, stamps[1:])]
    forward = sorted(step for step in steps if step > 0)
    descents = len(steps) - sum(step >= 0 for step in steps)
    if not forward or descents == 0 or descents > max(3, MAX_DESCENTS * len(steps)):
        return None
    usual = forward[len(forward) // 2]
    latest, begin, behind = stamps[0], 0, 0
    for index in range(1, len(stamps)):
        if stamps[index] > latest:
            latest, behind = stamps[index], 0
            continue
        goes_on = behind > 0 and 0 < stamps[index] - stamps[index - 1] <= MAX_STEP * usual
        behind, begin = (behind + 1, begin) if goes_on else (1, index)
        if behind >= MIN_BEHIND:
            return stamps[begin], (latest - stamps[begin]) * 1e-9
    return None
