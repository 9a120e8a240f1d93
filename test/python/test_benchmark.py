"""The table of benchmark figures, made from what google-benchmark programs write."""

import json
import os
import stat
import sys

import pytest

from ratslam_tools.cli import benchmark
from ratslam_tools.errors import InputError

MEASURED = [
    {
        "name": "newViewAmongRandomTemplates/1000/manual_time",
        "cpu_time": 90000.0,
        "time_unit": "ns",
        "ours_ms": 0.05,
        "oracle_ms": 5.5,
        "ratio": 110.0,
    },
    {
        "name": "referenceUpdate/1000",
        "cpu_time": 0.7,
        "time_unit": "ms",
        "ours_ms": 0.7,
        "oracle_ms": 0.84,
        "ratio": 1.2,
    },
    {"name": "closure/20000/iterations:1", "cpu_time": 300.0, "time_unit": "ms", "max_ms": 10.0},
    {"name": "growth/1000/iterations:3000", "cpu_time": 0.4, "time_unit": "us"},
    {"name": "somethingElse", "cpu_time": 1.0, "time_unit": "ms"},
]


def row_of(label):
    return next(row for row in benchmark.make_rows(MEASURED) if row["case"] == label)


def test_only_what_was_measured_has_a_line_and_the_order_is_that_of_the_cases():
    assert [row["case"] for row in benchmark.make_rows(MEASURED)] == [
        "view search, new view, 1 k",
        "map update, reference arithmetic, 1 k",
        "map growth without recalls, from 1 k on",
        "map, longest update after a closure over 20 k",
    ]


def test_a_ratio_is_held_against_its_bar():
    assert row_of("view search, new view, 1 k")["met"] is True
    assert row_of("map update, reference arithmetic, 1 k")["met"] is False


def test_a_time_is_held_against_its_bar():
    row = row_of("map, longest update after a closure over 20 k")
    assert row["ms"] == 10.0
    assert row["met"] is True


def test_without_a_counter_the_time_is_the_programs_in_its_unit():
    row = row_of("map growth without recalls, from 1 k on")
    assert row["ms"] == pytest.approx(0.0004)
    assert row["met"] is None


def test_openratslams_own_time_is_set_beside_ours():
    assert row_of("view search, new view, 1 k")["times_openratslam"] == pytest.approx(68.6)


def test_table_says_what_was_missed():
    lines = benchmark.make_table(benchmark.make_rows(MEASURED)).splitlines()
    assert lines[0].split()[:3] == ["case", "time", "oracle"]
    assert lines[1].split()[-4:] == ["met", "3.43", "ms", "68.6x"]
    assert "2x MISSED" in lines[2]
    assert len(lines) == 5


def test_a_size_is_not_taken_for_a_longer_one():
    assert benchmark.find([{"name": "defaultUpdate/10000"}], "defaultUpdate/1000") is None


def fake_program(folder, name, output, status=0):
    path = folder / name
    path.write_text(f"#!{sys.executable}\nimport sys\nprint({output!r})\nsys.exit({status})\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


def test_figures_of_all_programs_go_to_one_file(tmp_path, capsys):
    for name, part in (("a_benchmark", MEASURED[:2]), ("b_benchmark", MEASURED[2:])):
        fake_program(tmp_path, name, json.dumps({"context": {"num_cpus": 2}, "benchmarks": part}))
    out = tmp_path / "out" / "benchmark.json"
    benchmark.main(["--no-build", "--build", str(tmp_path), "--out", str(out)])
    written = json.loads(out.read_text())
    assert len(written["benchmarks"]) == len(MEASURED)
    assert len(written["table"]) == 4
    assert "view search" in capsys.readouterr().out


def test_a_table_of_its_own_is_shown_as_it_is(tmp_path, capfd):
    fake_program(tmp_path, "a_benchmark", json.dumps({"context": {"num_cpus": 2}, "benchmarks": MEASURED}))
    fake_program(tmp_path, "checkpoints_benchmark", "odometry 0.1 ms")
    out = tmp_path / "benchmark.json"
    benchmark.main(["--no-build", "--build", str(tmp_path), "--out", str(out)])
    assert "odometry 0.1 ms" in capfd.readouterr().out
    assert json.loads(out.read_text())["context"] == {"num_cpus": 2}


def test_the_build_folder_is_the_callers(tmp_path, monkeypatch):
    (tmp_path / "mine").mkdir()
    fake_program(tmp_path / "mine", "a_benchmark", json.dumps({"context": {}, "benchmarks": MEASURED}))
    monkeypatch.chdir(tmp_path)
    benchmark.main(["--no-build", "--build", "mine", "--out", "b.json"])
    assert len(json.loads((tmp_path / "b.json").read_text())["benchmarks"]) == len(MEASURED)


def test_only_chooses_programs_and_refuses_unknown_names(tmp_path):
    for name in ("a_benchmark", "b_benchmark"):
        fake_program(tmp_path, name, "{}")
    assert [os.path.basename(path) for path in benchmark.programs(str(tmp_path), ["b_"])] == ["b_benchmark"]
    with pytest.raises(InputError, match="a_benchmark, b_benchmark"):
        benchmark.programs(str(tmp_path), ["zebra"])


def test_a_program_that_fails_is_named(tmp_path):
    fake_program(tmp_path, "a_benchmark", "", status=3)
    with pytest.raises(InputError, match="a_benchmark: ended with status 3"):
        benchmark.run(str(tmp_path / "a_benchmark"))
