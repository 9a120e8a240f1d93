"""Files as people's editors, phones and disks leave them: read where their meaning is clear, refused in one line
where it is not.
"""

import os

import numpy as np
import pytest

from ratslam_tools import plotting, text_file
from ratslam_tools.cli import ini_to_yaml
from ratslam_tools.datasets import calibration, flat_yaml, images, kitti, odometry_file, recorder
from ratslam_tools.datasets.clock import clock_set_back
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import association, read_times, read_trajectory, write_tum

MARK = b"\xef\xbb\xbf"
TUM = b"0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 1 0 0 0 0 1\n"
CALIBRATION = b"image_width: 64\nimage_height: 48\nfx: 50\nfy: 51\ncx: 31\ncy: 23\nk1: -0.2\n"
ROS_CALIBRATION = b"""image_width: 64
image_height: 48
camera_name: phone
camera_matrix: {rows: 3, cols: 3, data: [50, 0, 31, 0, 51, 23, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.2, 0, 0, 0, 0]
projection_matrix: {rows: 3, cols: 4, data: [50, 0, 31, 0, 0, 51, 23, 0, 0, 0, 1, 0]}
"""
ODOMETRY = b"frame,stamp,linear_x,angular_z\n0,0.0,0,0\n1,0.1,1.5,0.01\n"


@pytest.fixture(name="file")
def file_with(tmp_path):
    def make(content, name="file.txt"):
        path = tmp_path / name
        path.write_bytes(content)
        return str(path)

    return make


READERS = {
    "trajectory": (lambda path: read_trajectory(path).positions, TUM),
    "times": (read_times, b"0\n0.1\n0.2\n"),
    "calibration": (lambda path: calibration.read(path).matrix, CALIBRATION),
    "KITTI calibration": (lambda path: kitti.read_calibration(path)["P0"], b"P0: 1 2 3\nP1: 4 5 6\n"),
    "odometry": (odometry_file.read_odometry, ODOMETRY),
    "ini": (lambda path: ini_to_yaml.convert(path)[0], b"[ratslam]\nexp_loops = 20\n"),
    "YAML": (flat_yaml.read, b"a: 1\nb: yes\n"),
    "timestamps": (kitti.read_timestamps, b"2011-09-26 13:02:25.964389445\n2011-09-26 13:02:26.1\n"),
    "GPS": (lambda path: recorder.read_gps_log(path).gps, b"1600000000000,49.5,8.4,110,1,2,3,gps\n"),
}


@pytest.mark.parametrize("name", READERS)
def test_marks_ends_of_lines_and_foreign_bytes_change_nothing(name, file):
    read, content = READERS[name]
    expected = read(file(content))
    changed = [MARK + content, content.replace(b"\n", b"\r\n"), content.replace(b"\n", b"\r"), content + b"\n \n"]
    if name not in ("ini", "GPS", "times", "timestamps", "odometry"):
        changed.append(content + b"# M\xfcller\n")
    for text in changed:
        np.testing.assert_equal(read(file(text)), expected)


@pytest.mark.parametrize("name", READERS)
def test_what_is_no_text_is_refused_in_one_line(name, file, tmp_path):
    read, content = READERS[name]
    pipe = str(tmp_path / "pipe")
    os.mkfifo(pipe)
    for path, words in (
        (file(content.decode().encode("utf-16"), "wide.txt"), "UTF-16"),
        (file(b"\0\1" + content, "binary.txt"), "not a text file"),
        (pipe, "pipe"),
        (str(tmp_path / "nowhere"), "No such file"),
    ):
        with pytest.raises(InputError, match=words):
            read(path)


@pytest.mark.parametrize("content", [b"0,1 0 0 0 0 0 0 1\n", b"0,0 0,5 0,1 0,2 0,0 0,0 0,0 1,0\n"])
def test_decimal_commas_are_named(content, file):
    with pytest.raises(InputError, match="commas.*points"):
        read_trajectory(file(content))
    with pytest.raises(InputError, match="commas"):
        read_times(file(b"0,1\n0,2\n"))
    with pytest.raises(InputError, match=":2: .*commas"):
        odometry_file.read_odometry(file(b"frame,stamp,linear_x,angular_z\n0,0,1,1,5,0,1\n"))


