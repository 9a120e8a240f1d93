#!/usr/bin/env python3
"""What README, docs and comments name exists: paths, parameters, topics, options and symbols.

Usage: check_documents.py SOURCE_TREE. Lists each name that is nowhere in the code and exits with 1 if there is any.

In documents, names are what stands in backticks, in indented or fenced commands, and in links. In comments, they are
names of files, names in backticks and names such as Class::member. A name exists where a file has that path (also
below one of the roots that documents leave out), or where the code, its comments left out, has all its words.
"""
import pathlib
import re
import subprocess
import sys

# Documents say pose_cells/attractor for include/ratslam/pose_cells/attractor.h and its source.
ROOTS = ("", "include/", "include/ratslam/", "src/ratslam/", "include/ratslam_ros/", "src/ratslam_ros/", "src/",
         "scripts/", "scripts/ratslam_tools/", "docs/", "config/", "test/", "test/unit/", "launch/")
ENDINGS = ("", ".h", ".cpp", ".py", ".md")
FILE_NAME = re.compile(r"(?<![\w./*<>{}$-])((?:[\w.-]+/)*[\w-]+\.(?:h|cpp|py|md|sh|yaml|launch|msg|rviz))(?![\w/*-])")
BACKTICKS = re.compile(r"`([^`\n]+)`")
LINK = re.compile(r"\]\(([^)#\s]+)(#[^)]*)?\)")
OPTION = re.compile(r"(?<![\w-])--([a-z][a-z0-9_-]+)")
MEMBER = re.compile(r"\b([A-Z]\w+)::(\w+)")
WORD = re.compile(r"[A-Za-z_]\w*")
NAME = re.compile(r"[A-Za-z_~][\w/.:~-]*(\(\))?")
CODE = {".h", ".cpp", ".py", ".msg", ".launch", ".yaml", ".test", ".xml", ".cmake", ".txt", ".sh", ".rviz", ".in", ""}

# Stand for what a user or a run puts in their place.
PLACEHOLDER = re.compile(r"FILE|NN|DIR|<\w+>")
# Names of others' programs, formats, libraries and files, which the code need not have.
ELSEWHERE = set("""
    apt bool false true std cmake git gdb perf evo evo_ape evo_rpe rosbag rostopic rosrun roslaunch rviz catkin_make
    hz reindex play clock PATH HOME ROS_HOSTNAME ROS_MASTER_URI use_sim_time setup.bash GCC Clang OpenCV Eigen ORB
    vdbpsadbw vpshrdq catkin_make_isolated chrony sbatch ROS_IP cameracalibrator.py cv2.calibrateCamera E_i yy-MM-dd yy-MM-dd-HH-mm-ss kitti_map.yaml
    """.split())
OPTIONS_ELSEWHERE = set("""
    save-map ros-args clock build install preset target prefix parallel output-on-failure recursive version
    """.split())


# Documents of formats, whose names are put together of a part's and a field's: pose_x.
COMPOSED = {"docs/map_file.md"}


def tracked(tree):
    listing = subprocess.run(["git", "-C", str(tree), "ls-files", "--cached", "--others", "--exclude-standard"],
                             stdout=subprocess.PIPE, text=True, check=True).stdout
    return [name for name in listing.splitlines() if (tree / name).is_file()]


def is_code(name):
    path = pathlib.PurePath(name)
    return path.suffix in CODE and not name.startswith(("test/data", "test/fuzz/corpus", "docs/")) and path.name != "LICENSE"


def comment_of(line, name):
    """The comment at the end of a line of code, or an empty text."""
    mark = "//" if name.endswith((".h", ".cpp")) else "#"
    match = re.search(r"(?:^|\s)" + mark + r"(?!include|define|if|else|endif|pragma|undef|error)(.*)", line)
    return match.group(1) if match else ""


