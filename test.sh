#!/usr/bin/env bash
# Every test: sets the machine up (tools/setup.sh), then the release build's tests (unit, statistical, command line, and
# against independent programs from PyPI), the same under address and undefined-behaviour sanitizers, and short fuzzing.
set -uo pipefail
cd "$(dirname "$0")"
tools/setup.sh packages || exit 1
mkdir -p build
log=build/test.log
: >"$log"
passed=0 failed=0

count() { # counts "N tests failed out of M" of a ctest run
  local line
  line=$(grep -E 'tests? failed out of [0-9]+' "$1" | tail -n 1)
  local bad all
  bad=$(sed -E 's/.*, ([0-9]+) tests? failed out of.*/\1/' <<<"$line")
  all=$(sed -E 's/.*out of ([0-9]+).*/\1/' <<<"$line")
  [ -n "$line" ] || { bad=1 all=1; }
  failed=$((failed + bad)) passed=$((passed + all - bad))
}

build() { # a failed build is a failed test
  echo "== build: $1"
  if cmake --preset "$1" >>"$log" 2>&1 && cmake --build --preset "$1" >>"$log" 2>&1; then return 0; fi
  tail -n 40 "$log"
  failed=$((failed + 1))
  return 1
}

suite() {
  echo "== tests: $1"
  ctest --preset "$1" 2>&1 | tee build/suite.log
  count build/suite.log
}

# The independent programs (Mitsuba 3, LuxCore, FLIP) live in a virtual environment of the tests' own.
if [ ! -e build/venv/.complete ]; then
  echo "== independent programs into build/venv"
  if python3 -m venv build/venv >>"$log" 2>&1 && build/venv/bin/pip install -q -r tests/reference/requirements.txt >>"$log" 2>&1; then
    touch build/venv/.complete
  else
    echo "skipped: the independent programs could not be installed (see $log); the tests against them do not run"
    rm -rf build/venv
  fi
fi

build release && suite release
build sanitize && suite sanitize
if build fuzz; then
  echo "== fuzzing, 10 s each"
  for fuzzer in build/fuzz/tests/fuzz_*; do
    [ -x "$fuzzer" ] && [ -f "$fuzzer" ] || continue
    name=$(basename "$fuzzer")
    corpus=$(mktemp -d)
    cp tests/fuzz/corpus/"$name"/* "$corpus"/
    if "$fuzzer" -max_total_time=10 -timeout=10 -rss_limit_mb=4096 -malloc_limit_mb=2048 "$corpus" >build/"$name".log 2>&1; then
      echo "$name: $(grep -oE 'Done [0-9]+ runs' build/"$name".log)"
      passed=$((passed + 1))
    else
      tail -n 30 build/"$name".log
      failed=$((failed + 1))
    fi
    rm -rf "$corpus"
  done
fi

echo "$passed passed, $failed failed"
[ "$failed" = 0 ] && [ "$passed" -gt 0 ]
