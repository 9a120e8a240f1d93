"""evaluate_nees: does a run know how wrong it is?"""

import json

import numpy as np
import pytest

from ratslam_tools.cli import evaluate_nees
from ratslam_tools.datasets import odometry_file
from ratslam_tools.errors import InputError
from ratslam_tools.evaluation import consistency
from ratslam_tools.runs import run_folder
from ratslam_tools.trajectory import Trajectory, read_trajectory, write_tum

STEPS = 2000
TWIST_SIGMA = np.array([0.1, 0.02, 0.02, 0.002, 0.003, 0.004])  # [m/s, rad/s]
POSE_NAMES = ["xx", "xy", "xz", "xyaw", "yy", "yz", "yyaw", "zz", "zyaw", "yawyaw"]


def rotation_of(vector):
    """Rotation matrix of a rotation vector [rad] (Rodrigues)."""
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def write_run(folder, truth, said=1.0):
    """A run whose odometry and map err as they say, but for the factor `said` on what they say.

    Errors of the map's poses are independent of each other.
    """
    random = np.random.default_rng(3)
    folder.mkdir()
    names = ["stamp"] + [f"r{i}{j}" if j < 4 else "xyz"[i - 1] for i in (1, 2, 3) for j in (1, 2, 3, 4)]
    names += [f"cov_{i}{j}" for i in range(1, 7) for j in range(1, 7)] + ["bridged", "correction_from"]
    covariance = (said**2 * np.diag(TWIST_SIGMA**2)).ravel()
    position, rotation = truth.positions[0].copy(), truth.rotations[0].copy()
    lines = [",".join(names)]
    poses = ["stamp,x,y,z,yaw," + ",".join(POSE_NAMES)]
    online = []
    pose_sigma = np.array([0.3, 0.2, 0.1, 0.01])
    exact = np.array([1e-3, 1e-3, 1e-3, 1e-5])  # what a map says of its first pose
    for k in range(len(truth)):
        if k > 0:
            dt = truth.stamps[k] - truth.stamps[k - 1]
            error = random.normal(size=6) * TWIST_SIGMA * dt
            moved = truth.rotations[k - 1].T @ (truth.positions[k] - truth.positions[k - 1])
            turned = truth.rotations[k - 1].T @ truth.rotations[k]
            position = position + rotation @ (moved + turned @ error[:3])
            rotation = rotation @ turned @ rotation_of(error[3:])
        matrix = np.hstack([rotation, position[:, None]]).ravel()
        values = [truth.stamps[k], *matrix, *covariance]
        lines.append(",".join(f"{value:.17g}" for value in values) + ",0,")
        yaw = np.arctan2(truth.rotations[k, 1, 0], truth.rotations[k, 0, 0])
        wrong = random.normal(size=4) * pose_sigma if k > 0 else np.zeros(4)
        values = [truth.stamps[k], *(np.append(truth.positions[k], yaw) + wrong)]
        online.append((truth.positions[k] + wrong[:3], rotation_of(np.array([0.0, 0.0, wrong[3]])) @ truth.rotations[k]))
        upper = np.diag(((said * pose_sigma if k > 0 else exact) ** 2))[np.triu_indices(4)]
        poses.append(",".join(f"{value:.17g}" for value in [*values, *upper]))
    (folder / "odometry.csv").write_text("\n".join(lines) + "\n")
    (folder / "pose_covariance.csv").write_text("\n".join(poses) + "\n")
    write_tum(folder / "trajectory_online.tum", Trajectory(*map(np.array, zip(*online)), truth.stamps))
    return folder


def measured(folder, truth):
    motions = odometry_file.read_motions(str(folder / "odometry.csv"))
    poses = run_folder.read_columns(str(folder / "pose_covariance.csv"), consistency.POSE_COLUMNS)
    return (
        consistency.summary(consistency.motion_nees(motions, truth), 6),
        consistency.summary(consistency.pose_nees(poses, read_trajectory(str(folder / "trajectory_online.tum")), truth), 4),
    )


def test_quantiles_are_those_of_the_tables():
    assert consistency.chi_squared_quantile(0.95, 6) == pytest.approx(12.5916, abs=1e-4)
    assert consistency.chi_squared_quantile(0.975, 4) == pytest.approx(11.1433, abs=1e-4)
    assert consistency.chi_squared_quantile(0.025, 6) == pytest.approx(1.23734, abs=1e-5)
    with pytest.raises(ValueError):
        consistency.chi_squared_quantile(0.95, 3)


