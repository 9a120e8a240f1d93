#!/usr/bin/env python3
"""Draws which room of the sources uses which, from their includes, into docs/architecture.md.

Usage: draw_rooms.py SOURCE_TREE [--write]. Without --write it exits with 1 where the picture is not that of the code.
"""
import pathlib
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*"((?:ratslam|ratslam_ros|town)/[^"]+)"', re.MULTILINE)
BEGIN = "<!-- drawn by test/style/draw_rooms.py -->\n```mermaid\n"
END = "```\n<!-- end -->\n"
# In every room's reach, so their arrows would say nothing.
EVERYWHERE = {"common", "simd"}


def room(path):
    """The room of a header or source, named from include/ or src/ on; none for files that all rooms share."""
    parts = path.split("/")
    if parts[0] == "town":
        return "town/ros" if parts[1] == "ros" else "town"
    if parts[0] in ("nodes", "tools"):
        return parts[0]
    if len(parts) < 3:
        return None
    return parts[1] if parts[0] == "ratslam" else "ros/" + parts[1]


def arrows(tree):
    """Pairs of rooms of which the first includes headers of the second."""
    found = set()
    for top in ("include", "src"):
        for path in (tree / top).rglob("*"):
            if path.suffix not in (".h", ".cpp"):
                continue
            user = room(path.relative_to(tree / top).as_posix())
            for included in INCLUDE.findall(path.read_text(encoding="utf-8")):
                used = room(included)
                if user and used and user != used and used not in EVERYWHERE:
                    found.add((user, used))
    return sorted(found)


def drawing(tree):
    def node(name):
        return name.replace("/", "_") + f'["{name}"]'

    lines = ["graph LR"] + [f"    {node(user)} --> {node(used)}" for user, used in arrows(tree)]
    return BEGIN + "\n".join(lines) + "\n" + END


def main(tree, write=False):
    document = tree / "docs" / "architecture.md"
    text = document.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    drawn = before + drawing(tree) + after
    if write:
        document.write_text(drawn, encoding="utf-8")
    elif drawn != text:
        print("docs/architecture.md draws other arrows than the code has; run test/style/draw_rooms.py . --write")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]), "--write" in sys.argv[2:]))
