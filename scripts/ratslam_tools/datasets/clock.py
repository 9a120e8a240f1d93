"""Detection of a clock that was set back during a recording (by the network's time, or by hand)."""

from typing import List, Optional, Tuple

# Fewest consecutive images before the latest stamp that show a clock set back. Fewer are late images.
MIN_BEHIND = 3
# A file is not ordered if more than this share of its times is earlier than the time before it.
MAX_DESCENTS = 0.05
# Largest step between images of one clock, in usual steps.
MAX_STEP = 5


def clock_set_back(images: List[Tuple[int, str]]) -> Optional[Tuple[int, float]]:
    """Checks (stamp [ns], name) in the order of recording.

    Returns the first stamp after the clock was set back, and the size of the jump [s]; None if it was not set back.
    Single late lines, repeated lines and files without order are no jump.
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
