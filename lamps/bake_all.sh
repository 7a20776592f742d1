#!/usr/bin/env bash
# Bakes the generated lamps into lamps/baked, the files that the rooms take by default, and says whether they are small
# enough to be kept in the repository: 10 MB in all.
# usage: lamps/bake_all.sh [-o FOLDER] [-q QUALITY] [LAMP...]      all lamps at standard quality unless said otherwise
set -euo pipefail
sources=$(cd "$(dirname "$0")/.." && pwd)
build=${BUILD_DIR:-$sources/build/release}
folder=$sources/lamps/baked
quality=standard
limit=10000000
while getopts o:q: option; do
  case $option in
  o) folder=$OPTARG ;;
  q) quality=$OPTARG ;;
  *) exit 2 ;;
  esac
done
shift $((OPTIND - 1))

options() { # what a lamp is baked with besides its quality
  case $1 in
  star_lamp) echo --proxy "$build/lamps/star_lamp/star_proxy.obj" ;;
  demo_lamp) echo --size small ;; # so that the sum is small enough
  esac
}

mkdir -p "$folder"
lamps=("$@")
[ ${#lamps[@]} -gt 0 ] || for source in "$sources"/lamps/*.c; do lamps+=("$(basename "$source" .c)"); done
for lamp in "${lamps[@]}"; do
  echo "== $lamp"
  # shellcheck disable=SC2046  # the options are words
  "$build/sconce" bake "$build/lamps/$lamp/$lamp.xml" -o "$folder/$lamp.safetensors" --quality "$quality" $(options "$lamp")
done
bytes=$(cat "$folder"/*.safetensors | wc -c)
echo "$folder: $bytes bytes of $limit at most"
[ "$bytes" -le "$limit" ]