@pytest.mark.parametrize("reference_bends, refused", [(False, False), (True, True)])
def test_alignment_by_poses_on_a_line(drive, turn, reference_bends, refused):
    """The rotation about the line is not determined: it matters as soon as anything beside the line is compared."""
    truth = drive(120)
    straight = 120 if not reference_bends else 60
    truth.positions[:straight] = np.outer(np.linspace(0.0, 50.0, straight), [1.0, 2.0, 0.5])
    moved = truth.transformed(turn, [3.0, -2.0, 1.0])
    count = 60 if reference_bends else None
    with pytest.raises(InputError, match="lie on one line"):
        association.fit_alignment(truth, moved, True, True, count, positions_only=False)
    if refused:
        with pytest.raises(InputError, match="lie on one line"):
            association.fit_alignment(truth, moved, True, True, count)
    else:
        fitted = association.fit_alignment(truth, moved, True, True, count).apply(moved)
        np.testing.assert_allclose(fitted.positions, truth.positions, atol=1e-9)
    assert association.fit_alignment(truth, moved, False, True, count).scale == pytest.approx(1.0)


def test_images_are_taken_in_the_order_of_their_numbers(tmp_path):
    for name in ["10.png", "9.PNG", "1.Jpg", "._1.jpg", "08.png", "notes.txt"]:
        (tmp_path / name).write_bytes(b"")
    (tmp_path / "folder.png").mkdir()
    found = [os.path.basename(path) for path in images.list_images(str(tmp_path))]
    assert found == ["1.Jpg", "08.png", "9.PNG", "10.png"]


@pytest.mark.parametrize(
    "names, count, rows",
    [
        (["a", "b"], 2, [0, 1]),
        (["000000", "000001", "000003"], 4, [0, 1, 3]),
        (["000000", "000001"], 9, [0, 1]),
        (["1", "3"], 3, [0, 2]),
        (["frame107", "frame109"], 3, [0, 2]),
        (["a", "b"], 3, None),
        (["5", "900"], 7, None),
        (["0", "1"], 1, None),
    ],
)
def test_each_image_gets_the_time_that_its_number_says(names, count, rows):
    paths = [f"/images/{name}.png" for name in names]
    if rows is None:
        with pytest.raises(InputError, match=f"times.txt: {count} times for {len(names)} images"):
            images.times_of(paths, count, "times.txt")
    else:
        assert images.times_of(paths, count, "times.txt") == rows


@pytest.mark.parametrize(
    "content, words",
    [
        (b"0\n1\n1e300\n", "time 3 .* outside 0 to 2\\^32"),
        (b"-1\n0\n1\n", "time 1 .* outside"),
        (b"0\nnan\n1\n", "times.txt:2: a NaN or infinite value: 'nan'"),
        (b"1_0\n2\n3\n", ":1: not a number"),
        (b"# time\n0\n1\n2\n", ":1: '# time' is not a time in seconds"),
        (b"0\n1 # a\n2\n", ":2: '1 # a' is not a time in seconds"),
    ],
)
def test_times_that_no_recording_has(tmp_path, content, words):
    (tmp_path / "image_0").mkdir()
    for index in range(3):
        (tmp_path / "image_0" / f"{index}.png").write_bytes(b"")
    (tmp_path / "times.txt").write_bytes(content)
    with pytest.raises(InputError, match=words):
        kitti.read_sequence(str(tmp_path))


@pytest.mark.parametrize("form", ["# of ours\nP0: {}\n", "P1: 9 9\nP0: {}\n", "calib_time: 9-Jan\nP_rect_00: {}\n"])
def test_forms_of_the_calibration(tmp_path, form):
    (tmp_path / "image_0").mkdir()
    (tmp_path / "image_0" / "0.png").write_bytes(b"")
    (tmp_path / "times.txt").write_text("0\n")
    (tmp_path / "calib.txt").write_text(form.format("50 0 31 0 0 51 23 0 0 0 1 0"))
    assert kitti.read_sequence(str(tmp_path)).projection[1, 1] == 51
    with pytest.raises(InputError, match="image_2.*--camera 0"):
        kitti.read_sequence(str(tmp_path), 2)


