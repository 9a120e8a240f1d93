"""ratslam: the core of ratslam_ros in Python.

    import ratslam
    network = ratslam.PoseCellNetwork(pc_dim_xy=30, pc_cell_x_size=0.5)
    network.step(distance=0.2, rotation=0.01)
    network.activity            # (heading, y, x), a view without a copy

Parameters have the names of docs/parameters.md; a name that no model knows is an error. `ratslam.tools` are the
evaluation and conversion tools; `ratslam.read_run(folder)` reads the results of `ratslam_run`.
"""

import importlib
import importlib.abc
import importlib.machinery
import sys

from ratslam._core import (
    Action,
    Estimate,
    ExperienceMap,
    LocalViewCells,
    Pipeline,
    PoseCellNetwork,
    PoseCells,
    ViewEvent,
    __version__,
)

__all__ = [
    "Action",
    "Estimate",
    "ExperienceMap",
    "LocalViewCells",
    "Pipeline",
    "PoseCellNetwork",
    "PoseCells",
    "ViewEvent",
    "read_run",
    "__version__",
]


class _Tools(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """ratslam.tools and all below it are the modules of ratslam_tools, not copies of them."""

    PREFIX = "ratslam.tools"

    def __init__(self):
        self.own_specs = {}

    def find_spec(self, fullname, path=None, target=None):
        if fullname == self.PREFIX or fullname.startswith(self.PREFIX + "."):
            return importlib.machinery.ModuleSpec(fullname, self)
        return None

    def create_module(self, spec):
        module = importlib.import_module("ratslam_tools" + spec.name[len(self.PREFIX) :])
        self.own_specs[module] = module.__spec__
        return module

    def exec_module(self, module):
        """It has been executed under its own name, and keeps it."""
        module.__spec__ = self.own_specs.pop(module)


sys.meta_path.insert(0, _Tools())


def __getattr__(name: str):
    """ratslam.tools, loaded when it is first asked for."""
    if name == "tools":
        return importlib.import_module(_Tools.PREFIX)
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")


def read_run(folder: str):
    """Results of `ratslam_run --out folder`: trajectories, map, templates, actions, summary, pose cells.

    Returns a ratslam_tools.runs.run_folder.Run. Raises ratslam_tools.errors.InputError naming what cannot be read.
    """
    from ratslam_tools.runs.run_folder import Run

    return Run(folder)
