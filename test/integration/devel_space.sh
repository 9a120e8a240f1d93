#!/usr/bin/env bash
# After `. devel/setup.bash`, rosrun finds every program and script of the package, each once, and tools and scripts are on PATH.
# Usage: devel_space.sh SOURCE_TREE
set -euo pipefail
cd "$1"
unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH PYTHONPATH LD_LIBRARY_PATH PKG_CONFIG_PATH ROSLISP_PACKAGE_DIRECTORIES
set +u
[ -e /opt/ros/noetic/setup.bash ] && . /opt/ros/noetic/setup.bash
. devel/setup.bash
set -u
cd /
programs=$(find "$1/devel/lib/ratslam_ros" -type f -perm /111 -printf '%f\n')
scripts=$(grep -lE -d skip '^#!.*python3' "$1"/scripts/* | xargs -n1 basename)
bad=0
for name in $programs $scripts; do
  # rosrun asks for a choice if it finds two; stdin is empty, so it fails.
  found=$(rosrun --prefix 'echo found' ratslam_ros "$name" </dev/null 2>&1) || true
  case "$found" in
    "found "*/"$name") ;;
    *) echo "rosrun ratslam_ros $name: $found"; bad=1 ;;
  esac
done
for name in $scripts; do
  [ "$(readlink -f "$(command -v "$name")")" = "$1/scripts/$name" ] || { echo "$name is not on PATH"; bad=1; }
done
for name in ratslam_run ratslam_map ratslam_places ratslam_town; do
  [ "$(readlink -f "$(command -v "$name")")" = "$1/devel/lib/ratslam_ros/$name" ] || { echo "$name is not on PATH"; bad=1; }
done
exit $bad
