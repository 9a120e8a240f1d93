#!/usr/bin/env bash
# Every source of ours passes clang-tidy. Usage: check_tidy.sh SOURCE_TREE BUILD_TREE
# A file that passed is not checked again until it, a header of ours or the configuration changes.
set -euo pipefail
source_tree=$1
build_tree=$2
cd "$source_tree"
command -v clang-tidy >/dev/null || { echo "clang-tidy is not installed"; exit 1; }
cache=$build_tree/tidy_passed
mkdir -p "$cache"
headers=$(find include test -name '*.h' | sort | xargs cat .clang-tidy | sha256sum | cut -c1-16)

check() {
  local file=$1 key
  key=$(cat "$file" <(echo "$file $headers") | sha256sum | cut -c1-32)
  [ -e "$cache/$key" ] && return 0
  if clang-tidy --quiet -p "$build_tree" "$file" 2>/dev/null; then touch "$cache/$key"; else echo "failed: $file"; return 1; fi
}
export -f check
export cache headers build_tree
find src -name '*.cpp' | sort | xargs -P "$(nproc)" -I{} bash -c 'check {}'
echo "clang-tidy has nothing to say"
