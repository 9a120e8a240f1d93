"""ini_to_yaml: an OpenRatSLAM configuration (.txt, ini form) as our flat YAML."""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from typing import Dict, List, Optional, Set, Tuple

from ratslam_tools import text_file
from ratslam_tools.errors import InputError
from ratslam_tools.runs import runner

GENERAL = ("topic_root",)
RATSLAM = (
    "image_crop_x_min",
    "image_crop_x_max",
    "image_crop_y_min",
    "image_crop_y_max",
    "template_x_size",
    "template_y_size",
    "vt_match_threshold",
    "vt_shift_match",
    "vt_step_match",
    "vt_normalisation",
    "vt_patch_normalise",
    "vt_min_patch_normalisation_std",
    "vt_panoramic",
    "vt_active_decay",
    "pc_dim_xy",
    "pc_dim_th",
    "pc_w_e_dim",
    "pc_w_i_dim",
    "pc_w_e_var",
    "pc_w_i_var",
    "pc_global_inhib",
    "pc_vt_inject_energy",
    "pc_vt_restore",
    "pc_cell_x_size",
    "exp_delta_pc_threshold",
    "exp_correction",
    "exp_loops",
    "exp_initial_em_deg",
)
VISUAL_ODOMETRY = tuple(
    f"{kind}_image_{axis}_{end}" for kind in ("vtrans", "vrot") for axis in "xy" for end in ("min", "max")
) + ("camera_fov_deg", "camera_hz", "vtrans_scaling", "vtrans_max")
SECTIONS = {"general": GENERAL, "ratslam": RATSLAM, "visual_odometry": VISUAL_ODOMETRY}
TRUTH_VALUES = ("vt_panoramic",)  # all others of OpenRatSLAM's are numbers
# The booleans of YAML 1.1, and so of rosparam and ratslam_run; each also with a capital, or in capitals.
TRUTHS = {"true": "true", "yes": "true", "on": "true", "1": "true", "false": "false", "no": "false", "off": "false", "0": "false"}
COMMENT = re.compile(r"[ \t][#;]")  # behind a value
IGNORED_SECTIONS = ("draw",)
# Values that OpenRatSLAM's configurations imply.
REFERENCE_ARITHMETIC = {"exp_solver": "relaxation", "pc_openratslam_injection": "true"}
TITLES = {
    "general": "all nodes",
    "ratslam": "local view, pose cells, experience map",
    "visual_odometry": "profile odometry",
}


def our_keys() -> Set[str]:
    """Keys that ratslam_run knows; without a built ratslam_run only those of the reference arithmetic."""
    try:
        listed = subprocess.run(
            [runner.find(), "--list-parameters"],
            stdout=subprocess.PIPE,
            universal_newlines=True,
            check=True,
        ).stdout
    except (InputError, OSError, subprocess.CalledProcessError):
        return set(REFERENCE_ARITHMETIC)
    return set(re.findall(r"^\| `(\w+)` \|", listed, re.MULTILINE))


def objection(configuration: str) -> Optional[Tuple[str, str]]:
    """The first value of a configuration (YAML text) that ratslam_run refuses: (parameter, message), or None.
    @throws InputError if there is no ratslam_run.
    """
    with tempfile.TemporaryDirectory() as folder:
        config = os.path.join(folder, "config.yaml")
        with open(config, "w", encoding="utf-8", errors="surrogateescape") as file:
            file.write(configuration)
        found = runner.objection(runner.find(), config)
    return (found[0], re.sub(rf" \(from {re.escape(config)}:\d+\)", "", found[1])) if found else None


def truth_value(text: str) -> str:
    """A boolean of YAML 1.1 as `true` or `false`. @throws ValueError for any other text."""
    if text not in (text.lower(), text.capitalize(), text.upper()) or text.lower() not in TRUTHS:
        raise ValueError(f"'{text_file.shown(text)}' is not true or false")
    return TRUTHS[text.lower()]


def yaml_value(text: str) -> str:
    """A value as YAML: numbers and truth values as they are, words in quotes. Zeros before a number are left out, because
    some readers of YAML take such a number for octal."""
    try:
        text_file.finite_number(text)
    except ValueError:
        return text if text in ("true", "false") else json.dumps(text)
    return re.sub(r"^([+-]?)0+(?=[0-9])", r"\1", text)


