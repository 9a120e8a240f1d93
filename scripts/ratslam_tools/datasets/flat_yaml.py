"""Reading of YAML configurations and calibrations. Scalars are kept as their text in the file."""

import re
from typing import Any, Dict

import yaml

from ratslam_tools import text_file
from ratslam_tools.errors import InputError, one_line


_TABS = re.compile(r"^([ ]*[A-Za-z_][A-Za-z0-9_]*:)[ \t]*\t[ \t]*", re.MULTILINE)


class _Loader(yaml.BaseLoader):
    """Reads every scalar as text. A key that is given twice is an error; yaml.BaseLoader would take the last value."""

    def construct_mapping(self, node, deep=False):
        """The dict of a mapping node. @throws yaml.constructor.ConstructorError naming a key that is given twice, or is no
        single word."""
        if not isinstance(node, yaml.MappingNode):
            return super().construct_mapping(node, deep)
        seen = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise yaml.constructor.ConstructorError(None, None, "a key is no single word", key.start_mark)
            if key.value in seen:
                raise yaml.constructor.ConstructorError(None, None, f"{key.value} is given twice", key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep)


def load(path: str) -> Dict[str, Any]:
    """The nested mapping in a file, with every scalar as text. OpenCV's `%YAML:1.0` and its tags are ignored. @throws
    InputError naming line and reason.
    """
    text = text_file.read_text(path)
    if text.startswith("%YAML:"):
        text = "#" + text.replace("!!opencv-matrix", "")
    text = _TABS.sub(r"\1 ", text)  # ratslam_run's parser takes them
    try:
        value = yaml.load(text, _Loader)  # scalars, lists and mappings alone: nothing is constructed from tags
    except yaml.MarkedYAMLError as error:
        line = f":{error.problem_mark.line + 1}" if error.problem_mark else ""
        raise InputError(f"{path}{line}: {one_line(error.problem or error.context or 'not YAML')}") from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: not YAML: {one_line(error)[:100]}") from None
    if value is None or value == "":
        return {}
    if not isinstance(value, dict):
        raise InputError(f"{path}: not of the form 'key: value', a line each")
    return value


def read(path: str) -> Dict[str, str]:
    """Keys and values of a flat file, values as text. @throws InputError naming a key whose value is a list or a mapping, and
    as load()."""
    values = load(path)
    for key, value in values.items():
        if not isinstance(value, str):
            raise InputError(f"{path}: {key}: a single value is expected")
    return values
