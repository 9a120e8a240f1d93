#!/usr/bin/env bash
# The installed package works without the source and build trees: its setup.bash, launch files, nodes, tools and
# Python scripts drive through a small town and leave the same bytes over ROS and offline.
# Usage: install_space.sh BUILD_TREE PREFIX
set -euo pipefail
build=$1
prefix=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# Below the scratch folder, away from the source tree, in which tools would find the package twice.
DESTDIR=$scratch cmake --install "$build" >"$scratch/install.log"
prefix=$scratch$prefix
cd "$scratch"
# Nothing of the devel space may help.
export HOME=$scratch ROS_LOG_DIR=$scratch/log
unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH PYTHONPATH LD_LIBRARY_PATH PKG_CONFIG_PATH ROSLISP_PACKAGE_DIRECTORIES
set +u
[ -e /opt/ros/noetic/setup.bash ] && . /opt/ros/noetic/setup.bash
. "$prefix/setup.bash"
set -u
found=$(rospack find ratslam_ros)
[ "$found" = "$prefix/share/ratslam_ros" ] || { echo "rospack finds $found, not the install space $prefix"; exit 1; }

rosrun ratslam_ros ratslam_town --out town.bag --frames 40 --jpeg-quality 90
port=$(/usr/bin/python3 -c 'import socket; s = socket.socket(); s.bind(("", 0)); print(s.getsockname()[1])')
ROS_HOSTNAME=localhost ROS_MASTER_URI=http://localhost:$port timeout 120 roslaunch -p "$port" ratslam_ros demo.launch \
  bag:="$scratch/town.bag" odometry:=profile trajectory_file:="$scratch/nodes" rate:=4
rosrun ratslam_ros ratslam_run town.bag --config "$found/config/demo.yaml" --odometry profile --out run
cmp nodes_final.tum run/trajectory_final.tum
rosrun ratslam_ros trajectory_convert town.bag truth.tum --topic /town/ground_truth
rosrun ratslam_ros evaluate_ape truth.tum run/trajectory_final.tum -as
