"""Geodesy, OpenRatSLAM configurations and donkey-car tubs."""

import json
import subprocess

import numpy as np
import pytest

from conftest import built, png
from ratslam_tools.cli import donkey_to_kitti, ini_to_yaml
from ratslam_tools.datasets import flat_yaml, kitti, odometry_file
from ratslam_tools.trajectory import geodesy
from ratslam_tools.errors import InputError
from ratslam_tools.runs import runner

STLUCIA = """[general]
topic_root=stlucia

[draw]
enable=1

[ratslam]
image_crop_x_min = 40
vt_match_threshold = 0.085
vt_patch_normalisation=0
pc_cell_x_size = 2.0   # metres
exp_loops=20

[visual_odometry]
vtrans_image_x_min = 195
camera_fov_deg = 53
"""


def test_earth_centred_coordinates_of_known_points():
    np.testing.assert_allclose(geodesy.ecef(0.0, 0.0, 0.0), [6378137.0, 0, 0], atol=1e-6)
    np.testing.assert_allclose(geodesy.ecef(90.0, 0.0, 10.0), [0, 0, 6356752.314245 + 10], atol=1e-5)
    np.testing.assert_allclose(geodesy.ecef(0.0, 90.0, -5.0), [0, 6378132.0, 0], atol=1e-6)


@pytest.mark.parametrize(
    "latitude, metres_north, metres_east",
    [(0.0, 110574.3, 111319.5), (45.0, 111131.8, 78846.8), (60.0, 111412.2, 55800.0)],
)
def test_lengths_of_a_degree(latitude, metres_north, metres_east):
    """Lengths of a degree on WGS-84 as tabulated by the National Geospatial-Intelligence Agency."""
    step = 1e-3
    north = geodesy.local_enu([latitude + step / 2], [82.9], [0.0], (latitude - step / 2, 82.9, 0.0))[0]
    east = geodesy.local_enu([latitude], [82.9 + step], [0.0], (latitude, 82.9, 0.0))[0]
    assert north[1] / step == pytest.approx(metres_north, rel=2e-6) and abs(north[0]) < 1e-6
    assert east[0] / step == pytest.approx(metres_east, rel=2e-5) and abs(east[2]) < 1e-2
    up = geodesy.local_enu([latitude], [82.9], [7.0], (latitude, 82.9, 0.0))[0]
    np.testing.assert_allclose(up, [0, 0, 7], atol=1e-6)


def test_mercator_agrees_with_the_ellipsoid_near_its_latitude():
    x, y = geodesy.mercator(np.array([49.0, 49.001]), np.array([8.4, 8.402]), 49.0)
    enu = geodesy.local_enu([49.001], [8.402], [0.0], (49.0, 8.4, 0.0))[0]
    np.testing.assert_allclose([x[1] - x[0], y[1] - y[0]], enu[:2], rtol=4e-3)


def test_openratslam_configuration(tmp_path, run):
    (tmp_path / "config.txt").write_text(STLUCIA)
    result = run("ini_to_yaml", tmp_path / "config.txt", tmp_path / "out.yaml")
    assert result.returncode == 0 and "[draw] is left out" in result.stderr
    assert flat_yaml.read(str(tmp_path / "out.yaml")) == {
        "topic_root": "stlucia",
        "image_crop_x_min": "40",
        "vt_match_threshold": "0.085",
        "vt_patch_normalise": "0",
        "pc_cell_x_size": "2.0",
        "exp_loops": "20",
        "vtrans_image_x_min": "195",
        "camera_fov_deg": "53",
        "exp_solver": "relaxation",
        "pc_openratslam_injection": "true",
    }
    assert "its arithmetic: exp_solver: relaxation, pc_openratslam_injection: true" in result.stderr


def test_blanks_around_the_name_of_a_section_change_nothing(tmp_path):
    (tmp_path / "config.txt").write_text(STLUCIA)
    expected = ini_to_yaml.convert(str(tmp_path / "config.txt"))
    (tmp_path / "config.txt").write_text(STLUCIA.replace("[ratslam]", "  [ ratslam\t]"))
    assert ini_to_yaml.convert(str(tmp_path / "config.txt")) == expected


def test_keys_of_our_own_in_an_openratslam_configuration(tmp_path, run):
    (tmp_path / "config.txt").write_text(STLUCIA.replace("exp_loops=20", "exp_loops=20\nexp_solver=graph"))
    result = run("ini_to_yaml", tmp_path / "config.txt", tmp_path / "out.yaml", "--strict")
    assert result.returncode == 0 and "exp_solver" not in result.stderr
    assert flat_yaml.read(str(tmp_path / "out.yaml"))["exp_solver"] == "graph"


