"""Times of a phone's recording whose unit is doubtful."""

import pytest

from ratslam_tools.cli import trajectory_convert
from ratslam_tools.datasets import recorder

SECONDS = (1600000000, 1600000001, 1600000002)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "images").mkdir()
    for second in SECONDS:
        (tmp_path / "images" / f"{second}000.jpeg").write_bytes(b"")
    (tmp_path / "data_image.txt").write_text("".join(f"{second}000,images/{second}000.jpeg\n" for second in SECONDS))
    (tmp_path / "data_gps.txt").write_text("".join(f"{second}000,49.0{second % 10},8.4,110,1,2,3,gps\n" for second in SECONDS))
    (tmp_path / "data_imu.txt").write_text("".join(f"{second}000,0,9.8,0,0,0,0\n" for second in SECONDS))
    return tmp_path


def doubts(recording):
    return {reason: count for reason, count in recording.dropped.items() if "10 digits" in reason}


@pytest.mark.parametrize("name", ["data_image.txt", "data_gps.txt", "data_imu.txt"])
def test_times_that_may_be_seconds_are_named(folder, name):
    assert not doubts(recorder.read(str(folder)))
    text = (folder / name).read_text()
    for second in SECONDS:
        text = text.replace(f"{second}000,", f"{second},")
    (folder / name).write_text(text)
    found = recorder.read(str(folder))
    assert doubts(found) == {f"{name}: time of 10 digits, taken as milliseconds (of 1970); is it in seconds?": 3}


def test_names_that_may_be_seconds_are_named(folder):
    (folder / "data_image.txt").unlink()
    for second in SECONDS:
        (folder / "images" / f"{second}000.jpeg").rename(folder / "images" / f"{second}.jpeg")
    found = recorder.read(str(folder))
    assert doubts(found) == {"images/: time of 10 digits, taken as milliseconds (of 1970); is it in seconds?": 3}


def test_a_log_converted_alone_names_them_as_well(folder, capsys):
    (folder / "data_gps.txt").write_text((folder / "data_gps.txt").read_text().replace("000,49", ",49"))
    trajectory_convert.main([str(folder / "data_gps.txt"), str(folder / "gps.tum"), "--from", "gps"])
    assert "data_gps.txt: time of 10 digits, taken as milliseconds (of 1970); is it in seconds?: 3" in "".join(capsys.readouterr())


@pytest.mark.parametrize(
    "digits, times, expected",
    [
        ("", [0, 0, 0, 5], [0, 333333, 666666, 5000000]),
        ("000", [0, 0, 100, 200, 200, 5000], [0, 50000, 100000, 200000, 700000, 5000000]),
        ("000000", [7, 7, 9, 9], [7, 8, 9, 500009]),
    ],
)
def test_samples_of_one_time_stay_before_the_next(folder, digits, times, expected):
    """Whether the times are in milliseconds, microseconds or nanoseconds."""
    first = int("1600000000000" + digits)
    (folder / "data_imu.txt").write_text("".join(f"{first + time},{row},9.8,0,0,0,0\n" for row, time in enumerate(times)))
    found = recorder.read(str(folder))
    assert [stamp - 1600000000 * 10**9 for stamp in found.imu_stamps] == expected
    assert found.imu[:, 0].tolist() == list(range(len(times)))
