#!/usr/bin/env python3
"""Every source of ours passes clang-tidy. Usage: check_tidy.py SOURCE_TREE BUILD_TREE

Most of a run is spent on the headers of OpenCV, Eigen and ROS; so sources of one folder are checked several at a time,
included into one file, and singly only where their file-local names collide. What passed is not checked again until
it, a header of ours or the configuration changes.
"""
import hashlib
import json
import os
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SOURCES_AT_ONCE = 8
COLLISIONS = ("redefinition of", "is ambiguous", "redeclared", "redeclaration")
IMPLIED_BY_BATCH = "-bugprone-suspicious-include"


def compile_flags(build):
    """Source -> its compiler flags, without compiler, launcher and output."""
    flags = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])
        first = next(i for i, word in enumerate(words) if word.startswith("-"))
        flags[Path(entry["file"]).resolve()] = tuple(words[first:words.index("-o")])
    return flags


def batches(sources, flags):
    """Sources of one folder with equal flags, a few at a time; a program's main alone."""
    groups = {}
    for path in sources:
        alone = path if "int main(" in path.read_text() else None
        groups.setdefault((path.parent, flags[path], alone), []).append(path)
    for (_, options, _), members in groups.items():
        for begin in range(0, len(members), SOURCES_AT_ONCE):
            yield options, members[begin:begin + SOURCES_AT_ONCE]


def tidy(file, checks, config, options):
    run = subprocess.run(["clang-tidy", "--quiet", f"--config-file={config}", f"--checks={checks}", str(file), "--", *options],
                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return run.returncode, run.stdout


class Checker:
    def __init__(self, source, build):
        self.config = source / ".clang-tidy"
        self.passed = build / "tidy_passed"
        self.passed.mkdir(exist_ok=True)
        shared = sorted(p for folder in ("include", "src") for p in (source / folder).rglob("*.h")) + [self.config]
        self.shared = hashlib.sha256(b"".join(p.read_bytes() for p in shared))

    def check(self, options, members):
        """What clang-tidy has to say about these sources; empty if nothing."""
        digest = self.shared.copy()
        for path in members:
            digest.update(f"{path} {options}".encode() + path.read_bytes())
        key = self.passed / digest.hexdigest()
        if key.exists():
            return ""
        if len(members) == 1:
            code, text = tidy(members[0], "", self.config, options)
        else:
            batch = self.passed / (digest.hexdigest()[:16] + ".cpp")
            batch.write_text("".join(f'#include "{path}"\n' for path in members))
            code, text = tidy(batch, IMPLIED_BY_BATCH, self.config, options)
            batch.unlink()
            if code and any(word in text for word in COLLISIONS):
                code, text = 0, "".join(self.check(options, [path]) for path in members)
                if text:
                    return text
        if code == 0:
            key.touch()
            return ""
        return text or f"clang-tidy failed on {members}\n"


def main(source, build):
    source, build = Path(source).resolve(), Path(build).resolve()
    flags = compile_flags(build)
    sources = sorted(p for p in (source / "src").rglob("*.cpp") if p in flags)
    checker = Checker(source, build)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        said = [text for text in pool.map(lambda batch: checker.check(*batch), batches(sources, flags)) if text]
    for text in said:
        print("\n".join(line for line in text.splitlines() if not line.endswith(" warnings generated.")))
    print(f"clang-tidy: {len(sources)} sources, " + ("see above" if said else "nothing to say"))
    return 1 if said else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