class Code:
    """What there is: files, and the words of all code."""

    def __init__(self, tree):
        self.tree = tree
        self.files = tracked(tree)
        self.paths = set(self.files)
        self.folders = {str(parent) for name in self.files for parent in pathlib.PurePath(name).parents}
        self.base_names = {pathlib.PurePath(name).name for name in self.files}
        self.words = set()
        self.text = []
        for name in filter(is_code, self.files):
            content = (tree / name).read_text(encoding="utf-8", errors="replace")
            for line in content.splitlines():
                comment = comment_of(line, name)
                code = line[:len(line) - len(comment)] if comment else line
                self.words.update(WORD.findall(code))
                self.text.append(code)
            self.words.update(WORD.findall(name))
        self.text = "\n".join(self.text)

    def has_path(self, path, beside=""):
        path = path.rstrip("/")
        for root in ROOTS + (beside,):
            for ending in ENDINGS:
                if root + path + ending in self.paths or root + path in self.folders:
                    return True
        return False

    def has_file(self, name):
        """A path, the end of one, or a file that the code itself speaks of."""
        if PLACEHOLDER.search(name) or name.split("/")[0].endswith("_msgs") or pathlib.PurePath(name).name in ELSEWHERE:
            return True
        return (self.has_path(name) or name in self.base_names or name in self.text
                or any(path.endswith("/" + name) for path in self.paths))

    def has_composed(self, name):
        parts = name.split("_")
        return name in self.words or any(
            "_".join(parts[:i]) in self.words and self.has_composed("_".join(parts[i:])) for i in range(1, len(parts)))

    def has_name(self, name):
        if self.has_path(name) or name in self.text or name in ELSEWHERE or PLACEHOLDER.search(name):
            return True
        return all(word in self.words or word in ELSEWHERE for word in WORD.findall(name))


def names_in_backticks(text):
    for quoted in BACKTICKS.findall(text):
        # Of a command or a key with its value, the first word says what it is.
        first = quoted.split()[0].rstrip(":,;") if quoted.split() else ""
        if NAME.fullmatch(first) and len(first) > 2:
            yield first.rstrip("()").lstrip("~")


def complaints_of_document(code, name):
    folder = str(pathlib.PurePath(name).parent)
    beside = "" if folder == "." else folder + "/"
    fenced = False
    for number, line in enumerate((code.tree / name).read_text(encoding="utf-8").splitlines(), 1):
        if line.startswith("```"):
            fenced = not fenced
        where = f"{name}:{number}: "
        for link, _ in LINK.findall(line):
            if "://" not in link and not code.has_path(link, beside):
                yield where + f"links to {link}, which is not there"
        if fenced or line.startswith("    "):
            for script in re.findall(r"(?<![\w./])(scripts/\w+|config/[\w/.-]+|launch/[\w.]+)", line):
                if not code.has_path(script.rstrip(".")):
                    yield where + f"{script} is not there"
        for option in OPTION.findall(line):
            if option not in OPTIONS_ELSEWHERE and not re.search(r"\b" + re.escape(option) + r"\b", code.text):
                yield where + f"no program has an option --{option}"
        for quoted in names_in_backticks(line):
            if not (code.has_name(quoted) or (name in COMPOSED and code.has_composed(quoted))):
                yield where + f"`{quoted}` is nowhere in the code"
        for file_name in FILE_NAME.findall(line):
            # An example in a fence makes up files of its own.
            if not fenced and "://" not in line and not code.has_file(file_name):
                yield where + f"{file_name} is not there"


def complaints_of_comments(code, name):
    for number, line in enumerate((code.tree / name).read_text(encoding="utf-8").splitlines(), 1):
        comment = comment_of(line, name)
        where = f"{name}:{number}: "
        for file_name in FILE_NAME.findall(comment):
            if not code.has_file(file_name):
                yield where + f"names {file_name}, which is not there"
        for owner, member in MEMBER.findall(comment):
            if owner in code.words and member not in code.words:
                yield where + f"names {owner}::{member}, which is nowhere in the code"
        for quoted in names_in_backticks(comment):
            if not code.has_name(quoted):
                yield where + f"`{quoted}` is nowhere in the code"


def complaints(tree):
    """Yields a line of text for each name that is nowhere."""
    code = Code(tree)
    for name in code.files:
        if name.endswith((".md", ".rst")):
            yield from complaints_of_document(code, name)
        elif is_code(name) and not name.endswith((".rviz", ".txt")):
            yield from complaints_of_comments(code, name)


def main():
    found = list(complaints(pathlib.Path(sys.argv[1]).resolve()))
    print("\n".join(found) if found else "documents and comments name what there is")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
