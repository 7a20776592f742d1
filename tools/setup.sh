#!/usr/bin/env bash
# Installs the Debian packages that building and testing need, then configures and builds.
# usage: tools/setup.sh [packages|build]      packages: only what is missing, build: packages, then the release build
set -euo pipefail
cd "$(dirname "$0")/.."

packages=(gcc g++ clang cmake ninja-build pkg-config git python3 python3-venv libembree-dev libexpat1-dev libjansson-dev
          libassimp-dev libopenexr-dev libpng-dev libstb-dev zlib1g-dev libomp-dev libclang-rt-14-dev libcmocka-dev)

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
  sudo=()
  if [ "$(id -u)" != 0 ]; then
    if command -v sudo >/dev/null && sudo -n true 2>/dev/null; then sudo=(sudo); else
      echo "These Debian packages are missing; run this line as root, then start again:"
      echo "  apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
      exit 1
    fi
  fi
  echo "installing: ${missing[*]}"
  log=$(mktemp)
  { "${sudo[@]}" apt-get update -q && DEBIAN_FRONTEND=noninteractive "${sudo[@]}" apt-get install -y -q --no-install-recommends "${missing[@]}"; } \
    >"$log" 2>&1 || { tail -n 20 "$log"; exit 1; }
  rm -f "$log"
fi

[ "${1:-build}" = packages ] && exit 0
cmake --preset release >/dev/null
cmake --build --preset release
