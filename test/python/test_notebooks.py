"""The notebooks run from top to bottom, and each draws its pictures."""

import glob
import json
import os
import sys

import pytest

from conftest import SOURCE

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
sys.path.append(os.path.join(SOURCE, "devel", "lib", "python3", "dist-packages"))
pytest.importorskip("ratslam", reason="the Python module is not built")

NOTEBOOKS = sorted(glob.glob(os.path.join(SOURCE, "docs", "notebooks", "*.ipynb")))
PICTURES = {"attractor": 4, "place_fields": 4, "paper_figures": 2}


def code_of(path):
    """The code cells, as text."""
    with open(path, encoding="utf-8") as file:
        notebook = json.load(file)
    return ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]


def test_every_notebook_is_known():
    assert {os.path.basename(path)[:-6] for path in NOTEBOOKS} == set(PICTURES)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=[os.path.basename(path)[:-6] for path in NOTEBOOKS])
def test_notebook(path, monkeypatch, tmp_path):
    from matplotlib import pyplot
    from ratslam_tools.errors import InputError
    from ratslam_tools.runs import runner

    name = os.path.basename(path)[:-6]
    if name == "paper_figures":
        try:
            runner.find()
        except InputError:
            pytest.skip("ratslam_run is not built")
        monkeypatch.setenv("FRAMES", "60")
        monkeypatch.setenv("SIZE", "620x188")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    shown = []

    def show():
        """Pictures are kept where a folder is named in NOTEBOOK_PICTURES."""
        shown.append(pyplot.gcf())
        folder = os.environ.get("NOTEBOOK_PICTURES")
        if folder:
            pyplot.gcf().savefig(os.path.join(folder, f"{name}_{len(shown)}.png"))
        pyplot.close("all")

    monkeypatch.setattr(pyplot, "show", show)
    names = {"__name__": "__main__"}
    for number, code in enumerate(code_of(path)):
        exec(compile(code, f"{path}, cell {number}", "exec"), names)  # pylint: disable=exec-used
    assert len(shown) == PICTURES[name]