def test_calibrations_that_contradict_themselves(file):
    line = b"P0: 50 0 31 0 0 51 23 0 0 0 1 0\n"
    assert list(kitti.read_calibration(file(line + line))) == ["P0"]
    with pytest.raises(InputError, match="'P0:' is given twice"):
        kitti.read_calibration(file(line + line.replace(b"50", b"60")))


def test_calibration_of_ros_is_read(file):
    for content in (ROS_CALIBRATION, b"%YAML:1.0\n---\n" + ROS_CALIBRATION.replace(b"matrix: {", b"matrix: !!opencv-matrix {")):
        found = calibration.read(file(content))
        expected = calibration.read(file(CALIBRATION))
        np.testing.assert_array_equal(found.matrix, expected.matrix)
        assert found.distortion == expected.distortion and (found.width, found.height) == (64, 48)
    fisheye = calibration.read(file(ROS_CALIBRATION.replace(b"plumb_bob", b"equidistant")))
    assert fisheye.model == "equidistant" and fisheye.distortion == (-0.2, 0, 0, 0)


@pytest.mark.parametrize(
    "change, words",
    [
        ((b"plumb_bob", b"mirror"), "distortion_model: 'mirror' is none of"),
        ((b"[50, 0,", b"[50,"), "camera_matrix: 8 numbers"),
        ((b"[50,", b"[wide,"), "'wide' is not a finite number"),
        ((b"[50,", b"[0,"), "fx: 0 is not allowed"),
        ((b"image_width: 64", b"image_width: 1e9"), "image_width: 1e\\+09 is not allowed"),
        ((b"[-0.2, 0, 0, 0, 0]", b"[0, 0, 0, 0, 0, 0.1]"), "plumb_bob has 5, here are 6"),
        ((b"image_width: 64\n", b""), "no image_width"),
        ((b"camera_name", b"image_width"), "image_width is given twice"),
        ((b"rows: 3", b"rows: [3"), "file.txt:[0-9]+: "),
    ],
)
def test_calibrations_that_are_none(change, words, file):
    with pytest.raises(InputError, match=words):
        calibration.read(file(ROS_CALIBRATION.replace(*change)))


def test_odometry_of_runs_and_of_others_is_read(file):
    poses = "," + ",".join(["r11", "r12", "r13", "x", "r21", "r22", "r23", "y", "r31", "r32", "r33", "z"])
    values = ",1,0,0,7,0,1,0,8,0,0,1,9"
    lines = ODOMETRY.decode().splitlines()
    with_poses = "\n".join([lines[0] + poses, *(line + values for line in lines[1:])])
    expected = odometry_file.read_odometry(file(ODOMETRY))
    np.testing.assert_array_equal(odometry_file.read_odometry(file(with_poses.encode())), expected)
    turned_round = b" angular_z , stamp,linear_x\n0, 0.0,0\n0.01,0.1,1.5\n"
    np.testing.assert_array_equal(odometry_file.read_odometry(file(turned_round)), expected)


POSED = b"stamp,linear_x,angular_z,r11,r12,r13,x,r21,r22,r23,y,r31,r32,r33,z\n"


