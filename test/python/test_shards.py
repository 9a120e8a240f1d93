"""A sweep divided among machines, and its results put together."""

import json
import os

import pytest

from run_fixtures import calls, folder, merging, program, sweep_words  # noqa: F401  (fixtures)
from ratslam_tools.cli import sweep
from ratslam_tools.errors import InputError


def test_shards_put_together_are_the_whole_sweep(program, tmp_path, capsys):
    vary = ("pc_vt_inject_energy=0.1:0.3:0.1", "other=1,2")
    whole = sweep_words(program, tmp_path, *vary)
    sweep.main(whole)
    expected = (tmp_path / "out" / "sweep.csv").read_text()
    told = capsys.readouterr().out
    parts = []
    for number in (1, 2, 3, 4):
        part = str(tmp_path / f"part{number}")
        parts.append(part)
        words = [part if word == str(tmp_path / "out") else word for word in whole]
        sweep.main(words + ["--shard", f"{number}/4"])
        assert not os.path.exists(os.path.join(part, "sweep.csv"))
    assert len(calls(program)) == 12
    capsys.readouterr()
    sweep.main(merging(tmp_path / "merged", parts, *vary))
    assert len(calls(program)) == 12
    assert (tmp_path / "merged" / "sweep.csv").read_text() == expected
    assert capsys.readouterr().out.splitlines()[0] == told.splitlines()[0]
    with pytest.raises(InputError, match="2 of 6 runs failed.*no shard has left it"):
        sweep.main(merging(tmp_path / "merged", [*parts[:1], *parts[2:]], *vary))
    part = json.loads(next((tmp_path / "part1").rglob("result.json")).read_text())
    next((tmp_path / "part1").rglob("result.json")).write_text(json.dumps({**part, "judged_by": "another truth"}))
    with pytest.raises(InputError, match="--merge: .*result.json and .*result.json were judged by different truths"):
        sweep.main(merging(tmp_path / "merged", parts, *vary))
    for bad in ("0/4", "5/4", "1", "a/b"):
        with pytest.raises(InputError, match="K/N"):
            sweep.main(whole + ["--shard", bad])


@pytest.fixture
def shards(program, tmp_path):
    """Makes the shards 1/2 and 2/2 of a sweep with further words for each of them; returns words that merge them."""

    def make(*more):
        for number in (1, 2):
            words = sweep_words(program, tmp_path, "pc_cell_x_size=1,2,3")
            words[words.index("--out") + 1] = str(tmp_path / f"part{number}")
            sweep.main([*words, "--shard", f"{number}/2", *more[number - 1]])
        return merging(tmp_path / "merged", [tmp_path / "part1", tmp_path / "part2"], "pc_cell_x_size=1,2,3")

    return make


def test_shards_with_an_odometry_of_their_own_are_put_together(shards, program, tmp_path):
    words = shards(["--odometry", "orb"], ["--odometry", "orb"])
    sweep.main(words)
    assert len((tmp_path / "merged" / "sweep.csv").read_text().splitlines()) == 4


@pytest.mark.parametrize(
    "first, second, told",
    [
        (["--max-frames", "5"], ["--max-frames", "6"], "'6' and '5'"),
        ([], ["--odometry", "topic"], "'--odometry' and '--set'"),
        ([], ["--", "--set", "vt_recall=belief"], "'--set' and nothing"),
        ([], ["--", "--set", "pc_dim_xy=9"], "'--set' and nothing"),
    ],
)
def test_results_of_other_commands_are_not_mixed(shards, first, second, told):
    words = shards(first, second)
    with pytest.raises(InputError, match=f"^--merge: .*part2.*result.json and .*part1.*result.json are results of .*: {told}"):
        sweep.main(words)


def test_results_of_other_recordings_are_not_mixed(shards, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "c.yaml").write_text("exp_loops: 5\n")
    words = shards([], [])
    sweep.main(words)
    path = next((tmp_path / "part2").rglob("result.json"))
    record = json.loads(path.read_text())
    record["inputs"]["c.yaml"] = "of another content"
    path.write_text(json.dumps(record))
    with pytest.raises(InputError, match="are results of different runs: 'c.yaml', whose content differs; merge those of one"):
        sweep.main(words)


@pytest.mark.parametrize(
    "more, told",
    [
        (["--config", "c.yaml"], "--config: c.yaml"),
        (["--truth", "t.tum"], "--truth: t.tum"),
        (["--t_max_diff", "1"], "--t_max_diff: 1"),
        (["--odometry", "orb"], "--odometry: orb"),
        (["--max-frames", "3"], "--max-frames: 3"),
        (["--jobs", "2"], "--jobs: 2"),
        (["--keep"], "--keep"),
        (["--", "--seed", "3"], "--: --seed 3"),
    ],
)
def test_what_has_no_effect_on_a_merge_is_refused(tmp_path, more, told):
    words = merging(tmp_path / "merged", [tmp_path / "part"], "k=1,2")
    with pytest.raises(InputError, match=f"^{told} has no effect: --merge computes nothing"):
        sweep.main(words + more)
    with pytest.raises(InputError, match="^INPUT: drive.bag has no effect: --merge computes nothing"):
        sweep.main(["drive.bag", *words])
