#!/usr/bin/env bash
# Another CMake project finds the installed core, also where its prefix was moved, builds against it and runs.
# Usage: consumer.sh BUILD_TREE COMPILER
set -euo pipefail
build=$1
compiler=$2
source=$(cd "$(dirname "$0")" && pwd)/consumer
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

DESTDIR='' cmake --install "$build" --prefix "$scratch/first" >"$scratch/install.log"
mv "$scratch/first" "$scratch/moved"
cmake -S "$source" -B "$scratch/build" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_PREFIX_PATH="$scratch/moved" \
  >"$scratch/configure.log" || { cat "$scratch/configure.log"; exit 1; }
cmake --build "$scratch/build" >"$scratch/build.log" || { cat "$scratch/build.log"; exit 1; }
"$scratch/build/consumer"
# What is installed names no folder of the trees it came from.
found=$(grep -rlF -e "$build" -e "$(dirname "$(dirname "$(dirname "$source")")")/include" --include='*.cmake' "$scratch/moved" |
  grep /ratslam/ || true)
[ -z "$found" ] || { echo "not relocatable: $found"; exit 1; }
echo "the installed core builds and runs a consumer"
