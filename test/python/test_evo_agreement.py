"""The figures of evo 1.36.5 on public trajectories: every case of APE and RPE that was recorded."""

import json

import pytest

from ratslam_tools.evaluation import metrics
from ratslam_tools.trajectory import association
from ratslam_tools.trajectory import read_trajectory

RELATIONS = {
    "translation_part": "trans_part",
    "rotation_angle_deg": "angle_deg",
    "full_transformation": "full",
}


def test_all_cases_agree_to_a_millionth(data):
    with open(data("evo", "expected.json"), encoding="utf-8") as file:
        expected = json.load(file)
    assert len(expected["cases"]) == 260
    trajectories = {}
    for case in expected["cases"]:
        for name in (case["ref"], case["est"]):
            if name not in trajectories:
                trajectories[name] = read_trajectory(data("evo", name), case["format"], allow_repeats=True)
        reference, estimate = association.associate(
            trajectories[case["ref"]], trajectories[case["est"]], expected["t_max_diff"]
        )
        assert len(reference) == case["matched"]
        alignment = association.fit_alignment(
            reference, estimate, "a" in case["options"], "s" in case["options"]
        )
        estimate = alignment.apply(estimate)
        relation = RELATIONS[case["pose_relation"]]
        if case["tool"] == "ape":
            errors = metrics.ape(reference, estimate, relation)
        else:
            starts, ends = metrics.pose_pairs(
                estimate, case["delta"], case["delta_unit"][0], case["all_pairs"]
            )
            assert len(starts) == case["pairs"], case
            errors = metrics.rpe(reference, estimate, starts, ends, relation)
        # Angles between equal rotations are rounding noise of 1e-16: nothing to agree on below 1e-12.
        assert metrics.statistics(errors) == pytest.approx(case["stats"], rel=1e-6, abs=1e-12), case


def test_command_line_gives_the_same_figures(data, run, tmp_path):
    out = tmp_path / "rpe.json"
    result = run(
        "evaluate_rpe",
        "-as",
        "-d",
        100,
        "-u",
        "m",
        "--all_pairs",
        "-r",
        "angle_deg",
        "--save_results",
        out,
        data("evo", "KITTI_00_gt.txt"),
        data("evo", "KITTI_00_ORB.txt"),
    )
    assert result.returncode == 0, result.stderr
    with open(data("evo", "expected.json"), encoding="utf-8") as file:
        cases = json.load(file)["cases"]
    (case,) = [
        case
        for case in cases
        if case["est"] == "KITTI_00_ORB.txt"
        and case["options"] == "-as"
        and case["pose_relation"] == "rotation_angle_deg"
        and case.get("delta") == 100
        and case["all_pairs"]
    ]
    found = json.loads(out.read_text())["results"][0]
    assert found["stats"] == pytest.approx(case["stats"], rel=1e-6)
    assert (found["errors"], found["coverage"]) == (case["pairs"], 1.0)


def test_official_drift_of_orb_slam2_stereo(data):
    """Its authors publish 0.70 % and 0.25 deg per 100 m for sequence 00 (Mur-Artal & Tardos 2017, Table
    I).
    """
    rows = metrics.kitti_drift(
        read_trajectory(data("evo", "KITTI_00_gt.txt")), read_trajectory(data("evo", "KITTI_00_ORB.txt"))
    )
    average = metrics.kitti_average(rows)
    assert average["translation_percent"] == pytest.approx(0.70, abs=0.005)
    assert average["rotation_deg_per_100m"] == pytest.approx(0.25, abs=0.005)
