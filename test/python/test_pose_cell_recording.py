"""ratslam_run --pose-cells-every: activity all along a drive, as numpy reads it."""

import subprocess

import numpy as np
import pytest

from ratslam_tools.errors import InputError
from ratslam_tools.runs import run_folder, runner

cv2 = pytest.importorskip("cv2")


def test_activity_all_along(tmp_path):
    try:
        program = runner.find()
    except InputError:
        pytest.skip("ratslam_run is not built")
    drive = tmp_path / "drive"
    (drive / "image_0").mkdir(parents=True)
    texture = np.random.RandomState(5).randint(0, 256, (60, 600)).astype(np.uint8)
    for index in range(25):
        cv2.imwrite(str(drive / "image_0" / f"{index:06d}.png"), texture[:, 6 * index : 6 * index + 160])
    np.savetxt(drive / "times.txt", 0.1 * np.arange(25))
    settings = ("pc_dim_xy=11", "pc_dim_th=12", "template_x_size=20", "template_y_size=6", "vt_shift_match=2")
    words = [program, str(drive), "--out", str(tmp_path / "out"), "--pose-cells-every", "4"]
    words += [word for setting in settings for word in ("--set", setting)]
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    kept = run_folder.Run(str(tmp_path / "out")).pose_cells
    assert kept["stamps"].dtype == np.int64 and kept["activity"].dtype == np.float32
    assert kept["activity"].shape == (len(kept["stamps"]), 12, 11, 11) and len(kept["stamps"]) in (6, 7)
    np.testing.assert_allclose(kept["activity"].sum(axis=(1, 2, 3)), 1.0, atol=1e-5)
    assert (np.abs(np.diff(kept["stamps"]) - 400000000) < 10).all()
    (tmp_path / "out" / "pose_cells.npz").write_bytes(b"PK nothing of the kind")
    with pytest.raises(InputError, match="not arrays of numpy"):
        run_folder.Run(str(tmp_path / "out"))
