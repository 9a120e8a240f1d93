"""Errors of an estimate against the truth."""

from ratslam_tools.evaluation.results import (  # noqa: F401
    Result,
    collapse_words,
    evaluate_ape,
    evaluate_rpe,
    print_results,
    tell_collapse,
    write_json,
)