@pytest.mark.parametrize(
    "content, words",
    [
        (b"", "names no column stamp"),
        (b"frame;stamp;linear_x;angular_z\n", "parted by commas"),
        (b"stamp,linear_x,angular_z,stamp\n0,0,0,0\n", "names column stamp twice"),
        (b"frame\tstamp\tlinear_x\tangular_z\n", "parted by commas"),
        (ODOMETRY + b"2,9999999999,1,0\n", ":4: stamp 1e\\+10 lies outside"),
        (ODOMETRY + b"2,0.1,1,0\n", ":4: stamps must rise"),
        (ODOMETRY + b"2,0.2,fast,0\n", ":4: linear_x: 'fast'"),
        (ODOMETRY + b"2,0.2,nan,0\n", ":4: linear_x: 'nan'"),
        (ODOMETRY + b"2,0.2,1e9,0\n", ":4: the speed 1e\\+09 m/s is out of range: at most 1e\\+06"),
        (ODOMETRY + b"2,0.2,1,-2e6\n", ":4: the yaw rate -2e\\+06 rad/s is out of range"),
        (POSED + b"0,1,0,1,0,0,0,0,1,0,0,0,0,-1,0\n", ":2: r11 to r33 are no rotation matrix"),
        (POSED + b"0,1,0,1,0,0,2e12,0,1,0,0,0,0,1,0\n", ":2: the position 2e\\+12 m is out of range"),
        (POSED.replace(b",y,", b",north,"), "names no column y"),
        (ODOMETRY[:31], "holds no odometry"),
    ],
)
def test_odometry_that_is_none(content, words, file):
    with pytest.raises(InputError, match=words):
        odometry_file.read_odometry(file(content))


FIXES = {
    "without bearing and speed": "1600000000000,49.03,8.39,111.3,1.5,,,gps",
    "with null": "1600000000000,49.03,8.39,111.3,1.5,null,null,gps",
    "of the shortest form": "1600000000000,49.03,8.39,111.3,1.5",
    "without altitude": "1600000000000,49.03,8.39,,1.5,90,5,gps",
    "in microseconds": "1600000000000000,49.03,8.39,111.3,1.5,90,5,gps",
    "with blanks": " 1600000000000 , 49.03 , 8.39 , 111.3, 1.5 ,90,5,gps",
}


@pytest.mark.parametrize("name", FIXES)
def test_a_fix_with_a_position_is_kept(name, file):
    second = FIXES[name].replace("16000000000", "16000000010").replace("8.39", "8.3901")
    found = recorder.read_gps_log(file(f"{FIXES[name]}\n{second}\n".encode()))
    assert found.gps_stamps == [1600000000 * 10**9, 1600000001 * 10**9]
    track = recorder.gps_track(found, recorder.good_fixes(found, 20.0))
    assert len(track) == 2 and track.positions[1, 0] == pytest.approx(7.3, abs=0.1)


def test_decimal_commas_of_a_phone_are_named(tmp_path):
    (tmp_path / "data_gps.txt").write_text("1600000000000,49,033595102,8,394906472,111,345,1,51,0,00,11,234,gps\n")
    with pytest.raises(InputError, match="data_gps.txt:1: 14 columns.*commas"):
        recorder.read_gps_log(str(tmp_path))
    (tmp_path / "data_gps.txt").unlink()
    (tmp_path / "data_imu.txt").write_text("1600000000000,0,000000,-9,806650,-1,213269,0,0,0,0,0,0\n")
    (tmp_path / "data_image.txt").write_text("1600000000000,1.jpeg\n")
    (tmp_path / "1.jpeg").write_bytes(b"")
    with pytest.raises(InputError, match="data_imu.txt:1: 13 columns.*commas"):
        recorder.read(str(tmp_path))


def recording(folder, stamps, ending=".jpeg"):
    (folder / "images").mkdir(parents=True, exist_ok=True)
    for stamp in stamps:
        (folder / "images" / f"{stamp}{ending}").write_bytes(b"")
    lines = [f"{stamp},images/{stamp}{ending}\n" for stamp in stamps]
    (folder / "data_image.txt").write_text("".join(lines))


def test_a_clock_that_was_set_back_is_named(tmp_path):
    stamps = [1600000000000 + 100 * index for index in range(25)]
    recording(tmp_path, stamps + [stamp + 1350 for stamp in stamps[:15]])
    with pytest.raises(InputError, match="set back by 1.050 s before the image of 1600000001350 ms"):
        recorder.read(str(tmp_path))


