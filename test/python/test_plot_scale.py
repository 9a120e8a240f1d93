"""plot_scale: the scale along the way, and which runs it takes for a pair."""

import json
import shutil

import numpy as np
import pytest

from run_fixtures import folder  # noqa: F401  (fixture)
from ratslam_tools.cli import plot_scale
from ratslam_tools.errors import InputError


def test_local_scale_is_the_ratio_of_lengths_along_the_way():
    way = np.linspace(0.0, 200.0, 401)
    true = np.column_stack([way, 0 * way, 0 * way])
    stretched = true.copy()
    stretched[way > 100.0, 0] = 100.0 + 1.5 * (way[way > 100.0] - 100.0)
    middles, ratio = plot_scale.local_scale(true, stretched, window=20.0)
    np.testing.assert_allclose(ratio[middles < 90.0], 1.0)
    np.testing.assert_allclose(ratio[middles > 110.0], 1.5)
    with pytest.raises(InputError, match="60 m are needed"):
        plot_scale.local_scale(true[:100], stretched[:100])


@pytest.fixture
def pair(folder, tmp_path):
    """Folders of two runs that differ in exp_scale."""
    (folder / "trajectory_odometry.tum").write_bytes((folder / "trajectory_online.tum").read_bytes())
    folders = tmp_path / "without", tmp_path / "with"
    for path, scale in zip(folders, (False, True)):
        shutil.copytree(folder, path)
        state(path, exp_scale=scale)
    return folders


def state(path, **parameters):
    """Changes parameters in the summary of a run."""
    summary = json.loads((path / "summary.json").read_text())
    summary["parameters"].update(parameters)
    (path / "summary.json").write_text(json.dumps(summary))


def test_plot_scale_draws_two_runs_over_the_truth(pair, tmp_path, capsys):
    picture = tmp_path / "scale.png"
    state(pair[0], threads=1, exp_scale_sigma=1.0)
    plot_scale.main([*map(str, pair), "--truth", str(tmp_path / "truth.tum"), "--out", str(picture)])
    assert picture.read_bytes()[:4] == b"\x89PNG"
    assert "map with scale" in capsys.readouterr().out


def test_plot_scale_refuses_what_is_no_pair(pair, tmp_path):
    without, with_scale = map(str, pair)

    def complaint(*folders):
        with pytest.raises(InputError) as caught:
            plot_scale.main([*folders, "--truth", str(tmp_path / "truth.tum"), "--out", str(tmp_path / "no.png")])
        assert not (tmp_path / "no.png").exists()
        return str(caught.value)

    assert complaint(with_scale, without) == f"{with_scale}: its run has exp_scale=true; WITHOUT must be the one with false"
    assert complaint(without, without) == f"{without}: its run has exp_scale=false; WITH must be the one with true"
    state(pair[1], pc_dim_xy=40)
    assert f"{with_scale}: its run has pc_dim_xy=40, that of {without} 30" in complaint(without, with_scale)
    state(pair[1], pc_dim_xy=30)
    path = pair[1] / "trajectory_odometry.tum"
    whole = path.read_text()
    path.write_text((pair[1] / "trajectory_final.tum").read_text())
    assert f"{with_scale}: its trajectory_odometry.tum is not that of {without}" in complaint(without, with_scale)
    path.write_text("".join(whole.splitlines(True)[1:]))
    assert "trajectory_odometry.tum is not that of" in complaint(without, with_scale)
    (pair[1] / "summary.json").unlink()
    assert "summary.json: cannot be read" in complaint(without, with_scale)
    (pair[1] / "summary.json").write_text("{}")
    assert "it states no exp_scale" in complaint(without, with_scale)
    assert "no such folder" in complaint(without, str(tmp_path / "nowhere"))
