"""A run that is saved, and continued in new processes, leaves what one run leaves; and what a map file refuses."""

import filecmp
import json
import os
import shutil
import sqlite3
import subprocess

import pytest

from conftest import SOURCE, built

FRAMES = 120


@pytest.fixture(scope="module")
def programs():
    """ratslam_run, ratslam_town and ratslam_map; skips where they are not built."""
    return built("ratslam_town", "ratslam_map")


@pytest.fixture(scope="module")
def drive(programs, tmp_path_factory):
    """A short drive through the town, and the words of a run over it."""
    folder = tmp_path_factory.mktemp("drive")
    subprocess.run(
        [programs[1], "--out", folder / "town", "--frames", str(FRAMES), "--size", "320x120"],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    settings = ("--set", "image_crop_y_min=10", "--set", "image_crop_y_max=100", "--set", "vt_match_threshold=0.05")
    regions = (
        *("--set", "vrot_image_x_min=100", "--set", "vrot_image_x_max=220", "--set", "vrot_image_y_min=30"),
        *("--set", "vrot_image_y_max=60", "--set", "vtrans_image_x_min=50", "--set", "vtrans_image_x_max=270"),
        *("--set", "vtrans_image_y_min=60", "--set", "vtrans_image_y_max=110"),
    )
    return [folder / "town", "--config", os.path.join(SOURCE, "config", "kitti.yaml"), *settings, *regions]


def call(*words):
    return subprocess.run(
        list(map(str, words)),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
        check=False,
    )


def succeed(*words):
    done = call(*words)
    assert done.returncode == 0, done.stdout + done.stderr
    return done


@pytest.fixture(scope="module")
def whole(programs, drive, tmp_path_factory):
    """The uninterrupted run: its folder, and its map."""
    out = tmp_path_factory.mktemp("whole")
    succeed(programs[0], *drive, "--out", out / "run", "--save-map", out / "map.db")
    return out


def without_timing(summary):
    content = json.loads(summary.read_text())
    del content["timing"]
    return content


@pytest.mark.parametrize("stops", [[2], [37], [60, 61, 100]])
def test_a_run_in_parts_leaves_what_one_run_leaves(programs, drive, whole, tmp_path, stops):
    words = []
    begin = 0
    for part, end in enumerate(stops + [FRAMES]):
        out = tmp_path / f"run{part}"
        words = ["--max-frames", end - begin, "--from-frame", begin]
        if part:
            words += ["--load-map", tmp_path / "map.db"]
        succeed(programs[0], *drive, *words, "--save-map", tmp_path / "map.db", "--out", out)
        begin = end
    names = sorted(os.listdir(whole / "run"))
    assert names == sorted(os.listdir(out))
    for name in names:
        if name == "summary.json":
            assert without_timing(out / name) == without_timing(whole / "run" / name)
        else:
            assert filecmp.cmp(out / name, whole / "run" / name, shallow=False), name


@pytest.mark.parametrize("wrong", ["0", "100"], ids=["none", "ahead"])
def test_a_wrong_stamp_at_the_end_of_a_part_does_not_cut_the_drive(programs, drive, tmp_path, wrong):
    town = tmp_path / "town"
    shutil.copytree(drive[0], town)
    times = (town / "times.txt").read_text().split()
    times[36] = wrong
    (town / "times.txt").write_text("".join(time + "\n" for time in times))
    words = [town, *drive[1:]]
    succeed(programs[0], *words, "--max-frames", 60, "--out", tmp_path / "whole")
    saved = ("--save-map", tmp_path / "map.db")
    succeed(programs[0], *words, "--max-frames", 37, *saved, "--out", tmp_path / "first")
    onward = ("--from-frame", 37, "--max-frames", 23, "--load-map", tmp_path / "map.db")
    done = succeed(programs[0], *words, *onward, *saved, "--out", tmp_path / "run")
    assert "a new stretch begins" not in done.stderr, done.stderr
    assert without_timing(tmp_path / "run" / "summary.json") == without_timing(tmp_path / "whole" / "summary.json")
    for name in ("trajectory_final.tum", "odometry.csv", "templates.csv"):
        assert filecmp.cmp(tmp_path / "run" / name, tmp_path / "whole" / name, shallow=False), name


def test_another_drive_goes_on_in_the_same_map(programs, drive, whole, tmp_path):
    before = sqlite3.connect(str(whole / "map.db")).execute("SELECT count(*) FROM template").fetchone()[0]
    done = succeed(
        programs[0], *drive, "--load-map", whole / "map.db", "--save-map", tmp_path / "both.db", "--out", tmp_path / "run"
    )
    assert "a new stretch begins" in done.stderr
    after = sqlite3.connect(str(tmp_path / "both.db")).execute("SELECT count(*) FROM template").fetchone()[0]
    assert before <= after <= before + 3, "the same images are recalled, not learned again"


def test_localising_learns_nothing(programs, drive, whole, tmp_path):
    shutil.copy(whole / "map.db", tmp_path / "map.db")
    done = succeed(
        programs[0], *drive, "--load-map", tmp_path / "map.db", "--localise-only", "--out", tmp_path / "run"
    )
    assert filecmp.cmp(whole / "map.db", tmp_path / "map.db", shallow=False)
    counts = [json.loads((out / "run" / "summary.json").read_text())["counts"] for out in (whole, tmp_path)]
    for name in ("templates", "experiences", "links"):
        assert counts[0][name] == counts[1][name], name
    assert done.returncode == 0


@pytest.mark.parametrize(
    "spoil, complaint",
    [
        (lambda path: path.unlink(), "there is no such map file"),
        (lambda path: path.write_bytes(b"SQLite? no"), "it is not a map file"),
        (lambda path: os.truncate(path, path.stat().st_size // 2), "it is damaged"),
    ],
)
def test_a_spoilt_map_is_refused_in_one_line(programs, drive, whole, tmp_path, spoil, complaint):
    path = tmp_path / "map.db"
    shutil.copy(whole / "map.db", path)
    spoil(path)
    done = call(programs[0], *drive, "--load-map", path, "--out", tmp_path / "run")
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert f"{path}: {complaint}" in done.stderr, done.stderr
    assert call(programs[2], "check", path).returncode == 1


def test_other_parameters_are_refused_by_name(programs, drive, whole, tmp_path):
    done = call(
        programs[0], *drive, "--load-map", whole / "map.db", "--out", tmp_path / "run", "--set", "pc_dim_xy=40"
    )
    assert done.returncode == 1
    assert "made with pc_dim_xy = 30, but it is 40 now" in done.stderr


def test_tools_read_what_is_in_a_map(programs, whole, tmp_path):
    ratslam_map = programs[2]
    assert "sound" in succeed(ratslam_map, "check", whole / "map.db").stdout
    assert "templates: " in succeed(ratslam_map, "info", whole / "map.db").stdout
    for form, name in (("yaml", "map.yaml"), ("tum", "trajectory_final.tum")):
        succeed(ratslam_map, "export", whole / "map.db", "--format", form, "-o", tmp_path / name)
        if form == "yaml":
            assert filecmp.cmp(tmp_path / name, whole / "run" / name, shallow=False)
    succeed(ratslam_map, "export", whole / "map.db", "--format", "graphml", "-o", tmp_path / "map.graphml")
    networkx = pytest.importorskip("networkx")
    graph = networkx.read_graphml(str(tmp_path / "map.graphml"))
    rows = sqlite3.connect(str(whole / "map.db"))
    assert len(graph.nodes) == rows.execute("SELECT count(*) FROM experience").fetchone()[0]
    assert len(graph.edges) == rows.execute("SELECT count(*) FROM link").fetchone()[0]


@pytest.mark.parametrize("anchor", (8.4, 180.0, -180.0))
def test_geojson_lies_about_its_anchor(programs, whole, tmp_path, anchor):
    path = tmp_path / "map.geojson"
    words = ("--format", "geojson", f"--anchor=49.0,{anchor},90", "-o", path)
    succeed(programs[2], "export", whole / "map.db", *words)
    content = json.loads(path.read_text())
    assert content["type"] == "FeatureCollection" and content["features"]
    for feature in content["features"]:
        assert feature["type"] == "Feature" and feature["geometry"]["type"] in ("Point", "LineString")
        place = feature["geometry"]["coordinates"]
        longitude, latitude = place if feature["geometry"]["type"] == "Point" else place[0]
        assert abs((longitude - anchor + 180) % 360 - 180) < 0.02 and abs(latitude - 49.0) < 0.02
        assert -180 <= longitude <= 180


def test_a_pruned_map_is_smaller_and_sound(programs, drive, whole, tmp_path):
    succeed(programs[2], "prune", whole / "map.db", "-o", tmp_path / "small.db")
    assert (tmp_path / "small.db").stat().st_size < (whole / "map.db").stat().st_size
    succeed(programs[2], "check", tmp_path / "small.db")
    rows = sqlite3.connect(str(tmp_path / "small.db"))
    parts = {path.split("|")[0].split("/")[0] for (path,) in rows.execute("SELECT path FROM state")}
    assert parts.isdisjoint({"run", "odometry"}), parts
    done = succeed(programs[0], *drive, "--load-map", tmp_path / "small.db", "--out", tmp_path / "run")
    assert "a new stretch begins" in done.stderr


@pytest.fixture(scope="module")
def parts(programs, drive, tmp_path_factory):
    """Maps of the drive's frames 0-79, 40-119 and 90-119, each made without the others."""
    out = tmp_path_factory.mktemp("parts")
    for name, begin, count in (("first", 0, 80), ("second", 40, 80), ("last", 90, 30)):
        words = ("--from-frame", begin, "--max-frames", count, "--out", out / name)
        succeed(programs[0], *drive, *words, "--save-map", out / f"{name}.db")
    return out


def templates_of(path):
    return sqlite3.connect(str(path)).execute("SELECT count(*) FROM template").fetchone()[0]


def test_maps_that_share_places_become_one_in_either_order(programs, drive, parts, tmp_path):
    ratslam_map = programs[2]
    orders = (("first", "second"), ("second", "first"))
    for number, (one, other) in enumerate(orders):
        done = succeed(
            ratslam_map, "merge", parts / f"{one}.db", parts / f"{other}.db", "-o", tmp_path / f"{number}.db"
        )
        assert "in 1 component\n" in done.stdout, done.stdout
        succeed(ratslam_map, "check", tmp_path / f"{number}.db")
        words = ("--format", "yaml", "-o", tmp_path / f"{number}.yaml")
        succeed(ratslam_map, "export", tmp_path / f"{number}.db", *words)
    assert filecmp.cmp(tmp_path / "0.yaml", tmp_path / "1.yaml", shallow=False)
    both = templates_of(tmp_path / "0.db")
    counts = [templates_of(parts / f"{name}.db") for name in ("first", "second")]
    assert max(counts) <= both < sum(counts) - 8, "what both know is in it once"
    done = succeed(programs[0], *drive, "--load-map", tmp_path / "0.db", "--localise-only", "--out", tmp_path / "run")
    assert "a new stretch begins" in done.stderr


def test_maps_that_share_nothing_stay_two_components(programs, parts, tmp_path):
    words = (parts / "first.db", parts / "last.db", "-o", tmp_path / "both.db")
    assert "in 2 components\n" in succeed(programs[2], "merge", *words).stdout
    counts = [templates_of(path) for path in (parts / "first.db", parts / "last.db", tmp_path / "both.db")]
    assert counts[0] + counts[1] == counts[2]


def test_what_cannot_be_merged_is_said_in_one_line(programs, drive, parts, tmp_path):
    words = ("--max-frames", 20, "--set", "pc_dim_xy=40", "--save-map", tmp_path / "other.db", "--out", tmp_path / "run")
    succeed(programs[0], *drive, *words)
    first, other, both = parts / "first.db", tmp_path / "other.db", tmp_path / "both.db"
    for words, complaint in (
        ((first, other, "-o", both), f"{other}: made with pc_dim_xy = 40, but it is 30 now"),
        ((first, "-o", both), "merge needs two map files"),
        ((first, other, "-o", first), f"{first}: it is the map itself"),
    ):
        done = call(programs[2], "merge", *words)
        assert done.returncode == 1 and done.stderr.startswith(f"ratslam_map: {complaint}"), done.stderr
        assert done.stderr.count("\n") == 1
        assert not both.exists()


def test_no_map_is_overwritten_under_another_name(programs, parts, tmp_path):
    path, other = tmp_path / "map.db", tmp_path / "other.db"
    shutil.copy(parts / "first.db", path)
    shutil.copy(parts / "second.db", other)
    os.symlink(path, tmp_path / "symbolic.db")
    os.link(path, tmp_path / "hard.db")
    for out in (f"{tmp_path}/./map.db", tmp_path / "symbolic.db", tmp_path / "hard.db"):
        for words in (("prune", path), ("merge", path, other), ("merge", other, path), ("export", path, "--format", "tum")):
            done = call(programs[2], *words, "-o", out)
            assert done.returncode == 1 and done.stderr == f"ratslam_map: {out}: it is the map itself\n", done.stderr
    done = call(programs[2], "export", path, "--format", "tum", "-o", other)
    assert done.returncode == 1 and "other.db: cannot write this file: it is a map or another database and is not overwritten" in done.stderr
    assert filecmp.cmp(path, parts / "first.db", shallow=False) and filecmp.cmp(other, parts / "second.db", shallow=False)


def test_a_map_is_not_merged_with_itself(programs, parts, tmp_path):
    shutil.copy(parts / "first.db", tmp_path / "copy.db")
    for second in (parts / "first.db", tmp_path / "copy.db"):
        done = call(programs[2], "merge", parts / "first.db", second, "-o", tmp_path / "both.db")
        assert done.returncode == 1 and f"{second}: it is the same map as" in done.stderr, done.stderr
    assert not (tmp_path / "both.db").exists()


def test_a_save_that_was_cut_off_is_undone_by_whoever_reads(programs, parts, tmp_path):
    live, cut = tmp_path / "live.db", tmp_path / "cut.db"
    shutil.copy(parts / "first.db", live)
    database = sqlite3.connect(live, isolation_level=None)
    for line in ("pragma cache_size = 2", "pragma cache_spill = 1", "begin immediate", "update experience set pose_x = pose_x + 1",
                 "update chunk set data = zeroblob(length(data))"):
        database.execute(line)
    shutil.copy(live, cut)
    shutil.copy(f"{live}-journal", f"{cut}-journal")
    database.execute("rollback")
    assert not filecmp.cmp(cut, live, shallow=False), "the half-written map is on the disk"
    done = call(programs[2], "check", cut)
    assert done.returncode == 0 and done.stdout == f"{cut}: sound\n", done.stdout + done.stderr
    assert filecmp.cmp(cut, live, shallow=False) and not os.path.exists(f"{cut}-journal")


def test_a_map_is_not_merged_with_what_was_made_from_it(programs, parts, tmp_path):
    succeed(programs[2], "prune", parts / "first.db", "-o", tmp_path / "pruned.db")
    done = call(programs[2], "merge", parts / "first.db", tmp_path / "pruned.db", "-o", tmp_path / "both.db")
    assert done.returncode == 1 and "merge takes maps of different drives" in done.stderr, done.stderr


def test_a_drive_is_not_merged_twice(programs, parts, tmp_path):
    first, second, both = parts / "first.db", parts / "second.db", tmp_path / "both.db"
    succeed(programs[2], "merge", first, second, "-o", both)
    for one, other in ((both, first), (both, second), (second, both)):
        done = call(programs[2], "merge", one, other, "-o", tmp_path / "again.db")
        assert done.returncode == 1 and "merge takes maps of different drives" in done.stderr, done.stderr
    succeed(programs[2], "merge", both, parts / "last.db", "-o", tmp_path / "all.db")


def test_nothing_is_invented_where_a_map_has_a_break(programs, drive, tmp_path):
    town = drive[0]
    shutil.copytree(town, tmp_path / "again")
    times = (tmp_path / "again" / "times.txt").read_text().split()
    (tmp_path / "again" / "times.txt").write_text("".join(f"{float(time) + 100.0}\n" for time in times))
    settings = ("image_crop_y_min=10", "image_crop_y_max=100", "template_x_size=40", "template_y_size=12")
    words = ["--config", os.path.join(SOURCE, "config", "demo.yaml"), "--odometry", "orb"]
    words += [word for setting in settings for word in ("--set", setting)]
    run, first, second = programs[0], tmp_path / "a.db", tmp_path / "b.db"
    part = ("--from-frame", "30", "--max-frames", "60", "--save-map", second)
    succeed(run, town, *words, "--max-frames", "25", "--out", tmp_path / "a", "--save-map", first)
    succeed(run, town, *words, *part, "--out", tmp_path / "b")
    succeed(run, tmp_path / "again", *words, *part, "--out", tmp_path / "c", "--load-map", second)
    merged = succeed(programs[2], "merge", first, second, "-o", tmp_path / "both.db")
    assert "in 2 components" in merged.stdout, "the two stretches of the second map are one: they share places"
    succeed(programs[2], "export", tmp_path / "both.db", "--format", "tum", "-o", tmp_path / "path.tum")
    stamps = [float(line.split()[0]) for line in (tmp_path / "path.tum").read_text().splitlines()]
    assert [stamp for stamp in stamps if 9.0 < stamp < 102.9] == []
    assert len([stamp for stamp in stamps if stamp >= 102.9]) == 60


def test_merge_takes_two_files(programs, parts, tmp_path):
    for words, complaint in (
        ((parts / "first.db", tmp_path), f"{tmp_path}: it is a folder, no map file"),
        ((parts / "first.db", parts / "second.db", "third.db"), "third.db: merge takes two map files"),
    ):
        done = call(programs[2], "merge", *words, "-o", tmp_path / "both.db")
        assert done.returncode == 1 and complaint in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_what_has_no_effect_on_a_map_is_refused(programs, parts, tmp_path):
    out = ("-o", tmp_path / "out")
    for words, complaint in (
        (("info", *out), "--out has no effect here"),
        (("check", "--format", "tum"), "--format has no effect here"),
        (("export", "--format", "tum", "--anchor=1,2,3", *out), "--anchor has no effect here"),
        (("export", "--format", "geojson", "--anchor=1,x,2,3", *out), "must be LAT,LON,BEARING"),
        (("export", "--format", "geojson", "--anchor=89,2,3", *out), "a latitude of -85 to 85"),
        (("export", "--format", "geojson", "--anchor=1,2,1e300", *out), "a bearing of -360 to 360"),
        (("export", *out), "export needs --format"),
    ):
        done = call(programs[2], words[0], parts / "first.db", *words[1:])
        assert done.returncode == 1 and complaint in done.stderr and done.stderr.count("\n") == 1, done.stderr
    assert not (tmp_path / "out").exists()
