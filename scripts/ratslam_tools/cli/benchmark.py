"""benchmark: builds and runs the benchmark programs and compares their figures with the required ones. Each program
measures a plain implementation of the model and ours in one run: absolute times depend on the machine and its load,
their ratio hardly does.
"""

import argparse
import dataclasses
import json
import os
import subprocess
from typing import Dict, List, Optional

from ratslam_tools import SCRIPTS, text_file
from ratslam_tools.errors import InputError
from ratslam_tools.table import format_table

SOURCES = os.path.dirname(SCRIPTS)
OWN_TABLE = ("checkpoints_benchmark",)  # what these programs print is their table, not Google Benchmark's
HEAD = ["case", "time", "oracle", "ratio", "bar", "OpenRatSLAM", "times OpenRatSLAM"]


@dataclasses.dataclass(frozen=True)
class Case:
    """One line of the table."""

    name: str  # of the benchmark, without the settings that Google Benchmark appends
    label: str
    bar_ratio: Optional[float] = None  # required: least ratio of the plain implementation's time to ours
    bar_ms: Optional[float] = None  # required: greatest time of ours [ms]
    openratslam_ms: Optional[float] = None  # time of OpenRatSLAM's own code on a machine of this kind [ms]
    time: str = "ours_ms"  # name of the counter with our time [ms]


def _sizes(name, label, bars, openratslam, **other) -> List[Case]:
    """A case for 1 k, 5 k and 20 k templates or experiences."""
    return [
        Case(f"{name}/{1000 * size}", f"{label} {size} k", bar, openratslam_ms=reference, **other)
        for size, bar, reference in zip((1, 5, 20), bars, openratslam)
    ]


CASES = [
    *_sizes("newViewAmongRandomTemplates", "view search, new view,", [100] * 3, (3.43, 16.9, 66.7)),
    *_sizes(
        "revisitedViewAmongRandomTemplates", "view search, revisited view,", [100] * 3, (1.77, 8.6, 38.7)
    ),
    Case("millionRealisticTemplates/revisited:0", "view search, new view, 1 M realistic", bar_ms=50),
    Case("millionRealisticTemplates/revisited:1", "view search, revisited view, 1 M realistic", bar_ms=50),
    Case("packetStep/n_xy:30", "attractor 30x30x36, one packet", 20, openratslam_ms=0.71),
    Case("allLitStep/n_xy:30", "attractor 30x30x36, all cells lit", 50, openratslam_ms=10.7),
    Case("packetStep/n_xy:61", "attractor 61x61x36, one packet", 50, openratslam_ms=2.34),
    Case("allLitStep/n_xy:61", "attractor 61x61x36, all cells lit", 50, openratslam_ms=46.3),
    *_sizes("defaultUpdate", "map update, default map,", (None, None, 50), (0.49, 2.50, 10.0)),
    *_sizes("referenceUpdate", "map update, reference arithmetic,", [2] * 3, (0.49, 2.50, 10.0)),
    Case("referenceUpdateAtRest/20000", "map update, reference arithmetic, no loops, 20 k"),
    Case("growth/1000", "map growth without recalls, from 1 k on"),
    Case("growth/20000", "map growth without recalls, from 20 k on"),
    Case("closure/20000", "map, longest update after a closure over 20 k", bar_ms=50, time="max_ms"),
    Case("takeMap/20000", "map file, 20 k places: what a frame waits for"),
    Case("writeMap/20000", "map file, 20 k places: writing"),
    Case("loadMap/20000", "map file, 20 k places: loading", bar_ms=1000),
    Case("mapMessage/100000", "map message of 100 k experiences"),
    Case("markerMessage/100000", "map marker of 100 k experiences"),
    Case("mapPicture/100000", "map picture of 100 k experiences"),
    Case(
        "wholeFrames/large:0/threads:1",
        "ORB frame 1241x376, one core, median",
        bar_ms=25,
        time="median_ms",
    ),
    Case("wholeFrames/large:0/threads:2", "ORB frame 1241x376, two cores, median", time="median_ms"),
    Case("wholeFrames/large:1/threads:1", "ORB frame 1280x960, one core, median", time="median_ms"),
    Case("wholeFrames/large:1/threads:2", "ORB frame 1280x960, two cores, median", time="median_ms"),
]

_MILLISECONDS = {"ns": 1e-6, "us": 1e-3, "ms": 1.0, "s": 1e3}


def find(benchmarks: List[Dict], name: str) -> Optional[Dict]:
    """The measurement of this name. google-benchmark appends its settings after a slash."""
    for measured in benchmarks:
        if measured["name"] == name or measured["name"].startswith(name + "/"):
            return measured
    return None


def time_ms(case: Case, measured: Dict) -> float:
    """The counter of this case's time; if there is none, google-benchmark's CPU time."""
    if case.time in measured:
        return measured[case.time]
    return measured["cpu_time"] * _MILLISECONDS[measured["time_unit"]]


