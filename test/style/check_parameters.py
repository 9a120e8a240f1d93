#!/usr/bin/env python3
"""docs/parameters.md has the table of keys that the program prints. Usage: check_parameters.py RATSLAM_RUN DOCUMENT"""
import subprocess
import sys
from pathlib import Path


def main(runner, document):
    printed = subprocess.run([runner, "--list-parameters"], stdout=subprocess.PIPE, text=True, check=True).stdout
    if printed.count("\n") < 3:
        print(f"{runner} --list-parameters prints no table:\n{printed}")
        return 1
    if printed.strip() in Path(document).read_text():
        return 0
    known = set(Path(document).read_text().splitlines())
    print(f"{document} differs from {runner} --list-parameters; the program's lines it lacks:")
    print("\n".join(line for line in printed.splitlines() if line not in known) or "(none: lines are too many or in another order)")
    return 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
