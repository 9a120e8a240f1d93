"""Finding and calling ratslam_run."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
from typing import Dict, Iterable, List, Optional, Sequence, Tuple

from ratslam_tools import SCRIPTS, evaluation
from ratslam_tools.runs import fingerprint, run_folder
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import later_files

PROGRAM = "ratslam_run"
# Its places, from the folder above scripts/: catkin workspace, plain CMake, install space.
BUILD_PLACES = (
    "devel/lib/ratslam_ros",
    "../../devel/lib/ratslam_ros",
    "../devel/lib/ratslam_ros",
    "build_core",
    "build",
    "../../install/lib/ratslam_ros",
)


def find(given: Optional[str] = None) -> str:
    """Path of ratslam_run: the given one, beside these scripts, on PATH, in an overlaid workspace, or in a
    build folder.

    @throws InputError listing the searched places.
    """
    if given is not None:
        path = shutil.which(given) or given
        if not (os.path.isfile(path) and os.access(path, os.X_OK)):
            raise InputError(f"--ratslam_run: {given} is not an executable file")
        return os.path.abspath(path)
    places = [SCRIPTS]
    places += [
        os.path.join(prefix, "lib", "ratslam_ros")
        for prefix in os.environ.get("CMAKE_PREFIX_PATH", "").split(":")
        if prefix
    ]
    places += [os.path.normpath(os.path.join(os.path.dirname(SCRIPTS), place)) for place in BUILD_PLACES]
    on_path = shutil.which(PROGRAM)
    candidates = [os.path.join(place, PROGRAM) for place in places]
    candidates[1:1] = [on_path] if on_path else []
    for candidate in candidates:
        if os.path.isfile(candidate) and os.access(candidate, os.X_OK):
            return os.path.abspath(candidate)
    raise InputError(
        f"{PROGRAM} was not found on PATH, in the workspaces of CMAKE_PREFIX_PATH, or in: "
        f"{', '.join(places)}; "
        "build the package, or give --ratslam_run FILE"
    )


def command(
    program: str,
    source: str,
    config: str,
    out: str,
    settings: Optional[Dict[str, str]] = None,
    odometry: Optional[str] = None,
    max_frames: Optional[int] = None,
    more: Sequence[str] = (),
) -> List[str]:
    """The command line of one run. @param more options of ratslam_run as they are. @throws InputError if they set a key of
    `settings`, which would then have no effect.
    """
    require_not_set(settings or {}, more)
    words = [program, source, "--config", config, "--out", out]
    if odometry is not None:
        words += ["--odometry", odometry]
    if max_frames is not None:
        words += ["--max-frames", str(max_frames)]
    for key, value in (settings or {}).items():
        words += ["--set", f"{key}={value}"]
    return [*words, *more]


def objection(program: str, config: str, settings: Optional[Dict[str, str]] = None) -> Optional[Tuple[str, str]]:
    """The first parameter that ratslam_run refuses, in a configuration or in what is set on top of it: (parameter, message), or
    None. It checks parameters before it opens the recording, so a recording that does not exist is given.
    """
    with tempfile.TemporaryDirectory() as folder:
        words = command(program, os.path.join(folder, "recording"), config, os.path.join(folder, "out"), settings)
        try:
            finished = subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
        except OSError as error:
            raise InputError(f"{words[0]}: cannot be run: {error.strerror}") from None
    found = re.search(rf"^{PROGRAM}: ((\w+): .*)$", finished.stderr.decode("utf-8", "replace"), re.MULTILINE)
    return (found.group(2), found.group(1)) if found else None


# Help text of commands that take such options.
PASSED_ON = "What follows `--` is passed on to ratslam_run: `-- --image-topic /front/image`, `-- --calibration phone.yaml`."


def split(argv: Optional[List[str]]) -> Tuple[List[str], List[str]]:
    """Words of the command line (None: the process's) before `--`, and those after it, which are options of
    ratslam_run."""
    words = list(sys.argv[1:] if argv is None else argv)
    end = words.index("--") if "--" in words else len(words)
    return words[:end], words[end + 1 :]


def option(words: Sequence[str], name: str) -> Optional[str]:
    """The value that `--name VALUE` or `--name=VALUE` gives among the words."""
    for word, following in zip(words, [*words[1:], None]):
        if word == name:
            return following
        if word.startswith(name + "="):
            return word[len(name) + 1 :]
    return None


IMAGE_FOLDERS = ("images", "image_0", "image_1", "image_2", "image_3")


def require_apart(out: str, source: str) -> None:
    """@throws InputError if the folder for the runs is the recording itself or its folder of images, which would then hold
    their files and figures."""
    places = [source, *(os.path.join(source, name) for name in IMAGE_FOLDERS)]
    if os.path.realpath(out) in map(os.path.realpath, places):
        raise InputError(f"--out: '{out}' is not allowed: it must be another folder than the recording's own")


SYNONYMS = {"vt_patch_normalisation": "vt_patch_normalise"}  # OpenRatSLAM's two spellings of one parameter


def parameter(key: str) -> str:
    """The name of the parameter that a key means."""
    return SYNONYMS.get(key.strip(), key.strip())


def require_not_set(keys: Iterable[str], more: Sequence[str]) -> None:
    """@throws InputError if options of ratslam_run set one of the keys that this command gives values itself: the last
    value would hold in every run."""
    ours = {parameter(key): key for key in keys}
    for word, following in zip(more, [*more[1:], ""]):
        name, equals, value = word.partition("=")
        if name not in ("--set", "--se"):  # ratslam_run takes the beginning of an option's name for the option
            continue
        assignment = value if equals else following
        key = parameter(assignment.partition("=")[0])
        if key in ours:
            raise InputError(
                f"--set: '{assignment}' is not allowed: {ours[key]} gets its values from this command itself; leave it out"
            )


def run_once(words: List[str], folder: str) -> str:
    """Runs a command that creates `folder`, unless the same command has created it before from the same inputs (fingerprint.py).
    Returns the folder.

    A folder of another command is replaced. One that this function has not made is left alone: it may hold a
    recording. @throws InputError as Runner.run.
    """
    done = os.path.join(folder, "command.json")
    known = run_folder.read_json(done) if os.path.isfile(done) else {}
    origin = {"command": words, "inputs": fingerprint.of_command(words)}
    if known == {**origin, "complete": True}:
        return folder
    if not known and os.path.exists(folder) and not (os.path.isdir(folder) and not os.listdir(folder)):
        raise InputError(f"{folder}: not replaced by a run: it exists, and no run of this tool has left it; give another --out")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    # Written first, so that what an interrupted run leaves is known as such.
    evaluation.write_json(done, {**origin, "complete": False})
    Runner().run(words)
    evaluation.write_json(done, {**origin, "complete": True})
    return folder


# Parameters of the models behind the odometry; whatever else is varied may change the odometry itself.
BEHIND_ODOMETRY = ("pc_", "vt_", "exp_", "template_", "image_crop_")


def odometry_can_be_shared(odometry: Optional[str], keys) -> bool:
    """Whether runs that differ only in `keys` have the same odometry, which is costly. Then one run computes it from
    images, and the others read its odometry.csv, with the same results.
    """
    return odometry == "orb" and all(key.startswith(BEHIND_ODOMETRY) for key in keys)


def shared_odometry(folder: str, odometry: str) -> str:
    """The value of --odometry with which other runs repeat the odometry of the run in `folder`: the path of its odometry.csv.
    If time went back in the run, `odometry` itself, because that file holds the first stretch only.
    """
    path = os.path.join(folder, "odometry.csv")
    return odometry if later_files(path) else path


class Runner:
    """Runs programs from several threads and can stop them all.

    Each program has its own session, so that Ctrl-C in the terminal does not end it early: a partial result would
    look like a complete one.
    """

    def __init__(self):
        self._lock = threading.Lock()
        self._processes: List[subprocess.Popen] = []
        self._stopped = False

    def run(self, words: List[str]) -> List[str]:
        """Runs a command to its end and returns what ratslam_run has remarked. @throws InputError with its last line of
        stderr if it fails or is stopped.
        """
        with self._lock:
            if self._stopped:
                raise InputError("stopped")
            try:
                process = subprocess.Popen(
                    words,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.PIPE,
                    start_new_session=True,
                )
            except OSError as error:
                raise InputError(f"{words[0]}: cannot be run: {error.strerror}") from None
            self._processes.append(process)
        try:
            _, messages = process.communicate()
        except KeyboardInterrupt:
            process.terminate()
            raise
        with self._lock:
            self._processes.remove(process)
            if self._stopped:
                raise InputError("stopped")
        lines = messages.decode("utf-8", "replace").strip().splitlines()
        if process.returncode != 0:
            own = [index for index, line in enumerate(lines) if line.startswith(PROGRAM + ": ")]
            last = " ".join(lines[own[-1] if own else -1 :])  # a name in it may break the line
            raise InputError(f"{' '.join(words)}: exit status {process.returncode}: {last or 'no message'}")
        return [line[len(PROGRAM) + 2 :] for line in lines if line.startswith(PROGRAM + ": ")]

    def stop(self) -> None:
        """Ends all running commands. No further ones are started."""
        with self._lock:
            self._stopped = True
            for process in self._processes:
                process.terminate()


def find_config(name: str, folder: Optional[str] = None) -> str:
    """Path of a shipped configuration, beside the sources or in the install space, or in the folder given."""
    above = os.path.dirname(SCRIPTS)
    shared = os.path.join(os.path.dirname(above), "share", "ratslam_ros", "config")
    places = [folder] if folder is not None else [os.path.join(above, "config"), shared]
    for place in places:
        if os.path.isfile(os.path.join(place, name)):
            return os.path.join(place, name)
    raise InputError(f"{name} was not found in {', '.join(places)}")