def make_rows(benchmarks: List[Dict]) -> List[Dict]:
    """The table's lines as numbers, for the cases that were measured. `met` is None without a bar."""
    rows = []
    for case in CASES:
        measured = find(benchmarks, case.name)
        if measured is None or measured.get("error_occurred"):
            continue
        ours = time_ms(case, measured)
        row = {"case": case.label, "ms": ours, "oracle_ms": measured.get("oracle_ms")}
        row["ratio"] = measured.get("ratio")
        row.update(bar_ratio=case.bar_ratio, bar_ms=case.bar_ms, openratslam_ms=case.openratslam_ms, met=None)
        row["times_openratslam"] = case.openratslam_ms / ours if case.openratslam_ms else None
        if case.bar_ratio is not None:
            row["met"] = row["ratio"] >= case.bar_ratio
        elif case.bar_ms is not None:
            row["met"] = ours <= case.bar_ms
        rows.append(row)
    return rows


def _milliseconds(value: Optional[float]) -> str:
    return "" if value is None else f"{value:.3g} ms"


def _times(value: Optional[float]) -> str:
    return "" if value is None else f"{value:.3g}x"


def _bar(row: Dict) -> str:
    text = _times(row["bar_ratio"]) or _milliseconds(row["bar_ms"])
    return text if row["met"] is None else f"{text} {'met' if row['met'] else 'MISSED'}"


def make_table(rows: List[Dict]) -> str:
    """The lines as text."""
    text = [
        [
            row["case"],
            _milliseconds(row["ms"]),
            _milliseconds(row["oracle_ms"]),
            _times(row["ratio"]),
            _bar(row),
            _milliseconds(row["openratslam_ms"]),
            _times(row["times_openratslam"]),
        ]
        for row in rows
    ]
    return format_table([HEAD, *text])


def build(folder: str) -> None:
    """Configures and builds the benchmark programs only. @raise InputError if that fails."""
    configure = ["cmake", "-S", SOURCES, "-B", folder, "-DRATSLAM_BENCHMARKS=ON"]
    if not os.path.exists(os.path.join(folder, "CMakeCache.txt")):
        configure += ["-DRATSLAM_TESTS=OFF"]
        configure += ["-DPYTHON_EXECUTABLE=/usr/bin/python3", "-DPython3_EXECUTABLE=/usr/bin/python3"]
    parallel = f"-j{os.cpu_count()}"
    for command in (configure, ["cmake", "--build", folder, parallel, "--target", "benchmarks"]):
        if subprocess.run(command, stdout=subprocess.DEVNULL).returncode != 0:
            raise InputError(f"{' '.join(command)}: failed; see above")


def programs(folder: str, only: List[str]) -> List[str]:
    """The benchmark programs. @param only parts of names, one of which a program must contain; empty: all."""
    names = sorted(name for name in os.listdir(folder) if name.endswith("_benchmark"))
    chosen = [name for name in names if not only or any(part in name for part in only)]
    if not chosen:
        found = ", ".join(names) or "no benchmark programs"
        raise InputError(f"--only {' '.join(only)}: {folder} has {found}")
    return [os.path.join(folder, name) for name in chosen]


def run(program: str) -> Dict:
    """Output of one program, as Google Benchmark writes it in JSON: context and benchmarks. A program of OWN_TABLE is shown, and
    has neither. @throws InputError if it fails.
    """
    own_table = os.path.basename(program) in OWN_TABLE
    words = [program] if own_table else [program, "--benchmark_format=json"]
    done = subprocess.run(words, stdout=None if own_table else subprocess.PIPE, cwd=SOURCES)
    if done.returncode != 0:
        raise InputError(f"{program}: ended with status {done.returncode}")
    return {"context": {}, "benchmarks": []} if own_table else json.loads(done.stdout)


def parse(argv):
    """The options of the command line, or of `argv` if it is not None, as an argparse.Namespace."""
    parser = argparse.ArgumentParser(prog="benchmark", description=__doc__)
    build_folder = os.path.join(SOURCES, "build")
    parser.add_argument("--build", default=build_folder, help="build folder (default: build)")
    parser.add_argument("--no-build", action="store_true", help="run the programs as they are")
    parser.add_argument(
        "--out",
        default=os.path.join(SOURCES, "out", "benchmark", "benchmark.json"),
        help="where the figures go as JSON (default: out/benchmark/benchmark.json)",
    )
    parser.add_argument(
        "--only", nargs="+", default=[], metavar="PART", help="programs whose names hold one of these"
    )
    options = parser.parse_args(argv)
    options.build = os.path.abspath(options.build)  # the programs run in another folder than the caller's
    return options


def main(argv=None) -> None:
    options = parse(argv)
    if not options.no_build:
        build(options.build)
    if not os.path.isdir(options.build):
        raise InputError(f"--build {options.build}: there is no such folder")
    measured = []
    context = {}
    for program in programs(options.build, options.only):
        print(f"{os.path.basename(program)} ...", flush=True)
        result = run(program)
        context = result["context"] or context
        measured += result["benchmarks"]
    rows = make_rows(measured)
    os.makedirs(os.path.dirname(os.path.abspath(options.out)), exist_ok=True)
    with text_file.writing(options.out) as file:
        json.dump({"context": context, "table": rows, "benchmarks": measured}, file, indent=2)
    print(f"\n{make_table(rows)}\n\n{options.out}")
