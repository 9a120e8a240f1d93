#!/usr/bin/env bash
# Every C++ file of ours is as clang-format leaves it. Usage: check_format.sh SOURCE_TREE
# Exits with 77, "skipped", where clang-format is older than 14: versions before it align otherwise.
set -euo pipefail
cd "$1"
command -v clang-format >/dev/null || { echo "clang-format is not installed"; exit 1; }
version=$(clang-format --version | grep -oE 'version [0-9]+' | grep -oE '[0-9]+')
if [ "$version" -lt 14 ]; then
  echo "skipped: clang-format here is version $version, the format is that of 14"
  exit 77
fi
find include src test benchmark -name '*.h' -o -name '*.cpp' | sort | xargs clang-format --dry-run --Werror
echo "the format holds"
