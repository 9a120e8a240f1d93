"""A short run of test/fuzz/python_readers.py; `scripts/endurance fuzz-python` is the long one."""

import os
import sys

import pytest

from conftest import SOURCE

sys.path.insert(0, os.path.join(SOURCE, "test", "fuzz"))
pytest.importorskip("rosbag")
import python_readers  # noqa: E402


@pytest.mark.parametrize("name", python_readers.TARGETS)
def test_readers_take_or_refuse_whatever_comes(name):
    assert python_readers.fuzz(name, 200, seed=7) == []


def test_a_planted_fault_is_found(monkeypatch):
    files, read = python_readers.TARGETS["odometry"]

    def faulty(folder):
        if len(read(folder)) != 4:
            raise IndexError("planted")

    monkeypatch.setitem(python_readers.TARGETS, "odometry", (files, faulty))
    assert python_readers.fuzz("odometry", 200, seed=7)
