"""Writing of bags: times that go back in a KITTI sequence, of which a bag holds one stretch; and full disks."""

import os
import resource

import numpy as np
import pytest

from test_bags import messages, sequence  # noqa: F401  (fixture)
from ratslam_tools.cli import kitti_to_bag
from ratslam_tools.errors import InputError


@pytest.mark.parametrize("times, frame", [("0 1 2 2 4 5", 3), ("300 301 302 2 3 4", 3), ("0 1 2 3 2.5 5", 4)])
def test_a_clock_that_was_set_back_parts_a_sequence_into_bags(sequence, tmp_path, times, frame):
    (sequence / "times.txt").write_text(times.replace(" ", "\n") + "\n")
    bag = tmp_path / "k.bag"
    with pytest.raises(InputError, match=rf"00000{frame}.png: its time .* --end {frame}, --start {frame}$"):
        kitti_to_bag.main([str(sequence), str(bag)])
    assert not bag.exists()
    for words, count in ((["--end", str(frame)], frame), (["--start", str(frame)], 6 - frame)):
        kitti_to_bag.main([str(sequence), str(bag), *words])
        stamps = [message.header.stamp.to_sec() for message, _ in messages(bag, "/kitti/camera/image")]
        assert len(stamps) == count and (np.diff(stamps) > 0).all()
        truth = [message.header.stamp.to_sec() for message, _ in messages(bag, "/kitti/ground_truth")]
        assert truth == stamps


def test_times_without_order_are_not_worth_parting(sequence, tmp_path):
    (sequence / "times.txt").write_text("0\n" * 6)
    with pytest.raises(InputError, match="000001.png: its time .* and the times of a bag rise$"):
        kitti_to_bag.main([str(sequence), str(tmp_path / "k.bag")])


@pytest.mark.parametrize("limit", [0, 3000, 20000])
def test_a_full_disk_is_said_of_the_bag_and_leaves_none(sequence, tmp_path, run, limit):
    out = tmp_path / "out"
    out.mkdir()
    done = run(
        *("kitti_to_bag", sequence, out / "k.bag"),
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
    )
    assert done.returncode == 1 and done.stderr.endswith(f"error: {out / 'k.bag'}: cannot be written: File too large\n")
    assert os.listdir(out) == []


def test_an_offset_of_no_odometry_is_refused(sequence, tmp_path):
    with pytest.raises(InputError, match="--odometry_offset: 0.5 has no effect: there is no --odometry"):
        kitti_to_bag.main([str(sequence), str(tmp_path / "k.bag"), "--odometry_offset", "0.5"])
