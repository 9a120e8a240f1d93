#!/usr/bin/env bash
# Two machines, as two network namespaces: camera, local view and odometry on one, pose cells and map on the other. The map
# is the same to the last byte as on one machine, and images do not cross the network.
# Usage: two_machines.sh SOURCE_TREE DEVEL_SPACE      (77: skipped, for want of root or of network namespaces)
set -euo pipefail
source=$1
devel=$2
id=$$
camera=camera_$id
rest=rest_$id
if [ "$(id -u)" -ne 0 ] || ! command -v ip >/dev/null || ! ip netns add "$camera" 2>/dev/null; then
  echo "skipped: network namespaces need root and ip (package iproute2)"
  exit 77
fi
scratch=$(mktemp -d)
pids=()
clean() {
  kill -INT "${pids[@]}" 2>/dev/null || true
  sleep 1
  kill -KILL "${pids[@]}" 2>/dev/null || true
  ip netns del "$camera" || true
  ip netns del "$rest" 2>/dev/null || true
  rm -rf "$scratch"
}
trap clean EXIT
ip netns add "$rest"
ip link add "va$id" type veth peer name "vb$id"
ip link set "va$id" netns "$camera"
ip link set "vb$id" netns "$rest"
ip -n "$camera" addr add 10.77.0.1/24 dev "va$id"
ip -n "$rest" addr add 10.77.0.2/24 dev "vb$id"
for name in "$camera" "$rest"; do ip -n "$name" link set lo up; done
ip -n "$camera" link set "va$id" up
ip -n "$rest" link set "vb$id" up

set +u
[ -e /opt/ros/noetic/setup.bash ] && . /opt/ros/noetic/setup.bash
. "$devel/setup.bash"
set -u
export ROS_HOME=$scratch ROS_MASTER_URI=http://10.77.0.1:11311 PYTHONDONTWRITEBYTECODE=1
unset ROS_HOSTNAME
on() {  # MACHINE COMMAND ...: in the background
  local address=10.77.0.1
  [ "$1" = "$rest" ] && address=10.77.0.2
  ip netns exec "$1" env ROS_IP=$address "${@:2}" &
  pids+=($!)
}
crossed() { ip netns exec "$camera" cat "/sys/class/net/va$id/statistics/tx_bytes" "/sys/class/net/va$id/statistics/rx_bytes" |
  awk '{sum += $1} END {print sum}'; }

/usr/bin/python3 - "$source" "$scratch" <<'EOF'
import os, sys
sys.path.insert(0, os.path.join(sys.argv[1], "test", "integration"))
import harness
harness.write_bag(os.path.join(sys.argv[2], "drive.bag"), "/drive", 110, size=(640, 240))
harness.write_config(os.path.join(sys.argv[2], "config.yaml"))
EOF

cd "$scratch"
on "$camera" roscore >roscore.log 2>&1
for _ in $(seq 50); do ip netns exec "$camera" rosparam list >/dev/null 2>&1 && break; sleep 0.2; done
on "$rest" rosrun ratslam_ros ratslam_em config.yaml _topic_root:=drive _trajectory_file:="$scratch/nodes"
map=${pids[-1]}
on "$rest" rosrun ratslam_ros ratslam_pc config.yaml _topic_root:=drive _wait_for_subscribers:=1
on "$camera" rosrun ratslam_ros ratslam_lv config.yaml _topic_root:=drive _image_queue_size:=0 _wait_for_subscribers:=1
on "$camera" rosrun ratslam_ros ratslam_vo config.yaml _topic_root:=drive _image_queue_size:=0 _wait_for_subscribers:=2
sleep 3
before=$(crossed)
ROS_IP=10.77.0.1 timeout 120 ip netns exec "$camera" rosrun ratslam_ros playback drive.bag --rate 4 \
  --image-topic drive/camera/image --pose-topic drive/ExperienceMap/RobotPose --expect drive/camera/image=2
bytes=$(($(crossed) - before))
# The signal goes to the node, which is what `ip netns exec` and rosrun have become.
kill -INT "$map"
for _ in $(seq 100); do [ -s nodes_final.tum ] && [ -s nodes_map.yaml ] && break; sleep 0.1; done
sleep 0.5

images=$(stat -c %s drive.bag)
echo "the camera's machine saw $((images / 1000)) kB of images; $((bytes / 1000)) kB crossed the network, $((bytes / 110)) bytes an image"
rosrun ratslam_ros ratslam_run drive.bag --config config.yaml --out run >/dev/null
cmp nodes_final.tum run/trajectory_final.tum
cmp nodes_online.tum run/trajectory_online.tum
[ "$bytes" -lt $((images / 10)) ] || { echo "that is more than a tenth of the images"; exit 1; }
