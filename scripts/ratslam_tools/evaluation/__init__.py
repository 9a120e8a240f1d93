"""Errors of an estimate against the truth."""

from ratslam_tools.evaluation.results import (  # noqa: F401
    Result,
    evaluate_ape,
    evaluate_rpe,
    print_results,
    write_json,
)