def read_ini(path: str) -> Dict[str, Dict[str, Tuple[int, str]]]:
    """Sections of an ini file, each with line number and value of its keys, as ratslam_run reads them. @throws InputError
    naming a line that is neither `key=value` nor `[section]`, or a section or key that is given twice.
    """
    sections: Dict[str, Dict[str, Tuple[int, str]]] = {}
    entries: Optional[Dict[str, Tuple[int, str]]] = None
    for number, line in text_file.read_lines(path):
        if line[0] in "#;":
            continue
        shown = text_file.shown(line)
        if line[0] == "[":
            name, end, _ = line[1:].partition("]")
            name = name.strip()
            if not end:
                raise InputError(f"{path}:{number}: not a line of an ini file: '{shown}' lacks its ]")
            if name in sections:
                raise InputError(f"{path}:{number}: section [{text_file.shown(name)}] is given twice")
            entries = sections[name] = {}
            continue
        key, equals, value = (part.strip() for part in line.partition("="))
        if not equals or not key:
            raise InputError(f"{path}:{number}: not a line of an ini file, which is key=value or [section]: '{shown}'")
        if entries is None:
            raise InputError(f"{path}:{number}: '{shown}' stands before any section, such as [ratslam]")
        if key in entries:
            raise InputError(f"{path}:{number}: {text_file.shown(key)} is given twice")
        entries[key] = number, COMMENT.split(value, 1)[0].strip()
    return sections


def convert(path: str):
    """(YAML text, remarks on ignored keys). @throws InputError naming a key whose value is of another type.
    """
    sections = read_ini(path)
    ours = our_keys()
    lines, remarks, seen = [], [], set()
    for section in sections:
        if section in IGNORED_SECTIONS:
            remarks.append(f"[{section}] is left out: rviz draws")
        elif section not in SECTIONS:
            remarks.append(f"[{text_file.shown(section)}] is unknown and left out")
    for section, known in SECTIONS.items():
        if section not in sections:
            continue
        lines.append(f"# {TITLES[section]}")
        for key, (number, value) in sections[section].items():
            name = runner.parameter(key)
            if name not in known and name not in ours:
                remarks.append(f"[{section}] {text_file.shown(key)} is unknown and left out")
                continue
            if name in seen:
                raise InputError(f"{path}:{number}: {name} is given twice")
            seen.add(name)
            if name in known and name not in GENERAL:
                try:
                    if name in TRUTH_VALUES:
                        value = truth_value(value)
                    else:
                        text_file.finite_number(value)
                except ValueError as error:
                    raise InputError(f"{path}:{number}: [{section}] {key}: {error}") from None
            lines.append(f"{name}: {json.dumps(value) if name in GENERAL else yaml_value(value)}")
    if not seen:
        raise InputError(
            f"{path}: none of the sections {', '.join(f'[{name}]' for name in SECTIONS)} has a known key"
        )
    implied = [f"{key}: {value}" for key, value in REFERENCE_ARITHMETIC.items() if key not in seen]
    if implied:
        lines += ["# OpenRatSLAM's arithmetic, which its configurations need not name", *implied]
        remarks.append(f"added, since an OpenRatSLAM configuration implies its arithmetic: {', '.join(implied)}")
    return "\n".join(lines) + "\n", remarks


def judge(path: str, configuration: str) -> List[str]:
    """Checks with ratslam_run the configuration (YAML text) made from the file `path`. Returns remarks. @throws InputError if
    ratslam_run refuses one of its values."""
    try:
        found = objection(configuration)
    except InputError:
        return [f"no {runner.PROGRAM} was found, so the values' ranges are not checked"]
    if found is None:
        return []
    name, message = found
    if re.search(rf"^{name}: ", configuration, re.MULTILINE):
        raise InputError(f"{path}: {message}")
    return [f"{runner.PROGRAM} refuses it without more: {message}"]


def main(argv=None) -> None:
    """ini_to_yaml."""
    parser = argparse.ArgumentParser(
        prog="ini_to_yaml",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Turns an OpenRatSLAM configuration into YAML for these nodes and ratslam_run. What it "
        "leaves out it "
        "reports on stderr. A value out of its range is refused, if ratslam_run is built.",
        epilog="examples:\n  ini_to_yaml config_stlucia.txt stlucia.yaml\n  ini_to_yaml config_stlucia.txt "
        "--strict",
    )
    parser.add_argument("ini", help="OpenRatSLAM configuration")
    parser.add_argument("yaml", nargs="?", help="file to write (default: stdout)")
    parser.add_argument("--strict", action="store_true", help="an unknown key is an error")
    arguments = parser.parse_args(argv)
    text_file.require_other("yaml", arguments.yaml, [arguments.ini])
    text, remarks = convert(arguments.ini)
    unknown = [remark for remark in remarks if "unknown" in remark]
    if arguments.strict and unknown:
        raise InputError(f"{arguments.ini}: {unknown[0]}")
    for remark in remarks + judge(arguments.ini, text):
        print(f"note: {remark}", file=sys.stderr)
    if arguments.yaml is None:
        sys.stdout.write(text)
        return
    with text_file.writing(arguments.yaml) as file:
        file.write(text)
