"""APE and RPE of estimates against a reference: results with their table rows and records."""

import json
import sys
from typing import Dict, List, Optional

from ratslam_tools import text_file
from ratslam_tools.evaluation import comparison, metrics
from ratslam_tools.table import format_table
from ratslam_tools.trajectory import frames


class Result:
    """Errors of one estimate: in space, and on the ground plane if the reference has one."""

    def __init__(
        self, name: str, compared: comparison.Comparison, errors, ends, ground_errors=None, ground_plane=None
    ):
        self.name, self.compared, self.errors, self.ends = name, compared, errors, ends
        self.ground_errors, self.ground_plane = ground_errors, ground_plane
        self.all_steps: Optional[float] = None  # equation (11), where asked for

    def record(self) -> Dict:
        """The record that --save_results writes."""
        alignment = self.compared.alignment
        record = {
            "estimate": self.name,
            "matched": self.compared.matched,
            "errors": len(self.errors),
            "reference_poses": self.compared.reference_poses,
            "coverage": self.compared.coverage,
            "alignment": {
                "rotation": alignment.rotation.tolist(),
                "translation": alignment.translation.tolist(),
                "scale": alignment.scale,
            },
            "stats": metrics.statistics(self.errors),
        }
        if self.ground_errors is not None:
            record["ground"] = {"plane": self.ground_plane, "stats": metrics.statistics(self.ground_errors)}
        if self.all_steps is not None:
            record["average_rmse_over_all_steps"] = self.all_steps
        return record


def collapse_words(name: str, alignment) -> str:
    """A clause on a path whose scale has collapsed (association.Alignment.collapsed)."""
    return (
        f"no scale fits {name} to the truth: least squares give {alignment.scale:.3g}, and its streets {alignment.length:.2g} times "
        f"their true length; parts of it are not joined, or lie far from where they were driven"
    )


def tell_collapse(name: str, alignment) -> None:
    """A note on stderr if the scale of an estimate has collapsed."""
    if alignment.collapsed:
        print(f"note: {collapse_words(name, alignment)}", file=sys.stderr)


def evaluate_ape(reference, estimates, settings, relation="trans_part") -> List[Result]:
    """APE (7)-(8) of each estimate."""
    needs_body = relation != "trans_part"
    results = []
    for estimate in estimates:
        compared = comparison.compare(reference, estimate, settings, needs_body, world_matters=needs_body)
        errors = metrics.ape(compared.reference, compared.estimate, relation)
        ground = comparison.on_ground(compared, settings, positions_only=not needs_body)
        on_ground = None if ground is None else metrics.ape(ground.reference, ground.estimate, relation)
        plane = None if ground is None else frames.GROUND[compared.convention]
        results.append(Result(estimate.name, compared, errors, range(len(errors)), on_ground, plane))
    return results


def evaluate_rpe(
    reference,
    estimates,
    settings,
    relation="trans_part",
    delta=1.0,
    unit="f",
    overlapping=False,
    all_steps=False,
) -> List[Result]:
    """RPE (9)-(10) of each estimate over steps of `delta` frames or metres; with all_steps also (11)."""
    results = []
    for estimate in estimates:
        compared = comparison.compare(reference, estimate, settings, needs_body=True)
        starts, ends = metrics.pose_pairs(compared.estimate, delta, unit, overlapping)
        result = Result(
            estimate.name,
            compared,
            metrics.rpe(compared.reference, compared.estimate, starts, ends, relation),
            ends,
        )
        if all_steps:
            result.all_steps = float(
                metrics.rmse_of_all_steps(compared.reference, compared.estimate, relation).mean()
            )
        results.append(result)
    return results


def print_results(title: str, reference, results: List[Result]) -> None:
    """The table on stdout, coverage with every figure; notes on stderr."""
    print(title)
    rows = [["estimate", "", *metrics.STATISTICS, "matched", "coverage"]]
    for result in results:
        coverage = [
            f"{result.compared.matched}/{result.compared.reference_poses}",
            f"{100 * result.compared.coverage:.1f} %",
        ]
        in_space = metrics.statistics(result.errors)
        label = "3D" if result.ground_errors is not None else ""
        rows.append([result.name, label, *(f"{in_space[key]:.6g}" for key in metrics.STATISTICS), *coverage])
        if result.ground_errors is not None:
            ground = metrics.statistics(result.ground_errors)
            rows.append(
                [
                    "",
                    f"ground ({result.ground_plane})",
                    *(f"{ground[key]:.6g}" for key in metrics.STATISTICS),
                    *coverage,
                ]
            )
    print(format_table(rows))
    for result in results:
        tell_collapse(result.name, result.compared.alignment)
        if result.compared.alignment.scale != 1.0:
            print(f"scale of {result.name}: {result.compared.alignment.scale:.6g}")
        if result.all_steps is not None:
            print(f"average RMSE over all steps, equation (11), of {result.name}: {result.all_steps:.6g}")


def write_json(path: str, record: Dict) -> None:
    """Writes a record as a JSON file. @throws InputError if it cannot be written."""
    with text_file.writing(path) as file:
        json.dump(record, file, indent=1)
        file.write("\n")
