#!/usr/bin/env bash
# Every C++ file of ours is as clang-format leaves it. Usage: check_format.sh SOURCE_TREE
set -euo pipefail
cd "$1"
command -v clang-format >/dev/null || { echo "clang-format is not installed"; exit 1; }
find include src test benchmark -name '*.h' -o -name '*.cpp' | sort | xargs clang-format --dry-run --Werror
echo "the format holds"