def test_errors_as_large_as_said_lie_in_the_band(tmp_path, drive):
    truth = drive(STEPS)
    for found in measured(write_run(tmp_path / "run", truth), truth):
        assert found["count"] == STEPS - 1
        assert found["percent_in_band"] == pytest.approx(95.0, abs=2.0)
        assert found["mean"] == pytest.approx(found["freedom"], rel=0.05)


def test_the_map_may_lie_anywhere(tmp_path, drive):
    """Also where the axes of the truth are tilted, as those of a camera at the first of KITTI's frames are."""
    truth = drive(STEPS)
    turned = rotation_of(np.array([0.0, 0.0, 1.2])) @ rotation_of(np.array([0.02, -0.03, 0.0]))
    _, found = measured(write_run(tmp_path / "run", truth), truth.transformed(turned, np.array([5.0, -70.0, 2.0])))
    assert found["percent_in_band"] == pytest.approx(95.0, abs=2.0)


def test_a_first_pose_that_is_not_on_the_path_is_named(drive):
    truth = drive(100)
    other = Trajectory(truth.positions, truth.rotations, truth.stamps + 50.0, "trajectory_online.tum")
    with pytest.raises(InputError, match=r"the pose at 0\.000000 s is not in trajectory_online\.tum"):
        consistency.pose_nees(poses_with(np.full((100, 4), 1e-3), truth), other, truth)


def test_who_promises_too_much_or_too_little_leaves_the_band(tmp_path, drive):
    truth = drive(STEPS)
    for found in measured(write_run(tmp_path / "bold", truth, said=0.3), truth):
        assert found["percent_above"] > 80.0
    for found in measured(write_run(tmp_path / "timid", truth, said=3.0), truth):
        assert found["percent_below"] > 50.0


def test_predicted_and_unsaid_samples_are_left_out(tmp_path, drive):
    truth = drive(200)
    motions = odometry_file.read_motions(str(write_run(tmp_path / "run", truth) / "odometry.csv"))
    motions.bridged[50:60] = True
    motions.covariances[100] = 0.0
    assert len(consistency.motion_nees(motions, truth)) == 199 - 11 - 2


def test_the_command_prints_and_saves(tmp_path, drive, capsys):
    truth = drive(300)
    write_tum(tmp_path / "truth.tum", truth)
    run = write_run(tmp_path / "run", truth)
    evaluate_nees.main([str(run), "--truth", str(tmp_path / "truth.tum"), "--save_results", str(tmp_path / "n.json")])
    assert "pose in the map" in capsys.readouterr().out
    assert '"percent_in_band"' in (tmp_path / "n.json").read_text()


def columns_alone(path, wanted):
    """Leaves of a CSV file only the columns whose name is `wanted`, a function."""
    rows = [line.split(",") for line in path.read_text().splitlines()]
    kept = [column for column, name in enumerate(rows[0]) if wanted(name)]
    path.write_text("".join(",".join(row[column] for column in kept) + "\n" for row in rows))


@pytest.mark.parametrize("lacking", ["rxyz", "c"])
def test_where_another_program_measured_the_map_is_judged(tmp_path, drive, capsys, lacking):
    truth = drive(300)
    write_tum(tmp_path / "truth.tum", truth)
    run = write_run(tmp_path / "run", truth)
    columns_alone(run / "odometry.csv", lambda name: name[0] not in lacking)
    evaluate_nees.main([str(run), "--truth", str(tmp_path / "truth.tum"), "--save_results", str(tmp_path / "n.json")])
    told = capsys.readouterr()
    assert "pose in the map" in told.out and "odometry's motion" not in told.out
    assert told.err.startswith(f"note: {run / 'odometry.csv'}: it states no poses with covariances") and told.err.count("\n") == 1
    assert list(json.loads((tmp_path / "n.json").read_text())["results"]) == ["map"]


def test_odometry_that_never_predicts_needs_no_columns_for_it(tmp_path, drive):
    run = write_run(tmp_path / "run", drive(50))
    whole = consistency.motion_nees(odometry_file.read_motions(str(run / "odometry.csv")), drive(50))
    columns_alone(run / "odometry.csv", lambda name: name not in ("bridged", "correction_from"))
    assert (consistency.motion_nees(odometry_file.read_motions(str(run / "odometry.csv")), drive(50)) == whole).all()


