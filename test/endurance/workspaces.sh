#!/usr/bin/env bash
# The package in a fresh catkin workspace, by each tool that builds one: catkin_make, catkin_make_isolated, catkin build. After
# each, the workspace's setup.bash is all that is needed: programs, scripts, the Python module and a launch file work.
# Usage: workspaces.sh SOURCE_TREE WORKSPACE [TOOL ...]      WORKSPACE is made, and made anew for each tool. If it lies within
# SOURCE_TREE, its name must begin with a dot: else roslaunch finds each launch file of the package twice (CATKIN_IGNORE does not
# keep it from that).
set -euo pipefail
source=$1
workspace=$2
tools=("${@:3}")
[ "${#tools[@]}" -gt 0 ] || tools=(catkin_make catkin_make_isolated catkin_build)
case "/$(realpath -m --relative-to="$source" "$workspace")" in
  */.*) ;;  # hidden, or outside (../)
  *) echo "$workspace: within $source a workspace's name must begin with a dot" >&2; exit 1 ;;
esac
[ ! -e "$workspace" ] || { echo "$workspace: there is something already; a folder that does not exist is needed" >&2; exit 1; }
trap 'rm -rf "$workspace"' EXIT

unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH PYTHONPATH LD_LIBRARY_PATH PKG_CONFIG_PATH ROSLISP_PACKAGE_DIRECTORIES
set +u
[ -e /opt/ros/noetic/setup.bash ] && . /opt/ros/noetic/setup.bash
set -u
options=(-DPYTHON_EXECUTABLE=/usr/bin/python3 -DPython3_EXECUTABLE=/usr/bin/python3 -DRATSLAM_TESTS=OFF)
# The tools build in other folders, but the sources are compiled once.
command -v ccache >/dev/null && options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
export CCACHE_BASEDIR=$workspace CCACHE_NOHASHDIR=1

build() {  # TOOL CMAKE_OPTION ...; called by strictly
  cd "$workspace"
  case "$1" in
    catkin_make) catkin_make "${@:2}" ;;
    catkin_make_isolated) catkin_make_isolated --cmake-args "${@:2}" ;;
    catkin_build) catkin build --no-status --cmake-args "${@:2}" ;;
    *) echo "tools are catkin_make, catkin_make_isolated and catkin_build" >&2; return 2 ;;
  esac
}

try() {  # SETUP.BASH; called by strictly
  set +u
  . "$1"
  set -u
  mkdir "$workspace/try"
  cd "$workspace/try"
  found=$(rospack find ratslam_ros)
  [ "$found" = "$workspace/src/ratslam_ros" ] || { echo "rospack finds $found"; return 1; }
  rosrun ratslam_ros ratslam_town --out town.bag --frames 40 --jpeg-quality 90
  port=$(/usr/bin/python3 -c 'import socket; s = socket.socket(); s.bind(("", 0)); print(s.getsockname()[1])')
  ROS_HOSTNAME=localhost ROS_MASTER_URI=http://localhost:$port ROS_LOG_DIR=$workspace/try/log timeout 120 \
    roslaunch -p "$port" ratslam_ros demo.launch bag:=town.bag odometry:=profile trajectory_file:="$PWD/nodes" rate:=4
  rosrun ratslam_ros ratslam_run town.bag --config "$found/config/demo.yaml" --odometry profile --out run
  cmp nodes_final.tum run/trajectory_final.tum
  trajectory_convert town.bag truth.tum --topic /town/ground_truth
  evaluate_ape truth.tum run/trajectory_final.tum -as
  /usr/bin/python3 -c 'import ratslam, ratslam.tools; print(ratslam.PoseCellNetwork(pc_dim_xy=11).activity.shape)'
}

# A function in a condition, such as `if try ...`, runs on after a command that fails, in a subshell as well, whatever `set -e` says.
strictly() {  # FUNCTION ARGUMENT ...: in a process of its own, which ends with the first command that fails
  bash -euo pipefail -c '"$@"' strictly "$@"
}
export -f build try
export workspace

failed=()
for tool in "${tools[@]}"; do
  if ! command -v "${tool%_build}" >/dev/null; then
    echo "$tool: skipped, it is not installed"
    continue
  fi
  rm -rf "$workspace"
  mkdir -p "$workspace/src/ratslam_ros"
  git -C "$source" ls-files -z --cached --others --exclude-standard | tar -C "$source" --null --files-from=- -c |
    tar -C "$workspace/src/ratslam_ros" -x
  log=$workspace/log.txt
  devel=$workspace/devel
  [ "$tool" = catkin_make_isolated ] && devel=$workspace/devel_isolated
  if strictly build "$tool" "${options[@]}" >"$log" 2>&1 && strictly try "$devel/setup.bash" >>"$log" 2>&1; then
    echo "$tool: built and tried in $devel"
  else
    tail -n 40 "$log"
    echo "$tool: FAILED"
    failed+=("$tool")
  fi
done
[ "${#failed[@]}" -eq 0 ]