@pytest.mark.parametrize(
    "change, words",
    [
        (("exp_loops=20", "exp_loops=many"), "not a number"),
        (("vt_patch_normalisation", "vt_patch_normalise=1\nvt_patch_normalisation"), "given twice"),
        (("[visual_odometry]", "[ratslam]"), "config.txt:14: section \\[ratslam\\] is given twice"),
        ((STLUCIA, "[other]\na=1\n"), "none of the sections"),
        ((STLUCIA, "just text\n"), "config.txt:1: not a line of an ini file, which is key=value or .section.: 'just text'"),
        (("exp_loops=20", "exp_loops=20\nexp_loops=30"), "config.txt:13: exp_loops is given twice"),
        (("camera_fov_deg = 53\n", "camera_fo"), "config.txt:16: not a line of an ini file.*: 'camera_fo'"),
        (("[visual_odometry]", "[visual_odo"), "config.txt:14: not a line of an ini file: '.visual_odo' lacks its ]"),
        (("exp_loops=20", "exp_loops: 20"), "config.txt:12: not a line of an ini file"),
        (("[general]\n", ""), "config.txt:1: 'topic_root=stlucia' stands before any section"),
    ],
)
def test_configurations_that_are_none(tmp_path, change, words):
    (tmp_path / "config.txt").write_text(STLUCIA.replace(*change))
    with pytest.raises(InputError, match=words):
        ini_to_yaml.convert(str(tmp_path / "config.txt"))


@pytest.mark.parametrize(
    "text, value", [("true", "true"), ("Yes", "true"), ("1", "true"), ("OFF", "false"), ("0", "false"), ("2", None), ("tRue", None)]
)
def test_truth_values_are_those_of_a_run(tmp_path, text, value):
    (tmp_path / "config.txt").write_text(f"[ratslam]\nvt_panoramic={text}\n")
    if value is None:
        with pytest.raises(InputError, match=f"vt_panoramic: '{text}' is not true or false"):
            ini_to_yaml.convert(str(tmp_path / "config.txt"))
    else:
        assert f"vt_panoramic: {value}\n" in ini_to_yaml.convert(str(tmp_path / "config.txt"))[0]


WHOLE = "[ratslam]\ntemplate_x_size=60\ntemplate_y_size=10\n"


@pytest.mark.parametrize(
    "line, reason",
    [
        ("pc_dim_xy=5000", "pc_dim_xy: value 5000 is not allowed: it must lie within [1, 4096]"),
        ("exp_loops=20.5", "exp_loops: value '20.5' is not a whole number"),
        ("vt_shift_match=40", "vt_shift_match: value 40 is not allowed: twice the shift must be less than"),
    ],
)
def test_what_a_run_refuses_is_not_converted(tmp_path, fails, line, reason):
    built()
    (tmp_path / "config.txt").write_text(WHOLE + line + "\n")
    message = fails("ini_to_yaml", tmp_path / "config.txt", tmp_path / "out.yaml")
    assert message.startswith(f"error: {tmp_path / 'config.txt'}: {reason}") and "config.yaml" not in message
    assert not (tmp_path / "out.yaml").exists()


def test_what_a_run_takes_is_converted_and_taken(tmp_path, run):
    (program,) = built()
    own = "vt_panoramic=Yes\npc_dim_xy=0030\nexp_loops=2e1\nvt_patch_normalisation=1\npc_openratslam_corner=no\n"
    (tmp_path / "config.txt").write_text("[general]\ntopic_root=007\n" + WHOLE + own)
    result = run("ini_to_yaml", tmp_path / "config.txt", tmp_path / "out.yaml", "--strict")
    assert result.returncode == 0 and result.stderr.count("note:") == 1, result.stderr
    for name in ("config.txt", "out.yaml"):
        words = [program, tmp_path / "nothing", "--config", tmp_path / name, "--out", tmp_path / "run"]
        taken = subprocess.run(words, stderr=subprocess.PIPE, stdout=subprocess.PIPE, universal_newlines=True, check=False)
        assert "nothing: cannot open" in taken.stderr, taken.stderr


