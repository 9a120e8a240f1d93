#!/usr/bin/env python3
"""No file has grown past what one reads at a sitting. Usage: check_sizes.py SOURCE_TREE

Sources, scripts and tests have at most 400 lines; those of nodes 150,
blank ones and what they include not counted.
"""
import pathlib
import sys

MOST_LINES = 400
MOST_LINES_OF_A_NODE = 150
ENDINGS = {".h", ".cpp", ".py", ".cmake", ".sh"}


def complaints(tree):
    """Yields a line of text for each file that is too long."""
    for folder in ("include", "src", "test", "scripts", "benchmark", "cmake"):
        for path in sorted((tree / folder).rglob("*")):
            if not path.is_file() or (path.suffix not in ENDINGS and folder != "scripts") or path.suffix == ".pyc":
                continue
            of_node = "ratslam_ros/nodes" in path.as_posix()
            lines = [line.strip() for line in path.read_text(encoding="utf-8", errors="replace").splitlines()]
            if of_node:
                lines = [line for line in lines if line and not line.startswith("#include")]
            lines = len(lines)
            most = MOST_LINES_OF_A_NODE if of_node else MOST_LINES
            if lines > most:
                yield f"{path.relative_to(tree)}: {lines} lines; it may have {most}"


def main():
    found = list(complaints(pathlib.Path(sys.argv[1])))
    print("\n".join(found) if found else "no file is too long")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
