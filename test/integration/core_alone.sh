#!/usr/bin/env bash
# The core builds without ROS: library, runner, town and unit tests. Its runner leaves the same bytes over a folder as
# the one with ROS does, and links nothing of ROS.
# Usage: core_alone.sh BUILD_TREE RATSLAM_RUN COMPILER [COMPILER_LAUNCHER]
set -euo pipefail
build=$1/core_alone
run_with_ros=$2
source=$(cd "$(dirname "$0")/../.." && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# As on a machine that has no package of ROS.
cmake -S "$source" -B "$build" -DRATSLAM_ROS=OFF -DCMAKE_DISABLE_FIND_PACKAGE_catkin=ON -DCMAKE_CXX_COMPILER="$3" \
  -DCMAKE_CXX_COMPILER_LAUNCHER="${4:-}" >"$scratch/configure.log" || { cat "$scratch/configure.log"; exit 1; }
cmake --build "$build" -j"$(nproc)" >"$scratch/build.log" 2>&1 || { tail -n 60 "$scratch/build.log"; exit 1; }
for tool in ratslam_run ratslam_town; do
  # by their names, since the folder of the sources may be called ratslam_ros
  linked=$(ldd "$build/$tool" | awk '{ print $1 }')
  ! grep -E 'ros|cpp_common|tf2' <<<"$linked" || { echo "$tool links libraries of ROS"; exit 1; }
done

cmake --install "$build" --prefix "$scratch/installed" >/dev/null
for tool in ratslam_run ratslam_map ratslam_places ratslam_town; do
  "$scratch/installed/bin/$tool" --help >/dev/null || { echo "$tool is not installed, or does not find its library"; exit 1; }
done

cd "$scratch"
"$build/ratslam_town" --out town --frames 40
for run in "$build/ratslam_run" "$run_with_ros"; do
  n=$((${n:-0} + 1))
  "$run" town --config "$source/config/demo.yaml" --odometry profile --out "out_$n"
done
cmp out_1/trajectory_final.tum out_2/trajectory_final.tum
! "$build/ratslam_run" drive.bag --config "$source/config/demo.yaml" --out refused 2>said ||
  { echo "a bag that is not there was accepted"; exit 1; }
touch drive.bag
! "$build/ratslam_run" drive.bag --config "$source/config/demo.yaml" --out refused 2>said ||
  { echo "a bag was accepted"; exit 1; }
grep -q "built without ROS" said
echo "the core stands alone"