def test_what_is_missing_is_named(tmp_path, drive):
    truth = drive(50)
    write_tum(tmp_path / "truth.tum", truth)
    run = write_run(tmp_path / "run", truth)
    command = [str(run), "--truth", str(tmp_path / "truth.tum")]
    text = (run / "odometry.csv").read_text()
    (run / "odometry.csv").write_text(text.replace("cov_11", "covariance"))
    with pytest.raises(InputError, match="no column cov_11"):
        evaluate_nees.main(command)
    (run / "odometry.csv").write_text("\n".join(text.splitlines()[:1]))
    with pytest.raises(InputError, match="holds no odometry"):
        evaluate_nees.main(command)
    (run / "odometry.csv").write_text(text)
    (run / "pose_covariance.csv").unlink()
    with pytest.raises(InputError, match="pose_covariance.csv: no such file"):
        evaluate_nees.main(command)


def test_a_run_in_a_loaded_map_is_judged_by_its_own_stretch(drive, tmp_path, capsys):
    known = drive(STEPS)
    write_tum(tmp_path / "truth.tum", known)
    run = write_run(tmp_path / "run", known, said=0.1)  # the first day's, which was too sure
    own = write_run(tmp_path / "own", known)
    for name in ("odometry.csv", "pose_covariance.csv", "trajectory_online.tum"):
        (own / name).rename(run / name.replace(".", "_2."))
    evaluate_nees.main([str(run), "--truth", str(tmp_path / "truth.tum"), "--save_results", str(tmp_path / "n.json")])
    told = capsys.readouterr().out
    assert f"evaluated: the last stretch of 2 ({run / 'odometry_2.csv'}, {run / 'pose_covariance_2.csv'})" in told
    found = json.loads((tmp_path / "n.json").read_text())["results"]
    assert found["map"]["mean"] < 5 and found["odometry"]["mean"] < 8


def poses_with(sigmas, truth):
    """Columns of pose_covariance.csv: the truth, with these sigmas of x, y, z and yaw (n, 4)."""
    yaw = np.arctan2(truth.rotations[:, 1, 0], truth.rotations[:, 0, 0])
    columns = dict(zip(("stamp", "x", "y", "z", "yaw"), (truth.stamps, *truth.positions.T, yaw)))
    columns.update({name: np.zeros(len(truth)) for name in POSE_NAMES})
    columns.update({2 * name if name != "yaw" else "yawyaw": row**2 for name, row in zip(("x", "y", "z", "yaw"), sigmas.T)})
    return columns


def test_a_truth_aligned_with_an_uncertain_pose_is_refused(drive):
    """As where a run goes on in a loaded map: the error of its first pose would be that of all others."""
    truth = drive(100)
    grown = np.outer(np.sqrt(np.arange(1, 101)), [0.1, 0.1, 0.1, 0.001])
    assert len(consistency.pose_nees(poses_with(grown, truth), truth, truth)) == 99
    complaint = r"the pose at 0\.000000 s, with which the truth is aligned, has a sigma of 1 m and 0\.03 rad in the map.*right is"
    with pytest.raises(InputError, match=complaint):
        consistency.pose_nees(poses_with(grown + [0.9, 0.9, 0.0, 0.029], truth), truth, truth)
    late = truth.select(range(60, 100))
    with pytest.raises(InputError, match=r"the pose at 6\.000000 s, .*a sigma of 0\.781 m and 0\.00781 rad"):
        consistency.pose_nees(poses_with(grown, truth), truth, late)


def test_a_yaw_in_doubt_counts_by_its_lever(drive):
    truth = drive(1000)
    sigmas = np.tile([0.1, 0.1, 0.1, 0.1], (1000, 1))
    sigmas[0] = [1e-3, 1e-3, 1e-3, 0.02]
    with pytest.raises(InputError, match=r"a sigma of 0\.001 m and 0\.02 rad"):
        consistency.pose_nees(poses_with(sigmas, truth), truth, truth)


def test_a_column_that_is_missing_is_named(fails, tmp_path, drive):
    truth = drive(50)
    write_tum(tmp_path / "truth.tum", truth)
    run = write_run(tmp_path / "run", truth)
    text = (run / "pose_covariance.csv").read_text()
    (run / "pose_covariance.csv").write_text(text.replace(",xx,", ",cov,"))
    told = fails("evaluate_nees", run, "--truth", tmp_path / "truth.tum")
    assert f"{run / 'pose_covariance.csv'}: no column xx; needed are stamp, x, y, z, yaw, xx" in told
