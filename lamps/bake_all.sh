#!/usr/bin/env bash
# Bakes the generated lamps into lamps/baked, the files that the rooms take by default, and says whether they are small
# enough to be kept in the repository: 10 MB in all.
# usage: lamps/bake_all.sh [-q QUALITY] [LAMP...]      all lamps at standard quality without arguments; the build must be there
set -euo pipefail
cd "$(dirname "$0")/.."
quality=standard
if [ "${1:-}" = -q ]; then
  quality=$2
  shift 2
fi
build=${BUILD_DIR:-build/release}
limit=10000000
mkdir -p lamps/baked

options() { # what a lamp is baked with besides its quality
  case $1 in
  star_lamp) echo "--proxy $build/lamps/star_lamp/star_proxy.obj" ;;
  esac
}

lamps=("$@")
[ ${#lamps[@]} -gt 0 ] || for source in lamps/*.c; do lamps+=("$(basename "$source" .c)"); done
for lamp in "${lamps[@]}"; do
  echo "== $lamp"
  # shellcheck disable=SC2046  # the options are words
  "$build/sconce" bake "$build/lamps/$lamp/$lamp.xml" -o "lamps/baked/$lamp.safetensors" --quality "$quality" $(options "$lamp")
done
bytes=$(cat lamps/baked/*.safetensors | wc -c)
echo "lamps/baked: $bytes bytes of $limit at most"
[ "$bytes" -le "$limit" ]
