"""Measures of place recognition, as defined in the literature.

Each query image has an answer (a place and a score) and may have right places. Recall at rank 1, the
precision-recall curve over the score, the area under it and the recall at 100 % precision are those of VPR-Bench
(Zaffar et al., IJCV 2021) and OpenSeqSLAM (Talbot et al., 2018): precision = right answers / answers given, recall =
right answers / queries with a right place.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Answers:
    """One answer per query. frame, place: ints (place -1: none); score: floats, larger is more certain; claimed:
    bools."""

    frame: np.ndarray
    place: np.ndarray
    score: np.ndarray
    claimed: np.ndarray


@dataclass(frozen=True)
class PlaceScores:
    """Number of queries with a right place, recall at rank 1, area under the curve, recall at 100 % and 99 %
    precision, the number of answers that the system claims and of right ones among them, and the curve."""

    questions: int
    right_at_1: float
    auc: float
    recall_at_100: float
    recall_at_99: float
    claimed: int
    claimed_right: int
    recall: np.ndarray
    precision: np.ndarray


def score(answers: Answers, right: np.ndarray, has_right_place: np.ndarray) -> PlaceScores:
    """The measures of n answers. right, has_right_place: bools (n,), whether the answer is right, and whether there is a right
    place."""
    questions = int(has_right_place.sum())
    given = answers.place >= 0
    order = np.argsort(-answers.score[given], kind="stable")
    hits = right[given][order]
    scores = answers.score[given][order]
    last_of_equals = np.append(np.diff(scores) != 0, True) if len(scores) else np.zeros(0, bool)
    found = np.cumsum(hits)[last_of_equals]
    taken = np.arange(1, len(hits) + 1)[last_of_equals]
    recall = found / max(questions, 1)
    precision = found / np.maximum(taken, 1)
    curve_recall = np.concatenate([[0.0], recall])
    curve_precision = np.concatenate([precision[:1] if len(precision) else [1.0], precision])
    area = float(np.sum(np.diff(curve_recall) * (curve_precision[1:] + curve_precision[:-1]) / 2))

    def recall_at(least):
        return float(recall[precision >= least].max()) if (precision >= least).any() else 0.0

    return PlaceScores(
        questions,
        float((right & has_right_place).sum() / max(questions, 1)),
        area,
        recall_at(1.0),
        recall_at(0.99),
        int(answers.claimed.sum()),
        int((answers.claimed & right).sum()),
        curve_recall,
        curve_precision,
    )


def by_index(answers: Answers, tolerance: int, learned: int):
    """Judges answers about two passes of one route whose images belong together by number, the first of `learned` images:
    (right, has_right_place), bools (n,). A place is right if it is at most `tolerance` images off."""
    right = (answers.place >= 0) & (np.abs(answers.place - answers.frame) <= tolerance)
    return right, answers.frame - tolerance < learned


def by_truth(answers: Answers, positions: np.ndarray, headings: np.ndarray, radius: float, min_gap: int):
    """One recording with true positions (n, 2) [m] and headings (n,) [rad]: a right place is within `radius` metres
    and 45 degrees, at least `min_gap` frames earlier. Returns (right, has_right_place)."""
    right = np.zeros(len(answers.frame), bool)
    has_right_place = np.zeros(len(answers.frame), bool)
    for k, frame in enumerate(answers.frame):
        near = _near(positions, headings, frame, radius)[: max(0, frame - min_gap + 1)]
        has_right_place[k] = near.any()
        right[k] = 0 <= answers.place[k] < len(near) and near[answers.place[k]]
    return right, has_right_place


def revisits(frames: np.ndarray, positions: np.ndarray, headings: np.ndarray, radius: float, min_gap: int) -> np.ndarray:
    """Which frames revisit a place, bools (n,): the robot has been there as by_truth says, and a stay of it there ended at least
    `min_gap` frames earlier. Who stands still revisits nothing."""
    found = np.zeros(len(frames), bool)
    for k, frame in enumerate(frames):
        near = _near(positions, headings, frame, radius)
        left = near[:-1] & ~near[1:]
        found[k] = left[: max(0, frame - min_gap + 1)].any()
    return found


def _near(positions: np.ndarray, headings: np.ndarray, frame: int, radius: float) -> np.ndarray:
    """Whether the robot was within `radius` and 45 degrees of where it is at a frame, for each frame up to it, itself included:
    bools (frame + 1,)."""
    turned = np.abs(np.angle(np.exp(1j * (headings[: frame + 1] - headings[frame]))))
    return (np.linalg.norm(positions[: frame + 1] - positions[frame], axis=1) <= radius) & (turned <= np.pi / 4)


def figure(curves: dict, pyplot):
    """Precision over recall. curves: label -> PlaceScores."""
    drawn, axes = pyplot.subplots(figsize=(6, 5), constrained_layout=True)
    for label, scores in curves.items():
        axes.plot(scores.recall, scores.precision, label=f"{label}: AUC {100 * scores.auc:.1f} %")
    axes.set(xlabel="recall", ylabel="precision", xlim=(0, 1.01), ylim=(0, 1.01))
    axes.grid(alpha=0.3)
    axes.legend(loc="lower left")
    return drawn