@pytest.mark.parametrize(
    "order",
    [
        [0, 1, 3, 2, 4, 5, 6, 7],  # two lines changed places
        [0, 3, 1, 2, 4, 5, 6, 7],
        [7, 2, 5, 1, 6, 0, 4, 3],  # no order at all
        [0, 1, 2, 3, 4, 5, 6, 7],
    ],
)
def test_lines_that_are_out_of_order_are_sorted(tmp_path, order):
    assert clock_set_back([(100 * index, str(index)) for index in order]) is None
    recording(tmp_path, [1600000000000 + 100 * index for index in order])
    found = recorder.read(str(tmp_path))
    assert np.all(np.diff(found.image_stamps) > 0) and len(found.images) == 8
    assert found.dropped["images out of order (sorted)"] == (order != sorted(order))


def test_an_index_of_malformed_lines_alone_is_not_called_empty(tmp_path):
    (tmp_path / "images").mkdir()
    (tmp_path / "data_image.txt").write_text("1600000000000;images/1.jpeg\n1600000000100;images/2.jpeg\n")
    with pytest.raises(InputError, match=r"no images listed in data_image.txt \(malformed image line: 2\)"):
        recorder.read(str(tmp_path))


def test_names_of_a_recording_that_lead_elsewhere_are_refused(tmp_path):
    recording(tmp_path, [1600000000000])
    for name in ("../other.jpeg", "/etc/passwd", "images/../../x.jpeg"):
        (tmp_path / "data_image.txt").write_text(f"1600000000000,{name}\n")
        with pytest.raises(InputError, match="does not lie within"):
            recorder.read(str(tmp_path))


def test_older_recordings_may_be_named_by_microseconds_in_capitals(tmp_path):
    recording(tmp_path, [1600000000000123, 1600000000100123], ".JPG")
    (tmp_path / "data_image.txt").unlink()
    (tmp_path / "images" / "._1600000000000123.JPG").write_bytes(b"")
    assert recorder.read(str(tmp_path)).image_stamps == [1600000000000123000, 1600000000100123000]


@pytest.mark.parametrize("digits", ["", "x", "-1", "\u00b2", "9" * 20, "9999999999999999999", "99999999999999"])
def test_numbers_that_are_no_time(digits):
    assert recorder.stamp_of(digits) is None


def test_files_are_written_whole_or_not_at_all(tmp_path, drive):
    path = tmp_path / "kept.txt"
    path.write_text("before")
    with pytest.raises(ZeroDivisionError):
        with text_file.writing(str(path)) as file:
            file.write("half")
            raise ZeroDivisionError
    assert path.read_text() == "before" and os.listdir(tmp_path) == ["kept.txt"]
    with pytest.raises(InputError, match="nowhere/o.tum: cannot be written"):
        write_tum(str(tmp_path / "nowhere" / "o.tum"), drive(3))
    with pytest.raises(InputError, match="/dev/full: cannot be written: No space left"):
        write_tum("/dev/full", drive(3))


def test_files_of_gigabytes_are_not_read_whole(tmp_path):
    path = tmp_path / "hole.txt"
    path.write_text("1 2 3\n")
    os.truncate(str(path), 1 << 36)
    with pytest.raises(InputError, match="not a text file"):
        text_file.read_text(str(path))


def test_names_in_figures_are_no_formulas(drive, tmp_path):
    pyplot = plotting.load()
    figure, axes = pyplot.subplots()
    axes.set_title(plotting.literal("a$b^{$_run"))
    axes.plot([0, 1], [0, 1], label=plotting.literal("_hidden$"))
    axes.legend()
    plotting.finish(pyplot, figure, str(tmp_path / "f.png"))
    assert os.path.getsize(tmp_path / "f.png") > 0


def test_truth_of_a_drive_with_a_late_image_is_taken_in_the_order_of_time(tmp_path, capsys):
    row = "1 0 0 {} 0 1 0 0 0 0 1 0\n"
    (tmp_path / "poses.txt").write_text("".join(row.format(x) for x in (0, 2, 1, 3)))
    (tmp_path / "times.txt").write_text("0\n0.2\n0.1\n0.3\n")
    truth = read_trajectory(str(tmp_path / "poses.txt"), times=str(tmp_path / "times.txt"))
    assert truth.positions[:, 0].tolist() == [0, 1, 2, 3]
    assert "1 times lie before the one before" in capsys.readouterr().err
