#!/usr/bin/env python3
"""Figures of what `scripts/endurance soak` has printed."""

import argparse
import csv
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))

from ratslam_tools import plotting  # noqa: E402


def read(path):
    """{column: values over the rows} of a table of the soak."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def over_frames(pyplot, table):
    """Memory, size of the map and time a frame over the frames."""
    figure, (memory, size, time) = pyplot.subplots(3, 1, sharex=True, figsize=(7.0, 6.5))
    millions = table["frames"] / 1e6
    memory.plot(millions, table["memory_mb"], color=plotting.FINAL)
    memory.set_ylabel("resident memory [MB]")
    memory.set_ylim(bottom=0.0)
    for name, colour in (("experiences", plotting.FINAL), ("links", plotting.ONLINE), ("graph_nodes", plotting.LINK)):
        size.plot(millions, table[name], color=colour, label=name.replace("_", " "))
    size.set_ylim(bottom=0.0)
    size.legend()
    for name, colour in (("worst_ms", plotting.LINK), ("mean_ms", plotting.FINAL)):
        time.semilogy(millions, table[name], color=colour, label=name.split("_", maxsplit=1)[0])
    time.set_ylabel("processor time a frame [ms]")
    time.legend()
    time.set_xlabel("million frames")
    figure.tight_layout()
    return figure


def over_visits(pyplot, tables, labels):
    """Experiences over the laps of a patrol, and straight lines in the logarithm of the visits, from lap 10 on."""
    figure, axes = pyplot.subplots(figsize=(7.0, 4.5))
    for table, label in zip(tables, labels):
        laps = np.arange(1, len(table["frames"]) + 1)
        (line,) = axes.semilogx(laps, table["experiences"], label=label)
        slope, start = np.polyfit(np.log(laps[9:]), table["experiences"][9:], 1)
        axes.semilogx(laps[9:], start + slope * np.log(laps[9:]), "--", color=line.get_color(), linewidth=1.0)
        off = np.abs(start + slope * np.log(laps[9:]) - table["experiences"][9:]).max()
        print(f"{label}: {start:.0f} + {slope:.1f} ln(visits) from the 10th on, off by up to {off:.0f}")
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("visits")
    axes.set_ylabel("experiences")
    axes.legend()
    figure.tight_layout()
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tables", nargs="+", help="CSV files of the soak")
    parser.add_argument("-o", "--out", required=True, help="PNG file to write")
    parser.add_argument("--visits", nargs="+", metavar="LABEL", help="patrols: experiences over visits, one name a table")
    arguments = parser.parse_args()
    pyplot = plotting.load()
    tables = [read(path) for path in arguments.tables]
    if arguments.visits:
        figure = over_visits(pyplot, tables, arguments.visits)
    else:
        figure = over_frames(pyplot, tables[0])
    plotting.finish(pyplot, figure, arguments.out)


if __name__ == "__main__":
    main()