def test_what_a_part_of_a_configuration_lacks_is_told(tmp_path, run):
    built()
    (tmp_path / "config.txt").write_text(STLUCIA)
    result = run("ini_to_yaml", tmp_path / "config.txt", "--strict")
    assert result.returncode == 0 and "note: ratslam_run refuses it without more: vt_shift_match: value 25" in result.stderr


def test_values_that_no_run_has_judged_are_told(tmp_path, capsys, monkeypatch):
    def absent(given=None):
        raise InputError("ratslam_run was not found")

    monkeypatch.setattr(runner, "find", absent)
    (tmp_path / "config.txt").write_text(WHOLE + "pc_dim_xy=5000\n")
    ini_to_yaml.main([str(tmp_path / "config.txt")])
    out, messages = capsys.readouterr()
    assert "pc_dim_xy: 5000" in out and "note: no ratslam_run was found, so the values' ranges are not checked" in messages


def test_numbers_with_leading_zeros_are_not_taken_for_octal(tmp_path):
    (tmp_path / "config.txt").write_text(STLUCIA.replace("exp_loops=20", "exp_loops=020").replace("= 40", "= -007"))
    text, _ = ini_to_yaml.convert(str(tmp_path / "config.txt"))
    assert "exp_loops: 20\n" in text and "image_crop_x_min: -7\n" in text and "vt_match_threshold: 0.085\n" in text


def test_unknown_keys_are_reported(tmp_path, run, fails):
    (tmp_path / "config.txt").write_text(STLUCIA.replace("exp_loops", "exp_lops"))
    result = run("ini_to_yaml", tmp_path / "config.txt")
    assert (
        result.returncode == 0 and "exp_lops is unknown" in result.stderr and "exp_lops" not in result.stdout
    )
    assert "exp_lops" in fails("ini_to_yaml", tmp_path / "config.txt", "--strict")


def tub(path, angle, throttle, count=100):
    (path / "images").mkdir(parents=True)
    records = []
    for index in range(count):
        name = f"{index}_cam_image_array_.jpg"
        (path / "images" / name).write_bytes(png(160, 120))
        records.append(
            json.dumps(
                {
                    "_index": index,
                    "_timestamp_ms": 1669759744666 + 50 * index,
                    "cam/image_array": name,
                    "user/angle": angle,
                    "user/throttle": throttle,
                }
            )
        )
    (path / "catalog_0.catalog").write_text("\n".join(records[:60]) + "\n")
    (path / "catalog_1.catalog").write_text("\n".join(records[60:]) + "\n")


def test_a_steady_command_drives_a_circle(tmp_path):
    tub(tmp_path / "tub", angle=-1.0, throttle=0.5)
    out = tmp_path / "out"
    donkey_to_kitti.main(
        [
            str(tmp_path / "tub"),
            str(out),
            "--run",
            "10:89",
            "--wheelbase",
            "0.3",
            "--max_steering_deg",
            "20",
            "--steering_trim",
            "0",
            "--speed_per_throttle",
            "4",
        ]
    )
    drive = kitti.read_sequence(str(out))
    assert len(drive.images) == 80 and drive.stamps_ns[1] == 50000000
    rows = odometry_file.read_odometry(str(out / "odometry.csv"))
    np.testing.assert_array_equal(rows[0], 0)
    np.testing.assert_allclose(rows[1:, 2], 2.0)
    np.testing.assert_allclose(rows[1:, 3], 2.0 * np.tan(np.radians(20)) / 0.3)
    with pytest.raises(InputError, match="not empty"):
        donkey_to_kitti.main([str(tmp_path / "tub"), str(out)])


def test_commands_take_their_time():
    stamps = np.arange(0, 10, 0.05)
    step = (stamps >= 2).astype(float)
    response = donkey_to_kitti.first_order_lag(stamps, step, 0.5)
    assert response[stamps < 2].max() == 0
    assert np.interp(2.45, stamps, response) == pytest.approx(1 - np.exp(-1), abs=0.01)


@pytest.mark.parametrize("text", ["5", "9:3", "a:b", "-1:4"])
def test_runs_that_are_none(text):
    with pytest.raises(InputError, match="--run"):
        donkey_to_kitti.parse_run(text)


def test_truth_of_the_clip_is_read_in_base_axes(data):
    drive = kitti.read_sequence(data("kitti_00"))
    assert len(drive.truth) == 1700 and drive.stamps_ns[1] == 103735900
    assert drive.truth.path_length()[-1] == pytest.approx(1263, abs=1)
    assert np.ptp(drive.truth.positions[:, 2]) < 25 < np.ptp(drive.truth.positions[:, 0])
